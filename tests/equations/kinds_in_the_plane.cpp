#include "equations/kinds.hpp"
#include "references/planar.hpp"

namespace assur::kinds {
namespace {

using namespace references;  // NOLINT

Where heading(const QuadJet& angle) { return {cos(angle), sin(angle), QuadJet{}}; }
Where left_of(const Where& v) { return {-v[1], v[0], QuadJet{}}; }

// P at the end of a crank of radius 0.75 about A = (0, 0).
Where crank(double t) { return QuadJet{0.75} * heading(at(kTurn, t)); }
SceneBuilder with_crank(const char* name, const Path& path) {
  SceneBuilder b(name, 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0.25, 0}).point("P", start(path, "P"));
  b.constrain("crank", Distance{"A", "P", 0.75}).drive("motor", PointAngle{"A", "P", "", kTurn});
  grid(b);
  return b;
}
Path path_of(std::function<void(double, Posture<QuadJet>&)> rest) {
  return [rest](double t) {
    Posture<QuadJet> posture = {{"P", crank(t)}};
    rest(t, posture);
    return posture;
  };
}
Kind kind(const std::string& name, const SceneBuilder& b, const Path& path) { return {name, b.build(), path}; }

Kind distances() {
  const Path path =
      path_of([](double t, auto& p) { p["C"] = intersect_circles(crank(t), 1.75, fixed(2, 0.25), 1.25); });
  SceneBuilder b = with_crank("distance", path);
  place(b, path, {"C"}).constrain("coupler", Distance{"P", "C", 1.75}).constrain("rocker", Distance{"D", "C", {}});
  return kind("distance", b, path);
}

Kind equal_distances() {  // |P - D| = |Q - A|, Q on the line y = 1/2
  const Path path = path_of([](double t, auto& p) {
    const Where d = crank(t) - fixed(2, 0.25);
    p["Q"] = {sqrt(dot(d, d) - 0.25), QuadJet{0.5}, QuadJet{}};
  });
  SceneBuilder b = with_crank("equal", path);
  place(b, path, {"Q"})
      .constrain("equal", EqualDistance{"P", "D", "Q", "A"})
      .constrain("height", FixedCoordinate{"Q.y", 0.5});
  return kind("equal_distance and coordinate", b, path);
}

Kind dots() {
  const Path path = path_of([](double t, auto& p) {
    p["u"] = heading(at(kTurn, t) + 0.5);                                         // 0.5 rad ahead of the crank
    p["Q"] = crank(t) + QuadJet{0.5} * p["u"] + QuadJet{0.25} * left_of(p["u"]);  // 0.5 along u, 0.25 left of u
  });
  SceneBuilder b = with_crank("dot", path);
  place(b, path, {"Q"}, {"u"});
  b.constrain("pair_vector", Dot{{"A", "P"}, "u", 0.75 * std::cos(0.5)});
  b.constrain("vector_pair", Dot{"u", {"P", "Q"}, 0.5});
  b.constrain("pair_pair", Dot{{"A", "P"}, {"P", "Q"}, 0.75 * (0.5 * std::cos(0.5) - 0.25 * std::sin(0.5))});
  return kind("dot", b, path);
}

Kind fixed_direction() {  // dot with a fixed vector that has a zero; its value comes from the drawing
  const Path path = path_of([](double t, auto& p) {
    const Where P = crank(t);
    p["Q"] = {QuadJet{1.25}, P[1] + sqrt(QuadJet{4} - (P[0] - 1.25) * (P[0] - 1.25)), QuadJet{}};
  });
  SceneBuilder b = with_crank("fixed", path);
  b.fixed_vector("x", {1, 0, 0});
  place(b, path, {"Q"}).constrain("across", Dot{{"A", "Q"}, "x", {}}).constrain("rod", Distance{"P", "Q", 2.0});
  return kind("dot with a fixed direction", b, path);
}

Kind parallels() {
  const Path path = path_of([](double t, auto& p) {
    p["u"] = heading(at(kTurn, t));
    p["along.lambda"] = scalar(QuadJet{Quad(1) / Quad(0.75)});
    p["Q"] = crank(t) + QuadJet{0.5} * p["u"];
    p["back.lambda"] = scalar(QuadJet{0.5});
  });
  SceneBuilder b = with_crank("parallel", path);
  place(b, path, {"Q"}, {"u"}).constrain("along", Parallel{{"A", "P"}, "u"});
  b.constrain("back", Parallel{"u", {"P", "Q"}}).constrain("offset", Distance{"P", "Q", 0.5});
  return kind("parallel", b, path);
}

Kind linears() {
  const Path path = path_of([](double t, auto& p) {
    p["u"] = heading(at(kTurn, t) - 0.25);
    p["Q"] = QuadJet{0.5} * (crank(t) + fixed(2, 0.25)) + QuadJet{0.375} * p["u"] + fixed(0.5, 0);
    p["n"] = p["u"] - fixed(0, 0.125);
  });
  SceneBuilder b = with_crank("linear", path);
  place(b, path, {"Q"}, {"u"}).vector("n", start(path, "n"), false);
  b.constrain("turned", Dot{{"A", "P"}, "u", 0.75 * std::cos(0.25)});
  b.constrain("mixed", Linear{{{"Q", 2}, {"P", -1}, {"D", -1}, {"u", -0.75}}, {1, 0, 0}});
  b.constrain("vectors", Linear{{{"n", 1}, {"u", -1}}, {0, -0.125, 0}});
  return kind("linear", b, path);
}

Kind lines() {
  const Path path = path_of([](double t, auto& p) {
    const QuadJet s = at(kSlide, t);
    p["Q"] = fixed(2, 0.25) + s * fixed(0.6, 0.8);  // Q is on a fixed line, and its displacement is driven
    p["rail.lambda"] = scalar(s);
    p["R"] = p["Q"] + QuadJet{0.25} * (crank(t) - p["Q"]);  // a quarter of the way from Q to P
    p["pair.lambda"] = scalar(QuadJet{0.25});
  });
  SceneBuilder b = with_crank("on_line", path);
  b.fixed_vector("d", {0.6, 0.8, 0});
  place(b, path, {"Q", "R"})
      .constrain("rail", OnLine{"Q", "D", "d"})
      .drive("slider", DrivenCoordinate{"rail.lambda", kSlide});
  b.constrain("pair", OnLine{"R", "Q", {"Q", "P"}}).constrain("quarter", FixedCoordinate{"pair.lambda", 0.25});
  return kind("on_line and lambda", b, path);
}

Kind relative_angle() {
  const Path path = path_of([](double t, auto& p) {
    const Where e = heading(at(kTurn, t) + at(kSwing, t));
    p["Q"] = crank(t) + QuadJet{1.25} * e;
    p["elbow.rho"] = scalar(QuadJet{Quad(0.75) * Quad(1.25)});
    p["u"] = heading(at(kTurn, t) + at(kSwing, t) - at(kSlide, t));
    p["wrist.rho"] = scalar(QuadJet{1.25});
  });
  SceneBuilder b = with_crank("relative", path);
  place(b, path, {"Q"}, {"u"}).constrain("arm", Distance{"P", "Q", 1.25});
  b.drive("elbow", RelativeAngle{{"A", "P"}, {"P", "Q"}, "", kSwing});
  b.drive("wrist", RelativeAngle{"u", {"P", "Q"}, "", kSlide});
  return kind("relative angle", b, path);
}

// The centre of an arm is fixed, driven, or unknown. The arm may belong to a declared group.
Kind arms() {
  const Path path = path_of([](double t, auto& p) {
    p["Q"] = crank(t) + QuadJet{0.5} * heading(at(kSwing, t));
    p["C"] = intersect_circles(p["Q"], 1.75, fixed(2, 0.25), 1.25);
    p["E"] = p["C"] + QuadJet{0.625} * heading(at(kSlide, t));
    p["F"] = p["E"] + QuadJet{0.25} * heading(at(kTurn, t));
  });
  SceneBuilder b = with_crank("arms", path);
  place(b, path, {"Q", "C", "E", "F"});
  b.constrain("l1", Distance{"Q", "P", 0.5})
      .constrain("l2", Distance{"E", "C", 0.625})
      .constrain("l3", Distance{"E", "F", 0.25});
  b.constrain("coupler", Distance{"Q", "C", 1.75}).constrain("rocker", Distance{"D", "C", 1.25});
  b.drive("second", PointAngle{"P", "Q", "", kSwing}).drive("third", PointAngle{"C", "E", "", kSlide});
  b.drive("fourth", PointAngle{"E", "F", "", kTurn});
  b.add(DeclaredGroup{"last", {"F"}});
  return kind("absolute angle", b, path);
}

Kind actuators() {
  const Path path = path_of([](double t, auto& p) {
    const QuadJet s = at(kSlide, t) + 1.0;
    const Where A = fixed(0, 0), D = fixed(2, 0.25), d = D - A;
    const QuadJet square = dot(d, d), along = (square + 2.25 - s * s) / (2 * square);
    p["Q"] = along * d + sqrt(QuadJet{2.25} / square - along * along) * left_of(d);
    p["R"] = {at(kSlide, t), QuadJet{0.5}, QuadJet{}};
    p["S"] = {at(kSwing, t), at(kSlide, t), QuadJet{}};
  });
  SceneBuilder b = with_crank("actuators", path);
  place(b, path, {"Q", "R", "S"}).constrain("rod", Distance{"A", "Q", 1.5});
  b.drive("cylinder", DrivenDistance{"Q", "D", kSlide + Law::constant(1)});
  b.drive("rx", DrivenCoordinate{"R.x", kSlide}).constrain("ry", FixedCoordinate{"R.y", 0.5});
  b.drive("sx", DrivenCoordinate{"S.x", kSwing}).drive("sy", DrivenCoordinate{"S.y", kSlide});
  b.add(DeclaredGroup{"declared", {"S"}});
  return kind("distance and coordinate drivers", b, path);
}

// A coupler with members. The length of its base is a constraint, or belongs to the body.
Kind base(bool written, bool poor = false) {
  const Path path = path_of([](double t, auto& p) {
    p["C"] = intersect_circles(crank(t), 1.75, fixed(2, 0.25), 1.25);
    const Where along = QuadJet{Quad(1) / Quad(1.75)} * (p["C"] - p["P"]);
    p["X"] = p["P"] + QuadJet{0.5} * along + QuadJet{-0.25} * left_of(along) - fixed(0, 1.5);
  });
  SceneBuilder b = with_crank("base", path);
  const Triple c = start(path, "C");
  b.point("C", poor ? Triple{1.0625 * c[0], 1.0625 * c[1], 0} : c);  // a poor guess does not change the shape
  place(b, path, {"X"}).constrain("rocker", Distance{"D", "C", 1.25});
  if (written) b.constrain("coupler", Distance{"C", "P", 1.75});
  b.add(Body{"coupler_body", "", {}, {"P", "C"}, {{"M", {0.5, -0.25, 0}}}, {{"m", {0.6, 0.8, 0}}}});
  b.constrain("hangs", Linear{{{"X", 1}, {"M", -1}}, {0, -1.5, 0}});
  Kind k = kind("body on two points" + std::string(written ? ", length written" : "") + (poor ? ", poor guess" : ""), b,
                path);
  k.members = [path](double t) {
    const Posture<QuadJet> p = path(t);
    const Where along = QuadJet{Quad(1) / Quad(1.75)} * (p.at("C") - p.at("P"));
    return Posture<QuadJet>{
        {"M", p.at("P") + QuadJet{0.5} * along + QuadJet{-0.25} * left_of(along)},
        {"m", QuadJet{unit<Quad>({0.6, 0.8, 0})[0]} * along + QuadJet{unit<Quad>({0.6, 0.8, 0})[1]} * left_of(along)}};
  };
  return k;
}

// The pose drives the whole body; X is connected to a member.
Kind pose(const std::string& base, bool declared) {
  const auto member = [base](double t) {
    const Where u = base == "translating" ? fixed(1, 0) : heading(at(kSwing, t));
    return Where{at(kSlide, t), at(kTurn, t), QuadJet{}} + QuadJet{0.5} * u + QuadJet{0.25} * left_of(u);
  };
  const Path path = [=](double t) {
    Posture<QuadJet> p;
    p["O"] = {at(kSlide, t), at(kTurn, t), QuadJet{}};
    if (base == "frame") p["u"] = heading(at(kSwing, t));
    if (base == "base") p["E"] = p["O"] + QuadJet{1.5} * heading(at(kSwing, t));
    p["X"] = member(t) + fixed(0.125, 0);
    return p;
  };
  SceneBuilder b("pose", 2);
  grid(place(b, path, {"O", "X"}));
  Body body{"body", "O", {}, {}, {{"M", {0.5, 0.25, 0}}}, {}};
  DeclaredGroup group{"whole", {"O"}};
  Pose driver{"body", {kSlide, kTurn}, {kSwing}};
  if (base == "frame") {
    b.vector("u", start(path, "u"));
    body.frame = {"u"};
    group.unknowns.push_back("u");
  } else if (base == "base") {
    b.point("E", start(path, "E"));
    body.origin = "";
    body.base = {"O", "E"};
    group.unknowns.push_back("E");
  } else {
    driver.rotation.clear();
  }
  b.add(body).drive("pose", driver).constrain("hangs", Linear{{{"X", 1}, {"M", -1}}, {0.125, 0, 0}});
  if (declared) b.add(group);
  Kind k = kind("pose of a body, " + base + (declared ? ", declared" : ""), b, path);
  k.members = [member](double t) { return Posture<QuadJet>{{"M", member(t)}}; };
  return k;
}

}  // namespace

std::vector<Kind> in_the_plane() {
  std::vector<Kind> all = {distances(),     equal_distances(), dots(), fixed_direction(), parallels(), linears(),
                           lines(),         relative_angle(),  arms(), actuators(),       base(false), base(true),
                           base(true, true)};
  for (const std::string base : {"frame", "base", "translating"}) {
    for (const bool declared : {false, true}) all.push_back(pose(base, declared));
  }
  return all;
}

}  // namespace assur::kinds
