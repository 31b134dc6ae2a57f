#include "simulation/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scene/outputs.hpp"
#include "simulation/random_sign.hpp"

namespace assur {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Five probes all below 1/5 of the true size happen once in ten thousand times; rounding is half as large as its bound.
constexpr double kSafety = 2.5;
constexpr double kRounding = 16 * kEps;       // residuals up to here are not looked at
constexpr std::int64_t kInterval = 512;       // steps from one measurement to the next
constexpr std::int64_t kIntervalUnseen = 16;  // where callbacks hide how the condition changes
constexpr double kGrown = 2;                  // of a condition, or a residual: then it is measured again
constexpr double kMoved = 1e-7;               // of a posture along a probe, internal units

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

double ErrorEstimate::Figures::worst() const { return std::max({position, velocity, acceleration}); }

ErrorEstimate::ErrorEstimate(const System& system, const Layout& layout, const OutputProgram& outputs, double asked)
    : outputs_(outputs), asked_(asked), size_(layout.size), first_unknown_(layout.first_unknown) {
  for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
    if (system.coordinates[c].role == Role::driven && system.coordinates[c].moving) {
      driven_.push_back(static_cast<std::int32_t>(c));
    }
  }
  for (const Output& o : wanted_outputs(system)) {
    const auto first = static_cast<std::int32_t>(3 * unit_.size());
    for (std::int32_t d = 0; d < 3; ++d) {
      if (o.wanted[d]) size_of_.insert(size_of_.end(), o.part_count, first + d);
    }
    unit_.push_back(system.unit(o.parts().front().dimension));
  }
  for (auto& probe : probes_) {
    for (auto& derivative : probe) derivative.resize(size_);
  }
  for (auto& derivative : moved_) derivative.resize(size_);
  moved_row_.resize(size_of_.size());
  sizes_.resize(3 * unit_.size());
  std::size_t blocks = 0;
  bool quadratic = true;
  for (const Pack& pack : layout.packs) {
    blocks += pack.omega.size();
    quadratic = quadratic && layout.solvers[idx(pack.group_class)]->quadratic();
  }
  omega_.reserve(blocks);
  regular_.resize(layout.packs.size());
  interval_ = quadratic ? kInterval : kIntervalUnseen;
  restart();
}

void ErrorEstimate::restart() {
  scale_ = {1, 0, 0};
  largest_.assign(sizes_.size(), {});
  residual_ = kRounding;
  steps_ = branch_checks_ = 0;
  seed_ = 0;
  now_ = {};
  expected_ = 0;
  in_doubt_ = true;
}

// Errors of accelerations grow like the cube of a condition, and those of levels multiply.
bool ErrorEstimate::due(std::span<const Pack> packs, std::int64_t branch_checks, double residual) {
  ++steps_;
  if (residual > kGrown * residual_) {
    residual_ = residual;
    return true;
  }
  // The start is solved with care; the first step is the first of its kind.
  const bool first = seed_ < 2 * kProbes;
  if (in_doubt_ || first || steps_ >= interval_) return true;
  // Where errors are let grow, conditions are watched between their measurements, too.
  if (branch_checks == branch_checks_ && expected_ == 0) return false;
  branch_checks_ = branch_checks;
  const double* before = omega_.data();
  // What a ball leaves open counts for one level: that all of them move towards a singularity at once is not expected.
  double grown = 1, open = 1;
  for (std::size_t p = 0; p < packs.size();) {
    double of_level = 1;
    for (const std::int32_t level = packs[p].level; p < packs.size() && packs[p].level == level; ++p) {
      for (const double omega : packs[p].omega) of_level = std::max(of_level, omega / *before++);
      for (const double used : packs[p].ball_used) open = std::max(open, 1 / (1 - used));
    }
    if (of_level > kGrown && expected_ == 0) return true;
    grown *= of_level;
  }
  if (expected_ > 0) grown *= open;
  return std::max(now_.worst(), expected_) * grown * grown * grown > asked_;
}

void ErrorEstimate::begin(double t, const double* const (&state)[3]) {
  steps_ = 0;
  for (const std::int32_t a : driven_) {
    for (std::size_t d = 1; d < 3; ++d) scale_[d] = std::max(scale_[d], std::abs(state[d][a]));
  }
  scale_[2] = std::max(scale_[2], scale_[1] * scale_[1]);
  for (std::size_t k = 0; k < kProbes; ++k) perturb_known(t, state, k);
}

// Laws are exact but for the rounding of their arguments, which grow with the time.
void ErrorEstimate::perturb_known(double t, const double* const (&state)[3], std::size_t probe) {
  RandomSign sign(++seed_);
  auto& [q, rate, acceleration] = probes_[probe];
  const double fastest = std::max(scale_[1], std::sqrt(scale_[2]));
  for (const std::int32_t a : driven_) {
    const double at = std::abs(t), v = std::abs(state[1][a]), w = std::abs(state[2][a]);
    q[idx(a)] = sign() * 2 * kEps * (std::abs(state[0][a]) + v * at);
    rate[idx(a)] = sign() * 2 * kEps * (v + w * at);
    acceleration[idx(a)] = sign() * 2 * kEps * (w + w * fastest * at);
  }
}

void ErrorEstimate::measure(double t, const double* const (&state)[3], std::span<Pack> packs, Levels& levels,
                            std::span<const double> row) {
  begin(t, state);
  Probes probes;
  for (std::size_t k = 0; k < kProbes; ++k) {
    for (std::size_t d = 0; d < 3; ++d) probes[k][d] = probes_[k][d].data();
  }
  levels.each([&](std::size_t p, GroupSolver& solver) {
    regular_[p] = solver.perturb(packs[p], state, probes, seed_) ? 1 : 0;
  });
  find_worst(packs, levels);
  omega_.clear();
  for (const Pack& pack : packs) omega_.insert(omega_.end(), pack.omega.begin(), pack.omega.end());
  finish(state, row, std::find(regular_.begin(), regular_.end(), 0) == regular_.end());
}

void ErrorEstimate::find_worst(std::span<const Pack> packs, Levels& levels) {
  double worst = -1;
  for (std::size_t p = 0; p < packs.size(); ++p) {
    const Pack& pack = packs[p];
    const GroupSolver& solver = levels.solver(pack);
    const std::size_t w = idx(solver.lanes()), n = idx(solver.program().n);
    for (const auto& probe : probes_) {
      for (std::size_t i = 0; i < n * w; ++i) {
        const double error = regular_[p] != 0 ? std::abs(probe[0][pack.unknowns + i]) : kInfinity;
        if (error <= worst || static_cast<std::int32_t>(i % w) >= pack.used) continue;
        worst = error;
        worst_pack_ = p;
        worst_lane_ = static_cast<std::int32_t>(i % w);
      }
    }
  }
}

void ErrorEstimate::finish(const double* const (&state)[3], std::span<const double> row, bool regular) {
  std::fill(sizes_.begin(), sizes_.end(), Size{});
  for (std::size_t c = 0; c < row.size(); ++c) {
    double& value = sizes_[idx(size_of_[c])].value;
    value = std::max(value, std::abs(row[c]));
  }
  for (const auto& probe : probes_) {
    double largest = 0;
    for (const double d : probe[0]) largest = std::max(largest, std::abs(d));
    if (!regular || !std::isfinite(largest)) {
      for (Size& s : sizes_) s.error = kInfinity;
      break;
    }
    if (largest == 0) largest = kEps;
    // The outputs are smooth: a small move along the probe tells their derivatives.
    const double along = kMoved / largest;
    for (std::size_t d = 0; d < 3; ++d) {
      for (std::size_t i = 0; i < size_; ++i) moved_[d][i] = state[d][i] + along * probe[d][i];
    }
    const double* const moved[3] = {moved_[0].data(), moved_[1].data(), moved_[2].data()};
    outputs_.evaluate(moved, moved_row_.data(), row.data(), 0);
    for (std::size_t c = 0; c < row.size(); ++c) {
      double& error = sizes_[idx(size_of_[c])].error;
      const double difference = kSafety * std::abs(moved_row_[c] - row[c]) / along;
      if (!(difference <= error)) error = std::isnan(difference) ? kInfinity : difference;
    }
  }
  for (std::size_t i = 0; i < sizes_.size(); ++i) {
    largest_[i].error = std::max(largest_[i].error, sizes_[i].error);
    largest_[i].value = std::max(largest_[i].value, sizes_[i].value);
    sizes_[i].value = largest_[i].value;
  }
  now_ = relative(sizes_);
  in_doubt_ = now_.worst() > asked_;
}

ErrorEstimate::Figures ErrorEstimate::relative(const std::vector<Size>& sizes) const {
  constexpr double kTurn = 2 * std::numbers::pi;
  const std::array<double, 3> least = {1, scale_[1] / kTurn, scale_[2] / (kTurn * kTurn)};
  std::array<double, 3> worst{};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const std::size_t d = i % 3;
    if (sizes[i].error > 0)
      worst[d] = std::max(worst[d], sizes[i].error / std::max(sizes[i].value, least[d] * unit_[i / 3]));
  }
  return {worst[0], worst[1], worst[2]};
}

ErrorEstimate::Figures ErrorEstimate::of_run() const { return relative(largest_); }

double ErrorEstimate::of_coordinate(std::size_t address) const {
  double worst = 0;
  for (const auto& probe : probes_) worst = std::max(worst, std::abs(probe[0][address]));
  return kSafety * worst;
}

}  // namespace assur
