// A level of any width: dyads on the end of one crank.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "assur/scene.hpp"
#include "motion/limited.hpp"
#include "numbers.hpp"

namespace assur::test {

// |P - Q| = length as a callback.
inline Callback distance_by_callback(const std::string& p, const std::string& q, double length) {
  Callback c;
  c.coordinates = {p + ".x", p + ".y", q + ".x", q + ".y"};
  c.equations = 1;
  c.residual = [length](std::span<const double> x, std::span<double> phi) {
    phi[0] = (x[0] - x[2]) * (x[0] - x[2]) + (x[1] - x[3]) * (x[1] - x[3]) - length * length;
  };
  c.jacobian = [](std::span<const double> x, std::span<double> j) {
    j[0] = 2 * (x[0] - x[2]), j[1] = 2 * (x[1] - x[3]), j[2] = -j[0], j[3] = -j[1];
  };
  c.curvature = [](std::span<const double>, std::span<const double> v, std::span<double> out) {
    out[0] = 2 * ((v[0] - v[2]) * (v[0] - v[2]) + (v[1] - v[3]) * (v[1] - v[3]));
  };
  return c;
}

// A crank of length 1 turns about A from the angle `start`; B is its end. Dyad i has its joint at Ci and turns about
// Di.
class Fan {
 public:
  Fan(std::string name, double start, Law law) : b_{std::cos(start), std::sin(start), 0}, builder_(std::move(name), 2) {
    builder_.fixed_point("A", {0, 0, 0}).point("B", b_).constrain("crank", Distance{"A", "B", 1.0});
    builder_.drive("motor", PointAngle{"A", "B", "", std::move(law)});
  }

  // The rocker turns about (ground, 0); the joint starts to the left of the line from B to that point.
  Fan& dyad(double ground, double coupler, double rocker) {
    constrain_rocker(ground, coupler, Distance{"D" + number(), "C" + number(), rocker}, rocker);
    return *this;
  }
  // A dyad with a callback for its rocker. The callback calls `seen` with the number of the dyad at each evaluation.
  Fan& dyad_by_callback(double ground, double coupler, double rocker, std::function<void(int)> seen) {
    Callback c = distance_by_callback("D" + number(), "C" + number(), rocker);
    c.residual = [i = dyads_, seen = std::move(seen), f = c.residual](std::span<const double> x,
                                                                      std::span<double> phi) {
      seen(i);
      f(x, phi);
    };
    c.tolerance = std::numeric_limits<double>::infinity();
    constrain_rocker(ground, coupler, std::move(c), rocker);
    return *this;
  }

  [[nodiscard]] SceneBuilder& builder() { return builder_; }
  [[nodiscard]] Scene build(double end, double step) { return builder_.time(0, end, step).build(); }

 private:
  [[nodiscard]] std::string number() const { return std::to_string(dyads_); }

  template <class Rocker>
  void constrain_rocker(double ground, double coupler, Rocker kind, double rocker) {
    const double dx = ground - b_[0], dy = -b_[1], square = dx * dx + dy * dy;
    const double along = (square + coupler * coupler - rocker * rocker) / (2 * square);
    const double across = std::sqrt(coupler * coupler / square - along * along);
    builder_.fixed_point("D" + number(), {ground, 0, 0});
    builder_.point("C" + number(), {b_[0] + along * dx - across * dy, b_[1] + along * dy + across * dx, 0});
    builder_.constrain("coupler" + number(), Distance{"B", "C" + number(), coupler});
    builder_.constrain("rocker" + number(), std::move(kind));
    ++dyads_;
  }

  Triple b_;
  SceneBuilder builder_;
  int dyads_ = 0;
};

inline constexpr int kWide = 48;

// Dyads without limits, except those in `ending`, which reach their limits at the same time (see limited_four_bar()).
inline Scene limited_fan(const std::set<int>& ending) {
  Fan fan("limited_fan", 0.5, Law::polynomial({0.5, 1}));
  for (int i = 0; i < kWide; ++i) {
    if (ending.count(i) != 0) {
      fan.dyad(2, 1, 1.2);
    } else {
      fan.dyad(2, 1.8, 1.3 + 0.01 * i);
    }
  }
  return fan.build(2, 0.02);
}

// Every second dyad is a parallelogram; all of these pass their change points at t = 0.25.
inline Scene fan_of_parallelograms() {
  Fan fan("parallelograms", kTurn / 4, Law::polynomial({kTurn / 4, kTurn}));
  for (int i = 0; i < kWide; ++i) fan.dyad(2, i % 2 == 1 ? 2 : 2.3, i % 2 == 1 ? 1 : 1.6 + 0.005 * i);
  return fan.build(0.7, 0.007);
}

}  // namespace assur::test
