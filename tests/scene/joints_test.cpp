// Misuse of joints is refused with place, problem and remedy, and without further findings.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "assur/scene.hpp"
#include "assur/status.hpp"

namespace assur {
namespace {

std::string refusal(int dimension, const std::string& rest) {
  try {
    (void)parse_scene("{\"assur\": 1, \"dimension\": " + std::to_string(dimension) + ", " + rest + "}");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

// The refusal of a scene with two bodies and these joints.
std::string with(int dimension, const std::string& joints, const std::string& more = "") {
  return refusal(dimension, R"("bodies": {"a": {}, "b": {}}, "joints": {)" + joints + "}" + more);
}

TEST(JointFiles, NameWrongBodies) {
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "c"], "at": [0, 0]})"),
            "scene: /joints/J/revolute/1: there is no body 'c'; there are: a, b, ground");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "a"], "at": [0, 0]})"),
            "scene: /joints/J: both bodies are 'a'; a joint connects two different bodies");
  EXPECT_EQ(with(2, R"("F": {"fixed": ["a", "b"]}, "J": {"revolute": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/J: 'a' and 'b' are fixed to each other; remove this joint");
  EXPECT_EQ(refusal(2, R"("bodies": {"a": {}, "b": {}, "c": {}}, "joints": {"J": {"revolute": ["a", "b"], "at": [0, 0]}})"),
            "scene: /bodies/c: no joint places this body; a body needs a base, joints, or \"rigid\" points");
}

TEST(JointFiles, NameWrongAxes) {
  const std::string at = R"("at": [0, 0, 0], )";
  EXPECT_EQ(with(3, R"("J": {"revolute": ["a", "b"], )" + at + R"("axis": [0, 0, 0]})"),
            "scene: /joints/J/axis: the axis is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(3, R"("J": {"revolute": ["a", "b"], "at": [0, 0, 0]})"),
            "scene: /joints/J/axis: the axis is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(3, R"("J": {"prismatic": ["a", "b"], "axis": "u"})"),
            "scene: /joints/J/axis: there is no unit vector 'u'");
  EXPECT_EQ(with(3, R"("J": {"universal": ["a", "b"], )" + at + R"("axes": [[1, 0, 0], [1, 1, 0]]})"),
            "scene: /joints/J/axes: the axes have the dot product 0.707107; those of a universal joint are at right "
            "angles");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "b"], "at": [0, 0], "axis": [0, 1]})"),
            "scene: /joints/J/axis: in the plane every axis is the normal; leave \"axis\" out");
  EXPECT_EQ(with(2, R"("J": {"spherical": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/J/spherical: spherical joints are for 3D; in the plane there are revolute, prismatic and "
            "fixed");
}

TEST(JointFiles, NameWrongCoordinates) {
  const std::string joint = R"("J": {"revolute": ["ground", "a"], "at": [0, 0]})";
  const auto driven = [](const std::string& coordinate) {
    return R"(, "drivers": {"m": {"coordinate": ")" + coordinate + R"(", "law": {"polynomial": [0, 1]}}})";
  };
  const std::string two = joint + R"(, "K": {"revolute": ["a", "b"], "at": [1, 0]})";
  EXPECT_EQ(with(2, two, driven("J.displacement")),
            "scene: /drivers/m/coordinate: joint 'J' is revolute and has no displacement");
  EXPECT_EQ(with(2, two, driven("J.angle")), "accepted");
}

TEST(JointFiles, ShareNamesWithAllKinds) {
  EXPECT_EQ(with(2, R"("a": {"revolute": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/a: 'a' is the name of something else already; all kinds share one set of names");
  EXPECT_EQ(refusal(2, R"("constraints": {"J": {"revolute": ["a", "b"], "at": [0, 0]}})"),
            "scene: /constraints/J/revolute: this is a joint; joints have a section of their own, \"joints\"");
}

TEST(JointFiles, BodiesWithoutBaseHaveMembersInTheGround) {
  EXPECT_EQ(refusal(2, R"("bodies": {"a": {"points": {"P": [1, 0]}}}, "joints": {"J": {"revolute": ["ground", "a"],
                         "at": [0, 0]}})"),
            "scene: /bodies/a/points/P: the body has no frame of its own; write the coordinates in the ground as "
            "written, {\"at\": [...]}");
}

// A rod may turn about the line through its joints; members on this line are determined nevertheless.
TEST(JointFiles, RodsHaveMembersOnTheirLine) {
  const Scene scene = parse_scene(R"({"assur": 1, "dimension": 3,
      "bodies": {"rod": {"points": {"M": {"at": [0.5, 0, 0]}}}, "arm": {}},
      "joints": {"S": {"spherical": ["ground", "rod"], "at": [0, 0, 0]},
                 "T": {"spherical": ["rod", "arm"], "at": [1, 0, 0]},
                 "R": {"revolute": ["arm", "ground"], "at": [2, 1, 0], "axis": [0, 0, 1]}}})");
  ASSERT_EQ(scene.bodies().size(), 2u);
  EXPECT_EQ(scene.bodies()[0].base, (std::vector<std::string>{"S", "T"}));
  ASSERT_EQ(scene.bodies()[0].points.size(), 1u);
  EXPECT_EQ(scene.bodies()[0].points[0].local, (Triple{0.5, 0, 0}));
  ASSERT_EQ(scene.warnings().size(), 1u);
  EXPECT_EQ(scene.warnings()[0].where, "/bodies/rod");
}

}  // namespace
}  // namespace assur
