// Scaling all lengths by a power of two keeps the results bitwise; shifting the mechanism keeps its accuracy.
#include <gtest/gtest.h>

#include "references/scaled.hpp"
#include "simulation/run.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

using references::powers_of_length;
using references::scaled;
using test::Result;

// "B.vx", "handle1.rate" -> "B", "handle1"; "slide.lambda.rate" -> "slide.lambda"
std::string item_of(std::string column, const std::unordered_map<std::string, int>& power) {
  while (!power.contains(column) && column.find('.') != std::string::npos) column.resize(column.rfind('.'));
  return column;
}

void expect_the_same_bits(const Scene& scene, const std::string& strategy, int exponent) {
  SCOPED_TRACE(scene.name() + " " + strategy + " x 2^" + std::to_string(exponent));
  // Both scenes are rebuilt, because building normalises vectors again.
  const Result plain = test::run(scaled(scene, 0), strategy), other = test::run(scaled(scene, exponent), strategy);
  ASSERT_TRUE(plain.report().status.ok());
  ASSERT_EQ(other.trajectory.columns(), plain.trajectory.columns());
  ASSERT_EQ(other.trajectory.rows(), plain.trajectory.rows());
  const auto power = powers_of_length(scene);
  std::size_t lengths = 0;
  for (std::size_t c = 0; c < plain.trajectory.columns().size(); ++c) {
    const int p = power.at(item_of(plain.trajectory.columns()[c], power));
    lengths += p != 0 ? 1 : 0;
    for (std::size_t k = 0; k < plain.trajectory.rows(); ++k) {
      ASSERT_EQ(other.trajectory(k, c), std::ldexp(plain.trajectory(k, c), p * exponent))
          << plain.trajectory.columns()[c] << " in row " << k;
    }
  }
  EXPECT_GT(lengths, 0u);
  EXPECT_EQ(other.counters().newton_iterations, plain.counters().newton_iterations);
  EXPECT_EQ(other.counters().rejected, plain.counters().rejected);
  EXPECT_TRUE(test::same_bits(other.report().error.position, plain.report().error.position));
  EXPECT_TRUE(test::same_bits(other.report().error.velocity, plain.report().error.velocity));
  EXPECT_TRUE(test::same_bits(other.report().error.acceleration, plain.report().error.acceleration));
}

TEST(Scaling, ByAPowerOfTwoKeepsResultsBitwise) {
  for (const std::string text :
       {"stewart:steps=100", "four_bar:loops=10,step=0.01,steps=100", "andrews", "slider_crank:step=0.01,steps=100",
        "rings:legs=2,n=24,steps=50", "gough:7", "hexapod:steps=50", "almost_parallelogram:delta=1e-4"}) {
    for (const int exponent : {20, -20}) {
      for (const std::string formulation : {"global", "groups", "irreducible"}) {
        for (const std::string& solver : test::solvers()) {
          expect_the_same_bits(sample(text), formulation + "/" + solver, exponent);
        }
      }
    }
  }
}

// A point of a body turns about a fixed axis far from the origin. Its distances keep the digits that the body has.
TEST(Scaling, DistancesFarAwayKeepTheirDigits) {
  const double height = 0.3, arm = 0.7;
  for (const double far : {0.0, 12345.678901, 7.3e8}) {
    SceneBuilder builder("far", 3);
    builder.fixed_point("O", {far, -3 * far, far / 7}).fixed_vector("axis", {2.0 / 3, 1.0 / 3, -2.0 / 3});
    builder.fixed_vector("zero", {1 / std::sqrt(5.0), -2 / std::sqrt(5.0), 0});
    builder.vector("u", {1 / std::sqrt(5.0), -2 / std::sqrt(5.0), 0})
        .vector("v", {-4 / std::sqrt(45.0), -2 / std::sqrt(45.0), -5 / std::sqrt(45.0)});
    builder.add(Body{"arm", "O", {"u", "v", "axis"}, {}, {{"P", {arm, 0, height}}}, {}});
    builder.drive("motor", RelativeAngle{"zero", "u", "axis", Law::polynomial({0, 1})});
    builder.measure("reach", MeasuredDistance{"O", "P"}).output("reach").time(0, 1, 0.125);
    const test::Result r = test::run(builder.build());
    ASSERT_TRUE(r.report().status.ok());
    for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
      EXPECT_NEAR(r.trajectory(k, 0), std::hypot(arm, height), 16 * kEps) << far;
      EXPECT_NEAR(r.trajectory(k, 2), 0, 64 * kEps) << far;
    }
  }
}

}  // namespace
}  // namespace assur
