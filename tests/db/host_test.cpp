#include "db/host.hpp"

#include <gtest/gtest.h>

#include "db/samples.hpp"
#include "foreign_locale.hpp"
#include "parallel/file_tree.hpp"

namespace assur::test {
namespace {

using db::Likeness;

TEST(Host, IsReadFromTheFilesOfLinux) {
  FileTree tree;
  tree.file("proc/meminfo", "MemTotal:       16384 kB\nMemFree: 1 kB\n");
  tree.file("proc/cpuinfo",
            "processor\t: 0\nvendor_id\t: AuthenticAMD\ncpu family\t: 26\nmodel\t\t: 2\nmodel name\t: AMD EPYC\n"
            "stepping\t: 1\nmicrocode\t: 0x1000065\nflags\t\t: fpu\nbugs\t\t:\n\nprocessor\t: 1\nmodel\t\t: 9\n");
  const db::Host host = db::read_host(tree.root(), {0, 1}, "");
  EXPECT_EQ(host.vendor, "AuthenticAMD");
  EXPECT_EQ(host.family, 26);
  EXPECT_EQ(host.model, 2);
  EXPECT_EQ(host.stepping, 1);
  EXPECT_EQ(host.microcode, "0x1000065");
  EXPECT_EQ(host.memory, 16384 * 1024);
  EXPECT_EQ(host.machine.model, "AMD EPYC");
  EXPECT_EQ(host.machine.cores.size(), 2u);
  EXPECT_EQ(to_string(host), "AMD EPYC (AuthenticAMD 26/2/1), " + host.machine.instructions + ", 2 cores");
}

TEST(Host, ReadsThePartsOfAnArmProcessor) {
  FileTree tree;
  tree.file("proc/cpuinfo",
            "processor\t: 0\nBogoMIPS\t: 243.75\nCPU implementer\t: 0x41\nCPU architecture: 8\nCPU variant\t: 0x3\n"
            "CPU part\t: 0xd0c\nCPU revision\t: 1\n\n");
  const db::Host host = db::read_host(tree.root(), {0}, "");
  EXPECT_EQ(host.vendor, "0x41");
  EXPECT_EQ(host.family, 8);
  EXPECT_EQ(host.model, 0xd0c);
  EXPECT_EQ(host.stepping, 0x31);
}

TEST(Host, AnUnknownHostIsOnlyLikeItself) {
  FileTree tree;
  const db::Host host = db::read_host(tree.root(), {0}, ""), more = db::read_host(tree.root(), {0, 1}, "");
  EXPECT_EQ(host.machine.model.rfind("processor of ", 0), 0u);
  EXPECT_EQ(likeness(host, host), Likeness::same);
  EXPECT_EQ(likeness(host, more), Likeness::none);
}

TEST(Host, IgnoresFieldsWithoutInfluenceOnTimes) {
  const db::Host host = host_with(4);
  db::Host other = host;
  other.microcode = "0x18";
  other.memory = 1;
  other.machine.openmp_limit = 1;
  other.machine.source = "hwloc";
  other.machine.cores = {7, 6, 5, 4};
  EXPECT_EQ(likeness(host, other), Likeness::same);
  EXPECT_EQ(host.fingerprint().size(), 16u);
  // Databases store this fingerprint, so it must never change.
  EXPECT_EQ(host.fingerprint(), "2bacf650164fcad3");
}

TEST(Host, LikenessFallsStepByStep) {
  const db::Host host = host_with(4);
  const auto with = [&](auto change) {
    db::Host other = host;
    change(other);
    return likeness(host, other);
  };
  EXPECT_EQ(likeness(host, host_with(2)), Likeness::processor);
  EXPECT_EQ(likeness(host, host_with(4, 1.5)), Likeness::processor);
  EXPECT_EQ(with([](db::Host& h) { h.machine.processors = 4; }), Likeness::processor);
  EXPECT_EQ(with([](db::Host& h) { h.machine.caches[2].bytes *= 2; }), Likeness::processor);
  EXPECT_EQ(with([](db::Host& h) { h.stepping = 2; }), Likeness::microarchitecture);
  EXPECT_EQ(with([](db::Host& h) { h.machine.model = "Slow One"; }), Likeness::microarchitecture);
  EXPECT_EQ(with([](db::Host& h) { h.machine.instructions = "SSE4"; }), Likeness::microarchitecture);
  EXPECT_EQ(with([](db::Host& h) { h.model = 18; }), Likeness::none);
  EXPECT_EQ(with([](db::Host& h) { h.family = 26; }), Likeness::none);
  EXPECT_EQ(with([](db::Host& h) { h.vendor = "Other"; }), Likeness::none);
}

// A locale that writes 1234.5 as "1.234,5" does not change the host.
TEST(Host, IsTheSameInEveryLocale) {
  FileTree tree;
  tree.file("proc/meminfo", "MemTotal:       16384000 kB\n");
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(1200, 1.5), 3);
  const auto look = [&] {
    return std::tuple(to_string(host_with(1200, 1.5)), db::read_host(tree.root(), {0}, "").memory,
                      db::Store(file, db::Access::read).runs().at(0).machine);
  };
  const auto expected = look();
  EXPECT_EQ(std::get<0>(expected), "Fast One (MakerOfProcessors 25/17/1), AVX2, 1200 cores, quota 1.5");
  EXPECT_EQ(std::get<2>(expected), host_with(1200, 1.5).fingerprint());
  for (const char point : {',', '.'}) {
    const ForeignLocale locale(point);
    EXPECT_EQ(look(), expected);
  }
}

}  // namespace
}  // namespace assur::test
