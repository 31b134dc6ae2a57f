// Distances between plane curves that are given as points, e.g. between the path of a joint and the path that a
// designer asks for.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace assur {

// Position of a point in the plane, m.
using PlanePoint = std::array<double, 2>;

// All functions need at least one point of each curve, and finite coordinates; else the result is NaN. Distances are in
// the unit of the curves (m), and root mean squares over points.

// Distance between points with the same index, i.e. at the same time. Throws Error (input) if the numbers of points
// differ.
[[nodiscard]] double timed_distance(std::span<const PlanePoint> a, std::span<const PlanePoint> b);

// Distance of each point of one curve from the nearest point of the other one, and the reverse: the root mean square
// over all points of both. Does not depend on times. Takes time in proportion to the product of both numbers.
[[nodiscard]] double nearest_distance(std::span<const PlanePoint> a, std::span<const PlanePoint> b);

// timed_distance() after `a` is scaled, turned and moved onto `b` as closely as possible (least squares; not mirrored).
// If all points of `a` are equal, it is only moved.
[[nodiscard]] double fitted_distance(std::span<const PlanePoint> a, std::span<const PlanePoint> b);

// How a curve is moved to its normal place: points p become (p - center) / radius, turned by -angle.
struct CurveFrame {
  PlanePoint center{};  // mean of the points
  double radius = 0;    // root mean square of the distances from the center; 0 if all points are equal
  double angle = 0;     // of the direction in which the points spread most, -pi/2 to pi/2, rad
};
[[nodiscard]] CurveFrame frame_of(std::span<const PlanePoint> curve);

// Writes the normal place of a curve to `to`, which may be the curve itself: centered, with radius 1 and the longest
// direction along x. All points are 0 if all points of the curve are equal.
void normalize(std::span<const PlanePoint> curve, const CurveFrame& frame, std::span<PlanePoint> to);

// nearest_distance() of both curves in their normal places, where the second one may be turned by half a turn; radii
// are 1. Does not depend on places, sizes, directions and the order of points; mirror images differ. Center, radius and
// direction are means over points, so give both curves many points, spread alike along them: four corners of a
// rectangle are not close to the path that a joint draws along it. The direction of a curve that spreads equally in all
// directions, e.g. of a circle or a square, is arbitrary, and with it the distance.
[[nodiscard]] double shape_distance(std::span<const PlanePoint> a, std::span<const PlanePoint> b);

}  // namespace assur
