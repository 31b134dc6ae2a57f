// Continuation: moves from posture to posture along the current branch. Halves a step that may leave the branch, or
// that Newton's method does not solve; passes change points; keeps the last good posture where a motion ends.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "assur/report.hpp"
#include "assur/step_settings.hpp"
#include "drivers/inputs.hpp"
#include "motion/approach.hpp"
#include "motion/bows.hpp"
#include "motion/event_log.hpp"
#include "motion/layout.hpp"
#include "motion/levels.hpp"
#include "motion/motion_conditions.hpp"
#include "motion/state.hpp"
#include "motion/stride.hpp"
#include "motion/together.hpp"
#include "motion/whole_step.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "program/step_rules.hpp"
#include "start/walk.hpp"

namespace assur {

// The motion of one mechanism.
class Continuation {
 public:
  // All arguments must outlive it. It adds counters and errors to the report.
  // Throws Error (environment) if a backend of the plan cannot run here.
  Continuation(const Preparation& prepared, const StepSettings& settings, Report& report, EventLog& events);

  // Signed angles that follow the postures from start() on; must outlive the continuation.
  void follow(AngleTurns& turns) { conditions_.follow(turns); }

  // Leaves out drivers that neither a computed unknown nor a marked coordinate (by address) depends on.
  void keep_what_is_read(std::vector<std::uint8_t> marked);

  // Begins at a posture (all coordinates) and time. Throws Error (numerical) if the equations do not hold there, or if
  // it has no velocities, or if it violates a limit that ends motions. before: the continuation that this one replaces;
  // it had other equations of the same scene.
  void start(double time, const std::vector<double>& posture, const Continuation* before = nullptr);

  // State that determines the next steps.
  struct Snapshot {
    State state;
    Inputs::Controls controls;
    std::vector<Kept> packs;
    StepErrors errors;
    double converged = kConverged;
    double time = 0;
    double selected_at = kNan;
    bool turn_guessed = false;
    MotionConditions::Snapshot conditions;
    std::vector<double> angles;  // of the drivers
    Bows::Measured bows;
    double change_point_at = kNan;
    std::vector<ChangePointPosture> change_points;
  };
  // Allocates no memory if `into` holds a snapshot of the same plan. in_step: the call comes within a step that has not
  // left its first posture; the snapshot is then the state before the step.
  void save(Snapshot& into, bool in_step) const;
  // Drops factors of earlier postures (+reuse=run), which a snapshot does not hold.
  void drop_factors();
  // True if the snapshot has the sizes of this continuation.
  [[nodiscard]] bool fits(const Snapshot& from) const;
  // Returns to a snapshot of the same equations. Solvers keep their pivot orders.
  void restore(const Snapshot& from);
  // Makes solvers ready for restore() without start().
  void restart_solvers();
  // `call` is called once in a step, at the posture where the step began, before the step is divided or fails.
  void before_dividing(std::function<void()> call) { before_dividing_ = std::move(call); }
  // After restore() of the begin of a step: prepares to repeat the step with controlled drivers that begin at rest.
  // False, with nothing changed, if they were at rest, or if no driver is controlled.
  [[nodiscard]] bool ask_again_from_rest();
  // After a step that failed: all drivers that were set stand still, and targets are dropped.
  void rest();

  using Clock = std::chrono::steady_clock::time_point (*)();
  // Begins a call, whose work shares one deadline (StepSettings::seconds).
  void start_clock() {
    if (settings_.seconds > 0) set_deadline();
  }
  void use_clock(Clock clock) { clock_ = clock; }
  // Continues the call of another continuation.
  void take_clock(const Continuation& other) {
    clock_ = other.clock_;
    deadline_ = other.deadline_;
  }
  [[nodiscard]] std::chrono::steady_clock::time_point now() const { return clock_(); }
  // False if work that takes so long would not end before the deadline.
  [[nodiscard]] bool has_time_for(std::chrono::steady_clock::duration work) const {
    return settings_.seconds <= 0 || work < deadline_ - clock_();
  }
  [[nodiscard]] bool deadline_passed() const { return settings_.seconds > 0 && clock_() > deadline_; }
  [[nodiscard]] Status late() const { return {Code::deadline, {}, settings_.seconds}; }

  // Later events may join earlier ones from this position on.
  [[nodiscard]] std::int64_t events_joined_from() const { return joined_from_; }
  void join_events_from(std::int64_t first) { joined_from_ = first; }
  // An event of this motion with its texts, also of a continuation that this one replaced.
  [[nodiscard]] Event in_words(const Noticed& event) const;

  // Rejected attempts at the current step. After 40,000 the step fails as branch_unknown. The first part of a step
  // begins to count at 0; further parts continue.
  [[nodiscard]] std::int64_t rejected() const { return rejected_; }
  void count_rejected_from(std::int64_t count) { rejected_ = count; }

  // Moves to time t. If the status is not ok, the last good posture on the way is kept. If reselection of redundant
  // equations is allowed, a step may stop and ask for it by wants_reselection(). Exceptions from laws and callbacks
  // propagate, and keep the last good posture as well.
  [[nodiscard]] Status step_to(double t, bool may_reselect, Stride& stride);
  [[nodiscard]] bool wants_reselection() const { return wants_reselection_; }
  // True if another set of the redundant equations would be better at the current posture than the set that is solved.
  [[nodiscard]] bool set_is_poor() { return conditions_.set_is_poor(state_.at(0), report_.counters.branch_checks); }
  // See MotionConditions.
  [[nodiscard]] std::vector<std::int32_t> checks_chosen_anew(std::span<const double> posture) const {
    return conditions_.checks_chosen_anew(posture);
  }
  // To be called if no better set was found: set_is_poor() is then false until the set is twice as poor.
  void keep_set() {
    conditions_.keep_set();
    selected_at_ = now_;
  }

  // Solves the current posture again, to this residual, and the next postures as well. False: the posture is unchanged,
  // because it cannot be solved so exactly, or because the number of iterations is prescribed.
  [[nodiscard]] bool polish(double converged);

  // Largest relative residual of the redundant equations at the current posture.
  [[nodiscard]] double contradiction() { return conditions_.contradiction(state_.at(0)); }
  // The residual at which an equation counts as solved.
  [[nodiscard]] double converged() const { return converged_; }  // 0: as exact as doubles allow
  void converge_to(double residual) { converged_ = residual; }

  [[nodiscard]] double time() const { return now_; }
  // All coordinates; those that presolve eliminated have the value of the guess.
  [[nodiscard]] std::vector<double> posture() const;
  // d-th derivative of the coordinates, by address.
  [[nodiscard]] const double* at(int d) const { return state_.at(d); }
  // True if an angle of the last step passed so close to a point without direction that its turn is a guess.
  [[nodiscard]] bool turn_guessed() const { return turn_guessed_; }
  // True if the current posture stands on a change point: no linear system there gives rates.
  [[nodiscard]] bool on_change_point() const { return now_ == change_point_at_; }
  [[nodiscard]] const StepErrors& errors() const { return last_errors_; }
  // The limited quantities, as in Preparation::start_limits.
  [[nodiscard]] std::vector<double> limited() const { return conditions_.limited(); }

  [[nodiscard]] Layout& layout() { return layout_; }
  [[nodiscard]] std::span<Pack> packs() { return packs_; }
  [[nodiscard]] Levels& levels() { return levels_; }
  [[nodiscard]] Inputs& inputs() { return inputs_; }
  [[nodiscard]] const Inputs& inputs() const { return inputs_; }

  // See Simulator::machine_code().
  [[nodiscard]] std::string machine_code() const;

 private:
  static constexpr int kStepHalvings = 20;  // a step is halved down to 2^-20, then its failure is examined
  static constexpr double kSmallestStep = 1.0 / (1 << kStepHalvings);  // over the whole step
  static constexpr int kMostRejected = 40000;                          // attempts at one step for any reason

  void use(StepCode& code);
  void repeat_in_idle_lanes();
  void announce_division();
  [[nodiscard]] Status solve_at(double t, Attempt::Branch branch, StepErrors& errors);
  [[nodiscard]] Status solve_all(double t, Attempt::Branch branch, StepErrors& errors);
  [[nodiscard]] Status solve_packs(double t, Attempt::Branch branch, double converged, StepErrors& errors);
  [[nodiscard]] Attempt usual_attempt(double t, Attempt::Branch branch, double converged) const;
  [[nodiscard]] bool is_usual(Attempt::Branch branch) const;
  [[nodiscard]] bool solve_together(const Attempt& attempt, StepErrors& errors);
  [[nodiscard]] double bent(double t);
  void measure_bows();
  [[nodiscard]] Status hidden();
  void undo_attempt();
  void forget_guards();
  [[nodiscard]] Status check_levers(MotionConditions::Levers which, double seconds);
  void record_stop(const Status& stopped, double target);
  void accept(double t, const StepErrors& errors);
  [[nodiscard]] Status check_aim(double t);
  [[nodiscard]] Status advance(double t, bool may_reselect, Stride& stride);
  void set_deadline();
  [[nodiscard]] double bend() const;
  void end_step(bool arrived);
  void predict(double target, Attempt::Branch branch);
  void combine();
  void expand();
  [[nodiscard]] Status try_step(double target, Attempt::Branch branch);
  [[nodiscard]] Status check_limits(double target, StepErrors& errors);
  [[nodiscard]] Status check_limits_passed(double change);
  void begin_limits(const Continuation* before);
  [[nodiscard]] Status turned_unseen(AngleTurns::Turned turned);
  [[nodiscard]] bool may_choose_anew(bool asked, double first) const;
  [[nodiscard]] Status examine_failed_step(const Status& failed, double target, double t, double first);
  [[nodiscard]] bool turns_back();
  [[nodiscard]] std::pair<double, double> fold_between(double target, double t);
  [[nodiscard]] bool pass(double target, double t, double first);
  [[nodiscard]] bool is_avoided(double h, double first);
  [[nodiscard]] bool pass_by(double reach, double smallest, double to);
  [[nodiscard]] bool arrive_on_change_point(double t, double smallest);
  [[nodiscard]] bool find_change_point(double t, double reach, double smallest,
                                       std::vector<ChangePointPosture>& postures);
  void leave_change_point();
  [[nodiscard]] bool walk(double until, double h, double change);
  [[nodiscard]] const std::string& name_of(const Noticed& event) const;
  [[nodiscard]] Noticed about_limit(const LimitWatch::Change& change) const;
  void record(Noticed event, double step);

  const Preparation& prepared_;
  const StepSettings& settings_;
  Report& report_;
  EventLog& events_;
  const GroupedSystem& structure_;
  const System& system_;
  Inputs inputs_;
  Layout layout_;
  std::vector<Pack>& packs_;
  Levels levels_;
  std::unique_ptr<Together> together_;  // null without +together
  std::unique_ptr<WholeStep> whole_;    // null if there is no such code
  State::Prediction prediction_;        // of the step that is tried
  bool is_predicted_ = true;            // false: it is left to whole_
  State state_;
  Bows bows_;
  bool bends_ = false;              // a law leaves its chord on the step that was tried
  std::array<LaneArray, 3> known_;  // for bows_: known coordinates and their derivatives, in the layout of the state
  const State::PostureHistory* over_ = nullptr;  // predicts the step over a change point; else null
  bool lacks_rates_ = false;  // the rates of some unknowns are not computed, because they are not wanted
  bool expands_ = false;      // all rates are computed, and used for the prediction
  MotionConditions conditions_;
  double converged_ = kConverged;
  StepErrors last_errors_;                      // of the last accepted posture
  std::vector<std::uint8_t> passing_, passed_;  // packs: 1 while the pack passes a change point; those of the last pass
  double now_ = 0;
  std::int64_t attempts_ = 0, rejected_ = 0;
  double last_before_pass_ = 0;
  double beyond_ = 0;              // a time behind the crossing that was found last
  double change_point_at_ = kNan;  // time of the posture whose packs stand on change points; NaN: none does
  bool passes_ = false;            // a change point is being passed: limits are checked afterwards
  int angles_together_;            // angles_together()
  bool any_turn_ = true;           // angles take the shorter way, even if they turn far
  bool turn_guessed_ = false;
  double turned_ = 0;    // length of the step that was tried over the largest allowed one, by turns and bows
  double shortest_ = 0;  // length of the shortest attempt at this step, until its failure is examined
  DiagnosisMemory diagnosis_;
  Singularity here_;  // the last diagnosis
  Approach approach_;
  State::PostureHistory history_;  // before the change point that is passed
  double largest_correction_ = 0;  // of a step through a change point, relative to the predicted move
  std::function<void()> before_dividing_;
  bool divided_ = false;  // the current step was divided, or it failed
  // At the begin of the current step; attempts that fail change them before save() is called.
  struct {
    double converged;
    bool turn_guessed;
  } at_begin_{};
  bool wants_reselection_ = false;
  double selected_at_ = kNan;    // time of the last reselection that was tried
  std::size_t failed_pack_ = 0;  // of the last attempt; the number of packs: none
  Clock clock_ = &std::chrono::steady_clock::now;
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
  std::int64_t joined_from_ = 0;
};

}  // namespace assur
