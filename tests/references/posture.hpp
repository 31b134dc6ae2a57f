// Positions of all parts of a scene, in any arithmetic, and residuals of its equations. Uses only the description of
// the scene, independently of the equations of the library.
#pragma once

#include <string>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "assur/scene.hpp"
#include "references/quad.hpp"
#include "scene/law_evaluate.hpp"

namespace assur::references {

// Points, vectors and auxiliary scalars ("slide.lambda", in [0]) by name; T = double, Quad, Jet<...>.
template <class T>
using Posture = std::unordered_map<std::string, Vec<T>>;

// Fixed parts are at their place, all others at their guess.
template <class T>
Posture<T> at_guess(const Scene& scene) {
  Posture<T> posture;
  for (const Point& p : scene.points()) posture[p.name] = exactly<T>(p.at);
  for (const Vector& v : scene.vectors()) posture[v.name] = exactly<T>(v.at);
  return posture;
}

// Adds the members of bodies with an origin, or with a base of two points in the plane.
template <class T>
void add_members(const Scene& scene, Posture<T>& posture) {
  for (const Body& body : scene.bodies()) {
    std::vector<Vec<T>> axes;
    for (const std::string& name : body.frame) axes.push_back(posture.at(name));
    if (body.base.size() == 2) axes = {unit(posture.at(body.base[1]) - posture.at(body.base[0]))};
    if (axes.empty()) axes = {exactly<T>({1, 0, 0}), exactly<T>({0, 1, 0}), exactly<T>({0, 0, 1})};
    if (axes.size() == 1) axes.push_back({-axes[0][1], axes[0][0], T{0}});
    const auto turned = [&axes](const Triple& local) {
      Vec<T> sum = exactly<T>({0, 0, 0});
      for (std::size_t i = 0; i < axes.size(); ++i) sum = sum + T{local[i].value()} * axes[i];
      return sum;
    };
    const std::string& origin = body.base.empty() ? body.origin : body.base[0];
    for (const Member& m : body.points) posture[m.name] = posture.at(origin) + turned(m.local);
    for (const Member& m : body.vectors) posture[m.name] = turned(m.local);
  }
}

// The residual of one equation; lengths are relative to the length in the equation.
template <class T>
struct Left {
  std::string equation;
  T value;
};

template <class T>
class Equations {
 public:
  // The posture must contain everything except members of bodies; these are added.
  Equations(const Scene& scene, Posture<T> posture) : scene_(scene), at_(std::move(posture)) {
    add_members(scene, at_);
    for (const Vector& v : scene.vectors()) {
      if (!v.fixed && v.unit) leave("|" + v.name + "| = 1", dot(at(v.name), at(v.name)) - T{1});
    }
    for (const Body& body : scene.bodies()) {
      if (body.frame.size() != 3) continue;
      leave("body " + body.name, dot(at(body.frame[0]), at(body.frame[1])));
      leave("body " + body.name, at(body.frame[2]) - cross(at(body.frame[0]), at(body.frame[1])));
    }
    for (const Constraint& c : scene.constraints()) {
      c.visit([&](const auto& kind) { constrain(c.name, kind); });
    }
  }

  // Adds the residuals of the drivers, with their laws at a time.
  template <class LawAt>
  void drive(const LawAt& law_at) {
    for (const Driver& d : scene_.drivers()) {
      std::visit([&](const auto& kind) { driven(d.name, kind, law_at); }, d.kind);
    }
  }

  [[nodiscard]] const std::vector<Left<T>>& left() const { return left_; }
  [[nodiscard]] const Vec<T>& at(const std::string& name) const { return at_.at(name); }

  // The vector of that name, or the vector from one point to the other.
  [[nodiscard]] Vec<T> direction(const Direction& d) const {
    return d.is_pair() ? at(d.second) - at(d.first) : at(d.first);
  }

 private:
  void leave(const std::string& equation, const T& value) { left_.push_back({equation, value}); }
  void leave(const std::string& equation, const Vec<T>& value) {
    for (int i = 0; i < scene_.dimension(); ++i) leave(equation, value[static_cast<std::size_t>(i)]);
  }
  void length(const std::string& name, const std::string& p, const std::string& q, const T& value) {
    const Vec<T> d = at(q) - at(p);
    leave(name, dot(d, d) / (value * value) - T{1});
  }

  // An omitted value is taken from the guess, where the equation holds by definition.
  void constrain(const std::string& name, const Distance& c) {
    if (c.value) length(name, c.p, c.q, T{c.value->value()});
  }
  void constrain(const std::string& name, const Dot& c) {
    if (c.value) leave(name, dot(direction(c.d), direction(c.e)) - T{c.value->value()});
  }
  void constrain(const std::string& name, const Linear& c) {
    Vec<T> sum = exactly<T>({-c.value[0], -c.value[1], -c.value[2]});
    for (const auto& [item, factor] : c.terms) sum = sum + T{factor.value()} * at(item);
    leave(name, sum);
  }
  // lambda comes from the posture, or else from the best fit.
  void constrain(const std::string& name, const OnLine& c) {
    const Vec<T> offset = at(c.p) - at(c.a), d = direction(c.d);
    const auto known = at_.find(name + ".lambda");
    const T lambda = known != at_.end() ? known->second[0] : dot(offset, d) / dot(d, d);
    leave(name, offset - lambda * d);
  }
  template <class Other>
  void constrain(const std::string& name, const Other&) {
    throw Error(Error::Kind::input, name + ": the test's own equations do not cover this constraint");
  }

  template <class LawAt>
  void driven(const std::string& name, const PointAngle& d, const LawAt& law_at) {
    using std::cos;
    using std::sin;
    const T angle = law_at(d.law);
    Vec<T> direction = {cos(angle), sin(angle), T{0}};
    if (const auto& axis = std::get<std::string>(d.axis); !axis.empty()) {  // the angle is zero at the guess
      const Posture<T> guess = at_guess<T>(scene_);
      const Vec<T> zero = unit(guess.at(d.b) - guess.at(d.a));
      direction = cos(angle) * zero + sin(angle) * cross(at(axis), zero);
    }
    leave(name, unit(at(d.b) - at(d.a)) - direction);
  }
  template <class LawAt>
  void driven(const std::string& name, const DrivenDistance& d, const LawAt& law_at) {
    length(name, d.a, d.b, law_at(d.law));
  }
  template <class LawAt>
  void driven(const std::string& name, const DrivenCoordinate& d, const LawAt& law_at) {
    const std::size_t dot_at = d.coordinate.find('.');
    const auto axis = static_cast<std::size_t>(d.coordinate[dot_at + 1] - 'x');
    leave(name, at(d.coordinate.substr(0, dot_at))[axis] - law_at(d.law));
  }
  template <class LawAt>
  void driven(const std::string& name, const Pose& d, const LawAt& law_at) {
    using std::cos;
    using std::sin;
    for (const Body& body : scene_.bodies()) {
      if (body.name != d.body) continue;
      leave(name,
            at(body.origin) - Vec<T>{law_at(d.translation[0]), law_at(d.translation[1]), law_at(d.translation[2])});
      const T psi = law_at(d.rotation[0]), theta = law_at(d.rotation[1]), phi = law_at(d.rotation[2]);
      const Vec<T> u = {cos(psi) * cos(theta), sin(psi) * cos(theta), -sin(theta)};
      // v is y = (-sin psi, cos psi, 0), turned about u by phi.
      const Vec<T> y = {-sin(psi), cos(psi), T{0}};
      leave(name, at(body.frame[0]) - u);
      leave(name, at(body.frame[1]) - (cos(phi) * y + sin(phi) * cross(u, y)));
    }
  }
  template <class Other, class LawAt>
  void driven(const std::string& name, const Other&, const LawAt&) {
    throw Error(Error::Kind::input, name + ": the test's own equations do not cover this driver");
  }

  const Scene& scene_;
  Posture<T> at_;
  std::vector<Left<T>> left_;
};

// The law of a driver that has only one.
inline QuadJet law_of(const Scene& scene, const std::string& driver, double t) {
  for (const Driver& d : scene.drivers()) {
    if (d.name != driver) continue;
    if (const auto* angle = std::get_if<PointAngle>(&d.kind)) return evaluate<Quad>(angle->law, Quad(t));
    if (const auto* distance = std::get_if<DrivenDistance>(&d.kind)) return evaluate<Quad>(distance->law, Quad(t));
    if (const auto* coordinate = std::get_if<DrivenCoordinate>(&d.kind)) {
      return evaluate<Quad>(coordinate->law, Quad(t));
    }
  }
  throw Error(Error::Kind::input, "no driver with a single law is called " + driver);
}

}  // namespace assur::references
