// Motions agree with those that x86-64 computed, which are stored in tests/data/references/x86.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "errors/conditions.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

struct Stored {
  std::vector<std::string> columns;  // without the time
  std::vector<double> times;
  std::vector<std::vector<double>> rows;

  explicit Stored(const std::string& scene) {
    std::ifstream file(ASSUR_SOURCE_DIR "/tests/data/references/x86/" + scene + ".csv");
    std::string line, cell;
    std::getline(file, line);
    std::istringstream names(line);
    std::getline(names, cell, ',');
    while (std::getline(names, cell, ',')) columns.push_back(cell);
    while (std::getline(file, line)) {
      std::istringstream numbers(line);
      std::getline(numbers, cell, ',');
      times.push_back(std::strtod(cell.c_str(), nullptr));
      auto& row = rows.emplace_back();
      while (std::getline(numbers, cell, ',')) row.push_back(std::strtod(cell.c_str(), nullptr));
    }
  }
};

class OtherMachines : public testing::TestWithParam<std::string> {};

// Two runs differ by at most twice the uncertainty that their residuals leave (docs/strategies.md).
TEST_P(OtherMachines, ComputeTheMotionOfX86) {
  const Stored stored(GetParam());
  ASSERT_EQ(stored.times.size(), 21u);
  const double step = stored.times[1];
  const Scene scene = open_scene(GetParam()).with_outputs(stored.columns).with_time({0, 20 * step, step});
  const std::vector<test::Condition> conditions = test::both_conditions(scene, stored.times);
  ASSERT_EQ(conditions.size(), stored.times.size());
  for (const std::string strategy : {"groups/eigen", "irreducible/lanes:8", "irreducible/lanes:4+once", "auto"}) {
    SCOPED_TRACE(strategy);
    const test::Result r = test::run(scene, strategy);
    ASSERT_EQ(r.report().status.code, Code::ok);
    ASSERT_EQ(r.trajectory.columns(), stored.columns);
    ASSERT_EQ(r.trajectory.rows(), stored.rows.size());
    const double residual = test::residual_of(r.report(), r.report());
    EXPECT_LE(residual, 1e-14);
    const test::Sizes sizes = test::sizes(r.trajectory);
    for (std::size_t k = 0; k < stored.rows.size(); ++k) {
      test::expect_same_row(stored.rows[k], r.trajectory, k, sizes, conditions[k].own, residual);
      if (HasFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, OtherMachines,
                         testing::Values("andrews", "bennett", "delta", "four_bar", "jansen", "slider_crank",
                                         "stewart"),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace assur
