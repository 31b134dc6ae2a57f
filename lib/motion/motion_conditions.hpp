// The conditions of one mechanism in motion besides its groups: levers that must not vanish, redundant equations and
// the choice among them, limits, and angles whose turns are counted. Continuation has one mechanism, Tile
// one in each lane.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "assur/report.hpp"
#include "drivers/inputs.hpp"
#include "equations/residual_scale.hpp"
#include "groups/attempt.hpp"
#include "motion/bows.hpp"
#include "motion/independence.hpp"
#include "motion/layout.hpp"
#include "motion/limit_watch.hpp"
#include "motion/watch.hpp"
#include "outputs/angle_turns.hpp"

namespace assur {

class MotionConditions {
 public:
  using Posture = LimitWatch::Posture;  // [d]: d-th derivatives of the coordinates, by address

  // lane: postures begin at this lane. All arguments must outlive it.
  MotionConditions(const GroupedSystem& structure, const Layout& layout, std::size_t lane = 0)
      : structure_(structure), layout_(layout), lane_(lane) {}

  // The mechanism has the numbers of this system from now on, which must outlive it. chooses: another set of its
  // redundant equations may be chosen.
  void bind(const System& system, bool chooses);
  // Marks the addresses that the checks read.
  void mark(std::vector<std::uint8_t>& addresses) const;
  // Adds signed angles, besides those of limits, that follow the postures; they must outlive this object.
  void follow(AngleTurns& turns) {
    if (!turns.empty()) turns_.push_back(&turns);
  }
  // The evaluated inputs of the system, whose levers are checked.
  void check_inputs(std::span<const Index> inputs);

  // A motion begins. Then begin() at its first posture.
  void clear();
  void begin(Posture q);
  // Measures how far everything may leave its way within a step (Bows). scratch: memory of the size of the state.
  void measure(Posture q, const Bows& bows, std::span<double> scratch);

  // ---- levers

  // Levers that are inputs, and those that are unknowns.
  enum class Levers : std::uint8_t { known, unknown };
  [[nodiscard]] bool has(Levers which) const { return known_levers_ != (which == Levers::known ? 0 : levers_.size()); }
  // Beyond zero, a driver's equations would hold half a turn away from its law. branch_unknown: a lever may vanish
  // unseen on the way; actuator_zero: one vanishes. The place is the driver. seconds: time of the way, 0: only `to` is
  // examined; times: factor of the bows, or 0.
  [[nodiscard]] Status check_levers(Levers which, Posture from, Posture to, double seconds, double times) const;
  // The first lever at q that is not larger than this part of its value at the begin; null: there is none.
  [[nodiscard]] const Lever* little_lever(const double* q, double part) const;

  // ---- redundant equations

  [[nodiscard]] bool watches() const { return watch_.has_value(); }
  [[nodiscard]] Watch& watch() { return *watch_; }
  // Largest relative residual of the redundant equations; 0 if there are none.
  [[nodiscard]] double contradiction(const double* q) { return watch_ ? watch_->residual(q) : 0; }
  // Largest coefficient when the redundant equations are written as combinations of the solved ones. branch_checks:
  // number of anchors; the coefficient is computed once for each anchor.
  [[nodiscard]] double largest_coefficient(const double* q, std::int64_t branch_checks);
  // The redundant equations that a new choice checks at a posture, all coordinates, in ascending order; empty: unknown
  [[nodiscard]] std::vector<std::int32_t> checks_chosen_anew(std::span<const double> coordinates) const;
  // True if another set of the redundant equations would be better.
  [[nodiscard]] bool set_is_poor(const double* q, std::int64_t branch_checks) {
    return !(largest_coefficient(q, branch_checks) <= poor_);
  }
  // False at a fold of all equations: there no other choice is better, and choosing takes memory and time.
  [[nodiscard]] bool another_set_may_help(const double* q) {
    return !independence_ || !(independence_->largest_coefficient(q) <= poor_);
  }
  // No better set was found: set_is_poor() is false until the set is twice as poor.
  void keep_set() { poor_ = std::max(poor_, 2 * largest_coefficient_); }

  // ---- angles and limits

  // False if accept() and follow_angles() do nothing.
  [[nodiscard]] bool is_followed() const { return limits_ != nullptr || !turns_.empty(); }
  // Examines the turns to another posture, see AngleTurns::follow().
  [[nodiscard]] AngleTurns::Turned follow_angles(const double* q, double seconds, double times);
  // Accepts the posture that was examined last. passes: limits are checked later.
  void accept(double seconds, bool passes = false);
  [[nodiscard]] LimitWatch* limits() { return limits_.get(); }  // null: there are none
  [[nodiscard]] const LimitWatch* limits() const { return limits_.get(); }
  // The limited quantities, as Preparation::start_limits.
  [[nodiscard]] std::vector<double> limited() const { return limits_ ? limits_->values() : std::vector<double>(); }
  // Begins to watch limits at a posture. known: see LimitWatch::start(). Returns the bounds that are violated where the
  // motion begins, none if it began before.
  [[nodiscard]] std::vector<LimitWatch::Change> begin_limits(Posture q, double time, std::span<const double> known);

  // ---- state

  // Begins a step: remembers the state that the step changes before it is accepted, for save(in_step).
  void begin_step() { level_at_begin_ = level_; }
  struct Snapshot {
    std::vector<Lever> levers;
    double level = 0, poor = 0, largest_coefficient = 0;
    std::int64_t since_measured = -1;  // branch checks since that coefficient was computed; -1: it was not
    std::vector<AngleTurns::Snapshot> turns;
    LimitWatch::Snapshot limits;
  };
  void save(Snapshot& into, bool in_step, std::int64_t branch_checks) const;
  void restore(const Snapshot& from, double time, std::int64_t branch_checks);

 private:
  template <class Correct>
  friend Status check_watched(std::span<MotionConditions> all, const double* q, double left, bool may_correct,
                              const Correct& correct, Counters& counters, StepErrors& errors, std::size_t& worst);
  void evaluate_watched(const double* q, Counters& counters) {
    counters.evaluated_equations += static_cast<std::int64_t>(watch_->equations());
    residual_ = watch_->residual(q);
  }
  template <class Do>
  void each_turns(const Do& with) const {
    for (AngleTurns* const turns : turns_) with(*turns);
    if (limits_ && !limits_->turns().empty()) with(limits_->turns());
  }

  const GroupedSystem& structure_;
  const Layout& layout_;
  std::size_t lane_;
  const System* system_ = nullptr;
  std::vector<Lever> levers_;  // known ones first
  std::size_t known_levers_ = 0;
  std::optional<Watch> watch_;
  double residual_ = 0;                         // of the watched equations, the last one
  double level_ = 0, level_at_begin_ = 0;       // smallest relative residual that they can reach
  std::unique_ptr<Independence> independence_;  // null: no other set can be chosen
  double largest_coefficient_ = 0, poor_ = kPoorSet;
  std::int64_t measured_at_ = -1;  // branch check of that coefficient
  std::unique_ptr<LimitWatch> limits_;
  std::vector<AngleTurns*> turns_;  // besides the angles of limits
};

// Checks the redundant equations of mechanisms that are solved together, mechanism i at q + i, where the solved
// equations hold to the relative residual `left`. Residuals of redundant equations below `left` prove nothing, so
// correct() may bring all equations to the rounding level by one more correction. worst: receives the mechanism with
// the largest residual.
template <class Correct>
[[nodiscard]] Status check_watched(std::span<MotionConditions> all, const double* q, double left, bool may_correct,
                                   const Correct& correct, Counters& counters, StepErrors& errors, std::size_t& worst) {
  const auto evaluate = [&] {
    for (std::size_t i = 0; i < all.size(); ++i) all[i].evaluate_watched(q + i, counters);
  };
  evaluate();
  const auto is_left = [&](const MotionConditions& m) { return m.residual_ > std::max(left, 2 * m.level_); };
  if (may_correct && std::any_of(all.begin(), all.end(), is_left)) {
    if (const Status s = correct(); !s.ok()) return s;
    evaluate();
    for (MotionConditions& m : all) m.level_ = m.residual_ > left ? m.residual_ : 0;
  }
  worst = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (!(all[i].residual_ <= all[worst].residual_)) worst = i;
  }
  const double largest = all[worst].residual_;
  if (!(largest <= std::max(kConsistent, left))) return {Code::inconsistent, {}, largest};
  errors.position = std::max(errors.position, largest);
  return {};
}

}  // namespace assur
