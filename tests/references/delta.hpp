// A delta robot: three arms about axes in the ground, each with two rods to the platform. z is up.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "assur/scene.hpp"

namespace assur::references {

struct Delta {
  double base = 0.3, arm = 0.3, rod = 0.7, platform = 0.1, width = 0.05;

  static Triple radial(int i) {
    const double a = 2 * std::numbers::pi / 3 * i;
    return {std::cos(a), std::sin(a), 0};
  }
  static Triple across(int i) { return {-radial(i)[1], radial(i)[0], 0}; }

  // The elbow of arm i at an angle below the horizontal.
  [[nodiscard]] Triple elbow(int i, double angle) const {
    const double out = base + arm * std::cos(angle);
    return {out * radial(i)[0], out * radial(i)[1], -arm * std::sin(angle)};
  }
  // The height of the platform if all arms are at one angle.
  [[nodiscard]] double height(double angle) const {
    const double out = base + arm * std::cos(angle) - platform;
    return -arm * std::sin(angle) - std::sqrt(rod * rod - out * out);
  }

  // The robot without drivers and time. `guess` has the angles of the arms in the scene. The platform starts at its
  // height for the angle `at`.
  [[nodiscard]] SceneBuilder scene(const std::array<double, 3>& guess, double at) const {
    SceneBuilder b("delta", 3);
    b.point("O", {0, 0, height(at)}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
    Body plate{"plate", "O", {"u", "v", "w"}, {}, {}, {}};
    for (int i = 0; i < 3; ++i) {
      const std::string n = std::to_string(i);
      const Triple r = radial(i), t = across(i);
      b.fixed_vector("r" + n, r).fixed_vector("t" + n, t);
      b.fixed_point("S" + n, {base * r[0], base * r[1], 0})
          .point("E" + n, elbow(i, guess[static_cast<std::size_t>(i)]));
      b.constrain("arm" + n, Distance{"S" + n, "E" + n, arm});
      b.constrain("hinge" + n, Dot{{"S" + n, "E" + n}, "t" + n, 0.0});
      Body bar{"bar" + n, "E" + n, {}, {}, {}, {}};
      for (const int side : {-1, 1}) {
        const std::string m = n + (side < 0 ? "l" : "r");
        const double w = side * width;
        bar.points.push_back({"E" + m, {w * t[0], w * t[1], 0}});
        plate.points.push_back({"P" + m, {platform * r[0] + w * t[0], platform * r[1] + w * t[1], 0}});
        b.constrain("rod" + m, Distance{"E" + m, "P" + m, rod});
      }
      b.add(bar);
    }
    return b.add(plate);
  }
};

}  // namespace assur::references
