// If a solver alone is not accurate enough, its solutions are refined, and the run reports this.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr int kSize = 60;

double entry(int i, int j) { return j == kSize - 1 || i == j ? 1.0 : j < i ? -1.0 : 0.0; }

// These numbers have few bits, so that their sums are exact.
double wanted(int j) { return (j * 7 % 11 - 5) / 16.0; }

// Wilkinson's matrix in a callback: partial pivoting doubles its last column in every step (growth 2^59). W x = w B.x,
// where w = W wanted: x = wanted cos t.
Scene growing() {
  SceneBuilder b("growing", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0}).constrain("crank", Distance{"A", "B", 1.0});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 1})});
  Callback c;
  c.equations = kSize;
  std::vector<double> w(kSize, 0.0);
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j < kSize; ++j) w[static_cast<std::size_t>(i)] += entry(i, j) * wanted(j);
  }
  for (int i = 0; i < kSize; i += 2) {
    const std::string name = "P" + std::to_string(i / 2);
    b.point(name, {wanted(i), wanted(i + 1), 0});
    c.coordinates.push_back(name + ".x");
    c.coordinates.push_back(name + ".y");
  }
  c.coordinates.push_back("B.x");
  c.residual = [w](std::span<const double> x, std::span<double> phi) {
    for (int i = 0; i < kSize; ++i) {
      double sum = -w[static_cast<std::size_t>(i)] * x[kSize];
      for (int j = 0; j < kSize; ++j) sum += entry(i, j) * x[static_cast<std::size_t>(j)];
      phi[static_cast<std::size_t>(i)] = sum;
    }
  };
  c.jacobian = [w](std::span<const double>, std::span<double> jacobian) {
    for (int i = 0; i < kSize; ++i) {
      double* const row = jacobian.data() + i * (kSize + 1);
      for (int j = 0; j < kSize; ++j) row[j] = entry(i, j);
      row[kSize] = -w[static_cast<std::size_t>(i)];
    }
  };
  c.curvature = [](std::span<const double>, std::span<const double>, std::span<double> out) {
    std::fill(out.begin(), out.end(), 0.0);
  };
  b.constrain("wilkinson", std::move(c));
  return b.time(0, 1, 0.1).build();
}

TEST(Safer, RefinesFactorsWithGrowth) {
  for (const std::string& solver : test::solvers()) {
    const test::Result r = test::run(growing(), "groups/" + solver);
    ASSERT_TRUE(r.report().status.ok()) << solver << " " << name(r.report().status.code);
    EXPECT_EQ(r.trajectory.rows(), 11u);
    EXPECT_LE(r.report().error.velocity, 1e-14) << solver;
    EXPECT_LE(r.report().error.acceleration, 1e-14) << solver;
    // Condition 60 in the maximum norm: the error is at most a few times 60 roundings.
    for (const int j : {0, 2, 30, 58}) {
      const std::string name = "P" + std::to_string(j / 2);
      EXPECT_NEAR(r.trajectory.last(name + ".x"), wanted(j) * std::cos(1.0), 1e-13) << solver << j;
      EXPECT_NEAR(r.trajectory.last(name + ".vx"), -wanted(j) * std::sin(1.0), 1e-13) << solver << j;
    }
    if (solver == "eigen") {
      EXPECT_GT(r.report().effort.unplanned, 0);
      ASSERT_FALSE(r.report().fallbacks.empty());
      EXPECT_NE(r.report().fallbacks.back().find("refined, because the pivots had grown"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace assur
