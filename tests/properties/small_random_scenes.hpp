// Small random scenes: mechanisms around a start posture in which they can be assembled and can move.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "assur/scene.hpp"
#include "mechanisms/draw.hpp"

namespace assur::test {

using mechanisms::Draw;

struct Placed {
  std::string name;
  Triple at;
};

// The sides of a rigid triangle P0 P1 P2, as long as they are at the start.
inline void add_sides(SceneBuilder& b) {
  for (int i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i), next = std::to_string((i + 1) % 3);
    b.constrain("side" + k, Distance{"P" + k, "P" + next, std::nullopt});
  }
}

// A small motion: the crank swings by less than a radian, so that dyads keep their open angles.
inline Law swing(Draw& draw, double value, double amplitude) {
  const double frequency = draw.real(0.3, 1), phase = draw.real(0, 2 * std::numbers::pi);
  return Law::harmonics({{amplitude, frequency, phase}}, value - amplitude * std::sin(phase));
}

inline Triple shifted(const Triple& at, const Triple& by) { return {at[0] + by[0], at[1] + by[1], at[2] + by[2]}; }

// Cranks, followed by dyads, sliders and points of couplers, each connected to two existing points.
inline Scene planar_mechanism(Draw& draw, const Triple& origin = {}) {
  SceneBuilder b("planar", 2);
  std::vector<Placed> fixed, moving;
  const auto ground = [&](const Triple& at) {
    fixed.push_back({"F" + std::to_string(fixed.size()), at});
    b.fixed_point(fixed.back().name, at);
    return fixed.back();
  };
  const auto size = draw.real(0.3, 3);
  for (std::size_t i = 0, cranks = 1 + draw.below(2); i < cranks; ++i) {
    const double x = size * draw.real(-1, 1), y = size * draw.real(-1, 1);
    const Placed pivot = ground({origin[0] + x, origin[1] + y, 0});
    const double angle = draw.real(-3, 3), radius = size * draw.real(0.2, 0.6);
    const std::string name = "M" + std::to_string(moving.size());
    moving.push_back({name, {pivot.at[0] + radius * std::cos(angle), pivot.at[1] + radius * std::sin(angle), 0}});
    b.point(name, moving.back().at);
    b.drive("motor" + std::to_string(i), PointAngle{pivot.name, name, "", swing(draw, angle, draw.real(0.05, 0.25))});
  }
  const std::size_t parts = 1 + draw.below(7);
  for (std::size_t i = 0; i < parts; ++i) {
    const std::string k = std::to_string(i), name = "C" + k;
    const Placed from = draw.of(moving);
    const double direction = draw.real(-3, 3), length = size * draw.real(0.8, 1.6);
    const Triple at = {from.at[0] + length * std::cos(direction), from.at[1] + length * std::sin(direction), 0};
    // The second bar is at 60 to 120 degrees to the first one; a rail is within 45 degrees of it.
    const double across = direction + (draw.maybe() ? 1 : -1) * draw.real(1.05, 2.1),
                 reach = size * draw.real(0.8, 1.6);
    b.point(name, at);
    b.constrain("bar" + k, Distance{from.name, name, std::nullopt});
    if (draw.below(3) == 0) {
      const double along = direction + draw.real(-0.7, 0.7);
      const Placed on = ground({at[0] - reach * std::cos(along), at[1] - reach * std::sin(along), 0});
      b.fixed_vector("rail" + k, {std::cos(along), std::sin(along), 0});
      b.constrain("slide" + k, OnLine{name, on.name, "rail" + k});
      b.measure("along" + k, MeasuredCoordinate{"slide" + k + ".lambda"});
    } else {
      const Placed on = ground({at[0] - reach * std::cos(across), at[1] - reach * std::sin(across), 0});
      b.constrain("rod" + k, Distance{on.name, name, std::nullopt});
      b.measure("angle" + k, AbsoluteAngle{on.name, name});
    }
    moving.push_back({name, at});
  }
  return b.time(0, 0.3, 0.01).build();
}

// A terminal with a given pose; legs, each a hinged handle and a rod; tripods with one foot on a moving point.
inline Scene spatial_mechanism(Draw& draw, const Triple& origin = {}) {
  SceneBuilder b("spatial", 3);
  const double size = draw.real(0.3, 3);
  b.point("O", origin).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  Body terminal{"terminal", "O", {"u", "v", "w"}, {}, {}, {}};
  Pose pose{"terminal", {}, {}};
  for (const double at : origin) pose.translation.push_back(swing(draw, at, size * 0.05));
  for (int i = 0; i < 3; ++i) pose.rotation.push_back(swing(draw, 0, 0.1));
  b.drive("pose", std::move(pose));
  std::vector<Placed> ends;
  const std::size_t legs = 1 + draw.below(4);
  for (std::size_t i = 0; i < legs; ++i) {
    const std::string k = std::to_string(i);
    const double azimuth = draw.real(-3, 3);
    const Triple out = {std::cos(azimuth), std::sin(azimuth), 0}, side = {-out[1], out[0], 0};
    const double arm = size * draw.real(0.4, 0.8), handle = size * draw.real(0.3, 0.5),
                 rod = size * draw.real(0.8, 1.2);
    const Triple P = {arm * out[0], arm * out[1], 0};
    // The rod hangs below P; the handle is about perpendicular to it, in the plane of `out`.
    const double tilt = draw.real(-0.3, 0.3);
    const Triple B = {P[0] + rod * std::sin(tilt) * out[0], P[1] + rod * std::sin(tilt) * out[1],
                      -rod * std::cos(tilt)};
    const Triple A = {B[0] + handle * out[0], B[1] + handle * out[1], B[2] + handle * draw.real(-0.3, 0.3)};
    terminal.points.push_back({"P" + k, P});
    b.fixed_point("A" + k, shifted(A, origin)).fixed_vector("a" + k, side).point("B" + k, shifted(B, origin));
    b.constrain("handle" + k, Distance{"A" + k, "B" + k, std::nullopt});
    b.constrain("hinge" + k, Dot{Direction("A" + k, "B" + k), "a" + k, std::nullopt});
    b.constrain("rod" + k, Distance{"B" + k, "P" + k, std::nullopt});
    ends.push_back({"B" + k, B});
  }
  for (std::size_t i = 0, tripods = draw.below(3); i < tripods; ++i) {
    const std::string k = std::to_string(i);
    const Placed foot = draw.of(ends);
    const Triple at = {foot.at[0] + size * draw.real(-0.2, 0.2), foot.at[1] + size * draw.real(-0.2, 0.2),
                       foot.at[2] - size * draw.real(0.8, 1.2)};
    b.point("T" + k, shifted(at, origin)).constrain("up" + k, Distance{foot.name, "T" + k, std::nullopt});
    b.fixed_point("G" + k, shifted({at[0] + size, at[1] + size * draw.real(-0.2, 0.2), at[2]}, origin));
    b.fixed_point("H" + k, shifted({at[0] + size * draw.real(-0.2, 0.2), at[1] + size, at[2]}, origin));
    b.constrain("east" + k, Distance{"G" + k, "T" + k, std::nullopt});
    b.constrain("north" + k, Distance{"H" + k, "T" + k, std::nullopt});
    ends.push_back({"T" + k, at});
  }
  b.add(std::move(terminal));
  return b.time(0, 0.3, 0.01).build();
}

}  // namespace assur::test
