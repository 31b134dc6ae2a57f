// Meaning of a model: postures of its joints, orientations, classes, keyframes, names, drivers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "assur/mjcf.hpp"
#include "mjcf/files.hpp"
#include "mjcf/tree.hpp"
#include "simulation/same_run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using test::M3;
using test::norm;
using test::turn;
using test::V3;

constexpr double kDegree = std::numbers::pi / 180;
constexpr V3 kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1};

class Importing : public testing::Test {
 protected:
  ImportedModel import(const std::string& inside, const ModelOptions& options = {}) {
    return import_model(folder_.write("model.xml", "<mujoco model='m'>" + inside + "</mujoco>"), options);
  }
  Scene scene(const std::string& inside, const ModelOptions& options = {}) { return import(inside, options).scene; }
  // The site in the last row of the motion.
  static V3 last(const Trajectory& t, const std::string& site) {
    return {t.last(site + ".x"), t.last(site + ".y"), t.last(site + ".z")};
  }
  // A site of the scene as written.
  static V3 written(const Scene& scene, const std::string& site) {
    for (const Body& b : scene.bodies()) {
      for (const Member& m : b.points) {
        if (m.name == site && b.name == "ground") return {m.local[0], m.local[1], m.local[2]};
      }
    }
    ADD_FAILURE() << site;
    return {};
  }
  // The scene as a file has this text.
  static void expect_line(const ImportedModel& model, const std::string& text) {
    const std::string file = write_scene(model.scene);
    EXPECT_NE(file.find(text), std::string::npos) << file;
  }
  test::Folder folder_;
};

void expect_near(const V3& a, const V3& b, double tolerance, const std::string& what) {
  EXPECT_LE(norm(a - b), tolerance) << what << ": " << a[0] << " " << a[1] << " " << a[2] << ", not " << b[0] << " "
                                    << b[1] << " " << b[2];
}

TEST_F(Importing, OrientationsAreThoseOfMuJoCo) {
  const V3 p = {0.1, 0.2, 0.3};
  struct One {
    std::string compiler, attribute;
    M3 turned;
  };
  const double a = 0.3, b = -0.7, c = 1.1;
  const std::string angles = "'0.3 -0.7 1.1'";
  const std::vector<One> cases = {
      {"angle='radian'", "euler=" + angles, turn(kX, a) * turn(kY, b) * turn(kZ, c)},
      {"angle='radian' eulerseq='XYZ'", "euler=" + angles, turn(kZ, c) * turn(kY, b) * turn(kX, a)},
      {"angle='radian' eulerseq='zxz'", "euler=" + angles, turn(kZ, a) * turn(kX, b) * turn(kZ, c)},
      {"angle='radian' eulerseq='xYz'", "euler=" + angles, turn(kY, b) * turn(kX, a) * turn(kZ, c)},
      {"", "euler='30 0 0'", turn(kX, 30 * kDegree)},
      {"", "axisangle='0 2 0 90'", turn(kY, 90 * kDegree)},
      {"angle='radian'", "axisangle='1 1 1 0.5'", turn({1, 1, 1}, 0.5)},
      {"", "quat='2 0 0 2'", turn(kZ, 90 * kDegree)},
      {"", "xyaxes='0 1 0 -1 0.5 0'", turn(kZ, 90 * kDegree)},
      {"", "zaxis='1 0 0'", turn(kY, 90 * kDegree)},
      {"", "zaxis='0 0 -2'", turn(kX, 180 * kDegree)},
  };
  for (const One& one : cases) {
    const std::string text = "<compiler " + one.compiler + "/><worldbody><body pos='1 2 3' " + one.attribute +
                             "><site name='s' pos='0.1 0.2 0.3'/></body></worldbody>";
    const V3 found = written(scene(text), "s"), wanted = V3{1, 2, 3} + one.turned * p;
    if (one.attribute == "zaxis='0 0 -2'") {
      EXPECT_NEAR(found[2], 2.7, 1e-15);  // the axis of a half turn is not determined
    } else {
      expect_near(found, wanted, 2e-15, one.compiler + " " + one.attribute);
    }
  }
}

TEST_F(Importing, FramesBodiesWithoutJointsAndFromtoPlaceSites) {
  const Scene s = scene(
      "<compiler angle='degree'/><worldbody><frame pos='1 0 0' euler='0 0 90'><frame pos='1 0 0'>"
      "<body pos='0 1 0'><site name='a' pos='1 0 0'/></body></frame>"
      "<site name='b' fromto='0 0 0 2 0 4'/></frame></worldbody>");
  expect_near(written(s, "a"), {0, 2, 0}, 1e-15, "a");
  expect_near(written(s, "b"), {1, 1, 2}, 1e-15, "b");
}

// Ranges are values of MuJoCo's joints; coordinates of the scene count from the start posture. A joint is limited if it
// says so, or if it has a range and does not say otherwise.
TEST_F(Importing, RangesAreLimitsThatFlag) {
  const std::string inside =
      "<compiler angle='degree'/><default><default class='small'><joint range='-10 10'/></default></default>"
      "<worldbody><body><joint name='a' range='-30 60' ref='15'/>"
      "<body><joint name='b' type='slide' axis='1 0 0' range='-0.2 0.5'/>"
      "<body><joint name='c' class='small' axis='0 1 0'/><body><joint name='d' range='0 1' limited='false'/>"
      "<body><joint name='e' type='ball' range='0 40'/><site name='tip' pos='1 0 "
      "0'/></body></body></body></body></body>"
      "</worldbody><keyframe><key name='out' qpos='15 0.7 0 0 1 0 0 0'/></keyframe>";
  const Scene s = scene(inside, {.drive = {{"a", "0"}, {"b", "0"}, {"c", "0"}, {"d", "0"}}});
  ASSERT_EQ(s.limits().size(), 3u);
  const auto expect = [&](std::size_t i, const std::string& quantity, double min, double max) {
    EXPECT_EQ(s.limits()[i].quantity, quantity);
    EXPECT_NEAR(s.limits()[i].min, min, 1e-15);
    EXPECT_NEAR(s.limits()[i].max, max, 1e-15);
    EXPECT_EQ(s.limits()[i].reaction, Limit::Reaction::flag);
  };
  expect(0, "a.angle", -45 * kDegree, 45 * kDegree);
  expect(1, "b.displacement", -0.2, 0.5);
  expect(2, "c.angle", -10 * kDegree, 10 * kDegree);
  const ImportedModel model = import(inside);
  const std::pair<std::string, std::size_t> ball("range of a ball joint", 1);
  EXPECT_NE(std::find(model.left_out.begin(), model.left_out.end(), ball), model.left_out.end());
  EXPECT_EQ(scene("<compiler autolimits='false'/><worldbody><body><joint range='0 1'/></body></worldbody>",
                  {.drive = {{"joint1", "0"}}})
                .limits()
                .size(),
            0u);
}

TEST_F(Importing, ClassesGiveMissingAttributes) {
  const std::string text =
      "<default><joint axis='1 0 0'/><default class='slider'><joint type='slide' axis='0 2 0'/>"
      "<default class='low'><joint ref='0.5'/></default></default></default>"
      "<worldbody><body childclass='slider'><joint name='a'/>"
      "<body><joint name='b' class='main'/><body><joint name='c' class='low'/>"
      "<body childclass='low'><joint name='d' type='hinge' axis='0 0 1' "
      "ref='90'/></body></body></body></body></worldbody>";
  const ImportedModel model = import(text);
  ASSERT_EQ(model.coordinates.size(), 4u);
  EXPECT_EQ(model.coordinates[0].name, "a.displacement");
  EXPECT_EQ(model.coordinates[1].name, "b.angle");
  EXPECT_EQ(model.coordinates[2].name, "c.displacement");
  EXPECT_EQ(model.coordinates[2].start, 0.5);
  EXPECT_EQ(model.coordinates[3].name, "d.angle");
  EXPECT_NEAR(model.coordinates[3].start, 90 * kDegree, 1e-15);
  expect_line(model, R"("a": {"prismatic": ["ground", "body1"], "axis": [0, 1, 0]})");
  expect_line(model, R"("b": {"revolute": ["body1", "body2"], "at": [0, 0, 0], "axis": [1, 0, 0]})");
}

// Three joints of one body: each joint moves the joints after it.
TEST_F(Importing, SeveralJointsOfABodyAreAChain) {
  const ImportedModel model = import(
      "<worldbody><body name='b' pos='1 0 0'><joint name='s' type='slide' axis='1 1 0'/>"
      "<joint name='z' axis='0 0 1' pos='0 0.5 0'/><joint name='y' axis='0 1 0'/>"
      "<site name='p' pos='0.2 0.3 0.4'/></body></worldbody>",
      {"", {{"s", "0,0.7"}, {"z", "0,1.2"}, {"y", "0,-0.4"}}});
  const test::Result run = test::run(model.scene);
  ASSERT_TRUE(run.report().status.ok());
  test::Tree tree;
  const int b = tree.add(0, {1, 0, 0}, test::kNoTurn,
                         {{"s", true, {}, {1, 1, 0}}, {"z", false, {0, 0.5, 0}, kZ}, {"y", false, {}, kY}});
  const auto pose = tree.poses({{"s", 0.7}, {"z", 1.2}, {"y", -0.4}})[static_cast<std::size_t>(b)];
  expect_near(last(run.trajectory, "p"), pose({0.2, 0.3, 0.4}), 1e-14, "p");
}

// A weld holds a bar between two cranks like a coupler of a parallelogram.
TEST_F(Importing, WeldsAndConnectsClose) {
  const std::string text =
      "<compiler angle='radian'/><worldbody><body name='one'><joint name='q1' axis='0 0 1'/><body name='bar' pos='0 1 "
      "0'>"
      "<joint name='q2' axis='0 0 1'/></body></body>"
      "<body name='two' pos='2 0 0'><joint name='q3' axis='0 0 1'/><body name='end' pos='0 1.5 0'>"
      "<joint name='q4' axis='0 0 1'/><site name='e' pos='0.1 0 0'/></body></body></worldbody>"
      "<equality><weld name='w' body1='bar' body2='end'/></equality>"
      "<actuator><motor name='m' joint='q1'/></actuator>";
  const test::Result run = test::run(scene(text, {"", {{"q1", "0,0.5"}}}));
  ASSERT_TRUE(run.report().status.ok());
  const Trajectory& t = run.trajectory;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double q1 = t(k, t.index("q1.angle")), q2 = t(k, t.index("q2.angle"));
    const double q3 = t(k, t.index("q3.angle")), q4 = t(k, t.index("q4.angle"));
    EXPECT_NEAR(q1 + q2, q3 + q4, 1e-14);
    // The joint of `end` seen from both sides.
    const V3 left = turn(kZ, q1) * V3{0, 1, 0} + turn(kZ, q1 + q2) * V3{2, 0.5, 0};
    const V3 right = V3{2, 0, 0} + turn(kZ, q3) * V3{0, 1.5, 0};
    expect_near(left, right, 1e-14, "joint of end");
    expect_near({t(k, t.index("e.x")), t(k, t.index("e.y")), t(k, t.index("e.z"))},
                right + turn(kZ, q3 + q4) * V3{0.1, 0, 0}, 1e-14, "e");
  }
}

// A relative pose that the model does not have at the start is reached before the scene is written.
TEST_F(Importing, RelposeIsReachedAtTheStart) {
  const ImportedModel model = import(
      "<worldbody><body name='a'><joint name='qa' axis='0 0 1'/></body><body name='b' pos='1 0 0'>"
      "<joint name='slide' type='slide' axis='1 0 0'/><body name='c'><joint name='qc' axis='0 0 1'/>"
      "<site name='s' pos='0 1 0'/></body></body></worldbody>"
      "<equality><weld body1='a' body2='c' relpose='2 0 0 0.9 0 0 0.1'/></equality>");
  std::map<std::string, double> start;
  for (const auto& c : model.coordinates) start[c.joint] = c.start;
  EXPECT_NEAR(start["qa"], 0, 1e-14);
  EXPECT_NEAR(start["slide"], 1, 1e-14);
  EXPECT_NEAR(start["qc"], 2 * std::atan2(0.1, 0.9), 1e-14);
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_EQ(model.notes[0], "closing the loops moved joints by up to 1, 'slide' the most");
}

TEST_F(Importing, KeyframesAreTheStart) {
  const std::string text =
      "<worldbody><body name='b'><joint name='q' axis='0 0 1' ref='30'/><body pos='1 0 0'><joint type='ball' "
      "name='ball'/>"
      "<site name='s' pos='1 0 0'/></body></body></worldbody>"
      "<keyframe><key name='up' qpos='1.2 0 0 0 2'/><key name='as_it_is'/></keyframe>";
  const ImportedModel up = import(text, {"up", {{"q", "0,0.25"}}});
  ASSERT_EQ(up.coordinates.size(), 1u);
  EXPECT_EQ(up.coordinates[0].start, 1.2);
  // q turns the body by 1.2 - 30 degrees, the ball by a half turn about z.
  const double turned = 1.2 - 30 * kDegree;
  const V3 at = turn(kZ, turned) * V3{1, 0, 0};
  const V3 site = at - turn(kZ, turned) * V3{1, 0, 0};
  expect_line(up, R"("ball": {"spherical": ["b", "body2"], "at": [)");
  EXPECT_LE(norm(site), 1e-15);
  EXPECT_EQ(import(text, {"as_it_is", {}}).coordinates[0].start, 30 * kDegree);
  const Scene scene = up.scene;
  const Joint& ball = scene.joints()[1];
  const Triple written = std::get<Triple>(std::get<Spherical>(ball.kind).at);
  expect_near({written[0], written[1], written[2]}, at, 1e-15, "ball");
}

// The posture at a keyframe keeps the shapes of the model: lengths are those of the model, although the keyframe has
// fewer digits.
TEST_F(Importing, KeyframesKeepShapes) {
  const std::string file = ASSUR_SOURCE_DIR "/scenes/mjcf/five_bar.xml";
  const ImportedModel model = import_model(file, {"low", {{"left", "0,0.1"}, {"right", "0,0.1"}}});
  const test::Result run = test::run(model.scene);
  ASSERT_TRUE(run.report().status.ok());
  const Trajectory& t = run.trajectory;
  ASSERT_EQ(model.coordinates.size(), 4u);
  EXPECT_NEAR(model.coordinates[0].start, 0.18, 1e-3);
  for (std::size_t k = 0; k < t.rows(); ++k) {
    std::map<std::string, double> q;
    for (const auto& c : model.coordinates) q[c.joint] = c.start + t(k, t.index(c.name));
    const auto tip = [&](double x, double direction, const std::string& arm, const std::string& elbow, double bent) {
      const double a = direction + q[arm], b = a + bent + q[elbow];
      return V3{x, 0, 0} + turn(kZ, a) * V3{0.2, 0, 0} + turn(kZ, b) * V3{0.3, 0, 0};
    };
    expect_near(tip(-0.1, 2.0943951023931953, "left", "left_elbow", -1.3),
                tip(0.1, 1.0471975511965976, "right", "right_elbow", 1.3), 1e-12, "row " + std::to_string(k));
  }
}

TEST_F(Importing, JointsMoveTogetherByTheirEquation) {
  const std::string text =
      "<compiler angle='radian'/><worldbody><body><joint name='a' axis='0 0 1' ref='0.5'/></body>"
      "<body><joint name='b' axis='0 0 1' ref='-1'/></body><body><joint name='c' type='slide' axis='0 0 1'/></body>"
      "<body><joint name='d' axis='0 1 0'/></body></worldbody>"
      "<equality><joint name='gear' joint1='b' joint2='a' polycoef='0.1 -2 0 0 0'/>"
      "<joint joint1='b' joint2='c' polycoef='0 4'/><joint joint1='d' polycoef='0.2'/></equality>";
  const ImportedModel model = import(text, {"", {{"a", "0,1,0.5"}}});
  std::map<std::string, double> start, end;
  const test::Result run = test::run(model.scene);
  ASSERT_TRUE(run.report().status.ok());
  for (const auto& c : model.coordinates) {
    start[c.joint] = c.start;
    end[c.joint] = c.start + run.trajectory.last(c.name);
    EXPECT_TRUE(c.driven);
  }
  for (auto* q : {&start, &end}) {
    EXPECT_NEAR((*q)["b"] + 1, 0.1 - 2 * ((*q)["a"] - 0.5), 1e-14);
    EXPECT_NEAR((*q)["b"] + 1, 4 * (*q)["c"], 1e-14);
    EXPECT_NEAR((*q)["d"], 0.2, 1e-15);
  }
  EXPECT_NEAR(end["a"] - start["a"], 1.5, 1e-14);
}

// A law with a table may be multiplied, too; its file lies in the folder of the model.
TEST_F(Importing, LawsHaveTablesAndExpressions) {
  folder_.write("lift.csv", "0,0\n0.5,0.25\n1,1\n");
  const std::string text =
      "<worldbody><body><joint name='a' axis='0 0 1'/></body><body><joint name='b' axis='0 0 1'/></body>"
      "<body><joint name='c' axis='0 0 1'/></body></worldbody>"
      "<equality><joint joint1='c' joint2='b' polycoef='0 3'/><joint joint1='b' joint2='a' polycoef='0 "
      "-2'/></equality>";
  const ImportedModel model = import(text, {"", {{"a", R"([{"table": "lift.csv"}, {"polynomial": [0, "=pi"]}])"}}, {}});
  EXPECT_EQ(model.scene.tables(), (std::vector<std::filesystem::path>{folder_.path("lift.csv")}));
  const test::Result run = test::run(model.scene);
  ASSERT_TRUE(run.report().status.ok());
  EXPECT_NEAR(run.trajectory.last("a.angle"), 1 + std::numbers::pi, 1e-14);
  EXPECT_NEAR(run.trajectory.last("c.angle"), -6 * (1 + std::numbers::pi), 1e-13);
  const test::Result again = test::run(parse_scene(write_scene(model.scene)));
  test::expect_same_rows(run.trajectory, again.trajectory);
}

TEST_F(Importing, IncludedFilesReplaceTheirInclude) {
  folder_.write("leg.xml",
                "<mujocoinclude><body name='leg' pos='0 0 1'><joint name='hip'/><include file='foot.xml'/></body>"
                "</mujocoinclude>");
  folder_.write("foot.xml", "<mujocoinclude><site name='foot' pos='0 0 -1'/></mujocoinclude>");
  const ImportedModel model = import("<worldbody><include file='leg.xml'/></worldbody>");
  expect_line(model, R"("foot": {"at": [0, 0, 0]})");
  // An error message names the included file that has the mistake.
  folder_.write("foot.xml", "<mujocoinclude>\n<sit name='foot'/></mujocoinclude>");
  try {
    (void)import("<worldbody><include file='leg.xml'/></worldbody>");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.what(),
              folder_.path("foot.xml") + ": line 2, <sit> 'foot': there is no such element; did you mean 'site'?");
  }
}

TEST_F(Importing, InvalidNamesAreChangedAndNoted) {
  const ImportedModel model = import(
      "<worldbody><body name='arm'><joint name='arm'/><site name='left-tip'/><body name='ground'><joint "
      "name='left_tip'/>"
      "<body><joint/><joint/></body></body></body></worldbody>"
      "<actuator><motor name='arm' joint='arm'/><motor joint='left_tip'/></actuator>");
  EXPECT_EQ(model.notes,
            (std::vector<std::string>{
                "site 'left-tip' is called left_tip_site in the scene", "body 'arm' is called arm_body in the scene",
                "body 'ground' is called ground_body in the scene", "drive 'arm' is called arm_drive in the scene"}));
  ASSERT_EQ(model.coordinates.size(), 4u);
  EXPECT_EQ(model.coordinates[2].joint, "joint3");
  ASSERT_EQ(model.drivers.size(), 2u);
  EXPECT_EQ(model.drivers[1].name, "left_tip_drive");
  EXPECT_EQ(model.scene.bodies().size(), 4u);
}

// The name is a text of the model: it may be no UTF-8, or very long. It is the same in the scene, in its file, and in
// the scene that is read from this file.
TEST_F(Importing, AnyNameOfTheModelIsKeptByFilesOfScenes) {
  const std::string arm = "<worldbody><body><joint/></body></worldbody>";
  const auto named = [&](const std::string& name) {
    return import_model(folder_.write("model.xml", "<mujoco model='" + name + "'>" + arm + "</mujoco>"));
  };
  EXPECT_EQ(named("arm \xe2\x82\xac").name, "arm \xe2\x82\xac");
  EXPECT_EQ(named("arm \xe2\x82").name, "arm \\xe2\\x82");
  for (const std::string& name : {std::string("arm \xe2\x82\xac"), std::string("arm \xe2\x82"), std::string(90, '\xe2'),
                                  std::string(90, '\x1b'), std::string(1000, 'x'), std::string("arm&#10;leg")}) {
    SCOPED_TRACE(name);
    const ImportedModel model = named(name);
    EXPECT_EQ(model.scene.name(), model.name);
    const std::string text = write_scene(model.scene);
    const Scene again = parse_scene(text);
    EXPECT_EQ(again.name(), model.name);
    EXPECT_EQ(write_scene(again), text);
  }
}

TEST_F(Importing, IgnoredElementsAreCounted) {
  const ImportedModel model = import(
      "<option timestep='0.001'/><asset><mesh name='m'/><mesh name='n'/></asset><visual/>"
      "<worldbody><light/><geom/><body name='free'><freejoint/><inertial/><geom/><geom/><site name='s'/></body>"
      "<body name='h'><joint name='j'/></body></worldbody>"
      "<contact><exclude/></contact><sensor><gyro/></sensor><tendon><spatial/></tendon>"
      "<equality><connect active='false' body1='h' anchor='0 0 0'/><weld body1='h' body2='free'/></equality>"
      "<actuator><motor joint='j'/><position joint='j'/><general tendon='t'/></actuator>");
  const std::vector<std::pair<std::string, std::size_t>> expected = {{"actuator without joint", 1},
                                                                     {"equality that is not active", 1},
                                                                     {"exclude", 1},
                                                                     {"further actuator of a joint", 1},
                                                                     {"geom", 3},
                                                                     {"gyro", 1},
                                                                     {"inertial", 1},
                                                                     {"light", 1},
                                                                     {"mesh", 2},
                                                                     {"option", 1},
                                                                     {"spatial", 1},
                                                                     {"visual", 1}};
  EXPECT_EQ(model.left_out, expected);
  EXPECT_EQ(model.joints, 2u);
  EXPECT_EQ(model.bodies, 2u);
}

// A weld to the world turned by pi, parallel to a ball joint: the body is held in the turned posture.
TEST_F(Importing, AWeldMayTurnABodyByPi) {
  const ImportedModel model = import(R"(<worldbody>
      <body name="base"><joint name="b" type="ball"/><geom size="0.05"/><site name="s" pos="0.3 0 0"/>
        <site name="t" pos="0 0.2 0.1"/></body>
      <site name="goal" pos="0.3 0 0" quat="0 1 0 0"/>
    </worldbody><equality><weld site1="goal" site2="s"/></equality>)");
  Simulator simulator(prepare(model.scene));
  const Trajectory motion = simulator.run();
  ASSERT_TRUE(simulator.report().status.ok());
  EXPECT_LE(norm(last(motion, "s") - V3{0.3, 0, 0}), 1e-12);
  EXPECT_LE(norm(last(motion, "t") - V3{0, -0.2, -0.1}), 1e-12);
}

}  // namespace
}  // namespace assur
