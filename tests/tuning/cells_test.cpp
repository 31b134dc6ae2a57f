#include "tuning/cells.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tuning/entrants.hpp"
#include "tuning/profile.hpp"

namespace assur::tuning {
namespace {

const Field kField{backends(), ThreadBudget{2}};

TEST(Cells, SizesAreSpacedEvenlyInTheirLogarithm) {
  EXPECT_EQ(spaced(3, 48, 5), (std::vector<std::int32_t>{3, 6, 12, 24, 48}));
  EXPECT_EQ(spaced(3, 4, 5), (std::vector<std::int32_t>{3, 4}));
}

TEST(Cells, HeldOutSizesAreMeasuredNowhereElse) {
  const std::vector<Cell> cells = general_cells({});
  std::set<std::pair<std::string, std::pair<int, int>>> seen, held_out;
  for (const Cell& c : cells) (c.held_out ? held_out : seen).insert({c.family, {c.n, c.groups}});
  EXPECT_GE(held_out.size(), 10u);
  for (const auto& cell : held_out) EXPECT_EQ(seen.count(cell), 0u) << cell.first << ' ' << cell.second.first;
}

// A disturbance of a few seconds must not determine how much threads slow each other down.
TEST(Cells, CrowdsAreSpreadAndHaveTheirOwnNumbersOfGroups) {
  const std::vector<Cell> cells = general_cells({});
  double before = 0;                                 // weight of the cells so far
  std::map<std::string, std::vector<double>> asked;  // by family
  std::set<std::pair<std::int32_t, std::int32_t>> crowds, packs;
  for (const Cell& c : cells) {
    if (c.kind == Cell::Kind::crowd) {
      asked[c.family].push_back(before);
      EXPECT_TRUE(crowds.insert({c.n, c.groups}).second) << to_string(c);
    } else if (c.kind == Cell::Kind::packs) {
      packs.insert({c.n, c.groups});
    }
    before += c.weight;
  }
  EXPECT_EQ(asked.size(), 3u);
  for (const auto& [family, times] : asked) {
    ASSERT_EQ(times.size(), 4u) << family;
    for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i] - times[i - 1], 0.08 * before) << family;
  }
  for (const auto& crowd : crowds) EXPECT_EQ(packs.count(crowd), 0u) << crowd.first << ", " << crowd.second;
}

TEST(Cells, EachCanBeOpenedAndEnteredByItsFirstCandidate) {
  const Extent small{.sizes = 2, .largest = 30, .largest_full = 30, .largest_random = 30, .most_groups = 10};
  for (const Cell& cell : general_cells(small)) {
    const std::unique_ptr<Ground> ground = open(cell, kField);
    ASSERT_FALSE(ground->candidates().empty()) << to_string(cell);
    const std::vector<Entrant> entrants = ground->enter(ground->candidates().front());
    ASSERT_FALSE(entrants.empty()) << to_string(cell);
    for (const Entrant& e : entrants) {
      if (e.packs_of_step == 0) {
        EXPECT_EQ(e.shape, ground->shape());
      }
      EXPECT_TRUE(e.work->run(2)) << to_string(cell);
    }
    if (cell.kind == Cell::Kind::meeting || cell.kind == Cell::Kind::steps || ground->around()) continue;
    EXPECT_EQ(ground->shape().n, cell.n) << to_string(cell);
    EXPECT_EQ(ground->shape().groups, cell.groups) << to_string(cell);
  }
}

TEST(Cells, ASceneHasItsOwnCells) {
  const std::vector<Cell> cells = scene_cells("stewart", sample("stewart"));
  std::set<std::string> texts;
  for (const Cell& c : cells) texts.insert(to_string(c));
  EXPECT_EQ(texts.count("stewart, groups, n = 15"), 1u);
  EXPECT_EQ(texts.count("stewart, groups, n = 15, 6 groups"), 1u);
  EXPECT_EQ(texts.count("stewart, global, n = 102, 1 group"), 1u);
  EXPECT_EQ(texts.count("stewart, irreducible, whole steps"), 1u);
  std::vector<std::string> together;
  for (const Cell& c : scene_cells("four_bar:7", sample("four_bar:7"))) {
    if (c.kind == Cell::Kind::together) together.push_back(to_string(c));
  }
  EXPECT_EQ(together, (std::vector<std::string>{"four_bar:7, groups, n = 2, 7 groups, together",
                                                "four_bar:7, irreducible, n = 2, 7 groups, together"}));
}

TEST(Cells, AFamilyHasCellsOfOtherSizes) {
  for (const Cell& c : general_cells({.sizes = 3, .largest = 100})) {
    if (!c.at) continue;
    const Cell other = c.at(40);
    EXPECT_EQ(other.family, c.family);
    EXPECT_EQ(other.n, 40);
    EXPECT_FALSE(other.held_out);
    EXPECT_EQ(open(other, kField)->shape().n, 40);
  }
}

TEST(Candidates, OneOfEachBackendComesFirst) {
  Shape shape{.n = 200, .nnz = 600};
  const std::vector<Strategy> all = linear_solvers(kField, shape, 16);
  std::set<std::string> backends_seen, texts;
  std::size_t last_new = 0;  // candidates until each backend has come once
  for (const Strategy& s : all) {
    texts.insert(to_string(s));
    if (backends_seen.insert(s.solver.backend).second) last_new = texts.size();
  }
  EXPECT_EQ(last_new, backends_seen.size() + 1);  // lanes come twice: alone, and eight side by side
  EXPECT_EQ(texts.size(), all.size());
  EXPECT_EQ(texts.count("groups/lanes:16"), 1u);
  EXPECT_EQ(texts.count("groups/eigen+float"), 1u);
  for (const Strategy& s : linear_solvers(kField, shape, 1)) EXPECT_EQ(s.solver.lanes, 1);
  shape.n = 20;
  for (const Strategy& s : linear_solvers(kField, shape, 16)) EXPECT_EQ(s.solver.threads, 1);
}

// Backends that solve matrices lane by lane have every width, too, because the rest of a step is in lanes.
TEST(Candidates, PacksHaveEveryWidthThatTheirGroupsFill) {
  std::map<std::string, std::set<int>> widths;
  for (const Strategy& s : pack_strategies(kField, Formulation::groups, {.n = 20, .nnz = 60, .groups = 8}, false)) {
    widths[s.solver.backend].insert(s.solver.lanes);
  }
  EXPECT_EQ(widths["lanes"], (std::set<int>{1, 2, 4, 8}));
  EXPECT_EQ(widths["eigen"], (std::set<int>{1, 2, 4, 8}));
}

// The dispatcher considers +once at every width, and its cost beyond the kernels differs from that of the plain policy.
TEST(Candidates, LaneByLaneSolversHaveEveryWidthWithOnce) {
  std::map<std::string, std::set<int>> widths;
  for (const Strategy& s : pack_strategies(kField, Formulation::groups, {.n = 20, .nnz = 60, .groups = 8}, true)) {
    if (s.solver.once) widths[s.solver.backend].insert(s.solver.lanes);
  }
  EXPECT_EQ(widths["lanes"], (std::set<int>{1, 8}));
  EXPECT_EQ(widths["eigen"], (std::set<int>{1, 2, 4, 8}));
}

TEST(Candidates, LeaveOutFailedTrials) {
  Field field = kField;
  field.why_not = [](const Strategy& s) { return s.solver.backend == "eigen" ? "crashes" : ""; };
  for (const Strategy& s : linear_solvers(field, {.n = 20, .nnz = 60}, 16)) EXPECT_NE(s.solver.backend, "eigen");
}

// The dispatcher does not consider it there.
TEST(Candidates, AGpuIsMeasuredWhereItMayWin) {
  std::vector<Backend> table(backends().begin(), backends().end());
  const auto eigen = std::find_if(table.begin(), table.end(), [](const Backend& b) { return b.id == "eigen"; });
  ASSERT_NE(eigen, table.end());
  eigen->device = true;
  const Field field{table, ThreadBudget{1}};
  const auto count = [](const std::vector<Strategy>& all) {
    return std::count_if(all.begin(), all.end(), [](const Strategy& s) { return s.solver.backend == "eigen"; });
  };
  for (const std::int32_t n : {20, 99, 100, 400}) {
    const Shape shape{.n = n, .nnz = 3 * n, .groups = 8};
    EXPECT_EQ(count(linear_solvers(field, shape, 16)) > 0, n >= 100) << n;
    EXPECT_EQ(count(pack_strategies(field, Formulation::groups, shape, false)) > 0, n >= 100) << n;
  }
}

TEST(Profile, ASmallerBudgetHasFewerCells) {
  std::size_t before = 0;
  for (const double seconds : {2.0, 10.0, 55.0, 300.0}) {
    const std::size_t count = general_cells(profile("quick", seconds).extent).size();
    EXPECT_GT(count, before) << seconds;
    before = count;
  }
  EXPECT_EQ(profile("standard", {}).seconds, profile("quick", profile("standard", {}).seconds).seconds);
  EXPECT_LE(profile("quick", {}).seconds, 60);
  EXPECT_LE(profile("standard", {}).seconds, 300);
  EXPECT_TRUE(profile("patient", {}).until_settled);
  EXPECT_THROW((void)profile("hasty", {}), Error);
}

}  // namespace
}  // namespace assur::tuning
