// What a Prepared says, and the same with another time grid.
#include <gtest/gtest.h>

#include <string>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "refusal.hpp"

namespace assur {
namespace {

TEST(Prepared, AnotherGridRunsFromTheSameStart) {
  const Prepared prepared = prepare(sample("four_bar:3"));
  const TimeGrid grid = prepared.time();
  const Prepared half = prepared.with_time({grid.start, grid.end, grid.step / 2});
  EXPECT_EQ(prepared.time().step, grid.step) << "the first one stays";
  const Trajectory coarse = Simulator(prepared).run(), fine = Simulator(half).run();
  ASSERT_EQ(fine.rows(), 2 * coarse.rows() - 1);
  for (std::size_t c = 0; c < coarse.columns().size(); ++c) EXPECT_EQ(fine(0, c), coarse(0, c));
}

TEST(Prepared, AGridThatDoesNotFitIsRefused) {
  const Prepared prepared = prepare(sample("four_bar:3"));
  const TimeGrid grid = prepared.time();
  const auto refused = [&](const TimeGrid& time) { return test::refusal([&] { (void)prepared.with_time(time); }); };
  EXPECT_NE(refused({grid.start + 1, grid.end + 1, grid.step}).find("/time/start"), std::string::npos);
  EXPECT_NE(refused({grid.start, grid.end, -grid.step}).find("/time/step"), std::string::npos);
  EXPECT_NE(refused({grid.start, grid.end, 0.7 * (grid.end - grid.start)}).find("a whole number"), std::string::npos);
}

TEST(Prepared, StructureHasTheGroupsInSolvingOrder) {
  const Prepared prepared = prepare(sample("stewart"), {.strategy = "groups/eigen"});
  const Structure structure = prepared.structure();
  const std::vector<Group> groups = structure.groups();
  ASSERT_FALSE(groups.empty());
  std::int32_t level = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    EXPECT_GE(groups[g].level, level);
    level = groups[g].level;
    EXPECT_LT(groups[g].group_class, structure.classes());
    const Shape shape = structure.shape(static_cast<std::int32_t>(g));
    EXPECT_EQ(shape.n, groups[g].n);
    EXPECT_EQ(shape.n, structure.pattern(groups[g].group_class).n);
  }
  EXPECT_EQ(level + 1, structure.levels());
  EXPECT_EQ(structure.counts().mobility, 6);
}

}  // namespace
}  // namespace assur
