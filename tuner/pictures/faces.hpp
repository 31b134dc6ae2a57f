// The outline of a rigid set of points.
#pragma once

#include <vector>

#include "assur/scene.hpp"

namespace assur::pictures {

// The polygons of the convex hull, each by its corners in turn: one if all points lie in a plane, a single edge (two
// corners) if they lie on a line, none for fewer than two places. With more points than kMostForFaces in space: edges
// from the first point to each other.
[[nodiscard]] std::vector<std::vector<int>> faces(const std::vector<Triple>& points);

inline constexpr std::size_t kMostForFaces = 48;

}  // namespace assur::pictures
