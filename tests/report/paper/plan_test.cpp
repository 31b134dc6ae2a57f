// The strategies that replace those of the paper, and the selection that fits into a time budget.
#include "report/paper/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur::report {
namespace {

std::set<std::string> texts(const std::vector<Split>& splits) {
  std::set<std::string> out;
  for (const Split& s : splits) out.insert(text_of(s));
  return out;
}

TEST(PaperPlan, SplitsAreLimitedByThreadsAndGroups) {
  EXPECT_EQ(texts(splits(1, 6)), (std::set<std::string>{"1x1"}));
  EXPECT_EQ(texts(splits(2, 6)), (std::set<std::string>{"1x1", "1x2", "2x1"}));
  EXPECT_EQ(texts(splits(4, 6)), (std::set<std::string>{"1x1", "1x2", "1x3", "1x4", "2x1", "2x2", "3x1", "4x1"}));
  EXPECT_EQ(texts(splits(4, 1)), (std::set<std::string>{"1x1", "1x2", "1x3", "1x4"}));
  EXPECT_TRUE(texts(splits(12, 6)).contains("6x2"));
  EXPECT_TRUE(texts(splits(12, 6)).contains("2x6"));
}

TEST(PaperPlan, Table5HasThePapersSplitsOnTwelveCores) {
  const auto both = [](int threads) {
    const auto [wide, narrow] = wide_and_narrow(threads);
    return texts({wide, narrow});
  };
  EXPECT_EQ(both(12), (std::set<std::string>{"6x2", "2x6"}));
  EXPECT_EQ(both(4), (std::set<std::string>{"4x1", "1x4"}));
  EXPECT_EQ(both(2), (std::set<std::string>{"2x1", "1x2"}));
  EXPECT_EQ(both(1), (std::set<std::string>{"1x1"}));
}

TEST(PaperPlan, StandInsRunAndResembleThePapersSolvers) {
  const StandIns with = stand_ins();
  const auto row = [](const std::string& id) { return find_backend(backends(), id); };
  for (const std::string& id : {with.dense, with.threaded, with.sparse}) {
    if (!id.empty()) {
      EXPECT_EQ(row(id).why_not({}, {}), "");
    }
  }
  EXPECT_TRUE(row(with.dense).dense);
  EXPECT_FALSE(row(with.sparse).dense);
  EXPECT_TRUE(row(with.sparse).keeps_pivots);
  for (const Backend& b : backends()) {
    if (!b.why_not({}, {}).empty()) continue;
    if (b.id == "lapack") {
      EXPECT_EQ(with.dense, b.id);
    }
    if (b.id == "team") {
      EXPECT_EQ(with.threaded, b.id);
    }
    if (b.id == "klu") {
      EXPECT_EQ(with.sparse, b.id);
    }
  }
  EXPECT_EQ(ours(), (std::vector<std::string>{"auto", "groups/lanes:8", "irreducible/lanes:8"}));
}

TEST(PaperPlan, EachMechanismHasOneContestWithBothReadings) {
  const StandIns with{"lapack", "team", "klu", false};
  const std::vector<PaperContest> all = contests(4, false, with);
  std::size_t cells = 0;
  for (const int table : {2, 3, 4, 5}) cells += cells_of_table(table).size();
  EXPECT_EQ(all.size(), cells - 4);  // four cells with six groups are in both tables 2 and 3
  for (const PaperContest& contest : all) {
    std::set<std::string> seen;
    for (const Entrant& e : contest.entrants) {
      EXPECT_TRUE(seen.insert(e.strategy).second) << e.strategy;
      const Strategy parsed = parse_strategy(e.strategy == "auto" ? "groups/eigen" : e.strategy);
      EXPECT_EQ(parsed.run.threads, e.split.p) << e.strategy;
      EXPECT_EQ(parsed.solver.threads, e.split.q) << e.strategy;
      EXPECT_EQ(parsed.solver.separate, e.reading == Reading::separate) << e.strategy;
      EXPECT_LE(e.split.p * e.split.q, 4);
      if (!e.version.starts_with("G")) continue;
      const bool other = std::any_of(contest.entrants.begin(), contest.entrants.end(), [&](const Entrant& o) {
        return o.version == e.version && o.split == e.split && o.reading != e.reading &&
               parse_strategy(o.strategy).solver.backend == parsed.solver.backend;
      });
      EXPECT_EQ(other, reads_twice(contest.cell)) << e.strategy;
    }
    EXPECT_TRUE(seen.contains("auto"));
  }
  const auto strategies = [&](std::size_t i) {
    std::set<std::string> out;
    for (const Entrant& e : all[i].entrants) out.insert(e.strategy);
    return out;
  };
  for (const char* text :
       {"global/lapack", "global/lapack 1x4", "global/klu+separate", "groups/lapack 3x1", "groups/team 2x2",
        "groups/team 1x3", "global/team 1x2", "groups/lapack+separate 1x4", "groups/klu 4x1"}) {
    EXPECT_TRUE(strategies(0).contains(text)) << text;
  }
  EXPECT_FALSE(strategies(0).contains("groups/team 3x2"));
  EXPECT_LT(contests(4, true, with).size(), all.size());
}

TEST(PaperPlan, AGpuTakesPartInTables4And5) {
  const StandIns with{"lapack", "team", "klu", false, {"cusolver", "magma"}};
  for (const PaperContest& contest : contests(4, false, with)) {
    std::set<std::string> on_device;
    for (const Entrant& e : contest.entrants) {
      if (e.version != kGpu) continue;
      on_device.insert(e.strategy);
      EXPECT_EQ(e.split, Split{});
    }
    std::set<std::string> expected;
    if (contest.cell.iterations > 1) expected = {"groups/cusolver", "groups/cusolver:8", "groups/magma"};
    if (contest.cell.iterations > 1 && reads_twice(contest.cell)) {
      expected.insert({"groups/cusolver+separate", "groups/cusolver:8+separate", "groups/magma+separate"});
    }
    EXPECT_EQ(on_device, expected) << contest.cell.n;
  }
  const Entrant gpu{std::string(kGpu), {}, Reading::shared, "groups/cusolver"};
  EXPECT_LT(PaperCosts().step(cells_of_table(5).back(), gpu), 60);
}

TEST(PaperPlan, PlansTheCheapestFirstWithinTheTime) {
  const std::vector<PaperContest> all = contests(2, false, {"lapack", "", "klu", false});
  const PaperCosts costs;
  for (const double seconds : {0.0, 1.0, 30.0, 1e9}) {
    const std::vector<std::vector<bool>> chosen = affordable(all, costs, seconds);
    double sum = 0, dearest = 0, cheapest_left_out = HUGE_VAL;
    for (std::size_t c = 0; c < all.size(); ++c) {
      for (std::size_t e = 0; e < all[c].entrants.size(); ++e) {
        const double cost = costs.least(all[c].cell, all[c].entrants[e]);
        if (chosen[c][e]) {
          sum += cost;
          dearest = std::max(dearest, cost);
        } else {
          cheapest_left_out = std::min(cheapest_left_out, cost);
        }
      }
    }
    EXPECT_LE(sum, seconds);
    EXPECT_LE(dearest, cheapest_left_out);
    EXPECT_EQ(seconds == 0, dearest == 0);
    EXPECT_EQ(seconds == 1e9, cheapest_left_out == HUGE_VAL);
  }
}

TEST(PaperPlan, TimesCorrectExpectedCosts) {
  const PaperCell small = cells_of_table(2)[0], large = cells_of_table(2)[7];
  const Entrant dense{"GMKL", {}, Reading::shared, "global/lapack"};
  PaperCosts costs;
  // By operation counts, dense work grows nearly with n^3.
  const double before = costs.step(large, dense) / costs.step(small, dense);
  EXPECT_GT(before, std::pow(4344.0 / 102, 2));
  EXPECT_LT(before, std::pow(4344.0 / 102, 3));
  costs.learn(small, dense, 2 * costs.step(small, dense));
  EXPECT_DOUBLE_EQ(costs.step(large, dense) / costs.step(small, dense), before);
  EXPECT_DOUBLE_EQ(costs.step(large, dense), 2 * PaperCosts().step(large, dense));
  const Entrant sparse{"GMA27", {}, Reading::shared, "global/klu"};
  EXPECT_DOUBLE_EQ(costs.step(large, sparse), PaperCosts().step(large, sparse));  // sparse work is learned separately
}

}  // namespace
}  // namespace assur::report
