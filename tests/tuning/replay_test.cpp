// Replays a tuning run from its samples.
#include "tuning/replay.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace assur::tuning {
namespace {

// eigen takes n^2 ns and lapack 20 n ns, so they cross at n = 20. Each was called for a second.
void add(std::vector<Sample>& samples, std::int32_t n) {
  for (const Kernel kernel : {Kernel::factor, Kernel::solve}) {
    for (const char* strategy : {"groups/eigen", "groups/lapack"}) {
      Sample s;
      s.kernel = kernel;
      s.shape = {.n = n, .nnz = n * n, .fill = std::int64_t{n} * n, .operations = std::int64_t{n} * n * n / 3};
      s.shape.pattern = static_cast<std::uint64_t>(n);
      s.strategy = parse_strategy(strategy);
      s.seconds = (s.strategy.solver.backend == "eigen" ? n * n : 20 * n) * (kernel == Kernel::factor ? 1e-9 : 1e-10);
      s.spread = s.seconds / 100;
      s.repetitions = static_cast<std::int64_t>(1 / s.seconds);
      samples.push_back(s);
    }
  }
}

std::vector<Sample> run_of(const std::vector<std::int32_t>& sizes) {
  std::vector<Sample> samples;
  for (const std::int32_t n : sizes) add(samples, n);
  return samples;
}

TEST(Replay, GroupsSamplesOfOneShapeIntoCells) {
  const std::vector<CellResult> cells = cells_of(run_of({128, 4, 22}));
  ASSERT_EQ(cells.size(), 3u);
  for (const CellResult& c : cells) EXPECT_EQ(c.results.size(), 4u);
  EXPECT_EQ(cells[0].cell.n, 128);
  EXPECT_FALSE(cells[0].cell.held_out);
  EXPECT_TRUE(cells[2].cell.held_out);
}

TEST(Replay, PacksAndMatricesOfOneShapeAreDifferentCells) {
  std::vector<Sample> samples = run_of({60});
  samples.push_back(samples[0]);
  samples.back().kernel = Kernel::pack;
  const std::vector<CellResult> cells = cells_of(samples);
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[1].cell.kind, Cell::Kind::packs);
  samples.back().strategy.run.together = true;
  EXPECT_EQ(cells_of(samples)[1].cell.kind, Cell::Kind::together);
}

TEST(Replay, RegretFallsWithMoreSamples) {
  // 22 is held out. A model with only size 128 always chooses lapack, which is better by a tenth at 22.
  const std::vector<CellResult> cells = cells_of(run_of({4, 8, 12, 22, 32, 64, 128}));
  const std::vector<Stage> stages = replay(cells, 3);
  ASSERT_EQ(stages.size(), 3u);
  for (std::size_t i = 0; i < stages.size(); ++i) {
    EXPECT_NEAR(stages[i].share, static_cast<double>(i + 1) / 3, 1e-3);  // each cell took the same time
    EXPECT_EQ(stages[i].cells, 2 * (i + 1));
    EXPECT_EQ(stages[i].samples, 8 * (i + 1));
    EXPECT_GT(stages[i].regret.questions, 0u);
  }
  EXPECT_LE(stages[2].regret.mean, stages[0].regret.mean);
  EXPECT_EQ(stages[2].regret.max, 0);
}

TEST(Replay, HoldsOutTheSameCellsAsTheTuner) {
  std::size_t held_out = 0;
  for (const Cell& c : general_cells({})) {
    if (c.kind != Cell::Kind::matrix && c.kind != Cell::Kind::packs) continue;
    const Kernel kernel = c.kind == Cell::Kind::packs ? Kernel::pack : Kernel::factor;
    EXPECT_EQ(is_held_out(kernel, {.n = c.n, .groups = c.groups}), c.held_out) << to_string(c);
    held_out += c.held_out ? 1 : 0;
  }
  EXPECT_GE(held_out, 10u);
}

}  // namespace
}  // namespace assur::tuning
