#include "tuning/archive.hpp"

#include <gtest/gtest.h>

#include "parallel/file_tree.hpp"

namespace assur::tuning {
namespace {

CellResult cell_of(double seconds, double slowness) {
  Sample s;
  s.kernel = Kernel::pack;
  s.shape = {.n = 15, .nnz = 48, .groups = 6, .terms = 129, .pattern = 7};
  s.strategy = parse_strategy("groups/eigen");
  s.seconds = seconds;
  s.slowness = slowness;
  CellResult cell;
  cell.results.emplace_back(std::move(s));
  return cell;
}

// A first run on a disturbed machine takes twice the usual time for the usual pace.
TEST(Archive, AWrongFirstPaceDoesNotScaleLaterSamples) {
  test::FileTree tree;
  const auto file = tree.root() / "tuning.db";
  {
    Archive first(file, "quick");
    EXPECT_EQ(first.usual_pace(), std::nullopt);
    first.add(cell_of(6e-6, 0.5), 4e-6);  // 3 us by the clock
    EXPECT_EQ(first.usual_pace(), 2e-6);
    first.finish({}, "{}");
  }
  Archive second(file, "quick");
  EXPECT_EQ(second.usual_pace(), 2e-6);
  for (const double slowness : {1.0, 1.0, 1.5}) second.add(cell_of(3e-6, slowness), 2e-6);
  second.finish({}, "{}");
  for (const Sample& s : db::Store(file, db::Access::read).samples()) EXPECT_DOUBLE_EQ(s.seconds, 3e-6);
  EXPECT_EQ(second.usual_pace(), 2e-6);
  EXPECT_EQ(Archive(std::nullopt, "quick").usual_pace(), std::nullopt);
}

}  // namespace
}  // namespace assur::tuning
