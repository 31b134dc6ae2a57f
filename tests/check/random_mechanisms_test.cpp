// Random mechanisms, modelled as by users, compared with independent plain equations. ASSUR_RANDOM_SCENES sets their
// number, ASSUR_RANDOM_SEED the first seed. A failure prints the seed, the fault and the scene.
#include <gtest/gtest.h>

#include <iostream>
#include <map>
#include <string>

#include "check/trial.hpp"
#include "properties/random_count.hpp"
#include "source_dir.hpp"

namespace assur::check {
namespace {

using mechanisms::random_mechanism;
using mechanisms::RandomMechanism;
using Verdict = Trial::Verdict;

std::string told(const RandomMechanism& m, const Trial& t) {
  std::string text = "seed " + std::to_string(m.seed) + ", " + m.family + ", " + m.how.strategy +
                     (m.commands.empty() ? "" : ", control") + ": " + name(t.verdict) + ": " + t.what + "\n" + m.json;
  for (std::size_t i = 0; i < m.controlled.size(); ++i) text += (i == 0 ? "\n" : ",") + m.controlled[i];
  for (const std::vector<double>& command : m.commands) {
    text += '\n';
    for (std::size_t i = 0; i < command.size(); ++i) text += (i == 0 ? "" : ",") + testing::PrintToString(command[i]);
  }
  return text;
}

TEST(RandomMechanisms, NoneIsWrongWithACleanStatus) {
  const int count = test::random_count(25);
  std::map<std::string, int> verdicts;
  int refused = 0, estimates = 0, exceeded = 0;
  for (std::uint64_t seed = test::first_seed(), end = seed + static_cast<std::uint64_t>(count); seed != end; ++seed) {
    const RandomMechanism m = random_mechanism(seed, ASSUR_SOURCE_DIR "/tests/data/tables");
    const Trial t = try_out(m);
    ++verdicts[name(t.verdict)];
    for (std::size_t d = 0; d < 3 && t.verdict == Verdict::agrees && t.rows > 0; ++d) {
      if (!t.error[d] || !t.estimated[d]) continue;
      ++estimates;
      exceeded += *t.error[d] > 3 * *t.estimated[d] ? 1 : 0;
    }
    if (t.verdict == Verdict::refused) {
      ++refused;
      std::cout << told(m, t) << '\n';
    }
    EXPECT_LT(t.verdict, Verdict::wrong_start) << told(m, t);
  }
  for (const auto& [verdict, n] : verdicts) std::cout << verdict << ": " << n << '\n';
  std::cout << exceeded << " of " << estimates << " estimates exceeded by more than 3\n";
  EXPECT_LE(refused, std::max(1, count / 1000));
  EXPECT_LE(exceeded, std::max(1, estimates / 100));
}

// These seeds are from searches among tens of thousands, one or two for each kind of fault.
TEST(RandomMechanisms, FormerlyWrongOnesStayRight) {
  for (const std::uint64_t seed :
       {492, 1163, 1792, 5583, 6622, 101955, 103855, 697, 2303, 103555, 3393, 34198, 63226}) {
    const RandomMechanism m = random_mechanism(seed, ASSUR_SOURCE_DIR "/tests/data/tables");
    const Trial t = try_out(m);
    EXPECT_LT(t.verdict, Verdict::refused) << told(m, t);
  }
}

// The plain equations confirm the right motion and reject a wrong one.
TEST(RandomMechanisms, PlainEquationsFollowAFourBar) {
  RandomMechanism m;
  m.family = "four_bar";
  m.tables = ".";
  m.how.budget = ThreadBudget{1};
  m.json = R"({"assur": 1, "name": "four_bar", "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true}, "B": {"at": [0.8, 0]},
               "C": {"at": [1.6, 1.2]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": 1.8}, "rocker": {"distance": ["D", "C"], "value": 1.3}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 6.283185307179586]}}},
    "measures": {"r": {"angle": ["D", "C"]}}, "time": {"start": 0, "end": 1, "step": 0.01}})";
  const Trial t = try_out(m);
  EXPECT_EQ(t.verdict, Verdict::agrees) << t.what;
  EXPECT_EQ(t.rows, 100);
  // Both are right up to rounding errors times the condition of the loop, 1 / sin of its transmission angle.
  ASSERT_TRUE(t.error[0] && t.error[2]);
  EXPECT_GT(*t.error[2], 0);
  EXPECT_LT(*t.error[0], 1e-14);
  EXPECT_LT(*t.error[2], 1e-12);
}

}  // namespace
}  // namespace assur::check
