// One attempt at a posture: known coordinates, groups, and the conditions that the posture must meet.
#include <algorithm>
#include <cmath>
#include <utility>

#include "index.hpp"
#include "motion/continuation.hpp"
#include "numbers.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

constexpr double kUnseen = 2;  // parts of a step in which a measured angle may have turned unseen

}  // namespace

// One attempt. A rejected attempt, or one that only explores, does not change the packs.
Status Continuation::solve_at(double t, Attempt::Branch branch, StepErrors& errors) {
  ++attempts_;
  try {
    const Status s = solve_all(t, branch, errors);
    if (!s.ok() || branch == Attempt::Branch::anywhere) undo_attempt();
    return s;
  } catch (...) {  // from a law or a callback
    undo_attempt();
    throw;
  }
}

// Known coordinates at t, then level after level, pack after pack.
Status Continuation::solve_all(double t, Attempt::Branch branch, StepErrors& errors) {
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  failed_pack_ = packs_.size();
  turned_ = 0;
  const double converged = branch == Attempt::Branch::inside ? converged_ : kConverged;
  const Attempt attempt = usual_attempt(t, branch, converged);
  const bool may_be_whole = !std::exchange(is_predicted_, true);
  bool whole = may_be_whole && !deadline_passed();
  const auto begin_in_parts = [&] {
    if (may_be_whole) combine();
    return inputs_.place(t, q);
  };
  inputs_.evaluate(t);
  if (!whole) {
    if (const Status s = begin_in_parts(); !s.ok()) return s;
  }
  if (!any_turn_) turned_ = bent(t);
  if (turned_ > 1) return {Code::branch_unknown, {}, turned_};
  if (whole && !whole_->run(q, prediction_, attempt)) {
    whole = false;
    if (const Status s = begin_in_parts(); !s.ok()) return s;
  }
  const double seconds = branch == Attempt::Branch::inside ? t - now_ : 0;
  if (const Status s = check_levers(MotionConditions::Levers::known, seconds); !s.ok()) return s;
  const Status solved = whole ? whole_->finish(q, attempt, report_.counters, errors, failed_pack_)
                              : solve_packs(t, branch, converged, errors);
  if (!solved.ok()) return solved;
  if (const Status s = check_levers(MotionConditions::Levers::unknown, seconds); !s.ok()) return s;
  if (conditions_.watches()) {
    const bool may_correct = settings_.iterations == 0 && branch != Attempt::Branch::anywhere;
    std::size_t one = 0;
    const Status s = check_watched(
        {&conditions_, 1}, state_.at(0), converged, may_correct, [&] { return solve_packs(t, branch, 0, errors); },
        report_.counters, errors, one);
    if (!s.ok()) return s;
  }
  // The angles of drivers are within the limit of a step here; measured angles may have turned farther.
  if (branch != Attempt::Branch::inside || !conditions_.is_followed()) return {};
  const AngleTurns::Turned turned = conditions_.follow_angles(state_.at(0), t - now_, any_turn_ ? 0 : bows_.times());
  return turned == AngleTurns::Turned::known ? Status{} : turned_unseen(turned);
}

// Length of a step to t, whose known coordinates are at hand, over the largest allowed one: by the turns of the
// drivers, and by what their laws may do within the step.
double Continuation::bent(double t) {
  if (inputs_.renew_bows(now_, t)) bends_ = bows_.take(inputs_.program().bows());
  const double turn = inputs_.program().turned(inputs_.program().accepted_angles(), angles_together_, system_.teeth);
  if (turn > 1 || !bends_) return turn;
  if (!bows_.serve(report_.counters.branch_checks)) {
    measure_bows();
    double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
    (void)inputs_.drive(t, q);
  }
  return std::max(turn, bows_.part());
}

void Continuation::measure_bows() {
  const double* const q[3] = {state_.accepted(0), state_.accepted(1), state_.accepted(2)};
  const auto known = [&](std::size_t, double* probe, std::span<const double> rates) {
    double* const here[3] = {known_[0].data(), known_[1].data(), known_[2].data()};
    std::copy_n(q[0], layout_.first_unknown, here[0]);
    std::fill_n(here[1], layout_.first_unknown, 0.0);
    (void)inputs_.drive(now_, here);
    std::fill_n(here[1], layout_.first_unknown, 0.0);
    inputs_.lean(rates, here);
    std::copy_n(here[1], layout_.first_unknown, probe);
  };
  bows_.measure(q[0], report_.counters.branch_checks, known, [&](const auto& work) { levels_.each(work); });
  drop_factors();
  conditions_.measure(q, bows_, known_[0]);
}

// A step must be divided if a lever may vanish in it, or a limit may be passed, so that its ends do not show it.
Status Continuation::hidden() {
  bows_.doubt();
  turned_ = kUnseen;
  return {Code::branch_unknown, {}, turned_};
}

Status Continuation::turned_unseen(AngleTurns::Turned turned) {
  const bool guesses = any_turn_ || turned == AngleTurns::Turned::none;
  turn_guessed_ = turn_guessed_ || guesses;
  if (guesses) return {};
  ++report_.counters.rejected;
  bows_.doubt();
  turned_ = kUnseen;
  return {Code::branch_unknown, {}, turned_};
}

Attempt Continuation::usual_attempt(double t, Attempt::Branch branch, double converged) const {
  Attempt usual;
  usual.branch = branch;
  usual.number = attempts_;
  usual.most_iterations = settings_.most_iterations;
  usual.converged = converged;
  if (report_.error.position > 0) usual.known_residual = report_.error.position;
  usual.time = t;
  usual.all_rates = expands_;
  usual.makes_code = std::isnan(selected_at_);
  return usual;
}

// True if all groups are solved by the same rules.
bool Continuation::is_usual(Attempt::Branch branch) const {
  return branch == Attempt::Branch::inside && settings_.iterations == 0 && !expands_ && std::isnan(change_point_at_) &&
         std::all_of(passing_.begin(), passing_.end(), [](std::uint8_t passes) { return passes == 0; });
}

Status Continuation::solve_packs(double t, Attempt::Branch branch, double converged, StepErrors& errors) {
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  const Attempt usual = usual_attempt(t, branch, converged);
  const bool inside = branch == Attempt::Branch::inside;
  const auto attempt = [&](std::size_t p) {
    Attempt a = usual;
    if (inside && packs_[p].level > 0) a.iterations = settings_.iterations;
    const bool stands = layout_.change_points[p].exists();
    if (inside && stands && t == change_point_at_) {
      a.branch = Attempt::Branch::change_point;
      a.change_point = &layout_.change_points[p];
    } else if (inside && (stands || passing_[p] != 0)) {
      a.branch = Attempt::Branch::pass;
      a.converged = kConverged;
      const GroupSolver& s = levels_.solver(packs_[p]);
      const std::size_t count = idx(s.group_class().n) * idx(s.lanes());
      a.largest_correction = largest_correction_ * state_.predicted_move(packs_[p].unknowns, count);
    }
    return a;
  };
  if (inside && together_) {
    if (solve_together(usual, errors)) return {};
    ++report_.counters.level_by_level;
  }
  // At the start one thread solves the packs in order: the first pack of a class makes the solver that others clone.
  Status s = levels_.solve(
      q, branch == Attempt::Branch::start, attempt, [&] { return deadline_passed(); }, report_.counters, errors,
      failed_pack_);
  forget_guards();
  if (s.code == Code::deadline) s.figure = settings_.seconds;
  return s;
}

// Solves the groups of all levels at once. False: the attempt must be solved level after level.
bool Continuation::solve_together(const Attempt& attempt, StepErrors& errors) {
  if (!is_usual(attempt.branch) || deadline_passed()) return false;
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  return together_->solve(q, attempt, report_.counters, errors);
}

// Restores the packs to their state before the last attempt.
void Continuation::undo_attempt() {
  if (together_) together_->undo(attempts_);
  for (Pack& pack : packs_) pack.undo(attempts_);
  forget_guards();
}

void Continuation::forget_guards() {
  if (together_) together_->forget();
}

Status Continuation::check_levers(MotionConditions::Levers which, double seconds) {
  if (!conditions_.has(which)) return {};
  const Status s =
      conditions_.check_levers(which, {state_.accepted(0), state_.accepted(1), state_.accepted(2)},
                               {state_.at(0), state_.at(1), state_.at(2)}, seconds, any_turn_ ? 0 : bows_.times());
  return s.code == Code::branch_unknown ? hidden() : s;
}

// Records the driver or redundant equation that stopped the motion.
void Continuation::record_stop(const Status& stopped, double target) {
  Noticed event{now_, target, stopped.where, stopped.code, stopped.figure};
  if (stopped.code == Code::inconsistent) {
    Watch& watch = conditions_.watch();
    event.watched = static_cast<std::int32_t>(watch.worst());
    const Watched& of = structure_.watched[watch.worst()];
    event.figure = watch.violation(state_.at(0)) * system_.unit(of.is_length ? 1 : 0);
  } else if (stopped.code != Code::actuator_zero) {
    return;
  }
  record(std::move(event), std::abs(target - now_));
}

void Continuation::accept(double t, const StepErrors& errors) {
  if (t != change_point_at_ && !std::isnan(change_point_at_)) leave_change_point();
  state_.accept(t);
  inputs_.program().accept();
  if (conditions_.is_followed()) conditions_.accept(t - now_, passes_);
  now_ = t;
  report_.reached = t;
  last_errors_ = errors;
  errors.add_to(report_.error);
}

}  // namespace assur
