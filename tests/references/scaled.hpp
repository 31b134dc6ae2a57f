// The same mechanism in another unit of length.
#pragma once

#include <cmath>
#include <string>
#include <unordered_map>
#include <variant>

#include "assur/scene.hpp"

namespace assur::references {

// Power of length of every point, vector, auxiliary scalar and measure, by name.
inline std::unordered_map<std::string, int> powers_of_length(const Scene& scene) {
  std::unordered_map<std::string, int> power;
  for (const Point& p : scene.points()) power[p.name] = 1;
  for (const Vector& v : scene.vectors()) power[v.name] = 0;
  for (const Body& b : scene.bodies()) {
    for (const Member& m : b.points) power[m.name] = 1;
    for (const Member& m : b.vectors) power[m.name] = 0;
  }
  const auto of = [&](const Direction& d) { return d.is_pair() ? 1 : power.at(d.first); };
  for (const Constraint& c : scene.constraints()) {
    if (const auto* line = c.as<OnLine>()) power[c.name + ".lambda"] = 1 - of(line->d);
    if (const auto* parallel = c.as<Parallel>()) power[c.name + ".lambda"] = of(parallel->e) - of(parallel->d);
  }
  for (const Measure& m : scene.measures()) {
    power[m.name] = 0;
    if (std::holds_alternative<MeasuredDistance>(m.kind)) power[m.name] = 1;
    if (const auto* c = std::get_if<MeasuredCoordinate>(&m.kind)) {
      const bool of_point =
          c->coordinate.ends_with(".x") || c->coordinate.ends_with(".y") || c->coordinate.ends_with(".z");
      power[m.name] = power.at(of_point ? c->coordinate.substr(0, c->coordinate.size() - 2) : c->coordinate);
    }
  }
  return power;
}

inline Law scaled(const Law& law, double factor) {
  Law out;
  for (const Law::Part& part : law.parts()) {
    if (const auto* polynomial = std::get_if<Law::Polynomial>(&part)) {
      std::vector<Number> c = polynomial->coefficients;
      for (Number& x : c) x *= factor;
      out = out + Law::polynomial(c);
    } else if (const auto* harmonics = std::get_if<Law::Harmonics>(&part)) {
      std::vector<Harmonic> terms = harmonics->terms;
      for (Harmonic& h : terms) h.amplitude *= factor;
      out = out + Law::harmonics(terms, harmonics->offset * factor);
    } else if (const auto* spline = std::get_if<Law::Spline>(&part)) {
      std::vector<double> v = spline->value;
      for (double& x : v) x *= factor;
      out = out + Law::table(spline->time, v, spline->periodic);
    } else {
      const auto motion = std::get<Law::Function>(part).motion;
      out = out + Law::function([motion, factor](double t) {
              const Motion m = motion(t);
              return Motion{m.value * factor, m.rate * factor, m.acceleration * factor};
            });
    }
  }
  return out;
}

// Multiplies every length exactly by 2^exponent. Not for scenes with callbacks, because the numbers in callbacks cannot
// be scaled.
inline Scene scaled(const Scene& scene, int exponent) {
  const double factor = std::ldexp(1.0, exponent);
  const auto power = powers_of_length(scene);
  const auto length = [factor](Triple at) {
    for (Number& x : at) x *= factor;
    return at;
  };
  const auto of = [&](const Direction& d) { return d.is_pair() ? 1 : power.at(d.first); };

  SceneBuilder builder(scene.name(), scene.dimension());
  for (const Point& p : scene.points()) builder.add(Point{p.name, length(p.at), p.fixed});
  for (const Vector& v : scene.vectors()) builder.add(v);
  for (Body b : scene.bodies()) {
    for (Member& m : b.points) m.local = length(m.local);
    builder.add(b);
  }
  for (Constraint c : scene.constraints()) {
    if (auto* distance = std::get_if<Distance>(&c.kind)) {
      if (distance->value) *distance->value *= factor;
    } else if (const Dot* own = c.as<Dot>()) {
      Dot dot = *own;
      if (dot.value) *dot.value *= std::ldexp(1.0, exponent * (of(dot.d) + of(dot.e)));
      c.kind = dot;
    } else if (auto* linear = std::get_if<Linear>(&c.kind)) {
      bool points = false;
      for (const auto& [name, f] : linear->terms) points = points || power.at(name) == 1;
      if (points) linear->value = length(linear->value);
      for (auto& [name, f] : linear->terms) f *= points && power.at(name) == 0 ? factor : 1;
    } else if (auto* coordinate = std::get_if<FixedCoordinate>(&c.kind)) {
      coordinate->value *= factor;
    }
    builder.add(c);
  }
  for (Driver d : scene.drivers()) {
    if (auto* distance = std::get_if<DrivenDistance>(&d.kind)) {
      distance->law = scaled(distance->law, factor);
    } else if (auto* coordinate = std::get_if<DrivenCoordinate>(&d.kind)) {
      coordinate->law = scaled(coordinate->law, factor);
    } else if (auto* pose = std::get_if<Pose>(&d.kind)) {
      for (Law& law : pose->translation) law = scaled(law, factor);
    }
    builder.add(d);
  }
  for (const Measure& m : scene.measures()) builder.add(m);
  for (const DeclaredGroup& g : scene.groups()) builder.add(g);
  for (const std::string& output : scene.outputs()) builder.output(output);
  return builder.time(scene.time().start, scene.time().end, scene.time().step).build();
}

}  // namespace assur::references
