#include "parallel/cgroup.hpp"

#include <gtest/gtest.h>

#include "parallel/file_tree.hpp"

namespace assur::test {
namespace {

// A line of mountinfo; `top` is the group at the root of the mount.
std::string mount(const std::string& top, const std::string& point, const std::string& type,
                  const std::string& options) {
  return "31 23 0:28 " + top + " " + point + " rw,nosuid shared:9 - " + type + " cgroup rw," + options + "\n";
}
const std::string kMountV2 = mount("/", "/sys/fs/cgroup", "cgroup2", "nsdelegate");
const std::string kMountV1 = mount("/", "/sys/fs/cgroup/memory", "cgroup", "memory") +
                             mount("/", "/sys/fs/cgroup/cpu,cpuacct", "cgroup", "cpu,cpuacct");

TEST(CpuQuota, IsUnlimitedWithoutFiles) {
  FileTree empty;
  EXPECT_EQ(cpu_quota(empty.root()), 0);
  FileTree tree;
  tree.file("proc/self/cgroup", "0::/\n").file("proc/self/mountinfo", kMountV2);
  EXPECT_EQ(cpu_quota(tree.root()), 0);
}

TEST(CpuQuota, Version2IsTimeOverPeriod) {
  FileTree tree;
  tree.file("proc/self/cgroup", "0::/job\n").file("proc/self/mountinfo", kMountV2);
  tree.file("sys/fs/cgroup/job/cpu.max", "200000 100000\n");
  EXPECT_EQ(cpu_quota(tree.root()), 2);
  tree.file("sys/fs/cgroup/job/cpu.max", "75000 50000\n");
  EXPECT_EQ(cpu_quota(tree.root()), 1.5);
  tree.file("sys/fs/cgroup/job/cpu.max", "max 100000\n");
  EXPECT_EQ(cpu_quota(tree.root()), 0);
}

TEST(CpuQuota, IsTheMinimumOfAllParentGroups) {
  FileTree tree;
  tree.file("proc/self/cgroup", "0::/a/b/c\n").file("proc/self/mountinfo", kMountV2);
  tree.file("sys/fs/cgroup/a/cpu.max", "150000 100000").file("sys/fs/cgroup/a/b/cpu.max", "max 100000");
  tree.file("sys/fs/cgroup/a/b/c/cpu.max", "400000 100000");
  EXPECT_EQ(cpu_quota(tree.root()), 1.5);
  tree.file("sys/fs/cgroup/a/b/cpu.max", "50000 100000");
  EXPECT_EQ(cpu_quota(tree.root()), 0.5);
  tree.file("sys/fs/cgroup/a/b/d/cpu.max", "10000 100000");  // a sibling group
  EXPECT_EQ(cpu_quota(tree.root()), 0.5);
}

// In a container with its own name space, the group of the container is the root of the mount.
TEST(CpuQuota, ReadsAContainerAtTheMountPoint) {
  FileTree tree;
  tree.file("proc/self/cgroup", "0::/\n").file("proc/self/mountinfo", kMountV2);
  tree.file("sys/fs/cgroup/cpu.max", "200000 100000");
  EXPECT_EQ(cpu_quota(tree.root()), 2);
}

// Without a name space, the mount shows the group of the container, but the process has its path from the machine's
// root.
TEST(CpuQuota, ReadsAGroupAtTheRootOfTheMount) {
  FileTree tree;
  tree.file("proc/self/cgroup", "4:cpu,cpuacct:/docker/4f/job\n");
  tree.file("proc/self/mountinfo", mount("/docker/4f", "/sys/fs/cgroup/cpu,cpuacct", "cgroup", "cpu,cpuacct"));
  tree.file("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "300000");
  tree.file("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000");
  EXPECT_EQ(cpu_quota(tree.root()), 3);
  tree.file("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_quota_us", "250000");
  tree.file("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_period_us", "100000");
  EXPECT_EQ(cpu_quota(tree.root()), 2.5);
}

TEST(CpuQuota, UsesTheRootForGroupsOutsideTheMount) {
  for (const std::string group : {"/../beside", "/docker/4f/../other", "/docker/4fa"}) {
    FileTree tree;
    tree.file("proc/self/cgroup", "0::" + group + "\n");
    tree.file("proc/self/mountinfo", mount("/docker/4f", "/sys/fs/cgroup", "cgroup2", "x"));
    tree.file("sys/fs/cgroup/cpu.max", "200000 100000").file("sys/fs/beside/cpu.max", "1 100000");
    EXPECT_EQ(cpu_quota(tree.root()), 2) << group;
  }
}

TEST(CpuQuota, Version1UsesTheCpuController) {
  FileTree tree;
  tree.file("proc/self/cgroup", "9:name=systemd:/\n4:memory:/m\n3:cpuset:/s\n1:cpu,cpuacct:/job/part\n0::/\n");
  tree.file("proc/self/mountinfo", kMountV1);
  tree.file("sys/fs/cgroup/cpu,cpuacct/job/part/cpu.cfs_quota_us", "-1");
  tree.file("sys/fs/cgroup/cpu,cpuacct/job/part/cpu.cfs_period_us", "100000");
  EXPECT_EQ(cpu_quota(tree.root()), 0);
  tree.file("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_quota_us", "400000");
  tree.file("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_period_us", "200000");
  EXPECT_EQ(cpu_quota(tree.root()), 2);
}

TEST(CpuQuota, UsesTheSmallerOfBothVersions) {
  FileTree tree;
  tree.file("proc/self/cgroup", "1:cpu,cpuacct:/\n0::/job\n");
  tree.file("proc/self/mountinfo", kMountV1 + mount("/", "/sys/fs/cgroup/unified", "cgroup2", "x"));
  tree.file("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "300000");
  tree.file("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000");
  tree.file("sys/fs/cgroup/unified/job/cpu.max", "200000 100000");
  EXPECT_EQ(cpu_quota(tree.root()), 2);
}

TEST(CpuQuota, IsUnlimitedForInvalidFiles) {
  for (const std::string text : {"", "much", "200000", "200000 0", "-5 100000", "0 100000", "200000 often"}) {
    FileTree tree;
    tree.file("proc/self/cgroup", "0::/job\n").file("proc/self/mountinfo", kMountV2);
    tree.file("sys/fs/cgroup/job/cpu.max", text);
    EXPECT_EQ(cpu_quota(tree.root()), 0) << text;
  }
  FileTree tree;
  tree.file("proc/self/cgroup", "nonsense\n::\n")
      .file("proc/self/mountinfo", "1 2\n - \nx - cgroup2\n\\0 \\999 - a b c");
  EXPECT_EQ(cpu_quota(tree.root()), 0);
}

TEST(CpuQuota, AcceptsAMountPointWithASpace) {
  FileTree tree;
  tree.file("proc/self/cgroup", "0::/\n").file("proc/self/mountinfo", mount("/", "/my\\040groups", "cgroup2", "x"));
  tree.file("my groups/cpu.max", "200000 100000");
  EXPECT_EQ(cpu_quota(tree.root()), 2);
}

TEST(CgroupMemory, IsTheLeastFreeMemoryOfAllParentGroups) {
  FileTree tree;
  tree.file("proc/self/cgroup", "0::/a/b\n").file("proc/self/mountinfo", kMountV2);
  EXPECT_EQ(cgroup_memory(tree.root()), 0);
  tree.file("sys/fs/cgroup/a/b/memory.max", "max\n");
  EXPECT_EQ(cgroup_memory(tree.root()), 0);
  tree.file("sys/fs/cgroup/a/memory.max", "8000\n").file("sys/fs/cgroup/a/memory.current", "5000\n");
  EXPECT_EQ(cgroup_memory(tree.root()), 3000);
  tree.file("sys/fs/cgroup/a/memory.stat", "anon 1000\nactive_file 70\ninactive_file 2500\n");
  EXPECT_EQ(cgroup_memory(tree.root()), 5500);
  tree.file("sys/fs/cgroup/a/b/memory.max", "4000").file("sys/fs/cgroup/a/b/memory.current", "4100");
  EXPECT_EQ(cgroup_memory(tree.root()), 1);
}

TEST(CgroupMemory, Version1UsesTheMemoryController) {
  FileTree tree;
  tree.file("proc/self/cgroup", "4:memory:/m\n1:cpu,cpuacct:/job\n").file("proc/self/mountinfo", kMountV1);
  tree.file("sys/fs/cgroup/memory/m/memory.limit_in_bytes", "9000");
  tree.file("sys/fs/cgroup/memory/m/memory.usage_in_bytes", "2000");
  tree.file("sys/fs/cgroup/memory/m/memory.stat", "inactive_file 1\ntotal_inactive_file 500\n");
  EXPECT_EQ(cgroup_memory(tree.root()), 7500);
}

}  // namespace
}  // namespace assur::test
