// Measured angles follow the posture through whole turns, for every step, mode and set of outputs.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "assur/ensemble.hpp"
#include "numbers.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {
// A wrong angle is wrong by whole turns; all other errors are far smaller, sqrt(eps) at a fold.
constexpr double kNoTurn = 1e-6;
constexpr double kFine = 2e-3;  // rad of the crank between two postures of the closed form

struct FourBar {
  double crank, coupler, rocker, ground;
  double side = 1;         // 1: C lies to the left of the line from B to D, -1: to the right
  Triple tracer{0, 0, 0};  // P in the frame of the coupler: along BC, and to the left of BC
  Triple post{0, 0, 0};    // F, the point from which P is seen

  // Computes B, C, P; false if there is no posture.
  bool at(double phi, Triple& b, Triple& c, Triple& p) const {
    b = {crank * std::cos(phi), crank * std::sin(phi), 0};
    const double dx = ground - b[0], dy = -b[1], length = std::hypot(dx, dy);
    const double along = (coupler * coupler - rocker * rocker + length * length) / (2 * length);
    const double square = coupler * coupler - along * along;
    if (!(square > 0)) return false;
    const double across = side * std::sqrt(square);
    c = {b[0] + (along * dx - across * dy) / length, b[1] + (along * dy + across * dx) / length, 0};
    const double ex = (c[0] - b[0]) / coupler, ey = (c[1] - b[1]) / coupler;
    p = {b[0] + tracer[0] * ex - tracer[1] * ey, b[1] + tracer[0] * ey + tracer[1] * ex, 0};
    return true;
  }
};

const FourBar kCrankRocker = {1, 2.2, 1.4, 2, 1, {1, 0.4, 0}, {0.3, 2.5, 0}};

const std::vector<std::string> kAngles = {"rocker", "transmission", "tracer", "crank"};
using Angles = std::array<double, 4>;

// The true angle, followed along the crank in small steps.
class Truth {
 public:
  Truth(const FourBar& m, double phi) : m_(m), phi_(phi) { valid_ = step(phi); }

  // Moves to this crank angle; false beyond a limit.
  bool go(double phi) {
    const int pieces = static_cast<int>(std::abs(phi - phi_) / kFine) + 1;
    const double from = phi_;
    for (int k = 1; k <= pieces && valid_; ++k) valid_ = step(from + (phi - from) * k / pieces);
    phi_ = phi;
    return valid_;
  }
  [[nodiscard]] double operator[](const std::string& column) const {
    for (std::size_t i = 0; i < kAngles.size(); ++i) {
      if (column == kAngles[i]) return angles_[i];
    }
    return std::nan("");
  }

 private:
  bool step(double phi) {
    Triple b, c, p;
    if (!m_.at(phi, b, c, p)) return false;
    const Triple d = {-b[0], -b[1], 0}, e = {c[0] - b[0], c[1] - b[1], 0};
    const Angles now = {std::atan2(c[1], c[0] - m_.ground),
                        std::atan2(d[0] * e[1] - d[1] * e[0], d[0] * e[0] + d[1] * e[1]),
                        std::atan2(p[1] - m_.post[1], p[0] - m_.post[0]), std::atan2(b[1], b[0])};
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double turns = first_ ? 0 : std::round((angles_[i] - now[i]) / kTurn);
      angles_[i] = now[i] + kTurn * turns;
    }
    first_ = false;
    return true;
  }

  const FourBar& m_;
  double phi_;
  bool valid_ = false, first_ = true;
  Angles angles_{};
};

Scene scene(const FourBar& m, const Law& law, double step, int steps, const std::vector<std::string>& outputs = {}) {
  Triple b, c, p;
  EXPECT_TRUE(m.at(law(0).value, b, c, p));
  SceneBuilder builder("four_bar", 2);
  builder.fixed_point("A", {0, 0, 0}).fixed_point("D", {m.ground, 0, 0}).fixed_point("F", m.post);
  builder.point("B", b).point("C", c).point("P", p);
  builder.constrain("BC", Distance{"B", "C", m.coupler}).constrain("CD", Distance{"C", "D", m.rocker});
  const double x = m.tracer[0], y = m.tracer[1];
  builder.constrain("BP", Distance{"B", "P", std::hypot(x, y)});
  builder.constrain("CP", Distance{"C", "P", std::hypot(x - m.coupler, y)});
  builder.drive("motor", PointAngle{"A", "B", "", law});
  builder.measure("rocker", AbsoluteAngle{"D", "C"}).measure("tracer", AbsoluteAngle{"F", "P"});
  builder.measure("crank", AbsoluteAngle{"A", "B"});
  builder.measure("transmission", AngleBetween{Direction("B", "A"), Direction("B", "C"), ""});
  for (const std::string& o : outputs) builder.output(o);
  return builder.time(0, step * steps, step).build();
}

const std::vector<std::vector<std::string>> kSubsets = {
    {},
    {"rocker"},
    {"rocker.value"},
    {"rocker.rate"},
    {"tracer.value", "crank.value"},
    {"rocker.value", "transmission.value", "tracer.value", "crank.value", "P.velocity"},
    {"tracer.value", "tracer.acceleration"}};

// Every mode and subset of outputs agrees with the closed form, and ends at the same time.
void expect_the_closed_form(const FourBar& m, const Law& law, double step, int steps) {
  std::vector<Truth> truth{Truth(m, law(0).value)};
  for (int k = 1; k <= steps; ++k) {
    Truth next = truth.back();
    if (!next.go(law(k * step).value)) break;
    truth.push_back(next);
  }
  const auto compare = [&](const std::vector<std::string>& columns, std::size_t rows, const auto& value) {
    ASSERT_EQ(rows, truth.size());
    for (std::size_t k = 0; k < rows; ++k) {
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const double expected = truth[k][columns[c]];
        if (std::isnan(expected)) continue;
        ASSERT_NEAR(value(k, c), expected, kNoTurn) << columns[c] << " in row " << k;
      }
    }
  };
  for (std::size_t i = 0; i < kSubsets.size(); ++i) {
    SCOPED_TRACE("outputs " + std::to_string(i));
    for (const std::string strategy : {"groups/eigen", "groups/eigen:4+chunks=3"}) {
      SCOPED_TRACE(strategy);
      const test::Result r = test::run(scene(m, law, step, steps, kSubsets[i]), strategy);
      const Trajectory& t = r.trajectory;
      compare(t.columns(), t.rows(), [&](std::size_t k, std::size_t c) { return t(k, c); });
      if (testing::Test::HasFatalFailure()) return;
      if (t.rows() <= static_cast<std::size_t>(steps)) continue;
      for (std::size_t c = 0; c < t.columns().size(); ++c) EXPECT_EQ(r.simulator.outputs()[c], t(t.rows() - 1, c));
    }
  }
  SCOPED_TRACE("ensemble");
  Ensemble ensemble(3, [&](std::size_t i) {
    FourBar of = m;
    of.coupler *= 1 + 0.01 * static_cast<double>(i);
    return prepare(scene(of, law, step, steps, {"rocker", "tracer.value"}), {"groups/eigen:4"});
  });
  const EnsembleTrajectory all = ensemble.run();
  compare(all.columns(), all.rows(0), [&](std::size_t k, std::size_t c) { return all(0, k, c); });
}

TEST(AngleTurns, AreRightForARockerWithLargeSteps) {
  const Law swings = Law::polynomial({0.97}) + Law::harmonics({{1.5, 2, 0}});
  expect_the_closed_form({1, 1.9, 1.1, 2, 1, {1, 0.4, 0}, {0.3, 2.5, 0}}, swings, 0.2, 20);
  expect_the_closed_form(kCrankRocker, Law::polynomial({0.97, 18}), 0.2, 20);
  expect_the_closed_form(kCrankRocker, Law::polynomial({0.97, -18, 7}), 0.2, 20);
}

TEST(AngleTurns, AreRightForAFollowerThatTurnsWithItsCrank) {
  const FourBar double_crank{1.5, 1.4, 1.6, 0.6, 1, {0.7, 0.9, 0}, {0.2, 0.3, 0}};
  expect_the_closed_form(double_crank, Law::polynomial({0.3, 1}), 0.9, 30);
  expect_the_closed_form(double_crank, Law::polynomial({0.3, -7}), 0.9, 30);
}

TEST(AngleTurns, AreRightForAPointSeenFromNearby) {
  const Law law = Law::polynomial({0.3, 1});
  for (const double t : {2.03, 3.7, 5.01}) {
    for (const double apart : {1e-2, -1e-2, 1e-5, -1e-5}) {
      FourBar m = kCrankRocker;
      Triple b, c, p, q;
      ASSERT_TRUE(m.at(law(t).value, b, c, p) && m.at(law(t).value + 1e-4, b, c, q));
      const double dx = q[0] - p[0], dy = q[1] - p[1], along = std::hypot(dx, dy);
      m.post = {p[0] - apart * dy / along, p[1] + apart * dx / along, 0};
      // The closed form does not resolve the passage. Past a straight line the angle turns by less than half a turn.
      const test::Result r = test::run(scene(m, law, 0.1, 60, {"tracer.value"}), "groups/eigen");
      ASSERT_EQ(r.trajectory.rows(), 61U);
      const auto row = static_cast<std::size_t>(t * 10);
      const double turned = r.trajectory(row + 1, 0) - r.trajectory(row, 0);
      EXPECT_EQ(std::signbit(turned), apart < 0) << t << " " << apart;
      EXPECT_GT(std::abs(turned), 1);
      EXPECT_LT(std::abs(turned), kTurn / 2 + 0.5);  // the path of P is bent
    }
  }
}

TEST(AngleTurns, AreRightForRandomFourBarsAtCoarseSteps) {
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const auto draw = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    FourBar m{};
    Triple b, c, p;
    double phi = 0;
    const auto grashof = [&] {
      const double sum = m.crank + m.coupler + m.rocker + m.ground;
      const double shortest = std::min({m.crank, m.coupler, m.rocker, m.ground});
      const double longest = std::max({m.crank, m.coupler, m.rocker, m.ground});
      return shortest + longest < 0.49 * sum && (shortest == m.crank || shortest == m.ground) && m.at(phi, b, c, p);
    };
    do {
      m = {draw(0.3, 2),
           draw(0.3, 2.5),
           draw(0.3, 2.5),
           draw(0.3, 2.5),
           draw(0, 1) < 0.5 ? -1.0 : 1.0,
           {draw(-1, 2), draw(-1, 1.5), 0},
           {draw(-1, 3), draw(-1.5, 1.5), 0}};
      phi = draw(-3, 3);
    } while (!grashof());
    const double step = std::exp(draw(std::log(0.01), std::log(0.4)));
    const double amplitude = draw(0.1, 2), phase = draw(0, 6), turning = draw(-4, 4) / step;
    const Law swing = Law::harmonics({{amplitude, draw(0.2, 3), phase}}, phi - amplitude * std::sin(phase));
    const Law law = seed % 2 == 0 ? Law::polynomial({phi, turning}) : swing + Law::polynomial({0, turning / 3});
    expect_the_closed_form(m, law, step, 20);
    if (testing::Test::HasFatalFailure()) return;
  }
}

// The last link of an arm turns by the sum of all joint angles.
TEST(AngleTurns, AreRightForTheLastLinkOfAnArm) {
  constexpr int kJoints = 6;
  for (const double rate : {0.9, 1.04, 2.1}) {  // rad a step: six joints together make about one turn, or two
    SceneBuilder builder("arm", 2);
    builder.fixed_vector("u0", {1, 0, 0});
    for (int k = 1; k <= kJoints; ++k) {
      const std::string link = "u" + std::to_string(k), before = "u" + std::to_string(k - 1);
      builder.vector(link, {1, 0, 0});
      builder.drive("joint" + std::to_string(k), RelativeAngle{before, link, "", Law::polynomial({0, rate})});
    }
    builder.measure("hand", AngleBetween{"u0", "u" + std::to_string(kJoints), ""}).output("hand.value");
    const test::Result r = test::run(builder.time(0, 10, 1).build(), "groups/eigen");
    ASSERT_TRUE(r.report().status.ok());
    for (std::size_t k = 0; k <= 10; ++k) {
      EXPECT_NEAR(r.trajectory(k, 0), kJoints * rate * static_cast<double>(k), kNoTurn) << rate;
    }
  }
}

// ---- control

const FourBar kLimited = {1.5, 1.0, 1.2, 2, 1, {1, 0.4, 0}, {0.3, 2.5, 0}};

Simulator controlled(const FourBar& m, double phi, const std::vector<std::string>& outputs) {
  return test::simulator(scene(m, Law::constant(phi), 0.01, 1, outputs), "groups/eigen", {}, {"motor"});
}

TEST(AngleTurns, AreRightAcrossALimitAndBack) {
  const FourBar m = kLimited;
  for (const auto& outputs : kSubsets) {
    Simulator s = controlled(m, 0.3, outputs);
    Truth truth(m, 0.3);
    int limits = 0, direction = 1, back = 0;
    for (int k = 0, at = 0; k < 300; ++k) {
      if (direction < 0 && ++back % 20 == 0) direction = 1;
      const double phi = 0.3 + 0.01 * (at += direction);
      s.set("motor", phi);
      const bool arrived = s.step().arrived();
      limits += arrived ? 0 : 1;
      if (!arrived) direction = -1;
      if (!arrived) continue;
      ASSERT_TRUE(truth.go(phi));
      for (std::size_t c = 0; c < s.columns().size(); ++c) {
        const double expected = truth[s.columns()[c]];
        if (std::isnan(expected)) continue;
        ASSERT_NEAR(s.outputs()[c], expected, kNoTurn) << phi;
      }
    }
    EXPECT_GT(limits, 5);
  }
}

TEST(AngleTurns, AreRightAfterAWrongRate) {
  const FourBar m = kCrankRocker;
  for (const auto& outputs : kSubsets) {
    Simulator s = controlled(m, 0.3, outputs);
    Truth truth(m, 0.3);
    for (int k = 1; k < 60; ++k) {
      const double phi = 0.3 + 0.05 * k;
      s.set("motor", phi, k % 20 == 10 ? 1e4 : 5);
      ASSERT_TRUE(s.step().arrived()) << k;
      ASSERT_TRUE(truth.go(phi));
      for (std::size_t c = 0; c < s.columns().size(); ++c) {
        const double expected = truth[s.columns()[c]];
        if (std::isnan(expected)) continue;
        ASSERT_NEAR(s.outputs()[c], expected, kNoTurn) << k;
      }
    }
  }
}

TEST(AngleTurns, AreRightBackwardsAndOverLongWays) {
  const FourBar m{1.5, 1.4, 1.6, 0.6, 1, {0.7, 0.9, 0}, {0.2, 0.3, 0}};
  const Law law = Law::polynomial({0.3, 1});
  Simulator s = test::simulator(scene(m, law, 0.1, 10, {"rocker.value", "tracer", "crank"}), "groups/eigen");
  Truth truth(m, law(0).value);
  for (const double t : {3.0, -20.0, -20.5, 15.0, 0.0}) {
    ASSERT_TRUE(s.step(t).arrived());
    ASSERT_TRUE(truth.go(law(t).value));
    for (std::size_t c = 0; c < s.columns().size(); ++c) {
      const double expected = truth[s.columns()[c]];
      if (std::isnan(expected)) continue;
      EXPECT_NEAR(s.outputs()[c], expected, kNoTurn) << t;
    }
  }
}

}  // namespace
}  // namespace assur
