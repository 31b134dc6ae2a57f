// Values of drivers in a posture, measured from positions and directions, independent of the equations of the drivers.
// They are compared with the laws.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// True if this law of the driver gives an angle.
[[nodiscard]] inline bool is_angle(const System& system, const DriverInput& input, std::size_t law) {
  const bool turns = input.kind == DriverInput::Kind::frame && law >= static_cast<std::size_t>(system.dimension);
  return input.kind == DriverInput::Kind::direction || turns;
}

// The values of a driver in a posture, one for each law; SI units, angles in (-pi, pi].
[[nodiscard]] std::vector<double> own_values(const System& system, const DriverInput& input, std::span<const double> q);
[[nodiscard]] std::vector<Number> own_values(const System& system, const DriverInput& input, std::span<const Number> q);

// The same, but NaN for values that the posture does not determine: the angle of a direction without length or along
// the axis, a distance of 0, and psi and phi of a pose at theta = +-pi / 2.
[[nodiscard]] std::vector<Number> written_values(const System& system, const DriverInput& input,
                                                 std::span<const Number> q);

// The values that the inputs in q prescribe, in the same form.
[[nodiscard]] std::vector<double> wanted_values(const System& system, const DriverInput& input,
                                                std::span<const double> q);

// a - b, angles by the shorter way round.
[[nodiscard]] std::vector<double> difference(const System& system, const DriverInput& input,
                                             const std::vector<double>& a, const std::vector<double>& b);

// Sets all driven coordinates of q by values[input][law].
void drive_by_values(const System& system, const std::vector<std::vector<double>>& values, std::vector<double>& q);

// The reason why a driver has no value in this posture, e.g. a direction without length or along the axis; "": it has
// one.
[[nodiscard]] std::string why_undefined(const System& system, const DriverInput& input, std::span<const double> q);
[[nodiscard]] std::string why_undefined(const System& system, const DriverInput& input, std::span<const Number> q);

// Tolerance of the values. Redundant equations hold to a relative 1e-10; the rest of the tolerance allows for values
// that amplify an error of an equation. Wrong values that satisfy the equations differ by half a turn or a reflection.
inline constexpr double kSlack = 1e-8;

// The value with the largest difference from the prescribed one, if the difference exceeds rounding or `slack`,
// relative to the terms of the value.
struct Mismatch {
  std::string what;  // "angle", "distance", "x", "psi", ...
  double has, wanted;
  std::string unit;  // "rad", "m", or none
};
[[nodiscard]] std::optional<Mismatch> mismatch(const System& system, const DriverInput& input,
                                               std::span<const double> q, double slack = kSlack);
// True if the driver has a value, and no mismatch.
[[nodiscard]] bool has_its_value(const System& system, const DriverInput& input, std::span<const double> q,
                                 double slack = kSlack);

}  // namespace assur
