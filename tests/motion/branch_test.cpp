// Runs stay on the branch in difficult cases, and report if the branch is undecidable.
#include <gtest/gtest.h>

#include "errors/deviation.hpp"
#include "references/planar.hpp"

namespace assur {
namespace {

using references::QuadJet;

using test::Result;

struct Verdict {
  std::size_t rows = 0;  // rows on the branch of the closed form
  double worst = 0;      // largest error / bound of these rows
  double largest = 0;    // largest error of these rows, m
  bool left = false;     // a row is off the branch
};

// Compares B1, the end of the rocker, with the closed form. Coupler and rocker hold their lengths to 8 eps of the
// coordinates of their ends. The errors move B1 by at most 8 sqrt(2) * 2 * 5 eps / sigma, where sigma is the sine
// between coupler and rocker: sqrt(2) for x and y, 2 for two lengths, 5 m for the coordinates of both ends. Near sigma
// = 0 the bound is the square root of the error of the lengths.
Verdict judge(const Trajectory& trajectory, double delta) {
  Verdict v;
  const std::size_t x = trajectory.index("B1.x");
  const double length_error = 8 * std::sqrt(2.0) * 2 * 5 * kEps;
  for (std::size_t k = 0; k < trajectory.rows(); ++k) {
    const auto at = references::almost_parallelogram(delta, trajectory.times()[k]);
    const auto &b0 = at.at("B0"), &b1 = at.at("B1");
    const double cx = static_cast<double>(b1[0].value - b0[0].value),
                 cy = static_cast<double>(b1[1].value - b0[1].value);
    const double rx = static_cast<double>(b1[0].value) - 2, ry = static_cast<double>(b1[1].value);
    const double sine = std::abs(cx * ry - cy * rx) / (2 * (1 + delta));
    const double bound = std::min(length_error / sine, 2 * std::sqrt(length_error));
    const double off = std::hypot(static_cast<double>(trajectory(k, x) - b1[0].value),
                                  static_cast<double>(trajectory(k, x + 1) - b1[1].value));
    if (off > bound) {
      v.left = true;
      break;
    }
    ++v.rows;
    v.worst = std::max(v.worst, off / bound);
    v.largest = std::max(v.largest, off);
  }
  return v;
}

std::vector<std::string> strategies() {
  return {"groups/eigen", "groups/" + test::sparse() + "+once", "irreducible/eigen+predict=past:3",
          "global/" + test::sparse() + "+predict=taylor:2"};
}

Scene almost_parallelogram(double delta, double step, int turns = 1) {
  return sample("almost_parallelogram", {{"delta", delta}, {"step", step}, {"steps", std::round(turns / step)}});
}

// From delta = 1e-6 downwards, plain Newton iteration ends up to 2 m off with a perfect residual. Here either every row
// follows the branch over the whole turn, or a status or an event reports doubt and all rows before it are right.
TEST(AlmostParallelogram, FollowsTheBranchOrReportsDoubt) {
  for (const double delta : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 3e-13, 1e-13}) {
    for (const double step : {0.01, 0.0033, 0.0625}) {
      for (const std::string& strategy : strategies()) {
        SCOPED_TRACE(std::to_string(std::log10(delta)) + " dt " + std::to_string(step) + " " + strategy);
        const Result r = test::run(almost_parallelogram(delta, step), strategy);
        const Verdict v = judge(r.trajectory, delta);
        double sure_until = r.report().reached;
        for (const Event& e : test::events(r.report())) sure_until = std::min(sure_until, e.time);
        std::size_t sure_rows = 0;
        while (sure_rows < r.trajectory.rows() && r.trajectory.times()[sure_rows] <= sure_until) ++sure_rows;
        EXPECT_GE(v.rows, sure_rows) << "error over bound before: " << v.worst << ", error " << v.largest << " m";
        EXPECT_LE(r.report().error.position, 1e-14);
        if (r.report().status.arrived()) {
          EXPECT_EQ(r.trajectory.rows(), static_cast<std::size_t>(std::round(1 / step)) + 1);
        }
        // Branches that come close are not mistaken for branches that cross.
        for (const Event& e : r.report().events) EXPECT_NE(e.kind, Code::change_point_passed);
        if (delta >= 1e-12) {
          EXPECT_TRUE(r.report().status.arrived());
          EXPECT_EQ(v.rows, r.trajectory.rows()) << "error over bound: " << v.worst;
        }
        if (delta >= 1e-10) {
          EXPECT_TRUE(r.report().status.arrived());
          EXPECT_TRUE(test::events(r.report()).empty());
        }
      }
    }
  }
}

// delta = 0: the two branches cross at crank angles 0 and pi. B1 = B0 + (2, 0) is the smooth continuation through all
// crossings. The steps are chosen so that no row lies on a change point.
TEST(Parallelogram, PassesItsChangePoints) {
  for (const double step : {0.0033, 0.0027, 0.0071}) {
    for (const std::string formulation : {"global", "groups", "irreducible"}) {
      for (const std::string option :
           {"", "+once", "+reuse=run", "+predict=taylor:0", "+once+predict=taylor:1", "+predict=taylor:2",
            "+predict=hermite:5", "+predict=past:2", "+reuse=run+predict=past:5"}) {
        const std::string strategy =
            formulation + "/" + test::solvers()[option.size() % test::solvers().size()] + option;
        SCOPED_TRACE(strategy + " dt " + std::to_string(step));
        const Result r = test::run(almost_parallelogram(0, step, 2), strategy);
        ASSERT_TRUE(r.report().status.arrived()) << "at " << r.report().reached;
        const std::vector<Event> events = test::events(r.report());
        ASSERT_EQ(events.size(), 4u);
        for (std::size_t i = 0; i < 4; ++i) {
          const Event& e = events[i];
          const double change = 0.25 + 0.5 * static_cast<double>(i);
          EXPECT_EQ(e.kind, Code::change_point_passed);
          EXPECT_EQ(e.group, formulation == "global" ? "all" : "B1");
          EXPECT_LT(e.time, change);
          EXPECT_GT(e.until, change);
          EXPECT_LE(e.until - e.time, step / 128);
        }
        // Rows are at least 0.0005 turns from a change point, so that sigma > 1e-3 in the bound of judge().
        const double bound = 8 * std::sqrt(2.0) * 2 * 5 * kEps / 1e-3;
        const std::size_t x0 = r.trajectory.index("B0.x"), x1 = r.trajectory.index("B1.x");
        for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
          ASSERT_NEAR(r.trajectory(k, x1), r.trajectory(k, x0) + 2, bound) << k;
          ASSERT_NEAR(r.trajectory(k, x1 + 1), r.trajectory(k, x0 + 1), bound) << k;
        }
      }
    }
  }
}

// The crank of a rhombus swings a little or far beyond the line where the branches cross, with long and short steps.
// Every run may end early or pass the line, but none of its rows is on the other branch.
TEST(Rhombus, KeepsItsBranchForEveryStepAndPredictor) {
  int arrived = 0;
  for (const double swing : {1.5709, 1.575, 1.58, 1.6, 1.65, 1.7, 1.8, 2.0, 2.5}) {
    for (const double steps : {37, 50, 77, 100, 133, 200, 317, 500, 1000}) {
      for (const char* strategy :
           {"global/eigen", "irreducible/lanes", "global/eigen+reuse=run", "irreducible/eigen+float",
            "irreducible/eigen+once", "irreducible/eigen+predict=taylor:0", "irreducible/lanes+predict=taylor:1",
            "irreducible/eigen+predict=past:3", "irreducible/lanes+predict=hermite:5"}) {
        SCOPED_TRACE(std::to_string(swing) + " steps " + std::to_string(steps) + " " + strategy);
        const Result r = test::run(sample("n_four_bar", {{"loops", 1}, {"swing", swing}, {"steps", steps}}), strategy);
        arrived += r.report().status.arrived() ? 1 : 0;
        const Trajectory& t = r.trajectory;
        const std::size_t crank = t.index("B0.x"), rocker = t.index("B1.x");
        for (std::size_t k = 0; k < t.rows(); ++k) {
          // The coupler stays parallel to the frame; on the other branch the rocker lies on the frame.
          const double off = std::hypot(t(k, rocker) - t(k, crank) - 1, t(k, rocker + 1) - t(k, crank + 1));
          ASSERT_LE(off, 1e-6) << "at " << t.times()[k];
        }
      }
    }
  }
  EXPECT_GT(arrived, 500);
}

// If only positions are outputs, the run still computes the rates that are needed to keep the branch.
TEST(Parallelogram, PassesItsChangePointsWithPositionsOnly) {
  const double step = 0.0033;
  const Result whole = test::run(almost_parallelogram(0, step, 2), "groups/eigen");
  ASSERT_TRUE(whole.report().status.arrived());
  const Result r = test::run(almost_parallelogram(0, step, 2).with_outputs({"B1.position"}), "groups/eigen");
  ASSERT_TRUE(r.report().status.arrived()) << "at " << r.report().reached;
  const std::vector<Event> expected = test::events(whole.report()), events = test::events(r.report());
  ASSERT_EQ(events.size(), expected.size());
  for (std::size_t i = 0; i < events.size(); ++i) EXPECT_EQ(events[i].kind, expected[i].kind);
  EXPECT_TRUE(std::isnan(r.report().error.velocity));             // velocities are not outputs
  const double bound = 8 * std::sqrt(2.0) * 2 * 5 * kEps / 1e-3;  // as in PassesItsChangePoints
  const std::size_t x = whole.trajectory.index("B1.x");
  for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
    ASSERT_NEAR(r.trajectory(k, 0), whole.trajectory(k, x), bound) << k;
    ASSERT_NEAR(r.trajectory(k, 1), whole.trajectory(k, x + 1), bound) << k;
  }
}

// At the change point the equations do not determine the velocity. A row there is the limit of the motion on both
// sides, never one of the other branch.
TEST(Parallelogram, HasTheRowsOnItsChangePoints) {
  for (const auto& [step, strategy] :
       {std::pair{0.01, std::string("groups/eigen")}, {0.005, std::string("global/eigen")}}) {
    SCOPED_TRACE(strategy + " dt " + std::to_string(step));
    const Result r = test::run(almost_parallelogram(0, step, 2), strategy);
    EXPECT_TRUE(r.report().status.arrived());
    const std::vector<Event> events = test::events(r.report());
    ASSERT_EQ(events.size(), 4u);
    for (std::size_t i = 0; i < events.size(); ++i) {
      const double change = 0.25 + 0.5 * static_cast<double>(i);
      EXPECT_EQ(events[i].kind, Code::change_point_passed);
      EXPECT_LE(events[i].time, change);
      EXPECT_GT(events[i].time, change - step / 16384);
      EXPECT_GE(events[i].until, change);
    }
    const Trajectory& t = r.trajectory;
    ASSERT_EQ(t.rows(), static_cast<std::size_t>(std::round(2 / step)) + 1);
    const std::size_t crank = t.index("B0.x"), rocker = t.index("B1.x");
    for (std::size_t k = 0; k < t.rows(); ++k) {
      EXPECT_NEAR(t(k, rocker), t(k, crank) + 2, 1e-11) << k;
      EXPECT_NEAR(t(k, rocker + 1), t(k, crank + 1), 1e-11) << k;
      EXPECT_NEAR(t(k, t.index("B1.vx")), t(k, t.index("B0.vx")), 1e-9) << k;
      EXPECT_NEAR(t(k, t.index("B1.ay")), t(k, t.index("B0.ay")), 1e-7) << k;
    }
  }
}

}  // namespace
}  // namespace assur
