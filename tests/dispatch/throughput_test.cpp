#include "dispatch/throughput.hpp"

#include <gtest/gtest.h>

#include "assur/machine.hpp"
#include "assur/plan.hpp"

namespace assur {
namespace {

TEST(Throughput, ChunksFillAllLanesAndThreadsTwice) {
  EXPECT_EQ(chunks_for(8, 2, 100'000), 32);
  EXPECT_EQ(chunks_for(1, 1, 100'000), 2);
  EXPECT_EQ(chunks_for(4, 3, 1'200), 24);
}

TEST(Throughput, ChunksAreLongEnoughAndLeaveNoLaneIdle) {
  EXPECT_EQ(chunks_for(8, 2, 1'599), 16);
  EXPECT_EQ(chunks_for(8, 2, 799), 8);
  EXPECT_EQ(chunks_for(8, 2, 399), 7);
  EXPECT_EQ(chunks_for(8, 2, 99), 1);
  EXPECT_EQ(chunks_for(8, 2, 0), 1);
  for (std::int32_t lanes : {1, 2, 4, 8, 16}) {
    for (std::int32_t p : {1, 2, 3, 64}) {
      for (std::int64_t steps = 0; steps < 3'000; steps += 7) {
        const std::int32_t chunks = chunks_for(lanes, p, steps);
        EXPECT_GE(chunks, 1);
        EXPECT_TRUE(chunks == 1 || steps / chunks >= kLeastSteps) << chunks << " chunks of " << steps;
        EXPECT_TRUE(chunks <= lanes || chunks % lanes == 0) << chunks << " chunks in " << lanes << " lanes";
        EXPECT_LE(chunks, 2 * lanes * p);
      }
    }
  }
}

TEST(Throughput, AutoFillsLanesAndTheWholeBudget) {
  const Prepared prepared = prepare(sample("stewart"), {.budget = ThreadBudget{3}, .mode = Mode::throughput});
  EXPECT_EQ(prepared.plan().run.threads, 3);
  EXPECT_EQ(prepared.plan().lanes, kThroughputLanes);
  EXPECT_EQ(prepared.plan().run.chunks, chunks_for(prepared.plan().lanes, 3, prepared.scene()->time().steps()));
  const Prepared of_the_machine = prepare(sample("stewart"), {.mode = Mode::throughput});
  EXPECT_EQ(of_the_machine.plan().run.threads, this_machine().budget().threads);
}

TEST(Throughput, KeepsAForcedStrategy) {
  const auto plan = [](const char* strategy) {
    return prepare(sample("stewart"), {.strategy = strategy, .mode = Mode::throughput}).plan();
  };
  EXPECT_EQ(plan("groups/eigen:4").run.chunks, 8);
  EXPECT_EQ(plan("groups/eigen:4").run.threads, 1);
  EXPECT_EQ(plan("groups/eigen:4").choices[0].solver.backend, "eigen");
  EXPECT_EQ(plan("groups/eigen:4+chunks=3").run.chunks, 3);
  EXPECT_EQ(plan("groups/eigen:4+chunks=1").run.chunks, 1);
}

TEST(Throughput, LatencyHasNoChunks) {
  EXPECT_EQ(prepare(sample("stewart")).plan().run.chunks, 1);
  EXPECT_EQ(prepare(sample("stewart"), {.strategy = "groups/eigen+chunks=3"}).plan().run.chunks, 3);
}

TEST(Throughput, ABudgetOfNoThreadsIsRefused) {
  EXPECT_THROW((void)prepare(sample("four_bar"), {.budget = ThreadBudget{0}, .mode = Mode::throughput}), Error);
}

}  // namespace
}  // namespace assur
