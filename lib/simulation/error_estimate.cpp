#include "simulation/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "scene/outputs.hpp"
#include "simulation/random_sign.hpp"
#include "simulation/tolerances.hpp"

namespace assur {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Five probes all below 1/5 of the true size happen once in ten thousand times; rounding is half as large as its bound.
constexpr double kSafety = 2.5;
constexpr double kRounding = 16 * kEps;       // residuals up to here are not looked at
constexpr std::int64_t kInterval = 512;       // steps from one measurement to the next
constexpr std::int64_t kIntervalUnseen = 16;  // where callbacks hide how the condition changes, or errors are in doubt
constexpr double kGrown = 2;                  // of a condition, or a residual: then it is measured again
constexpr double kMoved = 1e-7;               // of a posture along a probe, internal units

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

double ErrorEstimate::Figures::worst() const { return std::max({position, velocity, acceleration}); }

ErrorEstimate::ErrorEstimate(const Structure& structure, Layout& layout, std::span<const OutputProgram> outputs,
                             double accuracy)
    : layout_(layout),
      static_(*structure.system, structure),
      outputs_(outputs),
      asked_(accuracy > 0 ? accuracy : kDoubtfulError) {
  const System& system = *structure.system;
  for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
    const bool drives = system.coordinates[c].role == Role::driven && system.coordinates[c].moving;
    if (drives && layout.address[c] >= 0) driven_.push_back(layout.address[c]);
  }
  for (const Output& o : wanted_outputs(system)) {
    const auto first = static_cast<std::int32_t>(3 * dimension_.size());
    for (std::int32_t d = 0; d < 3; ++d) {
      if (o.wanted[d]) size_of_.insert(size_of_.end(), o.part_count, first + d);
    }
    dimension_.push_back(o.parts().front().dimension);
  }
  for (auto& probe : probes_) {
    for (auto& derivative : probe) derivative.resize(layout.size);
  }
  for (auto& derivative : moved_) derivative.resize(layout.size);
  moved_row_.resize(size_of_.size());
  mechanisms_.resize(outputs.size());
  for (Mechanism& m : mechanisms_) m.sizes.resize(3 * dimension_.size());
  std::size_t blocks = 0;
  bool quadratic = true;
  for (const Pack& pack : layout.packs) {
    blocks += pack.omega.size();
    quadratic = quadratic && layout.solvers[idx(pack.group_class)]->quadratic();
  }
  systems_.reserve(mechanisms_.size());
  omega_.reserve(blocks);
  regular_.resize(layout.packs.size());
  interval_ = quadratic ? kInterval : kIntervalUnseen;
}

void ErrorEstimate::restart(std::span<const System* const> systems) {
  used_ = systems.size();
  systems_.assign(systems.begin(), systems.end());
  static_known_ = static_.coordinates().empty();
  for (std::size_t i = 0; i < used_; ++i) {
    Mechanism& m = mechanisms_[i];
    m.unit.clear();
    for (const int dimension : dimension_) m.unit.push_back(systems[i]->unit(dimension));
    m.scale = {1, 0, 0};
    m.largest.assign(m.sizes.size(), {});
    m.now = {};
  }
  residual_ = kRounding;
  steps_ = branch_checks_ = 0;
  seed_ = 0;
  worst_ = expected_ = 0;
}

void ErrorEstimate::continue_from(const ErrorEstimate& before) {
  for (std::size_t i = 0; i < used_; ++i) {
    mechanisms_[i].scale = before.mechanisms_[i].scale;
    mechanisms_[i].largest = before.mechanisms_[i].largest;
    mechanisms_[i].now = before.mechanisms_[i].now;
  }
  worst_ = before.worst_;
}

// Errors of accelerations grow like the cube of a condition, and those of levels multiply.
bool ErrorEstimate::due(std::int64_t branch_checks, double residual) {
  ++steps_;
  if (residual > kGrown * residual_) {
    residual_ = residual;
    return true;
  }
  // The start is solved with care; the first step is the first of its kind.
  const bool first = seed_ < 2 * kProbes;
  if (first || steps_ >= (in_doubt() ? kIntervalUnseen : interval_)) return true;
  // Where errors are let grow, conditions are watched between their measurements, too.
  if (branch_checks == branch_checks_ && expected_ == 0) return false;
  branch_checks_ = branch_checks;
  const double* before = omega_.data();
  // What a ball leaves open counts for one level: that all of them move towards a singularity at once is not expected.
  double grown = 1, open = 1, shrunk = 1;
  const std::vector<Pack>& packs = layout_.packs;
  for (std::size_t p = 0; p < packs.size();) {
    double of_level = 1;
    for (const std::int32_t level = packs[p].level; p < packs.size() && packs[p].level == level; ++p) {
      for (const double omega : packs[p].omega) {
        of_level = std::max(of_level, omega / *before);
        shrunk = std::max(shrunk, *before++ / omega);
      }
      for (const double used : packs[p].ball_used) open = std::max(open, 1 / (1 - used));
    }
    if (of_level > kGrown && expected_ == 0) return true;
    grown *= of_level;
  }
  if (in_doubt()) return shrunk > kGrown;
  if (expected_ > 0) grown *= open;
  return std::max(worst_, expected_) * grown * grown * grown > asked_;
}

Probes ErrorEstimate::begin(std::span<const double> times, const double* const (&state)[3]) {
  steps_ = 0;
  for (std::size_t i = 0; i < used_; ++i) {
    auto& scale = mechanisms_[i].scale;
    for (const std::int32_t a : driven_) {
      for (std::size_t d = 1; d < 3; ++d) scale[d] = std::max(scale[d], std::abs(state[d][idx(a) + i]));
    }
    scale[2] = std::max(scale[2], scale[1] * scale[1]);
  }
  if (!static_known_) perturb_static(state[0]);
  Probes probes;
  for (std::size_t k = 0; k < kProbes; ++k) {
    perturb_known(times, state, k);
    for (std::size_t d = 0; d < 3; ++d) probes[k][d] = probes_[k][d].data();
  }
  return probes;
}

void ErrorEstimate::perturb_static(const double* state) {
  const std::span<const std::int32_t> stands = static_.coordinates();
  std::vector<double> q(systems_.empty() ? 0 : systems_[0]->coordinates.size());
  for (std::size_t i = 0; i < used_; ++i) {
    for (std::size_t c = 0; c < q.size(); ++c) {
      const std::int32_t a = layout_.address[c];
      q[c] = a >= 0 ? state[idx(a) + i] : 0;
    }
    const std::vector<double> errors = static_.draw(*systems_[i], q, kProbes, 0);
    for (std::size_t k = 0; k < kProbes; ++k) {
      for (std::size_t s = 0; s < stands.size(); ++s) {
        probes_[k][0][idx(layout_.address[idx(stands[s])]) + i] = errors[k * stands.size() + s];
      }
    }
  }
  static_known_ = true;
}

// Laws are exact but for the rounding of their arguments, which grow with the time.
void ErrorEstimate::perturb_known(std::span<const double> times, const double* const (&state)[3], std::size_t probe) {
  RandomSign sign(++seed_);
  auto& [q, rate, acceleration] = probes_[probe];
  for (std::size_t i = 0; i < used_; ++i) {
    const auto& scale = mechanisms_[i].scale;
    const double at = std::abs(times[i]), fastest = std::max(scale[1], std::sqrt(scale[2]));
    for (const std::int32_t address : driven_) {
      const std::size_t a = idx(address) + i;
      const double v = std::abs(state[1][a]), w = std::abs(state[2][a]);
      q[a] = sign() * 2 * kEps * (std::abs(state[0][a]) + v * at);
      rate[a] = sign() * 2 * kEps * (v + w * at);
      acceleration[a] = sign() * 2 * kEps * (w + w * fastest * at);
    }
  }
}

void ErrorEstimate::find_worst() {
  std::array<double, kMostLanes> worst{};
  worst.fill(-1);
  for (std::size_t p = 0; p < layout_.packs.size(); ++p) {
    const Pack& pack = layout_.packs[p];
    const GroupSolver& solver = *layout_.solvers[idx(pack.group_class)];
    const std::size_t w = idx(solver.lanes()), n = idx(solver.program().n);
    for (const auto& probe : probes_) {
      for (std::size_t i = 0; i < n * w; ++i) {
        const std::size_t lane = i % w, m = mechanisms_.size() > 1 ? lane : 0;
        const double error = regular_[p] != 0 ? std::abs(probe[0][pack.unknowns + i]) : kInfinity;
        if (lane >= idx(pack.used) || error <= worst[m]) continue;
        worst[m] = error;
        mechanisms_[m].worst = {p, static_cast<std::int32_t>(lane)};
      }
    }
  }
}

void ErrorEstimate::finish(const double* const (&state)[3], std::span<const double* const> rows) {
  find_worst();
  omega_.clear();
  for (const Pack& pack : layout_.packs) omega_.insert(omega_.end(), pack.omega.begin(), pack.omega.end());
  const bool regular = std::find(regular_.begin(), regular_.end(), 0) == regular_.end();
  for (std::size_t i = 0; i < used_; ++i) {
    std::vector<Size>& sizes = mechanisms_[i].sizes;
    std::fill(sizes.begin(), sizes.end(), Size{});
    for (std::size_t c = 0; c < size_of_.size(); ++c) {
      double& value = sizes[idx(size_of_[c])].value;
      value = std::max(value, std::abs(rows[i][c]));
    }
  }
  for (const auto& probe : probes_) {
    double largest = 0;
    for (const double d : probe[0]) largest = std::max(largest, std::abs(d));
    if (!regular || !std::isfinite(largest)) {
      for (Mechanism& m : mechanisms_) {
        for (Size& s : m.sizes) s.error = kInfinity;
      }
      break;
    }
    if (largest == 0) largest = kEps;
    // The outputs are smooth: a small move along the probe tells their derivatives.
    const double along = kMoved / largest;
    for (std::size_t d = 0; d < 3; ++d) {
      for (std::size_t i = 0; i < layout_.size; ++i) moved_[d][i] = state[d][i] + along * probe[d][i];
    }
    for (std::size_t i = 0; i < used_; ++i) {
      const double* const moved[3] = {moved_[0].data() + i, moved_[1].data() + i, moved_[2].data() + i};
      outputs_[i].evaluate(moved, moved_row_.data(), rows[i], 0);
      for (std::size_t c = 0; c < moved_row_.size(); ++c) {
        double& error = mechanisms_[i].sizes[idx(size_of_[c])].error;
        const double difference = kSafety * std::abs(moved_row_[c] - rows[i][c]) / along;
        if (!(difference <= error)) error = std::isnan(difference) ? kInfinity : difference;
      }
    }
  }
  worst_ = 0;
  for (std::size_t k = 0; k < used_; ++k) {
    Mechanism& m = mechanisms_[k];
    for (std::size_t i = 0; i < m.sizes.size(); ++i) {
      m.largest[i].error = std::max(m.largest[i].error, m.sizes[i].error);
      m.largest[i].value = std::max(m.largest[i].value, m.sizes[i].value);
      m.sizes[i].value = m.largest[i].value;
    }
    m.now = relative(m, m.sizes);
    worst_ = std::max(worst_, m.now.worst());
  }
}

ErrorEstimate::Figures ErrorEstimate::relative(const Mechanism& m, const std::vector<Size>& sizes) const {
  constexpr double kTurn = 2 * std::numbers::pi;
  const std::array<double, 3> least = {1, m.scale[1] / kTurn, m.scale[2] / (kTurn * kTurn)};
  std::array<double, 3> worst{};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (!(sizes[i].error > 0)) continue;
    const std::size_t d = i % 3;
    worst[d] = std::max(worst[d], sizes[i].error / std::max(sizes[i].value, least[d] * m.unit[i / 3]));
  }
  return {worst[0], worst[1], worst[2]};
}

ErrorEstimate::Figures ErrorEstimate::of_run(std::size_t mechanism) const {
  return relative(mechanisms_[mechanism], mechanisms_[mechanism].largest);
}

double ErrorEstimate::of_coordinate(std::size_t address) const {
  double worst = 0;
  for (const auto& probe : probes_) worst = std::max(worst, std::abs(probe[0][address]));
  return kSafety * worst;
}

void record_doubt(std::vector<Event>& events, Event event) {
  if (events.empty() || events.back().kind != event.kind || events.back().until != event.time) {
    events.push_back(std::move(event));
    return;
  }
  Event& before = events.back();
  before.until = event.until;
  if (before.figure < event.figure) {
    before.figure = event.figure;
    before.group = std::move(event.group);
  }
}

}  // namespace assur
