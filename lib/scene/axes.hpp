// Axes of angles: build() makes a fixed vector NAME.axis of one that is written as coordinates.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "assur/scene.hpp"

namespace assur {

// Name of the axis of an angle, after build(); "": it has none.
template <class Angle>
[[nodiscard]] const std::string& axis_of(const Angle& angle) {
  return std::get<std::string>(angle.axis);
}

// True if build() made the axis of coordinates.
[[nodiscard]] bool has_made_axis(const Driver& driver);
[[nodiscard]] bool has_made_axis(const Measure& measure);

// The parts of a scene that have to do with axes.
struct AxisParts {
  int dimension;
  std::vector<Vector>& vectors;
  std::vector<Driver>& drivers;
  std::vector<Measure>& measures;
};

// True if an axis is written as coordinates.
[[nodiscard]] bool has_written_axes(const AxisParts& parts);

// Replaces coordinates by names of vectors, and adds these, of unit length. Returns findings: axes without a direction.
[[nodiscard]] std::vector<Diagnostic> expand_axes(const AxisParts& parts);

}  // namespace assur
