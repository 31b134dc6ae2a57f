// The outline of a rigid set of points.
#pragma once

#include <vector>

#include "assur/scene.hpp"

namespace assur::pictures {

// The polygons of the convex hull, each one as a cycle of corners: one polygon if all points lie in a plane, a single
// edge (two corners) if they lie on a line, none for fewer than two places. For more than kMostForFaces points in
// space: edges from the first point to every other one.
[[nodiscard]] std::vector<std::vector<int>> faces(const std::vector<Triple>& points);

inline constexpr std::size_t kMostForFaces = 48;

}  // namespace assur::pictures
