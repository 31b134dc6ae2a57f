// The mechanisms of scenes/ in space: spheres, circles, and a few scalar equations.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>

#include "properties/shipped.hpp"

namespace assur {
namespace {

using references::cross;
using references::dot;
using references::operator+;
using references::operator-;
using references::operator*;
using references::QuadJet;
using references::unit;
using test::Expected;
using test::Point3;
using test::Shipped;

const Point3 kUp = references::exactly<QuadJet>({0, 0, 1});

// The point at distances p, q, r from P, Q, R, on the side of (Q - P) x (R - P).
Point3 meet(const Point3& P, const QuadJet& p, const Point3& Q, const QuadJet& q, const Point3& R, const QuadJet& r) {
  const Point3 x = unit(Q - P), z = unit(cross(Q - P, R - P)), y = cross(z, x);
  const QuadJet d = dot(x, Q - P), i = dot(x, R - P), j = dot(y, R - P);
  const QuadJet along = (p * p - q * q + d * d) / (2 * d);
  const QuadJet beside = (p * p - r * r + i * i + j * j - 2 * i * along) / (2 * j);
  return P + along * x + beside * y + sqrt(p * p - along * along - beside * beside) * z;
}

// A point or vector (`origin` 0) of the body with the base P, Q, R.
struct Frame {
  Point3 origin, x, y, z;

  Frame(const Point3& P, const Point3& Q, const Point3& R)
      : origin(P), x(unit(Q - P)), y(), z(unit(cross(Q - P, R - P))) {
    y = cross(z, x);
  }
  [[nodiscard]] Point3 turned(const Point3& local) const { return local[0] * x + local[1] * y + local[2] * z; }
};

// The platform with its six rods is one group: a free body. Three spheres about the elbows, moved inwards by as much as
// the joints of the platform are off its centre, meet in the centre.
TEST(Shipped, DeltaMovesWithoutTurning) {
  const Shipped s("delta");
  test::expect_groups(s.scene(), {{12}}, 1, 3);
  test::expect_motion(s.scene(), 1, [&](double t) {
    Expected e;
    std::array<Point3, 3> centre;
    std::array<QuadJet, 3> rod;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string n = std::to_string(i + 1);
      const Point3 S = s.fixed("S" + n), zero = unit(s.fixed("E" + n) - S);
      const QuadJet angle = s.law("motor" + n, t);
      const Point3 E = S + s.length("arm" + n) * (cos(angle) * zero + sin(angle) * cross(s.fixed("t" + n), zero));
      e.points["E" + n] = E;
      // with the mean of the two rods' joints
      const auto middle = [&](const std::string& left, const std::string& right) {
        return QuadJet{0.5} * (s.local(left + n) + s.local(right + n));
      };
      centre[i] = E + middle("L", "R") - middle("PL", "PR");
      rod[i] = s.length("rodL" + n);
    }
    e.points["O"] = meet(centre[0], rod[0], centre[2], rod[2], centre[1], rod[1]);
    e.points["u"] = references::exactly<QuadJet>({1, 0, 0});
    e.points["v"] = references::exactly<QuadJet>({0, 1, 0});
    e.points["w"] = kUp;
    return e;
  });
}

// A crank for each group: its end is on a circle and on the sphere of its rod.
TEST(Shipped, HexaTurnsItsCranks) {
  const Shipped s("hexa");
  test::expect_groups(s.scene(), {{3, 3, 3, 3, 3, 3}}, 1, 6);
  const auto* pose = std::get_if<Pose>(&s.scene().drivers().front().kind);
  ASSERT_NE(pose, nullptr);
  test::expect_motion(s.scene(), 1, [&](double t) {
    const auto value = [&](const Law& law) { return evaluate<references::Quad>(law, references::Quad(t)); };
    const QuadJet psi = value(pose->rotation[0]), theta = value(pose->rotation[1]), phi = value(pose->rotation[2]);
    Expected e;
    const Point3 O = {value(pose->translation[0]), value(pose->translation[1]), value(pose->translation[2])};
    // v and w are y and z, rotated by phi about u.
    const Point3 u = {cos(psi) * cos(theta), sin(psi) * cos(theta), -sin(theta)};
    const Point3 y = {-sin(psi), cos(psi), QuadJet{}}, v = cos(phi) * y + sin(phi) * cross(u, y);
    e.points = {{"O", O}, {"u", u}, {"v", v}, {"w", cross(u, v)}};
    for (int i = 0; i < 6; ++i) {
      const std::string n = std::to_string(i + 1), pair = std::to_string(i / 2 + 1);
      const Point3 A = s.fixed("A" + n), axis = s.fixed("t" + pair), out = s.fixed("r" + pair), at = s.local("P" + n);
      const Point3 P = O + at[0] * u + at[1] * v + at[2] * cross(u, v);
      // |A + crank (c x + s z) - P| = rod: f c + g s = k, with c^2 + s^2 = 1
      const Point3 x = unit(cross(axis, kUp)), z = cross(unit(axis), x);
      const QuadJet crank = s.length("crank" + n), rod = s.length("rod" + n), f = dot(P - A, x), g = dot(P - A, z);
      const QuadJet k = (crank * crank + dot(P - A, P - A) - rod * rod) / (2 * crank), square = f * f + g * g;
      const QuadJet root = sqrt(square - k * k);
      const Point3 d = crank * ((k * f + g * root) / square * x + (k * g - f * root) / square * z);
      e.points["P" + n] = P, e.points["B" + n] = A + d;
      e.measures["motor" + n] = {atan2(dot(axis, cross(out, d)), dot(out, d)), 2 / static_cast<double>(crank.value)};
    }
    return e;
  });
}

// The platform is one group, which determines its three joints; its normal follows from them. Each leg leans inwards by
// an angle in its plane: three equations |P_i - P_j| = side in three angles (Lee and Shah 1988), by Newton's method in
// numbers that carry their derivatives.
TEST(Shipped, ThreeRpsLiftsAndTilts) {
  const Shipped s("three_rps");
  test::expect_groups(s.scene(), {{9}, {1, 1, 1}}, 2, 3);
  std::array<Point3, 3> A, inwards;
  for (std::size_t i = 0; i < 3; ++i) {
    A[i] = s.fixed("A" + std::to_string(i + 1));
    inwards[i] = unit(cross(kUp, s.fixed("t" + std::to_string(i + 1))));
  }
  const QuadJet side = s.length("P12");
  test::expect_motion(s.scene(), 4, [&](double t) {
    std::array<QuadJet, 3> leg, lean = {QuadJet{0.25}, QuadJet{0.25}, QuadJet{0.25}};
    for (std::size_t i = 0; i < 3; ++i) leg[i] = s.law("leg" + std::to_string(i + 1), t);
    std::array<Point3, 3> P, turning;  // and their derivatives by the angles
    for (int iteration = 0; iteration < 9; ++iteration) {
      for (std::size_t i = 0; i < 3; ++i) {
        P[i] = A[i] + leg[i] * (sin(lean[i]) * inwards[i] + cos(lean[i]) * kUp);
        turning[i] = leg[i] * (cos(lean[i]) * inwards[i] - sin(lean[i]) * kUp);
      }
      // Equation i is about the other two points.
      std::array<QuadJet, 3> f, a, b;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        const Point3 d = P[j] - P[k];
        f[i] = dot(d, d) - side * side;
        a[i] = 2 * dot(d, turning[j]), b[i] = QuadJet{-2} * dot(d, turning[k]);
      }
      // a0 x1 + b0 x2 = f0, a1 x2 + b1 x0 = f1, a2 x0 + b2 x1 = f2
      const QuadJet x2 =
          (f[2] - a[2] * f[1] / b[1] - b[2] * f[0] / a[0]) / (-(a[2] * a[1] / b[1]) - b[2] * b[0] / a[0]);
      const QuadJet x0 = (f[1] - a[1] * x2) / b[1], x1 = (f[0] - b[0] * x2) / a[0];
      lean = {lean[0] - x0, lean[1] - x1, lean[2] - x2};
    }
    const Frame plate(P[0], P[1], P[2]);
    const Point3 centre = plate.origin + plate.turned(s.local("centre"));
    // Their relations: the platform does not turn about its normal, u_y = v_x, and its centre moves as it tilts.
    const QuadJet radius = side / sqrt(QuadJet{3});
    const Point3 u = unit(P[0] - centre), v = cross(plate.z, u);
    for (const QuadJet& zero : {u[1] - v[0], centre[0] - radius / 2 * (u[0] - v[1]), centre[1] + radius * u[1]}) {
      EXPECT_NEAR(static_cast<double>(zero.value), 0, 1e-15);  // rounding of the doubles in the scene
    }
    const QuadJet tilt = atan2(sqrt(plate.z[0] * plate.z[0] + plate.z[1] * plate.z[1]), plate.z[2]);
    return Expected{{{"P1", P[0]}, {"P2", P[1]}, {"P3", P[2]}, {"centre", centre}, {"normal", plate.z}},
                    {{"tilt", {tilt, 2}}}};
  });
}

// Each corner is one group. It includes one component of the upright's normal, because the driver prescribes the height
// of the wheel; the other components follow. For a given angle of the lower wishbone, the joints are intersections of
// circles and spheres, one after the other. Newton's method finds the angle at which the wheel has its height.
TEST(Shipped, DoubleWishboneSteers) {
  const Shipped s("double_wishbone");
  test::expect_groups(s.scene(), {{10, 10}, {1, 1, 1, 1}}, 2, 3);
  struct Corner {
    Point3 lower, upper, tie, wheel, spindle, normal;
  };
  const auto corner = [&](const std::string& side, const QuadJet& angle, const Point3& rack) {
    const auto at = [&](const std::string& name) { return s.fixed(name + "_" + side); };
    const auto length = [&](const std::string& name) { return s.length(name + "_" + side); };
    // The lower joint turns about the line of its two hinges, from its place in the posture as written.
    const Point3 front = at("lower_front"), axis = unit(at("lower_rear") - front), d = at("lower_joint") - front;
    const Point3 foot = dot(d, axis) * axis, lever = d - foot;
    Corner c;
    c.lower = front + foot + cos(angle) * lever + sin(angle) * cross(axis, lever);
    const bool left = side == "L";  // in the mirror, the other side of each plane
    const auto sphere = [&](const Point3& P, const QuadJet& p, const Point3& Q, const QuadJet& q, const Point3& R,
                            const QuadJet& r) { return left ? meet(P, p, Q, q, R, r) : meet(Q, q, P, p, R, r); };
    const auto apart = [&](const std::string& p, const std::string& q) { return test::norm(at(q) - at(p)); };
    c.upper = sphere(at("upper_front"), length("upper_arm_front"), c.lower, apart("lower_joint", "upper_joint"),
                     at("upper_rear"), length("upper_arm_rear"));
    const Point3 rack_end = rack + s.local("rack_" + side);
    const Point3 rack_written = s.fixed("rack_centre") + s.local("rack_" + side);
    c.tie = sphere(c.upper, apart("upper_joint", "tie_joint"), c.lower, apart("lower_joint", "tie_joint"), rack_end,
                   test::norm(at("tie_joint") - rack_written));
    const Frame upright(c.lower, c.upper, c.tie);
    c.wheel = upright.origin + upright.turned(s.local("wheel_" + side));
    c.spindle = upright.turned(s.local("spindle_" + side));
    c.normal = upright.z;
    return c;
  };
  // The spheres meet on the sides of the posture as written.
  const Point3 home = s.fixed("rack_centre");
  for (const std::string side : {"L", "R"}) {
    const Corner c = corner(side, QuadJet{}, home);
    for (const auto& [name, point] : {std::pair("upper_joint_", c.upper), std::pair("tie_joint_", c.tie)}) {
      for (std::size_t i = 0; i < 3; ++i) {
        ASSERT_NEAR(static_cast<double>((point - s.fixed(name + side))[i].value), 0, 1e-12) << name << side;
      }
    }
  }
  test::expect_motion(s.scene(), 4, [&](double t) {
    Expected e;
    const Point3 rack = {home[0], s.law("steering", t), home[2]};
    e.points["rack_centre"] = rack;
    for (const std::string side : {"L", "R"}) {
      const QuadJet height = corner(side, QuadJet{}, home).wheel[2] + s.law("travel_" + side, t);
      QuadJet angle{};
      Point3 resting = rack;
      for (QuadJet& x : resting) x = {x.value, 0, 0};
      for (int iteration = 0; iteration < 8; ++iteration) {
        const QuadJet slope = corner(side, {angle.value, 1, 0}, resting).wheel[2];  // derivatives by the angle
        angle = angle - (corner(side, angle, rack).wheel[2] - height) / slope.rate;
      }
      const Corner c = corner(side, angle, rack);
      e.points["lower_joint_" + side] = c.lower, e.points["upper_joint_" + side] = c.upper;
      e.points["tie_joint_" + side] = c.tie, e.points["wheel_" + side] = c.wheel;
      e.points["spindle_" + side] = c.spindle;
      const QuadJet level = sqrt(c.spindle[0] * c.spindle[0] + c.spindle[1] * c.spindle[1]);
      e.measures["camber_" + side] = {atan2(-c.spindle[2], level), 2};
      e.measures["toe_" + side] = {side == "L" ? atan2(c.spindle[0], c.spindle[1]) : atan2(c.spindle[0], -c.spindle[1]),
                                   2};
    }
    return e;
  });
}

}  // namespace
}  // namespace assur
