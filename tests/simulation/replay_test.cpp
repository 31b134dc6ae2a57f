// Tapes: numbers that are computed again without the code that computed them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "numbers.hpp"
#include "scene/expression.hpp"
#include "scene/number.hpp"
#include "side_by_side/replay.hpp"

namespace assur {
namespace {

// A computation in Numbers that passes some of its results through plain doubles.
std::vector<double> computed(double x, double y) {
  const Number a = x, b = y;
  std::vector<double> out = {(a + b).value(), (a * b - 3).value(), (a / b).value(), sqrt(a * a + b * b).value()};
  out.push_back(fma(a, b, 2).value());
  out.push_back((-abs(a - b)).value());
  out.push_back(hypot(a, b, 1).value());
  out.push_back(atan2(a, b).value());
  out.push_back(ldexp(a, -3).value());
  out.push_back((Number(out[0]) * Number(out[3])).value());  // found by their bits
  out.push_back(a < b ? x : (a - b).value());
  out.push_back(4);
  return out;
}

class Recorded {
 public:
  Recorded(double x, double y) : tape_(std::vector{x, y}) {
    const Tape::Recording recording(&tape_);
    for (const double v : computed(x, y)) nodes_.push_back(tape_.find(v));
  }
  [[nodiscard]] const std::vector<Tape::Node>& nodes() const { return nodes_; }
  [[nodiscard]] Tape& tape() { return tape_; }

 private:
  Tape tape_;
  std::vector<Tape::Node> nodes_;
};

TEST(Tape, RepeatsAComputation) {
  Recorded recorded(0.731234567890123, 1.91234567890123);
  ASSERT_EQ(recorded.nodes().back(), Tape::kNone);  // 4 depends on nothing
  std::vector<Tape::Node> wanted(recorded.nodes().begin(), recorded.nodes().end() - 1);
  for (const Tape::Node n : wanted) ASSERT_NE(n, Tape::kNone);
  std::mt19937_64 random(3);
  for (const std::size_t lanes : {1u, 4u, 5u, 8u, 16u}) {
    Replay replay(recorded.tape(), wanted, lanes);
    for (int round = 0; round < 20; ++round) {
      std::vector<std::vector<double>> points(lanes);
      std::vector<const double*> pointers;
      for (auto& p : points) {
        p = {static_cast<double>(random() >> 11) * 0x1p-52, static_cast<double>(random() >> 11) * 0x1p-52 + 0.5};
        pointers.push_back(p.data());
      }
      replay.run(pointers);
      for (std::size_t l = 0; l < lanes; ++l) {
        const std::vector<double> again = computed(points[l][0], points[l][1]);
        ASSERT_EQ(replay.holds(l), points[l][0] < points[l][1]);  // the recorded comparison had this outcome
        for (std::size_t i = 0; i < wanted.size() && replay.holds(l); ++i) {
          const bool is_rounded_otherwise = i == 6 || i == 7;  // the length, and the angle
          EXPECT_NEAR(replay.wanted(i)[l], again[i], is_rounded_otherwise ? 2 * kEps * std::abs(again[i]) : 0) << i;
        }
      }
    }
  }
}

TEST(Tape, DoesNotHoldForNumbersThatAreNotFinite) {
  Recorded recorded(0.731234567890123, 1.91234567890123);
  Replay replay(recorded.tape(), {recorded.nodes().begin(), recorded.nodes().end() - 1}, 4);
  const double points[][2] = {{0.5, 1}, {0, 0}, {HUGE_VAL, 1}, {NAN, 1}};
  const double* const pointers[] = {points[0], points[1], points[2], points[3]};
  replay.run(pointers);
  EXPECT_TRUE(replay.holds(0));
  for (const std::size_t l : {1u, 2u, 3u}) EXPECT_FALSE(replay.holds(l)) << l;
}

TEST(Tape, RecordsNothingWhilePaused) {
  Tape tape(std::vector{0.731234567890123});
  const Tape::Recording recording(&tape);
  const auto before = tape.operations().size();
  {
    const Tape::Recording none(nullptr);
    EXPECT_EQ((Number(0.731234567890123) + 1).node(), Tape::kNone);
  }
  EXPECT_EQ(tape.operations().size(), before);
  EXPECT_NE((Number(0.731234567890123) + 1).node(), Tape::kNone);
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
