// Plane mechanisms, written with joints and by hand.
#include <cmath>
#include <numbers>
#include <utility>

#include "joints/by_hand.hpp"

namespace assur::test {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kStep = 1.0 / 128;

Member in_ground(std::string name, const Triple& at) { return {std::move(name), at, true}; }
double distance(const Triple& a, const Triple& b) { return std::hypot(b[0] - a[0], b[1] - a[1]); }
double direction(const Triple& from, const Triple& to) { return std::atan2(to[1] - from[1], to[0] - from[0]); }

// The angle of a link from its posture as written.
void measure_turn(SceneBuilder& b, const std::string& name, const std::string& from, const std::string& to,
                  double written) {
  b.measure(name + "_absolute", AbsoluteAngle{from, to});
  b.measure(name, Combination{{{name + "_absolute", 1}}, -written});
}

WrittenTwice four_bar() {
  const Triple A = {0, 0}, B = {0.5, 0}, C = {1.6, 1.2}, D = {2, 0}, M = {1.1, 0.9};
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.add(Body{.name = "crank"})
      .add(Body{.name = "coupler", .points = {in_ground("M", M)}})
      .add(Body{.name = "rocker"})
      .joint("A", Revolute{"ground", "crank", A})
      .joint("B", Revolute{"crank", "coupler", B})
      .joint("C", Revolute{"coupler", "rocker", C})
      .joint("D", Revolute{"ground", "rocker", D})
      .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})})
      .measure("swing", MeasuredCoordinate{"D.angle"});
  by_hand.fixed_point("A", A)
      .fixed_point("D", D)
      .point("B", B)
      .point("C", C)
      .add(Body{.name = "coupler", .base = {"B", "C"}, .points = {in_ground("M", M)}})
      .constrain("rocker", Distance{"D", "C"})
      .drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, kTurn})});
  measure_turn(by_hand, "swing", "D", "C", direction(D, C));
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("C").output("M").output("swing").time(0, 1, kStep);
  return {"four_bar", joints.build(), by_hand.build()};
}

WrittenTwice slider_crank() {
  const Triple O = {0, 0}, B = {0.1, 0}, C = {0.4, 0.03}, M = {0.25, 0.02};
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.add(Body{.name = "crank"})
      .add(Body{.name = "rod", .points = {in_ground("M", M)}})
      .add(Body{.name = "piston"})
      .joint("O", Revolute{"ground", "crank", O})
      .joint("B", Revolute{"crank", "rod", B})
      .joint("C", Revolute{"rod", "piston", C})
      .joint("S", Prismatic{"ground", "piston", Triple{1, 0, 0}})
      .drive("motor", DrivenCoordinate{"O.angle", Law::polynomial({0, kTurn})})
      .measure("stroke", MeasuredCoordinate{"S.displacement"});
  by_hand.fixed_point("O", O)
      .fixed_point("A", C)
      .fixed_vector("rail", {1, 0})
      .point("B", B)
      .point("C", C)
      .add(Body{.name = "rod", .base = {"B", "C"}, .points = {in_ground("M", M)}})
      .constrain("slide", OnLine{"C", "A", "rail"})
      .drive("motor", PointAngle{"O", "B", "", Law::polynomial({0, kTurn})})
      .measure("stroke", MeasuredCoordinate{"slide.lambda"});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("C").output("M").output("stroke").time(0, 1, kStep);
  return {"slider_crank", joints.build(), by_hand.build()};
}

// The same with the end of the rod as the only output. By hand, a coordinate of this end is constant.
WrittenTwice slider_crank_end() {
  const Triple O = {0, 0}, B = {0.1, 0}, C = {0.4, 0.03};
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.add(Body{.name = "crank"})
      .add(Body{.name = "rod"})
      .add(Body{.name = "piston"})
      .joint("O", Revolute{"ground", "crank", O})
      .joint("B", Revolute{"crank", "rod", B})
      .joint("C", Revolute{"rod", "piston", C})
      .joint("S", Prismatic{"ground", "piston", Triple{1, 0, 0}})
      .drive("motor", DrivenCoordinate{"O.angle", Law::polynomial({0, kTurn})});
  by_hand.fixed_point("O", O)
      .point("B", B)
      .point("C", C)
      .constrain("rod", Distance{"B", "C"})
      .constrain("slide", FixedCoordinate{"C.y", C[1]})
      .drive("motor", PointAngle{"O", "B", "", Law::polynomial({0, kTurn})});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("C").time(0, 1, kStep);
  return {"slider_crank_end", joints.build(), by_hand.build()};
}

// A four-bar whose rocker has three joints, and a dyad on it.
WrittenTwice watt() {
  const Triple A = {0, 0}, B = {0.4, 0}, C = {1.5, 1.2}, D = {2, 0}, P = {2.6, 1}, Q = {4, 1.3}, E = {4.2, 0};
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.joint("A", Revolute{"ground", "crank", A})
      .joint("B", Revolute{"crank", "coupler", B})
      .joint("C", Revolute{"coupler", "rocker", C})
      .joint("D", Revolute{"ground", "rocker", D})
      .joint("P", Revolute{"rocker", "link", P})
      .joint("Q", Revolute{"link", "output", Q})
      .joint("E", Revolute{"ground", "output", E})
      .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
  for (const char* name : {"crank", "coupler", "rocker", "link", "output"}) joints.add(Body{.name = name});
  by_hand.fixed_point("A", A)
      .fixed_point("D", D)
      .fixed_point("E", E)
      .point("B", B)
      .point("C", C)
      .point("Q", Q)
      .add(Body{.name = "rocker", .base = {"D", "C"}, .points = {in_ground("P", P)}})
      .constrain("coupler", Distance{"B", "C"})
      .constrain("link", Distance{"P", "Q"})
      .constrain("output", Distance{"E", "Q"})
      .drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, kTurn})});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("C").output("Q").time(0, 1, kStep);
  return {"watt", joints.build(), by_hand.build()};
}

// A triangle on three bars, of which the crank moves one: a triad.
WrittenTwice stephenson() {
  const Triple A = {0, 0}, B = {0.1, 0}, D[] = {{2.2, -0.3}, {3, 2.4}};
  const Triple P[] = {{0.9, 0.1}, {1.9, 0.8}, {1.5, 1.5}};
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.add(Body{.name = "crank"})
      .add(Body{.name = "plate"})
      .joint("A", Revolute{"ground", "crank", A})
      .joint("B", Revolute{"crank", "bar0", B})
      .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
  by_hand.fixed_point("A", A).point("B", B).drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, kTurn})});
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i), bar = "bar" + k;
    joints.add(Body{.name = bar}).joint("P" + k, Revolute{bar, "plate", P[i]});
    if (i > 0) joints.joint("D" + k, Revolute{"ground", bar, D[i - 1]});
    if (i > 0) by_hand.fixed_point("D" + k, D[i - 1]);
    if (i < 2) by_hand.point("P" + k, P[i]);
    by_hand.constrain(bar, Distance{i > 0 ? "D" + k : "B", "P" + k});
  }
  by_hand.add(Body{.name = "plate", .base = {"P0", "P1"}, .points = {in_ground("P2", P[2])}});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("P0").output("P1").output("P2").time(0, 1, kStep);
  return {"stephenson", joints.build(), by_hand.build()};
}

// A block on the crank pin slides along an arm, which moves a ram by a rod.
WrittenTwice quick_return() {
  const Triple O = {0, 0.5}, B = {0.2, 0.6}, Q = {0, 0}, E = {0.4, 1.2}, C = {1.1, 1.3};
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.joint("O", Revolute{"ground", "crank", O})
      .joint("B", Revolute{"crank", "block", B})
      .joint("S", Prismatic{"arm", "block", Triple{0.2, 0.6}})
      .joint("Q", Revolute{"ground", "arm", Q})
      .joint("E", Revolute{"arm", "rod", E})
      .joint("C", Revolute{"rod", "ram", C})
      .joint("R", Prismatic{"ground", "ram", Triple{1, 0}})
      .drive("motor", DrivenCoordinate{"O.angle", Law::polynomial({0, kTurn})})
      .measure("stroke", MeasuredCoordinate{"R.displacement"});
  for (const char* name : {"crank", "block", "arm", "rod", "ram"}) joints.add(Body{.name = name});
  by_hand.fixed_point("O", O)
      .fixed_point("Q", Q)
      .fixed_point("G", C)
      .fixed_vector("rail", {1, 0})
      .point("B", B)
      .point("E", E)
      .point("C", C)
      .add(Body{.name = "arm", .base = {"Q", "E"}, .vectors = {in_ground("across", {-0.6, 0.2})}})
      .constrain("slot", Dot{Direction("Q", "B"), "across", 0.0})
      .constrain("rod", Distance{"E", "C"})
      .constrain("slide", OnLine{"C", "G", "rail"})
      .drive("motor", PointAngle{"O", "B", "", Law::polynomial({std::atan2(0.1, 0.2), kTurn})})
      .measure("stroke", MeasuredCoordinate{"slide.lambda"});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("E").output("C").output("stroke").time(0, 1, kStep);
  return {"quick_return", joints.build(), by_hand.build()};
}

// Boom, stick and bucket, moved by three cylinders; the bucket by a rocker and a link.
WrittenTwice excavator() {
  const Triple O = {0, 1.6}, F = {0.5, 0.9}, S = {5.24, 3.84}, T = {6.63, 1.29}, H = {7.07, 2.04}, J = {7.05, 1.44};
  const Triple boom_eye = {2.1, 3.1}, stick_foot = {2.4, 3.7}, stick_eye = {4.9, 4.5};
  const Triple bucket_foot = {6, 4}, rocker_foot = {6.52, 1.7}, tip = {6.1, 0};
  struct Cylinder {
    std::string name;
    Triple foot, eye;
    double stroke, phase;
  };
  const Cylinder cylinders[] = {{"boom_cylinder", F, boom_eye, 0.25, 0},
                                {"stick_cylinder", stick_foot, stick_eye, 0.25, 1},
                                {"bucket_cylinder", bucket_foot, H, 0.15, 2}};
  const auto law = [](const Cylinder& c) {
    return Law::harmonics({{c.stroke, 0.5, c.phase}}, -c.stroke * std::sin(c.phase));
  };
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.joint("O", Revolute{"ground", "boom", O})
      .joint("S", Revolute{"boom", "stick", S})
      .joint("T", Revolute{"stick", "bucket", T})
      .joint("G", Revolute{"stick", "rocker", rocker_foot})
      .joint("H", Revolute{"rocker", "link", H})
      .joint("J", Revolute{"link", "bucket", J})
      .add(Body{.name = "bucket", .points = {in_ground("tip", tip)}});
  for (const char* name : {"boom", "stick", "rocker", "link"}) joints.add(Body{.name = name});
  const std::pair<std::string, std::string> on[] = {{"ground", "boom"}, {"boom", "stick"}, {"stick", "rocker"}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Cylinder& c = cylinders[i];
    const Triple way = {c.eye[0] - c.foot[0], c.eye[1] - c.foot[1], 0};
    joints.add(Body{.name = c.name})
        .add(Body{.name = c.name + "_rod"})
        .joint(c.name + "_foot", Revolute{on[i].first, c.name, c.foot})
        .joint(c.name + "_slide", Prismatic{c.name, c.name + "_rod", way})
        .joint(c.name + "_eye", Revolute{c.name + "_rod", on[i].second, c.eye})
        .drive(c.name + "_pump", DrivenCoordinate{c.name + "_slide.displacement", law(c)});
    const std::string foot[] = {"F", "stick_foot", "bucket_foot"}, eye[] = {"boom_eye", "stick_eye", "H"};
    by_hand.drive(c.name, DrivenDistance{foot[i], eye[i], Law::polynomial({distance(c.foot, c.eye)}) + law(c)});
  }
  by_hand.fixed_point("O", O)
      .fixed_point("F", F)
      .point("S", S)
      .point("T", T)
      .point("H", H)
      .point("J", J)
      .add(Body{.name = "boom",
                .base = {"O", "S"},
                .points = {in_ground("boom_eye", boom_eye), in_ground("stick_foot", stick_foot)}})
      .add(Body{.name = "stick",
                .base = {"S", "T"},
                .points = {in_ground("stick_eye", stick_eye), in_ground("bucket_foot", bucket_foot),
                           in_ground("rocker_foot", rocker_foot)}})
      .add(Body{.name = "bucket", .base = {"T", "J"}, .points = {in_ground("tip", tip)}})
      .constrain("rocker", Distance{"rocker_foot", "H"})
      .constrain("link", Distance{"H", "J"});
  for (SceneBuilder* b : {&joints, &by_hand}) b->output("tip").output("T").time(0, 2, kStep);
  return {"excavator", joints.build(), by_hand.build()};
}

WrittenTwice chain(int loops) {
  const Triple A = {0, 0}, B = {0.3, 0};
  SceneBuilder joints("joints", 2), by_hand("by_hand", 2);
  joints.add(Body{.name = "link0"})
      .joint("A", Revolute{"ground", "link0", A})
      .joint("C0", Revolute{"link0", "coupler1", B})
      .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
  by_hand.fixed_point("A", A).point("C0", B).drive("motor", PointAngle{"A", "C0", "", Law::polynomial({0, kTurn})});
  for (int i = 1; i <= loops; ++i) {
    const std::string k = std::to_string(i), before = std::to_string(i - 1), after = std::to_string(i + 1);
    const Triple D = {2.0 * i, 0}, C = {2.0 * i + 0.1 * (i % 3 - 1), 1};
    joints.add(Body{.name = "coupler" + k})
        .add(Body{.name = "link" + k})
        .joint("C" + k, Revolute{"coupler" + k, "link" + k, C})
        .joint("D" + k, Revolute{"ground", "link" + k, D});
    if (i < loops) joints.joint("E" + k, Revolute{"link" + k, "coupler" + after, C});
    by_hand.fixed_point("D" + k, D)
        .point("C" + k, C)
        .constrain("coupler" + k, Distance{"C" + before, "C" + k})
        .constrain("link" + k, Distance{"D" + k, "C" + k});
    joints.output("C" + k), by_hand.output("C" + k);
  }
  for (SceneBuilder* b : {&joints, &by_hand}) b->time(0, 1, kStep);
  return {"chain", joints.build(), by_hand.build()};
}

}  // namespace

std::vector<WrittenTwice> plane_mechanisms_by_hand() {
  return {four_bar(), slider_crank(), slider_crank_end(), watt(), stephenson(), quick_return(), excavator(), chain(20)};
}

}  // namespace assur::test
