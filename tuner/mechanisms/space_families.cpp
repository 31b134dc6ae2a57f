// Families in space.
#include <algorithm>
#include <cmath>
#include <utility>

#include "mechanisms/families.hpp"

namespace assur::mechanisms {
namespace {

// An arm that turns about a fixed axis through a pivot, with or without driver; its hinge is modelled in three ways.
void arm(Draft& d, const std::string& pivot, const std::string& end, const Place& at, const Place& axis, bool driven) {
  Draw& c = d.chance;
  const std::string n = "n_" + end, zero = "x_" + end;
  d.fixed_vector(n, axis);
  const Place offset = at - d.at(pivot);
  const std::size_t way = c.below(3);
  if (way == 2) {  // a body with a frame about the axis
    const std::string u = "u_" + end, v = "v_" + end;
    const Place x = across(axis, c);
    d.vector(u, x), d.vector(v, cross(axis, x));
    d.frame_body("arm_" + end, pivot, {u, v, n}, {{end, at}});
    if (!driven) return;
    d.fixed_vector(zero, c.one_in(2) ? x : across(axis, c));
    d.turn_between(zero, u, n);
    return;
  }
  d.point(end, at);
  if (driven && way == 0) {
    if (c.one_in(2)) d.distance(pivot, end);
    d.turn(pivot, end, n);
    return;
  }
  d.distance(pivot, end);
  d.dot_product({pivot, end}, n);
  if (!driven) return;
  const Place flat = unit(offset - dot(offset, axis) * axis);
  d.fixed_vector(zero, c.one_in(3) ? flat : turned(flat, axis, c.real(-3, 3)));
  d.turn_between(zero, {pivot, end}, n);
}

// A serial robot of bodies that share points and axes; each joint is driven.
// The platform of a parallel manipulator; corners by name.
void platform(Draft& d, const Place& o, const std::map<std::string, Place>& corners, bool along_axes) {
  Draw& c = d.chance;
  if (along_axes || corners.size() != 3 || c.one_in(2)) {
    const Place u = along_axes ? Place{1, 0, 0} : c.direction();
    const Place v = along_axes ? Place{0, 1, 0} : across(u, c);
    d.point("O", o), d.vector("u", u), d.vector("v", v), d.vector("w", cross(u, v));
    d.frame_body("platform", "O", {"u", "v", "w"}, corners);
    d.measure_between("u", {"O", corners.begin()->first});
  } else {
    for (const auto& [name, at] : corners) d.point(name, at);
    const Place tip = o + Place{0.1, 0.1, 0.4};
    d.base_body("platform", {"P0", "P1", "P2"}, {{"tip", tip}}, {{"up", {0, 0, 1}}});
  }
}

// Six legs between ground and platform: driven lengths (the forward problem), cranks with rods, or the pose.
// A planar loop in space with redundant equations: bodies whose frames share the axes of their hinges.
// Two folding legs at a right angle lift a platform; by the count of equations it cannot move.
void sarrus(Draft& d) {
  Draw& c = d.chance;
  const double height = c.real(0.5, 1.1), radius = c.real(0.6, 1);
  const Place o = {0, 0, height};
  d.fixed_vector("x", {1, 0, 0}), d.fixed_vector("y", {0, 1, 0}), d.fixed_vector("z", {0, 0, 1});
  d.point("O", o), d.vector("u", {1, 0, 0}), d.vector("v", {0, 1, 0}), d.vector("w", {0, 0, 1});
  d.frame_body("platform", "O", {"u", "v", "w"}, {{"C0", o + Place{radius, 0, 0}}, {"C1", o + Place{0, radius, 0}}});
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string base = text("A", i), knee = text("B", i), top = text("C", i), axis = i == 0 ? "y" : "x";
    const Place out = i == 0 ? Place{1, 0, 0} : Place{0, 1, 0};
    d.fixed(base, radius * out);
    d.point(knee, radius * out + c.real(0.4, 0.6) * o + c.real(0.3, 0.8) * out);
    d.distance(base, knee), d.distance(knee, top);
    d.dot_product({base, knee}, axis), d.dot_product({knee, top}, axis);
  }
  d.dot_product("v", "x"), d.dot_product("v", "z"), d.dot_product("u", "y"), d.dot_product("u", "z");
  if (c.one_in(2)) {
    d.fixed_vector("zero", across({0, 1, 0}, c));
    d.turn_between("zero", {"A0", "B0"}, "y");
  } else {
    d.fixed("F", {0, 0, 0});
    d.reach("F", "O", c.real(-0.3, 0.3) * std::min(1.0, d.speed));
  }
  d.measure_between({"A1", "B1"}, {"B1", "C1"}, "x"), d.measure_between("u", "x");
}

// Bennett's linkage, a1 / sin alpha1 = a2 / sin alpha2: moves although it has an excess equation. Else Sarrus' linkage.
// Two shafts joined by a cross; the second one carries an arm.
// Double wishbones: two arms, an upright on three points, a tie rod; driven by an arm or the height of the wheel.
// Rods between lines and planes.

}  // namespace

void rssr(Draft& d) {
  Draw& c = d.chance;
  d.fixed("A", {0, 0, 0}), d.fixed("D", {c.real(1, 2), c.real(-0.5, 0.5), c.real(-0.5, 0.5)});
  const Place axis = c.one_in(2) ? Place{0, 0, 1} : c.direction();
  const Place b = c.real(0.2, 0.5) * across(axis, c) + (c.one_in(3) ? 0.1 : 0.0) * axis;
  arm(d, "A", "B", b, axis, true);
  const Place other = c.direction();
  const Place cc = d.at("D") + c.real(0.6, 1.1) * across(other, c);
  if (c.one_in(4)) {  // RSSP: a slider instead of the rocker
    d.fixed_vector("rail", other), d.point("C", d.at("D") + c.real(0.3, 0.8) * other);
    const std::string line = d.on_line("C", "D", "rail");
    d.measure_coordinate(line + ".lambda");
  } else {
    arm(d, "D", "C", cc, other, false);
    d.measure_between({"A", "D"}, {"D", "C"}, "n_C");
  }
  d.distance("B", "C");
  d.measure_between({"A", "B"}, {"B", "C"});
  for (std::size_t i = 0; i < c.below(3); ++i) {  // further points, each on three spheres
    const std::string t = text("T", i), g = text("G", i), h = text("H", i);
    const Place at = d.at("C") + Place{c.real(-0.2, 0.2), c.real(-0.2, 0.2), c.real(0.8, 1.2)};
    d.point(t, at), d.fixed(g, at + Place{1, c.real(-0.2, 0.2), 0}), d.fixed(h, at + Place{c.real(-0.2, 0.2), 1, 0});
    d.distance("C", t), d.distance(g, t), d.distance(h, t);
  }
}

void robot(Draft& d) {
  Draw& c = d.chance;
  Place o = {0, 0, 0}, axis = {0, 0, 1}, x = {1, 0, 0};
  d.fixed("O0", o), d.fixed_vector("z0", axis), d.fixed_vector("x0", x);
  const std::size_t joints = 2 + c.below(4);
  std::string origin = "O0", z = "z0", last_u = "x0";
  for (std::size_t i = 1; i <= joints; ++i) {
    const std::string u = text("u", i), v = text("v", i), next = text("O", i), n = text("z", i);
    const Place ui = turned(unit(x - dot(x, axis) * axis), axis, c.real(-2, 2));
    d.vector(u, ui), d.vector(v, cross(axis, ui));
    const Place to = o + c.real(0.3, 1) * c.direction();
    const Place turned_axis = c.one_in(3) ? axis : c.one_in(2) ? ui : c.direction();
    std::map<std::string, Place> vectors = {{n, turned_axis}};
    // The direction of this body from which the angle of the next joint is measured, perpendicular to the next axis.
    const std::string begin = text("b", i);
    vectors[begin] = across(turned_axis, c);
    if (c.one_in(4) && i < joints) {  // a prismatic joint after the hinge
      const std::string rail = text("w", i), slider = text("S", i);
      vectors[rail] = c.direction();
      d.point(next, o + 0.6 * vectors[rail]);
      d.frame_body(text("link", i), origin, {u, v, z}, {{slider, o}}, vectors);
      const std::string line = d.on_line(next, slider, rail);
      d.slide(line + ".lambda", 0.6, c.real(-0.4, 0.6));
      o = d.at(next);
    } else {
      d.frame_body(text("link", i), origin, {u, v, z}, {{next, to}}, vectors);
      o = to;
    }
    d.turn_between(last_u, u, z);
    origin = next, z = n, last_u = begin, axis = turned_axis, x = d.at(begin);
  }
  d.fixed("target", {c.real(-1, 1), c.real(-1, 1), c.real(-1, 1)});
  d.measure_distance("target", origin);
  d.measure_between("x0", last_u);
  d.measure_between("x0", last_u, "z0");
}

void stewart(Draft& d) {
  Draw& c = d.chance;
  const bool by_pose = c.one_in(3);
  if (by_pose) d.keep_axes();
  const Place o = {c.real(-0.1, 0.1), c.real(-0.1, 0.1), c.real(0.8, 1.4)};
  std::map<std::string, Place> corners;
  const double size = c.real(0.4, 0.8);
  for (std::size_t i = 0; i < 6; ++i) {
    const double at = kPi / 3 * static_cast<double>(i) + (i % 2 == 0 ? 0.35 : -0.35) + c.real(-0.1, 0.1);
    corners[text("P", i)] = o + polar(size, at) + Place{0, 0, c.real(-0.1, 0.1)};
  }
  platform(d, o, corners, by_pose);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string base = text("A", i), knee = text("B", i), top = text("P", i);
    const double at = kPi / 3 * static_cast<double>(i) + (i % 2 == 0 ? -0.3 : 0.3) + c.real(-0.1, 0.1);
    d.fixed(base, polar(c.real(1, 1.4), at) + Place{0, 0, c.real(-0.1, 0.1)});
    const std::size_t way = c.below(by_pose ? 2 : 3);
    if (way < 1) {
      if (!by_pose) d.reach(base, top, c.real(-0.25, 0.25) * std::min(1.0, d.speed));
      d.measure_distance(base, top);
      continue;
    }
    const Place span = d.at(top) - d.at(base), side = across(span, c);
    const Place elbow = d.at(base) + c.real(0.3, 0.5) * span + c.real(0.3, 0.6) * side;
    arm(d, base, knee, elbow, unit(cross(elbow - d.at(base), span)), !by_pose);
    d.distance(knee, top);
  }
  if (by_pose) d.pose("platform", "O", 0.2 * std::min(1.0, d.speed), 0.4 * std::min(1.0, d.speed));
  if (!by_pose) d.speed = std::min(d.speed, 0.6);
}

void three_rps(Draft& d) {
  Draw& c = d.chance;
  const Place o = {0, 0, c.real(0.8, 1.4)};
  std::map<std::string, Place> corners;
  for (std::size_t i = 0; i < 3; ++i)
    corners[text("P", i)] = o + polar(c.real(0.4, 0.7), 2.09 * static_cast<double>(i));
  platform(d, o, corners, false);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string base = text("A", i), top = text("P", i), n = text("n", i);
    const double angle = 2.09 * static_cast<double>(i);
    d.fixed(base, polar(c.real(0.8, 1.2), angle));
    d.fixed_vector(n, unit(cross({0, 0, 1}, d.at(top) - d.at(base))));
    d.dot_product({base, top}, n);
    d.reach(base, top, c.real(-0.3, 0.3) * std::min(1.0, d.speed));
  }
}

void delta(Draft& d) {
  Draw& c = d.chance;
  const std::size_t way = c.below(3);  // 0: single rods to a translating body; 1: six rods; 2: six equal rods
  const bool by_pose = c.one_in(3);
  if (by_pose) d.keep_axes();
  const Place o = {c.real(-0.15, 0.15), c.real(-0.15, 0.15), -c.real(0.7, 1)};
  const double R = c.real(0.3, 0.5), r = c.real(0.08, 0.2), L = c.real(0.3, 0.5), half = c.real(0.05, 0.1);
  std::map<std::string, Place> corners;
  std::vector<Place> out, side, knee;
  for (std::size_t i = 0; i < 3; ++i) {
    out.push_back(polar(1, 2 * kPi / 3 * static_cast<double>(i) + 0.3)), side.push_back(cross({0, 0, 1}, out[i]));
    if (way == 0) {
      corners[text("P", i)] = o + r * out[i];
    } else {
      corners[text("P", i)] = o + r * out[i] + half * side[i], corners[text("Q", i)] = o + r * out[i] - half * side[i];
    }
  }
  d.point("O", o);
  if (way == 0) {
    d.shifted_body("platform", "O", corners);
  } else {
    d.vector("u", {1, 0, 0}), d.vector("v", {0, 1, 0}), d.vector("w", {0, 0, 1});
    d.frame_body("platform", "O", {"u", "v", "w"}, corners);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i), base = "A" + k, n = "n" + k;
    const double tilt = c.real(-0.5, 0.5);
    const Place pivot = R * out[i], elbow = pivot + L * (std::cos(tilt) * out[i] + std::sin(tilt) * Place{0, 0, 1});
    d.fixed(base, pivot);
    if (way == 0) {
      arm(d, base, "B" + k, elbow, side[i], !by_pose);
      d.distance("B" + k, "P" + k);
      continue;
    }
    d.fixed_vector(n, side[i]), d.fixed_vector("x" + k, out[i]);
    const Place u = unit(elbow - pivot);
    d.vector("a" + k, u), d.vector("b" + k, cross(side[i], u));
    d.frame_body("arm" + k, base, {"a" + k, "b" + k, n},
                 {{"B" + k, elbow + half * side[i]}, {"C" + k, elbow - half * side[i]}});
    if (!by_pose) d.turn_between("x" + k, "a" + k, n);
    d.distance("B" + k, "P" + k), d.distance("C" + k, "Q" + k);
    if (by_pose || way < 2) continue;
    d.equal_distance("B" + k, "P" + k, "C" + k, "Q" + k);
  }
  if (by_pose) {
    if (way == 0) {
      d.pose("platform", "O", 0.3, 0);
    } else {
      for (int k = 0; k < 3; ++k) d.move("O", k, c.real(-0.15, 0.15));
    }
  }
  d.measure_distance("A0", "O");
}

void loop_in_space(Draft& d) {
  Draw& c = d.chance;
  const Place a = {0, 0, 0}, dd = {c.real(1.5, 2.2), c.real(-0.2, 0.2), 0};
  const Place b = polar(c.real(0.3, 0.6), c.real(-3, 3)), cc = dd + polar(c.real(1.1, 1.5), c.real(1, 2));
  d.fixed("A", a), d.fixed("D", dd), d.fixed_vector("z", {0, 0, 1}), d.fixed_vector("x", {1, 0, 0});
  const std::size_t way = c.below(4);
  if (way == 0) {  // points and dot products
    d.point("B", b), d.point("C", cc);
    d.distance("A", "B"), d.distance("B", "C"), d.distance("D", "C");
    d.dot_product({"A", "B"}, "z"), d.dot_product({"B", "C"}, "z"), d.dot_product({"D", "C"}, "z");
    c.one_in(2) ? d.turn_between("x", {"A", "B"}, "z") : d.turn("A", "B", "z");
    d.measure_between("x", {"D", "C"}, "z");
    return;
  }
  // bodies: crank and rocker about z, the coupler about z or about an axis that crank and coupler share
  const auto body = [&](const std::string& k, const std::string& origin, const std::map<std::string, Place>& points,
                        const std::map<std::string, Place>& vectors, const std::string& axis) {
    const Place u = polar(1, c.real(-3, 3));
    d.vector("u" + k, u), d.vector("v" + k, cross({0, 0, 1}, u));
    d.frame_body("body" + k, origin, {"u" + k, "v" + k, axis}, points, vectors);
  };
  body("1", "A", {{"B", b}}, {{"z1", {0, 0, 1}}}, "z");
  if (way == 1) {
    body("2", "B", {{"C", cc}, {"T", b + Place{0.3, 0.4, 0.2}}}, {}, "z");
    body("3", "D", {{"C3", cc}}, {}, "z");
    d.constraint_equal("C", "C3");
  } else if (way == 2) {  // the end of the rocker is a point of the coupler: one distance
    body("2", "B", {{"C", cc}}, {{"z2", {0, 0, 1}}}, "z1");
    d.distance("D", "C"), d.dot_product({"D", "C"}, "z");
    d.parallel("z", "z2");
  } else {  // a slider instead
    d.fixed_vector("rail", {1, 0, 0});
    body("2", "B", {{"C", cc}}, {{"z2", {0, 0, 1}}}, "z1");
    const std::string line = d.on_line("C", "D2", "rail");
    d.fixed("D2", cc - Place{c.real(0.3, 0.8), 0, 0});
    d.measure_coordinate(line + ".lambda");
  }
  d.turn_between("x", "u1", "z");
  d.measure_between("u1", "u2", "z"), d.measure_between("x", "u2");
}

void bennett(Draft& d) {
  Draw& c = d.chance;
  const double alpha = c.real(0.3, 1.2), beta = c.real(0.3, 1.2), a = 1, b = std::sin(beta) / std::sin(alpha);
  // Hinge axes z_i and common normals; closure by tan(t1/2) tan(t2/2) = sin((beta+alpha)/2) / sin((beta-alpha)/2).
  if (std::abs(beta - alpha) < 0.1) return sarrus(d);
  const double t1 = c.real(0.5, 2.6);
  const double t2 = 2 * std::atan(std::sin((beta + alpha) / 2) / std::sin((beta - alpha) / 2) / std::tan(t1 / 2));
  std::vector<Place> o = {{0, 0, 0}}, z = {{0, 0, 1}}, x = {{1, 0, 0}};
  const double length[4] = {a, b, a, b}, twist[4] = {alpha, beta, alpha, beta}, angle[4] = {t1, t2, -t1, -t2};
  for (std::size_t i = 0; i < 4; ++i) {
    o.push_back(o[i] + length[i] * x[i]);
    z.push_back(turned(z[i], x[i], twist[i]));
    x.push_back(turned(x[i], z[i + 1], angle[(i + 1) % 4]));
  }
  if (norm(o[4]) > 1e-9 || norm(z[4] - z[0]) > 1e-9) return sarrus(d);  // the linkage does not close on this branch
  d.fixed("A", o[0]), d.fixed("B", o[1]), d.fixed_vector("z0", z[0]), d.fixed_vector("z1", z[1]);
  d.fixed_vector("x0", x[0]);
  d.point("C", o[2]), d.point("D", o[3]), d.vector("z2", z[2]), d.vector("z3", z[3]);
  // Link i with the points and axes of both its hinges.
  const auto link = [&](const std::string& p, const std::string& q, const std::string& m, const std::string& n) {
    d.distance(p, q), d.dot_product({p, q}, m), d.dot_product({p, q}, n), d.dot_product(m, n);
  };
  link("B", "C", "z1", "z2"), link("C", "D", "z2", "z3"), link("A", "D", "z0", "z3");
  d.turn_between("x0", {"A", "D"}, "z0");
  d.measure_between("x0", {"B", "C"}, "z1");
}

void cardan(Draft& d) {
  Draw& c = d.chance;
  const double bend = c.real(0.1, 1.1);
  const Place first = {0, 0, 1}, second = turned(first, {0, 1, 0}, bend);
  d.fixed("O", {0, 0, 0}), d.fixed_vector("a", first), d.fixed_vector("b", second), d.fixed_vector("x", {1, 0, 0});
  const Place u = polar(1, c.real(-3, 3)), p = unit(cross(second, u));
  d.vector("u", u), d.vector("v", cross(first, u));
  d.frame_body("shaft1", "O", {"u", "v", "a"}, {});
  d.vector("p", p), d.vector("q", cross(second, p));
  d.frame_body("shaft2", "O", {"p", "q", "b"}, {{"T", 0.5 * p + c.real(0.2, 1) * second}});
  d.dot_product("u", "p");
  d.fixed_vector("y", across(second, c));
  c.one_in(3) ? d.turn_between("y", "p", "b") : d.turn_between("x", "u", "a");
  d.measure_between("y", "p", "b"), d.measure_between("x", "u", "a"), d.measure_between("u", "q");
}

void wishbone(Draft& d) {
  Draw& c = d.chance;
  const bool by_height = c.one_in(2);
  if (by_height) d.keep_axes();
  const auto near = [&](Place p) { return p + Place{c.real(-0.05, 0.05), c.real(-0.05, 0.05), c.real(-0.05, 0.05)}; };
  const Place low = near({0, 0.7, 0.2}), high = near({0, 0.6, 0.6}), tie = near({0.15, 0.65, 0.3});
  d.fixed("L1", near({-0.2, 0.3, 0.2})), d.fixed("L2", near({0.2, 0.3, 0.2}));
  d.fixed("U1", near({-0.15, 0.35, 0.55})), d.fixed("U2", near({0.15, 0.35, 0.55})),
      d.fixed("R", near({0.15, 0.3, 0.3}));
  d.point("L", low), d.point("U", high), d.point("T", tie);
  d.distance("L1", "L"), d.distance("L2", "L"), d.distance("U1", "U"), d.distance("U2", "U"), d.distance("R", "T");
  const Place wheel = near({0, 0.8, 0.35});
  d.base_body("upright", {"L", "U", "T"}, {{"W", wheel}}, {{"spin", {0, 1, 0}}});
  d.fixed_vector("y", c.one_in(8) ? Place{0, 1, 0} : across({0, 1, 0}, c));
  if (by_height) {
    d.move(c.one_in(2) ? "W" : "L", 2, c.real(-0.12, 0.12));
  } else {
    d.fixed("S", near({0, 0.35, 0.8}));
    d.reach("S", "L", c.real(-0.1, 0.1));  // the spring's length
  }
  d.measure_between("spin", "y");
  if (c.one_in(2)) d.measure_distance("R", "W");
}

void on_rails(Draft& d) {
  Draw& c = d.chance;
  d.fixed("A", {0, 0, 0}), d.fixed("D", {0.5, 1, 0.2});
  const Place rail = c.direction(), d1 = c.direction(), d2 = across(d1, c);
  d.fixed_vector("r", rail), d.fixed_vector("d1", d1), d.fixed_vector("d2", d2);
  const Place p = c.real(0.2, 0.6) * rail, q = Place{0.5, 1, 0.2} + c.real(0.2, 0.6) * d1 + c.real(0.2, 0.6) * d2;
  d.point("P", p), d.point("Q", q);
  const std::string line = d.on_line("P", "A", "r"), plane = d.on_plane("Q", "D", "d1", "d2");
  d.slide(line + ".lambda", norm(p), c.real(-0.5, 0.5));
  d.distance("P", "Q");
  const Place mu = q - Place{0.5, 1, 0.2};
  if (c.one_in(2)) {
    d.slide(plane + ".mu", dot(mu, d2), c.real(-0.3, 0.3));
  } else {
    d.fixed("E", q + c.real(0.6, 1.2) * c.direction());
    d.distance("E", "Q");
  }
  d.measure_coordinate(plane + ".lambda"), d.measure_distance("A", "Q"), d.measure_between("r", {"P", "Q"});
}

}  // namespace assur::mechanisms
