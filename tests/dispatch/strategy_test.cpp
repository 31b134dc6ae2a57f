#include "assur/strategy.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "assur/status.hpp"

namespace assur {
namespace {

// All combinations of a few values for every field.
std::vector<Strategy> every_strategy() {
  using Kind = Predictor::Kind;
  std::vector<Predictor> predictors{{}, {Kind::hermite, 5}};
  for (int order = 0; order <= 2; ++order) predictors.push_back({Kind::taylor, order});
  for (int order = 0; order <= 5; ++order) predictors.push_back({Kind::past, order});
  std::vector<Strategy> all;
  for (Formulation formulation : {Formulation::global, Formulation::groups, Formulation::irreducible})
    for (const char* backend : {"eigen", "klu", "some_solver2"})
      for (int lanes : {1, 2, 4, 8, 16})
        for (int flags = 0; flags < 12; ++flags)
          for (Reuse reuse : {Reuse::fresh, Reuse::step, Reuse::run})
            for (const Predictor& predictor : predictors)
              for (int chunks : {1, 7})
                for (bool together : {false, true})
                  for (auto [p, q] : {std::pair{1, 1}, {3, 1}, {1, 2}, {16, 12}})
                    all.push_back({{formulation, together, predictor, chunks, p},
                                   {backend, lanes, (flags & 1) != 0, (flags & 2) != 0, reuse, flags / 4 == 1,
                                    flags / 4 == 2, q}});
  return all;
}

TEST(Strategy, RoundTripsInEveryCombination) {
  std::set<std::string> texts;
  const std::vector<Strategy> all = every_strategy();
  for (const Strategy& strategy : all) {
    const std::string text = to_string(strategy);
    ASSERT_EQ(parse_strategy(text), strategy) << text;
    ASSERT_EQ(to_string(parse_strategy(text)), text);
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), all.size());
}

TEST(Strategy, OmitsDefaults) {
  EXPECT_EQ(to_string(Strategy{}), "groups/eigen");
  EXPECT_EQ(to_string(parse_strategy("groups/lapack:1+chunks=1 1x1")), "groups/lapack");
}

TEST(Strategy, TakesOptionsInAnyOrderAndPrintsThemInOne) {
  EXPECT_EQ(to_string(parse_strategy("global/klu+chunks=4+predict=hermite:5+once+reuse=run+refine+float 2x3")),
            "global/klu+float+refine+reuse=run+once+predict=hermite:5+chunks=4 2x3");
}

TEST(Strategy, ReadsTheDocumentedExamples) {
  const Strategy a = parse_strategy("irreducible/lanes:8+once+predict=hermite:5");
  EXPECT_EQ(a.run.formulation, Formulation::irreducible);
  EXPECT_EQ(a.solver.backend, "lanes");
  EXPECT_EQ(a.solver.lanes, 8);
  EXPECT_TRUE(a.solver.once);
  EXPECT_EQ(a.run.predictor, (Predictor{Predictor::Kind::hermite, 5}));
  EXPECT_EQ(parse_strategy("groups/lapack 3x1").run.threads, 3);
  EXPECT_EQ(parse_strategy("global/klu 1x2").solver.threads, 2);
}

TEST(Strategy, NamesFormulations) {
  EXPECT_EQ(name(Formulation::global), "global");
  EXPECT_EQ(name(Formulation::groups), "groups");
  EXPECT_EQ(name(Formulation::irreducible), "irreducible");
}

struct BadText {
  const char* text;
  const char* what;
};
class BadStrategy : public testing::TestWithParam<BadText> {};

TEST_P(BadStrategy, IsRefusedWithItsErrorAndTheGrammar) {
  const auto& [text, what] = GetParam();
  const std::string expected =
      std::string("strategy \"") + text + "\": " + what +
      "; the form is global|groups|irreducible/BACKEND[:1|2|4|8|16][+float][+refine]"
      "[+reuse=step|run][+once|+separate][+together][+predict=taylor:0..2|hermite:5|past:0..5][+chunks=C] [PxQ]";
  try {
    (void)parse_strategy(text);
    FAIL() << "accepted " << text;
  } catch (const Error& error) {
    EXPECT_EQ(error.what(), expected);
    EXPECT_EQ(error.kind(), Error::Kind::input);
  }
}

constexpr const char* kNoPredictor =
    " is not a predictor: use taylor:0, taylor:1, taylor:2, hermite:5 or past:0 to past:5";
constexpr const char* kContradiction =
    "options \"once\" and \"separate\" contradict each other: one factorisation for a step, or one more";
const std::string kTaylor3 = std::string("\"taylor:3\"") + kNoPredictor;
const std::string kHermite = std::string("\"hermite\"") + kNoPredictor;
const std::string kHermite3 = std::string("\"hermite:3\"") + kNoPredictor;
const std::string kPast6 = std::string("\"past:6\"") + kNoPredictor;
const std::string kGuess = std::string("\"guess:1\"") + kNoPredictor;
const std::string kSigned = std::string("\"taylor:-1\"") + kNoPredictor;

INSTANTIATE_TEST_SUITE_P(
    Texts, BadStrategy,
    testing::Values(
        BadText{"", "\"\" is not a formulation: use global, groups or irreducible"},
        BadText{"klu", "\"klu\" is not a formulation: use global, groups or irreducible"},
        BadText{"Groups/klu", "\"Groups\" is not a formulation: use global, groups or irreducible"},
        BadText{" groups/klu", "\"\" is not a formulation: use global, groups or irreducible"},
        BadText{"groups", "\"/BACKEND\" is missing after \"groups\""},
        BadText{"groups/", "\"\" is not the name of a backend"},
        BadText{"groups/KLU", "\"KLU\" is not the name of a backend"},
        BadText{"groups/klu/x", "\"klu/x\" is not the name of a backend"},
        BadText{"groups/klu:", "\"\" is not a number of lanes: use 1, 2, 4, 8 or 16"},
        BadText{"groups/klu:0", "\"0\" is not a number of lanes: use 1, 2, 4, 8 or 16"},
        BadText{"groups/klu:3", "\"3\" is not a number of lanes: use 1, 2, 4, 8 or 16"},
        BadText{"groups/klu:32", "\"32\" is not a number of lanes: use 1, 2, 4, 8 or 16"},
        BadText{"groups/klu:08", "\"08\" is not a number of lanes: use 1, 2, 4, 8 or 16"},
        BadText{"groups/klu+fast",
                "\"fast\" is not an option: use float, refine, reuse, once, separate, together, predict or chunks"},
        BadText{"groups/klu+",
                "\"\" is not an option: use float, refine, reuse, once, separate, together, predict or chunks"},
        BadText{"groups/klu++once",
                "\"\" is not an option: use float, refine, reuse, once, separate, together, predict or chunks"},
        BadText{"groups/klu+once+once", "option \"once\" is given twice"},
        BadText{"groups/klu+reuse=run+reuse=step", "option \"reuse\" is given twice"},
        BadText{"groups/klu+separate=yes", "option \"separate\" takes no value"},
        BadText{"groups/klu+separate+once", kContradiction},
        BadText{"groups/klu+once+refine+separate 2x1", kContradiction},
        BadText{"groups/klu+once=yes", "option \"once\" takes no value"},
        BadText{"groups/klu+reuse", "option \"reuse\" needs a value"},
        BadText{"groups/klu+reuse=always", "\"always\" is not a kind of reuse: use step or run"},
        BadText{"groups/klu+predict", "option \"predict\" needs a value"},
        BadText{"groups/klu+predict=taylor:3", kTaylor3.c_str()},
        BadText{"groups/klu+predict=taylor:-1", kSigned.c_str()},
        BadText{"groups/klu+predict=hermite", kHermite.c_str()},
        BadText{"groups/klu+predict=hermite:3", kHermite3.c_str()},
        BadText{"groups/klu+predict=past:6", kPast6.c_str()}, BadText{"groups/klu+predict=guess:1", kGuess.c_str()},
        BadText{"groups/klu+chunks=0", "\"0\" is not a number of chunks: use 1 to 2147483647"},
        BadText{"groups/klu+chunks=9999999999", "\"9999999999\" is not a number of chunks: use 1 to 2147483647"},
        BadText{"groups/klu ", "\"\" is not a split PxQ of threads such as 1x1 or 3x2"},
        BadText{"groups/klu 2", "\"2\" is not a split PxQ of threads such as 1x1 or 3x2"},
        BadText{"groups/klu 0x1", "\"0x1\" is not a split PxQ of threads such as 1x1 or 3x2"},
        BadText{"groups/klu 1x-2", "\"1x-2\" is not a split PxQ of threads such as 1x1 or 3x2"},
        BadText{"groups/klu 2x1x1", "\"2x1x1\" is not a split PxQ of threads such as 1x1 or 3x2"},
        BadText{"groups/klu  2x1", "\" 2x1\" is not a split PxQ of threads such as 1x1 or 3x2"},
        BadText{"groups/klu 2x1+once", "\"2x1+once\" is not a split PxQ of threads such as 1x1 or 3x2"}));

}  // namespace
}  // namespace assur
