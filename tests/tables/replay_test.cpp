// Tapes: numbers that are computed again without the code that computed them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "assur/number.hpp"
#include "files/expression.hpp"
#include "numbers.hpp"
#include "tables/replay.hpp"

namespace assur {
namespace {

std::vector<Number> computed(const Number& a, const Number& b) {
  std::vector<Number> out = {a + b, a * b - 3, a / b, sqrt(a * a + b * b)};
  out.push_back(fma(a, b, Number(2)));
  out.push_back(-abs(a - b));
  out.push_back(hypot(a, b, Number(1)));
  out.push_back(atan2(a, b));
  out.push_back(ldexp(a, -3));
  out.push_back(out[0] * out[3]);
  out.push_back(a < b ? a : a - b);
  out.push_back(4);
  return out;
}

class Recorded {
 public:
  Recorded(double x, double y) {
    const Tape::Recording recording(&tape_);
    const Number a = tape_.parameter(x), b = tape_.parameter(y);
    wanted_ = computed(a, b);
    EXPECT_FALSE(tape_.has(wanted_.back()));  // 4 depends on nothing
    wanted_.pop_back();
    for (const Number& v : wanted_) EXPECT_TRUE(tape_.has(v));
  }
  [[nodiscard]] std::size_t count() const { return wanted_.size(); }
  [[nodiscard]] ParameterProgram program() { return tape_.program(wanted_); }

 private:
  ParameterTape tape_;
  std::vector<Number> wanted_;
};

TEST(Tape, RepeatsAComputation) {
  Recorded recorded(0.731234567890123, 1.91234567890123);
  std::mt19937_64 random(3);
  for (const std::size_t lanes : {1u, 4u, 5u, 8u, 16u}) {
    Replay replay(recorded.program(), lanes);
    for (int round = 0; round < 20; ++round) {
      std::vector<std::vector<double>> points(lanes);
      std::vector<const double*> pointers;
      for (auto& p : points) {
        p = {static_cast<double>(random() >> 11) * 0x1p-52, static_cast<double>(random() >> 11) * 0x1p-52 + 0.5};
        pointers.push_back(p.data());
      }
      replay.run(pointers);
      for (std::size_t l = 0; l < lanes; ++l) {
        const std::vector<Number> again = computed(points[l][0], points[l][1]);
        ASSERT_EQ(replay.holds(l), points[l][0] < points[l][1]);  // the recorded comparison had this outcome
        for (std::size_t i = 0; i < recorded.count() && replay.holds(l); ++i) {
          const bool is_rounded_otherwise = i == 6 || i == 7;  // the length, and the angle
          const double expected = again[i];
          EXPECT_NEAR(replay.wanted(i)[l], expected, is_rounded_otherwise ? 2 * kEps * std::abs(expected) : 0) << i;
        }
      }
    }
  }
}

TEST(Tape, DoesNotHoldForNumbersThatAreNotFinite) {
  Recorded recorded(0.731234567890123, 1.91234567890123);
  Replay replay(recorded.program(), 4);
  const double points[][2] = {{0.5, 1}, {0, 0}, {HUGE_VAL, 1}, {NAN, 1}};
  const double* const pointers[] = {points[0], points[1], points[2], points[3]};
  replay.run(pointers);
  EXPECT_TRUE(replay.holds(0));
  for (const std::size_t l : {1u, 2u, 3u}) EXPECT_FALSE(replay.holds(l)) << l;
}

TEST(Tape, RecordsNothingWhilePaused) {
  ParameterTape tape;
  const Tape::Recording recording(&tape);
  const Number a = tape.parameter(0.73);
  {
    const Tape::Recording none(nullptr);
    EXPECT_FALSE(tape.has(a + 1));
    EXPECT_EQ(double{a}, 0.73);
  }
  EXPECT_EQ(tape.lost(), "");
  EXPECT_TRUE(tape.has(a + 1));
}

// Numbers with equal values are told apart, and a number is none of another tape's.
TEST(Tape, KnowsNumbersByTheirOrigin) {
  ParameterTape tape, other;
  const Tape::Recording recording(&tape);
  const Number a = tape.parameter(1), b = tape.parameter(1), one = 1;
  EXPECT_FALSE(tape.has(one));
  EXPECT_FALSE(other.has(a));
  Replay replay(tape.program(std::vector{b, a}), 1);
  const double values[] = {5, 7};
  const double* const member = values;
  replay.run({&member, 1});
  EXPECT_EQ(replay.wanted(0)[0], 7);
  EXPECT_EQ(replay.wanted(1)[0], 5);
  const Tape::Recording second(&other);
  EXPECT_FALSE(other.has(a + b));
}

// What a conversion to double loses is noted; reading a value for a message is not.
TEST(Tape, NotesWhatIsLost) {
  ParameterTape tape;
  const Tape::Recording recording(&tape);
  const Number a = tape.parameter(2);
  EXPECT_EQ((a - a).value(), 0);
  EXPECT_EQ(double{Number(3)}, 3);
  EXPECT_EQ(tape.lost(), "");
  EXPECT_EQ(std::sin(a), std::sin(2.0));
  EXPECT_NE(tape.lost(), "");
  EXPECT_FALSE(tape.has(a * 0));  // it depends on nothing
}

// Formulas of formulas run in their order; those that nothing needs do not run.
TEST(Tape, RepeatsFormulasOfFormulas) {
  ParameterTape tape;
  const Tape::Recording recording(&tape);
  const Number a = tape.parameter(0.5);
  const Number one = tape.formula("x+1", {"x"}, std::vector{a * 2}, 2);
  const Number two = tape.formula("x*y", {"x", "y"}, std::vector{one, Number(3)}, 6);
  (void)tape.formula("x-1", {"x"}, std::vector{two}, 5);
  const ParameterProgram program = tape.program(std::vector{two + one});
  ASSERT_EQ(program.parts.size(), 3u);
  for (const std::size_t part : {0u, 1u}) EXPECT_EQ(program.parts[part].texts.size(), 1u);
  Replay replay(program, 2);
  const double values[] = {1, 4};
  const double* const members[] = {&values[0], &values[1]};
  replay.run(members);
  EXPECT_EQ(replay.wanted(0)[0], 12);
  EXPECT_EQ(replay.wanted(0)[1], 36);
}

// An expression of a scene gives the same bits with parameters as constants and as variables.
TEST(Tape, RepeatsExpressions) {
  const char* const texts[] = {"a+b*2",          "2*pi/3-a",       "a^2+b^3",    "sqrt(a^2+b^2-2*a*b*cos(0.3))",
                               "a*0.5+b*0.25-1", "sin(a)*(b-1)/3", "atan2(a,b)", "a>1 ? a : b",
                               "-a/b*b",         "3*a*2"};
  std::mt19937_64 random(9);
  for (const char* text : texts) {
    Formula formula(text, {"a", "b"});
    for (int round = 0; round < 50; ++round) {
      const double a = 2 * static_cast<double>(random() >> 11) * 0x1p-53,
                   b = 1 + static_cast<double>(random() >> 11) * 0x1p-53;
      Expressions expressions;
      ASSERT_TRUE(expressions.define({{"a", a}, {"b", b}}).empty());
      const double values[] = {a, b};
      EXPECT_EQ(formula(values), expressions.evaluate(text).value) << text;
    }
  }
}

}  // namespace
}  // namespace assur
