// The orientation of a body from its axes: the columns f[0..2], f[3..5] and f[6..8] of a rotation matrix, as jets.
#pragma once

#include <cstddef>
#include <span>
#include <utility>

#include "scene/jet.hpp"

namespace assur {

// Component k of the unit quaternion (w, x, y, z), w >= 0, that turns ground axes into these. The largest component
// divides (Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1, 1978).
template <class T>
Jet<T> quaternion(std::span<const Jet<T>> f, std::size_t k) {
  const auto r = [&](std::size_t row, std::size_t column) -> const Jet<T>& { return f[3 * column + row]; };
  const Jet<T> trace = r(0, 0) + r(1, 1) + r(2, 2);
  // 4 q_i q_j
  const auto product = [&](std::size_t i, std::size_t j) -> Jet<T> {
    if (i > j) std::swap(i, j);
    if (j == 0) return trace + T(1);
    if (i == j) return T(2) * r(i - 1, i - 1) - trace + T(1);
    if (i > 0) return r(i - 1, j - 1) + r(j - 1, i - 1);
    return r((j + 1) % 3, j % 3) - r(j % 3, (j + 1) % 3);
  };
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (product(i, i).value > product(largest, largest).value) largest = i;
  }
  const Jet<T> root = sqrt(product(largest, largest));  // 2 |q_largest|
  const Jet<T> component = product(largest, k) / (T(2) * root);
  return product(largest, 0).value < T(0) ? -component : component;
}

// The turn about ground axis k, whose rate is the angular velocity 1/2 sum e x e' and whose acceleration the angular
// acceleration 1/2 sum e x e''. It has no value.
template <class T>
Jet<T> turn(std::span<const Jet<T>> f, std::size_t k) {
  const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
  T rate = 0, acceleration = 0;
  for (std::size_t axis = 0; axis < 9; axis += 3) {
    const Jet<T>&x = f[axis + i], &y = f[axis + j];
    rate = rate + (x.value * y.rate - y.value * x.rate);
    acceleration = acceleration + (x.value * y.acceleration - y.value * x.acceleration);
  }
  return {T(0), rate / T(2), acceleration / T(2)};
}

}  // namespace assur
