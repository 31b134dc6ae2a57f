#include <numbers>

#include "equations/kinds.hpp"

namespace assur::kinds {
namespace {

using namespace references;  // NOLINT

QuadJet number(double x) { return QuadJet{x}; }
Where exact(const Triple& a) { return exactly<QuadJet>(a); }

// v turned about the unit axis n (Rodrigues).
Where turned(const Where& v, const Where& n, const QuadJet& angle) {
  const QuadJet c = cos(angle);
  return c * v + sin(angle) * cross(n, v) + ((QuadJet{1} - c) * dot(n, v)) * n;
}

// A body in free motion: origin O, axes u, v, w = Rz(psi) Ry(theta) Rx(phi).
struct Motion3 {
  std::vector<Law> translation = {kSlide, kSwing, Law::polynomial({0.25, -0.5, 0.25})};
  std::vector<Law> rotation = {kTurn, Law::harmonics({{0.3, 0.2, 0.1}}), Law::polynomial({-0.2, 0.4})};

  Where origin(double t) const { return {at(translation[0], t), at(translation[1], t), at(translation[2], t)}; }
  Where axis(int j, double t) const {
    const Where x = fixed(1, 0, 0), y = fixed(0, 1, 0), z = fixed(0, 0, 1);
    Where a = j == 0 ? x : j == 1 ? y : z;
    a = turned(a, x, at(rotation[2], t));
    a = turned(a, y, at(rotation[1], t));
    return turned(a, z, at(rotation[0], t));
  }
  Where vector(const Triple& local, double t) const {
    return number(local[0]) * axis(0, t) + number(local[1]) * axis(1, t) + number(local[2]) * axis(2, t);
  }
  Where point(const Triple& local, double t) const { return origin(t) + vector(local, t); }
  void frame(double t, Posture<QuadJet>& p) const {
    p["O"] = origin(t);
    p["u"] = axis(0, t);
    p["v"] = axis(1, t);
    p["w"] = axis(2, t);
  }
};
const Motion3 kMotion;

// The pose drives O, u, v, w; `rest` adds the other parts.
Path path_of(std::function<void(double, Posture<QuadJet>&)> rest) {
  return [rest](double t) {
    Posture<QuadJet> p;
    kMotion.frame(t, p);
    rest(t, p);
    return p;
  };
}
SceneBuilder with_body(const char* name, const Path& path) {
  SceneBuilder b(name, 3);
  b.fixed_point("A", {0.5, -1, 0.25});
  place(b, path, {"O"}, {"u", "v", "w"});
  b.add(Body{"body", "O", {"u", "v", "w"}, {}, {{"M", {0.5, 0.25, -0.75}}}, {}});
  b.drive("pose", Pose{"body", kMotion.translation, kMotion.rotation});
  grid(b);
  return b;
}
Where member(double t) { return kMotion.point({0.5, 0.25, -0.75}, t); }
const Triple kA = {0.5, -1, 0.25}, kB = {0.5, 0.25, 0.25};
Kind kind(const std::string& name, const SceneBuilder& b, const Path& path) { return {name, b.build(), path}; }

// ---- bodies and poses

Kind pose(const std::string& base, bool declared) {
  const Triple local = base == "flat base" ? Triple{0.5, 0.25, 0} : Triple{0.5, 0.25, -0.75};
  const bool turns = base != "translating";
  const auto at_member = [=](double t) { return turns ? kMotion.point(local, t) : kMotion.origin(t) + exact(local); };
  const bool on_points = base == "base" || base == "flat base";
  const Path path = [=](double t) {
    Posture<QuadJet> p;
    if (base == "frame") {
      kMotion.frame(t, p);
    } else if (on_points) {
      p["E1"] = kMotion.origin(t);
      p["E2"] = kMotion.point({1.5, 0, 0}, t);
      p["E3"] = kMotion.point({0.25, 1.25, 0}, t);
      if (base == "base") p["body.normal"] = kMotion.axis(2, t);
    } else {
      p["O"] = kMotion.origin(t);
    }
    p["X"] = at_member(t) - fixed(0, 0, 0.125);
    return p;
  };
  SceneBuilder b("pose", 3);
  grid(b);
  Body body{"body", "O", {}, {}, {{"M", local}}, {}};
  Pose driver{"body", kMotion.translation, kMotion.rotation};
  DeclaredGroup group{"whole", {"O"}};
  if (base == "frame") {
    place(b, path, {"O"}, {"u", "v", "w"});
    body.frame = {"u", "v", "w"};
    body.vectors = {{"t", {0, 0.6, 0.8}}};
    group.unknowns = {"O", "u", "v", "w"};
  } else if (on_points) {
    place(b, path, {"E1", "E2", "E3"});
    body.origin = "";
    body.base = {"E1", "E2", "E3"};
    group.unknowns = body.base;
  } else {
    place(b, path, {"O"});
    driver.rotation.clear();
  }
  place(b, path, {"X"}).add(body).drive("pose", driver);
  b.constrain("hangs", Linear{{{"M", 2}, {"X", -2}}, {0, 0, 0.25}});
  if (declared) b.add(group);
  Kind k = kind("pose of a body, " + base + (declared ? ", declared" : ""), b, path);
  k.members = [=](double t) {
    Posture<QuadJet> m = {{"M", at_member(t)}};
    if (base == "frame") m["t"] = kMotion.vector({0, 0.6, 0.8}, t);
    return m;
  };
  return k;
}

// Six actuators of a free body. The joints on ground and body do not form similar hexagons.
Kind actuated(bool on_points, bool poor = false) {
  const Triple ground[6] = {{1, 0, -1},     {0.5, 1, -1.5}, {-0.5, 1.25, -1},
                            {-1, 0, -1.25}, {-0.5, -1, -1}, {0.75, -1, -1.5}};
  const Triple joint[6] = {{0.5, -0.25, 0.125}, {0.5, 0.25, 0},      {0, 0.5, -0.25},
                           {-0.25, 0.5, 0},     {-0.5, -0.25, 0.25}, {0, -0.5, 0}};
  const Path path = [=](double t) {
    Posture<QuadJet> p;
    if (on_points) {
      p["E1"] = kMotion.origin(t);
      p["E2"] = kMotion.point({1.5, 0, 0}, t);
      p["E3"] = kMotion.point({0.25, 1.25, 0}, t);
      p["body.normal"] = kMotion.axis(2, t);
    } else {
      kMotion.frame(t, p);
    }
    return p;
  };
  Body body{"body", "O", {"u", "v", "w"}, {}, {}, {}};
  if (on_points) body = {"body", "", {}, {"E1", "E2", "E3"}, {}, {}};
  SceneBuilder b("actuated", 3);
  grid(b);
  if (on_points) {
    const Triple third = start(path, "E3");
    place(b, path, {"E1", "E2"}).point("E3", poor ? Triple{third[0] + 0.0625, third[1], third[2] - 0.0625} : third);
    // One edge of the body is a constraint, too. Its value keeps the shape of the body even if the guess is poor.
    b.constrain("edge", Distance{"E3", "E1", std::sqrt(1.625)});
    if (poor) b.constrain("other", Distance{"E2", "E3", std::sqrt(3.125)});
  } else {
    place(b, path, {"O"}, {"u", "v", "w"});
  }
  for (int i = 0; i < 6; ++i) {
    const std::string k = std::to_string(i);
    const Triple g = ground[i], l = joint[i];
    b.fixed_point("A" + k, g);
    body.points.push_back({"P" + k, l});
    b.drive("leg" + k, DrivenDistance{"A" + k, "P" + k, Law::function([g, l](double t) {
                                        const Where d = kMotion.point(l, t) - exact(g);
                                        const QuadJet s = sqrt(dot(d, d));
                                        return Motion{static_cast<double>(s.value), static_cast<double>(s.rate),
                                                      static_cast<double>(s.acceleration)};
                                      })});
  }
  b.add(body);
  Kind k = kind(on_points ? std::string("body on three points") + (poor ? ", poor guess" : "") : "body with a frame", b,
                path);
  k.members = [joint = std::vector<Triple>(joint, joint + 6)](double t) {
    Posture<QuadJet> m;
    for (std::size_t i = 0; i < 6; ++i) m["P" + std::to_string(i)] = kMotion.point(joint[i], t);
    return m;
  };
  return k;
}

// One of the three axes of the frame is fixed.
Kind hinged(int fixed_axis) {
  const std::string name[3] = {"u", "v", "w"};
  const std::string &n = name[fixed_axis], &a = name[(fixed_axis + 1) % 3], &c = name[(fixed_axis + 2) % 3];
  const Path path = [a, c](double t) {
    const Where z = fixed(0, 0, 1);
    Posture<QuadJet> p;
    p[a] = turned(fixed(1, 0, 0), z, at(kTurn, t));
    p[c] = cross(z, p[a]);
    p["hinge.rho"] = scalar(number(1));
    return p;
  };
  SceneBuilder b("hinged", 3);
  grid(b).fixed_point("A", kA).fixed_vector(n, {0, 0, 1}).fixed_vector("zero", {1, 0, 0});
  place(b, path, {}, {a, c});
  b.add(Body{"door", "A", {"u", "v", "w"}, {}, {{"M", {0.5, 0.25, -0.75}}}, {}});
  b.drive("hinge", RelativeAngle{"zero", a, n, kTurn});
  Kind k = kind("frame with the fixed axis " + n, b, path);
  k.members = [=](double t) {
    Posture<QuadJet> p = path(t);
    p[n] = fixed(0, 0, 1);
    return Posture<QuadJet>{{"M", exact(kA) + number(0.5) * p["u"] + number(0.25) * p["v"] - number(0.75) * p["w"]}};
  };
  return k;
}

// ---- constraints

Kind distances() {
  const Path path = path_of([](double t, auto& p) { p["X"] = kMotion.point({1, 1, 1}, t); });
  SceneBuilder b = with_body("distance", path);
  b.add(Body{"more", "O", {"u", "v", "w"}, {}, {{"M2", {1.5, 0, 0}}}, {}});
  place(b, path, {"X"});
  b.constrain("OX", Distance{"X", "O", std::sqrt(3.0)});
  b.constrain("MX", Distance{"M", "X", std::sqrt(0.25 + 0.5625 + 3.0625)});
  b.constrain("M2X", Distance{"X", "M2", 1.5});
  return kind("distance", b, path);
}

Kind equal_distances() {  // |X - B| = |O - M| = |X - O|; X.x is driven
  const Path path = path_of([](double t, auto& p) {
    const QuadJet x = at(kSlide, t) * 0.25, square = number(0.25 + 0.0625 + 0.5625);
    // X = B + r with r.x known, |r|^2 = square and |r - (O - B)|^2 = square, solved in the plane of y and z.
    const Where d = p["O"] - exact(kB);
    const QuadJet rx = x - kB[0].value(), dd = d[1] * d[1] + d[2] * d[2], k = dot(d, d) / 2 - rx * d[0];
    const QuadJet along = k / dd, rest = sqrt((square - rx * rx) / dd - along * along);
    p["X"] = exact(kB) + Where{rx, along * d[1] - rest * d[2], along * d[2] + rest * d[1]};
  });
  SceneBuilder b = with_body("equal", path);
  b.fixed_point("B", kB);
  place(b, path, {"X"})
      .constrain("first", EqualDistance{"X", "B", "M", "O"})
      .constrain("second", EqualDistance{"X", "B", "O", "X"});
  b.drive("x", DrivenCoordinate{"X.x", follow_coordinate(path, "X", 0)});
  return kind("equal_distance", b, path);
}

Kind dots() {
  const Path path = path_of([](double t, auto& p) {
    p["X"] = kMotion.point({0.25, -0.5, 1}, t);
    p["e"] = turned(p["u"], p["w"], number(0.5));
  });
  SceneBuilder b = with_body("dot", path);
  place(b, path, {"X"}, {"e"});
  b.constrain("x", Dot{{"O", "X"}, "u", 0.25}).constrain("y", Dot{"v", {"O", "X"}, -0.5});
  b.constrain("pairs", Dot{{"O", "X"}, {"O", "M"}, 0.125 - 0.125 - 0.75});
  b.constrain("across", Dot{"e", "w", 0.0}).constrain("angle", Dot{"e", "v", std::sin(0.5)});
  return kind("dot", b, path);
}

Kind parallels() {
  const Path path = path_of([](double t, auto& p) {
    const Where d = member(t) - p["O"];
    p["e"] = unit(d);
    const QuadJet length = sqrt(dot(d, d));
    p["same.lambda"] = scalar(number(1) / length);
    p["X"] = exact(kA) + number(0.75) * p["w"];
    p["pair.lambda"] = scalar(number(0.75));
  });
  SceneBuilder b = with_body("parallel", path);
  place(b, path, {"X"}, {"e"}).constrain("same", Parallel{{"O", "M"}, "e"});
  b.constrain("pair", Parallel{"w", {"A", "X"}}).constrain("offset", FixedCoordinate{"pair.lambda", 0.75});
  return kind("parallel", b, path);
}

Kind lines_and_planes() {
  const Path path = path_of([](double t, auto& p) {
    const QuadJet s = at(kSlide, t), r = at(kSwing, t);
    p["X"] = p["O"] + s * p["v"];
    p["line.lambda"] = scalar(s);
    p["Y"] = exact(kA) + number(0.375) * (member(t) - p["O"]);
    p["pair.lambda"] = scalar(number(0.375));
    p["Z"] = member(t) + r * p["u"] + number(-0.5) * (p["X"] - p["O"]);
    p["plane.lambda"] = scalar(r);
    p["plane.mu"] = scalar(number(-0.5));
  });
  SceneBuilder b = with_body("lines", path);
  place(b, path, {"X", "Y", "Z"});
  b.constrain("line", OnLine{"X", "O", "v"}).drive("slider", DrivenCoordinate{"line.lambda", kSlide});
  b.constrain("pair", OnLine{"Y", "A", {"O", "M"}}).constrain("quarter", FixedCoordinate{"pair.lambda", 0.375});
  b.constrain("plane", OnPlane{"Z", "M", "u", {"O", "X"}});
  b.drive("r", DrivenCoordinate{"plane.lambda", kSwing}).constrain("half", FixedCoordinate{"plane.mu", -0.5});
  return kind("on_line and on_plane", b, path);
}

Kind linears() {
  const Path path = path_of([](double t, auto& p) {
    p["X"] = number(0.5) * (p["O"] + exact(kA)) + number(0.25) * p["v"] + fixed(0, 0, 0.5);
    p["n"] = number(0.5) * (p["u"] + p["v"]) - fixed(0.125, 0, 0);
    p["Y"] = {p["X"][0], number(0.75), at(kSlide, t)};
  });
  SceneBuilder b = with_body("linear", path);
  place(b, path, {"X", "Y"}).vector("n", start(path, "n"), false);
  b.constrain("mixed", Linear{{{"X", 2}, {"O", -1}, {"A", -1}, {"v", -0.5}}, {0, 0, 1}});
  b.constrain("vectors", Linear{{{"n", 1}, {"u", -0.5}, {"v", -0.5}}, {-0.125, 0, 0}});
  b.constrain("y", FixedCoordinate{"Y.y", 0.75}).drive("z", DrivenCoordinate{"Y.z", kSlide});
  b.drive("x", DrivenCoordinate{"Y.x", follow_coordinate(path, "X", 0)}).add(DeclaredGroup{"Y_declared", {"Y"}});
  return kind("linear and coordinate", b, path);
}

// ---- angles

Kind arms() {
  const Triple axis = {0, 0.6, 0.8}, at_start = {0.75, 0.25, 0.5}, second = {0.5, 0.5, 0.25};
  const Path path = [=](double t) {
    Posture<QuadJet> p;
    const Where n = unit(exact(axis));
    p["P"] = exact(kA) + turned(exact(at_start), n, at(kTurn, t) - 0.3);
    p["Q"] = p["P"] + turned(exact(second), fixed(0, 0, 1), at(kSwing, t) - at(kSwing, 0).value);
    p["R"] = p["Q"] + turned(exact(at_start), n, at(kTurn, t) - 0.3);
    return p;
  };
  SceneBuilder b("arms", 3);
  grid(b).fixed_point("A", kA).fixed_vector("n", axis).fixed_vector("z", {0, 0, 1});
  place(b, path, {"P", "Q", "R"});
  // The angle is measured from `at`, so the laws begin at zero.
  const double swing = static_cast<double>(at(kSwing, 0).value);
  b.drive("one", PointAngle{"A", "P", "n", kTurn + Law::constant(-0.3)});
  b.drive("two", PointAngle{"P", "Q", "z", kSwing + Law::constant(-swing)});
  b.drive("three", PointAngle{"Q", "R", "n", kTurn + Law::constant(-0.3)}).add(DeclaredGroup{"last", {"R"}});
  return kind("angle about an axis", b, path);
}

// An arm has the length of the distance between its points, not the sqrt(0.25^2 + 0.75^2 + 0.5^2) of `at`.
Kind arm_with_length() {
  const Path path = [](double t) {
    Posture<QuadJet> p;
    // The guess has another radius. The height 0.5 along the axis stays, and the radius becomes sqrt(1.5^2 - 0.5^2).
    const QuadJet r = sqrt(number(2.25 - 0.25));
    const Where e = unit(fixed(0.75, 0.25, 0));
    p["P"] = exact(kA) + fixed(0, 0, 0.5) + r * turned(e, fixed(0, 0, 1), at(kSlide, t));
    return p;
  };
  SceneBuilder b("arm", 3);
  grid(b).fixed_point("A", kA).fixed_vector("z", {0, 0, 1});
  b.point("P", {kA[0] + 0.75, kA[1] + 0.25, kA[2] + 0.5}).constrain("length", Distance{"P", "A", 1.5});
  b.drive("one", PointAngle{"A", "P", "z", kSlide});
  return kind("angle about an axis, length written", b, path);
}

Kind relative_angles() {
  const Path path = path_of([](double t, auto& p) {
    p["e"] = turned(p["u"], p["w"], at(kSwing, t));  // turns about a moving axis
    p["wrist.rho"] = scalar(number(1));
    p["wrist.across"] = p["v"];
    const Where z = fixed(0, 0, 1);
    p["P"] = exact(kA) + turned(fixed(0.75, 0, 0), z, at(kTurn, t));
    p["Q"] = p["P"] + turned(fixed(0.5, 0, 0), z, at(kTurn, t) + at(kSlide, t));  // turns about a fixed axis
    p["elbow.rho"] = scalar(number(0.375));
  });
  SceneBuilder b = with_body("relative", path);
  b.fixed_vector("z", {0, 0, 1}).fixed_vector("skew", {0.6, 0, 0.8});
  place(b, path, {"Q"}, {"e"});
  b.point("P", {kA[0] + 0.75, kA[1], kA[2]});  // where the angle is zero
  b.constrain("across", Dot{"e", "w", 0.0}).drive("wrist", RelativeAngle{"u", "e", "w", kSwing});
  b.drive("shoulder", PointAngle{"A", "P", "z", kTurn});
  b.constrain("flat", Dot{{"P", "Q"}, "z", 0.0}).constrain("arm", Distance{"P", "Q", 0.5});
  b.drive("elbow", RelativeAngle{{"A", "P"}, {"P", "Q"}, "z", kSlide});
  return kind("relative angle", b, path);
}

}  // namespace

std::vector<Kind> in_space() {
  std::vector<Kind> all = {distances(),        equal_distances(), dots(),         parallels(),
                           lines_and_planes(), linears(),         arms(),         arm_with_length(),
                           relative_angles(),  actuated(false),   actuated(true), actuated(true, true)};
  for (int axis = 0; axis < 3; ++axis) all.push_back(hinged(axis));
  for (const std::string base : {"frame", "base", "flat base", "translating"}) {
    for (const bool declared : {false, true}) all.push_back(pose(base, declared));
  }
  return all;
}

}  // namespace assur::kinds
