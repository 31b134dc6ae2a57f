// Lengths and unsigned angles have no derivatives where they are zero, unless they stay zero.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include "simulation/run.hpp"

namespace assur {
namespace {

// A bar in space turns about z from x. Its unsigned angle with another direction is measured.
Scene turning_bar(const std::string& law, const std::string& to, double start) {
  return parse_scene(R"({"assur": 1, "name": "bar", "dimension": 3,
    "points": {"O": {"at": [0, 0, 0], "fixed": true}, "P": {"at": [2, 0, 0]}},
    "vectors": {"x": {"at": [1, 0, 0], "fixed": true}, "back": {"at": [-1, 0, 0], "fixed": true},
                "aside": {"at": [0.6, 0.8, 3e-13], "fixed": true},
                "z": {"at": [0, 0, 1], "fixed": true}},
    "constraints": {"bar": {"distance": ["O", "P"], "value": 2}, "flat": {"dot": ["z", ["O", "P"]], "value": 0}},
    "drivers": {"motor": {"angle": ["O", "P"], "axis": "z", "law": {"polynomial": )" +
                     law + R"(}}},
    "measures": {"sight": {"angle": [["O", "P"], ")" +
                     to + R"("]}}, "outputs": ["sight"],
    "time": {"start": )" +
                     std::to_string(start) + R"(, "end": 1, "step": 0.125}})");
}

TEST(Kinks, AnUnsignedAngleHasNoRateWhereItReverses) {
  for (const std::string to : {"x", "back"}) {
    const test::Result r = test::run(turning_bar("[0, 2]", to, -0.5));
    EXPECT_TRUE(r.report().status.arrived());
    const bool away = to == "x";
    for (std::size_t k = 0; k < r.trajectory.times().size(); ++k) {
      const double t = r.trajectory.times()[k];
      const auto row = r.trajectory.row(k);
      EXPECT_NEAR(row[0], away ? std::abs(2 * t) : std::numbers::pi - std::abs(2 * t), 4 * kEps) << t;
      if (t == 0) {
        EXPECT_TRUE(std::isnan(row[1]) && std::isnan(row[2])) << row[1] << " " << row[2];
      } else {
        EXPECT_NEAR(row[1], (t < 0) == away ? -2 : 2, 64 * kEps) << t;
        EXPECT_NEAR(row[2], 0, 256 * kEps) << t;
      }
    }
    ASSERT_EQ(r.report().events.size(), 1U);
    EXPECT_EQ(r.report().events[0].kind, Code::inaccurate);
    EXPECT_EQ(r.report().events[0].until, 0);
    std::ostringstream csv;
    write_csv(csv, r.trajectory);
    EXPECT_NE(csv.str().find(away ? "\n0,0,,\n" : "\n0,3.141592653589793,,\n"), std::string::npos) << csv.str();
    EXPECT_LE(forward_error(r.simulator.prepared(), r.trajectory).velocity, 64 * kEps);
  }
}

TEST(Kinks, AnUnsignedAngleGrowsFromRest) {
  for (const std::string to : {"x", "back"}) {
    Simulator s = test::simulator(turning_bar("[0, 0, 3]", to, 0));
    EXPECT_TRUE(s.report().status.ok());
    EXPECT_EQ(s.output("sight"), to == "x" ? 0 : std::numbers::pi);
    EXPECT_EQ(s.output("sight.rate"), 0);
    EXPECT_NEAR(s.output("sight.acceleration"), to == "x" ? 6 : -6, 16 * kEps);
  }
}

TEST(Kinks, ALengthGrowsFromRest) {
  const auto meeting = [](Law law) {
    SceneBuilder builder("meeting", 2);
    builder.fixed_point("F", {1, 1, 0}).fixed_vector("along", {1, 0, 0}).point("P", {1, 1, 0});
    builder.constrain("line", OnLine{"P", "F", "along"});
    builder.drive("push", DrivenCoordinate{"P.x", std::move(law)});
    builder.measure("gap", MeasuredDistance{"F", "P"}).output("gap").time(0, 1, 0.25);
    return builder.build();
  };
  Simulator rests = test::simulator(meeting(Law::polynomial({1, 0, 2})));
  EXPECT_TRUE(rests.report().status.ok());
  EXPECT_EQ(rests.output("gap"), 0);
  EXPECT_EQ(rests.output("gap.rate"), 0);
  EXPECT_NEAR(rests.output("gap.acceleration"), 4, 16 * kEps);
  Simulator moves = test::simulator(meeting(Law::polynomial({1, 2})));
  EXPECT_EQ(moves.report().status.code, Code::inaccurate);
  EXPECT_TRUE(std::isnan(moves.output("gap.rate")));
  EXPECT_TRUE(moves.step().arrived());
  EXPECT_NEAR(moves.output("gap.rate"), 2, 16 * kEps);
}

// Outputs are checked before the first step, too. The bar passes a direction so closely that the angle and its
// acceleration are mostly rounding errors.
TEST(Kinks, ChecksTheStart) {
  Simulator s = test::simulator(turning_bar("[0.9272952180016122, 0.1]", "aside", 0), "auto", {}, {"motor"});
  EXPECT_NEAR(s.output("sight"), 3e-13, 1e-13);
  EXPECT_EQ(s.report().status.code, Code::inaccurate);
  ASSERT_EQ(s.report().events.size(), 1U);
  EXPECT_GT(s.report().events[0].figure, kDoubtfulError);
  EXPECT_TRUE(test::simulator(turning_bar("[0.3, 0.1]", "x", 0)).report().status.ok());
}

}  // namespace
}  // namespace assur
