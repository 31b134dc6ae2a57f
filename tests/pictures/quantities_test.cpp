#include "pictures/quantities.hpp"

#include <gtest/gtest.h>

#include "assur/simulator.hpp"
#include "plan/preparation.hpp"

namespace assur::pictures {
namespace {

TEST(Quantities, HaveTheColumnsAndUnitsOfOutputs) {
  const Prepared prepared =
      prepare(sample("slider_crank").with_outputs({"rod_angle", "C.velocity", "slide.lambda", "rail", "B"}));
  const std::vector<std::string> columns = Simulator(prepared).columns();
  const auto all = quantities(prepared.structure());
  std::vector<std::string> said;
  std::size_t next = 0;
  for (const Quantity& q : all) {
    said.push_back(q.title + " [" + q.unit + "]");
    for (const std::size_t c : q.columns) {
      EXPECT_EQ(c, next++);
      EXPECT_EQ(columns[c].substr(0, q.output.size()), q.output);
    }
  }
  EXPECT_EQ(next, columns.size());
  EXPECT_EQ(said, (std::vector<std::string>{"rod_angle [rad]", "rod_angle, rate [rad/s]",
                                            "rod_angle, acceleration [rad/s²]", "C, velocity [m/s]", "slide.lambda [m]",
                                            "slide.lambda, rate [m/s]", "slide.lambda, acceleration [m/s²]", "rail []",
                                            "rail, velocity [1/s]", "rail, acceleration [1/s²]", "B [m]",
                                            "B, velocity [m/s]", "B, acceleration [m/s²]"}));
}

TEST(Quantities, ScalarsComeFirstIfEverythingIsAnOutput) {
  const auto all = quantities(prepare(sample("stewart")).structure());
  EXPECT_EQ(all[0].title, "handle1");
  EXPECT_EQ(all[17].output, "handle6");
  for (std::size_t i = 18; i < all.size(); ++i) EXPECT_EQ(all[i].columns.size(), 3u);
}

}  // namespace
}  // namespace assur::pictures
