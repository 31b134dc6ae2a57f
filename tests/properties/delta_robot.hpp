// A delta robot: three arms on hinges, each with a parallelogram of two rods to the platform, whose pose is driven.
// Because the platform does not turn, one rod of each parallelogram is redundant.
#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "assur/scene.hpp"

namespace assur::test {

struct DeltaRobot {
  double base = 0.33, arm = 0.385, platform = 0.07, rod = 0.48, half_width = 0.05;  // m
  double home = -0.6123;                                                            // z of the platform at the start

  // Directions of arm k: away from the axis, and along its hinge.
  [[nodiscard]] static Triple out(int k) {
    const double a = 2 * std::numbers::pi * k / 3;
    return {std::cos(a), std::sin(a), 0};
  }
  [[nodiscard]] static Triple hinge(int k) { return {-out(k)[1], out(k)[0], 0}; }

  // The lowest z that arm k reaches with the platform at x: arm and rods are in line, seen along its hinge.
  [[nodiscard]] double lowest(int k, double x) const {
    const double across = x * hinge(k)[0], along = x * out(k)[0] + platform - base;
    const double reach = arm + std::sqrt(rod * rod - across * across);
    return -std::sqrt(reach * reach - along * along);
  }

  // Elbow k with the platform at x, z: the outer intersection of the circles of arm and rods.
  [[nodiscard]] Triple elbow(int k, double x, double z) const {
    const double across = x * hinge(k)[0], rods = std::sqrt(rod * rod - across * across);
    const double dx = x * out(k)[0] + platform - base, d = std::hypot(dx, z);
    const double along = (arm * arm - rods * rods + d * d) / (2 * d), beside = std::sqrt(arm * arm - along * along);
    const double from_axis = base + (along * dx - beside * z) / d;
    return {from_axis * out(k)[0], from_axis * out(k)[1], (along * z + beside * dx) / d};
  }

  [[nodiscard]] Scene scene() const {
    SceneBuilder b("delta", 3);
    b.point("O", {0, 0, home}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
    Body moving{"platform", "O", {"u", "v", "w"}, {}, {}, {}};
    for (int k = 0; k < 3; ++k) {
      const std::string n = std::to_string(k);
      const Triple e = out(k), t = hinge(k);
      b.fixed_point("A" + n, {base * e[0], base * e[1], 0}).fixed_vector("t" + n, t).fixed_vector("e" + n, e);
      b.point("B" + n, elbow(k, 0, home));
      b.constrain("arm" + n, Distance{"A" + n, "B" + n, arm});
      b.constrain("hinge" + n, Dot{Direction("A" + n, "B" + n), "t" + n, 0.0});
      Body elbow_axis{"elbow" + n, "B" + n, {}, {}, {}, {}};
      for (const int side : {1, -1}) {
        const std::string s = side > 0 ? "p" : "m";
        const Triple half = {side * half_width * t[0], side * half_width * t[1], 0};
        elbow_axis.points.push_back({"B" + s + n, half});
        moving.points.push_back({"P" + s + n, {platform * e[0] + half[0], platform * e[1] + half[1], 0}});
        b.constrain("rod" + s + n, Distance{"B" + s + n, "P" + s + n, rod});
      }
      b.add(std::move(elbow_axis));
      b.measure("motor" + n, AngleBetween{"e" + n, Direction("A" + n, "B" + n), "t" + n});
    }
    b.add(std::move(moving));
    b.drive("pose", Pose{"platform",
                         {Law::constant(0), Law::constant(0), Law::constant(home)},
                         {Law::constant(0), Law::constant(0), Law::constant(0)}});
    return b.time(0, 1, 0.01).build();
  }
};

}  // namespace assur::test
