// Programs: callbacks, Lipschitz constants, sharing. kinds_test.cpp compares programs with the system.
#include "evaluation/coefficients.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "evaluation/evaluator.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using enum Formulation;
using look::structure;

// A callback keeps P on a circle about A, and a rod connects P to a slider. Arguments of callbacks are in metres.
Scene with_callback(double length = 1) {
  const double radius = 1.5 * length;
  Callback circle;
  circle.coordinates = {"P.x", "P.y", "C.x"};
  circle.equations = 1;
  circle.residual = [=](auto x, auto phi) { phi[0] = x[0] * x[0] + x[1] * x[1] - radius * radius; };
  circle.jacobian = [](auto x, auto j) { j[0] = 2 * x[0], j[1] = 2 * x[1], j[2] = 0; };
  circle.curvature = [](auto, auto v, auto c) { c[0] = 2 * v[0] * v[0] + 2 * v[1] * v[1]; };
  SceneBuilder b("callback", 2);
  b.fixed_point("A", {0, 0, 0}).point("C", {2 * length, 0, 0}).point("P", {1.2 * length, 0.9 * length, 0});
  b.constrain("rod", Distance{"C", "P", 1.5 * length}).constrain("circle", circle);
  b.drive("slide", DrivenCoordinate{"C.x", Law::polynomial({2 * length, 0.25 * length})});
  b.constrain("rail", FixedCoordinate{"C.y", 0});
  return b.time(0, 1, 0.125).build();
}

TEST(ProgramCallback, IsEvaluatedInSiUnitsInEveryLane) {
  for (const double length : {1.0, 1e-3, 4e3}) {
    const GroupedSystem s = structure(with_callback(length), irreducible);
    ASSERT_EQ(s.cannot_assemble, "");
    const SolvedGroup& g = look::group(s, "P");
    const GroupClass& c = look::class_of(s, g);
    EXPECT_FALSE(c.quadratic());
    const double unit = s.system->unit(1);
    for (const int lanes : {1, 2, 8}) {
      const auto w = static_cast<std::size_t>(lanes);
      const auto evaluator = make_evaluator(*s.system, c, lanes);
      std::vector<double> constants, k(c.coefficients.size() * w), inputs, unknowns;
      for (const Index i : g.constants) constants.insert(constants.end(), w, s.system->constants[idx(i)]);
      bind_coefficients(c, constants.data(), k.data(), w);
      for (const Index i : g.inputs) inputs.insert(inputs.end(), w, s.start[idx(i)]);
      for (const Index i : g.unknowns) {
        for (std::size_t l = 0; l < w; ++l) unknowns.push_back(s.start[idx(i)] + 0.125 * static_cast<double>(l + 1));
      }
      std::vector<double> phi(2 * w), j(idx(c.pattern.nnz()) * w), rhs(2 * w), rates(unknowns.size());
      for (std::size_t i = 0; i < rates.size(); ++i) rates[i] = 0.25 * static_cast<double>(i + 1);
      evaluator->set_inputs(k.data(), inputs.data());
      evaluator->evaluate(unknowns.data(), phi.data(), j.data());
      std::vector<double> none(inputs.size(), 0);
      evaluator->velocity_rhs(none.data(), rhs.data());
      evaluator->acceleration_rhs(rates.data(), none.data(), rhs.data());
      // Phi''[a, a] is the curvature along a, and changes nothing that follows.
      std::vector<double> a = rates, b = rates, of_inputs = none, bent(2 * w), bend(2 * w), again(2 * w);
      evaluator->subtract_bend({a.data(), of_inputs.data()}, {b.data(), of_inputs.data()}, 1, bent.data(), bend.data());
      for (std::size_t i = 0; i < 2 * w; ++i) EXPECT_NEAR(bend[i], rhs[i], 16 * kEps * std::abs(rhs[i]));
      evaluator->velocity_rhs(none.data(), again.data());
      evaluator->acceleration_rhs(rates.data(), none.data(), again.data());
      EXPECT_EQ(again, rhs);
      const auto row = idx(c.callbacks.at(0).rows.at(0).equation);
      for (std::size_t l = 0; l < w; ++l) {
        const double x = unknowns[l] * unit, y = unknowns[w + l] * unit, r = 1.5 * length;
        EXPECT_NEAR(phi[row * w + l], x * x + y * y - r * r, 16 * kEps * (x * x + y * y + r * r));
        const double vx = rates[l] * unit, vy = rates[w + l] * unit;
        EXPECT_NEAR(rhs[row * w + l], -2 * (vx * vx + vy * vy), 16 * kEps * (vx * vx + vy * vy));
        for (Index column = 0; column < 2; ++column) {
          for (Index e = c.pattern.column_start[idx(column)]; e < c.pattern.column_start[idx(column) + 1]; ++e) {
            if (c.pattern.row[idx(e)] != static_cast<Index>(row)) continue;
            const double q = column == 0 ? x : y;  // derivative of phi by q / unit
            EXPECT_NEAR(j[idx(e) * w + l], 2 * q * unit, 16 * kEps * std::abs(q) * unit);
          }
        }
      }
    }
  }
}

// A callback with two rows, one of which is redundant: one row is solved, the other one checked.
TEST(ProgramCallback, EvaluatesPartOfItsRows) {
  Callback twice;
  twice.coordinates = {"P.x", "P.y"};
  twice.equations = 2;
  twice.residual = [](auto x, auto phi) {
    phi[0] = x[0] * x[0] + x[1] * x[1] - 2.25;
    phi[1] = 2 * phi[0];
  };
  twice.jacobian = [](auto x, auto j) { j[0] = 2 * x[0], j[1] = 2 * x[1], j[2] = 4 * x[0], j[3] = 4 * x[1]; };
  twice.curvature = [](auto, auto v, auto c) { c[1] = 2 * (c[0] = 2 * v[0] * v[0] + 2 * v[1] * v[1]); };
  SceneBuilder b("twice", 2);
  b.fixed_point("A", {0, 0, 0}).point("C", {2, 0, 0}).point("P", {1.2, 0.9, 0});
  b.constrain("rod", Distance{"C", "P", {}}).constrain("twice", twice);
  b.drive("motor", PointAngle{"A", "C", "", Law::polynomial({0, 0.25})}).time(0, 1, 0.125);
  const GroupedSystem s = structure(b.build(), groups);
  ASSERT_EQ(s.redundant.size(), 1u);
  ASSERT_EQ(s.groups.size(), 1u);
  const SolvedGroup& g = s.groups[0];
  const GroupClass& c = look::class_of(s, g);
  const auto evaluator = make_evaluator(*s.system, c, 1);
  std::vector<double> constants, k(c.coefficients.size()), inputs, unknowns;
  for (const Index i : g.constants) constants.push_back(s.system->constants[idx(i)]);
  bind_coefficients(c, constants.data(), k.data(), 1);
  for (const Index i : g.inputs) inputs.push_back(s.start[idx(i)]);
  for (const Index i : g.unknowns) unknowns.push_back(s.start[idx(i)] + 0.125);
  // One more value at the end, which must not be written.
  std::vector<double> phi(3, 77), j(idx(c.pattern.nnz()) + 1, 77), scale(3, 77), rhs(3, 77), none(inputs.size(), 0);
  evaluator->set_inputs(k.data(), inputs.data());
  evaluator->evaluate(unknowns.data(), phi.data(), j.data());
  evaluator->scale(scale.data());
  evaluator->velocity_rhs(none.data(), rhs.data());
  evaluator->acceleration_rhs(unknowns.data(), none.data(), rhs.data());
  EXPECT_EQ(phi[2], 77);
  EXPECT_EQ(j.back(), 77);
  EXPECT_EQ(scale[2], 77);
  EXPECT_EQ(rhs[2], 77);
  for (std::size_t i = 0; i < 2; ++i) {
    const double expected = residual<double>(*s.system, g.equations[i], [&] {
      std::vector<double> q = s.start;
      for (std::size_t u = 0; u < 2; ++u) q[idx(g.unknowns[u])] = unknowns[u];
      return q;
    }());
    EXPECT_NEAR(phi[i], expected, 16 * kEps * scale[i]) << s.system->equation_name(g.equations[i]);
  }
}

// ---- Lipschitz constants

TEST(Lipschitz, BoundsACircle) {
  SceneBuilder b("circle", 2);
  b.fixed_point("A", {0, 0, 0}).point("C", {2, 0, 0}).point("P", {1.2, 0.9, 0});
  b.constrain("PA", Distance{"P", "A", {}}).constrain("PC", Distance{"P", "C", {}});
  b.drive("motor", PointAngle{"A", "C", "", Law::polynomial({0, 1})}).time(0, 1, 0.1);
  const GroupedSystem s = structure(b.build(), groups);
  const SolvedGroup& g = look::group(s, "P");
  std::vector<double> constants, l(2);
  for (const Index i : g.constants) constants.push_back(s.system->constants[idx(i)]);
  const GroupClass& c = look::class_of(s, g);
  std::vector<double> k(c.coefficients.size());
  bind_coefficients(c, constants.data(), k.data(), 1);
  lipschitz(c, k.data(), l.data(), 1);
  EXPECT_EQ(l[0], 4);  // J = 2 (x, y): |2 dx| + |2 dy|
  EXPECT_EQ(l[1], 8);  // J = 2 (x - cx, y - cy); C moves as well
}

// |J_i(x) - J_i(y)|_1 <= l |x - y|_inf over the columns of the block, for all motions.
TEST(Lipschitz, BoundsTheJacobian) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const char* name : {"stewart", "andrews", "slider_crank", "rings:legs=1,n=12"}) {
    for (const Formulation f : {global, groups, irreducible}) {
      const GroupedSystem s = structure(sample(name), f);
      for (const SolvedGroup& g : s.groups) {
        const GroupClass& c = look::class_of(s, g);
        std::vector<double> constants, coefficients(c.coefficients.size()), l(c.equations.size());
        for (const Index k : g.constants) constants.push_back(s.system->constants[idx(k)]);
        bind_coefficients(c, constants.data(), coefficients.data(), 1);
        lipschitz(c, coefficients.data(), l.data(), 1);
        const auto moved = [&] {
          std::vector<double> q = s.start;
          for (const Index u : g.unknowns) q[idx(u)] += unit(random);
          for (std::size_t i = 0; i < g.inputs.size(); ++i) {
            if (c.input_moves[i] != 0) q[idx(g.inputs[i])] += unit(random);
          }
          return q;
        };
        const std::vector<double> x = moved(), y = moved();
        double distance = 0;
        for (std::size_t i = 0; i < x.size(); ++i) distance = std::max(distance, std::abs(x[i] - y[i]));
        for (std::size_t i = 0; i < g.equations.size(); ++i) {
          std::map<Index, double> difference;
          gradient<double>(*s.system, g.equations[i], x, [&](Index k, double v) { difference[k] += v; });
          gradient<double>(*s.system, g.equations[i], y, [&](Index k, double v) { difference[k] -= v; });
          double sum = 0;
          for (std::size_t u = 0; u < g.unknowns.size(); ++u) {
            if (c.unknown_block[u] == c.equation_block[i]) sum += std::abs(difference[g.unknowns[u]]);
          }
          EXPECT_LE(sum, l[i] * distance * (1 + 64 * kEps)) << s.system->equation_name(g.equations[i]);
        }
      }
    }
  }
}

// ---- sharing

// All groups of a class share a program: constants are slots, so the program does not depend on the instance.
TEST(ProgramSharing, GroupsOfAClassFillTheSameSlots) {
  for (const char* name : {"stewart", "four_bar:9", "rings:legs=3,n=18", "andrews"}) {
    const GroupedSystem s = structure(sample(name), groups);
    for (const SolvedGroup& g : s.groups) {
      const GroupClass& c = look::class_of(s, g);
      EXPECT_EQ(g.unknowns.size(), idx(c.n));
      EXPECT_EQ(g.equations.size(), idx(c.n));
      EXPECT_EQ(g.inputs.size(), idx(c.inputs));
      EXPECT_EQ(g.constants.size(), idx(c.constants));
      EXPECT_EQ(c.input_moves.size(), idx(c.inputs));
    }
  }
}

TEST(Coefficients, OnlySquaresAndAnglesNeverVanishTogether) {
  GroupClass distance;
  distance.n = 2;
  distance.products = {{0, 0, 0}, {0, 1, 1}};
  distance.linear = {{1, distance.one()}};
  EXPECT_FALSE(terms_may_vanish(distance));
  GroupClass slides = distance, turns = distance, rack = distance, dot = distance;
  slides.linear.push_back({0, 0});
  EXPECT_TRUE(terms_may_vanish(slides));
  dot.products.push_back({0, 0, 1});
  EXPECT_TRUE(terms_may_vanish(dot));
  turns.gears.emplace_back().is_periodic = true;
  EXPECT_FALSE(terms_may_vanish(turns));
  rack.gears.emplace_back().is_periodic = false;
  EXPECT_TRUE(terms_may_vanish(rack));
}

TEST(ProgramSharing, LanesAreOfFiveSizes) {
  const GroupedSystem s = structure(sample("four_bar"), groups);
  for (const int bad : {0, 3, 5, 32, -1})
    EXPECT_THROW((void)make_evaluator(*s.system, s.classes[0], bad), std::invalid_argument);
}

}  // namespace
}  // namespace assur
