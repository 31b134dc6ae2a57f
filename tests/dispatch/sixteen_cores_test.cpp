// The model on samples of a real machine: a quick tuning of 27 November 2026 on 16 cores of an Intel Xeon, 1,295 of its
// 4,068 samples. Among them are samples under a wrong key: packs of a chain, which use one lane, as packs of 16 lanes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "assur/performance.hpp"
#include "dispatch/candidates.hpp"
#include "dispatch/pace.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

// At the usual pace.
std::vector<Sample> samples_of_16_cores() {
  std::ifstream file(std::string(ASSUR_SOURCE_DIR) + "/tests/data/tuning/sixteen_cores.csv");
  std::vector<Sample> all;
  std::string line;
  std::getline(file, line);  // names of the columns
  while (std::getline(file, line)) {
    std::istringstream row(line);
    std::vector<std::string> cells;
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    Sample s;
    s.kernel = parse_kernel(cells.at(0));
    const auto number = [&](std::size_t i) { return std::stoll(cells.at(i)); };
    const auto small = [&](std::size_t i) { return static_cast<std::int32_t>(number(i)); };
    s.shape = {small(1),  small(2),  small(8),
               small(9),  number(3), number(4),
               number(5), number(6), std::stoull(cells.at(7), nullptr, 16)};
    s.shape.one_program = s.shape.n == 2 || s.shape.n == 3;
    s.strategy = parse_strategy(cells.at(10));
    s.seconds = std::stod(cells.at(11));
    s.spread = std::stod(cells.at(12));
    s.repetitions = number(13);
    const double slowness = std::stod(cells.at(14));
    s = slowed(std::move(s), 1 / slowness);
    s.slowness = slowness;
    all.push_back(std::move(s));
  }
  return all;
}

// Shapes with different groups of one level.
std::vector<Shape> shapes_of_levels(const std::vector<Sample>& all) {
  std::map<std::tuple<std::int32_t, std::uint64_t, std::int64_t>, Shape> shapes;
  for (const Sample& s : all) {
    if (s.kernel == Kernel::pack && !s.strategy.run.together && s.shape.groups >= 8) {
      shapes.try_emplace({s.shape.n, s.shape.pattern, s.shape.terms}, s.shape);
    }
  }
  std::vector<Shape> out;
  for (const auto& [key, shape] : shapes) out.push_back(shape);
  return out;
}

TEST(SixteenCores, MoreGroupsNeverCostLess) {
  const std::vector<Sample> all = samples_of_16_cores();
  ASSERT_EQ(all.size(), 1295u);
  const PerformanceModel model(all);
  const std::vector<Shape> shapes = shapes_of_levels(all);
  ASSERT_GE(shapes.size(), 4u);
  for (Shape shape : shapes) {
    for (const char* backend : {"lanes", "eigen"}) {
      for (std::int32_t lanes = 1; lanes <= kMostLanes; lanes *= 2) {
        const Strategy s{.run = {}, .solver = {.backend = backend, .lanes = lanes}};
        double before = 0;
        for (const std::int32_t groups : {8, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512}) {
          shape.groups = groups;
          const double level = std::ceil(static_cast<double>(groups) / lanes) * model.pack(shape, s).seconds;
          EXPECT_GE(level, 0.98 * before) << to_string(s) << ", n = " << shape.n << ", " << groups << " groups";
          before = level;
        }
      }
    }
  }
}

// One thread is fast there while other cores idle, and half as fast while they work, whatever the pace of the machine.
TEST(SixteenCores, ThreadsSlowEachOtherDownAsMeasured) {
  const std::vector<Sample> all = samples_of_16_cores();
  std::map<std::int32_t, std::map<std::tuple<std::int32_t, std::int32_t, std::string>, double>> seconds;  // by p
  for (const Sample& s : all) {
    Strategy alone = s.strategy;
    alone.run.threads = 1;
    const std::set<std::int32_t> crowds = {84, 90, 96, 108};
    if (s.kernel == Kernel::pack && crowds.count(s.shape.groups) > 0) {
      seconds[s.strategy.run.threads][{s.shape.n, s.shape.groups, to_string(alone)}] = s.seconds;
    }
  }
  const PerformanceModel model(all);
  for (const std::int32_t p : {2, 4, 8, 16}) {
    std::map<std::int32_t, std::vector<double>> ratios;
    for (const auto& [key, time] : seconds.at(p)) {
      const auto alone = seconds.at(1).find(key);
      if (alone != seconds.at(1).end()) ratios[std::get<0>(key)].push_back(time / alone->second);
    }
    ASSERT_FALSE(ratios.empty());
    for (const auto& [n, of] : ratios) {
      const auto [least, most] = std::minmax_element(of.begin(), of.end());
      EXPECT_GE(model.contention(p, n), std::max(1.0, *least) - 1e-12) << p << " threads, n = " << n;
      EXPECT_LE(model.contention(p, n), *most + 1e-12) << p << " threads, n = " << n;
    }
  }
  // So 16 threads solve twelve packs in half the time of 8.
  const auto level = [&](std::int32_t p) {
    const std::int32_t packs = 12;
    return together((packs + p - 1) / p, packs, p, model.contention(p, 15));
  };
  EXPECT_GT(level(8) / level(16), 1.5);
}

}  // namespace
}  // namespace assur
