// Families in the plane.
#include <algorithm>
#include <cmath>
#include <utility>

#include "mechanisms/families.hpp"

namespace assur::mechanisms {
namespace {

// A driven bar that turns about a fixed pivot, modelled in one of several ways; returns the name of its end.
std::string crank(Draft& d, const std::string& pivot, const std::string& end, const Place& at) {
  const Place dir = unit(at - d.at(pivot));
  switch (d.chance.below(4)) {
    case 0:
      d.point(end, at);
      if (d.chance.one_in(2)) d.distance(pivot, end);
      d.turn(pivot, end);
      break;
    case 1: {  // against a fixed direction
      d.point(end, at);
      d.distance(pivot, end);
      const std::string zero = "x_" + end;
      d.fixed_vector(zero, d.chance.one_in(2) ? Place{1, 0, 0} : d.chance.direction(2));
      d.turn_between(zero, {pivot, end});
      break;
    }
    case 2: {  // a body with a frame of one vector
      const std::string u = "u_" + end, zero = "x_" + end;
      d.vector(u, turned(dir, {0, 0, 1}, d.chance.real(-2, 2)));
      d.fixed_vector(zero, {1, 0, 0});
      d.frame_body("crank_" + end, pivot, {u}, {{end, at}});
      d.turn_between(zero, u);
      break;
    }
    default:  // a cylinder that pushes the bar
      d.point(end, at);
      d.distance(pivot, end);
      const std::string foot = "foot_" + end;
      d.fixed(foot, at + norm(at - d.at(pivot)) * d.chance.real(0.7, 1.5) *
                             turned(dir, {0, 0, 1}, d.chance.sign() * d.chance.real(0.8, 2.3)));
      d.reach(foot, end, d.chance.real(-0.5, 0.5) * norm(at - d.at(pivot)) * std::min(1.0, d.speed));
  }
  return end;
}

// Adds a point that is connected to two existing parts.
std::string dyad(Draft& d, std::size_t i, const std::string& from) {
  Draw& c = d.chance;
  const std::string k = std::to_string(i), end = "C" + k, base = "D" + k;
  const double direction = c.real(-3, 3), length = c.real(0.8, 1.6), reach = c.real(0.8, 1.6);
  const Place at = d.at(from) + polar(length, direction);
  const double other = direction + c.sign() * c.real(0.7, 2.3);
  switch (c.below(6)) {
    case 0:  // two bars
      d.point(end, at), d.fixed(base, at - polar(reach, other));
      d.distance(from, end), d.distance(base, end);
      d.measure_angle(base, end);
      if (c.one_in(3)) d.measure_between({from, end}, {base, end});
      return end;
    case 1: {  // a coupler plate and a rocker
      const std::string tip = "E" + k;
      d.point(end, at), d.fixed(base, at - polar(reach, other));
      d.base_body("plate" + k, {from, end}, {{tip, at + c.real(0.3, 1) * c.direction(2)}});
      d.distance(base, end);
      d.measure_between({from, end}, {base, end});
      return tip;
    }
    case 2: {  // a slider on a fixed rail
      const double rail = direction + c.real(-0.8, 0.8);
      d.point(end, at), d.distance(from, end), d.fixed(base, at - polar(reach, rail));
      d.fixed_vector("rail" + k, polar(1, rail));
      const std::string line = d.on_line(end, base, "rail" + k);
      d.measure_coordinate(line + ".lambda");
      d.measure_angle(from, end);
      return end;
    }
    case 3: {  // a bar that slides through a fixed pivot
      const std::string bar = "bar" + k;
      const Place pivot = d.at(from) + polar(length, direction);
      d.fixed(base, pivot), d.vector(bar, polar(1, direction + (c.one_in(2) ? 0 : kPi)));
      const std::string line = d.on_line(base, from, bar);
      d.frame_body("sleeve" + k, from, {bar},
                   {{end, d.at(from) + polar(length * c.real(0.5, 1.6), direction + c.real(-0.5, 0.5))}});
      d.measure_coordinate(line + ".lambda");
      if (c.one_in(2)) d.measure_distance(base, end);
      return end;
    }
    case 4: {  // a slider held by a dot product, or by a coordinate
      d.point(end, at), d.distance(from, end);
      if (c.one_in(2)) {
        d.level(end, std::abs(std::cos(direction)) > 0.7 && !d.turned_as_a_whole() ? 1 : static_cast<int>(c.below(2)));
      } else {
        d.fixed(base, at - polar(reach, direction));
        d.fixed_vector("normal" + k, polar(1, direction + kPi / 2 + c.real(-0.7, 0.7)));
        d.dot_product("normal" + k, {base, end});
      }
      d.measure_angle(from, end);
      return end;
    }
    default: {  // a plate with a frame, held by a rocker; its middle by `linear`
      const std::string u = "u" + k, tip = "E" + k, middle = "M" + k;
      d.vector(u, c.direction(2)), d.fixed(base, at - polar(reach, other));
      d.frame_body("plate" + k, from, {u}, {{end, at}, {tip, at + c.real(0.2, 0.8) * c.direction(2)}});
      d.distance(base, end);
      d.point(middle, 0.5 * (d.at(base) + d.at(tip)));
      d.middle(middle, base, tip);
      d.measure_between(u, {base, end});
      return c.one_in(2) ? tip : middle;
    }
  }
}

// 3-RRR, 3-RPR and mixtures, driven by their legs or by their pose.
// Watt and Stephenson chains whose driver leaves four or more unknowns together.
// A trammel: a rod with its ends on two lines, driven by a coordinate, a scalar or an angle.

}  // namespace

void planar_chain(Draft& d) {
  std::vector<std::string> moving;
  for (std::size_t i = 0, cranks = 1 + d.chance.below(2); i < cranks; ++i) {
    const std::string pivot = text("A", i);
    d.fixed(pivot, {d.chance.real(-1, 1), d.chance.real(-1, 1), 0});
    moving.push_back(crank(d, pivot, text("B", i), d.at(pivot) + d.chance.real(0.2, 0.6) * d.chance.direction(2)));
  }
  for (std::size_t i = 0, parts = 1 + d.chance.below(4); i < parts; ++i) {
    moving.push_back(dyad(d, i, moving[d.chance.below(moving.size())]));
  }
}

void planar_platform(Draft& d) {
  Draw& c = d.chance;
  const bool by_pose = c.one_in(4);
  if (by_pose) d.keep_axes();
  const double size = c.real(0.3, 0.8);
  const Place o = {c.real(-0.2, 0.2), c.real(-0.2, 0.2), 0};
  std::map<std::string, Place> corners;
  const double first = c.real(0, 2);
  for (std::size_t i = 0; i < 3; ++i)
    corners[text("P", i)] = o + polar(size, first + c.real(1.7, 2.4) * static_cast<double>(i));
  const std::size_t way = by_pose ? 0 : c.below(3);
  if (way == 0) {
    d.point("O", o), d.vector("u", by_pose ? Place{1, 0, 0} : c.direction(2));
    d.frame_body("platform", "O", {"u"}, corners);
  } else {
    d.point("P0", corners["P0"]), d.point("P1", corners["P1"]);
    if (way == 1) {
      d.base_body("platform", {"P0", "P1"}, {{"P2", corners["P2"]}});
    } else {
      d.point("P2", corners["P2"]);
      d.distance("P0", "P1"), d.distance("P1", "P2"), d.distance("P2", "P0");
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string base = text("A", i), knee = text("B", i), top = text("P", i);
    const double out = first + 2.09 * static_cast<double>(i) + c.real(-0.3, 0.3);
    d.fixed(base, o + polar(c.real(1.5, 2.2), out));
    const Place span = d.at(top) - d.at(base);
    if (c.one_in(2)) {  // a cylinder
      if (!by_pose) d.reach(base, top, c.real(-0.4, 0.4) * std::min(1.0, d.speed));
      d.measure_distance(base, top);
      continue;
    }
    d.point(knee, d.at(base) + 0.5 * span + c.sign() * c.real(0.3, 0.7) * Place{-span[1], span[0], 0});
    if (by_pose) {
      d.distance(base, knee);
    } else {
      if (c.one_in(2)) d.distance(base, knee);
      d.turn(base, knee);
    }
    d.distance(knee, top);
    d.measure_angle(knee, top);
  }
  if (by_pose) d.pose("platform", "O", 0.4 * std::min(1.0, d.speed), 0.6 * std::min(1.0, d.speed));
}

void six_bar(Draft& d) {
  Draw& c = d.chance;
  d.fixed("A", {0, 0, 0}), d.fixed("D", {c.real(1.2, 2), c.real(-0.3, 0.3), 0});
  const Place b = polar(c.real(0.5, 0.9), c.real(0.8, 2.2)), cc = d.at("D") + polar(c.real(0.9, 1.4), c.real(0.9, 1.9));
  d.point("B", b), d.point("C", cc);
  d.distance("A", "B"), d.distance("D", "C");
  const Place e = 0.5 * (b + cc) + c.real(0.4, 0.9) * unit(Place{b[1] - cc[1], cc[0] - b[0], 0});
  d.base_body("coupler", {"B", "C"}, {{"E", e}});
  const Place g = e + c.real(0.8, 1.3) * c.direction(2);
  if (c.one_in(3)) {  // Watt: from the rocker's plate
    const Place h = d.at("D") + c.real(0.7, 1.2) * c.direction(2);
    d.base_body("rocker", {"D", "C"}, {{"H", h}});
    const Place f = 0.5 * (e + h) + c.sign() * c.real(0.3, 0.8) * unit(Place{e[1] - h[1], h[0] - e[0], 0});
    d.point("F", f);
    d.distance("E", "F"), d.distance("H", "F");
    d.fixed("G", f + c.real(0.6, 1.2) * c.direction(2));
    d.reach("G", "F", c.real(-0.3, 0.3) * std::min(1.0, d.speed));
    d.measure_angle("E", "F");
  } else {  // Stephenson: driven at the far end
    d.fixed("G", g);
    const Place f = g + c.real(0.3, 0.6) * c.direction(2);
    crank(d, "G", "F", f);
    d.distance("E", "F");
  }
  d.measure_angle("A", "B"), d.measure_between({"A", "B"}, {"D", "C"});
}

void trammel(Draft& d) {
  Draw& c = d.chance;
  if (!c.one_in(4)) d.keep_axes();
  const double angle = c.real(0.3, 1.2), length = c.real(0.8, 1.5);
  const Place p = {length * std::cos(angle), 0, 0}, q = {0, length * std::sin(angle), 0};
  d.fixed("O", {0, 0, 0}), d.point("P", p), d.point("Q", q);
  d.base_body("rod", {"P", "Q"}, {{"T", 0.5 * (p + q) + c.real(0.1, 0.5) * c.direction(2)}});
  d.fixed_vector("x", {1, 0, 0}), d.fixed_vector("y", {0, 1, 0});
  const std::string line = d.on_line("P", "O", "x");
  if (d.turned_as_a_whole() || c.one_in(2)) {
    d.dot_product("x", {"O", "Q"});
  } else {
    d.level("Q", 0);
  }
  const double by = c.real(-0.6, 0.6) * std::min(1.0, d.speed);
  switch (c.below(3)) {
    case 0:
      d.slide(line + ".lambda", p[0], by);
      break;
    case 1:
      d.turn_between("x", {"P", "Q"});
      break;
    default:
      d.turned_as_a_whole() ? d.reach("O", "Q", by) : d.move("Q", 1, by);
  }
  d.measure_angle("P", "Q"), d.measure_coordinate(line + ".lambda"), d.measure_distance("O", "T");
}

}  // namespace assur::mechanisms
