// From posture to posture along the branch at hand: a step that may leave it, or that Newton's method does not solve,
// is halved; change points are passed; at a limit the last good posture is kept.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/simulator.hpp"
#include "group/step_rules.hpp"
#include "numbers.hpp"
#include "path/independence.hpp"
#include "path/layout.hpp"
#include "path/levels.hpp"
#include "path/state.hpp"
#include "path/watch.hpp"
#include "signals/angle_turns.hpp"
#include "signals/inputs.hpp"

namespace assur {

// The length of the steps that are tried: halved where one fails, `growth` times as long after `patience` that arrived.
struct Stride {
  double length = kInfinity;
  int patience = 1;
  double growth = 2;
  int arrived = 0;

  void set(double to) {
    length = to;
    arrived = 0;
  }
  void arrive() {
    if (++arrived == patience) set(growth * length);
  }
};

class Continuation {
 public:
  // All three must outlive it; counters, errors and events are added to the report.
  // Throws Error (environment) if a backend of the plan cannot run here.
  Continuation(const Prepared& prepared, const StepLimits& limits, Report& report);

  // Signed angles that follow the postures from start() on; it must outlive this.
  void follow(AngleTurns& turns) { turns_ = turns.empty() ? nullptr : &turns; }

  // Drivers behind nothing that is computed, or marked (by address), are left out.
  void keep_what_is_read(std::vector<std::uint8_t> marked);

  // From a posture (all coordinates) at a time. Throws Error (numerical) if it is none, or has no velocities.
  // before: what was set to another one, with other equations of the same scene, which stops here.
  void start(double time, const std::vector<double>& posture, const Inputs::Controls* before = nullptr);

  // All that the next steps depend on.
  struct Snapshot {
    State state;
    Inputs::Controls controls;
    std::vector<Kept> packs;
    StepErrors errors;
    double converged = kConverged;
    double time = 0;
    double selected_at = kNan;
    bool stands_still = false;
    double watched_level = 0, poor = 0;
    std::vector<Lever> levers;
    std::vector<double> angles;  // of the drivers
    AngleTurns::Snapshot turns;
  };
  // Takes no memory once `into` has been taken from the same plan. in_step: within a step, before it leaves the posture
  // where it began: then as it was before that step.
  void save(Snapshot& into, bool in_step) const;
  // Of earlier postures, with +reuse=run: a snapshot does not hold them.
  void drop_factors();
  [[nodiscard]] bool fits(const Snapshot& from) const;
  // With the same equations. Solvers keep their pivot orders.
  void restore(const Snapshot& from);
  // Instead of start(), before restore().
  void restart_solvers();
  // Is called, once in a step, at the posture where it began, before the step is divided or fails.
  void before_dividing(std::function<void()> call) { before_dividing_ = std::move(call); }
  // After restore() of a snapshot in a step: that step once more, with controlled drivers that stand still to begin
  // with. False if they did, or none is controlled.
  [[nodiscard]] bool ask_again_from_rest();

  // Attempts of a step that were rejected so far: after 10,000 the step fails, as branch_unknown. Its first
  // part begins with 0, others go on where those before them ended.
  [[nodiscard]] std::int64_t rejected() const { return rejected_; }
  void count_rejected_from(std::int64_t count) { rejected_ = count; }

  // What is not ok leaves the last good posture. May redundant equations be chosen anew, then wants_reselection() tells
  // that they should be. What a law or a callback throws comes from here, with the last good posture too.
  [[nodiscard]] Status step_to(double t, bool may_reselect, Stride& stride);
  [[nodiscard]] bool wants_reselection() const { return wants_reselection_; }
  // At the posture at hand another set of the redundant equations would be better than the one that is solved.
  [[nodiscard]] bool set_is_poor();
  // There is none that is: asks again once the set is twice as poor.
  void keep_set();

  // The posture at hand once more, and those of the next steps, until what is left counts as solved. False: it stays as
  // it was, because it cannot be, or the number of iterations is given.
  [[nodiscard]] bool polish(double converged);

  // The residual at which an equation counts as solved.
  [[nodiscard]] double converged() const { return converged_; }  // 0: as exact as doubles are
  void converge_to(double residual) { converged_ = residual; }

  [[nodiscard]] double time() const { return now_; }
  // All coordinates; what presolve eliminated, and follows from the others, as guessed.
  [[nodiscard]] std::vector<double> posture() const;
  // d-th derivative of the coordinates, by address.
  [[nodiscard]] const double* at(int d) const { return state_.at(d); }
  // In the last step an angle passed so close to where it has none that its direction is a guess.
  [[nodiscard]] bool turn_guessed() const { return turn_guessed_; }
  [[nodiscard]] const StepErrors& errors() const { return last_errors_; }

  [[nodiscard]] Layout& layout() { return layout_; }
  [[nodiscard]] std::span<Pack> packs() { return packs_; }
  [[nodiscard]] Levels& levels() { return levels_; }
  [[nodiscard]] Inputs& inputs() { return inputs_; }

 private:
  static constexpr int kStepHalvings = 20;  // a step is halved down to 2^-20, then it is asked why it fails
  static constexpr double kSmallestStep = 1.0 / (1 << kStepHalvings);
  static constexpr int kMostRejected = 10000;  // attempts of one step, whatever they were for

  void repeat_in_idle_lanes();
  void tell_before_dividing();
  [[nodiscard]] Status solve_at(double t, Attempt::Branch branch, StepErrors& errors);
  [[nodiscard]] Status solve_all(double t, Attempt::Branch branch, StepErrors& errors);
  // left: relative residual of what was solved.
  [[nodiscard]] Status check_watched(double t, Attempt::Branch branch, double left, StepErrors& errors);
  [[nodiscard]] Status solve_packs(double t, Attempt::Branch branch, double converged, StepErrors& errors);
  [[nodiscard]] Status check_levers(std::size_t begin, std::size_t end, double seconds);
  void tell(const Status& stopped, double target);
  void accept(double t, const StepErrors& errors);
  [[nodiscard]] bool deadline_passed() const;
  [[nodiscard]] Status check_aim(double t);
  [[nodiscard]] Status advance(double t, bool may_reselect, Stride& stride);
  void end_step(Inputs::End end);
  void predict(double target);
  void expand();
  [[nodiscard]] Status try_step(double target, Attempt::Branch branch);
  [[nodiscard]] Status turned_unseen(AngleTurns::Way way);
  [[nodiscard]] bool may_choose_anew(bool asked, double first) const;
  [[nodiscard]] Status at_the_limit(const Status& failed, double target, double t, double first);
  [[nodiscard]] bool turns_back(Singularity here);
  [[nodiscard]] double first_without_solution(double target, double t);
  [[nodiscard]] bool pass(double target, double t, double first);
  [[nodiscard]] bool is_avoided(double h, double first);
  [[nodiscard]] bool pass_by(double reach, double target, double t);
  [[nodiscard]] bool walk(double until, double h, double change);
  void record(Event event, double step);

  const Prepared& prepared_;
  const StepLimits& limits_;
  Report& report_;
  const Structure& structure_;
  const System& system_;
  Inputs inputs_;
  Layout layout_;
  std::vector<Pack>& packs_;
  Levels levels_;
  State state_;
  const State::Way* over_ = nullptr;  // while a change point is passed: predicts the step over it
  bool lacks_rates_ = false;          // of some unknowns, because they are not wanted
  bool expands_ = false;              // all rates are computed, and predict
  std::optional<Watch> watch_;
  double watched_level_ = 0;  // relative residual that the watched equations cannot be brought below
  std::optional<Independence> independence_;
  double largest_coefficient_ = 0, poor_ = kPoorSet;  // of the watched equations, and where it counts as poor
  std::int64_t measured_at_ = -1;                     // branch check of that coefficient
  double converged_ = kConverged;
  StepErrors last_errors_;             // of the last accepted posture
  std::vector<std::uint8_t> passing_;  // packs: on the way through a change point
  double now_ = 0;
  std::int64_t attempts_ = 0, rejected_ = 0;
  double last_before_pass_ = 0;
  AngleTurns* turns_ = nullptr;
  int together_;          // angles_together()
  bool any_turn_ = true;  // angles take the shorter way, however far they turn
  bool turn_guessed_ = false;
  double turned_ = 0;    // by the step that was tried, over what a step may turn
  double shortest_ = 0;  // attempt of this step so far, before it is asked why it fails
  // Postures of this step at which that was asked, those of one block each nearer to a singular one.
  std::vector<Singularity> approach_;
  double largest_correction_ = 0;  // of a step through a change point, over the move that was predicted
  std::function<void()> before_dividing_;
  bool divided_ = false;       // the step at hand, or it failed
  bool stands_still_ = false;  // from the posture at hand on, until something moves again
  bool wants_reselection_ = false;
  double selected_at_ = kNan;    // time of the last reselection that was tried
  std::size_t failed_pack_ = 0;  // of the last posture that was tried; their number: none
  std::vector<Lever> levers_;    // those that are known, then those that are solved for
  std::size_t known_levers_ = 0;
  bool vanished_ = false;  // one of them, in the last posture that was tried
  std::chrono::steady_clock::time_point deadline_;
};

}  // namespace assur
