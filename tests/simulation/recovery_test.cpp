// After a command that fails a simulator is as usable as before it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "simulation/delta_robot.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::kEps;

// The platform is lowered until two arms, or all three, are outstretched, and lifted again. There the rods that were
// chosen among the redundant ones become singular as well, and others are chosen.
TEST(Recovery, ADeltaRobotComesBackFromItsLimit) {
  const test::DeltaRobot robot;
  for (const std::string strategy : {"irreducible/eigen", "global/eigen", "irreducible/lanes"}) {
    for (const double x : {0.0, 0.05, 0.1}) {
      for (const double down : {0.001, 0.002, 0.005}) {
        SCOPED_TRACE(strategy + " x " + std::to_string(x) + " by " + std::to_string(down));
        Simulator s = test::simulator(robot.scene(), strategy, {}, {"pose"});
        double z = robot.home;
        Status status;
        for (int k = 0; k < 1000 && status.ok(); ++k) {
          z -= down;
          s.set("pose.x", x);
          s.set("pose.z", z);
          status = s.step();
        }
        EXPECT_EQ(status.code, Code::limit_reached);
        const double lowest = std::max({robot.lowest(0, x), robot.lowest(1, x), robot.lowest(2, x)});
        EXPECT_LT(z, lowest);
        EXPECT_GE(z, lowest - down);
        for (int k = 1; k <= 50; ++k) {
          s.set("pose.x", x);
          s.set("pose.z", z + k * down);
          const Status back = s.step();
          ASSERT_TRUE(back.arrived()) << k << " " << name(back.code) << " " << back.figure;
          EXPECT_NEAR(s.output("O.z"), z + k * down, 2 * kEps);
          const double away = z + k * down - lowest, sigma = std::sqrt(away);  // of the sine between arm and rods
          for (int arm = 0; arm < 3; ++arm) {
            const std::string elbow = "B" + std::to_string(arm);
            const Triple at = robot.elbow(arm, x, z + k * down);
            EXPECT_NEAR(s.output(elbow + ".x"), at[0], 64 * kEps / sigma);
            EXPECT_NEAR(s.output(elbow + ".y"), at[1], 64 * kEps / sigma);
            EXPECT_NEAR(s.output(elbow + ".z"), at[2], 64 * kEps / sigma);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace assur
