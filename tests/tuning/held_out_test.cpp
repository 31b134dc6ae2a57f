// Regret of choices, and proposals of further cells, for artificial samples.
#include "tuning/held_out.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tuning/refinement.hpp"
#include "tuning/sample_csv.hpp"

namespace assur::tuning {
namespace {

Sample sample_of(Kernel kernel, std::int32_t n, const std::string& strategy, double seconds) {
  Sample s;
  s.kernel = kernel;
  s.shape = {.n = n, .nnz = n * n, .fill = std::int64_t{n} * n, .operations = std::int64_t{n} * n * n / 3};
  s.shape.pattern = static_cast<std::uint64_t>(n);
  s.strategy = parse_strategy(strategy);
  s.seconds = seconds;
  s.spread = seconds / 100;
  s.repetitions = 100;
  return s;
}

Cell full(std::int32_t n) {
  Cell c;
  c.family = "full";
  c.n = c.per_row = n;
  c.at = full;
  return c;
}

// eigen takes n^2 ns and lapack 20 n ns, so they are equal at n = 20.
CellResult cell(std::int32_t n, bool held_out, double eigen = 1) {
  CellResult out;
  out.cell = full(n);
  out.cell.held_out = held_out;
  for (const auto& [kernel, share] : {std::pair(Kernel::factor, 1.0), std::pair(Kernel::solve, 0.1)}) {
    out.results.emplace_back(sample_of(kernel, n, "groups/eigen", eigen * share * n * n * 1e-9));
    out.results.emplace_back(sample_of(kernel, n, "groups/lapack", share * 20 * n * 1e-9));
  }
  return out;
}

std::vector<CellResult> grid() {
  std::vector<CellResult> cells;
  for (const std::int32_t n : {4, 8, 12, 32, 64, 128}) cells.push_back(cell(n, false));
  return cells;
}

TEST(Regret, IsEmptyWithoutHeldOutCells) { EXPECT_EQ(regret(model_of(grid()), grid()).questions, 0u); }

TEST(Regret, IsTheCostOfAWrongChoice) {
  std::vector<CellResult> cells = grid();
  cells.push_back(cell(10, true));
  cells.push_back(cell(50, true));
  const Regret right = regret(model_of(cells), cells);
  EXPECT_GE(right.questions, 2u);
  EXPECT_EQ(right.max, 0);
  // eigen takes eight times longer than expected in a held-out cell, but the model still chooses eigen.
  cells.push_back(cell(11, true, 8));
  const Regret wrong = regret(model_of(cells), cells);
  EXPECT_NEAR(wrong.max, 8.0 * 11 / 20 - 1, 1e-12);
  EXPECT_EQ(wrong.median, 0);
}

TEST(Regret, IgnoresUncertainTimes) {
  std::vector<CellResult> cells = grid();
  cells.push_back(cell(11, true, 8));
  for (Result& r : cells.back().results) {
    if (r.sample.strategy.solver.backend == "eigen") r.sample.spread = r.sample.seconds;
  }
  EXPECT_EQ(regret(model_of(cells), cells).questions, 0u);  // a single candidate leaves no choice
}

TEST(Refinement, ProposesCellsAtTheCrossover) {
  const std::vector<CellResult> cells = grid();
  const std::vector<Cell> next = propose(model_of(cells), cells, 2);
  ASSERT_FALSE(next.empty());
  EXPECT_EQ(next[0].n, 20);  // between 12 and 32
  EXPECT_LE(next.size(), 2u);
}

TEST(Refinement, EndsAtCloseNeighbours) {
  const std::vector<CellResult> cells = {cell(20, false), cell(21, false), cell(22, false)};
  EXPECT_TRUE(propose(model_of(cells), cells, 5).empty());
}

TEST(SampleCsv, HasALineForEachSample) {
  Sample s = sample_of(Kernel::factor, 3, "groups/lanes:8", 0.25);
  s.forward_error = std::nan("");
  s.slowness = 1.5;
  std::ostringstream out;
  write_csv(out, std::vector{s});
  EXPECT_EQ(out.str(),
            "kernel,n,nnz,fill,operations,depth,terms,pattern,one_program,groups,strategy,seconds,spread,repetitions,"
            "backward_error,forward_error,raw_seconds,slowness\n"
            "factor,3,9,9,9,0,0,3,0,1,groups/lanes:8,0.25,0.0025000000000000001,100,0,,0.375,1.5\n");
}

}  // namespace
}  // namespace assur::tuning
