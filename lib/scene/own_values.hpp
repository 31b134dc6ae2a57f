// The values of drivers as a posture has them, measured from positions and directions alone, whatever the equations of
// the drivers are. Laws are held against them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/system.hpp"

namespace assur {

// One for each law of the driver, SI units, angles in (-pi, pi].
[[nodiscard]] std::vector<double> own_values(const System& system, const DriverInput& input, std::span<const double> q);

// What the inputs in q ask for, in the same form.
[[nodiscard]] std::vector<double> wanted_values(const System& system, const DriverInput& input,
                                                std::span<const double> q);

// a - b, angles by the shorter way round.
[[nodiscard]] std::vector<double> difference(const System& system, const DriverInput& input,
                                             const std::vector<double>& a, const std::vector<double>& b);

// Sets all driven coordinates of q by values[input][law].
void drive_by_values(const System& system, const std::vector<std::vector<double>>& values, std::vector<double>& q);

// Why the driver has no value in this posture, e.g. a direction without length or along the axis; empty: it has one.
[[nodiscard]] std::string why_undefined(const System& system, const DriverInput& input, std::span<const double> q);

// Equations hold to 1e-10 of their terms at worst, those that are redundant; the rest is for the lever between an
// equation and the value. A value that the equations cannot tell from the right one is off by a half turn or a mirror.
inline constexpr double kSlack = 1e-8;

// The value that differs most from the one that is asked for by more than rounding explains, or by more than `slack`,
// relative to the terms that it is made of.
struct Mismatch {
  std::string what;  // "angle", "distance", "x", "psi", ...
  double has, wanted;
  std::string unit;  // "rad", "m", or none
};
[[nodiscard]] std::optional<Mismatch> mismatch(const System& system, const DriverInput& input,
                                               std::span<const double> q, double slack = kSlack);

}  // namespace assur
