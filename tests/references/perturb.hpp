// The same scene with a worse guess.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "assur/scene.hpp"

namespace assur::references {

// Every coordinate of every guess changes by a uniform random number in [-size, size]; vectors are normalised again.
// Lengths that the scene takes from its guess change with it.
inline Scene perturbed(const Scene& scene, double size, unsigned seed) {
  std::mt19937 random(seed);
  const auto shift = [&](Triple at) {
    for (int i = 0; i < scene.dimension(); ++i) {
      const double in_unit = static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
      at[static_cast<std::size_t>(i)] += size * (2 * in_unit - 1);
    }
    return at;
  };

  SceneBuilder builder(scene.name(), scene.dimension());
  for (const Point& p : scene.points()) builder.add(p.fixed ? p : Point{p.name, shift(p.at), false});
  for (const Vector& v : scene.vectors()) {
    Vector moved = v;
    if (!v.fixed) {
      const Triple at = shift(v.at);
      const double norm = std::hypot(at[0], at[1], at[2]);
      moved.at = {at[0] / norm, at[1] / norm, at[2] / norm};
    }
    builder.add(moved);
  }
  for (const Body& x : scene.bodies()) builder.add(x);
  for (const Constraint& x : scene.constraints()) builder.add(x);
  for (const Driver& x : scene.drivers()) builder.add(x);
  for (const Measure& x : scene.measures()) builder.add(x);
  for (const DeclaredGroup& x : scene.groups()) builder.add(x);
  for (const std::string& x : scene.outputs()) builder.output(x);
  const TimeGrid& time = scene.time();
  return builder.time(time.start, time.end, time.step).build();
}

}  // namespace assur::references
