// The range of a driver ends at the folds of closed forms, both ways.
#include "assur/motion_range.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "assur/simulator.hpp"
#include "motion/limited.hpp"
#include "numbers.hpp"
#include "samples/samples.hpp"
#include "source_dir.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

constexpr double kDegree = kTurn / 360;

void expect_fold(const RangeEnd& end, double value, double size) {
  EXPECT_EQ(end.code, Code::fold);
  EXPECT_LE(std::min(end.reached, end.beyond), value);
  EXPECT_GE(std::max(end.reached, end.beyond), value);
  EXPECT_LE(std::abs(end.beyond - end.reached), 1e-12 * size);
}

TEST(MotionRange, OfAFourBarEndsAtBothFolds) {
  const Scene scene = test::limited_four_bar(Law::polynomial({0.5, 1})).time(0, 1, 0.01).build();
  const MotionRange range = motion_range(scene);
  EXPECT_EQ(range.driver, scene.drivers().front().name);
  EXPECT_EQ(range.start, 0.5);
  EXPECT_EQ(range.unit, "rad");
  expect_fold(range.high, std::acos(0.04), 1);
  expect_fold(range.low, -std::acos(0.04), 1);
}

TEST(MotionRange, OfBricardsHingeEqualsThePublishedRange) {
  const MotionRange range = motion_range(read_scene(ASSUR_SOURCE_DIR "/scenes/bricard_joints.json"), "motor");
  expect_fold(range.low, -30 * kDegree, 1);
  expect_fold(range.high, 210 * kDegree, 4);
}

TEST(MotionRange, OfACrankIsAWholeTurn) {
  const MotionRange range = motion_range(sample("slider_crank"));
  EXPECT_EQ(range.low.code, Code::ok);
  EXPECT_EQ(range.high.code, Code::ok);
  EXPECT_EQ(range.low.group + range.high.group, "");
  EXPECT_DOUBLE_EQ(range.high.reached, range.start + kTurn);
  EXPECT_DOUBLE_EQ(range.low.reached, range.start - kTurn);
  EXPECT_DOUBLE_EQ(motion_range(sample("slider_crank"), "", 0.25).high.reached, range.start + 0.25);
}

// A cylinder from D to B, which turns about A, is as long as |AB| - |AD| to |AB| + |AD|. The size does not matter.
TEST(MotionRange, OfACylinderEndsWhereTheTriangleIsFlat) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    SceneBuilder builder("crane", 2);
    builder.fixed_point("A", {0, 0}).fixed_point("D", {size, 0}).point("B", {size, 2 * size});
    builder.constrain("boom", Distance{"A", "B", std::sqrt(5.0) * size});
    Driver cylinder{"cylinder", DrivenDistance{"D", "B", Law::polynomial({0, 0.2 * size})}, true};
    const Scene scene = builder.add(cylinder).time(0, 1, 0.01).build();
    const MotionRange range = motion_range(scene, "cylinder");  // from 2 size
    EXPECT_EQ(range.start, 0);
    EXPECT_EQ(range.unit, "m");
    expect_fold(range.low, (std::sqrt(5.0) - 1 - 2) * size, size);
    expect_fold(range.high, (std::sqrt(5.0) + 1 - 2) * size, size);
  }
}

// Other drivers rest. Every value of a pose has a range of its own, and it ends where the run with that law ends.
TEST(MotionRange, OfAValueOfAPoseEndsWhereItsRunEnds) {
  const Scene stewart = sample("stewart");
  const MotionRange range = motion_range(stewart, stewart.drivers().front().name + ".z");
  EXPECT_LT(range.low.reached, range.start);
  EXPECT_GT(range.high.reached, range.start);
  for (const auto& [end, sign] : {std::pair{range.low, -1.0}, {range.high, 1.0}}) {
    if (end.code == Code::ok) continue;
    const Scene run = stewart.with_laws([&, sign = sign](const std::string& name, const Law& law) {
      const double value = law(stewart.time().start).value;
      return name == range.driver ? Law::polynomial({value, sign}) : Law::constant(value);
    });
    Simulator s(prepare(run.with_time({0, 10, 0.01}), {.strategy = "groups/eigen"}));
    (void)s.run();
    EXPECT_EQ(s.report().status.code, end.code);
    EXPECT_NEAR(range.start + sign * s.report().events.back().time, end.reached, 1e-11);
  }
}

TEST(MotionRange, ListsTheDriversIfTheNameIsWrong) {
  const Scene stewart = sample("stewart");
  const auto refusal = [&](const Scene& scene, const std::string& driver, double farthest) {
    return look::error(Error::Kind::input, [&] { (void)motion_range(scene, driver, farthest); });
  };
  EXPECT_NE(refusal(stewart, "", 0).find("6 drivers; name one of them"), std::string::npos);
  EXPECT_NE(refusal(stewart, "motr", 0).find("there is no driver 'motr'"), std::string::npos);
  EXPECT_NE(refusal(sample("four_bar"), "", kNan).find("it must be finite"), std::string::npos);
  SceneBuilder still("still", 2);
  still.fixed_point("A", {0, 0}).fixed_point("D", {1, 0}).point("B", {0.5, 0.8});
  still.constrain("one", Distance{"A", "B"}).constrain("two", Distance{"D", "B"});
  EXPECT_NE(refusal(still.build(), "", 0).find("no driver"), std::string::npos);
}

}  // namespace
}  // namespace assur
