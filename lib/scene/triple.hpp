// Arithmetic of positions and directions.
#pragma once

#include <algorithm>

#include "assur/number.hpp"

namespace assur::triple {

inline Triple add(const Triple& a, const Triple& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Triple subtract(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Triple scale(const Number& s, const Triple& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Number dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// std::hypot neither over- nor underflows.
inline Number norm(const Triple& a) { return hypot(a[0], a[1], a[2]); }
inline Triple unit(const Triple& a) { return scale(1 / norm(a), a); }
// The square root of the squares has fewer roundings.
inline Number length(const Triple& a) { return sqrt(dot(a, a)); }
inline bool is_finite(const Triple& a) {
  return std::all_of(a.begin(), a.end(), [](const Number& x) { return isfinite(x); });
}

}  // namespace assur::triple
