#include "check/matrices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace assur::check {
namespace {

Result result_of(const std::string& name, const Parameters& set, std::vector<Verdict> expected, double accuracy) {
  Case c;
  c.name = c.matrix = name;
  c.set = set;
  c.accuracy = accuracy;
  c.expected = {std::move(expected), ""};
  return run_matrix(c, [] { return false; });
}

TEST(Matrices, AllSolversSolveWellConditionedMatrices) {
  const Result r = result_of("random", {{"n", 30}}, {"pass"}, 1e-13);
  EXPECT_TRUE(r.passed()) << (r.unexpected.empty() ? "" : r.unexpected[0].strategy);
  EXPECT_GE(r.runs, 4 * 2);  // eigen and lanes at least
  EXPECT_LE(*r.backward_error, 1e-14);
  EXPECT_LE(*r.condition, 10);
}

// Growth of 2^59 spoils a solution with partial pivoting. It is reported, and refinement repairs it.
TEST(Matrices, ReportsPivotGrowth) {
  const Result r = result_of("wilkinson", {{"n", 60}}, {"pass"}, 1e-6);
  const auto eigen = std::find_if(r.unexpected.begin(), r.unexpected.end(),
                                  [](const check::Run& run) { return run.strategy == "eigen"; });
  ASSERT_NE(eigen, r.unexpected.end());
  EXPECT_EQ(eigen->verdict, "inaccurate");
  EXPECT_GT(*eigen->forward_error, 1e-3);
  for (const check::Run& run : r.unexpected) EXPECT_EQ(run.strategy.find("+refine"), std::string::npos) << run.strategy;
}

TEST(Matrices, ReportsSingularMatrices) {
  EXPECT_TRUE(result_of("zero_row", {}, {"singular"}, 1e-6).passed());
  EXPECT_FALSE(result_of("zero_row", {}, {"pass"}, 1e-6).passed());
  EXPECT_TRUE(result_of("nan", {}, {"not_finite"}, 1e-6).passed());
}

TEST(Matrices, HaveTheirDefinedEntries) {
  const Dense wilkinson = matrix("wilkinson", {{"n", 4}});
  EXPECT_EQ(wilkinson[3], (std::vector<double>{-1, -1, -1, 1}));
  EXPECT_EQ(wilkinson[1], (std::vector<double>{-1, 1, 0, 1}));
  EXPECT_EQ(matrix("hilbert", {{"n", 3}})[2][1], 0.25);
  const Dense repeated = matrix("repeated_row", {{"n", 5}});
  EXPECT_EQ(repeated[4], repeated[0]);
  EXPECT_THROW((void)matrix("bogus", {}), Error);
}

}  // namespace
}  // namespace assur::check
