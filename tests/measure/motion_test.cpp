// Counts the work of a call of `pack`, `step` and `evaluate`.
#include "measure/motion.hpp"

#include <gtest/gtest.h>

#include "structure/grouped_system.hpp"

namespace assur::measure {
namespace {

Prepared prepared(const std::string& scene, const std::string& strategy) { return prepare(sample(scene), {strategy}); }

class Packs : public testing::TestWithParam<const char*> {};

TEST_P(Packs, ACallIsOneStepOfOnePack) {
  const Prepared p = prepared("rings:legs=10,n=20,terminal=12", GetParam());
  const std::int32_t legs = p.structure().groups().back().group_class;
  PackStep packs(p, legs);
  ASSERT_EQ(packs.packs(), static_cast<std::size_t>((10 + packs.lanes() - 1) / packs.lanes()));
  const Counters before = packs.counters();
  ASSERT_TRUE(packs.run(static_cast<int>(3 * packs.packs())));
  const Counters after = packs.counters();
  EXPECT_EQ(after.group_solutions - before.group_solutions, 3 * 10);  // every group of the class in turn
  EXPECT_EQ(after.newton_iterations - before.newton_iterations, 3 * 10);
  EXPECT_EQ(after.branch_checks, before.branch_checks);
  EXPECT_LE(packs.error().position, 1e-12);  // the solver takes such residuals for rounding
}

INSTANTIATE_TEST_SUITE_P(, Packs,
                         testing::Values("groups/eigen", "groups/lanes", "groups/lanes:8", "groups/lanes:4+once",
                                         "groups/eigen+reuse=run+once", "groups/eigen+reuse=step"),
                         [](const auto& call) {
                           std::string text = call.param;
                           for (char& c : text) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                           return text;
                         });

TEST(PackStep, ACallOfAllLevelsTogetherSolvesEveryPack) {
  for (const int lanes : {4, 8, 16}) {
    PackStep step(prepared("four_bar:20", "irreducible/lanes:" + std::to_string(lanes) + "+together"), 0);
    EXPECT_EQ(step.lanes(), lanes);
    EXPECT_EQ(step.packs(), static_cast<std::size_t>((20 + lanes - 1) / lanes));
    const Counters before = step.counters();
    ASSERT_TRUE(step.run(3));
    const Counters after = step.counters();
    EXPECT_EQ(after.group_solutions - before.group_solutions, 3 * 20);
    EXPECT_EQ(after.newton_iterations - before.newton_iterations, 3 * 20);
    EXPECT_EQ(after.branch_checks, before.branch_checks);
    EXPECT_LE(step.error().position, 1e-12);
  }
}

TEST(PackStep, CountsFactorisationsOfThePolicy) {
  for (const auto& [strategy, factorizations] :
       {std::pair("groups/eigen", 2), {"groups/eigen+once", 1}, {"groups/eigen+separate", 3}}) {
    const Prepared p = prepared("stewart", strategy);
    PackStep packs(p, p.structure().groups().back().group_class);
    const Counters before = packs.counters();
    ASSERT_TRUE(packs.run(6));
    EXPECT_EQ(packs.counters().factorizations - before.factorizations, 6 * factorizations) << strategy;
  }
}

TEST(StepWorkload, RepeatsTheGrid) {
  StepWorkload steps(prepared("andrews", "groups/eigen"));  // 72 steps
  for (const int calls : {5, 100, 1, 72}) {
    steps.get_ready(calls);
    EXPECT_TRUE(steps.run(calls));
  }
  EXPECT_TRUE(steps.report().status.ok());
}

TEST(Evaluation, RunsOverAllWidths) {
  const auto structure = std::make_shared<const GroupedSystem>(group_equations(sample("stewart")));
  for (std::int32_t c = 0; c < static_cast<std::int32_t>(structure->classes.size()); ++c) {
    for (const int lanes : {1, 8, 16}) EXPECT_TRUE(evaluation(structure, c, lanes)->run(2));
  }
}

}  // namespace
}  // namespace assur::measure
