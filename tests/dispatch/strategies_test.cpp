// The space of strategies: every listed strategy is meaningful, runs, and is listed once.
#include "dispatch/strategies.hpp"

#include <gtest/gtest.h>

#include <set>

#include "backends/backends.hpp"

namespace assur {
namespace {

std::string on_two_threads_at_most(const Shape&, ThreadBudget budget) {
  return budget.threads > 2 ? "two threads at most" : "";
}
std::string too_large(const Shape& shape, ThreadBudget) { return shape.n > 100 ? "too large" : ""; }

// Artificial backends: the list depends only on their properties.
const Backend kPlain = {.id = "plain", .why_not = too_large, .make = nullptr, .version = nullptr, .licence = ""};
const Backend kRich = {.id = "rich",
                       .why_not = on_two_threads_at_most,
                       .make = nullptr,
                       .version = nullptr,
                       .licence = "",
                       .single = true,
                       .threads = true};
const Backend kInTurns = {
    .id = "in_turns", .why_not = too_large, .make = nullptr, .version = nullptr, .licence = "", .takes_turns = true};

std::vector<std::string> texts(const StrategySpace& space, const StrategyFilter& filter) {
  std::vector<std::string> all;
  for (const Strategy& s : strategies(space, filter)) all.push_back(to_string(s));
  return all;
}

StrategySpace large() {
  StrategySpace space;
  space.formulations = {Formulation::irreducible, Formulation::global};
  space.packs = space.threads = powers_of_two(4);
  space.lanes = powers_of_two(kMostLanes);
  space.policies = {{}, {.single = true}, {.refine = true}, {.reuse = Reuse::run}, {.once = true}, {.separate = true}};
  space.predictors.assign(kTypicalPredictors.begin(), kTypicalPredictors.end());
  return space;
}

TEST(StrategySpace, FollowsFromThePropertiesOfARow) {
  const std::array table = {kPlain, kRich, kInTurns};
  StrategySpace space;
  space.formulations = {Formulation::irreducible, Formulation::global};
  space.packs = {1, 2};
  space.lanes = {1, 8};
  space.threads = {1, 2, 4};
  space.policies = {{}, {.single = true}};
  const std::vector<std::string> plain = {
      "irreducible/plain",     "irreducible/plain 1x2", "irreducible/plain 1x4", "irreducible/plain:8",
      "irreducible/plain 2x1", "irreducible/plain 2x2", "irreducible/plain 2x4", "irreducible/plain:8 2x1",
      "global/plain",          "global/plain 1x2",      "global/plain 1x4",
  };
  EXPECT_EQ(texts(space, {.table = std::span(table).first(1)}), plain);
  const std::vector<std::string> rich = {
      "irreducible/rich",     "irreducible/rich+float",     "irreducible/rich 1x2",   "irreducible/rich+float 1x2",
      "irreducible/rich:8",   "irreducible/rich:8+float",   "irreducible/rich 2x1",   "irreducible/rich+float 2x1",
      "irreducible/rich 2x2", "irreducible/rich+float 2x2", "irreducible/rich:8 2x1", "irreducible/rich:8+float 2x1",
      "global/rich",          "global/rich+float",          "global/rich 1x2",        "global/rich+float 1x2",
  };
  EXPECT_EQ(texts(space, {.table = std::span(table).subspan(1, 1)}), rich);
  const std::vector<std::string> in_turns = {
      "irreducible/in_turns", "irreducible/in_turns 1x2", "irreducible/in_turns 1x4", "irreducible/in_turns:8",
      "global/in_turns",      "global/in_turns 1x2",      "global/in_turns 1x4",
  };
  EXPECT_EQ(texts(space, {.table = std::span(table).last(1)}), in_turns);
}

TEST(StrategySpace, IsFilteredByShapeNameAndPredicate) {
  const std::array table = {kPlain, kRich, kInTurns};
  const std::vector<std::string> without = {"rich"};
  const auto listed = [&](const StrategyFilter& filter) { return texts({}, filter); };
  EXPECT_EQ(listed({.table = table, .shape = {.n = 101}}), std::vector<std::string>{"groups/rich"});
  EXPECT_EQ(listed({.table = table, .without = without}),
            (std::vector<std::string>{"groups/plain", "groups/in_turns"}));
  EXPECT_EQ(listed({.table = table, .wanted = [](const Backend& b, const Strategy&) { return b.takes_turns; }}),
            std::vector<std::string>{"groups/in_turns"});
}

TEST(StrategySpace, HoldsEveryStrategyOnceWithItsShortestText) {
  const std::vector<Strategy> all = strategies(large(), {.table = backends(), .shape = {.n = 20, .nnz = 60}});
  ASSERT_GT(all.size(), 1000u);
  std::set<std::string> seen;
  for (const Strategy& s : all) {
    EXPECT_EQ(parse_strategy(to_string(s)), s);
    EXPECT_TRUE(seen.insert(to_string(s)).second) << to_string(s);
    const Backend& backend = find_backend(backends(), s.solver.backend);
    EXPECT_EQ(backend.why_not({.n = 20, .nnz = 60}, ThreadBudget{s.solver.threads}), "") << to_string(s);
    EXPECT_TRUE(backend.single || !s.solver.single) << to_string(s);
  }
}

TEST(StrategySpace, ListsPowersOfTwo) {
  EXPECT_EQ(powers_of_two(1), std::vector<std::int32_t>{1});
  EXPECT_EQ(powers_of_two(3), (std::vector<std::int32_t>{1, 2}));
  EXPECT_EQ(powers_of_two(16), (std::vector<std::int32_t>{1, 2, 4, 8, 16}));
  EXPECT_EQ(powers_of_two(std::numeric_limits<std::int32_t>::max()).back(), 1 << 30);
}

}  // namespace
}  // namespace assur
