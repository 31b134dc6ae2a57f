// Events of a motion as its steps notice them: names and texts are looked up when the report is read, so that a step
// that fails allocates nothing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "assur/report.hpp"
#include "outputs/columns.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// An Event without texts.
struct Noticed {
  double time = 0, until = 0;
  Place about;  // Event::group names it
  Code kind = Code::ok;
  double figure = 0;
  std::int32_t bound = -1;    // of System::bounds, if the event is about a limit
  std::int32_t watched = -1;  // of GroupedSystem::watched, if a redundant equation no longer holds
  Missing missing = {};       // of the first inaccurate row
  std::shared_ptr<const GroupedSystem> structure = {};  // its groups and watched equations
  std::unique_ptr<Event> told = {};                     // texts that cannot be looked up; null: none

  // An event with its texts; allocates.
  [[nodiscard]] static Noticed all_of(Event event) {
    Noticed n{event.time, event.until, {}, event.kind, event.figure};
    n.told = std::make_unique<Event>(std::move(event));
    return n;
  }
};

// Events name the group of a status, but no other object.
[[nodiscard]] inline Place only_group(Place place) { return place.is(Place::Kind::group) ? place : Place(); }

// The events of a run, or the latest ones of single steps. Positions count all events, including dropped ones.
class EventLog {
 public:
  // Begins anew, as the log of a run, which keeps all events and grows.
  void clear();
  // Before a single step: bounds the memory. Within the step no memory is added.
  void bound() {
    is_bounded_ = true;
    if (kept_.size() >= kMost) drop(kept_.size() - kMost / 2);
  }

  [[nodiscard]] std::int64_t end() const { return dropped_ + std::ssize(kept_); }
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }
  void add(Noticed event);
  // The last event, to be changed; null if it lies before this position.
  [[nodiscard]] Noticed* last(std::int64_t from = 0);
  // Removes the events of [from, until) for which remove() is true.
  template <class Remove>
  void erase(std::int64_t from, std::int64_t until, const Remove& remove) {
    const auto at = [&](std::int64_t k) { return kept_.begin() + std::max<std::int64_t>(k - dropped_, 0); };
    told_ = std::min(told_, static_cast<std::size_t>(at(from) - kept_.begin()));
    kept_.erase(std::remove_if(at(from), at(until), remove), at(until));
  }
  // Brings the report up to date. in_words: the event with its texts
  template <class InWords>
  void write_to(Report& report, const InWords& in_words) {
    report.events.resize(told_);
    for (; told_ < kept_.size(); ++told_) report.events.push_back(in_words(kept_[told_]));
    report.dropped_events = dropped_;
  }

 private:
  static constexpr std::size_t kMost = 1000;     // of single steps; then the older half is dropped
  static constexpr std::size_t kOfOneStep = 64;  // a step that notices more drops older ones, too
  void drop(std::size_t count);

  std::vector<Noticed> kept_;
  std::size_t told_ = 0;  // events that the report holds as they are
  std::int64_t dropped_ = 0;
  bool is_bounded_ = false;
};

}  // namespace assur
