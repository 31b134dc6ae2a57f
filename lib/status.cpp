#include "assur/status.hpp"

namespace assur {
namespace {

std::string join(const std::vector<Diagnostic>& diagnostics, std::string_view source) {
  std::string lines;
  for (const Diagnostic& diagnostic : diagnostics) {
    if (!lines.empty()) lines += '\n';
    if (!source.empty()) lines += std::string(source) + ": ";
    if (!diagnostic.where.empty()) lines += diagnostic.where + ": ";
    lines += diagnostic.what;
  }
  return lines;
}

}  // namespace

Error::Error(Kind kind, std::vector<Diagnostic> diagnostics, std::string_view source)
    : std::runtime_error(join(diagnostics, source)), kind_(kind), diagnostics_(std::move(diagnostics)) {}

std::string_view name(Code code) noexcept {
  switch (code) {
    case Code::ok:
      return "ok";
    case Code::singular:
      return "singular";
    case Code::not_finite:
      return "not_finite";
    case Code::not_converged:
      return "not_converged";
    case Code::fold:
      return "fold";
    case Code::change_point_passed:
      return "change_point_passed";
    case Code::inaccurate:
      return "inaccurate";
    case Code::branch_unknown:
      return "branch_unknown";
    case Code::inconsistent:
      return "inconsistent";
    case Code::out_of_range:
      return "out_of_range";
    case Code::actuator_zero:
      return "actuator_zero";
    case Code::deadline:
      return "deadline";
    case Code::interrupted:
      return "interrupted";
    case Code::limit_reached:
      return "limit_reached";
    case Code::limit_exceeded:
      return "limit_exceeded";
    case Code::within_limits:
      return "within_limits";
    case Code::not_assembled:
      return "not_assembled";
    case Code::near_singular:
      return "near_singular";
  }
  return "unknown";
}

std::string_view explanation(Code code) noexcept {
  switch (code) {
    case Code::ok:
      return "done";
    case Code::singular:
      return "the equations are singular";
    case Code::not_finite:
      return "a value is not finite";
    case Code::not_converged:
      return "Newton's method did not converge";
    case Code::fold:
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
    case Code::limit_reached:
      return "a limit of the scene ends the motion";
    case Code::limit_exceeded:
      return "the quantity leaves its limit";
    case Code::within_limits:
      return "the quantity returns into its limit";
    case Code::not_assembled:
      return "the start posture cannot be assembled";
    case Code::near_singular:
      return "the motion passed close to a singular posture, where rates change quickly";
  }
  return "unknown";
}

}  // namespace assur
