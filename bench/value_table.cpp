// Ensembles whose members are rows of a table: the time to bind and assemble a member, beside preparing it, the
// throughput of a Stewart platform with 24 random parameters beside equal platforms, and that of four-bars of which
// many jam or cannot be assembled. Members are compared with prepared ones. The exit status is 1 if one of them
// deviates by more than 1e-10 of the largest value of its column.
//
//   value_table_bench [MEMBERS [ROUNDS [STRATEGY]]]    10000 members, 5 rounds and auto unless told otherwise
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "machine.hpp"
#include "median.hpp"
#include "tables/value_table.hpp"

namespace assur::bench {
namespace {

constexpr std::size_t kCompared = 200;
constexpr double kTolerance = 1e-10;

double wall() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct Design {
  Scene scene;
  std::vector<std::string> names;
  std::vector<double> middle;
  double spread;  // of each value

  [[nodiscard]] std::vector<double> table(std::size_t members) const {
    std::mt19937_64 random(20261126);
    std::vector<double> values;
    for (std::size_t i = 0; i < members; ++i) {
      for (const double v : middle) {
        const double share = static_cast<double>(random() >> 11) * 0x1p-52 - 1;
        values.push_back(v + spread * share * std::max(std::abs(v), 0.1));
      }
    }
    return values;
  }
  [[nodiscard]] Parameters row(const std::vector<double>& values, std::size_t i) const {
    Parameters of_row;
    for (std::size_t k = 0; k < names.size(); ++k) of_row[names[k]] = values[i * names.size() + k];
    return of_row;
  }
};

std::string strategy = "auto";

PrepareOptions how(int threads) {
  return {.strategy = strategy, .budget = ThreadBudget{threads}, .mode = Mode::throughput};
}

// Seconds for all members of a table: bound, and assembled.
struct Bound {
  double binding = 0, assembling = 0;
  std::size_t members = 0;  // that were bound and assembled
};

Bound bind_all(const ValueTable& table, Tile& tile, MemberBinder& binder) {
  const auto lanes = static_cast<std::size_t>(tile.lanes());
  std::vector<std::size_t> members(lanes);
  std::vector<const Variant*> variants(lanes);
  Bound out;
  for (std::size_t first = 0; first + lanes <= table.count(); first += lanes) {
    for (std::size_t l = 0; l < lanes; ++l) members[l] = first + l;
    const double begin = wall();
    binder.bind(members, variants);
    const double bound = wall();
    if (std::count(variants.begin(), variants.end(), nullptr) == 0 && tile.start(variants).ok()) {
      for (std::size_t l = 0; l < lanes; ++l) {
        out.members += binder.is_start(*variants[l], tile.posture(static_cast<int>(l))) ? 1 : 0;
      }
    }
    out.binding += bound - begin;
    out.assembling += wall() - bound;
  }
  return out;
}

double prepare_some(const Design& design, const Prepared& first, const std::vector<double>& values) {
  const double begin = wall();
  for (std::size_t i = 0; i < kCompared; ++i) {
    (void)prepare_like(first, design.scene.with_values(design.row(values, i)), how(1));
  }
  return (wall() - begin) / kCompared;
}

// Largest deviation of the first members from prepared ones, relative to the largest value of the column.
double deviation(const Design& design, std::vector<double> values) {
  values.resize(kCompared * design.names.size());
  Ensemble bound(design.scene, design.names, values, how(1));
  const Prepared first = bound.prepared();
  Ensemble each(kCompared, [&](std::size_t i) {
    return prepare_like(first, design.scene.with_values(design.row(values, i)), how(1));
  });
  const EnsembleTrajectory a = bound.run(), b = each.run();
  double worst = 0;
  for (std::size_t i = 0; i < kCompared; ++i) {
    if (a.rows(i) != b.rows(i)) return HUGE_VAL;
    for (std::size_t c = 0; c < a.columns().size(); ++c) {
      double size = 0, off = 0;
      for (std::size_t k = 0; k < a.rows(i); ++k) {
        size = std::max(size, std::abs(b(i, k, c)));
        off = std::max(off, std::abs(a(i, k, c) - b(i, k, c)));
      }
      // Rounding of the other columns remains in a column that is zero.
      worst = std::max(worst, off / std::max(size, 1.0));
    }
  }
  return worst;
}

bool report(const Design& design, std::size_t members, int rounds) {
  const std::vector<double> values = design.table(members);
  const ValueTable table(design.scene, design.names, values, how(1), AtRest::in_front);
  if (!table.why_not().empty()) {
    std::printf("%s: %s\n", design.scene.name().c_str(), table.why_not().c_str());
    return false;
  }
  Preparation first = *table.first();
  first.plan.run.chunks = first.plan.run.threads = 1;
  Tile tile(first, {});
  tile.keep_pivots({first.structure->system, first.structure->start, first.time.start, first.reselect});
  const auto binder = table.binder(static_cast<std::size_t>(tile.lanes()));
  std::vector<double> binding, assembling, preparing;
  std::size_t bound = 0;
  for (int r = 0; r < rounds; ++r) {
    const Bound b = bind_all(table, tile, *binder);
    bound = b.members;
    binding.push_back(1e6 * b.binding / static_cast<double>(members));
    assembling.push_back(1e6 * b.assembling / static_cast<double>(members));
    preparing.push_back(1e6 * prepare_some(design, Preparation::shared(first), values));
  }
  const double worst = deviation(design, values);
  std::printf("| %s, %zu values | %d | %.2f | %.2f | %.0f | %.1f %% | %.1e |\n", design.scene.name().c_str(),
              design.names.size(), tile.lanes(), median(binding), median(assembling), median(preparing),
              100.0 * static_cast<double>(bound) / static_cast<double>(members), worst);
  return worst <= kTolerance;
}

// Steps per second of all members together; the figures of handle angles are kept.
double throughput(Ensemble& ensemble, const std::vector<std::string>& columns) {
  const double begin = wall();
  (void)ensemble.summarize(columns);
  const double steps =
      static_cast<double>(ensemble.members()) * static_cast<double>(ensemble.prepared().time().steps());
  return steps / (wall() - begin);
}

void compare_throughput(const Design& platform, std::size_t members, int rounds) {
  constexpr std::size_t kEqual = 1024;
  const std::vector<std::string> columns = {"handle1", "handle2", "handle3", "handle4", "handle5", "handle6"};
  Ensemble random(platform.scene, platform.names, platform.table(members), how(2));
  const Prepared first = random.prepared();
  Ensemble equal(kEqual, [&](std::size_t) { return first; });
  std::vector<double> of_random, of_equal, ratio;
  for (int r = 0; r < rounds; ++r) {
    of_equal.push_back(throughput(equal, columns));
    of_random.push_back(throughput(random, columns));
    ratio.push_back(of_random.back() / of_equal.back());
  }
  std::printf(
      "\n%zu platforms with %zu random values, %lld steps each, ranges of handle angles, two threads: %.3g steps/s\n",
      members, platform.names.size(), static_cast<long long>(first.time().steps()), median(of_random));
  std::printf("%zu equal platforms: %.3g steps/s; ratio %.3f (%.3f to %.3f)\n", kEqual, median(of_equal), median(ratio),
              *std::min_element(ratio.begin(), ratio.end()), *std::max_element(ratio.begin(), ratio.end()));
  for (const std::string& text : random.report().fallbacks) std::printf("  %s\n", text.c_str());
}

// Time for a member of a wide design space beside that of a narrow one, in which all members turn.
void compare_with_jams(const Design& narrow, const Design& wide, std::size_t members, int rounds) {
  std::vector<Ensemble> ensembles;
  for (const Design* d : {&narrow, &wide}) ensembles.emplace_back(d->scene, d->names, d->table(members), how(2));
  std::vector<double> times[2], ratio;
  for (int r = 0; r < rounds; ++r) {
    for (std::size_t e = 0; e < 2; ++e) {
      const double begin = wall();
      (void)ensembles[e].summarize(ensembles[e].columns());
      times[e].push_back(1e6 * (wall() - begin) / static_cast<double>(members));
    }
    ratio.push_back(times[1].back() / times[0].back());
  }
  std::size_t done = 0, jammed = 0, alone = 0;
  for (const Ensemble::Outcome& o : ensembles[1].outcomes()) {
    done += o.status.arrived();
    jammed += !o.status.arrived() && o.cannot.empty();
    alone += o.alone && o.status.arrived();
  }
  std::printf("\n%zu members of %s, %lld steps each, two threads: %.2f us each; in a wide design space %.2f us\n",
              members, wide.scene.name().c_str(), static_cast<long long>(ensembles[0].prepared().time().steps()),
              median(times[0]), median(times[1]));
  std::printf(
      "(%zu turn, %zu of them alone from some time on, %zu jam, %zu cannot be assembled); ratio %.2f (%.2f to %.2f)\n",
      done, alone, jammed, members - done - jammed, median(ratio), *std::min_element(ratio.begin(), ratio.end()),
      *std::max_element(ratio.begin(), ratio.end()));
}

// 18 coordinates of the joints of the base and 6 of those of the terminal.
Design stewart() {
  const std::vector<std::string> handles = {"handle1", "handle2", "handle3", "handle4", "handle5", "handle6"};
  Design d{sample("stewart").with_outputs(handles), {}, {}, 0.02};
  const auto add = [&](const std::string& name, std::size_t k, const Triple& at) {
    d.names.push_back(name + "." + "xyz"[k]);
    d.middle.push_back(at[k]);
  };
  for (const Point& p : d.scene.points()) {
    for (std::size_t k = 0; p.fixed && p.name[0] == 'A' && k < 3; ++k) add(p.name, k, p.at);
  }
  for (const Body& body : d.scene.bodies()) {
    for (const Member& m : body.points) add(m.name, 0, m.local);
  }
  return d;
}

int run(std::size_t members, int rounds) {
  describe_machine(std::cout);
  std::cout << std::endl;
  std::printf(
      "| mechanism | W | bind, us | assemble, us | prepare, us | bound | deviation |\n|---|---|---|---|---|---|---|\n");
  const std::string scenes = std::string(ASSUR_SOURCE_DIR) + "/scenes/";
  const Design four_bar{read_scene(scenes + "four_bar.json").with_outputs({"rocker_angle"}),
                        {"crank_length", "coupler_length", "rocker_length"},
                        {0.8, 1.8, 1.3},
                        0.02};
  const Design slider_crank{
      sample("slider_crank").with_outputs({"displacement"}), {"crank_length", "rod_length"}, {0.1, 0.3}, 0.1};
  const Design of_file{read_scene(scenes + "stewart.json").with_outputs({"handle1"}),
                       {"handle", "rod", "base_radius", "toe"},
                       {0.2, 0.55, 0.5, 0.2},
                       0.02};
  const Design all_outputs{read_scene(scenes + "stewart.json").with_outputs({"all"}), of_file.names, of_file.middle,
                           0.02};
  const Design platform = stewart();
  bool good = true;
  for (const Design* d : {&four_bar, &slider_crank, &of_file, &all_outputs, &platform})
    good = report(*d, members, rounds) && good;
  compare_throughput(platform, members, rounds);
  Design wide = four_bar;
  wide.spread = 0.5;
  const double deviates = deviation(wide, wide.table(kCompared));
  std::printf("\ndeviation in the wide design space: %.1e\n", deviates);
  good = deviates <= kTolerance && good;
  compare_with_jams(four_bar, wide, members, rounds);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace assur::bench

int main(int count, char** arguments) {
  if (count > 3) assur::bench::strategy = arguments[3];
  const std::size_t members = count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 10'000;
  return assur::bench::run(std::max<std::size_t>(members, 200), count > 2 ? std::atoi(arguments[2]) : 5);
}
