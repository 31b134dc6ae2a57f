// Staying on the branch where it is hard, and saying so where it cannot be known.
#include <gtest/gtest.h>

#include <iostream>
#include <numbers>

#include "references/planar.hpp"
#include "simulation/deviation.hpp"

namespace assur {
namespace {

using references::QuadJet;
using test::kEps;
using test::Result;

struct Verdict {
  std::size_t rows = 0;   // on the closed form's branch
  double worst = 0;       // error / bound over these rows
  double largest = 0;     // error over these rows, m
  bool left = false;      // a row is off the branch
};

// The rocker's end against the closed form. Where the rocker and the coupler meet at an angle of sine sigma, lengths that
// hold to 8 eps of their ends' coordinates (up to 3 m, both lengths, x and y) leave B1 open by 8 sqrt(2) * 2 * 5 eps /
// sigma, and near sigma = 0 by the square root of that length error: never more.
Verdict judge(const Trajectory& trajectory, double delta) {
  Verdict v;
  const std::size_t x = trajectory.index("B1.x");
  const double length_error = 8 * std::sqrt(2.0) * 2 * 5 * kEps;
  for (std::size_t k = 0; k < trajectory.rows(); ++k) {
    const auto at = references::almost_parallelogram(delta, trajectory.times()[k]);
    const auto &b0 = at.at("B0"), &b1 = at.at("B1");
    const double cx = static_cast<double>(b1[0].value - b0[0].value), cy = static_cast<double>(b1[1].value - b0[1].value);
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

// Plain Newton ends up to 2 m off with a perfect residual from delta = 1e-6 on. Here every row of the table either
// follows the branch over the whole turn, or stops or says at which time it is no longer sure.
TEST(AlmostParallelogram, FollowsTheBranchOrSaysSo) {
  for (const double delta : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12}) {
    for (const double step : {0.01, 0.0033}) {
      for (const std::string& strategy :
           {std::string("groups/eigen"), "groups/" + test::sparse() + "+once", std::string("irreducible/eigen+predict=past:3"),
            std::string("global/eigen+predict=taylor:2")}) {
        const Result r = test::run(
            sample("almost_parallelogram", {{"delta", delta}, {"step", step}, {"steps", std::round(1 / step)}}), strategy);
        const Verdict v = judge(r.trajectory, delta);
        const bool clean = r.report().status.ok() && r.report().events.empty();
        double first_event = r.report().reached;
        for (const Event& e : r.report().events) first_event = std::min(first_event, e.time);
        std::size_t before_event = 0;
        while (before_event < r.trajectory.rows() && r.trajectory.times()[before_event] <= first_event) ++before_event;
        std::cout << delta << " " << step << " " << strategy << " status " << name(r.report().status.code) << " rows "
                  << r.trajectory.rows() << " right " << v.rows << " events " << r.report().events.size() << " at "
                  << first_event << " err/bound " << v.worst << " err " << v.largest << " rej " << r.counters().rejected
                  << " sub " << r.counters().substeps << "\n";
        if (clean) {
          EXPECT_EQ(r.trajectory.rows(), static_cast<std::size_t>(std::round(1 / step)) + 1);
          EXPECT_FALSE(v.left) << "after row " << v.rows;
        } else {
          EXPECT_GE(v.rows, before_event);
        }
      }
    }
  }
}

TEST(AlmostParallelogram, X0) {
  for (const double step : {0.01, 0.0033}) {
    for (const std::string& strategy :
         {std::string("groups/eigen"), "groups/" + test::sparse() + "+once", std::string("irreducible/eigen+predict=past:3"),
          std::string("global/eigen+predict=taylor:2")}) {
      const Result r = test::run(sample("almost_parallelogram", {{"delta", 0}, {"step", step}, {"steps", std::round(2 / step)}}), strategy);
      std::cout << step << " " << strategy << " " << name(r.report().status.code) << " reached " << r.report().reached;
      for (const Event& e : r.report().events) std::cout << " [" << e.time << "," << e.until << "] " << e.group << " " << name(e.kind);
      // a parallelogram: B1 = B0 + (2, 0)
      double off = 0;
      for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
        off = std::max({off, std::abs(r.trajectory(k, r.trajectory.index("B1.x")) - r.trajectory(k, r.trajectory.index("B0.x")) - 2),
                        std::abs(r.trajectory(k, r.trajectory.index("B1.y")) - r.trajectory(k, r.trajectory.index("B0.y")))});
      }
      std::cout << " off " << off << "\n";
    }
  }
}

}  // namespace
}  // namespace assur
