// The heat maps of the fastest strategies, by operation counts and for an artificial machine.
#include <gtest/gtest.h>

#include "report/sections.hpp"

namespace assur::report {
namespace {

Knowledge nothing_known() {
  Knowledge k;
  k.known.model = std::make_shared<PerformanceModel>();
  return k;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

TEST(Winners, NameThePriorWithoutSamples) {
  Conditions conditions;
  conditions.quick = true;
  const Section s = winners(nothing_known(), conditions);
  EXPECT_NE(s.body.find("come from the prior"), std::string::npos);
  EXPECT_GT(s.measurements.size(), 50u);
  for (const Measurement& m : s.measurements) {
    EXPECT_GT(m.value, 0);
    EXPECT_EQ(m.repetitions, 0);
    EXPECT_EQ(m.origin.rfind("predicted, prior", 0), 0u) << m.origin;
  }
  // Each measurement is a cell in the wide and in the narrow picture.
  EXPECT_GE(count(s.body, "<rect"), 2 * s.measurements.size());
  EXPECT_EQ(count(s.body, "class=\"measured\""), 2u) << "dots where nothing was measured, beyond those of the legends";
}

TEST(Winners, ListMeasuredCrossovers) {
  Conditions conditions;
  conditions.quick = true;
  Knowledge k = nothing_known();
  k.tuning.emplace();
  k.tuning->crossovers.columns = {"kernel", "dense", "n_before", "n", "strategy_before", "strategy"};
  for (const std::int64_t dense : {0, 1}) {
    k.tuning->crossovers.rows.push_back({std::string("factor+3solve"), dense, std::int64_t{125}, 144 + dense,
                                         std::string("groups/lanes:16"), std::string("groups/lapack")});
  }
  const Section s = winners(k, conditions);
  EXPECT_NE(s.body.find("lanes:16 up to 125, lapack from 145."), std::string::npos);
  EXPECT_EQ(s.body.find("lapack from 144"), std::string::npos) << "sparse and full ones are not of one list";
}

}  // namespace
}  // namespace assur::report
