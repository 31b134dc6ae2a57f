#include "output/status_text.hpp"

#include <algorithm>

#include "decimal.hpp"
#include "output/format.hpp"

namespace assur::output {
namespace {

// Times need more digits than other numbers: an event is looked up by its time.
std::string moment(double t) { return general(t, 10); }

std::string_view meaning(Code code) {
  switch (code) {
    case Code::ok:
      return "done";
    case Code::singular:
      return "the equations are singular";
    case Code::not_finite:
      return "a value is not finite";
    case Code::not_converged:
      return "Newton's method did not converge";
    case Code::limit_reached:
      return "the mechanism cannot move further";
    case Code::change_point_passed:
      return "two branches cross; the smooth continuation was taken";
    case Code::inaccurate:
      return "the estimated error exceeds the accuracy asked for";
    case Code::branch_unknown:
      return "which branch continues the motion could not be decided; where a row lies at, or very near, a posture in "
             "which branches cross, another step or start time avoids it";
    case Code::inconsistent:
      return "a redundant equation is no longer satisfied";
    case Code::out_of_range:
      return "a law was asked for a time outside its table";
    case Code::actuator_zero:
      return "a driven distance, or the lever of a driven angle, has reached zero";
    case Code::deadline:
      return "the time allowed for the step ran out";
    case Code::interrupted:
      return "interrupted";
    case Code::wrong_function:
      return "derivatives that a law or a callback of the program gives are not those of its values";
  }
  return "unknown";
}

}  // namespace

std::string explained(Code code) {
  std::string text(meaning(code));
  if (code != Code::ok && text != name(code)) text += " (" + std::string(name(code)) + ")";
  return text;
}

std::string why_stopped(const Status& status, const std::vector<Event>& events, double reached) {
  const auto at = std::find_if(events.rbegin(), events.rend(), [&](const Event& e) { return e.kind == status.code; });
  // What stopped a motion is its last event; after an inaccurate step others may follow.
  const bool is_told = at != events.rend() && (at == events.rbegin() || status.code == Code::inaccurate);
  if (!is_told) return "after t = " + moment(reached) + " s: " + explained(status.code);
  const Event& e = *at;
  return time_of(e) + place_of(e) + ": " + explained(status.code) + (e.detail.empty() ? "" : ": " + e.detail);
}

std::string place_of(const Event& e) {
  if (e.group.empty()) return "";
  if (e.kind == Code::actuator_zero) return ", driver " + e.group;
  if (e.kind != Code::inconsistent) return ", group " + e.group;
  return ", '" + e.group + "' off by " + number(e.figure) + (e.unit.empty() ? "" : " " + e.unit);
}

std::string time_of(const Event& event) {
  std::string text = "t = " + moment(event.time);
  if (event.until != event.time) text += " ... " + moment(event.until);
  return text + " s";
}

}  // namespace assur::output
