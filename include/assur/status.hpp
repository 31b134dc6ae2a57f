// The two channels of failure. Misuse and bad input throw assur::Error, which names location, problem and remedy.
// Numerical operations return a [[nodiscard]] Status with a figure. The library never prints and never aborts.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// One finding about the input.
struct Diagnostic {
  std::string where;  // JSON pointer, also if no file was read: "/constraints/coupler/distance/1"; "": the whole scene
  std::string what;   // one sentence: the problem and its remedy
};

// The exception for bad input and misuse. what() has one line for each diagnostic: "where: what".
class Error : public std::runtime_error {
 public:
  // The cause of the error.
  enum class Kind : std::uint8_t {
    input,        // wrong use of the library, or a wrong scene; an undetermined mechanism is a wrong scene
    numerical,    // a computation that fails, e.g. the assembly of a mechanism
    environment,  // the machine: a backend that cannot run here, no memory, a file that cannot be read
  };

  // An error with several findings. If `source` (a file name) is given, each line of what() begins with "source: ";
  // diagnostics() do not contain it.
  Error(Kind kind, std::vector<Diagnostic> diagnostics, std::string_view source = {});
  // An error with one finding that belongs to no place in a scene.
  Error(Kind kind, std::string what) : Error(kind, {Diagnostic{"", std::move(what)}}) {}

  // The cause; the command derives its exit status from it.
  [[nodiscard]] Kind kind() const noexcept { return kind_; }
  // All findings, at least one; valid as long as the error.
  [[nodiscard]] const std::vector<Diagnostic>& diagnostics() const noexcept { return diagnostics_; }

 private:
  Kind kind_;
  std::vector<Diagnostic> diagnostics_;
};

// Outcome of a numerical operation. The names are part of the command's JSON, and the numbers are those of enum
// assur_code in assur.h: neither changes, and 16, which is free, is never used again. docs/extending.md lists what a
// new code needs.
enum class Code : std::uint8_t {
  ok,                   // success; no estimated error exceeds the required accuracy
  singular,             // a matrix without a usable pivot
  not_finite,           // NaN or infinity among the values
  not_converged,        // Newton did not reach the tolerance
  fold,                 // a fold: the mechanism cannot move further; time is bracketed
  change_point_passed,  // two branches cross here; the smooth continuation was taken. An Event::kind, never a status
  inaccurate,           // accepted, but the estimated error exceeds the required accuracy
  branch_unknown,       // the library could not decide which branch continues the motion
  inconsistent,         // a redundant equation is no longer satisfied
  out_of_range,         // a time lies outside the table of a law
  actuator_zero,        // a driver drives nothing: its distance is 0, or its axis is along a direction of its angle
  deadline,             // the time allowed for the step ran out
  interrupted,          // the observer or StepSettings::stop asked to stop
  limit_reached,        // a quantity has reached its limit, and the scene ends the motion there; time is bracketed
  limit_exceeded,       // a quantity has left its limit, and the motion goes on. An Event::kind, never a status
  within_limits,        // the quantity has returned into its limit. An Event::kind, never a status
  not_assembled = 17,   // the start posture cannot be assembled: of a member of an ensemble, or of a linkage
  near_singular,        // the motion passed close to a singular posture. An Event::kind, never a status
};

// Name of a code as in the command's JSON, e.g. "fold".
[[nodiscard]] std::string_view name(Code code) noexcept;
// The same for people, e.g. "the mechanism cannot move further".
[[nodiscard]] std::string_view explanation(Code code) noexcept;

// The object that a status is about.
struct Place {
  // Type of the object. `index` refers to the list of this type.
  enum class Kind : std::uint8_t {
    none,    // no particular object
    driver,  // of Scene::drivers
    group,   // of Structure::groups()
    lane,    // of a linear solver, or of mechanisms that are solved side by side
    member,  // of an ensemble
    target,  // of Simulator::drivers(): a controlled driver, or one value of a controlled pose
    limit,   // of Simulator::limits()
  };
  std::int32_t index = -1;  // counted from 0; -1 if the kind is none
  Kind kind = Kind::none;   // type of the object

  // No particular object.
  constexpr Place() = default;
  // The i-th object of a list.
  constexpr Place(Kind of, std::int32_t i) noexcept : index(i), kind(of) {}
  // The i-th driver of the scene.
  [[nodiscard]] static constexpr Place driver(std::int32_t i) noexcept { return {Kind::driver, i}; }
  // The i-th group of the structure.
  [[nodiscard]] static constexpr Place group(std::int32_t i) noexcept { return {Kind::group, i}; }
  // The i-th lane.
  [[nodiscard]] static constexpr Place lane(std::int32_t i) noexcept { return {Kind::lane, i}; }
  // The i-th member of the ensemble, counted from 0.
  [[nodiscard]] static constexpr Place member(std::int32_t i) noexcept { return {Kind::member, i}; }

  // The i-th controlled driver.
  [[nodiscard]] static constexpr Place target(std::int32_t i) noexcept { return {Kind::target, i}; }
  // The i-th limited quantity.
  [[nodiscard]] static constexpr Place limit(std::int32_t i) noexcept { return {Kind::limit, i}; }

  // True if the object is of this type.
  [[nodiscard]] constexpr bool is(Kind k) const noexcept { return kind == k; }
  friend constexpr bool operator==(const Place&, const Place&) = default;
};

// Outcome of a numerical operation, with the object and the figure that it is about. print.hpp prints it; a group has
// its name from Structure::name_of(), every object of a simulator from Simulator::name_of(), and the events of the
// report have the details.
struct [[nodiscard]] Status {
  // The code lies in the padding of the place: functions return 16 bytes in registers.
  [[no_unique_address]] Place where;  // the object that failed, or whose error is the largest
  Code code = Code::ok;               // ok, or the reason for the failure
  // Depends on the code, see the table in docs/accuracy.md: an estimated error, a residual, a ratio of singular values,
  // a time in s, ...; 0 if none.
  double figure = 0;

  // Success.
  constexpr Status() = default;
  // An outcome with the object and the figure that it is about.
  constexpr Status(Code of, Place at, double f = 0) noexcept : where(at), code(of), figure(f) {}

  // True if the operation succeeded with the required accuracy.
  [[nodiscard]] constexpr bool ok() const noexcept { return code == Code::ok; }
  // True if the step reached its time, even if the result is `inaccurate`.
  [[nodiscard]] constexpr bool arrived() const noexcept { return ok() || code == Code::inaccurate; }
};

}  // namespace assur
