// The limits of a scene along a motion: events where a quantity leaves or enters one, and the end of the motion.
#include <cmath>
#include <utility>

#include "motion/continuation.hpp"

namespace assur {

void Continuation::begin_limits(const Continuation* before) {
  const std::vector<double> known = before != nullptr ? before->limited() : prepared_.start_limits;
  for (const LimitWatch::Change& outside :
       conditions_.begin_limits({state_.at(0), state_.at(1), state_.at(2)}, now_, known)) {
    const LimitWatch& limits = *conditions_.limits();
    if (limits.ends(outside)) {
      throw Error(Error::Kind::numerical, "the start posture violates a limit: " + limits.describe(outside.bound) +
                                              "; start elsewhere, or give the limit the reaction \"flag\"");
    }
    events_.add(about_limit(outside));
  }
}

// Checks the way to the posture at hand, which was solved and is not accepted yet. Where a motion ends, the last
// posture within the limit is accepted instead.
Status Continuation::check_limits(double target, StepErrors& errors) {
  if (passes_) return {};
  const double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  LimitWatch* const limit_watch = conditions_.limits();
  const bool may_change = limit_watch->may_change(q, target);
  if (!any_turn_ && limit_watch->hides_change(bows_.times())) {
    undo_attempt();
    return hidden();
  }
  if (!may_change) return {};
  undo_attempt();
  const std::span<const LimitWatch::Change> changes = limit_watch->changes([&](double t) -> const double* {
    predict(t, Attempt::Branch::anywhere);
    StepErrors ignored;
    return solve_at(t, Attempt::Branch::anywhere, ignored).ok() ? state_.at(0) : nullptr;
  });
  const bool ends = !changes.empty() && limit_watch->ends(changes.back());
  const double to = ends ? changes.back().from : target;
  if (ends) announce_division();
  errors = {};
  Status s;
  if (to != now_) {
    predict(to, Attempt::Branch::inside);
    s = solve_at(to, Attempt::Branch::inside, errors);
    const double* const there[3] = {state_.at(0), state_.at(1), state_.at(2)};
    if (s.ok()) (void)limit_watch->may_change(there, to);
    if (s.ok() && ends) accept(to, errors);
  }
  if (!ends && !s.ok()) return s;
  for (const LimitWatch::Change& c : changes) events_.add(about_limit(c));
  return ends ? limit_watch->status(changes.back()) : Status{};
}

// Checks the way over a change point, whose postures are accepted already.
Status Continuation::check_limits_passed(double change) {
  LimitWatch* const limit_watch = conditions_.limits();
  if (limit_watch == nullptr) return {};
  const double to = now_;
  const double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  if (limit_watch->may_change(q, to)) {
    const std::span<const LimitWatch::Change> changes = limit_watch->changes([](double) { return nullptr; });
    for (const LimitWatch::Change& c : changes) events_.add(about_limit(c));
    if (!changes.empty() && limit_watch->ends(changes.back())) {
      passes_ = true;
      (void)walk(change, to - change, change);
      passes_ = false;
      state_.restore();
      return limit_watch->status(changes.back());
    }
  }
  limit_watch->accept();
  return {};
}

}  // namespace assur
