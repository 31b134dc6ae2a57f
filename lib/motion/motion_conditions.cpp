#include "motion/motion_conditions.hpp"

#include "index.hpp"

namespace assur {

void MotionConditions::bind(const System& system, bool chooses) {
  system_ = &system;
  watch_.reset();
  independence_.reset();
  largest_coefficient_ = 0;
  limits_.reset();
  if (!structure_.watch_class.equations.empty()) {
    watch_.emplace(system, structure_, layout_.address);
    if (chooses) independence_ = std::make_unique<Independence>(system, structure_, layout_.address);
    if (independence_ && independence_->empty()) independence_.reset();
  }
  if (!system.bounds.empty()) limits_ = std::make_unique<LimitWatch>(system, layout_.address);
}

void MotionConditions::mark(std::vector<std::uint8_t>& addresses) const {
  if (limits_) limits_->mark(addresses);
  for (const std::int32_t c : structure_.watch.inputs) addresses[idx(layout_.address[idx(c)])] = 1;
}

void MotionConditions::check_inputs(std::span<const Index> inputs) {
  levers_.clear();
  for (const Index i : inputs) {
    const DriverInput& in = system_->inputs[idx(i)];
    if (in.must_not_vanish) levers_.push_back({layout_.address[idx(in.first)], in.driver});
  }
  known_levers_ = levers_.size();
  for (const Positive& p : system_->positive) {
    const std::int32_t address = layout_.address[idx(p.coordinate)];
    if (address >= 0 && system_->coordinates[idx(p.coordinate)].role == Role::unknown) {
      levers_.push_back({address, p.driver});
    }
  }
}

void MotionConditions::clear() {
  for (Lever& l : levers_) l.bow = 0;
  level_ = 0;
  poor_ = kPoorSet;
  measured_at_ = -1;
}

void MotionConditions::begin(Posture q) {
  each_turns([&](AngleTurns& turns) { turns.start(q[0]); });
  for (Lever& l : levers_) l.start = q[0][l.address];
}

void MotionConditions::measure(Posture q, const Bows& bows, std::span<double> scratch) {
  each_turns([&](AngleTurns& turns) { turns.measure(q[0], bows.probes(), scratch, lane_); });
  for (Lever& l : levers_) l.bow = bows.sizes()[idx(l.address) + lane_];
  if (!limits_) return;
  std::fill(scratch.begin(), scratch.end(), 0.0);
  limits_->measure(q, bows.probes(), scratch.data(), lane_);
}

Status MotionConditions::check_levers(Levers which, Posture from, Posture to, double seconds, double times) const {
  const auto levers =
      which == Levers::known ? std::span(levers_).first(known_levers_) : std::span(levers_).subspan(known_levers_);
  const Lever* l = seconds == 0 ? nullptr : may_vanish(levers, from[0], to[0], times);
  if (l != nullptr) return {Code::branch_unknown, Place::driver(l->driver), seconds};
  l = vanished(levers, from, to, seconds);
  if (l == nullptr) return {};
  return {Code::actuator_zero, Place::driver(l->driver), std::min(to[0][l->address], 0.0)};
}

const Lever* MotionConditions::little_lever(const double* q, double part) const {
  const auto is_little = [&](const Lever& l) { return !(q[l.address] > part * l.start); };
  const auto found = std::find_if(levers_.begin(), levers_.end(), is_little);
  return found == levers_.end() ? nullptr : &*found;
}

// Within the ball of an anchor the inverse of the Jacobian grows at most by the factor 1 / (1 - kBall), and with it the
// coefficients, unless a row vanishes. So each anchor is checked.
double MotionConditions::largest_coefficient(const double* q, std::int64_t branch_checks) {
  if (independence_ && measured_at_ != branch_checks) {
    measured_at_ = branch_checks;
    largest_coefficient_ = independence_->largest_coefficient(q);
  }
  return largest_coefficient_;
}

std::vector<std::int32_t> MotionConditions::checks_chosen_anew(std::span<const double> coordinates) const {
  if (!independence_) return {};
  std::vector<std::int32_t> checks = independence_->chosen_anew(coordinates);
  if (checks.empty()) return {};
  const std::vector<std::int32_t>& watched = structure_.watch.equations;
  for (const std::int32_t e : structure_.checks) {
    if (std::find(watched.begin(), watched.end(), e) == watched.end()) checks.push_back(e);
  }
  std::sort(checks.begin(), checks.end());
  return checks;
}

AngleTurns::Turned MotionConditions::follow_angles(const double* q, double seconds, double times) {
  AngleTurns::Turned turned = AngleTurns::Turned::known;
  each_turns([&](AngleTurns& turns) {
    const AngleTurns::Turned of_these = turns.follow(q, seconds, times);
    if (turned != AngleTurns::Turned::unknown && of_these != AngleTurns::Turned::known) turned = of_these;
  });
  return turned;
}

void MotionConditions::accept(double seconds, bool passes) {
  each_turns([&](AngleTurns& turns) { turns.accept(seconds); });
  if (limits_ && !passes) limits_->accept();
}

std::vector<LimitWatch::Change> MotionConditions::begin_limits(Posture q, double time, std::span<const double> known) {
  std::vector<LimitWatch::Change> outside;
  if (!limits_) return outside;
  limits_->start(q, time, known);
  if (!known.empty()) return outside;
  for (const std::size_t bound : limits_->violated()) outside.push_back({bound, true, time, time});
  return outside;
}

void MotionConditions::save(Snapshot& into, bool in_step, std::int64_t branch_checks) const {
  into.levers = levers_;
  into.level = in_step ? level_at_begin_ : level_;
  into.poor = poor_;
  into.largest_coefficient = largest_coefficient_;
  into.since_measured = measured_at_ < 0 ? -1 : branch_checks - measured_at_;
  std::size_t count = 0;
  each_turns([&](AngleTurns&) { ++count; });
  into.turns.resize(count);
  count = 0;
  each_turns([&](AngleTurns& turns) { turns.save(into.turns[count++]); });
  if (limits_) limits_->save(into.limits);
}

void MotionConditions::restore(const Snapshot& from, double time, std::int64_t branch_checks) {
  levers_ = from.levers;
  level_ = from.level;
  poor_ = from.poor;
  largest_coefficient_ = from.largest_coefficient;
  measured_at_ = from.since_measured < 0 ? -1 : branch_checks - from.since_measured;
  std::size_t count = 0;
  each_turns([&](AngleTurns& turns) { turns.restore(from.turns[count++]); });
  if (limits_) limits_->restore(from.limits, time);
}

}  // namespace assur
