// The mechanisms of scenes/ that are written with joints and have redundant equations, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "properties/shipped.hpp"
#include "scene/triple.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;

Scene shipped(const std::string& name, const Parameters& set = {}) {
  return read_scene(std::string(ASSUR_SOURCE_DIR) + "/scenes/" + name + ".json", set);
}

struct Motion {
  explicit Motion(const Scene& scene) : run(test::run(scene)), t(run.trajectory) {
    for (const GroupFigures& g : run.simulator.examine()) condition = std::max(condition, g.condition);
  }
  [[nodiscard]] double operator()(std::size_t row, const char* column) const { return t(row, t.index(column)); }
  [[nodiscard]] double tolerance() const { return 16 * condition * kEps; }
  [[nodiscard]] double residual() const { return run.report().error.residual(); }

  test::Result run;
  const Trajectory& t;
  double condition = 1;
};

// The angle about an axis from PQ to QR.
double bend(const Triple& p, const Triple& q, const Triple& r, const Triple& axis) {
  const Triple a = triple::subtract(q, p), b = triple::subtract(r, q);
  return std::atan2(triple::dot(axis, triple::cross(a, b)) / triple::norm(axis), triple::dot(a, b));
}

// G. T. Bennett, Engineering 76, 1903: the product of the tangents of half the angles of neighbouring joints is
// constant, and opposite joints turn alike.
TEST(ShippedJoints, BennettMakesFullTurns) {
  const Motion m(shipped("bennett"));
  ASSERT_EQ(m.t.rows(), 401u);
  EXPECT_EQ(m.run.report().status.code, Code::ok);
  const Triple A = {1, 0, 0.3}, B = {0.4, 1, -0.3}, C = {-1, 0, 0.3}, D = {-0.4, -1, -0.3};
  const double first = bend(D, A, B, {-1.2, 0.48, 2}), second = bend(A, B, C, {0, 1.2, 2});
  const double k = std::tan(first / 2) * std::tan(second / 2);
  for (std::size_t row = 0; row < m.t.rows(); ++row) {
    EXPECT_NEAR(m(row, "A.angle"), 2 * kPi * m.t.times()[row], 1e-13);
    const double a = (first + m(row, "A.angle")) / 2, b = (second + m(row, "B.angle")) / 2;
    EXPECT_NEAR(std::sin(a) * std::sin(b), k * std::cos(a) * std::cos(b), 1e-13);
    EXPECT_NEAR(m(row, "C.angle"), m(row, "A.angle"), 1e-13);
    EXPECT_NEAR(m(row, "D.angle"), m(row, "B.angle"), 1e-13);
  }
  EXPECT_LE(m.residual(), 1e-14);
}

// M. Goldberg, Transactions of the ASME 65, 1943: two of Bennett's linkages with a common link J C, of length a and
// twist alpha, which is left out. Angles of Bennett's linkages are those of Denavit and Hartenberg. C stays on the
// circle that the common link would lead it on, and joint E follows through the angle at J.
TEST(ShippedJoints, GoldbergMakesFullTurns) {
  const Motion m(shipped("goldberg"));
  ASSERT_EQ(m.t.rows(), 401u);
  EXPECT_EQ(m.run.report().status.code, Code::ok);
  const double alpha = 0.9, beta = 0.65, gamma = 0.45, a = std::sin(alpha), b = std::sin(beta), c = std::sin(gamma);
  const double k1 = std::sin((alpha + beta) / 2) / std::sin((alpha - beta) / 2);
  const double k2 = std::sin((alpha + gamma) / 2) / std::sin((alpha - gamma) / 2);
  const auto follow = [](double k, double angle) {
    return 2 * std::atan2(k * std::cos(angle / 2), std::sin(angle / 2));
  };
  const double first = follow(k2, follow(k1, 1.2) + kPi);  // joint E in the posture as written
  for (std::size_t row = 0; row < m.t.rows(); ++row) {
    const double A = 1.2 + m(row, "A.angle"), J = follow(k1, A), E = follow(k2, J + kPi);
    EXPECT_NEAR(std::remainder(m(row, "E.angle") - (E - first), 2 * kPi), 0, m.tolerance());
    const Triple expected[] = {
        {b + a * std::cos(A), a * std::sin(A) * std::cos(beta), a * std::sin(A) * std::sin(beta)},
        {-a * std::cos(J), a * std::sin(J), 0},
        {-c - a * std::cos(E), -a * std::sin(E) * std::cos(gamma), a * std::sin(E) * std::sin(gamma)}};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::string column = {"BCD"[i], '.', "xyz"[k]};
        EXPECT_NEAR(m(row, column.c_str()), expected[i][k], m.tolerance()) << column << " in row " << row;
      }
    }
  }
  EXPECT_NEAR(m(400, "A.angle"), 4 * kPi, 1e-13);
  EXPECT_NEAR(std::abs(m(400, "E.angle")), 4 * kPi, m.tolerance());  // E makes full turns, too
  EXPECT_LE(m.residual(), 1e-14);
}

// Positions, velocities and accelerations of the same closed form, in quad.
TEST(ShippedJoints, GoldbergsDerivativesFollow) {
  using references::QuadJet;
  const test::Shipped s("goldberg");
  const QuadJet alpha{0.9}, beta{0.65}, gamma{0.45}, a = sin(alpha), b = sin(beta), c = sin(gamma);
  const QuadJet k1 = sin((alpha + beta) / 2) / sin((alpha - beta) / 2);
  const QuadJet k2 = sin((alpha + gamma) / 2) / sin((alpha - gamma) / 2);
  test::expect_motion(s.scene(), 4, [&](double t) {
    const QuadJet A = s.law("motor", t) + 1.2, J = 2 * atan2(k1 * cos(A / 2), sin(A / 2));
    const QuadJet E = 2 * atan2(-1 * k2 * sin(J / 2), cos(J / 2));
    return test::Expected{{{"B", {b + a * cos(A), a * sin(A) * cos(beta), a * sin(A) * sin(beta)}},
                           {"C", {-1 * a * cos(J), a * sin(J), QuadJet{}}},
                           {"D", {-1 * c - a * cos(E), -1 * a * sin(E) * cos(gamma), a * sin(E) * sin(gamma)}}}};
  });
}

TEST(ShippedJoints, SarrusMovesStraight) {
  const Motion m(shipped("sarrus"));
  ASSERT_EQ(m.t.rows(), 401u);
  const double link = std::hypot(0.8, 0.5), start = std::atan2(0.5, 0.8);
  for (std::size_t row = 0; row < m.t.rows(); ++row) {
    const double turn = 0.4 * std::sin(kPi * m.t.times()[row]);
    EXPECT_NEAR(m(row, "T.x"), 0.5, m.tolerance());
    EXPECT_NEAR(m(row, "T.y"), 0.5, m.tolerance());
    EXPECT_NEAR(m(row, "T.z"), 2 * link * std::sin(start - turn), m.tolerance());
    EXPECT_NEAR(m(row, "foot_y.angle"), -turn, m.tolerance());
  }
  EXPECT_LE(m.residual(), 1e-14);
}

// J. E. Baker, Mechanism and Machine Theory 15, 1980. At the cube both angles are a quarter turn.
TEST(ShippedJoints, BricardFollowsBakersEquation) {
  const Motion m(shipped("bricard_joints"));
  ASSERT_EQ(m.t.rows(), 401u);
  EXPECT_EQ(m.run.report().status.code, Code::ok);
  for (std::size_t row = 0; row < m.t.rows(); ++row) {
    const double a = std::cos(m(row, "A.angle") - kPi / 2), b = std::cos(m(row, "B.angle") - kPi / 2);
    EXPECT_NEAR(a + b + a * b, 0, m.tolerance());
  }
  EXPECT_LE(m.residual(), 1e-14);
}

TEST(ShippedJoints, BricardEndsAtBothFolds) {
  for (const auto& [low, high, fold] : {std::array{-29.0, 210.1, 210.0}, std::array{-30.1, 209.0, -30.0}}) {
    const Scene scene = shipped("bricard_joints", {{"low", low}, {"high", high}});
    const Motion m(scene);
    EXPECT_EQ(m.run.report().status.code, Code::fold);
    const std::vector<Event> events = test::events(m.run.report());
    ASSERT_FALSE(events.empty());
    const double middle = (high + low) / 2, swing = (high - low) / 2;
    const double turn = std::asin((fold - middle) / swing);  // the angle is middle + swing sin(turn)
    const double time = ((fold > 0 ? turn : kPi - turn) + std::asin(middle / swing)) / kPi;
    EXPECT_LE(events.back().time, time);
    EXPECT_GE(events.back().until, time);
    EXPECT_LT(events.back().until - events.back().time, 1e-12);
  }
}

TEST(ShippedJoints, WhitworthCountsTenTurns) {
  const Motion m(shipped("whitworth_joints"));
  ASSERT_EQ(m.t.rows(), 1001u);
  const double crank = 0.3, pivot = 0.15;
  for (std::size_t row = 0; row < m.t.rows(); ++row) {
    const double phi = 2 * kPi * m.t.times()[row], x = crank * std::cos(phi) - pivot, y = crank * std::sin(phi);
    const double in_turn = std::atan2(y, x), link = in_turn + 2 * kPi * std::round((phi - in_turn) / (2 * kPi));
    EXPECT_NEAR(m(row, "Q.angle"), link, 1e-13);
    EXPECT_NEAR(m(row, "S.displacement"), std::hypot(x, y) - 0.15, m.tolerance());
  }
  EXPECT_NEAR(m(1000, "Q.angle"), 20 * kPi, 1e-12);
  EXPECT_LE(m.residual(), 1e-14);
}

}  // namespace
}  // namespace assur
