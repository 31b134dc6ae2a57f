// The closed forms and tables that other tests use as references satisfy the equations of the samples, including
// derivatives. The test has its own equations (posture.hpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "references/perturb.hpp"
#include "references/planar.hpp"
#include "references/stewart.hpp"
#include "references/tables.hpp"

namespace assur {
namespace {

using namespace references;  // NOLINT: the whole file is about them

// The largest absolute value among a value and its derivatives.
double magnitude(const QuadJet& x) {
  return std::max({std::abs(static_cast<double>(x.value)), std::abs(static_cast<double>(x.rate)),
                   std::abs(static_cast<double>(x.acceleration))});
}

template <class T>
void expect_satisfied(const Equations<T>& equations, double tolerance) {
  EXPECT_FALSE(equations.left().empty());
  for (const Left<T>& left : equations.left()) EXPECT_LE(magnitude(left.value), tolerance) << left.equation;
}

// The closed form and its derivatives satisfy every equation of the scene. Tolerance: twenty roundings of the terms of
// an equation, which are products of two coordinates or their derivatives over the square of its length.
void expect_exact(const Scene& scene, double t, const Posture<QuadJet>& closed_form) {
  SCOPED_TRACE(scene.name() + " at t = " + std::to_string(t));
  Posture<QuadJet> posture = at_guess<QuadJet>(scene);
  double largest = 1, shortest = 1;
  for (const auto& [name, at] : closed_form) {
    posture[name] = at;
    for (const QuadJet& x : at) {
      largest = std::max(largest, static_cast<double>(abs(x.value) + abs(x.rate) + abs(x.acceleration)));
    }
  }
  for (const Constraint& c : scene.constraints()) {
    if (const auto* distance = c.as<Distance>()) shortest = std::min<double>(shortest, *distance->value);
  }
  Equations<QuadJet> equations(scene, posture);
  equations.drive([t](const Law& law) { return evaluate<Quad>(law, Quad(t)); });
  const double epsilon = static_cast<double>(std::numeric_limits<Quad>::epsilon());
  expect_satisfied(equations, 20 * epsilon * std::pow(largest / shortest, 2));
}

TEST(ClosedForm, SatisfiesFourBarChains) {
  const Scene scene = sample("four_bar:20");
  for (const double t : {0.0, 0.123, 0.5, 0.999, 3.7}) expect_exact(scene, t, four_bar_chain(20, t));
}

TEST(ClosedForm, FourBarChainStartsAtTheGuess) {
  const Posture<double> guess = at_guess<double>(sample("four_bar:20"));
  for (const auto& [name, at] : four_bar_chain(20, 0)) {
    EXPECT_NEAR(guess.at(name)[0], static_cast<double>(at[0].value), 1e-13) << name;
    EXPECT_NEAR(guess.at(name)[1], static_cast<double>(at[1].value), 1e-13) << name;
  }
}

TEST(ClosedForm, SatisfiesNFourBar) {
  const Scene scene = sample("n_four_bar:40");
  for (const double t : {0.0, 1.0, 1.5707963267948966, 9.99}) expect_exact(scene, t, n_four_bar(40, t));
}

TEST(ClosedForm, AlmostParallelogramStaysOnItsBranch) {
  for (const double delta : {1e-2, 1e-6, 1e-12}) {
    const Scene scene = sample("almost_parallelogram", {{"delta", delta}});
    QuadJet before;
    for (int k = 0; k <= 1000; ++k) {
      const double t = k / 1000.0;
      const Posture<QuadJet> posture = almost_parallelogram(delta, t);
      expect_exact(scene, t, posture);
      // Position and velocity of the end of the rocker are continuous.
      const QuadJet y = posture.at("B1")[1];
      if (k > 0) {
        EXPECT_NEAR(static_cast<double>(y.value), static_cast<double>(before.value), 0.02);
      }
      EXPECT_GE(static_cast<double>(y.value), 0);  // the rocker always swings above the ground
      before = y;
    }
  }
}

TEST(ClosedForm, SatisfiesTheSliderCrank) {
  for (const double offset : {0.0, 0.05, -0.19}) {
    const Scene scene = sample("slider_crank", {{"offset", offset}});
    for (const double t : {0.0, 0.25, 0.6, 1.0}) expect_exact(scene, t, slider_crank(offset, t));
  }
  const Scene equal = sample("slider_crank:crank_length=0.2,rod_length=0.2001");
  for (const double t : {0.0, 0.2, 0.3, 0.7}) expect_exact(equal, t, slider_crank(0, t, 0.2, 0.2001));
}

TEST(ClosedForm, SatisfiesParallelograms) {
  const Scene scene = sample("parallelograms:5");
  for (const double t : {0.0, 1.0, 9.99}) expect_exact(scene, t, parallelograms(5, t));
}

TEST(ClosedForm, SatisfiesTheStewartPlatform) {
  for (const std::string text : {"stewart", "stewart:legs=5,omega=6.3"}) {
    const Scene scene = sample(text);
    for (const double t : {0.0, 1.7, 10.0}) expect_exact(scene, t, stewart(scene, t));
  }
}

TEST(ClosedForm, StewartStartsAtTheGuess) {
  const Scene scene = sample("stewart:platforms=2");
  const Posture<double> guess = at_guess<double>(scene);
  for (const std::string suffix : {"_1", "_2"}) {
    const Posture<QuadJet> start = stewart(scene, 0, suffix);
    EXPECT_EQ(start.size(), 4u + 6 * 5);
    for (const auto& [name, at] : start) {
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(guess.at(name)[i], static_cast<double>(at[i].value), 2e-15) << name;
    }
  }
}

TEST(ClosedForm, GoughReferenceSatisfiesTheSample) {
  for (const GoughRow& row : read_gough()) {
    SCOPED_TRACE(row.posture);
    const Scene scene = sample("gough", {{"posture", row.posture}});
    Posture<Quad> posture = at_guess<Quad>(scene);
    posture["B1"] = row.n;
    posture["u"] = row.u;
    posture["v"] = row.v;
    posture["w"] = cross(row.u, row.v);
    Equations<Quad> equations(scene, posture);
    equations.drive([](const Law& law) { return evaluate<Quad>(law, Quad(0)).value; });
    // The table has 25 decimals; the dimensions of the sample are doubles.
    for (const auto& left : equations.left())
      EXPECT_LE(std::abs(static_cast<double>(left.value)), 1e-14) << left.equation;
  }
}

TEST(ClosedForm, AndrewsReferenceSatisfiesTheSample) {
  const Scene scene = sample("andrews");
  for (const AndrewsRow& row : read_andrews()) {
    Posture<QuadJet> posture = at_guess<QuadJet>(scene);
    const QuadJet beta{row.beta, 1, 0};
    posture["F"] = on_circle(at_rest(0, 0), 0.007, beta);
    posture["E"] = row.E;
    posture["G"] = row.G;
    posture["H"] = row.H;
    Equations<QuadJet> equations(scene, posture);
    equations.drive([&beta](const Law&) { return beta; });
    expect_satisfied(equations, 1e-14);  // dimensions are doubles: 20 roundings of the relative length
  }
}

TEST(Perturbed, MovesOnlyGuesses) {
  const Scene scene = sample("gough:5"), moved = perturbed(scene, 1e-3, 7);
  const Posture<double> before = at_guess<double>(scene), after = at_guess<double>(moved);
  ASSERT_EQ(before.size(), after.size());
  for (const auto& [name, at] : before) {
    const Vec<double> d = after.at(name) - at;
    const double distance = std::sqrt(dot(d, d));
    if (name[0] == 'A') {
      EXPECT_EQ(distance, 0) << name;
    } else {
      EXPECT_GT(distance, 1e-5) << name;
      EXPECT_LT(distance, 2e-3) << name;  // sqrt(3) * 1e-3, and what normalising adds
    }
  }
  EXPECT_EQ(moved.drivers().size(), 6u);
  EXPECT_NE(at_guess<double>(perturbed(scene, 1e-3, 8)), after);
}

}  // namespace
}  // namespace assur
