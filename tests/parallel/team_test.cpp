#include "parallel/team.hpp"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>
#ifdef _OPENMP
#include <omp.h>
#endif

#include "assur/status.hpp"
#include "backends/allocations.hpp"
#include "parallel/barrier.hpp"
#include "parallel/in_a_child.hpp"
#include "parallel/thread_state.hpp"
#include "sanitizers.hpp"

namespace assur::test {
namespace {

std::vector<std::thread::id> threads_of(Team& team) {
  std::vector<std::thread::id> ids(static_cast<std::size_t>(team.size()));
  team.run([&](int rank) noexcept { ids[static_cast<std::size_t>(rank)] = std::this_thread::get_id(); });
  return ids;
}

TEST(Team, EveryRankWorksOnceOnItsOwnThread) {
  for (int size : {1, 2, 3, 8}) {
    Team team(size);
    ASSERT_EQ(team.size(), size);
    const auto ids = threads_of(team);
    EXPECT_EQ(ids[0], std::this_thread::get_id());
    EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), ids.size());
    EXPECT_EQ(threads_of(team), ids);  // always the same threads

    std::vector<int> calls(ids.size());
    for (int i = 0; i < 1000; ++i) team.run([&](int rank) noexcept { ++calls[static_cast<std::size_t>(rank)]; });
    EXPECT_EQ(calls, std::vector<int>(ids.size(), 1000));
  }
}

TEST(Team, WritesAreVisibleAfterTheRun) {
  Team team(4);
  int given = 0, taken[4] = {};
  for (int i = 1; i <= 1000; ++i) {
    given = i;
    team.run([&](int rank) noexcept { taken[rank] = given + rank; });
    for (int rank = 0; rank < 4; ++rank) ASSERT_EQ(taken[rank], i + rank);
  }
}

TEST(Team, TeamsOfTeamsHaveTheirOwnThreads) {
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

TEST(Team, CanBeDestroyedWithoutWork) {
  for (int i = 0; i < 100; ++i) Team team(3);
}

TEST(Team, RefusesZeroThreads) {
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

TEST(Team, ARunAllocatesNothing) {
  Team team(3);
  std::atomic<int> sum = 0;
  const auto add_ranks = [&](int rank) noexcept { sum += rank; };
  team.run(add_ranks);  // threads may allocate when they start
  const auto before = allocations();
  for (int i = 0; i < 100; ++i) team.run(add_ranks);
  EXPECT_EQ(allocations() - before, 0);
  EXPECT_EQ(sum, 303);
}

// State of a thread in Linux: R is running, S sleeping.
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

TEST(Team, MembersMeet) {
  for (int size : {1, 2, 4, 16}) {  // more than the cores of most test machines
    Team team(size);
    std::vector<int> arrived(static_cast<std::size_t>(size));
    std::atomic<int> early = 0;
    team.run([&](int rank) {
      for (int round = 1; round <= 500; ++round) {
        arrived[static_cast<std::size_t>(rank)] = round;
        team.barrier();
        for (int other : arrived) early += other != round;
        team.barrier();
      }
    });
    EXPECT_EQ(early, 0) << size;
  }
}

TEST(Team, AnExceptionOfAMemberReachesTheCaller) {
  Team team(4);
  for (int thrower : {0, 1, 3}) {
    std::atomic<int> past = 0;
    const auto work = [&](int rank) {
      team.barrier();
      if (rank == thrower) throw Error(Error::Kind::numerical, "rank " + std::to_string(rank));
      team.barrier();
      ++past;
    };
    try {
      team.run(work);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::numerical);
      EXPECT_EQ(error.what(), "rank " + std::to_string(thrower));
    }
    EXPECT_EQ(past, 0);

    team.run([&](int) {  // the barrier works again
      team.barrier();
      ++past;
    });
    EXPECT_EQ(past, 4);
  }
}

TEST(Team, IfAllThrowTheLowestRankCounts) {
  Team team(3);
  for (int i = 0; i < 100; ++i) {
    try {
      team.run([](int rank) { throw rank; });
      FAIL();
    } catch (int rank) {
      EXPECT_EQ(rank, 0);
    }
  }
}

TEST(Team, EachThreadOfTheUserHasItsOwnTeam) {
  std::atomic<int> sum = 0;
  const auto use = [&] {
    Team team(3);
    for (int i = 0; i < 200; ++i) {
      team.run([&](int rank) {
        sum += rank;
        team.barrier();
      });
    }
  };
  std::thread other(use);
  use();
  other.join();
  EXPECT_EQ(sum, 2 * 200 * 3);
}

#ifdef _OPENMP
TEST(Team, WorksWithinAParallelRegionOfTheUser) {
  std::atomic<int> sum = 0, inside = 0;
#pragma omp parallel num_threads(2)
  {
    Team team(3);
    inside += omp_in_parallel();
    for (int i = 0; i < 200; ++i) {
      team.run([&](int rank) {
        sum += rank;
        team.barrier();
      });
    }
    EXPECT_EQ(omp_get_num_threads(), 2);
  }
  EXPECT_EQ(inside, 2);
  EXPECT_EQ(sum, 2 * 200 * 3);
}
#endif

TEST(Team, PinsMembersAndReleasesTheCaller) {
  const std::vector<int> before = allowed_processors();
  if (before.empty()) GTEST_SKIP() << "the system does not tell where threads may run";
  for (std::size_t size = 1; size <= std::min<std::size_t>(before.size(), 4); ++size) {
    Team team(static_cast<int>(size), before);
    std::vector<std::vector<int>> on(size);
    team.run([&](int rank) {
      on[static_cast<std::size_t>(rank)] = allowed_processors();
      team.barrier();
    });
    for (std::size_t rank = 0; rank < size; ++rank) EXPECT_EQ(on[rank], std::vector<int>{before[rank]});
    EXPECT_EQ(allowed_processors(), before);
    EXPECT_THROW(team.run([](int) { throw 1; }), int);
    EXPECT_EQ(allowed_processors(), before);
  }
}

TEST(Team, CannotBePinnedToFewerCoresThanMembers) {
  const std::vector<int> one = {0};
  try {
    Team team(2, one);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    EXPECT_STREQ(error.what(), "a team of 2 threads cannot be pinned to 1 cores; use fewer threads, or do not pin");
  }
}

TEST(Team, CannotBePinnedToForbiddenProcessors) {
  const std::vector<int> before = allowed_processors();
  const std::vector<int> absent = {before.empty() ? 0 : before[0], 8000};
  try {
    Team team(2, absent);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_NE(std::string(error.what()).find("cannot pin a thread to processor 8000: "), std::string::npos);
  }
  EXPECT_EQ(allowed_processors(), before);
}

class ForkedTeam : public testing::Test {
 protected:
  void SetUp() override {
#ifdef ASSUR_THREAD_SANITIZER
    GTEST_SKIP() << "ThreadSanitizer lets the child of a fork start no threads";
#endif
  }
};

TEST_F(ForkedTeam, RestartsInTheChild) {
  const std::vector<int> processors = allowed_processors();
  for (const bool pinned : {false, true}) {
    const int size = pinned ? static_cast<int>(std::min<std::size_t>(processors.size(), 3)) : 3;
    if (size == 0) GTEST_SKIP() << "the system does not tell where threads may run";
    Team team(size, pinned ? processors : std::vector<int>{});
    const auto before = threads_of(team);
    const auto works = [&] {
      int calls[3] = {};
      for (int i = 0; i < 100; ++i) {
        team.run([&](int rank) {
          team.barrier();
          ++calls[rank];
          team.barrier();
        });
      }
      return std::all_of(calls, calls + size, [](int c) { return c == 100; });
    };
    EXPECT_EQ(in_a_child([&] { return works() ? 0 : 1; }), 0);
    EXPECT_EQ(in_a_child([&] { return in_a_child([&] { return works() ? 0 : 1; }); }), 0);  // in a child of the child
    EXPECT_TRUE(works());  // the parent keeps its threads
    EXPECT_EQ(threads_of(team), before);
  }
}

// At the fork, another thread of the parent is inside run(); the child starts without it.
TEST_F(ForkedTeam, RestartsInTheChildWhileAtWork) {
  Team team(2);
  std::atomic<bool> at_work = false, end = false;
  std::thread user([&] {
    team.run([&](int) {
      at_work = true;
      while (!end) std::this_thread::yield();
      team.barrier();
    });
  });
  while (!at_work) std::this_thread::yield();
  EXPECT_EQ(in_a_child([&] {
              std::atomic<int> sum = 0;
              team.run([&](int rank) {
                sum += rank + 1;
                team.barrier();
              });
              return sum == 3 ? 0 : 1;
            }),
            0);
  end = true;
  user.join();
}

TEST_F(ForkedTeam, CanBeDestroyedInTheChild) {
  std::optional<Team> team(3);
  EXPECT_EQ(in_a_child([&] {
              team.reset();
              return 0;
            }),
            0);
}

// 16 threads are more than the cores of most test machines, so waiting threads must yield.
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

TEST(Barrier, SubteamsWithTheirOwnBarriersAreIndependent) {
  Team team(4);  // two subteams of two
  Barrier barriers[2] = {Barrier(2), Barrier(2)};
  std::atomic<int> rounds[2] = {};
  team.run([&](int rank) noexcept {
    const int subteam = rank / 2;
    if (subteam == 1) {
      while (rounds[0] < 200) std::this_thread::yield();  // the first subteam ends before the second begins
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
