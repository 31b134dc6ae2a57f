// A small mechanism for every kind of constraint, driver and body, with its motion in closed form.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "references/posture.hpp"

namespace assur::kinds {

using references::Posture;
using references::Quad;
using references::QuadJet;
using references::Vec;
using Where = Vec<QuadJet>;

// Moving points, vectors and auxiliary scalars (their value in [0]) at time t, without members of bodies.
using Path = std::function<Posture<QuadJet>(double t)>;

struct Kind {
  std::string name;
  Scene scene;  // as many equations as unknowns, regular at every time of its grid
  Path path;
  // Expected members of bodies.
  Path members = [](double) { return Posture<QuadJet>{}; };
};
inline void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }  // for failed tests

[[nodiscard]] std::vector<Kind> in_the_plane();
[[nodiscard]] std::vector<Kind> in_space();

// ---- helpers

inline const Law kTurn = Law::polynomial({0.3, 1.1, 0.2});
inline const Law kSwing = Law::harmonics({{0.4, 0.3, 0.2}}, 0.9);
inline const Law kSlide = Law::polynomial({0.5, 0.25, -0.125});

inline QuadJet at(const Law& law, double t) { return evaluate<Quad>(law, Quad(t)); }
inline Where scalar(const QuadJet& s) { return {s, QuadJet{}, QuadJet{}}; }
inline Where fixed(double x, double y, double z = 0) { return {QuadJet{x}, QuadJet{y}, QuadJet{z}}; }
inline Triple start(const Path& path, const std::string& name) {
  const Where at = path(0).at(name);
  return {static_cast<double>(at[0].value), static_cast<double>(at[1].value), static_cast<double>(at[2].value)};
}
inline double start_scalar(const Path& path, const std::string& name) { return start(path, name)[0]; }

// A law with the value of(path).
template <class Of>
Law follow(const Path& path, Of of) {
  return Law::function([path, of](double t) {
    const QuadJet j = of(path(t));
    return Motion{static_cast<double>(j.value), static_cast<double>(j.rate), static_cast<double>(j.acceleration)};
  });
}
inline Law follow_coordinate(const Path& path, const std::string& name, std::size_t k) {
  return follow(path, [name, k](const Posture<QuadJet>& at) { return at.at(name)[k]; });
}

// Adds the points and vectors of a path at its start.
inline SceneBuilder& place(SceneBuilder& b, const Path& path, const std::vector<std::string>& points,
                           const std::vector<std::string>& vectors = {}) {
  for (const std::string& p : points) b.point(p, start(path, p));
  for (const std::string& v : vectors) b.vector(v, start(path, v));
  return b;
}

inline SceneBuilder& grid(SceneBuilder& b) { return b.time(0, 1, 0.125); }

}  // namespace assur::kinds
