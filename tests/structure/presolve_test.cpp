// Linear equations with constant coefficients eliminate one unknown each.
#include "structure/presolve.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "equations/lowering.hpp"
#include "references/perturb.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using enum Formulation;
using look::structure;

struct Presolved {
  System system;
  std::vector<Index> equations, unknowns;
  Index eliminated;

  explicit Presolved(const Scene& scene) : system(lower(std::make_shared<const Scene>(scene), {}, false)) {
    equations.resize(system.equations.size());
    std::iota(equations.begin(), equations.end(), 0);
    for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
      if (system.coordinates[c].role == Role::unknown) unknowns.push_back(static_cast<Index>(c));
    }
    eliminated = presolve(system, equations, unknowns);
  }
  [[nodiscard]] std::set<std::string> left() const {
    std::set<std::string> out;
    for (const Index u : unknowns) out.insert(system.coordinate_name(u));
    return out;
  }
  // Coefficient of `of` in the form of `item`; 0 if the form does not contain it.
  [[nodiscard]] double coefficient(const std::string& item, int k, const std::string& of) const {
    const Item& it = system.item(item);
    for (const Term& t : system.form(it.form[k])) {
      if (system.coordinate_name(t.coordinate) == of) return system.constants[static_cast<std::size_t>(t.constant)];
    }
    return 0;
  }
};

// The rod has 1 m, so that one internal unit is 1 m.
SceneBuilder plane() {
  SceneBuilder b("linear", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).point("C", {1, 0, 0});
  b.drive("crank", PointAngle{"A", "C", "", Law::polynomial({0.3, 1})});
  return b.time(0, 1, 0.01);
}

TEST(Presolve, CountsEliminatedUnknowns) {
  EXPECT_EQ(structure(sample("stewart"), irreducible).eliminated, 36);
  EXPECT_EQ(structure(sample("stewart:legs=10"), irreducible).eliminated, 60);
  EXPECT_EQ(structure(sample("four_bar:7"), irreducible).eliminated, 0);
  EXPECT_EQ(structure(sample("stewart"), groups).eliminated, 0);
  EXPECT_EQ(structure(sample("stewart"), global).eliminated, 0);
}

// P = C + (0.5, 0.25) leaves no unknowns of P, and its constant moves to the right-hand side.
TEST(Presolve, MovesConstantsToTheRightHandSide) {
  const Presolved p(
      plane().point("P", {1, 1, 0}).constrain("offset", Linear{{{"P", 2}, {"C", -2}}, {1, 0.5, 0}}).build());
  EXPECT_EQ(p.eliminated, 2);
  EXPECT_TRUE(p.equations.empty());
  EXPECT_TRUE(p.left().empty());
  EXPECT_EQ(p.coefficient("P", 0, "C.x"), 1);
  EXPECT_EQ(p.coefficient("P", 0, "1"), 0.5);
  EXPECT_EQ(p.coefficient("P", 1, "1"), 0.25);
}

// P1 needs P2, P2 needs P3, and so on, in the worst order for substitution and in the best one.
TEST(Presolve, EliminatesAChainOfLinearEquations) {
  for (const bool forward : {true, false}) {
    SceneBuilder b = plane();
    const int n = 8;
    for (int i = 1; i <= n; ++i) b.point("P" + std::to_string(i), {1, 1, 0});
    b.point("Q", {1.5, 1, 0});
    for (int k = 1; k <= n; ++k) {  // P_i = P_{i+1} + (0.125, 0), P_{n+1} = Q
      const int i = forward ? k : n + 1 - k;
      const std::string here = "P" + std::to_string(i), next = i == n ? "Q" : "P" + std::to_string(i + 1);
      b.constrain("step" + std::to_string(i), Linear{{{here, 1}, {next, -1}}, {0.125, 0, 0}});
    }
    b.constrain("rod", Distance{"P1", "B", 1.0}).constrain("link", Distance{"Q", "C", 1.0});
    const Scene scene = b.build();
    const Presolved p(scene);
    EXPECT_EQ(p.eliminated, 2 * n);
    EXPECT_EQ(p.unknowns.size(), 2u);
    EXPECT_EQ(p.equations.size(), 2u);
    const GroupedSystem s = structure(scene, irreducible);
    EXPECT_EQ(s.cannot_assemble, "");
    for (int i = 1; i <= n; ++i) {
      EXPECT_NEAR(look::start(s, "P" + std::to_string(i) + ".x") - look::start(s, "Q.x"), 0.125 * (n + 1 - i), 1e-15);
    }
  }
}

// In x = sum (c_j / c_p) q_j the pivot |c_p| is at least half of the largest |c_j|, so no rounding is amplified by more
// than two.
TEST(Presolve, AvoidsSmallPivots) {
  const Presolved p(plane()
                        .point("P", {1, 1, 0})
                        .point("Q", {1, 1, 0})
                        .constrain("ratio", Linear{{{"P", 1e-6}, {"Q", 1}, {"C", -0.5}}, {}})
                        .constrain("rod", Distance{"Q", "B", 1.0})
                        .constrain("link", Distance{"Q", "C", 1.0})
                        .constrain("third", Distance{"Q", "A", 1.0})
                        .build());
  EXPECT_EQ(p.eliminated, 2);
  EXPECT_EQ(p.left(), (std::set<std::string>{"P.x", "P.y"}));  // although Q stands in more equations
  EXPECT_DOUBLE_EQ(p.coefficient("Q", 0, "P.x"), -1e-6);
  EXPECT_EQ(p.coefficient("Q", 0, "C.x"), 0.5);
}

// Among sufficiently large pivots, the one in the fewest equations is eliminated.
TEST(Presolve, PrefersTheUnknownThatFewerEquationsMention) {
  const Presolved p(plane()
                        .point("P", {1, 1, 0})
                        .point("Q", {1, 1, 0})
                        .constrain("same", Linear{{{"P", 1}, {"Q", -1.5}}, {}})
                        .constrain("rod", Distance{"Q", "B", 1.0})
                        .constrain("link", Distance{"Q", "C", 1.0})
                        .build());
  EXPECT_EQ(p.left(), (std::set<std::string>{"Q.x", "Q.y"}));
  EXPECT_EQ(p.coefficient("P", 1, "Q.y"), 1.5);
}

// A long sum would make every equation dense that contains its unknown.
TEST(Presolve, KeepsLongForms) {
  for (const int n : {10, 11}) {
    SceneBuilder b = plane();
    Linear sum{{{"P", -1}}, {}};
    b.point("P", {0, 0, 0});
    for (int i = 0; i < n; ++i) {
      const std::string q = "Q" + std::to_string(i);
      b.point(q, {1, 1 + 0.1 * i, 0})
          .constrain("rod" + q, Distance{q, "B", {}})
          .constrain("link" + q, Distance{q, "C", {}});
      sum.terms.emplace_back(q, 1);
    }
    b.constrain("sum", sum);
    // n + 1 unknowns and the constant: 12 terms are the longest form that is eliminated.
    EXPECT_EQ(Presolved(b.build()).eliminated, n == 10 ? 2 : 0) << n;
  }
}

// Equations with products keep their unknowns even if values make them linear, because safe pivots would depend on
// values.
TEST(Presolve, KeepsProducts) {
  const Presolved p(SceneBuilder("dot", 2)
                        .fixed_vector("d", {0.6, 0.8, 0})
                        .vector("u", {1, 0, 0})
                        .constrain("across", Dot{"u", "d", 0.0})
                        .time(0, 1, 0.1)
                        .build());
  EXPECT_EQ(p.eliminated, 0);
}

TEST(Presolve, FormulationsAgree) {
  for (const char* name :
       {"stewart", "andrews", "four_bar:10", "slider_crank:offset=0.05", "rings:legs=2,n=24", "gough"}) {
    const Scene scene = references::perturbed(sample(name), 1e-3, 3);
    const GroupedSystem all = structure(scene, global), declared = structure(scene, groups),
                        small = structure(scene, irreducible);
    for (const Item& item : all.system->items) {
      if (item.hidden) continue;
      for (int k = 0; k < item.components; ++k) {
        const std::string c = item.components == 1 ? item.name : item.name + "." + "xyz"[k];
        EXPECT_NEAR(look::start(declared, c), look::start(all, c), 1e-13) << name << " " << c;
        EXPECT_NEAR(look::start(small, c), look::start(all, c), 1e-13) << name << " " << c;
      }
    }
  }
}

}  // namespace
}  // namespace assur
