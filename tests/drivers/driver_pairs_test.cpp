// Two drivers of one pair of points, one body or one joint: each combination moves both as they ask, or is refused by
// name. A distance driver and an angle driver of one pair make an arm in polar coordinates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr double kValue = 1e-12;  // values of size 1 at conditions up to 100

struct Polar {
  double x, y, vx, vy, ax, ay;
};

// The end of an arm of length r at the angle q.
Polar polar(const Motion& r, const Motion& q) {
  const double c = std::cos(q.value), s = std::sin(q.value);
  const double radial = r.acceleration - r.value * q.rate * q.rate;
  const double across = r.value * q.acceleration + 2 * r.rate * q.rate;
  return {r.value * c,
          r.value * s,
          r.rate * c - r.value * q.rate * s,
          r.rate * s + r.value * q.rate * c,
          radial * c - across * s,
          radial * s + across * c};
}

const Law kReach = Law::polynomial({1, 0.5}), kTurn = Law::polynomial({0, 1, 0.3});

// The arm from A, in the plane, or in space about z with the end at the height `h`. Drivers in either order.
SceneBuilder arm(int dimension, double h, bool distance_first, bool reversed, const Law& reach, const Law& turn) {
  SceneBuilder b("arm", dimension);
  b.fixed_point("A", {0, 0, 0}).point("B", {std::sqrt(1 - h * h), 0, h});
  if (dimension == 3) b.fixed_vector("n", {0, 0, 1});
  const DrivenDistance distance{reversed ? "B" : "A", reversed ? "A" : "B", reach};
  const PointAngle angle{"A", "B", dimension == 3 ? "n" : "", turn};
  if (distance_first) b.drive("l", distance);
  b.drive("q", angle);
  if (!distance_first) b.drive("l", distance);
  b.measure("r", MeasuredDistance{"A", "B"}).output("B").output("r").time(0, 1, 0.25);
  return b;
}

TEST(DriverPairs, ADistanceAndAnAngleMoveAnArm) {
  for (const int dimension : {2, 3}) {
    for (const double h : {0.0, 0.6}) {
      if (dimension == 2 && h != 0) continue;
      for (const bool distance_first : {true, false}) {
        for (const bool reversed : {true, false}) {
          for (const std::string strategy : {"global/eigen", "groups/eigen", "irreducible/eigen", "auto"}) {
            SCOPED_TRACE(strategy + " " + std::to_string(dimension) + " " + std::to_string(h));
            PrepareOptions options;
            options.strategy = strategy;
            const Scene scene = arm(dimension, h, distance_first, reversed, kReach, kTurn).build();
            EXPECT_EQ(group_equations(scene).mobility, 2);
            Simulator simulator(prepare(scene, options));
            const Trajectory motion = simulator.run();
            ASSERT_TRUE(simulator.report().status.ok()) << name(simulator.report().status.code);
            ASSERT_EQ(motion.rows(), 5u);
            for (std::size_t k = 0; k < motion.rows(); ++k) {
              const double t = motion.times()[k];
              // Across the axis, the arm has the length (l^2 - h^2)^1/2.
              const Motion l = kReach(t);
              const double across = std::sqrt(l.value * l.value - h * h), rate = l.value * l.rate / across;
              const Motion r = {across, rate, (l.rate * l.rate + l.value * l.acceleration - rate * rate) / across};
              const Polar p = polar(r, kTurn(t));
              EXPECT_NEAR(motion(k, motion.index("B.x")), p.x, kValue);
              EXPECT_NEAR(motion(k, motion.index("B.y")), p.y, kValue);
              EXPECT_NEAR(motion(k, motion.index("B.vx")), p.vx, kValue);
              EXPECT_NEAR(motion(k, motion.index("B.vy")), p.vy, kValue);
              EXPECT_NEAR(motion(k, motion.index("B.ax")), p.ax, kValue);
              EXPECT_NEAR(motion(k, motion.index("B.ay")), p.ay, kValue);
              EXPECT_NEAR(motion(k, motion.index("r")), l.value, kValue);
              if (dimension == 3) {
                EXPECT_NEAR(motion(k, motion.index("B.z")), h, kValue);
              }
            }
          }
        }
      }
    }
  }
}

TEST(DriverPairs, AnArmFollowsTargets) {
  for (const int dimension : {2, 3}) {
    const Law one = Law::constant(1), zero = Law::constant(0);
    PrepareOptions options;
    options.controlled = {"l", "q"};
    Simulator simulator(prepare(arm(dimension, 0, true, false, one, zero).build(), options));
    const OutputJacobian jacobian = simulator.jacobian();
    const auto slope = [&](const std::string& output, std::size_t driver) {
      const auto at = std::find(jacobian.outputs.begin(), jacobian.outputs.end(), output) - jacobian.outputs.begin();
      return jacobian.values[static_cast<std::size_t>(at) * jacobian.drivers.size() + driver];
    };
    EXPECT_NEAR(slope("B.x", 0), 1, kValue);
    EXPECT_NEAR(slope("B.y", 0), 0, kValue);
    EXPECT_NEAR(slope("r", 0), 1, kValue);
    EXPECT_NEAR(slope("B.x", 1), 0, kValue);
    EXPECT_NEAR(slope("B.y", 1), 1, kValue);
    EXPECT_NEAR(slope("r", 1), 0, kValue);
    for (int k = 1; k <= 20; ++k) {
      const double l = 1 + 0.05 * k, q = 0.1 * k;
      simulator.set("l", l);
      simulator.set("q", q);
      ASSERT_TRUE(simulator.step().ok()) << k;
      EXPECT_NEAR(simulator.output("B.x"), l * std::cos(q), kValue);
      EXPECT_NEAR(simulator.output("B.y"), l * std::sin(q), kValue);
      EXPECT_NEAR(simulator.output("r"), l, kValue);
    }
  }
}

// A length of 0 has no direction, and in space the arm cannot be shorter than its part along the axis.
TEST(DriverPairs, AnArmEndsWhereItVanishes) {
  const Law shrinking = Law::polynomial({1, -1});
  for (const int dimension : {2, 3}) {
    for (const double h : {0.0, 0.6}) {
      if (dimension == 2 && h != 0) continue;
      Simulator simulator(prepare(arm(dimension, h, true, false, shrinking, kTurn).time(0, 2, 0.125).build()));
      (void)simulator.run();
      const Report& report = simulator.report();
      EXPECT_FALSE(report.status.ok()) << dimension << " " << h;
      EXPECT_NEAR(report.reached, 1 - h, 0.126);
    }
  }
}

TEST(DriverPairs, MembersOfAnEnsembleHaveTheirOwnArms) {
  const std::string text = R"({"assur": 1, "name": "arm", "dimension": 2, "parameters": {"L": 1},
    "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [1, 0]}},
    "drivers": {"q": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}},
                "l": {"distance": ["A", "B"], "law": {"constant": "=L"}}},
    "measures": {"r": {"distance": ["A", "B"]}}, "outputs": ["B.position", "r"],
    "time": {"start": 0, "end": 1, "step": 0.25}})";
  for (const double length : {1.0, 1.5, 0.7}) {
    Simulator simulator(prepare(parse_scene(text, "arm", ".", {{"L", length}})));
    const Trajectory motion = simulator.run();
    ASSERT_TRUE(simulator.report().status.ok());
    EXPECT_NEAR(motion.last("r"), length, kValue);
    EXPECT_NEAR(motion.last("B.x"), length * std::cos(1.0), kValue);
  }
}

TEST(DriverPairs, AConstantDistanceIsNotDrivenAsWell) {
  SceneBuilder b = arm(2, 0, true, false, kReach, kTurn);
  b.constrain("bar", Distance{"B", "A", 1.0});
  try {
    (void)b.build();
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "/drivers/l/distance: constraint 'bar' keeps this distance constant; remove one of them");
  }
}

// Of two constraints of one distance, an angle driver takes one as its radius; the other one must agree.
TEST(DriverPairs, TwoConstantDistancesMustAgree) {
  const auto scene = [](double second) {
    SceneBuilder b("bars", 2);
    b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0});
    b.constrain("one", Distance{"A", "B", 1.0}).constrain("two", Distance{"A", "B", second});
    return b.drive("q", PointAngle{"A", "B", "", kTurn}).output("B").time(0, 1, 0.25).build();
  };
  Simulator simulator(prepare(scene(1)));
  (void)simulator.run();
  EXPECT_TRUE(simulator.report().status.ok());
  EXPECT_THROW((void)prepare(scene(1.25)), Error);
}

// ---- all combinations

struct Item {
  std::string name, json;  // the driver without its law
  std::string quantity;    // the column that must follow the law
  double offset = 0;       // of targets: the value of the driver less that of the column
};

struct Kit {
  std::string before, after;  // text of the scene around the drivers
  std::vector<Item> items;
  int freedoms = 0;
};

Kit points_of_the_plane() {
  return {R"("dimension": 2, "points": {"A": {"at": [0, 0], "fixed": true}, "C": {"at": [1, 0], "fixed": true},
             "B": {"at": [1.2, 0.5]}},)",
          R"("measures": {"d": {"distance": ["A", "B"]}, "a": {"angle": ["A", "B"]},
              "r": {"angle": [["A", "C"], ["A", "B"]]}, "e": {"distance": ["C", "B"]}}, "outputs": ["B", "d", "a", "r", "e"])",
          {{"D", R"("distance": ["A", "B"])", "d"},
           {"G", R"("angle": ["A", "B"])", "a"},
           {"R", R"("angle": [["A", "C"], ["A", "B"]])", "r"},
           {"X", R"("coordinate": "B.x")", "B.x"},
           {"Y", R"("coordinate": "B.y")", "B.y"},
           {"E", R"("distance": ["C", "B"])", "e"}},
          2};
}

Kit points_of_space() {
  return {R"("dimension": 3, "points": {"A": {"at": [0, 0, 0], "fixed": true}, "C": {"at": [1, 0, 0], "fixed": true},
             "B": {"at": [1.2, 0.5, 0.4]}}, "vectors": {"n": {"at": [0, 0, 1], "fixed": true}},
             "constraints": {"plane": {"coordinate": "B.z", "value": 0.4}},)",
          R"("measures": {"d": {"distance": ["A", "B"]}, "r": {"angle": [["A", "C"], ["A", "B"]], "axis": "n"}},
              "outputs": ["B", "d", "r"])",
          {{"D", R"("distance": ["A", "B"])", "d"},
           {"G", R"("axis": "n", "angle": ["A", "B"])", "r", -std::atan2(0.5, 1.2)},
           {"R", R"("axis": "n", "angle": [["A", "C"], ["A", "B"]])", "r"},
           {"X", R"("coordinate": "B.x")", "B.x"},
           {"Y", R"("coordinate": "B.y")", "B.y"}},
          2};
}

// A block on a cylindrical joint about z, with the point P beside it.
Kit joint_of_space() {
  return {R"("dimension": 3, "points": {"A": {"at": [0, 0, 0], "fixed": true}},
             "vectors": {"n": {"at": [0, 0, 1], "fixed": true}},
             "bodies": {"c": {"points": {"P": {"at": [0.8, 0.6, 0.5]}}}},
             "joints": {"J": {"cylindrical": ["ground", "c"], "at": [0, 0, 0], "axis": "n"}},)",
          R"("measures": {"d": {"distance": ["A", "P"]}, "s": {"coordinate": "J.displacement"},
              "a": {"coordinate": "J.angle"}}, "outputs": ["P", "d", "s", "a"])",
          {{"S", R"("coordinate": "J.displacement")", "s"},
           {"Q", R"("coordinate": "J.angle")", "a"},
           {"D", R"("distance": ["A", "P"])", "d"},
           {"G", R"("axis": "n", "angle": ["A", "P"])", "a"},
           {"X", R"("coordinate": "P.x")", "P.x"},
           {"Z", R"("coordinate": "P.z")", "P.z"}},
          2};
}

// A crank on a revolute joint: one freedom, so that two drivers are one too many.
Kit crank() {
  return {R"("dimension": 2, "points": {"A": {"at": [0, 0], "fixed": true}},
             "bodies": {"c": {"points": {"P": {"at": [1, 0.2]}}}}, "joints": {"J": {"revolute": ["ground", "c"], "at": "A"}},)",
          R"("measures": {"d": {"distance": ["A", "P"]}, "a": {"coordinate": "J.angle"}}, "outputs": ["P", "d", "a"])",
          {{"Q", R"("coordinate": "J.angle")", "a"},
           {"D", R"("distance": ["A", "P"])", "d"},
           {"G", R"("angle": ["A", "P"])", "a", std::atan2(0.2, 1)},
           {"X", R"("coordinate": "P.x")", "P.x"}},
          1};
}

Kit body_of_the_plane() {
  return {R"("dimension": 2, "points": {"A": {"at": [0, 0], "fixed": true}, "O": {"at": [1.2, 0.5]}},
             "vectors": {"u": {"at": [0.8, 0.6]}}, "bodies": {"b": {"origin": "O", "frame": ["u"], "points": {"P": [1, 0.2]}}},
             "constraints": {"turn": {"coordinate": "u.x", "value": 0.8}},)",
          R"("measures": {"d": {"distance": ["A", "O"]}, "a": {"angle": ["A", "O"]}}, "outputs": ["O", "P", "d", "a"])",
          {{"D", R"("distance": ["A", "O"])", "d"},
           {"G", R"("angle": ["A", "O"])", "a"},
           {"X", R"("coordinate": "O.x")", "O.x"},
           {"Y", R"("coordinate": "P.y")", "P.y"}},
          2};
}

struct Count {
  int works = 0, refused = 0;
};

// rate: of both laws, which count from the posture as written.
Scene pair_of(const Kit& kit, const Item& one, const Item& other, const std::string& rate) {
  const auto driver = [&](const Item& item, const std::string& suffix) {
    return "\"" + item.name + suffix + "\": {" + item.json + R"(, "relative": true, "law": {"polynomial": [0, )" +
           rate + "]}}";
  };
  return parse_scene(R"({"assur": 1, "name": "pair", )" + kit.before + R"("drivers": {)" + driver(one, "1") + ", " +
                     driver(other, "2") + "}, " + kit.after + R"(, "time": {"start": 0, "end": 1, "step": 0.25}})");
}

// True if a message names one of the two drivers, or says that they leave something free.
bool names(const std::string& what, const Item& one, const Item& other) {
  if (what.find("undetermined: ") != what.npos) return true;
  for (const std::string& name : {one.name + "1", other.name + "2"}) {
    for (const std::string& form : {"'" + name + "'", "driver " + name, "/drivers/" + name}) {
      if (what.find(form) != std::string::npos) return true;
    }
  }
  return false;
}

// Whether the quantity has moved by `by`, angles up to whole turns.
bool has_moved(double from, double to, double by) {
  return std::abs(std::remainder(to - from - by, 2 * std::numbers::pi)) <= kValue;
}

void by_laws(const Kit& kit, const Item& one, const Item& other, Count& count) {
  try {
    Simulator simulator(prepare(pair_of(kit, one, other, "0.1")));
    const Trajectory motion = simulator.run();
    if (!simulator.report().status.ok()) {
      ++count.refused;
      return;
    }
    ++count.works;
    for (const std::string& column : {one.quantity, other.quantity}) {
      EXPECT_TRUE(has_moved(motion(0, motion.index(column)), motion.last(column), 0.1)) << column;
    }
  } catch (const Error& error) {
    ++count.refused;
    EXPECT_TRUE(names(error.what(), one, other)) << error.what();
  }
}

void by_targets(const Kit& kit, const Item& one, const Item& other, Count& count) {
  try {
    PrepareOptions options;
    options.controlled = {one.name + "1", other.name + "2"};
    Simulator simulator(prepare(pair_of(kit, one, other, "0"), options));
    const double from[2] = {simulator.output(one.quantity), simulator.output(other.quantity)};
    simulator.set(options.controlled[0], from[0] + one.offset + 0.1);
    simulator.set(options.controlled[1], from[1] + other.offset + 0.1);
    if (!simulator.step().ok()) {
      ++count.refused;
      return;
    }
    ++count.works;
    EXPECT_TRUE(has_moved(from[0], simulator.output(one.quantity), 0.1)) << one.quantity;
    EXPECT_TRUE(has_moved(from[1], simulator.output(other.quantity), 0.1)) << other.quantity;
  } catch (const Error& error) {
    ++count.refused;
    EXPECT_TRUE(names(error.what(), one, other)) << error.what();
  }
}

TEST(DriverPairs, EachWorksOrIsRefusedByName) {
  for (const Kit& kit : {points_of_the_plane(), points_of_space(), joint_of_space(), crank(), body_of_the_plane()}) {
    Count laws, targets;
    for (const Item& one : kit.items) {
      for (const Item& other : kit.items) {
        SCOPED_TRACE(kit.before.substr(0, 14) + " " + one.name + " " + other.name);
        by_laws(kit, one, other, laws);
        by_targets(kit, one, other, targets);
      }
    }
    if (kit.freedoms == 2) {
      EXPECT_GE(laws.works, 2);
      EXPECT_GE(targets.works, 2);
    }
    EXPECT_GE(laws.refused, static_cast<int>(kit.items.size()));
    RecordProperty("works", laws.works + targets.works);
  }
}

// The pose of a body leaves nothing to other drivers of the body.
TEST(DriverPairs, APoseIsTheOnlyDriverOfItsBody) {
  Kit kit = body_of_the_plane();
  kit.before.erase(kit.before.find(R"("constraints")"));
  const std::string still = R"({"polynomial": [0, 0.1]})";
  const std::string pose = R"("pose": {"relative": true, "pose": "b", "translation": [)" + still + ", " + still +
                           R"(], "rotation": {"angle": )" + still + "}}";
  for (const Item& item : kit.items) {
    const std::string other =
        "\"" + item.name + "2\": {" + item.json + R"(, "relative": true, "law": {"polynomial": [0, 0.2]}})";
    for (const bool first : {true, false}) {
      SCOPED_TRACE(item.name);
      try {
        (void)prepare(parse_scene(R"({"assur": 1, "name": "pair", )" + kit.before + R"("drivers": {)" +
                                  (first ? pose + ", " + other : other + ", " + pose) + "}, " + kit.after +
                                  R"(, "time": {"start": 0, "end": 1, "step": 0.25}})"));
        ADD_FAILURE() << "accepted";
      } catch (const Error& error) {
        const std::string what = error.what();
        EXPECT_TRUE(what.find("pose") != what.npos || names(what, item, item)) << what;
      }
    }
  }
}

}  // namespace
}  // namespace assur
