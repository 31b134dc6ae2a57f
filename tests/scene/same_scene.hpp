// Scenes bit by bit: a text with everything that a scene holds, written without the tables of the library.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "assur/scene.hpp"

namespace assur::test {

class SceneDump {
 public:
  static std::string of(const Scene& scene) {
    SceneDump d;
    d.out_ << std::hexfloat;
    d.put(scene.name(), scene.dimension());
    for (const Point& p : scene.points()) d.line("point", p.name, p.at, p.fixed);
    for (const Vector& v : scene.vectors()) d.line("vector", v.name, v.at, v.fixed, v.unit);
    for (const Body& b : scene.bodies()) {
      d.line("body", b.name, b.origin, b.frame, b.base, b.rigid);
      for (const Member& m : b.points) d.line(" point", m.name, m.local, m.in_ground);
      for (const Member& m : b.vectors) d.line(" vector", m.name, m.local, m.in_ground);
    }
    for (const Joint& j : scene.joints()) {
      d.line("joint", j.name, j.kind.index());
      std::visit([&](const auto& k) { d.kind(k); }, j.kind);
    }
    for (const Constraint& c : scene.constraints()) {
      d.line("constraint", c.name, c.kind.index());
      c.visit([&](const auto& k) { d.kind(k); });
    }
    for (const Driver& r : scene.drivers()) {
      d.line("driver", r.name, r.kind.index(), r.relative, r.sets_difference);
      std::visit([&](const auto& k) { d.kind(k); }, r.kind);
    }
    for (const Measure& m : scene.measures()) {
      d.line("measure", m.name, m.kind.index());
      std::visit([&](const auto& k) { d.kind(k); }, m.kind);
    }
    for (const Limit& l : scene.limits()) {
      d.line("limit", l.quantity, l.min, l.max, static_cast<int>(l.reaction), l.driver);
    }
    for (const DeclaredGroup& g : scene.groups()) d.line("group", g.name, g.unknowns, g.keep);
    d.line("outputs", scene.outputs());
    d.line("time", scene.time().start, scene.time().end, scene.time().step);
    return d.out_.str();
  }

 private:
  template <class... Values>
  void line(const Values&... values) {
    out_ << '\n';
    put(values...);
  }
  template <class... Values>
  void put(const Values&... values) {
    (one(values), ...);
  }
  template <class T>
  void one(const T& value) {
    out_ << value << ' ';
  }
  void one(const Triple& t) { put(t[0], t[1], t[2]); }
  void one(const Direction& d) { put(d.first, d.second); }
  void one(const std::optional<Number>& x) { x ? put("is", *x) : put("none"); }
  void one(const Anchor& a) {
    std::visit([&](const auto& own) { one(own); }, a);
  }
  template <class A, class B>
  void one(const std::pair<A, B>& pair) {
    put(pair.first, pair.second);
  }
  template <class T>
  void one(const std::vector<T>& items) {
    out_ << items.size() << ": ";
    for (const T& item : items) one(item);
  }
  void one(const Harmonic& h) { put(h.amplitude, h.frequency, h.phase); }
  void one(const Law& law) {
    for (const Law::Part& part : law.parts()) {
      line(" law", part.index());
      if (const auto* p = std::get_if<Law::Polynomial>(&part)) put(p->coefficients);
      if (const auto* h = std::get_if<Law::Harmonics>(&part)) put(h->terms, h->offset);
      if (const auto* s = std::get_if<Law::Spline>(&part)) put(s->time, s->value, s->second, s->periodic, s->monotone);
    }
  }

  void kind(const Revolute& k) { put(k.a, k.b, k.at, k.axis); }
  void kind(const Prismatic& k) { put(k.a, k.b, k.axis); }
  void kind(const Cylindrical& k) { put(k.a, k.b, k.at, k.axis); }
  void kind(const Spherical& k) { put(k.a, k.b, k.at); }
  void kind(const Universal& k) { put(k.a, k.b, k.at, k.axis_a, k.axis_b); }
  void kind(const Planar& k) { put(k.a, k.b, k.normal); }
  void kind(const Fixed& k) { put(k.a, k.b); }
  void kind(const Distance& k) { put(k.p, k.q, k.value); }
  void kind(const EqualDistance& k) { put(k.p, k.q, k.r, k.s); }
  void kind(const Dot& k) { put(k.d, k.e, k.value); }
  void kind(const Parallel& k) { put(k.d, k.e); }
  void kind(const Linear& k) { put(k.terms, k.value); }
  void kind(const FixedCoordinate& k) { put(k.coordinate, k.value); }
  void kind(const OnLine& k) { put(k.p, k.a, k.d); }
  void kind(const OnPlane& k) { put(k.p, k.a, k.d, k.e); }
  void kind(const Gear& k) { put(k.a, k.b, k.ratio); }
  void kind(const Callback& k) { put(k.coordinates, k.equations, k.tolerance, k.teeth); }
  void kind(const PointAngle& k) { put(k.a, k.b, k.axis, k.law); }
  void kind(const RelativeAngle& k) { put(k.d, k.e, k.axis, k.law); }
  void kind(const DrivenDistance& k) { put(k.a, k.b, k.law); }
  void kind(const DrivenCoordinate& k) { put(k.coordinate, k.law); }
  void kind(const Pose& k) { put(k.body, k.translation, k.rotation); }
  void kind(const AbsoluteAngle& k) { put(k.a, k.b); }
  void kind(const AngleBetween& k) { put(k.d, k.e, k.axis); }
  void kind(const MeasuredDistance& k) { put(k.a, k.b); }
  void kind(const MeasuredCoordinate& k) { put(k.coordinate); }
  void kind(const Combination& k) { put(k.terms, k.constant); }
  void kind(const Orientation& k) { put(k.body, static_cast<int>(k.part)); }

  std::ostringstream out_;
};

// The scene that is read from the text of this scene; expects that both are the same, bit by bit, and that writing it
// again gives the same text.
inline Scene written_and_read(const Scene& scene) {
  const std::string text = write_scene(scene);
  Scene again = parse_scene(text, scene.name());
  EXPECT_EQ(SceneDump::of(again), SceneDump::of(scene)) << text;
  EXPECT_EQ(write_scene(again), text);
  return again;
}

}  // namespace assur::test
