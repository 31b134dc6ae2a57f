// Arithmetic of positions and directions as written in a scene.
#pragma once

#include <algorithm>
#include <cmath>

#include "assur/scene.hpp"

namespace assur::triple {

inline Triple add(const Triple& a, const Triple& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Triple subtract(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Triple scale(double s, const Triple& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// std::hypot neither over- nor underflows.
inline double norm(const Triple& a) { return std::hypot(a[0], a[1], a[2]); }
inline bool is_finite(const Triple& a) {
  return std::all_of(a.begin(), a.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace assur::triple
