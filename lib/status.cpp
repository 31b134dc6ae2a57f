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
    case Code::limit_reached:
      return "limit_reached";
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
    case Code::stop_reached:
      return "stop_reached";
    case Code::limit_exceeded:
      return "limit_exceeded";
    case Code::within_limits:
      return "within_limits";
    case Code::wrong_function:
      return "wrong_function";
  }
  return "unknown";
}

}  // namespace assur
