#include "output/status_text.hpp"

#include <algorithm>

#include "decimal.hpp"
#include "output/format.hpp"

namespace assur::output {
namespace {

// Times have more digits than other numbers, so that an event can be found by its time.
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
      return "the estimated error exceeds the required accuracy";
    case Code::branch_unknown:
      return "it could not be decided which branch continues the motion; if a row lies at or very near a posture in "
             "which branches cross, choose another step or start time";
    case Code::inconsistent:
      return "a redundant equation is no longer satisfied";
    case Code::out_of_range:
      return "a time lies outside the table of a law";
    case Code::actuator_zero:
      return "a driven distance, or the lever of a driven angle, has reached zero";
    case Code::deadline:
      return "the step did not finish within its time limit";
    case Code::interrupted:
      return "interrupted";
    case Code::stop_reached:
      return "a limit of the scene ends the motion";
    case Code::limit_exceeded:
      return "the quantity leaves its limit";
    case Code::within_limits:
      return "the quantity returns into its limit";
    case Code::wrong_function:
      return "the derivatives of a law or callback of the program do not match its values";
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
  // The last event stopped the motion, unless the step is only inaccurate: then others may follow.
  const bool is_told = at != events.rend() && (at == events.rbegin() || status.code == Code::inaccurate);
  if (!is_told) return "after t = " + moment(reached) + " s: " + explained(status.code);
  const Event& e = *at;
  return time_of(e) + place_of(e) + ": " + explained(status.code) + (e.detail.empty() ? "" : ": " + e.detail);
}

std::string place_of(const Event& e) {
  if (e.group.empty()) return "";
  if (e.kind == Code::actuator_zero) return ", driver " + e.group;
  if (e.kind == Code::stop_reached || e.kind == Code::limit_exceeded || e.kind == Code::within_limits) {
    return ", limit of " + e.group;
  }
  if (e.kind != Code::inconsistent) return ", group " + e.group;
  return ", '" + e.group + "' off by " + number(e.figure) + (e.unit.empty() ? "" : " " + e.unit);
}

std::string time_of(const Event& event) {
  std::string text = "t = " + moment(event.time);
  if (event.until != event.time) text += " ... " + moment(event.until);
  return text + " s";
}

}  // namespace assur::output
