#include "parallel/machine.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include "parallel/file_tree.hpp"
#include "parallel/thread_state.hpp"
#include "parallel/topology.hpp"

namespace assur::test {
namespace {

using Processors = std::vector<int>;

Processors first(int count) {
  Processors processors(static_cast<std::size_t>(count));
  std::iota(processors.begin(), processors.end(), 0);
  return processors;
}

TEST(ProcessorList, IsReadAsLinuxWritesIt) {
  EXPECT_EQ(parse_processors("0-3,8\n"), (Processors{0, 1, 2, 3, 8}));
  EXPECT_EQ(parse_processors("5"), Processors{5});
  EXPECT_EQ(parse_processors("3,1-2"), (Processors{1, 2, 3}));
  EXPECT_EQ(parse_processors("1,a,-4,3-,5-4,0-2000000000,7"), (Processors{1, 7}));
  EXPECT_EQ(parse_processors(""), Processors{});
}

// 4 cores of two threads each, as Linux numbers them: processors p and p + 4 are one core. Each of two nodes has an L3.
void lay_out_cores(FileTree& tree) {
  const std::string cpus = "sys/devices/system/cpu/cpu", nodes = "sys/devices/system/node/";
  for (int p = 0; p < 8; ++p) {
    const int core = p % 4;
    const std::string cpu = cpus + std::to_string(p) + "/";
    const std::string siblings = std::to_string(core) + "," + std::to_string(core + 4);
    tree.file(cpu + "topology/core_cpus_list", siblings + "\n");
    const auto cache = [&](int index, const std::string& level, const std::string& type, const std::string& size,
                           const std::string& shared) {
      const std::string folder = cpu + "cache/index" + std::to_string(index) + "/";
      tree.file(folder + "level", level).file(folder + "type", type).file(folder + "size", size);
      tree.file(folder + "shared_cpu_list", shared);
    };
    cache(0, "1", "Data\n", "48K\n", siblings);
    cache(1, "1", "Instruction\n", "32K\n", siblings);
    cache(2, "2", "Unified\n", "1M\n", siblings);
    cache(3, "3", "Unified\n", "16384K\n", core < 2 ? "0-1,4-5" : "2-3,6-7");
  }
  tree.file(nodes + "online", "0-1\n").file(nodes + "node0/cpulist", "0-1,4-5\n");
  tree.file(nodes + "node1/cpulist", "2-3,6-7\n");
  tree.file("proc/cpuinfo", "processor\t: 0\nmodel name\t: Fast One @ 3 GHz\n\nprocessor\t: 1\nmodel name\t: Other\n");
}
const std::vector<Cache> kCaches = {{1, 48 << 10, 1}, {2, 1 << 20, 1}, {3, 16 << 20, 2}};

TEST(Machine, IsReadFromTheFilesOfLinux) {
  FileTree tree;
  lay_out_cores(tree);
  const Machine machine = read_machine(tree.root(), first(8), "");
  EXPECT_EQ(machine.model, "Fast One @ 3 GHz");
  EXPECT_EQ(machine.cores, first(4));
  EXPECT_EQ(machine.processors, 8);
  EXPECT_EQ(machine.caches, kCaches);
  EXPECT_EQ(machine.numa_nodes, 2);
  EXPECT_EQ(machine.quota, 0);
  EXPECT_EQ(machine.source, "sysfs");
  EXPECT_EQ(machine.budget().threads, 4);
  EXPECT_FALSE(machine.instructions.empty());
}

// On 64-bit ARM Linux names no processor, and lists caches only if the firmware describes them.
TEST(Machine, IsNamedByItsBoard) {
  FileTree tree;
  tree.file("proc/cpuinfo", "processor\t: 0\nCPU implementer\t: 0x41\nCPU part\t: 0xd03\n");
  tree.file("proc/device-tree/model", std::string("Raspberry Pi 3 Model B Rev 1.2\0", 31));
  const Machine machine = read_machine(tree.root(), first(4), "");
  EXPECT_EQ(machine.model, "Raspberry Pi 3 Model B Rev 1.2");
  EXPECT_EQ(machine.cores, first(4));
  EXPECT_TRUE(machine.caches.empty());
  EXPECT_EQ(machine.numa_nodes, 1);
}

TEST(Machine, HasTheCoresOfTheAffinityMask) {
  FileTree tree;
  lay_out_cores(tree);
  const auto cores = [&](const Processors& allowed) { return read_machine(tree.root(), allowed, "").cores; };
  EXPECT_EQ(cores({1, 5}), Processors{1});       // both threads of one core
  EXPECT_EQ(cores({2, 5}), (Processors{2, 5}));  // one thread of each of two cores
  EXPECT_EQ(cores({0, 4, 7}), (Processors{0, 7}));
  const Machine machine = read_machine(tree.root(), {2, 3, 6}, "");
  EXPECT_EQ(machine.processors, 3);
  EXPECT_EQ(machine.numa_nodes, 1);
  EXPECT_EQ(machine.caches, kCaches) << "of all who share, not only of those that are allowed";
}

TEST(Machine, IsOneCoreWithoutFiles) {
  FileTree empty;
  const Machine machine = read_machine(empty.root(), {}, "");
  EXPECT_EQ(machine.cores, Processors{0});
  EXPECT_EQ(machine.processors, 1);
  EXPECT_EQ(machine.numa_nodes, 1);
  EXPECT_EQ(machine.model, "");
  EXPECT_TRUE(machine.caches.empty());
  EXPECT_EQ(machine.budget().threads, 1);
  EXPECT_EQ(read_machine(empty.root(), {0, 1, 5}, "").cores, (Processors{0, 1, 5})) << "each processor a core";
}

TEST(Machine, IgnoresInvalidFiles) {
  FileTree tree;
  lay_out_cores(tree);
  tree.file("sys/devices/system/cpu/cpu1/topology/core_cpus_list", "what?\n");
  tree.file("sys/devices/system/cpu/cpu0/cache/index0/size", "large\n");
  tree.file("sys/devices/system/node/online", "\n");
  tree.file("proc/cpuinfo", "model name");
  const Machine machine = read_machine(tree.root(), {0, 1, 2}, "many");
  EXPECT_EQ(machine.cores, first(3));
  EXPECT_EQ(machine.caches.front().level, 2);
  EXPECT_EQ(machine.numa_nodes, 1);
  EXPECT_EQ(machine.model, "");
  EXPECT_EQ(machine.openmp_limit, 0);
}

TEST(Machine, ReadsTheListOfAnOlderLinux) {
  FileTree tree;
  for (int p : {0, 1}) {
    tree.file("sys/devices/system/cpu/cpu" + std::to_string(p) + "/topology/thread_siblings_list", "0-1");
  }
  EXPECT_EQ(read_machine(tree.root(), {0, 1}, "").cores, Processors{0});
}

TEST(Budget, IsTheLeastOfCoresQuotaAndOmpNumThreads) {
  struct Case {
    int cores;
    double quota;
    std::string omp_num_threads;
    int budget;
  };
  const std::vector<Case> cases = {
      {64, 0, "", 64},   {64, 2, "", 2},    {64, 1.5, "", 2},  {64, 0.1, "", 1},  {2, 8, "", 2},   {64, 63.5, "", 64},
      {64, 0, "4", 4},   {64, 0, "4,2", 4}, {64, 0, "99", 64}, {64, 3, "4", 3},   {64, 8, "4", 4}, {64, 0, "0", 64},
      {64, 0, "-3", 64}, {64, 0, "x", 64},  {1, 0.5, "1", 1},  {64, 1e9, "", 64},
  };
  for (const Case& c : cases) {
    FileTree tree;
    tree.file("proc/self/cgroup", "0::/\n").file("proc/self/mountinfo", "1 2 0:3 / /cg rw - cgroup2 c rw\n");
    if (c.quota > 0) tree.file("cg/cpu.max", std::to_string(c.quota * 100000) + " 100000");
    EXPECT_EQ(read_machine(tree.root(), first(c.cores), c.omp_num_threads).budget().threads, c.budget)
        << c.cores << " cores, quota " << c.quota << ", " << c.omp_num_threads;
  }
}

TEST(Machine, TextNamesItsLimits) {
  FileTree tree;
  lay_out_cores(tree);
  Machine machine = read_machine(tree.root(), first(8), "");
  machine.instructions = "AVX2";
  EXPECT_EQ(to_string(machine),
            "Fast One @ 3 GHz, AVX2: 4 cores (8 processors), L1 48 KiB, L2 1 MiB, L3 16 MiB for 2 cores, 2 NUMA nodes; "
            "budget: 4 threads");
  machine = {};
  machine.instructions = "SCALAR";
  machine.cores = {0};
  machine.quota = 0.5;
  machine.openmp_limit = 2;
  EXPECT_EQ(to_string(machine), "unknown processor, SCALAR: 1 core; budget: 1 thread, quota 0.5, OMP_NUM_THREADS 2");
}

// ---- hwloc

class Hwloc : public testing::Test {
 protected:
  void SetUp() override {
    if (!topology_by_hwloc({0}, "core:1 pu:1")) GTEST_SKIP() << "this build is without hwloc";
  }
};

TEST_F(Hwloc, ReadsCoresCachesAndNodes) {
  const auto topology = topology_by_hwloc(first(16),
                                          "numa:2 l3:1(size=16777216) l2:4(size=1048576) l1d:1(size=49152) "
                                          "core:1 pu:2");
  ASSERT_TRUE(topology);
  EXPECT_EQ(topology->cores, (Processors{0, 2, 4, 6, 8, 10, 12, 14}));
  EXPECT_EQ(topology->caches, (std::vector<Cache>{{1, 48 << 10, 1}, {2, 1 << 20, 1}, {3, 16 << 20, 4}}));
  EXPECT_EQ(topology->numa_nodes, 2);
  EXPECT_EQ(topology->source.rfind("hwloc ", 0), 0u);
}

TEST_F(Hwloc, CountsCoresOfTheAffinityMask) {
  const std::string machine = "numa:2 l3:1 core:4 pu:2";
  const auto cores = [&](const Processors& allowed) { return topology_by_hwloc(allowed, machine)->cores; };
  EXPECT_EQ(cores({2, 3}), Processors{2});
  EXPECT_EQ(cores({3, 4}), (Processors{3, 4}));
  EXPECT_EQ(topology_by_hwloc({0, 2}, machine)->numa_nodes, 1);
  EXPECT_EQ(topology_by_hwloc({0, 8}, machine)->numa_nodes, 2);
  EXPECT_EQ(topology_by_hwloc({0}, machine)->caches.back().cores, 4) << "those included that are not allowed";
  EXPECT_FALSE(topology_by_hwloc({99}, machine)) << "a mask of another machine";
  EXPECT_FALSE(topology_by_hwloc({0}, "no such machine"));
}

TEST_F(Hwloc, AgreesWithLinux) {
  const Processors allowed = allowed_processors();
  if (allowed.empty()) GTEST_SKIP() << "the system does not tell where threads may run";
  const auto topology = topology_by_hwloc(allowed);
  ASSERT_TRUE(topology);
  const Topology plain = topology_by_sysfs(allowed);
  EXPECT_EQ(topology->cores, plain.cores);
  EXPECT_EQ(topology->numa_nodes, plain.numa_nodes);
  if (!plain.caches.empty()) {
    EXPECT_EQ(topology->caches, plain.caches);
  }
}

// ---- this machine

TEST(ThisMachine, HasTheProcessorsOfTheCallingThread) {
  const Machine machine = this_machine();
  const Processors allowed = allowed_processors();
  ASSERT_FALSE(machine.cores.empty());
  EXPECT_GE(machine.budget().threads, 1);
  EXPECT_LE(machine.budget().threads, static_cast<int>(machine.cores.size()));
  EXPECT_LE(static_cast<int>(machine.cores.size()), machine.processors);
  EXPECT_EQ(available_budget().threads, machine.budget().threads);
  if (allowed.empty()) return;
  EXPECT_EQ(machine.processors, static_cast<int>(allowed.size()));
  const Pinned pinned(allowed.back());
  EXPECT_EQ(this_machine().cores, Processors{allowed.back()});
  EXPECT_EQ(this_machine().budget().threads, 1);
  EXPECT_EQ(available_budget().threads, 1);
}

TEST(ThisMachine, OmpNumThreadsIsAnUpperBound) {
  const char* const before = std::getenv("OMP_NUM_THREADS");
  const std::string kept = before ? before : "";
  setenv("OMP_NUM_THREADS", "1", 1);
  EXPECT_EQ(this_machine().budget().threads, 1);
  EXPECT_EQ(available_budget().threads, 1);
  setenv("OMP_NUM_THREADS", "100000", 1);
  const int bounded = this_machine().budget().threads;
  unsetenv("OMP_NUM_THREADS");
  EXPECT_EQ(this_machine().budget().threads, bounded);
  if (before) setenv("OMP_NUM_THREADS", kept.c_str(), 1);
}

}  // namespace
}  // namespace assur::test
