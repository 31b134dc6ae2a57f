// Forward kinematics of a tree of bodies by rotation matrices, apart from all of the library.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace assur::test {

struct V3 {
  std::array<double, 3> of;
  constexpr double& operator[](std::size_t i) { return of[i]; }
  constexpr double operator[](std::size_t i) const { return of[i]; }
};
using M3 = std::array<V3, 3>;  // rows

inline V3 operator+(const V3& a, const V3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline V3 operator-(const V3& a, const V3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline V3 operator*(double f, const V3& a) { return {f * a[0], f * a[1], f * a[2]}; }
inline double dot(const V3& a, const V3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double norm(const V3& a) { return std::sqrt(dot(a, a)); }
inline V3 cross(const V3& a, const V3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline V3 operator*(const M3& m, const V3& a) { return {dot(m[0], a), dot(m[1], a), dot(m[2], a)}; }
inline M3 operator*(const M3& m, const M3& n) {
  M3 p;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) p[i][k] = m[i][0] * n[0][k] + m[i][1] * n[1][k] + m[i][2] * n[2][k];
  }
  return p;
}
inline constexpr M3 kNoTurn = {V3{1, 0, 0}, V3{0, 1, 0}, V3{0, 0, 1}};

// The turn by an angle about an axis of any length (Rodrigues).
inline M3 turn(const V3& axis, double angle) {
  const V3 u = (1 / norm(axis)) * axis;
  const double c = std::cos(angle), s = std::sin(angle);
  M3 r;
  for (std::size_t i = 0; i < 3; ++i) {
    V3 e{};
    e[i] = 1;
    const V3 column = c * e + s * cross(u, e) + ((1 - c) * u[i]) * u;
    for (std::size_t k = 0; k < 3; ++k) r[k][i] = column[k];
  }
  return r;
}

// The shortest turn of z to a direction.
inline M3 z_along(const V3& direction) {
  const V3 z = {0, 0, 1}, d = (1 / norm(direction)) * direction, axis = cross(z, d);
  return norm(axis) == 0 ? kNoTurn : turn(axis, std::atan2(norm(axis), dot(z, d)));
}

class Tree {
 public:
  struct Joint {
    std::string name;
    bool slides;
    V3 at, axis;  // in the body
  };
  struct Pose {
    V3 at{};
    M3 turn = kNoTurn;
    V3 operator()(const V3& x) const { return at + turn * x; }
  };

  // A body in its parent, with its joints in order. The ground is 0; returns the number of the body.
  int add(int parent, const V3& at, const M3& turned, std::vector<Joint> joints) {
    bodies_.push_back({parent, {at, turned}, std::move(joints)});
    return static_cast<int>(bodies_.size());
  }

  // The poses of all bodies for values of the joints, by name; a joint that is not named has 0.
  [[nodiscard]] std::vector<Pose> poses(const std::map<std::string, double>& q) const {
    std::vector<Pose> all(1);
    for (const Body& b : bodies_) {
      const Pose& parent = all[static_cast<std::size_t>(b.parent)];
      Pose p{parent(b.pose.at), parent.turn * b.pose.turn};
      for (const Joint& j : b.joints) {
        const auto found = q.find(j.name);
        const double value = found == q.end() ? 0 : found->second;
        if (j.slides) {
          p.at = p.at + value * (p.turn * ((1 / norm(j.axis)) * j.axis));
        } else {
          const V3 anchor = p(j.at);
          p.turn = p.turn * turn(j.axis, value);
          p.at = anchor - p.turn * j.at;
        }
      }
      all.push_back(p);
    }
    return all;
  }

 private:
  struct Body {
    int parent;
    Pose pose;
    std::vector<Joint> joints;
  };
  std::vector<Body> bodies_;
};

}  // namespace assur::test
