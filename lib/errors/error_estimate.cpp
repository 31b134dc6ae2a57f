#include "errors/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "equations/outputs.hpp"
#include "errors/law_rounding.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "outputs/random_sign.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {
// Factor of an estimate. In one of ten thousand cases all five probes are below 1/5 of the true error; rounding errors
// reach half of their bound.
constexpr double kSafety = 2.5;
constexpr double kUsual = kSumRounding;          // residuals up to this one are normal in any step
constexpr double kSolvedToRounding = 16 * kEps;  // equations with smaller residuals are solved as exactly as possible
// the same if callbacks hide changes of the condition, or while errors are in doubt; a choice
constexpr std::int64_t kIntervalUnseen = 16;
// A measurement takes the time of some ten steps, and a loose step saves a tenth to a half of its time (hexa, jansen).
constexpr std::int64_t kWorthLoosening = 64;
constexpr std::int64_t kMostPatience = 1 << 20;
constexpr double kCloser = 1.6;  // if the square of a divisor falls by this factor, its inverse cube doubles
// Growth of a rate or an acceleration of a driver that asks for a new measurement; a choice.
constexpr double kFaster = 4;
// A driver rests below this share of the rate that it reaches within a radian; a choice.
constexpr double kAtRest = 1e-4;
constexpr double kSlowerThan = 1.0 / 16;  // part of the fastest rate: slower drivers are not told apart; a choice

}  // namespace

double ErrorEstimate::Figures::worst() const { return std::max({position, velocity, acceleration}); }

ErrorEstimate::ErrorEstimate(const GroupedSystem& structure, Layout& layout, std::span<const OutputProgram> outputs,
                             double accuracy)
    : layout_(layout),
      static_(*structure.system, structure),
      outputs_(outputs),
      kernels_(pack_kernels(static_cast<int>(outputs.size()))),
      asked_(accuracy > 0 ? accuracy : kDoubtfulError),
      best_(accuracy > 0 ? kConverged : 0) {
  const System& system = *structure.system;
  for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
    const bool drives = system.coordinates[c].role == Role::driven && system.coordinates[c].moving;
    const bool is_copy = layout.address[c] != static_cast<std::int32_t>(c * outputs.size());
    if (drives && !is_copy) driven_.push_back(layout.address[c]);
  }
  for (const Output& o : wanted_outputs(system)) {
    const auto first = static_cast<std::int32_t>(3 * dimension_.size());
    for (std::int32_t d = 0; d < 3; ++d) {
      if (!o.wanted[d]) continue;
      size_of_.insert(size_of_.end(), o.part_count, first + d);
      wanted_[idx(d)] = true;
    }
    dimension_.push_back(o.parts().front().dimension);
    is_angle_.push_back(is_angle(o.parts().front().kind) ? 1 : 0);
  }
  probes_.push_back({Probe::Cause::left, {}});
  probes_.insert(probes_.end(), kRandom, {Probe::Cause::rounding, {}});
  if (accuracy > 0) probes_.insert(probes_.end(), kRandom, {Probe::Cause::tolerance, {}});
  for (std::size_t d = 0; d < 3; ++d) {
    memory_[d].resize(probes_.size() * layout.size);
    for (std::size_t k = 0; k < probes_.size(); ++k) probes_[k].errors[d] = memory_[d].data() + k * layout.size;
  }
  slopes_.resize(size_of_.size() * outputs.size());
  mechanisms_.resize(outputs.size());
  for (Mechanism& m : mechanisms_) {
    m.sizes.resize(3 * dimension_.size());
    m.rounding.resize(m.sizes.size());
  }
  std::size_t blocks = 0;
  bool quadratic = true;
  for (const Pack& pack : layout.packs) {
    blocks += pack.omega.size();
    quadratic = quadratic && layout.solvers[idx(pack.group_class)]->group_class().quadratic();
  }
  systems_.reserve(mechanisms_.size());
  omega_.reserve(blocks);
  regular_.resize(layout.packs.size());
  interval_ = quadratic ? kStepsBetween : kIntervalUnseen;
}

void ErrorEstimate::restart(std::span<const System* const> systems, std::span<const Index> evaluated,
                            const Inputs* inputs) {
  used_ = systems.size();
  systems_.assign(systems.begin(), systems.end());
  evaluated_ = evaluated;
  inputs_ = inputs;
  std::size_t laws = 0;
  for (const Index i : evaluated) laws += systems.front()->inputs[idx(i)].laws.size();
  ahead_.assign(laws, {});
  static_known_ = static_.coordinates().empty();
  for (std::size_t i = 0; i < used_; ++i) {
    Mechanism& m = mechanisms_[i];
    m.unit.clear();
    for (std::size_t o = 0; o < dimension_.size(); ++o) {
      const bool is_like_last = o > 0 && dimension_[o] == dimension_[o - 1];
      m.unit.push_back(is_like_last ? m.unit.back() : systems[i]->unit(dimension_[o]));
    }
    m.scale = {1, 0, 0};
    m.largest.assign(m.sizes.size(), {});
    m.now = {};
    m.limit = asked_;
    m.laws.assign(laws, {});
    m.before = m.step = m.serves = m.redundant = 0;
  }
  const std::size_t w = mechanisms_.size(), divisors = outputs_[0].measures() * w;
  watched_.smallest.assign(divisors, kInfinity);
  watched_.least.assign(divisors, -kInfinity);
  watched_.most.assign(divisors, kInfinity);
  watched_.rate.assign(driven_.size() * w, kInfinity);
  watched_.acceleration = watched_.rate;
  for (std::size_t i = 0; i < watched_.rate.size(); ++i) {
    if (i % w < used_) watched_.rate[i] = watched_.acceleration[i] = 0;
  }
  residual_ = kUsual;
  steps_ = branch_checks_ = measurements_ = 0;
  seed_ = 0;
  worst_ = gain_ = left_ = 0;
  loose_ = false;
  exact_ = patience_ = 0;
}

bool ErrorEstimate::due(std::int64_t branch_checks, std::span<const double> times, const double* const (&state)[3],
                        double residual, const double* divisors) {
  ++steps_;
  const bool grown = residual > kGrownTwice * residual_;
  if (grown) residual_ = residual;
  // The start is solved more exactly than steps, so the first step is measured as well.
  const bool first = measurements_ < 2;
  // The residual of this step may be in any equation.
  const double error = residual > kSolvedToRounding ? gain_ * residual : 0;
  bool serve = serves(divisors);
  for (std::size_t i = 0; i < used_; ++i) {
    Mechanism& m = mechanisms_[i];
    if (times[i] != m.before) m.step = times[i] - std::exchange(m.before, times[i]);
    serve = serve && std::abs(times[i] - m.measured) <= m.serves;
  }
  if (grown || first || !serve || error > asked_ || is_faster(state) ||
      steps_ >= (in_doubt() ? kIntervalUnseen : interval_) || conditions_have_grown(branch_checks, error)) {
    return true;
  }
  if (error > 0) left_ = std::max(left_, residual);
  return false;
}

void ErrorEstimate::continue_from(ErrorEstimate& before) {
  before.keep_steps_between();
  for (std::size_t i = 0; i < used_; ++i) {
    mechanisms_[i].scale = before.mechanisms_[i].scale;
    mechanisms_[i].largest = before.mechanisms_[i].largest;
    mechanisms_[i].now = before.mechanisms_[i].now;
    mechanisms_[i].limit = before.mechanisms_[i].limit;
  }
  worst_ = before.worst_;
}

// The error of an acceleration grows by the cube of the growth of a condition. Groups rarely approach a singularity at
// the same time, so only the largest growth counts: among random chains of 2 to 37 four-bars that all end nearly in
// line, the product along each path through the groups found 34 of 30,320 measurements more, and changed neither a
// doubt nor the largest ratio of true to estimated error.
bool ErrorEstimate::conditions_have_grown(std::int64_t branch_checks, double error) {
  // If equations are solved loosely, conditions are also checked between branch checks.
  if (branch_checks == branch_checks_ && !loose_) return false;
  branch_checks_ = branch_checks;
  const double* before = omega_.data();
  // Inside its ball a condition may have changed unseen.
  double grown = 1, open = 1, shrunk = 1;
  for (const Pack& pack : layout_.packs) {
    for (const double omega : pack.omega) {
      grown = std::max(grown, omega / *before);
      shrunk = std::max(shrunk, *before++ / omega);
    }
    for (const double used : pack.ball_used) open = std::max(open, 1 / (1 - used));
  }
  if (grown > kGrownTwice && !loose_) return true;
  if (in_doubt()) return shrunk > kGrownTwice;
  if (loose_) grown *= open;
  return std::max(worst_, error) * grown * grown * grown > asked_;
}

void ErrorEstimate::begin(std::span<const double> times, const double* const (&state)[3]) {
  keep_steps_between();
  const bool has_paid = !loose_ || steps_ >= kWorthLoosening || measurements_ < 2;
  if (!has_paid) patience_ = std::min(2 * patience_ + 1, kMostPatience);
  exact_ = has_paid ? std::max<std::int64_t>(exact_ - 1, 0) : patience_;
  steps_ = 0;
  ++measurements_;
  for (std::size_t i = 0; i < used_; ++i) {
    Mechanism& m = mechanisms_[i];
    std::array<double, 3>& scale = m.scale;
    for (const std::int32_t a : driven_) {
      for (std::size_t d = 1; d < 3; ++d) scale[d] = std::max(scale[d], std::abs(state[d][idx(a) + i]));
    }
    scale[2] = std::max(scale[2], scale[1] * scale[1]);
    for (std::size_t k = 0; k < driven_.size(); ++k) {
      const auto raise = [&](std::vector<double>& fast, std::size_t d) {
        double& most = fast[k * mechanisms_.size() + i];
        const double now = std::abs(state[d][idx(driven_[k]) + i]);
        most = std::max({most, kFaster * now, kFaster * kSlowerThan * scale[d]});
      };
      raise(watched_.rate, 1);
      raise(watched_.acceleration, 2);
    }
  }
  for (std::size_t i = 0; i < used_; ++i) find_rounding_of_laws(i, times[i]);
  // If equations are solved as exactly as possible and errors are still too large, they will not be loosened.
  knows_gain_ = probes_.size() > 1 + kRandom && (loose_ || !in_doubt());
  for (const Probe& probe : probes()) {
    if (probe.cause == Probe::Cause::rounding) perturb_known(state, probe);
  }
  if (!static_known_) perturb_static(state[0]);
}

void ErrorEstimate::find_worst() {
  std::array<double, kMostLanes> worst{};
  worst.fill(-1);
  for (std::size_t p = 0; p < layout_.packs.size(); ++p) {
    const Pack& pack = layout_.packs[p];
    const GroupSolver& solver = *layout_.solvers[idx(pack.group_class)];
    const std::size_t w = idx(solver.lanes()), n = idx(solver.group_class().n);
    for (std::size_t i = 0; i < n * w; ++i) {
      const std::size_t lane = i % w, m = mechanisms_.size() > 1 ? lane : 0;
      const double error = regular_[p] != 0 ? of_coordinate(pack.unknowns + i) : kInfinity;
      if (lane >= idx(pack.used) || error <= worst[m]) continue;
      worst[m] = error;
      mechanisms_[m].worst = {p, static_cast<std::int32_t>(lane)};
    }
  }
}

void ErrorEstimate::finish(const double* const (&state)[3], std::span<const double* const> rows) {
  find_worst();
  omega_.clear();
  for (std::size_t p = 0; p < layout_.packs.size(); ++p) {
    const LaneArray& omega = layout_.packs[p].omega;
    // Beside a change point errors are larger than at the limit on it: any condition there has grown.
    const bool on_change_point = layout_.change_points[p].exists();
    for (const double now : omega) omega_.push_back(on_change_point ? 0 : now);
  }
  for (std::size_t i = 0; i < used_; ++i) {
    Mechanism& m = mechanisms_[i];
    std::fill(m.sizes.begin(), m.sizes.end(), Size{});
    std::fill(m.rounding.begin(), m.rounding.end(), 0.0);
    for (std::size_t c = 0; c < size_of_.size(); ++c) {
      double& value = m.sizes[idx(size_of_[c])].value;
      value = std::max(value, std::abs(rows[i][c]));
    }
  }
  const bool regular = std::find(regular_.begin(), regular_.end(), 0) == regular_.end();
  for (const Probe& probe : probes()) {
    if (regular) carry(probe, state);
  }
  worst_ = gain_ = 0;
  for (std::size_t k = 0; k < used_; ++k) {
    Mechanism& m = mechanisms_[k];
    for (std::size_t i = 0; i < m.sizes.size(); ++i) {
      Size& size = m.sizes[i];
      // The measurement serves until the residual has doubled.
      size.error = regular ? kSafety * (kGrownTwice * size.error + m.rounding[i]) : kInfinity;
      if (!regular) size.gain = kInfinity;
      size.value = m.largest[i].value = std::max(m.largest[i].value, size.value);
    }
    m.now = relative(m, m.sizes, &Size::error);
    worst_ = std::max(worst_, m.now.worst());
    gain_ = std::max(gain_, relative(m, m.sizes, &Size::gain).worst());
  }
}

// Steps between measurements may leave the largest residual in any equation. A larger one than solved equations have is
// the concern of the gain.
Unseen ErrorEstimate::of_other_steps() const {
  Unseen unseen;
  unseen.fill(std::min(residual_, kSolvedToRounding));
  return unseen;
}

// Adds the residuals of the redundant equations that errors of the posture do not explain. False: there are none.
bool ErrorEstimate::find_contradictions(Unseen& unseen) const {
  bool found = false;
  for (std::size_t i = 0; i < used_; ++i) {
    const Mechanism& m = mechanisms_[i];
    if (!(m.redundant > m.now.position)) continue;
    found = true;
    if (mechanisms_.size() > 1) {
      unseen[i] += kGrownTwice * m.redundant;
    } else {
      for (double& lane : unseen) lane += kGrownTwice * m.redundant;
    }
  }
  return found;
}

// Errors of the outputs by one probe. Probes of rounding include the rounding of the terms of measures.
void ErrorEstimate::carry(const Probe& probe, const double* const (&state)[3]) {
  const bool rounds = probe.cause == Probe::Cause::rounding;
  RandomSign sign(seed_ + static_cast<std::uint64_t>(&probe - probes_.data()));
  const double* const along[3] = {probe.errors[0], probe.errors[1], probe.errors[2]};
  if (output_steps_ != nullptr) {
    output_steps_->differentiate(state, along, rounds ? &sign : nullptr, slopes_.data());
  } else {
    outputs_[0].differentiate(state, along, rounds ? &sign : nullptr, slopes_.data());
  }
  for (std::size_t k = 0; k < used_; ++k) {
    Mechanism& m = mechanisms_[k];
    for (std::size_t c = 0; c < size_of_.size(); ++c) {
      const std::size_t i = idx(size_of_[c]);
      double& size = probe.cause == Probe::Cause::left ? m.sizes[i].error : rounds ? m.rounding[i] : m.sizes[i].gain;
      double slope = std::abs(slopes_[c * mechanisms_.size() + k]);
      if (probe.cause == Probe::Cause::tolerance) slope *= kSafety / kSumRounding;
      if (!(slope <= size)) size = std::isnan(slope) ? kInfinity : slope;
    }
  }
}

void ErrorEstimate::keep() {
  for (std::size_t k = 0; k < used_; ++k) {
    Mechanism& m = mechanisms_[k];
    for (std::size_t i = 0; i < m.sizes.size(); ++i) {
      m.largest[i].error = std::max(m.largest[i].error, m.sizes[i].error);
    }
    m.limit = in_doubt(k) ? asked_ / kGrownTwice : asked_;
  }
}

// The error of an acceleration grows like the inverse cube of the length by which it is divided. The error is measured
// again if a divisor becomes clearly smaller than any before, or if its change may change the verdict.
void ErrorEstimate::watch_divisors(std::size_t mechanism, const double* divisors) {
  const double room = std::cbrt(std::pow(asked_ / mechanisms_[mechanism].now.worst(), 2));
  for (std::size_t i = mechanism; i < watched_.smallest.size(); i += mechanisms_.size()) {
    watched_.smallest[i] = std::min(watched_.smallest[i], divisors[i]);
    watched_.least[i] = std::max(watched_.smallest[i] / kCloser, divisors[i] / std::max(room, kCloser));
    watched_.most[i] = in_doubt() ? divisors[i] * kCloser : kInfinity;
  }
}

bool ErrorEstimate::serves(const double* divisors) const {
  const auto rows = static_cast<std::int32_t>(watched_.least.size() / mechanisms_.size());
  return kernels_.between(divisors, rows, watched_.least.data(), watched_.most.data());
}

// A measurement at rest, or at low speed, underestimates the errors of velocities and accelerations.
bool ErrorEstimate::is_faster(const double* const (&state)[3]) const {
  if (!wanted_[1] && !wanted_[2]) return false;
  const auto rows = static_cast<std::int32_t>(driven_.size());
  return !(kernels_.at_most(state[1], driven_.data(), rows, watched_.rate.data()) &&
           kernels_.at_most(state[2], driven_.data(), rows, watched_.acceleration.data()));
}

// For steps without a measurement, takes the largest error that their residual allows.
void ErrorEstimate::keep_steps_between() {
  const double left = std::exchange(left_, 0);
  for (std::size_t k = 0; k < used_ && left > 0; ++k) {
    Mechanism& m = mechanisms_[k];
    for (std::size_t i = 0; i < m.sizes.size(); ++i) {
      m.largest[i].error = std::max(m.largest[i].error, m.sizes[i].gain * left);
    }
  }
}

ErrorEstimate::Figures ErrorEstimate::relative(const Mechanism& m, const std::vector<Size>& sizes,
                                               double Size::*what) const {
  // A driver that stops for a moment has a rate that is only rounding.
  const double fastest = std::max(m.scale[1], kAtRest * std::sqrt(m.scale[2]));
  const std::array<double, 3> least = {1, fastest / kTurn, m.scale[2] / (kTurn * kTurn)};
  std::array<double, 3> worst{};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (!(sizes[i].*what > 0)) continue;
    const std::size_t d = i % 3;
    double size = std::max(sizes[i].value, least[d] * m.unit[i / 3]);
    // The direction that turns has an acceleration at least as large as the square of the rate.
    if (d == 2 && is_angle_[i / 3] != 0) size = std::max(size, sizes[i - 1].value * sizes[i - 1].value);
    worst[d] = std::max(worst[d], sizes[i].*what / size);
  }
  return {worst[0], worst[1], worst[2]};
}

ErrorFigures ErrorEstimate::of_run(std::size_t mechanism) {
  if (!measured()) return {};
  keep_steps_between();
  const Mechanism& m = mechanisms_[mechanism];
  const auto [position, velocity, acceleration] = relative(m, m.largest, &Size::error);
  ErrorFigures figures;
  if (wanted_[0]) figures.estimated_position = position;
  if (wanted_[1]) figures.estimated_velocity = velocity;
  if (wanted_[2]) figures.estimated_acceleration = acceleration;
  return figures;
}

double ErrorEstimate::of_coordinate(std::size_t address) const {
  double left = 0, rounding = 0;
  for (const Probe& probe : probes_) {
    const double error = std::abs(probe.errors[0][address]);
    if (probe.cause == Probe::Cause::left) left = error;
    if (probe.cause == Probe::Cause::rounding) rounding = std::max(rounding, error);
  }
  return kSafety * (left + rounding);
}

void ErrorEstimate::save(Snapshot& into) const {
  into.mechanisms = mechanisms_;
  into.watched = watched_;
  into.omega.reserve(omega_.capacity());
  into.omega = omega_;
  into.residual = residual_;
  into.worst = worst_;
  into.gain = gain_;
  into.left = left_;
  into.knows_gain = knows_gain_;
  into.loose = loose_;
  into.exact = exact_;
  into.patience = patience_;
  into.branch_checks = branch_checks_;
  into.steps = steps_;
  into.interval = interval_;
  into.measurements = measurements_;
  into.seed = seed_;
}

void ErrorEstimate::restore(const Snapshot& from, std::int64_t branch_checks) {
  mechanisms_ = from.mechanisms;
  watched_ = from.watched;
  omega_ = from.omega;
  residual_ = from.residual;
  worst_ = from.worst;
  gain_ = from.gain;
  left_ = from.left;
  knows_gain_ = from.knows_gain;
  loose_ = from.loose;
  exact_ = from.exact;
  patience_ = from.patience;
  branch_checks_ = from.branch_checks + branch_checks;
  steps_ = from.steps;
  interval_ = from.interval;
  measurements_ = from.measurements;
  seed_ = from.seed;
}

void record_doubt(std::vector<Event>& events, Event event) {
  if (events.empty() || events.back().kind != event.kind || events.back().until != event.time) {
    events.push_back(std::move(event));
    return;
  }
  Event& before = events.back();
  before.until = event.until;
  if (before.detail.empty()) before.detail = std::move(event.detail);
  if (before.figure < event.figure) {
    before.figure = event.figure;
    before.group = std::move(event.group);
  }
}

}  // namespace assur
