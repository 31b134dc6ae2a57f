// Plans that variants of a scene share.
#include <gtest/gtest.h>

#include <vector>

#include "assur/assur.hpp"
#include "source_dir.hpp"

namespace assur::test {
namespace {

std::vector<std::string> solvers(const Plan& plan) {
  std::vector<std::string> texts;
  for (const Plan::Choice& choice : plan.choices) texts.push_back(to_string(plan.strategy(choice)));
  return texts;
}

// Even where the variant alone would get another plan: here `like` is forced, and the options say `auto`.
TEST(PrepareLike, TakesThePlanOfTheSameStructure) {
  const PrepareOptions forced{.strategy = "irreducible/eigen+predict=past:3", .budget = ThreadBudget{1}};
  const PrepareOptions options{.budget = ThreadBudget{1}};
  const Prepared like = prepare(sample("slider_crank"), forced);
  const Scene other = sample("slider_crank", {{"crank_length", 0.07}, {"steps", 50}});
  const Prepared variant = prepare_like(like, other, options);
  EXPECT_EQ(solvers(variant.plan()), solvers(like.plan()));
  EXPECT_EQ(variant.time().steps(), 50);
  const Trajectory a = Simulator(variant).run(), b = Simulator(prepare(other, forced)).run();
  ASSERT_EQ(a.values().size(), b.values().size());
  EXPECT_TRUE(std::equal(a.values().begin(), a.values().end(), b.values().begin()));
}

TEST(PrepareLike, ChoosesForAnotherStructure) {
  const PrepareOptions options{.budget = ThreadBudget{1}};
  const Prepared like = prepare(sample("slider_crank"), {.strategy = "groups/eigen", .budget = ThreadBudget{1}});
  const Prepared other = prepare_like(like, sample("four_bar:3"), options);
  EXPECT_EQ(solvers(other.plan()), solvers(prepare(sample("four_bar:3"), options).plan()));
  EXPECT_NE(solvers(other.plan()), solvers(like.plan()));
}

TEST(PrepareLike, RefusesWhatPrepareRefuses) {
  const Prepared like = prepare(sample("slider_crank"), {.budget = ThreadBudget{1}});
  EXPECT_THROW((void)prepare_like(like, sample("slider_crank"), {.budget = ThreadBudget{0}}), Error);
  EXPECT_THROW((void)prepare_like(like, sample("slider_crank"), {.controlled = {"nothing"}}), Error);
  const std::string file = ASSUR_SOURCE_DIR "/scenes/four_bar.json";
  const Prepared four_bar = prepare(read_scene(file, {}), {.budget = ThreadBudget{1}});
  const Scene apart = read_scene(file, {{"crank_length", 9}});
  EXPECT_THROW((void)prepare_like(four_bar, apart), Error);
}

}  // namespace
}  // namespace assur::test
