#include "tuning/archive.hpp"

#include <gtest/gtest.h>

#include "parallel/file_tree.hpp"

namespace assur::tuning {
namespace {

CellResult cell_of(double seconds) {
  Sample s;
  s.kernel = Kernel::pack;
  s.shape = {.n = 15, .nnz = 48, .groups = 6, .terms = 129, .pattern = 7};
  s.strategy = parse_strategy("groups/eigen");
  s.seconds = seconds;
  CellResult cell;
  cell.results.emplace_back(std::move(s));
  return cell;
}

// So that the samples of all runs are at one pace.
TEST(Archive, LaterRunsGoByTheTimeOfTheFirst) {
  test::FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const Sample what = cell_of(1).results[0].sample;
  {
    Archive first(file, "quick");
    EXPECT_EQ(first.first_seconds(what.kernel, what.shape, what.strategy), std::nullopt);
    first.add(cell_of(3e-6));
    first.finish({}, "{}");
  }
  Archive second(file, "quick");
  second.add(cell_of(5e-6));
  EXPECT_EQ(second.first_seconds(what.kernel, what.shape, what.strategy), 3e-6);
  Shape other = what.shape;
  other.groups = 7;
  EXPECT_EQ(second.first_seconds(what.kernel, other, what.strategy), std::nullopt);
  EXPECT_EQ(second.first_seconds(Kernel::step, what.shape, what.strategy), std::nullopt);
  EXPECT_EQ(Archive(std::nullopt, "quick").first_seconds(what.kernel, what.shape, what.strategy), std::nullopt);
}

}  // namespace
}  // namespace assur::tuning
