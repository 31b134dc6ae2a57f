// Arithmetic of positions and directions that a tape records, see number.hpp. The doubles of a Triple stand for their
// numbers.
#pragma once

#include <algorithm>
#include <cmath>

#include "assur/scene.hpp"
#include "scene/number.hpp"

namespace assur::recorded {

inline Numbers add(const Numbers& a, const Numbers& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Numbers subtract(const Numbers& a, const Numbers& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Numbers scale(const Number& s, const Numbers& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Number dot(const Numbers& a, const Numbers& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Numbers cross(const Numbers& a, const Numbers& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// std::hypot neither over- nor underflows.
inline Number norm(const Numbers& a) { return hypot(a[0], a[1], a[2]); }
inline Numbers unit(const Numbers& a) { return scale(1 / norm(a), a); }
// The square root of the squares has fewer roundings.
inline Number length(const Numbers& a) { return sqrt(dot(a, a)); }

inline Triple add(const Triple& a, const Triple& b) { return values(add(numbers(a), numbers(b))); }
inline Triple subtract(const Triple& a, const Triple& b) { return values(subtract(numbers(a), numbers(b))); }
inline Triple scale(const Number& s, const Triple& a) { return values(scale(s, numbers(a))); }
inline Number dot(const Triple& a, const Triple& b) { return dot(numbers(a), numbers(b)); }
inline Triple cross(const Triple& a, const Triple& b) { return values(cross(numbers(a), numbers(b))); }
inline Number norm(const Triple& a) { return norm(numbers(a)); }
inline Triple unit(const Triple& a) { return values(unit(numbers(a))); }
inline Number length(const Triple& a) { return length(numbers(a)); }
inline bool is_finite(const Triple& a) {
  return std::all_of(a.begin(), a.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace assur::recorded
