// A fleet of random linkages (5 to 20 joints, 200 times of one turn) against the plain closed form of the same
// linkages, which checks nothing. Every rate is in dyads that were solved, at times before the linkage jams; those
// beyond are work for nothing, which the plain form does. 1,000 linkages are also run by the simulator, step by step.
// The exit status is 1 if one of them ends otherwise or deviates by more than 100 times its estimated error.
//
//   fleet_bench [LINKAGES [ROUNDS]]    100000 linkages and 5 rounds unless told otherwise
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "assur/assur.hpp"
#include "fleet/linkage.hpp"
#include "fleet/linkages.hpp"
#include "machine.hpp"
#include "median.hpp"
#include "numbers.hpp"
#include "outputs/angle_kernels.hpp"
#include "sweep/random_linkage.hpp"

namespace assur::bench {
namespace {

constexpr std::size_t kRows = 200;
constexpr std::uint64_t kSeed = 20261125;

void linkage_into(std::size_t i, Linkage& to) { sweep::random_linkage(kSeed, i, {5, 20}, to); }

double wall() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// What many would write: dyad after dyad, for all times.
class PlainForm {
 public:
  explicit PlainForm(const std::vector<double>& times) : times_(times) {}

  // The last joint.
  const double* solve(const Linkage& linkage) {
    const std::size_t n = times_.size();
    x_.resize(linkage.joints.size() * n);
    y_.resize(linkage.joints.size() * n);
    for (std::size_t j = 0; j < linkage.joints.size(); ++j) {
      const LinkageJoint& joint = linkage.joints[j];
      double *x = x_.data() + j * n, *y = y_.data() + j * n;
      const double *ax = x_.data() + joint.first * n, *ay = y_.data() + joint.first * n;
      const auto& v = joint.value;
      if (joint.kind == LinkageJoint::Kind::ground) {
        std::fill_n(x, n, v[0]);
        std::fill_n(y, n, v[1]);
      } else if (joint.kind == LinkageJoint::Kind::crank) {
        angles_.resize(n);
        for (std::size_t k = 0; k < n; ++k) angles_[k] = v[1] + v[2] * times_[k];
        angle_kernels().sin_cos(angles_.data(), n, y, x);
        for (std::size_t k = 0; k < n; ++k) {
          x[k] = ax[k] + v[0] * x[k];
          y[k] = ay[k] + v[0] * y[k];
        }
      } else {
        meet(n, ax, ay, x_.data() + joint.second * n, y_.data() + joint.second * n, v[0], v[1], joint.left ? 1 : -1, x,
             y);
      }
    }
    return x_.data() + (linkage.joints.size() - 1) * n;
  }

 private:
  __attribute__((target_clones("avx512f", "avx2", "default"))) static void meet(std::size_t n, const double* ax,
                                                                                const double* ay, const double* bx,
                                                                                const double* by, double a, double b,
                                                                                double side, double* __restrict x,
                                                                                double* __restrict y) {
    const double squares = (a - b) * (a + b);
    for (std::size_t k = 0; k < n; ++k) {
      const double dx = bx[k] - ax[k], dy = by[k] - ay[k], inverse = 1 / (dx * dx + dy * dy);
      const double u = 0.5 + 0.5 * squares * inverse, w = side * __builtin_sqrt(a * a * inverse - u * u);
      x[k] = ax[k] + u * dx - w * dy;
      y[k] = ay[k] + u * dy + w * dx;
    }
  }

  const std::vector<double>& times_;
  std::vector<double> x_, y_, angles_;
};

// A way to move linkages, and its times.
struct Contender {
  std::string name;
  std::function<void()> run;
  std::vector<double> seconds;
};

void race(std::vector<Contender>& contenders, int rounds) {
  for (int round = 0; round <= rounds; ++round) {
    for (Contender& c : contenders) {
      const double begin = wall();
      c.run();
      if (round > 0) c.seconds.push_back(wall() - begin);
    }
  }
}

void print(const Contender& c, double dyads) {
  std::printf("  %-46s %8.3f s (%.3f to %.3f)  %9.2e dyads/s\n", c.name.c_str(), median(c.seconds),
              *std::min_element(c.seconds.begin(), c.seconds.end()),
              *std::max_element(c.seconds.begin(), c.seconds.end()), dyads / median(c.seconds));
}

// Compares with the simulator. Returns the number of linkages that differ.
int verify(const Fleet& fleet, const std::vector<double>& times, std::size_t count) {
  const TimeGrid grid{0, static_cast<double>(kRows - 1) / kRows, 1.0 / kRows};
  int wrong = 0, jammed = 0;
  double largest_jam = 0, largest_ratio = 0, largest_deviation = 0;
  const auto sink = [&](std::size_t i, const LinkageMotion& motion) {
    Linkage linkage;
    linkage_into(i, linkage);
    PrepareOptions how;
    how.strategy = "groups/lanes";
    Simulator simulator(prepare(scene_of(linkage, grid), how));
    const Trajectory t = simulator.run(times);
    const Report& report = simulator.report();
    double deviation = 0, size = 0;
    const std::size_t column = t.columns().size() - 2;
    for (std::size_t k = 0; k < std::min(t.rows(), motion.path.size()); ++k) {
      for (std::size_t c = 0; c < 2; ++c) {
        deviation = std::max(deviation, std::abs(motion.path[k][c] - t(k, column + c)));
        size = std::max(size, std::abs(t(k, column + c)));
      }
    }
    const double estimated = motion.error + report.error.estimated_position.value_or(0);
    const double jam = motion.status.arrived() ? 0 : std::abs(motion.reached - report.reached);
    const bool alike = motion.status.code == report.status.code && motion.path.size() == t.rows();
    wrong += alike && deviation <= 100 * estimated * size ? 0 : 1;
    jammed += motion.status.arrived() ? 0 : 1;
    largest_jam = std::max(largest_jam, jam);
    largest_deviation = std::max(largest_deviation, deviation / size);
    largest_ratio = std::max(largest_ratio, deviation / (size * estimated));
  };
  (void)fleet.stream(sink, times, {.last = count});
  std::printf(
      "  %zu against the simulator: %d differ; positions by %.1e at most, %.1f estimated errors; %d jam, times by "
      "%.1e s at most\n",
      count, wrong, largest_deviation, largest_ratio, jammed, largest_jam);
  return wrong;
}

double megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

int run(std::size_t count, int rounds) {
  describe_machine(std::cout);
  std::vector<double> times;
  for (std::size_t k = 0; k < kRows; ++k) times.push_back(static_cast<double>(k) / kRows);
  const Fleet fleet(count, linkage_into);
  const auto drop = [](std::size_t, const LinkageMotion&) {};

  // Memory, while nothing is stored.
  (void)fleet.stream(drop, times, {.last = std::max<std::size_t>(count / 10, 1)});
  const double of_tenth = megabytes();
  FleetReport report = fleet.stream(drop, times);
  const double of_all = megabytes();
  std::printf("%zu linkages: %zu are done, %zu jam, %zu cannot be closed; largest residual %.1e\n", count, report.done,
              report.jammed, report.not_closed, report.residual);
  std::printf("  memory of the process: %.1f MB after a tenth of them, %.1f MB after all\n", of_tenth, of_all);
  const int wrong = verify(fleet, times, std::min<std::size_t>(count, 1000));

  std::vector<Linkage> all(count), complete;
  for (std::size_t i = 0; i < count; ++i) linkage_into(i, all[i]);
  const auto keep = [&](std::size_t i, const LinkageMotion& m) {
    if (m.status.arrived()) complete.push_back(all[i]);
  };
  (void)fleet.stream(keep, times);
  PreparedLinkage prepared;
  std::int64_t dyads_of_complete = 0;
  for (const Linkage& linkage : complete) {
    if (prepared.take(linkage).empty()) dyads_of_complete += prepared.dyads() * static_cast<std::int64_t>(kRows);
  }
  const Fleet stored(all), stored_complete(complete);
  // Linkages with a triad each.
  std::vector<Linkage> of_triads(count);
  for (std::size_t i = 0; i < count; ++i) of_triads[i] = test::with_triad(i);
  const Fleet triads(std::move(of_triads));
  const auto dyads_and_triads = static_cast<double>(triads.stream(drop, times).dyads);
  PlainForm plain(times);
  double sum = 0;
  FleetOptions two;
  two.threads = 2;
  const std::vector<Linkage>* const lists[] = {&all, &complete};
  const auto plainly = [&](std::size_t list) {
    return [&, list] {
      for (const Linkage& linkage : *lists[list]) {
        const double last = plain.solve(linkage)[kRows - 1];
        sum += std::isnan(last) ? 0 : last;
      }
    };
  };
  std::vector<Contender> contenders = {
      {"fleet, linkages made on the way", [&] { (void)fleet.stream(drop, times); }, {}},
      {"fleet, stored linkages", [&] { (void)stored.stream(drop, times); }, {}},
      {"fleet, stored linkages, two threads", [&] { (void)stored.stream(drop, times, two); }, {}},
      {"plain closed form", plainly(0), {}},
      {"fleet, those that are done", [&] { (void)stored_complete.stream(drop, times); }, {}},
      {"plain closed form, those that are done", plainly(1), {}},
      {"fleet, a dyad and a triad in each linkage", [&] { (void)triads.stream(drop, times); }, {}},
      {"making linkages",
       [&] {
         for (std::size_t i = 0; i < count; ++i) linkage_into(i, all[i]);
       },
       {}},
      {"checking and preparing linkages",
       [&] {
         for (const Linkage& l : all) (void)prepared.take(l);
       },
       {}},
  };
  race(contenders, rounds);
  const auto dyads = static_cast<double>(report.dyads), of_complete = static_cast<double>(dyads_of_complete);
  for (std::size_t i = 0; i < 4; ++i) print(contenders[i], dyads);
  for (std::size_t i = 4; i < 6; ++i) print(contenders[i], of_complete);
  print(contenders[6], dyads_and_triads);
  for (std::size_t i = 7; i < 9; ++i) {
    std::printf("  %-46s %8.0f ns for each\n", contenders[i].name.c_str(),
                1e9 * median(contenders[i].seconds) / static_cast<double>(count));
  }
  std::printf("  %lld intervals were divided; the plain form is %.2f times as fast on those that are done (sum %.3g)\n",
              static_cast<long long>(report.divided), median(contenders[4].seconds) / median(contenders[5].seconds),
              sum);
  return wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace assur::bench

int main(int count, char** arguments) {
  const long linkages = count > 1 ? std::atol(arguments[1]) : 100000, rounds = count > 2 ? std::atol(arguments[2]) : 5;
  return assur::bench::run(static_cast<std::size_t>(std::max(linkages, 1L)), static_cast<int>(std::max(rounds, 1L)));
}
