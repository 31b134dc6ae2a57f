// Long chains of groups, each driven by the previous one, and large groups.
#include <gtest/gtest.h>

#include "errors/deviation.hpp"
#include "references/planar.hpp"

namespace assur {
namespace {

using references::Posture;
using references::QuadJet;
using test::Deviation;

using test::Result;

struct Chain {
  std::string text;
  int loops;
  double spacing;  // A_i = (spacing i, 0)
  Posture<QuadJet> (*closed_form)(int loops, double t);
  std::int64_t every;  // rows between two comparisons; the closed form of a long chain is slow
};

Posture<QuadJet> crank_rockers(int loops, double t) { return references::four_bar_chain(loops, t); }

const Chain kSingle = {"four_bar:1", 1, 2, crank_rockers, 1};
const Chain kShort = {"four_bar:10", 10, 2, crank_rockers, 2};
const Chain kMiddle = {"four_bar:64", 64, 2, crank_rockers, 8};
const Chain kLong = {"four_bar:1000", 1000, 2, crank_rockers, 40};
const Chain kRhombi = {"n_four_bar:40", 40, 1, references::n_four_bar, 5};

// Largest possible |B_i - closed form|. Each length holds to 8 eps (the criterion of convergence) of the sum of the
// coordinates of its ends, times sqrt(2) for x and y. A rocker adds the errors of three lengths (the previous rocker,
// the coupler, the rocker), divided by the sine between coupler and rocker. From the second loop on, all loops are
// parallelograms, which pass on the previous error without growth. The error therefore grows with the number of loops
// and with the coordinates.
class Bound {
 public:
  Bound(const Chain& chain, const Posture<QuadJet>& at) : chain_(chain), at_(at) {}

  double next(int i) {
    const auto [px, py] = end(i - 1);
    const auto [qx, qy] = end(i);
    const double cx = qx - px, cy = qy - py, rx = qx - chain_.spacing * i, ry = qy;
    const double sine = std::abs(cx * ry - cy * rx) / (std::hypot(cx, cy) * std::hypot(rx, ry));
    const double length_error = 8 * std::sqrt(2.0) * kEps * 2 * std::hypot(qx, qy);
    across_ += 3 * length_error / sine;
    return across_ + length_error;
  }

 private:
  [[nodiscard]] std::pair<double, double> end(int i) const {
    const auto& b = at_.at("B" + std::to_string(i));
    return {static_cast<double>(b[0].value), static_cast<double>(b[1].value)};
  }

  const Chain& chain_;
  const Posture<QuadJet>& at_;
  double across_ = 0;
};

void expect_closed_form(const Chain& chain, const std::string& strategy) {
  SCOPED_TRACE(chain.text + " " + strategy);
  const Scene scene = sample(chain.text);
  const Result r = test::run(scene, strategy);
  ASSERT_EQ(r.report().status.code, Code::ok) << "at " << r.report().reached;
  EXPECT_TRUE(r.report().events.empty());
  EXPECT_LE(r.report().error.position, 1e-14);

  std::vector<std::size_t> column;
  for (int i = 0; i <= chain.loops; ++i) column.push_back(r.trajectory.index("B" + std::to_string(i) + ".x"));
  Deviation deviation(r.trajectory);
  for (std::int64_t k = 0; k <= scene.time().steps(); k += chain.every) {
    const auto row = static_cast<std::size_t>(k);
    const Posture<QuadJet> at = chain.closed_form(chain.loops, scene.time().time(k));
    Bound bound(chain, at);
    for (int i = 1; i <= chain.loops; ++i) {
      const auto& b = at.at("B" + std::to_string(i));
      const std::size_t c = column[static_cast<std::size_t>(i)];
      const double dx = static_cast<double>(r.trajectory(row, c) - b[0].value);
      const double dy = static_cast<double>(r.trajectory(row, c + 1) - b[1].value);
      ASSERT_LE(std::hypot(dx, dy), bound.next(i)) << "B" << i << " in row " << row;
    }
    for (const auto& [name, b] : at) deviation.add(row, name, b);
  }
  // Deviations are relative to the largest value of the run.
  const Motion off = deviation.worst();
  EXPECT_LE(off.value, 1e-12);
  EXPECT_LE(off.rate, 1e-11);
  EXPECT_LE(off.acceleration, 1e-11);
}

TEST(Chains, CrankRockersFollowTheClosedForm) {
  expect_closed_form(kSingle, "groups/eigen");
  expect_closed_form(kShort, "irreducible/eigen");
  expect_closed_form(kMiddle, "groups/" + test::sparse());
  expect_closed_form(kMiddle, "global/" + test::sparse());
}

TEST(Chains, SolvesAThousandLoops) { expect_closed_form(kLong, "groups/eigen"); }

TEST(Chains, RhombiFollowTheClosedForm) {
  expect_closed_form(kRhombi, "groups/eigen");
  expect_closed_form(kRhombi, "irreducible/" + test::sparse());
  expect_closed_form(kRhombi, "global/" + test::sparse());
}

struct Rings {
  std::string text;
  std::int64_t steps;
};

// The condition is 5 to 16 for all n from 12 to 720, so iterations and errors do not grow with n.
TEST(Rings, TakeTwoIterationsAtMost) {
  for (const Rings& rings : {Rings{"rings:legs=6,n=12,terminal=12", 1000}, Rings{"rings:legs=6,n=24", 1000},
                             Rings{"rings:legs=6,n=120", 300}, Rings{"rings:legs=3,n=360,terminal=72", 200},
                             Rings{"rings:legs=2,n=720,terminal=24", 100}}) {
    SCOPED_TRACE(rings.text);
    const Scene scene = sample(rings.text, {{"steps", static_cast<double>(rings.steps)}});
    const Result r = test::run(scene, "groups/" + test::sparse());
    ASSERT_EQ(r.report().status.code, Code::ok) << "at " << r.report().reached;
    EXPECT_TRUE(r.report().events.empty());
    EXPECT_LE(r.counters().most_iterations, 2);
    EXPECT_EQ(r.counters().rejected, 0);
    EXPECT_LE(r.report().error.position, 1e-14);
    EXPECT_GT(r.report().error.position, 0);
    // The normwise backward error of a sparse LU without growth of the entries is a few eps for every n.
    EXPECT_LE(r.report().error.velocity, 1e-14);
    EXPECT_LE(r.report().error.acceleration, 1e-14);
  }
}

TEST(Rings, DenseAndGlobalGiveTheSameMotion) {
  const Scene scene = sample("rings:legs=3,n=24", {{"steps", 200}});
  const Result groups = test::run(scene, "groups/" + test::sparse());
  for (const std::string strategy : {"groups/eigen", "global/eigen", "irreducible/eigen"}) {
    SCOPED_TRACE(strategy);
    const Result r = test::run(scene, strategy);
    ASSERT_TRUE(r.report().status.ok());
    EXPECT_LE(r.counters().most_iterations, 2);
    // Two solutions with residuals of 8 eps each. The condition is 16 in the terminal and 16 in the legs that it moves;
    // rates also include the error of the position times 16.
    EXPECT_LE(test::difference(groups.trajectory, r.trajectory), 2 * 8 * 16 * 16 * 16 * kEps);
  }
}

}  // namespace
}  // namespace assur
