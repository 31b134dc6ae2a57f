// The unit of length is nobody's business: scaling all lengths by a power of two changes no bit.
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
  // Both rebuilt: building normalises the vectors once more.
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

TEST(Scaling, ByAPowerOfTwoChangesNoBit) {
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

}  // namespace
}  // namespace assur
