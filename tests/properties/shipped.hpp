// The mechanisms of scenes/ against closed forms in quad: their groups, and their motion.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "errors/conditions.hpp"
#include "references/posture.hpp"
#include "source_dir.hpp"
#include "structure/grouped_system.hpp"

namespace assur::test {

using references::Posture;
using references::Quad;
using references::QuadJet;
using references::operator+;
using references::operator-;
using references::operator*;
using Point3 = references::Vec<QuadJet>;

inline QuadJet norm(const Point3& v) { return sqrt(references::dot(v, v)); }

// A scene with its numbers, from which closed forms are computed: a file of scenes/, or any scene.
class Shipped {
 public:
  explicit Shipped(const std::string& name)
      : scene_(read_scene(std::string(ASSUR_SOURCE_DIR) + "/scenes/" + name + ".json")) {}
  explicit Shipped(Scene scene) : scene_(std::move(scene)) {}

  [[nodiscard]] const Scene& scene() const { return scene_; }
  // Value of a constraint of a distance, m.
  [[nodiscard]] QuadJet length(const std::string& constraint) const {
    for (const Constraint& c : scene_.constraints()) {
      if (c.name != constraint) continue;
      const auto* distance = c.as<Distance>();
      if (distance->value) return QuadJet{distance->value->value()};
      const Point3 d = fixed(distance->q) - fixed(distance->p);
      return norm(d);
    }
    throw std::out_of_range(constraint);
  }
  // Coordinates, as written, of a point, a vector or a member of the ground.
  [[nodiscard]] Point3 fixed(const std::string& name) const { return references::exactly<QuadJet>(written(name)); }
  // Local coordinates of a member.
  [[nodiscard]] Point3 local(const std::string& member) const {
    for (const Body& b : scene_.bodies()) {
      for (const auto* members : {&b.points, &b.vectors}) {
        for (const Member& m : *members) {
          if (m.name == member) return references::exactly<QuadJet>(m.local);
        }
      }
    }
    throw std::out_of_range(member);
  }
  [[nodiscard]] QuadJet law(const std::string& driver, double t) const { return references::law_of(scene_, driver, t); }

 private:
  [[nodiscard]] Triple written(const std::string& name) const {
    for (const assur::Point& p : scene_.points()) {
      if (p.name == name) return p.at;
    }
    for (const Vector& v : scene_.vectors()) {
      if (v.name == name) return v.at;
    }
    const Point3 at = local(name);
    return {static_cast<double>(at[0].value), static_cast<double>(at[1].value), static_cast<double>(at[2].value)};
  }

  Scene scene_;
};

// In the plane: the point at distance p from P and q from Q, to the left of P -> Q.
inline Point3 meet(const Point3& P, const QuadJet& p, const Point3& Q, const QuadJet& q) {
  const Point3 d = Q - P;
  const QuadJet square = references::dot(d, d), along = (square + p * p - q * q) / (2 * square);
  const QuadJet across = sqrt(p * p / square - along * along);
  return P + along * d + across * Point3{-d[1], d[0], QuadJet{}};
}
// In the plane: a member of the body with the base P, Q.
inline Point3 member(const Point3& P, const Point3& Q, const Point3& local) {
  const Point3 u = references::unit(Q - P);
  return P + local[0] * u + local[1] * Point3{-u[1], u[0], QuadJet{}};
}
inline Point3 heading(const QuadJet& angle) { return {cos(angle), sin(angle), QuadJet{}}; }

// Sizes of the groups by level, each level in ascending order.
using Levels = std::vector<std::vector<int>>;
inline Levels sizes_of_groups(const GroupedSystem& structure) {
  Levels sizes(static_cast<std::size_t>(structure.levels));
  for (const SolvedGroup& g : structure.groups) sizes[static_cast<std::size_t>(g.level)].push_back(g.of);
  for (auto& level : sizes) std::sort(level.begin(), level.end());
  return sizes;
}

// Expects that a scene has these groups, which were found by hand, that it is regular, and that it begins at the values
// of its laws.
inline void expect_groups(const Scene& scene, const Levels& sizes, std::size_t classes, std::int64_t mobility) {
  EXPECT_TRUE(scene.warnings().empty());
  const GroupedSystem s = group_equations(scene.with_outputs({"all"}));
  EXPECT_EQ(sizes_of_groups(s), sizes);
  EXPECT_EQ(s.classes.size(), classes);
  EXPECT_EQ(s.mobility, mobility);
  EXPECT_TRUE(s.redundant.empty());
  EXPECT_TRUE(s.undetermined.empty());
  EXPECT_EQ(s.cannot_assemble, "");
  EXPECT_TRUE(s.notes.empty());
}

// A measure, and its largest change by an error of 1 m (of 1 for vectors) in each coordinate.
struct Measured {
  QuadJet value;
  double gain = 1;
};
struct Expected {
  Posture<QuadJet> points;  // points and vectors
  std::map<std::string, Measured> measures = {};
};

// Compares runs with closed forms. If all equations hold to 8 eps, the criterion of convergence, coordinates have
// errors of at most 8 eps kappa (kappa: test::Condition::own), rates of kappa times that, and accelerations of kappa
// times the error of the rates. The bound is twice as large, because laws and outputs round as well. `gain`: factor by
// which members of bodies move more than the points of their base.
class ClosedForm {
 public:
  template <class At>
  ClosedForm(const Scene& shipped, double gain, const At& at)
      : scene_(shipped.with_outputs({"all"})), times_(grid_of(scene_)), conditions_(both_conditions(scene_, times_)) {
    unit_ = std::ldexp(1, group_equations(scene_).system->length_exponent);
    scale_ = gain * unit_;
    for (const double t : times_) expected_.push_back(at(t));
    for (const Expected& e : expected_) {
      for (const auto& [name, point] : e.points) {
        for (const QuadJet& x : point) {
          fastest_ = std::max(fastest_, std::abs(static_cast<double>(x.rate)) / unit_);
          hardest_ = std::max(hardest_, std::abs(static_cast<double>(x.acceleration)) / unit_);
        }
      }
    }
  }

  void expect(const std::string& strategy) {
    SCOPED_TRACE(scene_.name() + " " + strategy);
    const Result r = run(scene_, strategy);
    ASSERT_TRUE(r.report().status.ok()) << name(r.report().status.code);
    EXPECT_TRUE(r.report().events.empty());
    ASSERT_EQ(r.trajectory.rows(), times_.size());
    ASSERT_EQ(conditions_.size(), times_.size());
    std::fill_n(worst_, 3, 0.0);
    for (std::size_t k = 0; k < times_.size() && !testing::Test::HasFailure(); ++k) {
      for (const auto& [name, point] : expected_[k].points) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(scene_.dimension()); ++i) {
          const std::string axis(1, "xyz"[i]);
          compare(r.trajectory, k, {name + "." + axis, name + ".v" + axis, name + ".a" + axis}, point[i], scale_);
        }
      }
      for (const auto& [name, m] : expected_[k].measures) {
        compare(r.trajectory, k, {name, name + ".rate", name + ".acceleration"}, m.value, scale_ * m.gain);
      }
    }
    double largest = 0;
    for (const Condition& c : conditions_) largest = std::max(largest, c.own);
    std::ostringstream figures;  // errors over the bounds without their factor of 16; the largest condition
    figures << worst_[0] << ' ' << worst_[1] << ' ' << worst_[2] << " of " << largest;
    testing::Test::RecordProperty(strategy, figures.str());
  }

 private:
  void compare(const Trajectory& t, std::size_t k, const std::array<std::string, 3>& columns, const QuadJet& value,
               double scale) {
    const Quad expected[3] = {value.value, value.rate, value.acceleration};
    const double kappa = conditions_[k].own, size[3] = {1, fastest_, hardest_ + fastest_ * fastest_};
    for (std::size_t d = 0; d < 3; ++d) {
      const double bound = kEps * std::pow(kappa, d + 1) * size[d] * scale;
      const double off = std::abs(static_cast<double>(t(k, t.index(columns[d])) - expected[d]));
      worst_[d] = std::max(worst_[d], off / bound);
      EXPECT_LE(off, 16 * bound) << columns[d] << " at t = " << times_[k] << ", condition " << kappa;
    }
  }

  Scene scene_;
  std::vector<double> times_;
  std::vector<Condition> conditions_;
  double unit_ = 1, scale_ = 1;       // m
  std::vector<Expected> expected_;    // rows
  double fastest_ = 0, hardest_ = 0;  // of points, in units of length: 1/s, 1/s^2
  double worst_[3] = {};              // of value, rate and acceleration
};

template <class At>
void expect_motion(const Scene& scene, double gain, const At& at) {
  ClosedForm closed_form(scene, gain, at);
  for (const std::string strategy : {"auto", "global/eigen"}) closed_form.expect(strategy);
}

}  // namespace assur::test
