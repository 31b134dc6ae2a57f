#include "motion/continuation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "assur/status.hpp"
#include "decimal.hpp"
#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "motion/near_pass.hpp"
#include "numbers.hpp"
#include "program/step_rules.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

constexpr double kPassed = 64;   // ratio to the first shortest step from which on a step has passed the failure
constexpr int kExpandAfter = 4;  // rejected attempts in a row; then all rates are computed and used for predictions

bool worth_halving(Code code) {
  return code == Code::branch_unknown || code == Code::not_converged || code == Code::singular ||
         code == Code::not_finite;
}

// Where to start instead of a posture at which branches cross.
std::string start_beside(const System& system, double time) {
  constexpr double kBeside = 0.1;  // rad, or characteristic lengths; a choice
  std::string example;
  for (const DriverInput& in : system.inputs) {
    if (in.laws.size() != 1) continue;
    const Motion now = in.laws[0](time);
    const std::string unit = in.kind == DriverInput::Kind::direction ? " rad" : in.dimension == 1 ? " m" : "";
    const double here = now.value - in.zero, by = std::copysign(kBeside * system.unit(in.dimension), now.rate);
    example = ", for example with " + in_quotes(system.drivers[idx(in.driver)]) + " at " + general(here + by, 6) +
              unit + " instead of " + general(here, 6) + unit;
    if (now.rate != 0) break;
  }
  return "; branches cross there: draw the mechanism in another posture of its motion" + example +
         ", and begin the law there, too";
}

}  // namespace

Continuation::Continuation(const Preparation& prepared, const StepSettings& settings, Report& report, EventLog& events)
    : prepared_(prepared),
      settings_(settings),
      report_(report),
      events_(events),
      structure_(*prepared.structure),
      system_(*structure_.system),
      inputs_(system_, prepared.controlled),
      layout_(lay_out(prepared)),
      packs_(layout_.packs),
      levels_(prepared, layout_, settings.pin_to),
      conditions_(structure_, layout_),
      angles_together_(angles_together(system_, structure_)) {
  if (prepared.plan.run.together && !packs_.empty())
    together_ = std::make_unique<Together>(prepared, layout_, levels_.team());
  state_.resize(layout_.first_unknown, layout_.size, prepared.plan.run.predictor);
  conditions_.bind(system_, prepared.reselect != nullptr);
  for (const auto& solver : layout_.solvers) solver->reserve(diagnosis_);
  here_.reads.reserve(diagnosis_.most_read);
  approach_.reserve(diagnosis_.most_read);
  state_.reserve(history_);
  passing_.assign(packs_.size(), 0);
  passed_ = passing_;
  lacks_rates_ = std::any_of(structure_.classes.begin(), structure_.classes.end(),
                             [](const GroupClass& c) { return c.derivatives == 0 || c.first_wanted > 0; });
}

void Continuation::keep_what_is_read(std::vector<std::uint8_t> marked) {
  for (const Pack& pack : packs_) {
    for (const std::int32_t a : pack.inputs) marked[idx(a)] = 1;
  }
  conditions_.mark(marked);
  marked.resize(system_.coordinates.size());  // known coordinates lie at their own index
  inputs_.keep_only(std::move(marked));
  bows_.resize(layout_, inputs_.bends() ? inputs_.laws() : 0, 1);
  for (LaneArray& v : known_) v.assign(inputs_.bends() ? layout_.size : 0, 0.0);
  conditions_.check_inputs(inputs_.evaluated());
  whole_.reset();
  if (prepared_.code != nullptr) use(*prepared_.code);
}

void Continuation::use(StepCode& code) {
  inputs_.use(code);
  const bool on_one_thread = together_ == nullptr && levels_.threads() == 1;
  if (on_one_thread) whole_ = WholeStep::make(layout_, &inputs_.program(), state_, code);
  if (whole_) return;  // what it does not solve is rare
  if (together_) together_->use(code);
  // Those with the most work first, as long as there is time for code.
  std::vector<std::pair<double, GroupSolver*>> by_work;
  for (const auto& solver : layout_.solvers) by_work.emplace_back(0.0, solver.get());
  for (const Pack& pack : packs_) {
    auto& [work, solver] = by_work[idx(pack.group_class)];
    work += pack.used * std::pow(solver->group_class().n, 2);
  }
  std::stable_sort(by_work.begin(), by_work.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [work, solver] : by_work) solver->use(code);
}

std::string Continuation::machine_code() const {
  if (prepared_.code == nullptr) return "";
  const std::string vectors = prepared_.code->vectors();
  if (whole_) return vectors + ", one call for all";
  std::size_t coded = together_ ? together_->coded_groups() : 0;
  for (const Pack& pack : packs_) {
    if (!together_ && layout_.solvers[idx(pack.group_class)]->is_coded(pack)) coded += pack.groups.size();
  }
  if (coded == 0) return "";
  return vectors + ", " + std::to_string(coded) + " of " + std::to_string(structure_.groups.size()) + " groups";
}

void Continuation::start(double time, const std::vector<double>& posture, const Continuation* before) {
  now_ = time;
  selected_at_ = before != nullptr ? time : kNan;
  if (before != nullptr) {
    take_clock(*before);
  } else {
    deadline_ = std::chrono::steady_clock::time_point::max();  // deadlines hold for steps only
  }
  inputs_.reset();
  if (before != nullptr) inputs_.set_controls(before->inputs_.controls());
  conditions_.clear();
  restart_solvers();
  converged_ = kConverged;
  any_turn_ = true;
  bows_.clear();
  leave_change_point();
  state_.clear();
  for (std::size_t c = 0; c < layout_.address.size(); ++c) {
    if (layout_.address[c] >= 0) state_.at(0)[layout_.address[c]] = posture[c];
  }
  repeat_in_idle_lanes();
  if (whole_) whole_->forget();
  StepErrors errors;
  const Status s = solve_at(now_, Attempt::Branch::start, errors);
  if (!s.ok()) {
    const std::size_t at_fault = failed_pack_;
    const auto branches_cross = [&] {
      if (at_fault == packs_.size()) return false;
      double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
      Pack& pack = packs_[at_fault];
      levels_.solver(pack).diagnose(pack, q, diagnosis_, here_);
      return here_.status.code == Code::change_point_passed;
    };
    const std::string group = s.where.is(Place::Kind::group) ? " in group " + structure_.name_of(s.where) : "";
    throw Error(Error::Kind::numerical,
                "the start posture has no " + std::string(s.code == Code::singular ? "velocities" : "solution") + ": " +
                    std::string(name(s.code)) + group +
                    (s.code != Code::singular ? ""
                     : branches_cross()       ? start_beside(system_, now_)
                                              : "; the Jacobian is singular there, start elsewhere on the path"));
  }
  if (together_) {
    double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
    together_->start(q);
  }
  conditions_.begin({state_.at(0), state_.at(1), state_.at(2)});
  turn_guessed_ = false;
  accept(now_, errors);
  begin_limits(before);
}

void Continuation::restart_solvers() {
  levels_.restart();
  for (Pack& pack : packs_) {
    pack.restarts = true;
    pack.factored = false;
  }
  forget_guards();
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
  into.converged = in_step ? at_begin_.converged : converged_;
  into.time = now_;
  into.selected_at = selected_at_;
  into.turn_guessed = in_step ? at_begin_.turn_guessed : turn_guessed_;
  conditions_.save(into.conditions, in_step, report_.counters.branch_checks);
  into.angles = inputs_.program().accepted_angles();
  bows_.save(into.bows, report_.counters.branch_checks);
  into.change_point_at = change_point_at_;
  into.change_points.clear();
  if (!std::isnan(change_point_at_)) into.change_points = layout_.change_points;
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
  if (whole_) whole_->forget();
  inputs_.set_controls(from.controls);
  for (std::size_t p = 0; p < packs_.size(); ++p) packs_[p].restore(from.packs[p]);
  forget_guards();
  last_errors_ = from.errors;
  converged_ = from.converged;
  report_.reached = now_ = from.time;
  selected_at_ = from.selected_at;
  turn_guessed_ = from.turn_guessed;
  conditions_.restore(from.conditions, now_, report_.counters.branch_checks);
  inputs_.program().accept(from.angles);
  bows_.restore(from.bows, report_.counters.branch_checks);
  leave_change_point();
  if (!from.change_points.empty()) layout_.change_points = from.change_points;
  change_point_at_ = from.change_point_at;
  wants_reselection_ = false;
}

bool Continuation::ask_again_from_rest() {
  if (!inputs_.ask_again_from_rest(now_)) return false;
  state_.stand_still();
  return true;
}

void Continuation::rest() {
  if (!inputs_.stop(now_)) return;
  state_.stand_still();
  state_.restore();
}

void Continuation::announce_division() {
  if (!std::exchange(divided_, true) && before_dividing_) before_dividing_();
}

void Continuation::repeat_in_idle_lanes() {
  for (const Pack& pack : packs_) {
    const int w = levels_.solver(pack).lanes();
    double* x = state_.at(0) + pack.unknowns;
    for (std::int32_t i = 0; i < levels_.solver(pack).group_class().n; ++i) {
      for (int lane = pack.used; lane < w; ++lane) x[i * w + lane] = x[i * w];
    }
  }
}

void Continuation::set_deadline() {
  constexpr double kLongestTime = 1e9;  // 30 years; the clock counts nanoseconds up to 300
  deadline_ = clock_() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                             std::chrono::duration<double>(std::min(settings_.seconds, kLongestTime)));
}

// ---- one step

Status Continuation::step_to(double t, bool may_reselect, Stride& stride) {
  wants_reselection_ = false;
  divided_ = false;
  if (t == now_) return {};
  if (!std::isfinite(t) || !inputs_.controls().empty()) {
    if (const Status s = check_aim(t); !s.ok()) return s;
  }
  at_begin_ = {converged_, turn_guessed_};
  conditions_.begin_step();
  bows_.begin_step();
  Status status;
  try {
    inputs_.begin_step(now_, t);
    status = advance(t, may_reselect, stride);
  } catch (...) {  // from a law or a callback
    std::fill(passing_.begin(), passing_.end(), 0);
    passes_ = wants_reselection_ = false;
    over_ = nullptr;
    inputs_.follow();
    announce_division();
    end_step(false);
    throw;
  }
  end_step(status.ok());
  return status;
}

// Steps from posture to posture until t.
Status Continuation::advance(double t, bool may_reselect, Stride& stride) {
  const double span = t - now_, first = std::abs(span) * kSmallestStep;
  any_turn_ = turn_guessed_ = expands_ = false;
  shortest_ = first;
  approach_.clear();
  largest_correction_ = WalkRules::kSureOfBranch;
  if (on_change_point()) expand();
  NearPass near;
  int in_a_row = 0;  // attempts that were rejected; from kExpandAfter on the count is kept
  for (bool is_first = true; now_ != t; is_first = false) {
    if (!is_first && settings_.stop && settings_.stop()) return {Code::interrupted, {}, now_};
    const double before = now_;
    const double h = std::copysign(std::min(stride.length, std::abs(span)), span);
    const double target = std::abs(t - now_) <= std::abs(h) * 1.0000001 ? t : now_ + h;
    if (in_a_row >= kExpandAfter) expand();
    any_turn_ = std::abs(h) <= shortest_ * 1.5;
    const Status s = try_step(target, Attempt::Branch::inside);
    if (s.ok()) {
      if (in_a_row < kExpandAfter) in_a_row = 0;
      if (expands_) near.see(bend(), before, now_);
      if (now_ == t) break;  // a last stride that was shortened is no evidence for full strides
      stride.arrive();
      if (stride.length > kPassed * first) {  // the failure was passed
        shortest_ = first;
        approach_.clear();
      }
      ++report_.counters.substeps;
      if (may_choose_anew(may_reselect, first) && set_is_poor()) {
        wants_reselection_ = true;
        return {Code::singular, {}, conditions_.largest_coefficient(state_.at(0), report_.counters.branch_checks)};
      }
      continue;
    }
    if (!divided_) near.begin(bend());
    announce_division();
    if (s.code == Code::limit_reached) return s;
    if (turned_ > 1) {
      stride.set(std::max(std::abs(target - now_) / std::ceil(turned_), shortest_));
      continue;
    }
    ++report_.counters.rejected;
    ++in_a_row;
    near.fail(only_group(s.where));
    if (rejected_ >= kMostRejected) {
      record({now_, target, only_group(s.where), Code::branch_unknown, s.figure}, std::abs(t - target));
      return {Code::branch_unknown, s.where, s.figure};
    }
    // Close to a singularity of the solved equations, the watched equations fail first.
    if (s.code == Code::inconsistent && may_choose_anew(may_reselect, first) &&
        conditions_.another_set_may_help(state_.accepted(0))) {
      wants_reselection_ = true;
      return s;
    }
    const bool vanished = s.code == Code::actuator_zero;
    const bool halves =
        vanished || s.code == Code::inconsistent || (worth_halving(s.code) && failed_pack_ != packs_.size());
    if (!halves) {
      record_stop(s, target);
      return s;
    }
    if (std::abs(h) > shortest_ * 1.5) {
      stride.set(std::abs(target - now_) / 2);
      continue;
    }
    if (!vanished && may_choose_anew(may_reselect, first) && conditions_.another_set_may_help(state_.accepted(0))) {
      wants_reselection_ = true;
      return s;
    }
    if (vanished || failed_pack_ == packs_.size()) {
      record_stop(s, target);
      return s;
    }
    passes_ = true;
    const Status found = examine_failed_step(s, target, t, first);
    passes_ = false;
    if (!found.ok()) return found;
    if (now_ != before) {
      near.explain();
      if (const Status stop = check_limits_passed(before); !stop.ok()) return stop;
    }
    stride.set(shortest_);
  }
  if (near.is_possible() && near.is_passed(bend())) record(near.event(), std::abs(span));
  return {};
}

// The largest acceleration of an unknown over what the drivers explain in a regular posture: the sum of their largest
// acceleration and the square of their largest rate.
double Continuation::bend() const {
  const auto largest = [&](int d, std::size_t begin, std::size_t end) {
    double out = 0;
    for (std::size_t i = begin; i < end; ++i) out = std::max(out, std::abs(state_.accepted(d)[i]));
    return out;
  };
  const std::size_t known = layout_.first_unknown;
  const double rate = largest(1, 0, known), drivers = rate * rate + largest(2, 0, known);
  return drivers > 0 ? largest(2, known, layout_.size) / drivers : 0;
}

// If a step did not arrive, the last good posture is kept, which may lie on its way.
void Continuation::end_step(bool arrived) {
  if (!arrived) state_.restore();
  inputs_.end_step(now_, wants_reselection_);
  if (arrived) ++report_.counters.steps;
}

bool Continuation::polish(double converged) {
  if (converged == 0 && settings_.iterations > 0) return false;
  converged_ = converged;
  state_.restore();
  StepErrors errors;
  if (!solve_at(now_, Attempt::Branch::inside, errors).ok()) {
    state_.restore();
    return false;
  }
  state_.replace();
  conditions_.accept(0, true);
  last_errors_ = errors;
  return true;
}

// Checks the target. A driver whose target is not finite is named in an event, and nothing moves.
Status Continuation::check_aim(double t) {
  if (!std::isfinite(t)) {
    inputs_.drop_pending();
    return {Code::not_finite, {}, t};
  }
  double value = 0;
  const std::int32_t driver = inputs_.not_finite(value);
  if (driver < 0) return {};
  record({now_, t, Place::target(driver), Code::not_finite, value}, std::abs(t - now_));
  inputs_.drop_pending();
  return {Code::not_finite, Place::target(driver), value};
}

// No set is chosen again close to the last choice: near a fold no set helps, and sets would alternate.
bool Continuation::may_choose_anew(bool asked, double first) const {
  return asked && prepared_.reselect && !(std::abs(now_ - selected_at_) <= kPassed * first);
}

// The code of a whole step predicts for itself.
void Continuation::predict(double target, Attempt::Branch branch) {
  if (over_ != nullptr) {
    state_.begin_prediction(*over_, target, prediction_);
  } else if (expands_) {
    state_.begin_expansion(target, prediction_);
  } else {
    state_.begin_prediction(target, prediction_);
  }
  is_predicted_ = !whole_ || over_ != nullptr || !is_usual(branch);
  if (is_predicted_) combine();
}

void Continuation::combine() {
  levels_.share(state_.unknowns(), [&](std::size_t part, std::size_t parts) {
    state_.predict(prediction_, state_.unknowns() * part / parts, state_.unknowns() * (part + 1) / parts);
  });
}

// Until the end of the step, rates of all unknowns are computed, wanted or not, and predictions use the last posture
// and its derivatives, whatever the predictor is. A motion in doubt then continues in the same way for every strategy.
void Continuation::expand() {
  if (std::exchange(expands_, true) || !lacks_rates_) return;
  state_.restore();
  StepErrors errors;
  if (solve_at(now_, Attempt::Branch::inside, errors).ok()) state_.replace();
  state_.restore();
}

Status Continuation::try_step(double target, Attempt::Branch branch) {
  predict(target, branch);
  StepErrors errors;
  Status s = solve_at(target, branch, errors);
  if (s.code == Code::inconsistent && converged_ > kConverged) {  // or it was not solved exactly enough to decide
    converged_ = kConverged;
    predict(target, branch);
    errors = {};
    s = solve_at(target, branch, errors);
  }
  if (s.ok() && conditions_.limits() != nullptr) s = check_limits(target, errors);
  if (s.ok()) {
    accept(target, errors);
  } else if (turned_ <= 1 && s.code != Code::limit_reached) {
    ++rejected_;
  }
  return s;
}

std::vector<double> Continuation::posture() const {
  std::vector<double> all = system_.guess;
  for (std::size_t c = 0; c < all.size(); ++c) {
    if (layout_.address[c] >= 0) all[c] = state_.at(0)[layout_.address[c]];
  }
  return all;
}

}  // namespace assur
