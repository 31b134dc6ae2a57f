#include "parallel/team.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <sys/syscall.h>
#include <unistd.h>

#include "assur/status.hpp"
#include "backends/allocations.hpp"
#include "parallel/barrier.hpp"

namespace assur::test {
namespace {

std::vector<std::thread::id> threads_of(Team& team) {
  std::vector<std::thread::id> ids(static_cast<std::size_t>(team.size()));
  team.run([&](int rank) noexcept { ids[static_cast<std::size_t>(rank)] = std::this_thread::get_id(); });
  return ids;
}

TEST(Team, EveryRankWorksOnceOnAThreadOfItsOwn) {
  for (int size : {1, 2, 3, 8}) {
    Team team(size);
    ASSERT_EQ(team.size(), size);
    const auto ids = threads_of(team);
    EXPECT_EQ(ids[0], std::this_thread::get_id());
    EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), ids.size());
    EXPECT_EQ(threads_of(team), ids);  // and always on the same one

    std::vector<int> calls(ids.size());
    for (int i = 0; i < 1000; ++i) team.run([&](int rank) noexcept { ++calls[static_cast<std::size_t>(rank)]; });
    EXPECT_EQ(calls, std::vector<int>(ids.size(), 1000));
  }
}

TEST(Team, WhatIsWrittenBeforeAndWithinIsSeenAfter) {
  Team team(4);
  int given = 0, taken[4] = {};
  for (int i = 1; i <= 1000; ++i) {
    given = i;
    team.run([&](int rank) noexcept { taken[rank] = given + rank; });
    for (int rank = 0; rank < 4; ++rank) ASSERT_EQ(taken[rank], i + rank);
  }
}

TEST(Team, TeamsOfTeamsAreThreadsOfTheirOwn) {
  Team callers(2);
  Team inner_of[2] = {Team(2), Team(2)};
  std::vector<std::thread::id> ids[2];
  callers.run([&](int rank) noexcept {
    for (int i = 0; i < 100; ++i) ids[rank] = threads_of(inner_of[rank]);
  });
  EXPECT_EQ(ids[0][0], std::this_thread::get_id());
  std::set<std::thread::id> all(ids[0].begin(), ids[0].end());
  all.insert(ids[1].begin(), ids[1].end());
  EXPECT_EQ(all.size(), 4u);
}

TEST(Team, CanBeLeftWithoutWork) {
  for (int i = 0; i < 100; ++i) Team team(3);
}

TEST(Team, RefusesToHaveNoThread) {
  for (int size : {0, -1}) {
    try {
      Team team(size);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::input);
      EXPECT_EQ(error.what(), "a team needs at least one thread, not " + std::to_string(size));
    }
  }
}

TEST(Team, ARunTakesNoMemory) {
  Team team(3);
  std::atomic<int> sum = 0;
  const auto before = allocations();
  for (int i = 0; i < 100; ++i) team.run([&](int rank) noexcept { sum += rank; });
  EXPECT_EQ(allocations() - before, 0);
  EXPECT_EQ(sum, 300);
}

// The state of a thread as Linux tells it: R runs, S sleeps.
char state_of(long thread) {
  std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/stat");
  std::string line;
  std::getline(file, line);
  const auto name_end = line.rfind(')');
  return name_end == std::string::npos ? '?' : line[name_end + 2];
}

TEST(Team, AnIdleTeamFallsAsleepAndWakes) {
  Team team(2);
  long worker = 0;
  const auto ask = [&](int rank) noexcept {
    if (rank == 1) worker = syscall(SYS_gettid);
  };
  team.run(ask);
  if (state_of(worker) == '?') GTEST_SKIP() << "/proc does not show threads";
  while (state_of(worker) != 'S') std::this_thread::yield();
  const long asleep = worker;
  worker = 0;
  team.run(ask);
  EXPECT_EQ(worker, asleep);
}

// 16 threads are more than the cores of most machines that test: those who wait must let the others on.
TEST(Barrier, NobodyPassesBeforeAllHaveArrived) {
  for (int size : {1, 2, 4, 16}) {
    Team team(size);
    Barrier barrier(size);
    std::vector<int> arrived(static_cast<std::size_t>(size));
    std::atomic<int> early = 0;
    team.run([&](int rank) noexcept {
      for (int round = 1; round <= 500; ++round) {
        arrived[static_cast<std::size_t>(rank)] = round;
        barrier.arrive_and_wait();
        for (int other : arrived) early += other != round;
        barrier.arrive_and_wait();  // before the next round is written
      }
    });
    EXPECT_EQ(early, 0) << size;
  }
}

TEST(Barrier, SubteamsWithBarriersOfTheirOwnDoNotWaitForEachOther) {
  Team team(4);  // two subteams of two
  Barrier barriers[2] = {Barrier(2), Barrier(2)};
  std::atomic<int> rounds[2] = {};
  team.run([&](int rank) noexcept {
    const int subteam = rank / 2;
    if (subteam == 1) {
      while (rounds[0] < 200) std::this_thread::yield();  // the first is through before the second begins
    }
    for (int round = 0; round < 100; ++round) {
      barriers[subteam].arrive_and_wait();
      ++rounds[subteam];
    }
  });
  EXPECT_EQ(rounds[0], 200);
  EXPECT_EQ(rounds[1], 200);
}

}  // namespace
}  // namespace assur::test
