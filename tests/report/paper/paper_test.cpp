// The tables of the paper, and their numbers that the paper prints a second time.
#include "report/paper/paper.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "assur/plan.hpp"
#include "plan/preparation.hpp"

namespace assur::report {
namespace {

std::vector<int> totals(int table) {
  std::vector<int> out;
  for (const PaperCell& cell : cells_of_table(table)) out.push_back(cell.total());
  return out;
}

TEST(PaperCells, TotalSizesEqualThePapers) {
  EXPECT_EQ(totals(2), (std::vector<int>{102, 204, 384, 744, 1464, 2184, 2904, 4344}));
  EXPECT_EQ(totals(3), (std::vector<int>{102, 204, 384, 744, 252, 504, 984, 1944, 342, 684, 1344, 2664}));
  const std::vector<PaperCell> fourth = cells_of_table(4), fifth = cells_of_table(5);
  ASSERT_EQ(fourth.size(), 8u);
  for (const PaperCell& cell : fourth) EXPECT_EQ(3 * cell.terminal, 2 * cell.n);
  EXPECT_EQ(fourth.back().n, 144);
  ASSERT_EQ(fifth.size(), 13u);
  EXPECT_EQ(fifth[5].n, 108);
  EXPECT_EQ(fifth[5].terminal, 72);
  for (std::size_t i = 6; i < fifth.size(); ++i) EXPECT_EQ(fifth[i].terminal, fifth[i].n);
  EXPECT_THROW((void)cells_of_table(1), Error);
}

TEST(PaperCells, ScenesHaveTheGroupsOfTheirCell) {
  std::vector<PaperCell> cells = cells_of_table(2);
  for (const int table : {3, 4}) {
    for (const PaperCell& cell : cells_of_table(table)) cells.push_back(cell);
  }
  for (const PaperCell& cell : cells) {
    SCOPED_TRACE(cell.scene());
    const Prepared prepared = prepare(sample(cell.scene()), {.strategy = "groups/eigen"});
    const GroupedSystem& s = *preparation(prepared).structure;
    ASSERT_EQ(s.groups.size(), static_cast<std::size_t>(cell.groups) + 1);
    int total = 0;
    for (const SolvedGroup& group : s.groups) {
      EXPECT_EQ(group.of, group.level == 0 ? cell.terminal : cell.n);
      total += s.classes[static_cast<std::size_t>(group.group_class)].n;
    }
    EXPECT_EQ(total, cell.total());
  }
}

double speed_up(const PaperCell& cell, std::string_view version) {
  return best(paper_times(2), cell, "GMA27") / best(paper_times(2), cell, version);
}

// The points of the figure were read to two digits, so the tolerance is half of the last one.
TEST(PaperFigures, Figure2FollowsFromTable2) {
  const std::vector<double> dense = {7.9, 8.0, 5.6, 3.0, 1.14, 0.48, 0.29, 0.17};
  const std::vector<double> sparse = {5.7, 6.4, 4.7, 4.4, 3.9, 3.9, 3.9, 3.8};
  const std::vector<PaperCell> cells = cells_of_table(2);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    EXPECT_NEAR(speed_up(cells[i], "GEOMP+MKL"), dense[i], dense[i] < 2 ? 0.005 : 0.05);
    EXPECT_NEAR(speed_up(cells[i], "GEOMP+MA27"), sparse[i], 0.05);
  }
}

TEST(PaperFigures, TheLastColumnsOfTable5AreRatiosOfItsTimes) {
  const std::vector<double> wide_over_narrow = {0.60, 0.62, 0.48, 0.44, 0.51, 0.61, 1.03,
                                                0.90, 0.73, 0.94, 1.08, 1.24, 1.29};
  const std::vector<double> over_gpu = {0.02, 0.02, 0.03, 0.06, 0.07, 0.08, 0.20, 0.30, 0.36, 0.51, 0.82, 1.03, 1.12};
  const std::vector<PaperCell> cells = cells_of_table(5);
  const double rounding = 0.005 * (1 + 1e-9);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double wide = best(paper_times(5), cells[i], "GEOMP+MKL", just({6, 2}));
    EXPECT_NEAR(wide / best(paper_times(5), cells[i], "GEOMP+MKL", just({2, 6})), wide_over_narrow[i], rounding);
    EXPECT_NEAR(wide / best(paper_times(5), cells[i], "GEMAGMA"), over_gpu[i], rounding);
  }
}

// The paper rounds seconds to 0.01 and joules to 0.1.
TEST(PaperFigures, EnergyIsPowerTimesTime) {
  ASSERT_EQ(paper_times(4).size(), 32u);
  for (const PaperTiming& t : paper_times(4)) {
    const double watts = paper_machine(t.machine).watts;
    EXPECT_NEAR(t.joules, watts * t.seconds * t.cell.steps, 0.05 + 0.005 * watts) << t.machine << " " << t.cell.n;
  }
}

TEST(PaperFigures, TheSequentialColumnsOfTable3AreOneThread) {
  const PaperCell last = cells_of_table(3).back();
  EXPECT_DOUBLE_EQ(best(paper_times(3), last, "GEOMP+MKL", just({1, 1})) * last.steps, 78.89);
  EXPECT_DOUBLE_EQ(best(paper_times(3), last, "GEOMP+MA27", just({4, 1})) * last.steps, 19.38);
  EXPECT_EQ(fastest(paper_times(3), last, "GEOMP+MA27", just({3, 1})), nullptr);
  EXPECT_THROW((void)paper_machine("i7"), Error);
}

}  // namespace
}  // namespace assur::report
