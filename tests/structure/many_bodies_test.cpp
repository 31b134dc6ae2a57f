// Many bodies on joints, deep and wide, with names in any order: the structure is that of a few bodies, repeated, and
// the work of reading and analysing grows in proportion to the number of bodies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "assur/scene.hpp"
#include "backends/allocations.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

// A scene whose items are added in a random order, with names in another one.
class Shuffled {
 public:
  explicit Shuffled(int count, bool in_order = false)
      : random_(static_cast<unsigned>(count)), names_(static_cast<std::size_t>(count)), in_order_(in_order) {
    for (int i = 0; i < count; ++i) names_[static_cast<std::size_t>(i)] = i;
    if (!in_order) std::shuffle(names_.begin(), names_.end(), random_);
  }
  // All names have the same length, so that they need the same memory.
  std::string name(const char* stem, int i) const {
    return stem + std::to_string(100'000 + names_[static_cast<std::size_t>(i)]);
  }
  void body(const std::string& name) {
    items_.emplace_back([=](SceneBuilder& b) { b.add(Body{name}); });
  }
  void hinge(const std::string& name, const std::string& a, const std::string& b, double x, double y) {
    items_.emplace_back([=](SceneBuilder& builder) { builder.joint(name, Revolute{a, b, Triple{x, y, 0}}); });
  }
  void drive(const std::string& joint) {
    items_.emplace_back([=](SceneBuilder& b) {
      b.drive("drive_" + joint, DrivenCoordinate{joint + ".angle", Law::polynomial({0, 1e-3})});
    });
  }
  Scene build() {
    if (!in_order_) std::shuffle(items_.begin(), items_.end(), random_);
    SceneBuilder b("many", 2);
    for (const auto& add : items_) add(b);
    return std::move(b).build();
  }

 private:
  std::mt19937 random_;
  std::vector<int> names_;
  bool in_order_;
  std::vector<std::function<void(SceneBuilder&)>> items_;
};

// Each body is driven about the body before it.
Scene chain_in(bool order, int bodies) {
  Shuffled s(bodies, order);
  for (int i = 0; i < bodies; ++i) {
    s.body(s.name("b", i));
    s.hinge(s.name("J", i), i == 0 ? "ground" : s.name("b", i - 1), s.name("b", i), 0.1 * i, 0.01 * (i % 2));
    s.drive(s.name("J", i));
  }
  return s.build();
}

Scene chain(int bodies) { return chain_in(false, bodies); }
Scene ordered(int bodies) { return chain_in(true, bodies); }

// A driven hub with driven arms.
Scene star(int bodies) {
  Shuffled s(bodies);
  s.body("hub");
  s.hinge("H", "ground", "hub", 0, 0);
  s.drive("H");
  for (int i = 1; i < bodies; ++i) {
    const double at = 2 * std::numbers::pi * i / bodies;
    s.body(s.name("b", i));
    s.hinge(s.name("J", i), "hub", s.name("b", i), std::cos(at), std::sin(at));
    s.drive(s.name("J", i));
  }
  return s.build();
}

// Four-bar linkages in series: the rocker of each is the crank of the next one.
Scene loops(int bodies) {
  const int count = bodies / 2;
  Shuffled s(count + 1);
  s.body(s.name("r", 0));
  s.hinge("M", "ground", s.name("r", 0), 0, 0);
  s.drive("M");
  for (int i = 0; i < count; ++i) {
    const std::string crank = s.name("r", i), coupler = s.name("c", i), rocker = s.name("r", i + 1);
    s.body(coupler), s.body(rocker);
    s.hinge(s.name("A", i), crank, coupler, 2.0 * i + 0.1, 0.5 + 0.01 * (i % 3));
    s.hinge(s.name("B", i), coupler, rocker, 2.0 * i + 2.1, 0.5 + 0.01 * ((i + 1) % 3));
    s.hinge(s.name("G", i), "ground", rocker, 2.0 * i + 2, 0);
  }
  return s.build();
}

// A driven hub with two-link arms to the ground.
Scene wheel(int bodies) {
  const int count = bodies / 2;
  Shuffled s(count);
  s.body("hub");
  s.hinge("H", "ground", "hub", 0, 0);
  s.drive("H");
  for (int i = 0; i < count; ++i) {
    const double at = 2 * std::numbers::pi * i / count, c = std::cos(at), d = std::sin(at);
    const std::string p = s.name("p", i), q = s.name("q", i);
    s.body(p), s.body(q);
    s.hinge(s.name("A", i), "hub", p, c, d);
    s.hinge(s.name("B", i), p, q, 2 * c - 0.3 * d, 2 * d + 0.3 * c);
    s.hinge(s.name("C", i), "ground", q, 3 * c, 3 * d);
  }
  return s.build();
}

struct Shape {
  const char* name;
  Scene (*make)(int bodies);
  int groups_of_two_bodies, unknowns;  // of each group
  bool is_deep;

  friend void PrintTo(const Shape& s, std::ostream* out) { *out << s.name; }
};

class ManyBodies : public testing::TestWithParam<Shape> {};

TEST_P(ManyBodies, HaveTheStructureOfFew) {
  const auto& [name, make, groups, unknowns, is_deep] = GetParam();
  constexpr int kBodies = 20'000;
  const GroupedSystem s = group_equations(make(kBodies));
  const int free = kBodies / 2 * groups - (groups == 2 ? 1 : 0);  // the first body of a chain or star is driven
  ASSERT_EQ(s.groups.size(), static_cast<std::size_t>(free));
  for (const SolvedGroup& g : s.groups) ASSERT_EQ(g.of, unknowns) << g.name;
  EXPECT_EQ(s.levels, is_deep ? free : 1);
  EXPECT_TRUE(s.undetermined.empty());
  EXPECT_TRUE(s.redundant.empty());
}

TEST_P(ManyBodies, AllocationsGrowInProportion) {
  const auto count = [](int bodies) {
    const std::int64_t before = test::allocations();
    (void)group_equations(GetParam().make(bodies));
    return test::allocations() - before;
  };
  // 8 times as many bodies; a logarithm would make the factor 10.2.
  const std::int64_t few = count(2'000), many = count(16'000);
  EXPECT_LE(many, 8.5 * static_cast<double>(few)) << few << " and " << many;
}

INSTANTIATE_TEST_SUITE_P(Shapes, ManyBodies,
                         testing::Values(Shape{"chain", chain, 2, 3, true}, Shape{"ordered", ordered, 2, 3, true},
                                         Shape{"star", star, 2, 3, false}, Shape{"loops", loops, 1, 2, true},
                                         Shape{"wheel", wheel, 1, 2, false}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace assur
