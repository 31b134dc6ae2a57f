// The equation of a gear or rack between two coordinates of joints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assur/scene.hpp"

namespace assur {

// A coordinate of a joint. An angle turns direction `from` into `to` about `axis`, which is empty in the plane; a
// displacement is a scalar.
struct GearSide {
  bool is_angle = true;
  std::string from, to, axis;  // names of unit vectors
  std::string displacement;    // "NAME.lambda"
};

inline constexpr int kMostTeeth = 1000;  // a choice: fractions then differ by 1e-6 at least
// Cosine of a phase of about 1 rad: farther out of mesh, Newton's method may find another tooth.
inline constexpr double kLeastCosineInMesh = 0.54;
inline constexpr double kLargestPhase = 0x1p30;  // rad; beyond it rounding hides the teeth

// Whole numbers n, m <= kMostTeeth with |n / m - ratio| <= 1e-9; empty: there are none.
[[nodiscard]] std::optional<std::pair<int, int>> whole_ratio(double ratio);

// Both coordinates are 0 in the posture as written.
//   two angles:              sin(m b - n a) = 0 with the ratio n / m
//   an angle and a distance: sin(angle - distance / radius) = 0
//   two distances:           b - ratio a = 0
// A posture gives angles up to whole turns, and all these equations hold after whole turns of both wheels. They also
// hold at other teeth: Callback::teeth makes steps short enough, and the residual is NaN if the wheels are farther than
// about 1 rad of their phase, m b - n a, out of mesh.
[[nodiscard]] Callback gear_equation(const GearSide& a, const GearSide& b, double ratio);

// The equation as numbers, for saved plans: phi = sin(total), or total; total = sum of factor * coordinate.
struct GearNumbers {
  // An angle has the arguments from, to and in space the axis, with `dimension` components each; a displacement is one
  // argument.
  struct Side {
    bool is_angle = true;
    std::int32_t dimension = 2;
    double factor = 1;

    [[nodiscard]] std::size_t arguments() const { return !is_angle ? 1 : dimension == 2 ? 4 : 9; }
  };
  std::vector<Side> sides;
  bool is_periodic = false;
  std::int32_t teeth = 1;  // Callback::teeth
};

inline constexpr std::size_t kMostGearArguments = 18;  // two angles in space: two directions and an axis each

// The numbers of a callback that gear_equation() or gear_of() made; empty: it is another one.
[[nodiscard]] std::optional<GearNumbers> numbers_of(const Callback& callback);

// The callback with these numbers. It has no names of coordinates, and its derivatives are not checked.
[[nodiscard]] Callback gear_of(const GearNumbers& numbers);

}  // namespace assur
