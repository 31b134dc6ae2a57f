#include "path/continuation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "assur/status.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "scene/residual_scale.hpp"

namespace assur {
namespace {

constexpr int kStepHalvings = 20;  // a step is halved down to 2^-20, then it is asked why it fails
constexpr double kSmallestStep = 1.0 / (1 << kStepHalvings);
constexpr double kUnseen = 2;            // parts of a step in which a measured angle turned unseen
constexpr double kShorter = 1.0 / 4;     // each time it is asked again
constexpr double kLeast = 0x1p-44;       // of the step, and
constexpr double kResolved = 16 * kEps;  // of the time: no step is shorter
constexpr int kMostRejected = 10000;     // attempts of one step, whatever they were for
constexpr int kMostWalked = 1000;        // attempts on a part of the way to or from a change point; it takes some tens
constexpr double kPassed = 64;      // steps so much longer than the first shortest one are far from where it failed
constexpr double kClear = 1e-5;     // singular value, over the largest one: a posture is known to eps / kClear^2 of it
constexpr double kLookedAt = 4e-6;  // singular values from which the least one of a crossing is foretold
constexpr double kSeen = 1e-7;      // least one that rounding of dimensions to 14 digits does not explain
constexpr double kNearer = 1.15;    // of singular values, from one posture to the next that is compared
constexpr int kExpandAfter = 4;     // rejected attempts rates are computed of all unknowns, and predict
constexpr int kReach = 12;        // a change point is passed from 2^12 of the first shortest steps before it to beyond
constexpr int kLonger = 8;        // or from up to 2^8 times as far
constexpr int kMoreHalvings = 6;  // of the shortest step, on the way back from a change point
constexpr double kApart = 1.0 / 16;     // of that reach: a step that ends nearer to the change point is in doubt
constexpr double kSureOfBranch = 1e-3;  // largest correction over the distance of the branches
constexpr double kLittleLever = 1e-3;   // of what it was at the start: a driver's lever that is about to vanish

bool worth_halving(Code code) {
  return code == Code::branch_unknown || code == Code::not_converged || code == Code::singular ||
         code == Code::not_finite;
}

}  // namespace

Continuation::Continuation(const Prepared& prepared, const StepLimits& limits, Report& report)
    : prepared_(prepared),
      limits_(limits),
      report_(report),
      structure_(*prepared.structure),
      system_(*structure_.system),
      inputs_(system_, prepared.controlled),
      layout_(lay_out(prepared)),
      packs_(layout_.packs),
      levels_(prepared, layout_, limits.pin_to),
      together_(angles_together(system_, structure_)) {
  state_.resize(layout_.first_unknown, layout_.size, prepared.plan.predictor);
  if (!structure_.watch_class.equations.empty()) {
    watch_.emplace(system_, structure_, layout_.address);
    if (prepared.reselect) independence_.emplace(system_, structure_, layout_.address);
    if (independence_ && independence_->empty()) independence_.reset();
  }
  passing_.assign(packs_.size(), 0);
  lacks_rates_ = std::any_of(structure_.classes.begin(), structure_.classes.end(),
                             [](const GroupClass& c) { return c.derivatives == 0 || c.first_wanted > 0; });
}

void Continuation::keep_what_is_read(std::vector<std::uint8_t> marked) {
  for (const Pack& pack : packs_) {
    for (const std::int32_t a : pack.inputs) marked[idx(a)] = 1;
  }
  for (const std::int32_t c : structure_.watch.inputs) marked[idx(layout_.address[idx(c)])] = 1;
  marked.resize(system_.coordinates.size());  // known coordinates lie at their own index
  inputs_.keep(std::move(marked));
  levers_ = inputs_.levers();
  known_levers_ = levers_.size();
  for (const Positive& p : system_.positive) {
    const std::int32_t address = layout_.address[idx(p.coordinate)];
    if (address >= 0 && idx(address) >= layout_.first_unknown) levers_.push_back({address, p.driver});
  }
}

void Continuation::start(double time, const std::vector<double>& posture, const Inputs::Controls* before) {
  now_ = time;
  selected_at_ = before != nullptr ? time : kNan;
  deadline_ = std::chrono::steady_clock::time_point::max();  // it is for steps
  inputs_.reset();
  if (before != nullptr) inputs_.take(*before);
  watched_level_ = 0;
  poor_ = kPoorSet;
  measured_at_ = -1;
  restart_solvers();
  converged_ = kConverged;
  stands_still_ = false;
  any_turn_ = true;
  state_.clear();
  for (std::size_t c = 0; c < layout_.address.size(); ++c) {
    if (layout_.address[c] >= 0) state_.at(0)[layout_.address[c]] = posture[c];
  }
  repeat_in_idle_lanes();
  StepErrors errors;
  const Status s = solve_at(now_, Attempt::Branch::start, errors);
  if (!s.ok()) {
    const std::string group = s.where.is(Place::Kind::group) ? " in group " + structure_.name_of(s.where) : "";
    throw Error(Error::Kind::numerical,
                "the start posture has no " + std::string(s.code == Code::singular ? "velocities" : "solution") + ": " +
                    std::string(name(s.code)) + group +
                    (s.code == Code::singular ? "; the Jacobian is singular there, start elsewhere on the path" : ""));
  }
  if (turns_ != nullptr) turns_->start(state_.at(0));
  turn_guessed_ = false;
  accept(now_, errors);
  for (Lever& l : levers_) l.start = state_.at(0)[l.address];
}

void Continuation::restart_solvers() {
  levels_.restart();
  for (Pack& pack : packs_) {
    pack.solver.reset();
    pack.factored = false;
  }
}

void Continuation::drop_factors() {
  for (Pack& pack : packs_) pack.factored = false;
}

void Continuation::save(Snapshot& into, bool in_step) const {
  into.state.copy(state_);
  into.controls = inputs_.controls();
  if (in_step) Inputs::undo_step(into.controls, now_);
  into.packs.resize(packs_.size());
  for (std::size_t p = 0; p < packs_.size(); ++p) {
    packs_[p].save(into.packs[p]);
  }
  into.errors = last_errors_;
  into.converged = converged_;
  into.time = now_;
  into.selected_at = selected_at_;
  into.stands_still = stands_still_;
  into.watched_level = watched_level_;
  into.poor = poor_;
  into.levers = levers_;
  into.angles = inputs_.accepted_angles();
  if (turns_ != nullptr) turns_->save(into.turns);
}

bool Continuation::fits(const Snapshot& from) const {
  if (packs_.size() != from.packs.size() || !state_.is_like(from.state)) return false;
  for (std::size_t p = 0; p < packs_.size(); ++p) {
    if (packs_[p].anchor.size() != from.packs[p].anchor.size()) return false;
  }
  return inputs_.controls().size() == from.controls.size();
}

void Continuation::restore(const Snapshot& from) {
  state_.copy(from.state);
  state_.restore();
  inputs_.take(from.controls);
  for (std::size_t p = 0; p < packs_.size(); ++p) packs_[p].restore(from.packs[p]);
  last_errors_ = from.errors;
  converged_ = from.converged;
  report_.reached = now_ = from.time;
  selected_at_ = from.selected_at;
  stands_still_ = from.stands_still;
  watched_level_ = from.watched_level;
  poor_ = from.poor;
  measured_at_ = -1;
  levers_ = from.levers;
  inputs_.accept(from.angles);
  if (turns_ != nullptr) turns_->restore(from.turns);
  wants_reselection_ = false;
}

bool Continuation::ask_again_from_rest() {
  stands_still_ = inputs_.ask_again_from_rest();
  return stands_still_;
}

void Continuation::tell_before_dividing() {
  if (!std::exchange(divided_, true) && before_dividing_) before_dividing_();
}

void Continuation::repeat_in_idle_lanes() {
  for (const Pack& pack : packs_) {
    const int w = levels_.solver(pack).lanes();
    double* x = state_.at(0) + pack.unknowns;
    for (std::int32_t i = 0; i < levels_.solver(pack).program().n; ++i) {
      for (int lane = pack.used; lane < w; ++lane) x[i * w + lane] = x[i * w];
    }
  }
}

// ---- one posture

// An attempt: one that is rejected, or only looks ahead, leaves nothing in the packs.
Status Continuation::solve_at(double t, Attempt::Branch branch, StepErrors& errors) {
  ++attempts_;
  const auto undo = [&] {
    for (Pack& pack : packs_) pack.undo(attempts_);
  };
  try {
    const Status s = solve_all(t, branch, errors);
    if (!s.ok() || branch == Attempt::Branch::anywhere) undo();
    return s;
  } catch (...) {  // from a law or a callback
    undo();
    throw;
  }
}

// Known coordinates at t, then level after level, pack after pack.
Status Continuation::solve_all(double t, Attempt::Branch branch, StepErrors& errors) {
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  failed_pack_ = packs_.size();
  vanished_ = false;
  turned_ = 0;
  if (const Status s = inputs_.drive(t, q); !s.ok()) return s;
  if (!any_turn_) turned_ = inputs_.turned(together_);
  if (turned_ > 1) return {Code::branch_unknown, {}, turned_};
  const double seconds = branch == Attempt::Branch::inside ? t - now_ : 0;
  if (const Status s = check_levers(0, known_levers_, seconds); !s.ok()) return s;
  const double converged = branch == Attempt::Branch::inside ? converged_ : kConverged;
  if (const Status s = solve_packs(t, branch, converged, errors); !s.ok()) return s;
  if (const Status s = check_levers(known_levers_, levers_.size(), seconds); !s.ok()) return s;
  if (watch_) {
    if (const Status s = check_watched(t, branch, converged, errors); !s.ok()) return s;
  }
  // Drivers turned no more than a step may; does what follows them?
  if (turns_ == nullptr || branch != Attempt::Branch::inside) return {};
  const AngleTurns::Way way = turns_->follow(state_.at(0), t - now_);
  return way == AngleTurns::Way::known ? Status{} : turned_unseen(way);
}

Status Continuation::turned_unseen(AngleTurns::Way way) {
  const bool guesses = any_turn_ || way == AngleTurns::Way::none;
  turn_guessed_ = turn_guessed_ || guesses;
  if (guesses) return {};
  ++report_.counters.rejected;
  turned_ = kUnseen;
  return {Code::branch_unknown, {}, turned_};
}

Status Continuation::solve_packs(double t, Attempt::Branch branch, double converged, StepErrors& errors) {
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  Attempt usual;
  usual.branch = branch;
  usual.number = attempts_;
  usual.most_iterations = limits_.most_iterations;
  usual.converged = converged;
  usual.time = t;
  usual.all_rates = expands_;
  const bool inside = branch == Attempt::Branch::inside;
  const auto attempt = [&](std::size_t p) {
    Attempt a = usual;
    if (inside && packs_[p].level > 0) a.iterations = limits_.iterations;
    if (inside && passing_[p] != 0) {
      a.branch = Attempt::Branch::pass;
      a.converged = kConverged;
      const GroupSolver& s = levels_.solver(packs_[p]);
      const std::size_t count = idx(s.program().n) * idx(s.lanes());
      a.largest_correction = largest_correction_ * state_.predicted_move(packs_[p].unknowns, count);
    }
    return a;
  };
  // At the start every pack makes its solver from those of the packs before it.
  Status s = levels_.solve(
      q, branch == Attempt::Branch::start, attempt, [&] { return deadline_passed(); }, report_.counters, errors,
      failed_pack_);
  if (s.code == Code::deadline) s.figure = limits_.seconds;
  return s;
}

// Equations that hold cannot be told from others up to what is left in those that were solved; what is left there is
// larger in those that are watched. One more correction brings both to the rounding level.
Status Continuation::check_watched(double t, Attempt::Branch branch, double left, StepErrors& errors) {
  const auto residual = [&] {
    report_.counters.evaluated_equations += static_cast<std::int64_t>(watch_->equations());
    return watch_->residual(state_.at(0));
  };
  double r = residual();
  const bool may_correct = limits_.iterations == 0 && branch != Attempt::Branch::anywhere;
  if (may_correct && r > std::max(left, 2 * watched_level_)) {
    if (const Status s = solve_packs(t, branch, 0, errors); !s.ok()) return s;
    r = residual();
    watched_level_ = r > left ? r : 0;
  }
  if (!(r <= std::max(kConsistent, left))) return {Code::inconsistent, {}, r};
  errors.position = std::max(errors.position, r);
  return {};
}

// Beyond zero a driver's equations hold half a turn away from its law.
Status Continuation::check_levers(std::size_t begin, std::size_t end, double seconds) {
  const double* const from[3] = {state_.accepted(0), state_.accepted(1), state_.accepted(2)};
  const double* const to[3] = {state_.at(0), state_.at(1), state_.at(2)};
  const Lever* const l = vanished(std::span(levers_).subspan(begin, end - begin), from, to, seconds);
  if (l == nullptr) return {};
  // A driver that is to get there does so however short the step is.
  vanished_ = idx(l->address) >= layout_.first_unknown || to[0][l->address] > 0;
  return {Code::actuator_zero, Place::driver(l->driver), std::min(to[0][l->address], 0.0)};
}

// Which driver or redundant equation stopped the motion.
void Continuation::tell(const Status& stopped, double target) {
  Event event{now_, target, "", stopped.code, stopped.figure};
  if (stopped.code == Code::inconsistent) {
    const Watched& of = structure_.watched[watch_->worst()];
    event.group = of.name;
    event.figure = watch_->violation(state_.at(0)) * system_.unit(of.is_length ? 1 : 0);
    event.unit = of.is_length ? "m" : "";
  } else if (stopped.code == Code::actuator_zero) {
    event.group = system_.drivers[idx(stopped.where.index)];
  } else {
    return;
  }
  record(std::move(event), std::abs(target - now_));
}

void Continuation::accept(double t, const StepErrors& errors) {
  state_.accept(t);
  inputs_.accept();
  if (turns_ != nullptr) turns_->accept(t - now_);
  now_ = t;
  report_.reached = t;
  last_errors_ = errors;
  errors.add_to(report_.error);
}

bool Continuation::deadline_passed() const {
  return limits_.seconds > 0 && std::chrono::steady_clock::now() > deadline_;
}

// ---- one step

Status Continuation::step_to(double t, bool may_reselect, Stride& stride) {
  wants_reselection_ = false;
  divided_ = false;
  if (t == now_) return {};
  if (const Status s = check_aim(t); !s.ok()) return s;
  if (std::exchange(stands_still_, false)) state_.stand_still();
  if (limits_.seconds > 0) {
    constexpr double kLongestTime = 1e9;  // 30 years; the clock counts nanoseconds up to 300
    deadline_ =
        std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                               std::chrono::duration<double>(std::min(limits_.seconds, kLongestTime)));
  }
  inputs_.begin_step(now_, t);
  Status status;
  try {
    status = advance(t, may_reselect, stride);
  } catch (...) {  // from a law or a callback
    std::fill(passing_.begin(), passing_.end(), 0);
    tell_before_dividing();
    end_step(Inputs::End::failed);
    throw;
  }
  end_step(status.ok() ? Inputs::End::arrived : wants_reselection_ ? Inputs::End::goes_on : Inputs::End::failed);
  return status;
}

// From posture to posture until t.
Status Continuation::advance(double t, bool may_reselect, Stride& stride) {
  const double span = t - now_, first = std::abs(span) * kSmallestStep;
  any_turn_ = turn_guessed_ = expands_ = false;
  shortest_ = first;
  approach_.clear();
  int in_a_row = 0;  // attempts that were rejected; once they are many, they stay so
  while (now_ != t) {
    const double h = std::copysign(std::min(stride.length, std::abs(span)), span);
    const double target = std::abs(t - now_) <= std::abs(h) * 1.0000001 ? t : now_ + h;
    if (in_a_row >= kExpandAfter) expand();
    const Status s = try_step(target, Attempt::Branch::inside);
    if (s.ok()) {
      if (in_a_row < kExpandAfter) in_a_row = 0;
      if (now_ == t) break;  // what was left says nothing of a whole stride
      stride.arrive();
      if (stride.length > kPassed * first) {  // whatever was close
        shortest_ = first;
        approach_.clear();
      }
      ++report_.counters.substeps;
      if (may_choose_anew(may_reselect, first) && set_is_poor()) {
        wants_reselection_ = true;
        return {Code::singular, {}, largest_coefficient_};
      }
      continue;
    }
    tell_before_dividing();
    if (turned_ > 1) {
      any_turn_ = std::abs(h) <= shortest_ * 1.5;
      if (!any_turn_) stride.set(std::max(std::abs(target - now_) / std::ceil(turned_), shortest_));
      continue;
    }
    ++report_.counters.rejected;
    ++in_a_row;
    if (rejected_ >= kMostRejected) {
      record({now_, target, structure_.name_of(s.where), Code::branch_unknown, s.figure}, std::abs(t - target));
      return {Code::branch_unknown, s.where, s.figure};
    }
    // Close to a singularity of the equations that are solved, what is watched is the first to tell.
    if (s.code == Code::inconsistent && may_choose_anew(may_reselect, first)) {
      wants_reselection_ = true;
      return s;
    }
    const bool halves =
        vanished_ || s.code == Code::inconsistent || (worth_halving(s.code) && failed_pack_ != packs_.size());
    if (!halves) {
      tell(s, target);
      return s;
    }
    if (std::abs(h) > shortest_ * 1.5) {
      stride.set(std::abs(target - now_) / 2);
      continue;
    }
    if (!vanished_ && may_choose_anew(may_reselect, first)) {
      wants_reselection_ = true;
      return s;
    }
    if (vanished_ || failed_pack_ == packs_.size()) {
      tell(s, target);
      return s;
    }
    if (const Status found = at_the_limit(s, target, t, first); !found.ok()) return found;
    stride.set(shortest_);
  }
  return {};
}

// A step that did not arrive leaves the last good posture, which may lie on the way.
void Continuation::end_step(Inputs::End end) {
  if (end != Inputs::End::arrived) state_.restore();
  stands_still_ = inputs_.end_step(now_, end);
  if (end == Inputs::End::arrived) ++report_.counters.steps;
}

bool Continuation::polish(double converged) {
  if (converged == 0 && limits_.iterations > 0) return false;
  converged_ = converged;
  state_.restore();
  StepErrors errors;
  if (!solve_at(now_, Attempt::Branch::inside, errors).ok()) {
    state_.restore();
    return false;
  }
  state_.replace();
  if (turns_ != nullptr) turns_->accept(0);
  last_errors_ = errors;
  return true;
}

// Is it somewhere? A driver that was set to nowhere is named by an event, and nothing moves.
Status Continuation::check_aim(double t) {
  if (!std::isfinite(t)) return {Code::not_finite, {}, t};
  double value = 0;
  const std::string* const driver = inputs_.not_finite(value);
  if (driver == nullptr) return {};
  record({now_, t, *driver, Code::not_finite, value}, std::abs(t - now_));
  inputs_.drop_pending();
  return {Code::not_finite, {}, value};
}

// Equations that were chosen close by would serve if any did; near a fold none do, and others would be chosen in turns.
bool Continuation::may_choose_anew(bool asked, double first) const {
  return asked && prepared_.reselect && !(std::abs(now_ - selected_at_) <= kPassed * first);
}

// Within the ball of an anchor, conditions change by a bounded factor.
bool Continuation::set_is_poor() {
  if (independence_ && measured_at_ != report_.counters.branch_checks) {
    measured_at_ = report_.counters.branch_checks;
    largest_coefficient_ = independence_->largest_coefficient(state_.at(0));
  }
  return !(largest_coefficient_ <= poor_);
}

void Continuation::keep_set() {
  poor_ = std::max(poor_, 2 * largest_coefficient_);
  selected_at_ = now_;
}

void Continuation::predict(double target) {
  const State::Prediction prediction = over_ != nullptr ? state_.begin_prediction(*over_, target)
                                       : expands_       ? state_.begin_expansion(target)
                                                        : state_.begin_prediction(target);
  levels_.share(state_.unknowns(), [&](std::size_t part, std::size_t parts) {
    state_.predict(prediction, state_.unknowns() * part / parts, state_.unknowns() * (part + 1) / parts);
  });
}

// Until the end of the step rates of all unknowns are computed, wanted or not, and predictions are from the last
// posture and its derivatives, whatever the predictor reads: how a motion goes on where it is in doubt depends on no
// strategy.
void Continuation::expand() {
  if (std::exchange(expands_, true) || !lacks_rates_) return;
  state_.restore();
  StepErrors errors;
  if (solve_at(now_, Attempt::Branch::inside, errors).ok()) state_.replace();
  state_.restore();
}

Status Continuation::try_step(double target, Attempt::Branch branch) {
  predict(target);
  StepErrors errors;
  Status s = solve_at(target, branch, errors);
  if (s.code == Code::inconsistent && converged_ > kConverged) {  // or not solved far enough to tell
    converged_ = kConverged;
    predict(target);
    errors = {};
    s = solve_at(target, branch, errors);
  }
  if (s.ok()) {
    accept(target, errors);
  } else if (turned_ <= 1) {
    ++rejected_;
  }
  return s;
}

// The shortest step fails: is this a limit, a change point that can be passed, or are shorter steps needed? ok: go on.
// What a posture is near to does not depend on the grid: where rounding ends the search, it is left undecided.
Status Continuation::at_the_limit(const Status& failed, double target, double t, double first) {
  const std::size_t at_fault = failed_pack_;
  expand();
  failed_pack_ = at_fault;
  state_.restore();
  for (const Lever& l : levers_) {
    const double lever = state_.at(0)[l.address];
    if (lever > kLittleLever * l.start) continue;
    const Status gone{Code::actuator_zero, Place::driver(l.driver), lever};
    tell(gone, target);
    return gone;
  }
  any_turn_ = true;
  Pack& pack = packs_[failed_pack_];
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  GroupSolver::Singularity nearest = levels_.solver(pack).diagnose(pack, q);
  Status found = nearest.status;
  if (found.code == Code::limit_reached && !turns_back(std::move(nearest))) found.code = Code::branch_unknown;
  const double least = std::max(first * (kLeast / kSmallestStep), kResolved * std::max(std::abs(now_), std::abs(t)));
  const bool shorter = kShorter * shortest_ >= least;
  // Close to a change point rounding would take one of the branches.
  const bool clear = found.code != Code::change_point_passed || (found.figure > kClear && shorter);
  if (!clear && is_avoided(target - now_, first)) found.code = Code::branch_unknown;
  if (found.code != Code::limit_reached && (clear || found.code == Code::branch_unknown) && shorter) {
    shortest_ *= kShorter;
    any_turn_ = false;
    return {};
  }
  if (found.code == Code::change_point_passed && !pass(target, t, first)) found.code = Code::branch_unknown;
  const bool unclear = failed.code == Code::not_converged && found.figure > 0.05;
  if (found.code == Code::branch_unknown && (failed.code == Code::not_finite || unclear)) found = failed;
  const bool passed = found.code == Code::change_point_passed;
  if (found.code == Code::limit_reached) target = first_without_solution(target, t);
  any_turn_ = false;
  record(
      {passed ? last_before_pass_ : now_, passed ? now_ : target,
       structure_.name_of(found.where.is(Place::Kind::group) ? found.where : failed.where), found.code, found.figure},
      std::abs(t - target));
  if (!passed) return found;
  shortest_ = first;
  return {};
}

// Rates that grow are no evidence of a fold: they do so before a posture that is nearly singular, too, behind which the
// motion goes on. Towards a fold, where the unknowns turn back like s* - s = y^2, the square of the smallest singular
// value falls in proportion to the way of the inputs s: the slopes between three postures are the same. Towards the
// others, like s = y^3 + e y, it falls slower and slower, at least as it does for e = 0.
bool Continuation::turns_back(GroupSolver::Singularity here) {
  const auto same = [&](const GroupSolver::Singularity& o) {  // others may fail in turns with it
    return o.status.where == here.status.where && o.block == here.block;
  };
  std::erase_if(approach_, [&](const auto& o) { return same(o) && o.smallest <= here.smallest; });
  std::vector<const GroupSolver::Singularity*> nearer;
  approach_.reserve(approach_.size() + 1);
  for (const auto& o : approach_) {
    if (same(o)) nearer.push_back(&o);
  }
  if (!nearer.empty() && nearer.back()->smallest < kNearer * here.smallest) return false;
  nearer.push_back(&approach_.emplace_back(std::move(here)));
  if (nearer.size() < 3) return false;
  const auto *const last = nearer.back(), *const middle = nearer[nearer.size() - 2],
                    *const first = nearer[nearer.size() - 3];
  const auto fall = [](const auto& far, const auto& near) {
    return far->smallest * far->smallest - near->smallest * near->smallest;
  };
  const auto way = [](const auto& far, const auto& near) {
    double sum = 0;
    for (std::size_t i = 0; i < near->reads.size(); ++i) sum = std::hypot(sum, near->reads[i] - far->reads[i]);
    return sum;
  };
  const auto way_of_cubic = [](const auto& far, const auto& near) {
    return std::pow(far->smallest, 1.5) - std::pow(near->smallest, 1.5);
  };
  const double falls = fall(middle, last) / fall(first, middle);
  const double slopes = falls * way(first, middle) / way(middle, last);
  const double of_cubic = falls * way_of_cubic(first, middle) / way_of_cubic(middle, last);
  const double least = std::sqrt(of_cubic);  // halfway between both
  return slopes >= least && slopes <= 1 / least;
}

// At a change point the smallest singular value is zero. Where two branches come close and stay apart it is not, and
// each goes its own way, which shorter steps follow. Close to the least value its square is a parabola of the way: two
// of them, through postures twice as far from here each, tell the least value and how well it is known. No farther than
// a change point is passed from: what is singular there, too, is none of the two.
bool Continuation::is_avoided(double h, double first) {
  const std::size_t at_fault = failed_pack_;
  const double change = now_;
  std::array<double, 4> way{}, square{};
  std::size_t looks = 0;
  std::int32_t block = -1;
  const double farthest = std::ldexp(first, kReach + kLonger);
  bool same = true;
  for (double back = std::abs(h); looks < way.size() && same; back *= 2) {
    same = back <= farthest && walk(change - std::copysign(back, h), h, change);
    if (!same) break;
    Pack& pack = packs_[at_fault];
    double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
    const GroupSolver::Singularity here = levels_.solver(pack).diagnose(pack, q);
    if (here.status.figure < kLookedAt) continue;
    if (looks == 0) block = here.block;
    same = here.block == block;
    way[looks] = back;
    square[looks++] = here.status.figure * here.status.figure;
  }
  (void)walk(change, h, change);
  state_.restore();
  failed_pack_ = at_fault;
  if (!same) return false;
  const auto least = [&](std::size_t i) {  // of the parabola through three of them
    const double near = (square[i + 1] - square[i]) / (way[i + 1] - way[i]);
    const double far = (square[i + 2] - square[i + 1]) / (way[i + 2] - way[i + 1]);
    const double bend = (far - near) / (way[i + 2] - way[i]);
    const double slope = near - bend * (way[i + 1] - way[i]);
    return square[i] - slope * slope / (4 * bend);
  };
  const double nearer = least(0), farther = least(1);
  return nearer > std::abs(farther - nearer) + kSeen * kSeen;
}

// The shortest steps through one change point are one event.
void Continuation::record(Event event, double step) {
  if (!report_.events.empty()) {
    Event& before = report_.events.back();
    if (before.kind == event.kind && before.group == event.group && std::abs(event.time - before.until) <= step) {
      before.until = event.until;
      before.figure = std::min(before.figure, event.figure);
      return;
    }
  }
  report_.events.push_back(std::move(event));
}

// Steps end a little before a fold, where the ball around the posture shrinks to nothing; the fold itself lies before
// the first time at which Newton's method finds no solution at all.
double Continuation::first_without_solution(double target, double t) {
  const double smallest = target - now_;
  for (int k = 0; k <= kStepHalvings; ++k) {
    const double h = std::ldexp(smallest, k);
    target = std::abs(t - now_) <= std::abs(h) ? t : now_ + h;
    state_.predict(target);
    StepErrors errors;
    const bool exists = solve_at(target, Attempt::Branch::anywhere, errors).ok();
    if (!exists) break;
  }
  state_.restore();
  return target;
}

// Over a change point by the smooth continuation. Close to it a posture is uncertain by eps / distance and its rates
// by eps / distance^2, so the step starts well before it and lands as far beyond, where the branches are apart by
// more than any error. What predicts that step does not depend on the strategy: a cubic through postures on the way
// back. Other packs may be at one of theirs at the same time.
bool Continuation::pass(double target, double t, double first) {
  const std::size_t failed = failed_pack_;
  for (int longer = 0; longer <= kLonger; longer += kLonger / 2) {
    if (pass_by(std::copysign(std::ldexp(first, kReach + longer), target - now_), target, t)) return true;
    failed_pack_ = failed;
  }
  return false;
}

bool Continuation::pass_by(double reach, double target, double t) {
  last_before_pass_ = now_;
  const std::size_t at_its_change_point = failed_pack_;
  const double change = now_, smallest = target - now_;
  const double to = std::abs(t - change) <= std::abs(reach) ? t : change + reach;
  bool passed = false, walked = std::abs(to - change) >= kApart * std::abs(reach);
  State::Way way;
  for (const double part : {1.0 / 4, 2.0 / 4, 3.0 / 4, 1.0}) {
    walked = walked && walk(change - part * reach, smallest, change);
    if (walked) state_.keep(way);
  }
  if (walked) {
    over_ = &way;
    passing_[at_its_change_point] = 1;
    largest_correction_ = kSureOfBranch * (to - change) / (to - now_);
    for (std::size_t more = 0; more < packs_.size() && !passed; ++more) {
      passed = try_step(to, Attempt::Branch::inside).ok();
      // Beyond all packs if none of them failed.
      if (failed_pack_ == packs_.size() || passing_[failed_pack_] != 0) break;
      passing_[failed_pack_] = 1;
    }
    std::fill(passing_.begin(), passing_.end(), 0);
    over_ = nullptr;
  }
  if (!passed) {
    (void)walk(change, smallest, change);
    state_.restore();
  }
  return passed;
}

// By continuation to `until`, in steps of about h. Predictions away from a change point do not read older postures,
// which are closer to it.
bool Continuation::walk(double until, double h, double change) {
  h = std::abs(h);
  const double shortest = std::ldexp(h, -kMoreHalvings);
  for (int attempts = 0; now_ != until; ++attempts) {
    if (attempts == kMostWalked || rejected_ >= kMostRejected) return false;
    if (std::abs(now_ - change) < std::abs(until - change)) state_.forget();
    const double left = until - now_;
    if (try_step(std::abs(left) <= h ? until : now_ + std::copysign(h, left), Attempt::Branch::inside).ok()) {
      h *= 2;
    } else if ((h /= 2) < shortest) {
      return false;
    }
  }
  return true;
}

std::vector<double> Continuation::posture() const {
  std::vector<double> all = system_.guess;
  for (std::size_t c = 0; c < all.size(); ++c) {
    if (layout_.address[c] >= 0) all[c] = state_.at(0)[layout_.address[c]];
  }
  return all;
}

}  // namespace assur
