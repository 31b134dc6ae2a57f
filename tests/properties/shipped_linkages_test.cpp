// The planar mechanisms of scenes/: circle by circle, as they would be drawn.
#include <gtest/gtest.h>

#include "properties/shipped.hpp"

namespace assur {
namespace {

using references::dot;
using references::operator+;
using references::operator-;
using references::operator*;
using references::QuadJet;
using test::Expected;
using test::heading;
using test::meet;
using test::member;
using test::norm;
using test::Point3;
using test::Shipped;

// Three dyads: A, B, and C, which depends on both.
TEST(Shipped, PeaucellierDrawsAStraightLine) {
  const Shipped s("peaucellier");
  test::expect_groups(s.scene(), {{2, 2}, {2}}, 2, 1);
  const Point3 O = s.fixed("O"), Q = s.fixed("Q");
  const QuadJet crank = s.length("QP"), arm = s.length("OA"), side = s.length("PA");
  test::expect_motion(s.scene(), 1, [&](double t) {
    const QuadJet angle = s.law("motor", t);
    const Point3 P = Q + crank * heading(angle);
    const QuadJet x = (arm * arm - side * side) / (2 * crank);  // the inverse of a circle through O
    return Expected{{{"P", P},
                     {"A", meet(O, arm, P, side)},
                     {"B", meet(P, side, O, arm)},
                     {"C", {x, x * sin(angle / 2) / cos(angle / 2), QuadJet{}}}}};
  });
}

// One dyad. The middle of the coupler is on Watt's curve: with the middle of the fixed pivots as origin, the distance 2
// a of the pivots, equal rockers b and the coupler 2 c, r^2 = b^2 - (a sin t +- sqrt(c^2 - a^2 cos^2 t))^2 in polar
// coordinates (J. D. Lawrence, A Catalog of Special Plane Curves, 1972); t counts from the line of the pivots.
TEST(Shipped, WattGuidesAPointAlmostStraight) {
  const Shipped s("watt");
  test::expect_groups(s.scene(), {{2}}, 1, 1);
  const Point3 A = s.fixed("A"), D = s.fixed("D"), B0 = s.fixed("B"), C0 = s.fixed("C");
  const QuadJet coupler = norm(C0 - B0), right = norm(C0 - D);
  const auto at = [&](double t) {
    const Point3 start = B0 - A;
    const QuadJet turn = s.law("motor", t);
    const Point3 B =
        A + Point3{cos(turn) * start[0] - sin(turn) * start[1], sin(turn) * start[0] + cos(turn) * start[1], QuadJet{}};
    const Point3 C = meet(D, right, B, coupler);
    return Expected{{{"B", B}, {"C", C}, {"M", member(B, C, s.local("M"))}}};
  };
  test::expect_motion(s.scene(), 1, at);
  const double a = std::hypot(1, 0.25), b = 1, c = 0.25, slope = std::atan2(-0.25, 1);
  for (const double t : {0.3, 0.5, 1.2, 3.3}) {
    const Point3 M = at(t).points.at("M");
    const double x = double(M[0].value), y = double(M[1].value), r = std::hypot(x, y), angle = std::atan2(y, x) - slope;
    const double root = std::sqrt(c * c - std::pow(a * std::cos(angle), 2)), sine = a * std::sin(angle);
    const double one = b * b - std::pow(sine + root, 2), other = b * b - std::pow(sine - root, 2);
    EXPECT_LE(std::min(std::abs(r * r - one), std::abs(r * r - other)), 1e-12) << t;
  }
}

// Two dyads for each leg: the connecting rod with the lower rocker, and the leg with the upper one.
TEST(Shipped, KlannWalks) {
  const Shipped s("klann");
  test::expect_groups(s.scene(), {{2, 2}, {2, 2}}, 4, 1);
  const Point3 shaft = s.fixed("shaft"), hip_axle = s.fixed("hip_axle"), elbow_axle = s.fixed("elbow_axle");
  test::expect_motion(s.scene(), 4, [&](double t) {
    Expected e;
    e.points["pin1"] = shaft + s.length("crank1") * heading(s.law("motor", t));
    e.points["pin2"] = member(shaft, e.points["pin1"], s.local("pin2"));
    for (const std::string n : {"1", "2"}) {
      const Point3 pin = e.points["pin" + n];
      const Point3 elbow = meet(elbow_axle, s.length("elbow_rocker" + n), pin, s.length("rod_length" + n));
      const Point3 knee = member(pin, elbow, s.local("knee" + n));
      const Point3 hip = meet(knee, s.length("thigh" + n), hip_axle, s.length("hip_rocker" + n));
      e.points["elbow" + n] = elbow, e.points["knee" + n] = knee, e.points["hip" + n] = hip;
      e.points["foot" + n] = member(knee, hip, s.local("foot" + n));
    }
    return e;
  });
}

// Three dyads for each leg, of two kinds: two from the pin and a pivot, the third from both of these.
void expect_to_walk(const Shipped& s, int legs) {
  SCOPED_TRACE(legs);
  const auto pairs = static_cast<std::size_t>(legs) / 2;
  test::expect_groups(s.scene(), {std::vector<int>(4 * pairs, 2), std::vector<int>(2 * pairs, 2)}, 2, 1);
  const Point3 O = s.fixed("O");
  test::expect_motion(s.scene(), 4, [&](double t) {
    Expected e;
    e.points["X"] = O + s.length("crank") * heading(s.law("motor", t));
    for (std::size_t k = 1; k <= pairs; ++k) {
      const std::string pair = std::to_string(k);
      const Point3 pin = member(O, e.points["X"], s.local("pin" + pair));
      e.points["pin" + pair] = pin;
      for (const std::string& leg : {"R" + pair, "L" + pair}) {
        const Point3 pivot = s.fixed("P" + leg.substr(0, 1));
        // The left leg mirrors the right leg, so that left and right of a line are exchanged.
        const auto joint = [&](const Point3& P, const std::string& p, const Point3& Q, const std::string& q) {
          return leg[0] == 'R' ? meet(P, s.length(p + leg), Q, s.length(q + leg))
                               : meet(Q, s.length(q + leg), P, s.length(p + leg));
        };
        const Point3 top = joint(pin, "j", pivot, "b"), knee = joint(pivot, "c", pin, "k");
        const Point3 d = member(pivot, top, s.local("D" + leg));
        const Point3 shin = joint(d, "f", knee, "g");
        e.points["T" + leg] = top, e.points["K" + leg] = knee, e.points["D" + leg] = d, e.points["S" + leg] = shin;
        e.points["foot" + leg] = member(knee, shin, s.local("foot" + leg));
      }
    }
    return e;
  });
}

TEST(Shipped, JansenWalks) {
  expect_to_walk(Shipped("jansen"), 4);
  for (const int legs : {2, 6}) expect_to_walk(Shipped(sample("jansen:legs=" + std::to_string(legs))), legs);
}

// One group for each stage: one class for the first stage, which stands on the ground, and one for the other stages.
void expect_to_lift(const Shipped& s, int stages) {
  SCOPED_TRACE(stages);
  test::expect_groups(s.scene(), test::Levels(static_cast<std::size_t>(stages), {4}), stages == 1 ? 1 : 2, 1);
  const QuadJet arm = s.length("rising_arm1");
  const std::string top = "A" + std::to_string(stages);
  test::expect_motion(s.scene(), 1, [&](double t) {
    const QuadJet width = s.law("cylinder", t), rise = sqrt(arm * arm - width * width);
    Expected e;
    e.points["B0"] = {width, QuadJet{}, QuadJet{}};
    for (int k = 1; k <= stages; ++k) {
      const std::string n = std::to_string(k);
      e.points["A" + n] = {QuadJet{}, k * rise, QuadJet{}};
      e.points["B" + n] = {width, k * rise, QuadJet{}};
      e.points["M" + n] = e.points["N" + n] = {width / 2, (k - 0.5) * rise, QuadJet{}};
    }
    e.points["edge"] = e.points[top] + s.local("edge");
    e.measures["height"] = {stages * rise};
    return e;
  });
}

TEST(Shipped, ScissorLifts) {
  expect_to_lift(Shipped("scissor"), 4);
  for (const int stages : {1, 5, 9}) expect_to_lift(Shipped(sample("scissor:" + std::to_string(stages))), stages);
}

// One dyad each for boom, stick, rocker and bucket, one after the other.
TEST(Shipped, ExcavatorDigs) {
  const Shipped s("excavator");
  test::expect_groups(s.scene(), {{2}, {2}, {2}, {2}}, 4, 3);
  // The end of the base of a body about P with a member at `eye`. The base has the length `length`.
  const auto end = [](const Point3& P, const Point3& eye, const Point3& local, const QuadJet& length) {
    const Point3 d = eye - P;
    const Point3 along = {d[0] * local[0] + d[1] * local[1], d[1] * local[0] - d[0] * local[1], QuadJet{}};
    return P + length / dot(local, local) * along;
  };
  const Point3 O = s.fixed("O"), F = s.fixed("F");
  test::expect_motion(s.scene(), 4, [&](double t) {
    const Point3 boom_local = s.local("boom_eye"), stick_local = s.local("stick_eye");
    const Point3 boom_eye = meet(O, norm(boom_local), F, s.law("boom_cylinder", t));
    const Point3 S = end(O, boom_eye, boom_local, s.length("boom_length"));
    const Point3 stick_foot = member(O, S, s.local("stick_foot"));
    const Point3 stick_eye = meet(stick_foot, s.law("stick_cylinder", t), S, norm(stick_local));
    const Point3 T = end(S, stick_eye, stick_local, s.length("stick_length"));
    const Point3 bucket_foot = member(S, T, s.local("bucket_foot")), rocker_foot = member(S, T, s.local("rocker_foot"));
    const Point3 H = meet(bucket_foot, s.law("bucket_cylinder", t), rocker_foot, s.length("rocker_length"));
    const Point3 J = meet(H, s.length("link_length"), T, s.length("ear_length"));
    const Point3 tip = member(T, J, s.local("tip"));
    // All angles stay within half a turn.
    const auto angle = [](const Point3& d, const Point3& e) {
      return atan2(d[0] * e[1] - d[1] * e[0], d[0] * e[0] + d[1] * e[1]);
    };
    const auto turn = [](const Point3& d) { return 2 / static_cast<double>(norm(d).value); };
    const Point3 boom = S - O, stick = T - S, bucket = tip - T;
    return Expected{{{"boom_eye", boom_eye},
                     {"S", S},
                     {"stick_foot", stick_foot},
                     {"stick_eye", stick_eye},
                     {"T", T},
                     {"bucket_foot", bucket_foot},
                     {"rocker_foot", rocker_foot},
                     {"H", H},
                     {"J", J},
                     {"tip", tip},
                     {"back", member(T, J, s.local("back"))}},
                    {{"boom_angle", {atan2(boom[1], boom[0]), turn(boom)}},
                     {"stick_angle", {angle(boom, stick), turn(boom) + turn(stick)}},
                     {"bucket_angle", {angle(stick, bucket), turn(stick) + turn(bucket)}}}};
  });
}

}  // namespace
}  // namespace assur
