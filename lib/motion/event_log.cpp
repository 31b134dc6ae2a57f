#include "motion/event_log.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "index.hpp"
#include "motion/continuation.hpp"

namespace assur {
namespace {

// Not in a function: its first call, in a step, would take memory.
const std::string kNone;

}  // namespace

void EventLog::clear() {
  kept_.clear();
  kept_.reserve(kMost + kOfOneStep);
  told_ = 0;
  dropped_ = 0;
  is_bounded_ = false;
}

void EventLog::add(Noticed event) {
  if (is_bounded_ && kept_.size() == kept_.capacity()) drop(kMost / 2);
  kept_.push_back(std::move(event));
}

Noticed* EventLog::last(std::int64_t from) {
  if (kept_.empty() || end() <= from) return nullptr;
  told_ = std::min(told_, kept_.size() - 1);
  return &kept_.back();
}

void EventLog::drop(std::size_t count) {
  kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(count));
  told_ = 0;
  dropped_ += static_cast<std::int64_t>(count);
}

// ---- the events of a continuation

// Joins an event with the last one if both belong to the same change point. The same failure in the next step replaces
// the last one: the bracket of its time belongs to one way only.
void Continuation::record(Noticed event, double step) {
  event.structure = prepared_.structure;
  Noticed* const before = events_.last(joined_from_);
  if (before != nullptr && before->kind == event.kind && name_of(*before) == name_of(event) &&
      std::abs(event.time - before->until) <= step) {
    if (event.kind == Code::change_point_passed) {
      event.time = before->time;
      event.figure = std::min(before->figure, event.figure);
    }
    *before = std::move(event);
    return;
  }
  events_.add(std::move(event));
}

Noticed Continuation::about_limit(const LimitWatch::Change& change) const {
  Noticed event{change.from, change.until, {}, conditions_.limits()->kind(change), system_.bounds[change.bound].value};
  event.bound = static_cast<std::int32_t>(change.bound);
  return event;
}

// Names of drivers and limits belong to the scene, those of groups to the structure at that time.
const std::string& Continuation::name_of(const Noticed& event) const {
  if (event.told) return event.told->group;
  if (event.bound >= 0) return system_.measures[idx(system_.bounds[idx(event.bound)].measure)].name;
  if (event.watched >= 0) return event.structure->watched[idx(event.watched)].name;
  if (event.about.is(Place::Kind::group)) return event.structure->groups[idx(event.about.index)].name;
  if (event.about.is(Place::Kind::driver)) return system_.drivers[idx(event.about.index)];
  if (event.about.is(Place::Kind::target)) return inputs_.controls()[idx(event.about.index)].name;
  return kNone;
}

Event Continuation::in_words(const Noticed& event) const {
  Event out{event.time, event.until, name_of(event), event.kind, event.figure};
  if (event.told) out.detail = event.told->detail, out.unit = event.told->unit;
  if (event.bound >= 0) {
    Event of_limit = conditions_.limits()->event({idx(event.bound), event.kind != Code::within_limits, 0, 0});
    out.detail = std::move(of_limit.detail);
    out.unit = std::move(of_limit.unit);
  }
  if (event.watched >= 0 && event.structure->watched[idx(event.watched)].is_length) out.unit = "m";
  return out;
}

}  // namespace assur
