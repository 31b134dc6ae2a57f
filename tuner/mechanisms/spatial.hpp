// Vectors of three numbers.
#pragma once

#include <cmath>

namespace assur::mechanisms {

template <class T>
struct Spatial {
  T x{}, y{}, z{};
  T& operator[](int k) { return k == 0 ? x : k == 1 ? y : z; }
  const T& operator[](int k) const { return k == 0 ? x : k == 1 ? y : z; }
  friend Spatial operator+(const Spatial& a, const Spatial& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Spatial operator-(const Spatial& a, const Spatial& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Spatial operator*(const T& s, const Spatial& a) { return {s * a.x, s * a.y, s * a.z}; }
};
template <class T>
T dot(const Spatial<T>& a, const Spatial<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Spatial<T> cross(const Spatial<T>& a, const Spatial<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
Spatial<T> unit(const Spatial<T>& a) {
  using std::sqrt;
  return T(1) / sqrt(dot(a, a)) * a;
}

}  // namespace assur::mechanisms
