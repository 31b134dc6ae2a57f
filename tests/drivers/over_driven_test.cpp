// More drivers than freedoms: bodies that drivers move must keep their shape, or the scene is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "assur/assur.hpp"

namespace assur {
namespace {

// A four-bar with a motor on each crank. swapped: the joints name their bodies in the other order.
Scene two_motors(const Law& other, bool swapped, bool parallelogram) {
  const auto pair = [&](const char* a, const char* b) {
    return swapped ? std::pair<std::string, std::string>(b, a) : std::pair<std::string, std::string>(a, b);
  };
  const Triple top = parallelogram ? Triple{2.5, 0.3} : Triple{2, 1.4},
               foot = parallelogram ? Triple{2, 0} : Triple{2.4, 0};
  const auto hinge = [&](const char* a, const char* b, const Triple& at) {
    const auto [first, second] = pair(a, b);
    return Revolute{first, second, at};
  };
  SceneBuilder b("two motors", 2);
  for (const char* body : {"a", "c", "r"}) b.add(Body{.name = body});
  b.joint("A", hinge("ground", "a", {0, 0})).joint("B", hinge("a", "c", {0.5, 0.3}));
  b.joint("C", hinge("c", "r", top)).joint("D", hinge("ground", "r", foot));
  b.drive("m", DrivenCoordinate{"A.angle", Law::polynomial({0, swapped ? -0.5 : 0.5})});
  b.drive("n", DrivenCoordinate{"D.angle", other});
  return b.output("B").output("C").time(0, 1, 0.125).build();
}

// The scene is refused when it is prepared, with this reason.
void expect_refused(const Scene& scene, const std::string& reason) {
  try {
    (void)prepare(scene);
    ADD_FAILURE() << scene.name() << " is not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::numerical);
    EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
  }
}

TEST(OverDriven, FourBarsKeepTheirCoupler) {
  for (const bool swapped : {false, true}) {
    const double sign = swapped ? -1 : 1;
    const Law same = Law::polynomial({0, 0.5 * sign}), other = Law::polynomial({0, 0.3 * sign});
    expect_refused(two_motors(other, swapped, false), "driver n");
    expect_refused(two_motors(other, swapped, true), "driver n");
    Simulator simulator(prepare(two_motors(same, swapped, true)));  // both cranks of a parallelogram turn alike
    const Trajectory motion = simulator.run();
    ASSERT_TRUE(simulator.report().status.ok()) << name(simulator.report().status.code);
    for (std::size_t k = 0; k < motion.times().size(); ++k) {
      const auto row = motion.row(k);
      const std::size_t c = row.size() / 2;  // of C.x
      EXPECT_NEAR(std::hypot(row[c] - row[0], row[c + 1] - row[1]), 2, 1e-14) << motion.times()[k];
    }
  }
}

// A truss of three links and three pins with a motor in one pin.
TEST(OverDriven, ATrussDoesNotMove) {
  SceneBuilder b("truss", 2);
  b.add(Body{.name = "p"}).add(Body{.name = "q"});
  b.joint("A", Revolute{"ground", "p", Triple{0, 0}}).joint("B", Revolute{"p", "q", Triple{1, 1}});
  b.joint("C", Revolute{"ground", "q", Triple{2, 0}});
  b.drive("m", DrivenCoordinate{"C.angle", Law::polynomial({0, 1})});
  expect_refused(b.output("B").time(0, 1, 0.125).build(), "joints A, B, C; driver m");
}

// A plate on three driven cranks by balls: the cranks of unequal speed would stretch it.
TEST(OverDriven, APlateKeepsItsTriangle) {
  SceneBuilder b("plate", 3);
  b.add(Body{.name = "plate"});
  for (const char* i : {"0", "1", "2"}) {
    const double turn = 2.1 * (i[0] - '0');
    const std::string crank = std::string("crank") + i;
    b.add(Body{.name = crank});
    const Triple foot = {std::cos(turn), std::sin(turn), 0}, ball = {1.5 * std::cos(turn), 1.5 * std::sin(turn), 0};
    b.joint(std::string("R") + i, Revolute{"ground", crank, foot, Triple{-std::sin(turn), std::cos(turn), 0}});
    b.joint(std::string("S") + i, Spherical{crank, "plate", ball});
    b.drive(std::string("d") + i, DrivenCoordinate{std::string("R") + i + ".angle", Law::polynomial({0, 0.1 + turn})});
  }
  expect_refused(b.output("plate").time(0, 1, 0.125).build(), "driver d2");
}

TEST(OverDriven, UnitVectorsKeepTheirLength) {
  const auto scene = [](const std::string& x, const std::string& y) {
    return parse_scene(R"({"assur": 1, "name": "vector", "dimension": 2, "vectors": {"u": {"at": [1, 0]}},
      "drivers": {"x": {"coordinate": "u.x", "law": )" +
                       x + R"(}, "y": {"coordinate": "u.y", "law": )" + y + R"(}},
      "outputs": ["u"], "time": {"start": 0, "end": 1, "step": 0.25}})");
  };
  expect_refused(scene(R"({"polynomial": [1]})", R"({"polynomial": [0, 1]})"), "|u| = 1");
  const Scene circle = scene(R"({"harmonics": [{"amplitude": 1, "frequency": 0.25, "phase": 1.5707963267948966}]})",
                             R"({"harmonics": [{"amplitude": 1, "frequency": 0.25, "phase": 0}]})");
  Simulator turning(prepare(circle));
  (void)turning.run();
  EXPECT_TRUE(turning.report().status.ok()) << name(turning.report().status.code);
}

// A frame that takes one axis from each of two posed bodies.
TEST(OverDriven, FramesOfDrivenAxesStayOrthogonal) {
  const auto scene = [](double second) {
    const std::string still = R"([{"polynomial": [0]}, {"polynomial": [0]}, {"polynomial": [0]}])";
    const auto pose = [&](const char* body, double rate) {
      return R"({"pose": ")" + std::string(body) + R"(", "relative": true, "translation": )" + still +
             R"(, "rotation": {"euler_zyx": [{"polynomial": [0, )" + std::to_string(rate) +
             R"(]}, {"polynomial": [0]}, {"polynomial": [0]}]}})";
    };
    return parse_scene(R"({"assur": 1, "name": "frames", "dimension": 3,
      "points": {"O1": {"at": [0, 0, 0]}, "O2": {"at": [3, 0, 0]}, "O3": {"at": [1, 1, 1]}},
      "vectors": {"u": {"at": [1, 0, 0]}, "v": {"at": [0, 1, 0]}, "w": {"at": [0, 0, 1]}, "p": {"at": [1, 0, 0]},
                  "q": {"at": [0, 1, 0]}, "r": {"at": [0, 0, 1]}, "n": {"at": [0, 0, 1]}},
      "bodies": {"b1": {"origin": "O1", "frame": ["u", "v", "w"]}, "b2": {"origin": "O2", "frame": ["p", "q", "r"]},
                 "b3": {"origin": "O3", "frame": ["u", "q", "n"]}},
      "constraints": {"o": {"linear": [["O3", 1], ["O1", -1]], "value": [1, 1, 1]}},
      "drivers": {"d1": )" +
                       pose("b1", 0.3) + R"(, "d2": )" + pose("b2", second) + R"(},
      "outputs": ["u", "q", "n"], "time": {"start": 0, "end": 1, "step": 0.125}})");
  };
  expect_refused(scene(-0.3), "body b3");
  Simulator together(prepare(scene(0.3)));
  (void)together.run();
  EXPECT_TRUE(together.report().status.ok()) << name(together.report().status.code);
}

}  // namespace
}  // namespace assur
