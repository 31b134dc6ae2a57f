// The comparison program of the benchmarks computes the same motion.
#include "afternoon.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using bench::Afternoon;
using bench::KluOptions;

struct Off {
  double value = 0, rate = 0, acceleration = 0;
};

// The largest difference between both programs over the largest value of the run.
template <class Mechanism>
Off compare(const Scene& whole, const Mechanism& mechanism, int points, KluOptions options) {
  std::vector<std::string> names;
  for (int i = 1; i <= points; ++i) names.push_back("B" + std::to_string(i));
  const Scene scene = whole.with_outputs(names);
  const test::Result library = test::run(scene, "irreducible/eigen");
  EXPECT_TRUE(library.report().status.ok());

  Afternoon<Mechanism> rival(mechanism, options);
  const auto d = static_cast<std::size_t>(scene.dimension());
  EXPECT_EQ(library.trajectory.columns().size(), 3 * d * names.size());
  double off[3] = {}, largest[3] = {};
  for (std::size_t k = 0; k < library.trajectory.rows(); ++k) {
    const bool ok = rival.step(library.trajectory.times()[k]);
    EXPECT_TRUE(ok) << k;
    if (!ok) break;
    EXPECT_LE(rival.residual(), bench::kRivalTolerance);
    const std::span<const double> of_rival[3] = {rival.position(), rival.velocity(), rival.acceleration()};
    for (std::size_t i = 0; i < d * names.size(); ++i) {
      for (std::size_t part = 0; part < 3; ++part) {  // columns of a point: x y (z) vx vy (vz) ax ay (az)
        const double expected = library.trajectory(k, i / d * 3 * d + part * d + i % d);
        const double difference = std::abs(of_rival[part][i] - expected);
        if (!(difference <= off[part])) off[part] = difference;
        largest[part] = std::max(largest[part], std::abs(expected));
      }
    }
  }
  return {off[0] / largest[0], off[1] / largest[1], off[2] / largest[2]};
}

constexpr double kRequired = 1e-10;  // largest error of a rival, even if the condition allows more

// Both programs satisfy every equation to 8 eps of its terms, so that they differ by at most 2 x 8 eps x condition.
// Each derivative has one more factor of the condition. Growth by the pivots in the linear systems of the derivatives
// is added: up to 1000 for klu_defaults, whose pivots may be 0.001 of their column, and 4 for partial pivoting in
// blocks of three.
void expect_within(const Off& off, double condition, KluOptions options) {
  const double residual = 2 * 8 * kEps;
  const double pivots = options == KluOptions::defaults ? 1000 * kEps * condition : 0;  // others are within the 8 eps
  EXPECT_LE(off.value, std::min(kRequired, residual * condition));
  EXPECT_LE(off.rate, std::min(kRequired, residual * std::pow(condition, 2) + pivots));
  EXPECT_LE(off.acceleration, std::min(kRequired, residual * std::pow(condition, 3) + pivots * condition));
  EXPECT_GT(off.value, 0);  // two different programs do not agree bitwise
}

// |J^-1| times the scale of residuals over the largest coordinate: at most 4.7 on this motion.
constexpr double kLegCondition = 5;
// Errors across the rocker of a loop: three lengths divided by the sine between coupler and rocker, which is at least
// 1/2. They propagate to the next loop.
constexpr double kLoopCondition = 6;

class RivalMotion : public testing::TestWithParam<KluOptions> {};

TEST_P(RivalMotion, StewartAgreesWithTheLibrary) {
  expect_within(compare(sample("stewart"), bench::StewartHandles(), 6, GetParam()), kLegCondition, GetParam());
}

TEST_P(RivalMotion, StewartAgreesWithTheFile) {
  const Scene file = read_scene(ASSUR_SOURCE_DIR "/scenes/stewart.json");
  expect_within(compare(file, bench::StewartHandles(), 6, GetParam()), kLegCondition, GetParam());
}

TEST_P(RivalMotion, ChainsAgreeWithTheLibrary) {
  for (const int loops : {1, 10, 100}) {
    SCOPED_TRACE(loops);
    const Scene scene = sample("four_bar:" + std::to_string(loops));
    expect_within(compare(scene, bench::FourBarChain(loops), loops, GetParam()), kLoopCondition * loops, GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(Klu, RivalMotion, testing::Values(KluOptions::defaults, KluOptions::unscaled),
                         [](const auto& test) { return test.param == KluOptions::defaults ? "defaults" : "unscaled"; });

}  // namespace
}  // namespace assur
