// Winners of artificial cells.
#include "tuning/tuning_report.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace assur::output {
namespace {

using tuning::Cell;
using tuning::CellResult;

tuning::Result timed(Kernel kernel, std::int32_t n, const std::string& strategy, double seconds) {
  Sample s;
  s.kernel = kernel;
  s.shape.n = n;
  s.strategy = parse_strategy(strategy);
  s.seconds = seconds;
  return tuning::Result(std::move(s));
}

CellResult matrix(std::int32_t n, double lapack) {
  CellResult out;
  out.cell.family = "full";
  out.cell.n = n;
  for (const auto& [strategy, factor] :
       {std::pair("groups/lanes:8", 8e-6), {"groups/lanes", 2e-6}, {"groups/lapack", lapack}}) {
    out.results.push_back(timed(Kernel::factor, n, strategy, factor));
    out.results.push_back(timed(Kernel::solve, n, strategy, factor / 10));
  }
  // Solutions are slow, and a step has three of them.
  out.results.push_back(timed(Kernel::factor, n, "groups/eigen", 0.1e-6));
  out.results.push_back(timed(Kernel::solve, n, "groups/eigen", 1e-6));
  return out;
}

CellResult packs(std::int32_t groups, const std::string& fastest) {
  CellResult out;
  out.cell.kind = Cell::Kind::packs;
  out.cell.family = "dyads";
  out.cell.groups = groups;
  out.results.push_back(timed(Kernel::pack, 2, fastest, 1e-6));
  out.results.push_back(timed(Kernel::pack, 2, "groups/eigen", 1.1e-6));
  return out;
}

TEST(TuningReport, CountsAFactorisationAndThreeSolutionsForOneMatrix) {
  const std::vector<CellResult> cells = {matrix(10, 3e-6)};
  const std::vector<Winner> all = winners(cells);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].strategy, "lanes");
  EXPECT_DOUBLE_EQ(all[0].seconds, 2.6e-6);
  EXPECT_TRUE(all[1].side_by_side);
  EXPECT_EQ(all[1].strategy, "lanes:8");
  EXPECT_DOUBLE_EQ(all[1].seconds, 1.3e-6);
}

TEST(TuningReport, ShowsCrossovers) {
  const std::vector<CellResult> cells = {
      matrix(10, 3e-6),      matrix(20, 3e-6), matrix(40, 1.1e-6), matrix(80, 1.1e-6), packs(10, "groups/lanes:4"),
      packs(1, "groups/klu")};
  TuningSummary summary;
  summary.profile = "quick";
  summary.grade = "good";
  summary.cells = cells;
  summary.figures.planned = 8;
  summary.figures.measured = 6;
  summary.figures.cut_short = 2;
  std::ostringstream out;
  Page page(out);
  print(page, summary);
  for (const char* line : {"full: lanes up to 20, lapack from 40\n", "full, side by side: lanes:8 from 10 to 80\n",
                           "dyads, n = 2, steps by groups: klu at 1, lanes:4 from 10\n", "good\n", "no database\n"}) {
    EXPECT_NE(out.str().find(line), std::string::npos) << line << out.str();
  }
  const Json json = to_json(summary);
  EXPECT_EQ(json["coverage"], 0.5);
  EXPECT_TRUE(json["tuning_run"].is_null());
  EXPECT_TRUE(json["held_out_regret"]["median"].is_null());
  EXPECT_EQ(json["winners"].size(), 10u);
}

}  // namespace
}  // namespace assur::output
