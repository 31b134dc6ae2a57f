#include "status_text.hpp"

#include <algorithm>

#include "decimal.hpp"

namespace assur {
namespace {

// Times have more digits than other numbers, so that an event can be found by its time.
std::string moment(double t) { return general(t, 10); }

}  // namespace

std::string explained(Code code) {
  std::string text(explanation(code));
  if (code != Code::ok && text != name(code)) text += " (" + std::string(name(code)) + ")";
  return text;
}

std::string why_stopped(const Status& status, const std::vector<Event>& events, double reached) {
  const auto at = std::find_if(events.rbegin(), events.rend(), [&](const Event& e) { return e.kind == status.code; });
  // The last event stopped the motion, unless the step is only inaccurate: then others may follow.
  const bool is_told = at != events.rend() && (at == events.rbegin() || status.code == Code::inaccurate);
  if (!is_told) return "after t = " + moment(reached) + " s: " + explained(status.code);
  const Event& e = *at;
  return time_of(e) + place_of(e) + ": " + explained(status.code) + (e.detail.empty() ? "" : ": " + e.detail);
}

std::string place_of(Code kind, const std::string& name) {
  if (name.empty()) return "";
  if (kind == Code::actuator_zero) return ", driver " + name;
  if (kind == Code::limit_reached || kind == Code::limit_exceeded || kind == Code::within_limits) {
    return ", limit of " + name;
  }
  return kind == Code::inconsistent ? ", '" + name + "'" : ", group " + name;
}

std::string place_of(const Event& e) {
  std::string text = place_of(e.kind, e.group);
  if (e.kind != Code::inconsistent || text.empty()) return text;
  return text + " off by " + general(e.figure, 6) + (e.unit.empty() ? "" : " " + e.unit);
}

std::string time_of(const Event& event) {
  std::string text = "t = " + moment(event.time);
  if (event.until != event.time) text += " ... " + moment(event.until);
  return text + " s";
}

}  // namespace assur
