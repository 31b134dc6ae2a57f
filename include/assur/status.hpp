// Two channels of failure. Misuse and bad input throw assur::Error, which says where, what and what instead.
// Numerical outcomes are a [[nodiscard]] Status with figures. The library never prints and never aborts.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// One finding about the input.
struct Diagnostic {
  std::string where;  // JSON pointer into the scene, e.g. "/constraints/coupler/distance/1"; "" = the whole scene
  std::string what;   // what is wrong and what would be right, one sentence
};

// Thrown for bad input and misuse. what() lists every diagnostic, one a line: "where: what", or "source: where: what"
// where `source` names the file they are about; diagnostics() stay without it.
class Error : public std::runtime_error {
 public:
  enum class Kind : std::uint8_t {
    input,        // bad usage or bad scene
    numerical,    // the mechanism cannot be assembled, is undetermined, ...
    environment,  // a backend that cannot run here, no memory, a file that cannot be read
  };

  Error(Kind kind, std::vector<Diagnostic> diagnostics, std::string_view source = {});
  Error(Kind kind, std::string what) : Error(kind, {Diagnostic{"", std::move(what)}}) {}

  [[nodiscard]] Kind kind() const noexcept { return kind_; }
  [[nodiscard]] const std::vector<Diagnostic>& diagnostics() const noexcept { return diagnostics_; }

 private:
  Kind kind_;
  std::vector<Diagnostic> diagnostics_;
};

// Outcome of a numerical operation. The names are part of the command's JSON and are never renamed.
enum class Code : std::uint8_t {
  ok,
  singular,             // a matrix without a usable pivot
  not_finite,           // NaN or Inf among the values
  not_converged,        // Newton did not reach the tolerance
  limit_reached,        // a fold: the mechanism cannot move further; time is bracketed
  change_point_passed,  // two branches cross here; the smooth continuation was taken
  inaccurate,           // accepted, but the estimated error exceeds the accuracy asked for
  branch_unknown,       // which branch continues the motion could not be decided
  inconsistent,         // a redundant equation is no longer satisfied
  out_of_range,         // a law was asked for a time outside its table
  actuator_zero,        // a driven distance reached zero, or the directions of a driven angle: it drives nothing there
  deadline,             // the time allowed for the step ran out
  interrupted,          // the observer asked to stop
  wrong_function,       // derivatives that a law or a callback of the program gives are not those of its values
};

[[nodiscard]] std::string_view name(Code code) noexcept;

// The object that a status is about.
struct Place {
  enum class Kind : std::uint8_t {
    none,
    driver,  // index: of Scene::drivers
    group,   // of Structure::groups
    lane,    // of a linear solver, or of variants that are solved side by side
    member,  // of an ensemble
  };
  Kind kind = Kind::none;
  std::int32_t index = -1;

  [[nodiscard]] static constexpr Place driver(std::int32_t i) noexcept { return {Kind::driver, i}; }
  [[nodiscard]] static constexpr Place group(std::int32_t i) noexcept { return {Kind::group, i}; }
  [[nodiscard]] static constexpr Place lane(std::int32_t i) noexcept { return {Kind::lane, i}; }
  [[nodiscard]] static constexpr Place member(std::int32_t i) noexcept { return {Kind::member, i}; }

  [[nodiscard]] constexpr bool is(Kind k) const noexcept { return kind == k; }
  friend constexpr bool operator==(const Place&, const Place&) = default;
};

struct [[nodiscard]] Status {
  Code code = Code::ok;
  Place where;
  double figure = 0;        // pivot, residual, contraction, ...: what the code is about

  [[nodiscard]] constexpr bool ok() const noexcept { return code == Code::ok; }
  // What was asked for is there, if not as accurate.
  [[nodiscard]] constexpr bool arrived() const noexcept { return ok() || code == Code::inaccurate; }
};

}  // namespace assur
