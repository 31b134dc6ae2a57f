#include "parallel/free_memory.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>

#include "assur/status.hpp"
#include "parallel/file_tree.hpp"
#include "parallel/in_a_child.hpp"
#include "sanitizers.hpp"

namespace assur::test {
namespace {

const std::string kMeminfo = "MemTotal:       16000000 kB\nMemFree:         1000000 kB\nMemAvailable:    3000000 kB\n";

TEST(FreeMemory, IsTheAvailableMemoryOfTheMachine) {
  FileTree tree;
  tree.file("proc/meminfo", kMeminfo);
  EXPECT_EQ(free_memory(tree.root()), 3'000'000 * 1024.0);
}

TEST(FreeMemory, IsLimitedByTheControlGroup) {
  FileTree tree;
  tree.file("proc/meminfo", kMeminfo).file("proc/self/cgroup", "0::/job\n");
  tree.file("proc/self/mountinfo", "31 23 0:28 / /sys/fs/cgroup rw shared:9 - cgroup2 cgroup rw\n");
  tree.file("sys/fs/cgroup/job/memory.max", "4000000000").file("sys/fs/cgroup/job/memory.current", "1500000000");
  EXPECT_EQ(free_memory(tree.root()), 2.5e9);
}

TEST(FreeMemory, IsUnlimitedWithoutFiles) {
  FileTree tree;
  EXPECT_EQ(free_memory(tree.root()), HUGE_VAL);
}

#if !defined(ASSUR_ADDRESS_SANITIZER) && !defined(ASSUR_THREAD_SANITIZER)
TEST(FreeMemory, IsLimitedByTheLimitsOfTheProcess) {
  for (const int resource : {RLIMIT_AS, RLIMIT_DATA}) {
    EXPECT_EQ(in_a_child([resource] {
                const rlimit limit{rlim_t{3} << 30, rlim_t{3} << 30};
                if (setrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return 1;
                const double free = free_memory();
                return free > 0 && free < 3 * 1073741824.0 ? 0 : 2;
              }),
              0);
  }
}
#endif

TEST(FreeMemory, ErrorsNameNeededAndFreeMemory) {
  EXPECT_NO_THROW(require_memory(1e6, "little", "nothing"));
  try {
    require_memory(1e18, "that", "ask for less");
    FAIL() << "no machine has it";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    const std::string text = error.what();
    EXPECT_EQ(text.rfind("no memory for that (953674316406 MiB, ", 0), 0u) << text;
    EXPECT_TRUE(text.ends_with(" free); ask for less")) << text;
  }
}

TEST(FreeMemory, TakenMemoryIsThatOfTheProcess) { EXPECT_GT(taken_memory(), 1e5); }

}  // namespace
}  // namespace assur::test
