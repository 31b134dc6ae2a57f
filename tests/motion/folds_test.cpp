// A fold is found by evidence that the branch turns back, for every time grid. Growing rates do not prove a fold.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "properties/near_singular.hpp"
#include "properties/random_chains.hpp"
#include "properties/random_count.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

// The scene over [0, end] in `steps` steps.
Scene over(const Scene& scene, double end, int steps) {
  SceneBuilder b(scene.name(), scene.dimension());
  for (const Point& p : scene.points()) b.add(p);
  for (const Vector& v : scene.vectors()) b.add(v);
  for (const Body& body : scene.bodies()) b.add(body);
  for (const Constraint& c : scene.constraints()) b.add(c);
  for (const Driver& d : scene.drivers()) b.add(d);
  return b.time(0, end, end / steps).build();
}

// At t = 0.0033 s the six legs nearly reach a singular posture: rates grow to 200 m/s within a millisecond and fall
// again.
TEST(Folds, DifferFromNearlySingularPostures) {
  const Scene scene = read_scene(std::string(ASSUR_SOURCE_DIR) + "/tests/data/references/near_fold_stewart.json");
  double from = 0, until = 1;
  for (const int steps : {5, 10, 20, 30, 50, 1000}) {
    SCOPED_TRACE(steps);
    const test::Result r = test::run(over(scene, 4.3032, steps), "irreducible/eigen");
    EXPECT_EQ(r.report().status.code, Code::fold);
    ASSERT_FALSE(r.report().events.empty());
    const Event& e = r.report().events.back();
    EXPECT_NEAR(e.time, 0.25187, 0.00001);
    from = std::max(from, e.time);
    until = std::min(until, e.until);
  }
  EXPECT_LE(from, until);  // all brackets contain one common time
}

// The step that passes it, and no other, has an event with the time, whatever the strategy is.
TEST(Folds, NearlySingularPosturesAreEvents) {
  const Scene scene = read_scene(std::string(ASSUR_SOURCE_DIR) + "/tests/data/references/near_fold_stewart.json");
  for (const int steps : {5, 20, 50}) {
    for (const char* strategy : {"irreducible/eigen", "groups/lanes:4", "global/eigen+predict=taylor:0"}) {
      SCOPED_TRACE(strategy + std::to_string(steps));
      const test::Result r = test::run(over(scene, 0.2, steps), strategy);
      EXPECT_TRUE(r.report().status.arrived());
      int events = 0;
      for (const Event& e : r.report().events) {
        if (e.kind != Code::near_singular) continue;
        ++events;
        EXPECT_NEAR(e.time, 0.0033, 0.0002);
        EXPECT_GT(e.until, e.time);
        EXPECT_NE(e.group, "");
        EXPECT_GE(e.figure, 1000);
      }
      EXPECT_EQ(events, 1);
    }
  }
  for (const char* regular : {"four_bar:loops=3,step=0.9,steps=20", "stewart:step=0.5,steps=20", "klann"}) {
    const test::Result r = test::run(sample(regular), "groups/eigen+predict=taylor:0");
    for (const Event& e : r.report().events) EXPECT_NE(e.kind, Code::near_singular) << regular;
  }
}

// With every grid, the motion of a random platform or chain ends at the same time, or does not end early.
TEST(Folds, DoNotDependOnTheTimeGrid) {
  int ends = 0, goes_on = 0;
  const int all = test::random_count(60);
  for (int i = 0; i < all; ++i) {
    SCOPED_TRACE(i);
    int arrived = 0, limits = 0, refused = 0, others = 0;
    double until = std::numeric_limits<double>::infinity(), from = 0, end = 0;
    for (const int steps : {5, 20, 100, 1000}) {
      test::Draw draw(static_cast<std::uint64_t>(1000 + i));
      const Scene scene = i % 3 == 0   ? test::six_legs(draw, steps)
                          : i % 3 == 1 ? test::chain_with_triad(draw, steps)
                                       : test::three_legs(draw, steps);
      end = scene.time().end;
      try {
        const test::Result r = test::run(scene, "irreducible/eigen");
        const Code code = r.report().status.code;
        arrived += r.report().status.arrived() ? 1 : 0;
        limits += code == Code::fold ? 1 : 0;
        others += !r.report().status.arrived() && code != Code::fold ? 1 : 0;
        if (code != Code::fold) continue;
        const Event fold = test::events(r.report()).back();
        until = std::min(until, fold.until);
        from = std::max(from, fold.time);
        EXPECT_LE(fold.until - fold.time, 1e-10 * end);
      } catch (const Error&) {
        ++refused;  // the random start posture is singular
      }
    }
    if (refused > 0) continue;
    EXPECT_EQ(others, 0);
    EXPECT_TRUE(arrived == 0 || limits == 0) << arrived << " arrive, " << limits << " end";
    if (limits > 0) {
      EXPECT_LE(from, until);  // the times in brackets of all grids are the same
    }
    (limits > 0 ? ends : goes_on) += 1;
  }
  EXPECT_GT(ends, all / 4);
  EXPECT_GT(goes_on, all / 10);
}

// Close to a cusp the squares of singular values fall like those of a cubic until rounding ends the search. Long steps
// used to end as branch_unknown.
TEST(Folds, CloseToACuspAreFound) {
  for (const int steps : {5, 8, 20}) {
    SCOPED_TRACE(steps);
    test::Draw draw(737);
    const Scene scene = test::chain_with_triad(draw, steps);
    const test::Result r = test::run(scene, "irreducible/eigen");
    EXPECT_EQ(r.report().status.code, Code::fold);
    const Event fold = test::events(r.report()).back();
    EXPECT_LE(fold.until - fold.time, 1e-10 * scene.time().end);
  }
}

// Long steps along a nearly singular stretch need tens of thousands of parts. They used to be given up.
TEST(Folds, LongStepsAlongANearlySingularStretch) {
  for (const int steps : {5, 100}) {
    SCOPED_TRACE(steps);
    test::Draw draw(1727);
    const test::Result r = test::run(test::chain_with_triad(draw, steps), "irreducible/eigen");
    EXPECT_EQ(r.report().status.code, Code::fold);
    EXPECT_NEAR(r.report().reached, 0.70944, 0.00001);
  }
}

TEST(Folds, AStepGivesUpAfterFortyThousandAttempts) {
  test::Draw draw(1068);
  const test::Result r = test::run(test::three_legs(draw, 100), "irreducible/eigen");
  EXPECT_EQ(r.report().status.code, Code::branch_unknown);
  EXPECT_GE(r.report().counters.rejected, 40000);
}

}  // namespace
}  // namespace assur
