// The suite finds wrong mechanisms and wrong expectations.
#include "check/runner.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "check/twin.hpp"
#include "check/yardstick.hpp"
#include "equations/system.hpp"
#include "plan/preparation.hpp"

namespace assur::check {
namespace {

Case case_of(const std::string& text, Expected expected) {
  Case c;
  c.family = "test";
  c.name = c.text = text;
  c.strategies = {"groups/eigen", "irreducible/lanes"};
  c.expected = std::move(expected);
  return c;
}

TEST(Runner, PassesRunsThatEndAsExpected) {
  const Result r = run(case_of("slider_crank:steps=100,step=0.01", {{"pass"}, ""}));
  EXPECT_TRUE(r.passed());
  EXPECT_EQ(r.verdict, "pass");
  EXPECT_EQ(r.runs, 2);
  ASSERT_TRUE(r.forward_error && r.backward_error && r.condition && r.bound);
  EXPECT_GT(*r.forward_error, 0);
  EXPECT_LE(*r.forward_error, *r.bound);  // eps kappa^2 for a regular run
  EXPECT_LE(*r.backward_error, 1e-14);
  // Bound: with rod 0.3 and crank 0.1, one coordinate has terms of up to 0.4 (0.3 + 0.1) 4 over pivots of at least 2
  // sqrt(0.08).
  EXPECT_GE(*r.condition, 1);
  EXPECT_LE(*r.condition, 10);
}

TEST(Runner, FindsAWrongExpectation) {
  const Result r = run(case_of("slider_crank:steps=10", {{"fold", "refused"}, ""}));
  EXPECT_FALSE(r.passed());
  EXPECT_EQ(r.verdict, "pass");
  ASSERT_EQ(r.unexpected.size(), 2u);
  EXPECT_EQ(r.unexpected[0].strategy, "groups/eigen");
}

TEST(Runner, FindsAnUnexpectedFold) {
  const Result r = run(case_of("slider_crank:crank_length=0.3,rod_length=0.2", {{"pass"}, ""}));
  EXPECT_FALSE(r.passed());
  EXPECT_EQ(r.verdict, "fold");
}

// The run is clean, but it is compared with the closed form of parallelograms twice as wide as its rhombi.
TEST(Runner, FindsACleanRunThatIsWrong) {
  Case c = case_of("n_four_bar:loops=2,steps=20", {{"pass"}, ""});
  EXPECT_TRUE(run(c).passed());
  c.closed_form = "n_four_bar";
  EXPECT_TRUE(run(c).passed());
  c.closed_form = "parallelograms";
  const Result r = run(c);
  EXPECT_FALSE(r.passed());
  EXPECT_EQ(r.verdict, "wrong");
  EXPECT_NE(r.unexpected.at(0).message.find("pass, but"), std::string::npos) << r.unexpected[0].message;
}

TEST(Runner, FindsErrorsAboveTheRequiredAccuracy) {
  Case c = case_of("slider_crank:steps=10", {{"pass"}, ""});
  c.accuracy = 1e-19;
  const Result r = run(c);
  EXPECT_FALSE(r.passed());
  EXPECT_NE(r.verdict, "pass");
}

TEST(Runner, TellsRefusalsApartByTheirMessage) {
  const std::string text = "andrews:xb=0.03635";
  EXPECT_TRUE(run(case_of(text, {{"refused"}, "cannot be assembled"})).passed());
  const Result r = run(case_of(text, {{"refused"}, "undetermined"}));
  EXPECT_FALSE(r.passed());
  EXPECT_EQ(r.verdict, "refused");
}

TEST(Runner, ComparesStrategiesForScenesOfTheUser) {
  EXPECT_EQ(run(case_of("slider_crank:steps=10", {})).verdict, "pass");
  const Result fold = run(case_of("slider_crank:crank_length=0.3,rod_length=0.2", {}));
  EXPECT_TRUE(fold.passed());
  EXPECT_EQ(fold.verdict, "fold");
}

TEST(Runner, LeavesOutStrategiesThatCannotRunAndNotesIt) {
  Case c = case_of("slider_crank:steps=10", {{"pass"}, ""});
  c.strategies.emplace_back("groups/klu+float");
  const Result r = run(c);
  EXPECT_TRUE(r.passed());
  EXPECT_EQ(r.runs, 2);
  ASSERT_EQ(r.left_out.size(), 1u);
  EXPECT_EQ(r.left_out.begin()->rfind("klu: ", 0), 0u) << *r.left_out.begin();
}

TEST(Runner, RunsEveryBackendAndPolicy) {
  Case c = case_of("slider_crank:steps=5", {{"pass"}, ""});
  c.strategies.clear();
  const Result all = run(c), quick = run(c, {.quick = true, .stop = [] { return false; }});
  EXPECT_TRUE(all.passed());
  EXPECT_TRUE(quick.passed());
  std::int64_t least = 0;
  for (const Backend& backend : backends()) {
    if (backend.why_not(Shape{}, ThreadBudget{1}).empty()) least += backend.single ? 10 : 5;
  }
  constexpr std::int64_t kTogether = 2;              // +together, in the formulations groups and irreducible
  EXPECT_EQ(all.runs, 3 * (least + 7) + kTogether);  // 3 formulations; 7 predictors with one backend
  EXPECT_LT(quick.runs, all.runs / 2);
}

TEST(Runner, StopsWhenAsked) {
  int asked = 0;
  const Result r =
      run(case_of("slider_crank", {{"pass"}, ""}), {.quick = false, .stop = [&asked] { return ++asked > 5; }});
  EXPECT_TRUE(r.interrupted);
}

TEST(Runner, FindsATwinThatDiffersInBits) {
  Case c = case_of("", {{"pass"}, ""});
  c.scene = R"({"assur": 1, "dimension": 2, "parameters": {"unit": 2},
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": ["=2*unit", 0], "fixed": true},
               "B": {"at": ["=0.8*unit", 0]}, "C": {"at": ["=1.6*unit", "=1.2*unit"]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": "=1.8*unit"},
                    "rocker": {"distance": ["D", "C"], "value": "=1.3*unit"}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}}},
    "time": {"start": 0, "end": 1, "step": 0.1}})";
  c.twin = {{"unit", 1}};
  EXPECT_TRUE(run(c).passed());
  c.twin = {{"unit", 3}};
  EXPECT_EQ(run(c).verdict, "other_bits");
}

// The errors of the suite agree with forward_error() of the library.
TEST(Yardstick, AgreesWithForwardError) {
  for (const char* text : {"slider_crank:offset=0.02,steps=50,step=0.02", "stewart:steps=20", "bricard:steps=50",
                           "whitworth:steps=50", "almost_parallelogram:delta=1e-6"}) {
    SCOPED_TRACE(text);
    const Prepared prepared = prepare(sample(text), {.strategy = "groups/eigen+once"});
    std::unique_ptr<TrueMotion> motion = reference_motion(prepared);
    if (!motion) GTEST_SKIP() << "no quad precision in this build";
    Yardstick yardstick(prepared, std::move(motion));
    Simulator simulator(prepared);
    const Trajectory trajectory = simulator.run();
    const ForwardError expected = forward_error(prepared, trajectory);
    const double worst = std::max({expected.position, expected.velocity, expected.acceleration});
    // Rows of the reference are stored in doubles.
    EXPECT_NEAR(yardstick.forward_error(trajectory, trajectory.rows()), worst, 1e-3 * worst + 1e-18);
  }
}

// Rows that a run reports as inaccurate count neither for errors nor for the size of the outputs.
TEST(Yardstick, LeavesOutRowsThatDoNotCount) {
  const Prepared prepared = prepare(sample("n_four_bar:loops=1,steps=20").with_outputs({"B1"}));
  Simulator simulator(prepared);
  const Trajectory trajectory = simulator.run();
  const auto shifted_from = [&](double t0) {
    return [&prepared, t0](const std::string& output, double t) {
      auto at = closed_form("n_four_bar", *prepared.scene())(output, t);
      if (t > t0) (*at)[0].value += 1e-3L;
      return at;
    };
  };
  Yardstick yardstick(prepared, known_motion(prepared, shifted_from(0.105)));
  // B1 is farthest from the origin at the start, at (1, 1).
  const double size = std::max(1.0, preparation(prepared).structure->system->unit(1));
  EXPECT_NEAR(yardstick.forward_error(trajectory, trajectory.rows()), 1e-3 / size, 1e-12);
  EXPECT_LE(yardstick.forward_error(trajectory, trajectory.rows(), [](std::size_t row) { return row < 11; }), 1e-14);
  EXPECT_LE(yardstick.forward_error(trajectory, 11), 1e-14);
}

TEST(Yardstick, IsNotCalledAgainAfterAFailure) {
  class Lost final : public TrueMotion {
   public:
    explicit Lost(int& asked) : asked_(asked) {}
    std::vector<long double> row(std::size_t, double) override {
      ++asked_;
      throw Error(Error::Kind::numerical, "lost");
    }

   private:
    int& asked_;
  };
  const Prepared prepared = prepare(sample("slider_crank:steps=5"));
  const Trajectory trajectory = Simulator(prepared).run();
  int asked = 0;
  Yardstick yardstick(prepared, std::make_unique<Lost>(asked));
  for (int i = 0; i < 3; ++i) EXPECT_THROW((void)yardstick.forward_error(trajectory, 2), Error);
  EXPECT_EQ(asked, 1);
}

TEST(Yardstick, UnknownTruthHasInfiniteError) {
  const Prepared prepared = prepare(sample("slider_crank:steps=5"));
  Simulator simulator(prepared);
  const Trajectory trajectory = simulator.run();
  Yardstick unknown(prepared, known_motion(prepared, [](const std::string&, double) { return std::nullopt; }));
  EXPECT_EQ(unknown.forward_error(trajectory, trajectory.rows()), HUGE_VAL);
  Yardstick itself(prepared, agreed_motion(trajectory));
  EXPECT_EQ(itself.forward_error(trajectory, trajectory.rows()), 0);
}

}  // namespace
}  // namespace assur::check
