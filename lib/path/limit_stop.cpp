// The limits of a scene along a motion: events where a quantity leaves or enters one, and the end of the motion.
#include <cmath>
#include <utility>

#include "path/continuation.hpp"

namespace assur {

void Continuation::begin_limits(const Continuation* before) {
  if (!limit_watch_) return;
  const double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  const std::vector<double> known = before != nullptr ? before->limited() : prepared_.start_limits;
  limit_watch_->start(q, now_, known);
  if (!known.empty()) return;  // the motion has begun before
  for (const std::size_t i : limit_watch_->violated()) {
    const LimitWatch::Change outside{i, true, now_, now_};
    if (limit_watch_->ends(outside)) {
      throw Error(Error::Kind::numerical, "the start posture violates a limit: " + limit_watch_->describe(i) +
                                              "; start elsewhere, or give the limit the reaction \"flag\"");
    }
    events_.add(about_limit(outside));
  }
}

// Checks the way to the posture at hand, which was solved and is not accepted yet. Where a motion ends, the last
// posture within the limit is accepted instead.
Status Continuation::check_limits(double target, StepErrors& errors) {
  const double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  if (passes_) return {};
  const bool may_change = limit_watch_->may_change(q, target);
  if (!any_turn_ && limit_watch_->hides_change(bows_.times())) {
    undo_attempt();
    return hidden();
  }
  if (!may_change) return {};
  undo_attempt();
  const std::span<const LimitWatch::Change> changes = limit_watch_->changes([&](double t) -> const double* {
    predict(t);
    StepErrors ignored;
    return solve_at(t, Attempt::Branch::anywhere, ignored).ok() ? state_.at(0) : nullptr;
  });
  const bool ends = !changes.empty() && limit_watch_->ends(changes.back());
  const double to = ends ? changes.back().from : target;
  if (ends) tell_before_dividing();
  errors = {};
  Status s;
  if (to != now_) {
    predict(to);
    s = solve_at(to, Attempt::Branch::inside, errors);
    const double* const there[3] = {state_.at(0), state_.at(1), state_.at(2)};
    if (s.ok()) (void)limit_watch_->may_change(there, to);
    if (s.ok() && ends) accept(to, errors);
  }
  if (!ends && !s.ok()) return s;
  for (const LimitWatch::Change& c : changes) events_.add(about_limit(c));
  return ends ? limit_watch_->status(changes.back()) : Status{};
}

// Checks the way over a change point, whose postures are accepted already.
Status Continuation::check_limits_passed(double change) {
  if (!limit_watch_) return {};
  const double to = now_;
  const double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  if (limit_watch_->may_change(q, to)) {
    const std::span<const LimitWatch::Change> changes = limit_watch_->changes([](double) { return nullptr; });
    for (const LimitWatch::Change& c : changes) events_.add(about_limit(c));
    if (!changes.empty() && limit_watch_->ends(changes.back())) {
      passes_ = true;
      (void)walk(change, to - change, change);
      passes_ = false;
      state_.restore();
      return limit_watch_->status(changes.back());
    }
  }
  limit_watch_->accept();
  return {};
}

}  // namespace assur
