// Counters of artificial packages.
#include "report/paper/energy.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "parallel/file_tree.hpp"

namespace assur::report {
namespace {

const std::string kZones = "sys/class/powercap/";

void add_zone(test::FileTree& tree, const std::string& zone, const std::string& name, const std::string& count,
              const std::string& range) {
  const std::string folder = kZones + zone;
  tree.file(folder + "/name", name + "\n").file(folder + "/energy_uj", count + "\n");
  tree.file(folder + "/max_energy_range_uj", range + "\n");
}

TEST(EnergyMeter, AddsPackagesOnly) {
  test::FileTree tree;
  add_zone(tree, "intel-rapl:0", "package-0", "1000000", "262143328850");
  add_zone(tree, "intel-rapl:0:0", "core", "700000", "262143328850");
  add_zone(tree, "intel-rapl:1", "package-1", "5000000", "262143328850");
  add_zone(tree, "intel-rapl:2", "psys", "9000000", "262143328850");
  const EnergyMeter meter(tree.root());
  EXPECT_EQ(meter.why_not(), "");
  const std::vector<std::int64_t> before = meter.read();
  ASSERT_EQ(before.size(), 2u);
  tree.file(kZones + "intel-rapl:0/energy_uj", "1500000\n").file(kZones + "intel-rapl:1/energy_uj", "5250000\n");
  tree.file(kZones + "intel-rapl:0:0/energy_uj", "900000\n").file(kZones + "intel-rapl:2/energy_uj", "20000000\n");
  EXPECT_DOUBLE_EQ(meter.joules(before, meter.read()), 0.75);
}

TEST(EnergyMeter, HandlesCounterOverflow) {
  test::FileTree tree;
  add_zone(tree, "intel-rapl:0", "package-0", "262143000000", "262143328850");
  const EnergyMeter meter(tree.root());
  const std::vector<std::int64_t> before = meter.read();
  tree.file(kZones + "intel-rapl:0/energy_uj", "671150\n");
  EXPECT_NEAR(meter.joules(before, meter.read()), 1.0, 1e-12);  // 328,850 uJ up to the range, 671,150 uJ beyond it
}

TEST(EnergyMeter, ExplainsMissingCounters) {
  const test::FileTree nothing;
  const EnergyMeter none(nothing.root());
  EXPECT_NE(none.why_not().find("has no energy counters"), std::string::npos) << none.why_not();
  EXPECT_TRUE(none.read().empty());
  EXPECT_TRUE(std::isnan(none.joules({}, {})));

  test::FileTree tree;  // a counter that cannot be read
  tree.file(kZones + "intel-rapl:0/name", "package-0\n").file(kZones + "intel-rapl:0/max_energy_range_uj", "1000\n");
  EXPECT_NE(EnergyMeter(tree.root()).why_not().find("administrator"), std::string::npos);
}

TEST(EnergyMeter, HasNoEnergyIfAReadingIsMissing) {
  test::FileTree tree;
  add_zone(tree, "intel-rapl:0", "package-0", "100", "1000");
  const EnergyMeter meter(tree.root());
  const std::vector<std::int64_t> before = meter.read();
  tree.file(kZones + "intel-rapl:0/energy_uj", "no number\n");
  EXPECT_TRUE(std::isnan(meter.joules(before, meter.read())));
}

}  // namespace
}  // namespace assur::report
