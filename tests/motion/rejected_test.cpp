// A rejected attempt at a step leaves no trace: the next one starts from the last accepted posture.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kOffset = 0.885;  // rad: the crank swings by 1 rad about it
constexpr double kLargest = 3.2;   // m, the largest coordinate
constexpr double kCondition = 50;  // largest condition on the whole way

// A four-bar followed by a dyad, regular in all postures. Steps are so long that the dyad, which is solved last,
// rejects many attempts that the four-bar has accepted.
Scene four_bar_and_dyad(double step, std::int64_t steps) {
  SceneBuilder b("four_bar_and_dyad", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).fixed_point("F", {3.2, 0.7, 0});
  b.point("B", {0.95 * std::cos(kOffset), 0.95 * std::sin(kOffset), 0}).point("C", {2.2, 1.1, 0});
  b.point("E", {2.5 + std::cos(kOffset), 1.5, 0});
  b.constrain("crank", Distance{"A", "B", 0.95});
  b.constrain("coupler", Distance{"B", "C", 1.9}).constrain("rocker", Distance{"D", "C", 1.1});
  b.constrain("rod", Distance{"C", "E", 1.8}).constrain("arm", Distance{"F", "E", 1.7});
  b.drive("motor", PointAngle{"A", "B", "", Law::harmonics({{1, 1.25, 0}}, kOffset)});
  b.measure("first", AbsoluteAngle{"D", "C"}).measure("last", AbsoluteAngle{"F", "E"});
  return b.time(0, step * static_cast<double>(steps), step).build();
}

TEST(Rejected, AttemptsLeaveNoTrace) {
  test::Draw draw(12);
  std::int64_t rejected = 0;
  const int all = test::random_count(150);
  for (int i = 0; i < all; ++i) {
    const double step = i == 0 ? 0.3700174936818723 : draw.real(0.02, 0.4);
    const Scene scene = four_bar_and_dyad(step, static_cast<std::int64_t>(30 / step));
    const std::string strategy = i % 2 == 0 ? "irreducible/lanes" : "groups/eigen";
    SCOPED_TRACE(std::to_string(step) + " s, " + strategy);
    const test::Result r = test::run(scene, strategy);
    ASSERT_TRUE(r.report().status.arrived()) << name(r.report().status.code) << " at " << r.report().reached;
    rejected += r.counters().rejected;
    // Groups that are left out must not influence the other groups.
    const test::Result one = test::run(scene.with_outputs({"E.position"}), strategy);
    ASSERT_TRUE(one.report().status.arrived()) << name(one.report().status.code);
    EXPECT_NEAR(one.trajectory.last("E.x"), r.trajectory.last("E.x"), 2 * 8 * kEps * kCondition * kLargest);
  }
  EXPECT_GT(rejected, all);
}

}  // namespace
}  // namespace assur
