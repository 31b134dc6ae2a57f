#include "program/needs.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "samples/samples.hpp"

namespace assur {
namespace {

std::vector<Need> needs_in(const GroupedSystem& s) {
  const Needs needs = needs_of(s);
  std::vector<Need> found;
  for (int i = 0; i < kNeeds; ++i) {
    if (needs.has(static_cast<Need>(i))) found.push_back(static_cast<Need>(i));
  }
  return found;
}

// A crank and its rod, whose end is guided by another rod, or by a function of the program.
SceneBuilder crank(const Law& law, bool by_function) {
  SceneBuilder builder("crank", 2);
  builder.fixed_point("O", {0, 0}).point("A", {1, 0}).point("B", {3, 0});
  builder.constrain("rod", Distance{"A", "B"});
  builder.drive("motor", PointAngle{"O", "A", "", law});
  if (by_function) {
    builder.constrain("guide", Callback{{"A.y", "B.y"},
                                        1,
                                        [](auto x, auto phi) { phi[0] = x[1] - x[0] / 2; },
                                        [](auto, auto j) { j[0] = -0.5, j[1] = 1; },
                                        [](auto, auto, auto c) { c[0] = 0; }});
  } else {
    builder.fixed_point("C", {3, 2}).constrain("guide", Distance{"B", "C"});
  }
  return builder.output("B").time(0, 1, 0.1);
}

TEST(Needs, AreThoseOfTheScene) {
  const Law turn = Law::polynomial({0, 1}), function = Law::function([](double t) { return Motion{t, 1, 0}; });
  EXPECT_EQ(needs_in(group_equations(sample("stewart"))), std::vector<Need>{});
  EXPECT_EQ(needs_in(group_equations(crank(turn, false).build())), std::vector<Need>{});
  EXPECT_EQ(needs_in(group_equations(crank(function, false).build())), (std::vector{Need::functions_in_laws}));
  EXPECT_EQ(needs_in(group_equations(crank(turn, true).build())),
            (std::vector{Need::functions_in_equations, Need::proofs}));
  EXPECT_EQ(needs_in(group_equations(sample("bricard"))), (std::vector{Need::choices}));
  EXPECT_EQ(needs_in(group_equations(
                crank(turn, false).measure("reach", MeasuredDistance{"O", "B"}).limit("reach", 0, 9).build())),
            (std::vector{Need::limits}));
}

TEST(Needs, APathIsRefusedForTheFirstOneThatItDoesNotSupply) {
  EXPECT_EQ(why_not(Path::chunks, {}), "");
  EXPECT_EQ(why_not(Path::chunks, {Need::deadline, Need::limits}), "limits are followed from step to step");
  EXPECT_EQ(why_not(Path::chunks, {Need::choices}), "");
  EXPECT_EQ(why_not(Path::table, {Need::choices}), "the scene has redundant equations");
  EXPECT_FALSE(can_take(Path::together, Need::proofs));
  EXPECT_TRUE(can_take(Path::step_program, Need::proofs));
}

}  // namespace
}  // namespace assur
