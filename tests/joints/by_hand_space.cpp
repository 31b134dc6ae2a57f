// Mechanisms in space, written with joints and by hand.
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "joints/by_hand.hpp"
#include "scene/triple.hpp"

namespace assur::test {
namespace {

using triple::add;
using triple::cross;
using triple::scale;
using triple::subtract;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kStep = 1.0 / 128;
const Triple kZ = {0, 0, 1};

Member in_ground(std::string name, const Triple& at) { return {std::move(name), at, true}; }
double distance(const Triple& a, const Triple& b) { return triple::norm(subtract(b, a)); }
Triple unit(const Triple& a) { return scale(1 / triple::norm(a), a); }

// A crank about the z axis through A, with the point B.
void add_crank(SceneBuilder& joints, SceneBuilder& by_hand, const Triple& A, const Triple& B) {
  joints.add(Body{.name = "crank"})
      .joint("A", Revolute{"ground", "crank", A, kZ})
      .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
  by_hand.fixed_point("A", A).fixed_vector("z", kZ).point("B", B).drive(
      "motor", PointAngle{"A", "B", "z", Law::polynomial({0, kTurn})});
}

// Crank and rocker about skew axes, and a rod with two spherical joints.
WrittenTwice rssr() {
  const Triple A = {0, 0, 0}, B = {0.2, 0, 0}, C = {0.9, 1.1, 0.5}, D = {1, 0.4, -0.1};
  const Triple hinge = cross(subtract(C, D), {0.2, 1, 0});
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  add_crank(joints, by_hand, A, B);
  joints.add(Body{.name = "rod"})
      .add(Body{.name = "rocker"})
      .joint("B", Spherical{"crank", "rod", B})
      .joint("C", Spherical{"rod", "rocker", C})
      .joint("D", Revolute{"ground", "rocker", D, hinge});
  by_hand.fixed_point("D", D)
      .fixed_vector("hinge", hinge)
      .point("C", C)
      .constrain("rod", Distance{"B", "C"})
      .constrain("rocker", Distance{"D", "C"})
      .constrain("swing", Dot{Direction("D", "C"), "hinge", 0.0});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("C").time(0, 1, kStep);
  return {"rssr", joints.build(), by_hand.build()};
}

// Crank, spherical joint, coupler, cylindrical joint on a rocker.
WrittenTwice rscr() {
  const Triple A = {0, 0, 0}, B = {0.2, 0, 0}, D = {0.9, 0.3, -0.1}, C = {0.8, 0.9, 0.3};
  const Triple hinge = {0.1, 0.2, 1}, axis = {1, 0.4, 0.2};
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  add_crank(joints, by_hand, A, B);
  joints.add(Body{.name = "coupler"})
      .add(Body{.name = "rocker", .vectors = {in_ground("w", axis)}})
      .joint("B", Spherical{"crank", "coupler", B})
      .joint("C", Cylindrical{"rocker", "coupler", C, "w"})
      .joint("D", Revolute{"ground", "rocker", D, hinge});
  by_hand.fixed_point("D", D)
      .fixed_vector("hinge", hinge)
      .vector("w", axis)
      .point("C", C)
      .add(Body{.name = "rocker", .base = {"D", "hinge", "w"}, .points = {in_ground("origin", C)}})
      .constrain("slide", OnLine{"C", "origin", "w"})
      .constrain("coupler", Distance{"B", "C"})
      .constrain("angle", Dot{Direction("B", "C"), "w"});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("C").output("w").time(0, 1, kStep);
  return {"rscr", joints.build(), by_hand.build()};
}

// Crank, rod with two spherical joints, and a slider on a fixed axis.
WrittenTwice slider_crank() {
  const Triple A = {0, 0, 0}, B = {0.2, 0, 0}, C = {0.5, 0.9, 0.4}, axis = {0.3, 1, 0.2};
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  add_crank(joints, by_hand, A, B);
  joints.add(Body{.name = "rod"})
      .add(Body{.name = "slider"})
      .joint("B", Spherical{"crank", "rod", B})
      .joint("C", Spherical{"rod", "slider", C})
      .joint("S", Prismatic{"ground", "slider", axis})
      .measure("stroke", MeasuredCoordinate{"S.displacement"});
  by_hand.fixed_point("G", C)
      .fixed_vector("rail", axis)
      .point("C", C)
      .constrain("rod", Distance{"B", "C"})
      .constrain("slide", OnLine{"C", "G", "rail"})
      .measure("stroke", MeasuredCoordinate{"slide.lambda"});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("C").output("stroke").time(0, 1, kStep);
  return {"rssp", joints.build(), by_hand.build()};
}

// A plate on six struts: universal, prismatic and spherical joint. Their displacements are driven, or those that the
// driven plate has are measured.
struct Hexapod {
  std::array<Triple, 6> foot, hand;
  Triple centre = {0, 0, 1.2};

  Hexapod() {
    for (std::size_t i = 0; i < 6; ++i) {
      const double low = kTurn * (static_cast<double>((i + 1) / 2) / 3 + (i % 2 == 0 ? 0.04 : -0.04)),
                   high = kTurn * (static_cast<double>(i / 2) / 3 + 1.0 / 6 + (i % 2 == 0 ? -0.03 : 0.03));
      foot[i] = {std::cos(low), std::sin(low), 0};
      hand[i] = {0.6 * std::cos(high), 0.6 * std::sin(high), 1.2};
    }
  }
  void add_struts(SceneBuilder& joints) const {
    for (std::size_t i = 0; i < 6; ++i) {
      const std::string k = std::to_string(i);
      const Triple way = subtract(hand[i], foot[i]), side = cross(way, kZ);
      joints.add(Body{.name = "cylinder" + k})
          .add(Body{.name = "piston" + k})
          .joint("U" + k, Universal{"ground", "cylinder" + k, foot[i], side, cross(way, side)})
          .joint("L" + k, Prismatic{"cylinder" + k, "piston" + k, way})
          .joint("P" + k, Spherical{"piston" + k, "plate", hand[i]});
    }
  }
  [[nodiscard]] double length(std::size_t i) const { return distance(foot[i], hand[i]); }
};

WrittenTwice forward_hexapod() {
  const Hexapod h;
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  h.add_struts(joints);
  joints.add(Body{.name = "plate", .points = {in_ground("centre", h.centre)}});
  Body plate{.name = "plate", .base = {"P0", "P2", "P4"}, .points = {in_ground("centre", h.centre)}};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string k = std::to_string(i);
    const double phase = static_cast<double>(i);
    const Law law = Law::harmonics({{0.1, 0.5, phase}}, -0.1 * std::sin(phase));
    joints.drive("pump" + k, DrivenCoordinate{"L" + k + ".displacement", law});
    by_hand.fixed_point("U" + k, h.foot[i])
        .drive("pump" + k, DrivenDistance{"U" + k, "P" + k, Law::polynomial({h.length(i)}) + law});
    if (i % 2 == 0) {
      by_hand.point("P" + k, h.hand[i]);
    } else {
      plate.points.push_back(in_ground("P" + k, h.hand[i]));
    }
  }
  by_hand.add(std::move(plate));
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("P0").output("P2").output("centre").time(0, 2, kStep);
  return {"hexapod", joints.build(), by_hand.build()};
}

WrittenTwice inverse_hexapod() {
  const Hexapod h;
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  h.add_struts(joints);
  const auto wave = [](double amplitude, double phase, double at) {
    return Law::harmonics({{amplitude, 0.5, phase}}, at - amplitude * std::sin(phase));
  };
  const Pose pose{"plate",
                  {wave(0.1, 0, 0), wave(0.1, 1, 0), wave(0.1, 2, 1.2)},
                  {wave(0.2, 0.5, 0), wave(0.2, 1.5, 0), wave(0.2, 2.5, 0)}};
  Body plate{.name = "plate", .origin = "centre", .frame = {"u", "v", "w"}};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string k = std::to_string(i);
    joints.measure("way" + k, MeasuredCoordinate{"L" + k + ".displacement"});
    plate.points.push_back(in_ground("P" + k, h.hand[i]));
    by_hand.fixed_point("U" + k, h.foot[i])
        .measure("length" + k, MeasuredDistance{"U" + k, "P" + k})
        .measure("way" + k, Combination{{{"length" + k, 1}}, -h.length(i)});
    joints.output("way" + k), by_hand.output("way" + k);
  }
  by_hand.add(plate);
  plate.points.clear();
  joints.add(plate);
  for (SceneBuilder* b : {&joints, &by_hand}) {
    b->point("centre", h.centre).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", kZ);
    b->drive("pose", pose).time(0, 2, kStep);
  }
  return {"hexapod_inverse", joints.build(), by_hand.build()};
}

// Three driven arms, each with two rods to the plate. By hand, the plate only translates, and one rod of each arm
// remains. With joints the plate only translates if it has an origin but no frame; the second rods are then redundant.
WrittenTwice delta(bool translates) {
  constexpr double kBase = 0.2, kArm = 0.25, kRod = 0.6, kPlate = 0.06, kHalf = 0.04;
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  std::array<Triple, 3> out, side, elbow;
  for (std::size_t i = 0; i < 3; ++i) {
    const double azimuth = kTurn * static_cast<double>(i) / 3;
    out[i] = {std::cos(azimuth), std::sin(azimuth), 0}, side[i] = {-std::sin(azimuth), std::cos(azimuth), 0};
    elbow[i] = add(scale(kBase + kArm * std::cos(0.35), out[i]), {0, 0, -kArm * std::sin(0.35)});
  }
  const double reach = kBase + kArm * std::cos(0.35) - kPlate;
  const Triple O = {0, 0, -kArm * std::sin(0.35) - std::sqrt(kRod * kRod - reach * reach)};
  Body plate{.name = "plate"};
  if (translates) plate.origin = "O", joints.point("O", O);
  if (!translates) plate.points = {in_ground("O", O)};
  by_hand.point("O", O);
  Body moved{.name = "plate", .origin = "O"};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i);
    const Triple shoulder = scale(kBase, out[i]), wrist = add(O, scale(kPlate, out[i]));
    const Law law = Law::harmonics({{0.35, 0.5, static_cast<double>(i)}}, -0.35 * std::sin(static_cast<double>(i)));
    joints.add(Body{.name = "arm" + k})
        .joint("S" + k, Revolute{"ground", "arm" + k, shoulder, side[i]})
        .drive("motor" + k, DrivenCoordinate{"S" + k + ".angle", law});
    for (const double half : {-kHalf, kHalf}) {
      const std::string n = k + (half < 0 ? "L" : "R");
      joints.add(Body{.name = "rod" + n})
          .joint("E" + n, Spherical{"arm" + k, "rod" + n, add(elbow[i], scale(half, side[i]))})
          .joint("W" + n, Spherical{"rod" + n, "plate", add(wrist, scale(half, side[i]))});
    }
    by_hand.fixed_point("S" + k, shoulder)
        .fixed_vector("axis" + k, side[i])
        .point("E" + k, elbow[i])
        .constrain("rod" + k, Distance{"E" + k, "W" + k})
        .drive("motor" + k, PointAngle{"S" + k, "E" + k, "axis" + k, law});
    moved.points.push_back({"W" + k, scale(kPlate, out[i])});
  }
  joints.add(plate), by_hand.add(moved);
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("O").time(0, 2, kStep);
  return {translates ? "delta_translating" : "delta", joints.build(), by_hand.build()};
}

// Two arms, an upright and a tie rod to a rack; the lower arm and the rack are driven.
WrittenTwice wishbone() {
  const Triple LF = {0.15, 0.35, 0.2}, LR = {-0.22, 0.35, 0.19}, UF = {0.1, 0.42, 0.49}, UR = {-0.18, 0.42, 0.46};
  const Triple L = {0, 0.7, 0.18}, U = {-0.03, 0.665, 0.51}, T = {-0.13, 0.68, 0.26}, R = {-0.14, 0.36, 0.265};
  const Triple wheel = {0, 0.765, 0.32}, low = subtract(LF, LR), high = subtract(UF, UR);
  const Law travel = Law::harmonics({{0.15, 0.5, 0}}), steer = Law::harmonics({{0.04, 0.75, 0}});
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  joints.add(Body{.name = "upright", .points = {in_ground("wheel", wheel)}})
      .joint("lower", Revolute{"ground", "lower_arm", LF, low})
      .joint("upper", Revolute{"ground", "upper_arm", UF, high})
      .joint("L", Spherical{"lower_arm", "upright", L})
      .joint("U", Spherical{"upper_arm", "upright", U})
      .joint("T", Spherical{"tie_rod", "upright", T})
      .joint("R", Spherical{"rack", "tie_rod", R})
      .joint("guide", Prismatic{"ground", "rack", Triple{0, 1, 0}})
      .drive("travel", DrivenCoordinate{"lower.angle", travel})
      .drive("steering", DrivenCoordinate{"guide.displacement", steer});
  for (const char* name : {"lower_arm", "upper_arm", "tie_rod", "rack"}) joints.add(Body{.name = name});
  const auto foot = [](const Triple& at, const Triple& axis, const Triple& p) {
    const Triple u = unit(axis);
    return add(at, scale(triple::dot(subtract(p, at), u), u));
  };
  by_hand.fixed_point("lower", foot(LF, low, L))
      .fixed_point("upper", foot(UF, high, U))
      .fixed_point("guide", R)
      .fixed_vector("lower_axis", low)
      .fixed_vector("upper_axis", high)
      .fixed_vector("rail", {0, 1, 0})
      .point("L", L)
      .point("U", U)
      .point("T", T)
      .point("R", R)
      .add(Body{.name = "upright", .base = {"L", "U", "T"}, .points = {in_ground("wheel", wheel)}})
      .constrain("upper_arm", Distance{"upper", "U"})
      .constrain("upper_plane", Dot{Direction("upper", "U"), "upper_axis", 0.0})
      .constrain("tie_rod", Distance{"R", "T"})
      .constrain("slide", OnLine{"R", "guide", "rail"})
      .drive("travel", PointAngle{"lower", "L", "lower_axis", travel})
      .drive("steering", DrivenCoordinate{"slide.lambda", steer});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("wheel").output("U").output("T").time(0, 2, kStep);
  return {"wishbone", joints.build(), by_hand.build()};
}

}  // namespace

WrittenTwice spherical_four_bar(const std::array<double, 4>& away) {
  const Triple O = {0, 0, 0}, a = {0, 0, 1}, b = unit({0.4, 0, 1}), c = unit({0.6, 1, 0.6}), d = unit({1, 0.1, 0.35});
  const Triple A = scale(away[0], a), B = scale(away[1], b), C = scale(away[2], c), D = scale(away[3], d);
  SceneBuilder joints("joints", 3), by_hand("by_hand", 3);
  joints.add(Body{.name = "crank"})
      .add(Body{.name = "coupler"})
      .add(Body{.name = "rocker"})
      .joint("A", Revolute{"ground", "crank", A, a})
      .joint("B", Revolute{"crank", "coupler", B, b})
      .joint("C", Revolute{"coupler", "rocker", C, c})
      .joint("D", Revolute{"ground", "rocker", D, d})
      .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
  by_hand.fixed_point("A", {0, 0, B[2]})
      .fixed_point("O", O)
      .fixed_vector("a", a)
      .fixed_vector("d", d)
      .point("B", B)
      .point("C", C)
      .constrain("radius", Distance{"O", "C"})
      .constrain("coupler", Distance{"B", "C"})
      .constrain("rocker", Dot{Direction("O", "C"), "d"})
      .drive("motor", PointAngle{"A", "B", "a", Law::polynomial({0, kTurn})});
  for (SceneBuilder* s : {&joints, &by_hand}) s->output("C").time(0, 1, kStep);
  return {"spherical", joints.build(), by_hand.build()};
}

std::vector<WrittenTwice> space_mechanisms_by_hand() {
  return {rssr(),
          rscr(),
          slider_crank(),
          forward_hexapod(),
          inverse_hexapod(),
          delta(false),
          delta(true),
          wishbone(),
          spherical_four_bar({0.5, 1, 1, 1})};
}

}  // namespace assur::test
