// Scenes are written as files that read back as the same scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "assur/scene.hpp"
#include "assur/simulator.hpp"
#include "files/shipped_files.hpp"
#include "properties/any_mechanism.hpp"
#include "properties/random_count.hpp"
#include "samples/samples.hpp"
#include "scene/same_scene.hpp"
#include "simulation/same_run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using test::written_and_read;

// The motion in up to 20 steps of both scenes.
void expect_same_motion(const Scene& a, const Scene& b) {
  const auto few = [](const Scene& s) {
    const TimeGrid t = s.time();
    const auto steps = static_cast<double>(std::min<std::int64_t>(t.steps(), 20));
    return s.with_time({t.start, t.start + steps * t.step, t.step});
  };
  const test::Result one = test::run(few(a)), other = test::run(few(b));
  EXPECT_GT(one.trajectory.rows(), 0u);
  test::expect_same_rows(one.trajectory, other.trajectory);
  EXPECT_EQ(one.report().status.code, other.report().status.code);
}

TEST(WriteScene, ShippedFilesReadBackTheSame) {
  for (const auto& file : test::shipped_files()) {
    SCOPED_TRACE(file);
    const Scene scene = read_scene(file);
    expect_same_motion(scene, written_and_read(scene));
  }
}

TEST(WriteScene, SamplesReadBackTheSame) {
  std::vector<std::string> texts = {"four_bar:3",       "stewart:legs=8,platforms=2", "gough:7",
                                    "parallelograms:2", "whitworth:hinge=stated",     "rings:legs=2,n=12,terminal=12"};
  for (const samples::SampleMechanism& s : samples::table()) texts.emplace_back(s.name);
  for (const std::string& text : texts) {
    SCOPED_TRACE(text);
    const Scene scene = sample(text);
    expect_same_motion(scene, written_and_read(scene));
  }
}

TEST(WriteScene, RandomMechanismsReadBackTheSame) {
  for (int seed = 0; seed < test::random_count(300) && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    test::Draw draw(static_cast<std::uint64_t>(seed));
    const Scene scene = test::any_mechanism(draw);
    const Scene again = written_and_read(scene);
    if (seed % 10 == 0) expect_same_motion(scene, again);
  }
}

// The name of a scene is any text, of a file or of a program.
TEST(WriteScene, EveryNameIsWrittenTheSameAgain) {
  for (const std::string& name :
       {std::string("four\nbar"), std::string("four \"bars\" \\n"), std::string(47, '\n'), std::string(1000, '\n'),
        std::string(141, 'x'), std::string(100'000, 'x'), std::string(50, '\xe2'), std::string("half \xe2\x82")}) {
    SCOPED_TRACE(name);
    SceneBuilder builder(name, 2);
    builder.add(Point{"A", {}, true});
    const std::string text = write_scene(builder.build());
    const Scene again = parse_scene(text);
    EXPECT_EQ(write_scene(again), text);
    EXPECT_EQ(parse_scene(write_scene(again)).name(), again.name());
  }
}

// Points at random doubles, also the smallest and the largest ones.
TEST(WriteScene, EveryNumberReadsBackTheSame) {
  std::mt19937_64 random(5);
  std::vector<double> numbers = {0.0,  -0.0,  1e-310, 5e-324, 1.7976931348623157e308, 1e22, 1e23, 123456789012345680.0,
                                 1e15, -1e16, 0.1,    2.0 / 3};
  while (numbers.size() < 3000) {
    const double x = std::bit_cast<double>(random());
    if (std::isfinite(x)) numbers.push_back(x);
  }
  SceneBuilder b("numbers", 2);
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    b.fixed_point("P" + std::to_string(i), {numbers[i], numbers[i + 1], 0});
  }
  const Scene scene = b.build(), again = written_and_read(scene);
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    EXPECT_TRUE(test::same_bits(again.points()[i / 2].at[0], numbers[i])) << numbers[i];
  }
}

TEST(WriteScene, UnitVectorsKeepEveryBit) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  SceneBuilder b("vectors", 3);
  for (int i = 0; i < 3000; ++i) {
    b.fixed_vector("v" + std::to_string(i), {any(random), any(random), any(random)});
  }
  written_and_read(b.build());
}

// Joints stay joints, names keep their order, and redundant keys are left out.
TEST(WriteScene, WritesAsAPersonWould) {
  const std::string text = R"({
  "assur": 1,
  "name": "wiper",
  "dimension": 2,
  "points": {
    "D": {"at": [2, 0], "fixed": true},
    "C": {"at": [1.6, 1.2]}
  },
  "bodies": {
    "ground": {"points": {"A": [0, 0]}},
    "coupler": {"points": {"tip": {"at": [1, 2]}}, "rigid": ["C"]},
    "crank": {}
  },
  "joints": {
    "motor": {"revolute": ["ground", "crank"], "at": "A"},
    "B": {"revolute": ["crank", "coupler"], "at": [0.8, 0]}
  },
  "constraints": {
    "rocker": {"distance": ["D", "C"]}
  },
  "drivers": {
    "turn": {"coordinate": "motor.angle", "law": {"polynomial": [0, 6.283185307179586]}}
  },
  "measures": {
    "elbow": {"coordinate": "B.angle"},
    "rocker_angle": {"angle": ["D", "C"]},
    "arm": {"angle": ["B", "tip"]},
    "sum": {"sum": [["elbow", 1], ["arm", -0.5]], "constant": 0.25}
  },
  "outputs": ["coupler", "sum.rate"],
  "time": {"start": 0, "end": 1, "step": 0.01}
}
)";
  const Scene scene = parse_scene(text);
  EXPECT_EQ(write_scene(scene), text);
  written_and_read(scene);
}

TEST(WriteScene, LongObjectsAreBroken) {
  SceneBuilder b("long", 3);
  Body body{"body", "O", {"u", "v", "w"}};
  for (int i = 0; i < 4; ++i) body.points.push_back({"point" + std::to_string(i), {0.125 * i, 1 / 3.0, -2}});
  std::vector<double> time, value;
  for (int i = 0; i < 12; ++i) time.push_back(i), value.push_back(0.1 * (i % 4));
  b.point("O", {}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1}).add(body);
  b.drive("pose", Pose{"body",
                       {Law::table(time, value), Law::constant(2), Law::constant(1) + Law::harmonics({{1, 2, 0}})},
                       {Law(), Law::harmonics({{0.1, 1, 0.5}, {0.01, 2, 0}}, 0.2), Law::polynomial({0, 1})}});
  EXPECT_EQ(write_scene(b.time(0, 1, 0.5).build()), R"({
  "assur": 1,
  "name": "long",
  "dimension": 3,
  "points": {
    "O": {"at": [0, 0, 0]}
  },
  "vectors": {
    "u": {"at": [1, 0, 0]},
    "v": {"at": [0, 1, 0]},
    "w": {"at": [0, 0, 1]}
  },
  "bodies": {
    "body": {
      "origin": "O",
      "frame": ["u", "v", "w"],
      "points": {
        "point0": [0, 0.3333333333333333, -2],
        "point1": [0.125, 0.3333333333333333, -2],
        "point2": [0.25, 0.3333333333333333, -2],
        "point3": [0.375, 0.3333333333333333, -2]
      }
    }
  },
  "drivers": {
    "pose": {
      "pose": "body",
      "translation": [
        {
          "table": [
            [0, 0], [1, 0.1], [2, 0.2], [3, 0.30000000000000004], [4, 0], [5, 0.1], [6, 0.2], [7, 0.30000000000000004],
            [8, 0], [9, 0.1], [10, 0.2], [11, 0.30000000000000004]
          ]
        },
        {"constant": 2},
        [{"constant": 1}, {"harmonics": [{"amplitude": 1, "frequency": 2}]}]
      ],
      "rotation": {
        "euler_zyx": [
          {"constant": 0},
          {
            "harmonics": [{"amplitude": 0.1, "frequency": 1, "phase": 0.5}, {"amplitude": 0.01, "frequency": 2}],
            "offset": 0.2
          },
          {"polynomial": [0, 1]}
        ]
      }
    }
  },
  "time": {"start": 0, "end": 1, "step": 0.5}
}
)");
}

// Every kind of joint, constraint, driver and measure, with the keys that are usually left out.
TEST(WriteScene, EveryKindReadsBackTheSame) {
  SceneBuilder b("every \"kind\" \xc3\xa4", 3);
  b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0}).point("C", {0, 1, 0}).point("D", {1, 1, 1});
  b.fixed_vector("x", {1, 0, 0}).fixed_vector("z", {0, 0, 3}).vector("n", {0, 0, 1}, false).vector("m", {0, 1, 0});
  for (const char* name : {"a", "b", "c", "d", "e", "f", "g", "h"}) b.add(Body{name});
  b.add(Body{"rigid", "", {}, {}, {}, {}, {"C", "D", "m"}});
  b.joint("J1", Revolute{"ground", "a", "A", "z"}).joint("J2", Prismatic{"a", "b", Triple{1, 0, 0}});
  b.joint("J3", Cylindrical{"b", "c", Triple{3, 1, 0}, Triple{0, 1, 0}})
      .joint("J4", Spherical{"c", "d", Triple{1, 2, 3}});
  b.joint("J5", Universal{"d", "e", Triple{2, 2, 2}, Triple{1, 0, 0}, Triple{0, 1, 0}});
  b.joint("J6", Planar{"e", "f", Triple{0, 1, 1}}).joint("J7", Fixed{"f", "g"});
  b.joint("J8", Revolute{"ground", "h", Triple{5, 0, 0}, Triple{0, 0, 1}})
      .joint("J9", Spherical{"h", "g", Triple{6, 0, 0}});
  b.constrain("k1", Distance{"A", "B", std::nullopt}).constrain("k2", EqualDistance{"A", "B", "A", "C"});
  b.constrain("k3", Dot{Direction("A", "B"), "z", 0.5}).constrain("k4", Dot{"n", Direction("B", "C"), std::nullopt});
  b.constrain("k5", Parallel{"n", Direction("A", "D")}).constrain("k6", Linear{{{"B", 1}, {"C", -0.25}}, {1, 1, 1}});
  b.constrain("k7", Linear{{{"B", 1}, {"D", 3}}, {1, 0, -0.0}}).constrain("k8", FixedCoordinate{"B.x", 1e-3});
  b.constrain("k9", OnLine{"B", "A", "n"}).constrain("k10", OnPlane{"C", "A", "x", Direction("A", "D")});
  b.constrain("k11", Gear{"J1.angle", "J8.angle", -0.5});
  b.drive("d1", PointAngle{"A", "D", "z", Law::polynomial({0, 1})});
  b.drive("d2", RelativeAngle{Direction("A", "B"), "n", "z", Law::table({0, 1, 2, 3}, {1, 2, 0.5, 1}, true)}, true);
  b.drive("d3", DrivenDistance{"B", "C", Law::constant(1) + Law::polynomial({0, 0.1})});
  b.drive("d4", DrivenCoordinate{"J2.displacement", Law::harmonics({{1, 2, 3}}, 0.5)});
  b.drive("d5", DrivenCoordinate{"J1.angle", Law::harmonics({{1, 2, 3}}, 0.5)});
  b.measure("m1", AngleBetween{"n", Direction("A", "B"), ""}).measure("m2", AngleBetween{"n", "x", "z"});
  b.measure("m3", MeasuredDistance{"B", "C"}).measure("m4", MeasuredCoordinate{"k9.lambda"});
  b.measure("m5", MeasuredCoordinate{"J3.angle"}).measure("m6", Combination{{{"m1", 2}, {"m2", -1}}, 0.5});
  b.limit("J1.angle", -0.5, 1.25, Limit::Reaction::flag)
      .add(Limit{"m3", -HUGE_VAL, 2})
      .add(Limit{"J3.displacement", 0});
  b.add(DeclaredGroup{"G", {"B", "n", "k9.lambda"}, true});
  b.output("a").output("b.origin").output("c.angular_velocity").output("J3.displacement").output("m6.value");
  const Scene scene = b.time(-1, 1, 0.25).build();
  const Scene again = written_and_read(scene);
  EXPECT_EQ(again.joints().size(), 9u);
  EXPECT_EQ(parse_scene(write_scene(SceneBuilder("two\nlines", 2).build())).name(), "two\\nlines");
}

TEST(WriteScene, KeepsOtherOutputsTimesAndLaws) {
  const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/delta.json").with_outputs({"all"});
  const Scene changed = scene.with_time({0, 0.5, 0.25}).with_laws([](const std::string&, const Law& before) {
    return before + Law::polynomial({0, 0.125});
  });
  expect_same_motion(changed, written_and_read(changed));
  const Scene joints = read_scene(ASSUR_SOURCE_DIR "/scenes/bennett.json");
  ASSERT_EQ(joints.joints().size(), 4u);
  const Scene other = joints.with_laws([](const std::string&, const Law&) { return Law::polynomial({0, 0.125}); });
  EXPECT_EQ(written_and_read(other).joints().size(), 4u);
  for (const char* output : {"coupler", "output.quaternion"}) {
    const Scene asked = other.with_outputs({output});
    expect_same_motion(asked, written_and_read(asked));
  }
}

// Outputs of a scene may be replaced by any coordinate of its joints, whatever its file asks for.
TEST(WithOutputs, AskForCoordinatesOfJoints) {
  const Scene scene = parse_scene(R"({"assur": 1, "dimension": 2, "bodies": {"a": {}, "b": {}},
      "joints": {"J": {"revolute": ["ground", "a"], "at": [0, 0]}, "K": {"prismatic": ["a", "b"], "axis": [1, 0]}},
      "drivers": {"turn": {"coordinate": "J.angle", "law": {"polynomial": [0, 1]}},
                  "push": {"coordinate": "K.displacement", "law": {"polynomial": [0, 2]}}},
      "outputs": ["J"], "time": {"start": 0, "end": 1, "step": 0.5}})");
  const Scene other = scene.with_outputs({"K.displacement", "J.angle.rate"});
  EXPECT_EQ(other.drivers().size(), 2u);
  const Trajectory motion = test::run(other).trajectory;
  EXPECT_NEAR(motion.last("K.displacement"), 2, 1e-14);
  EXPECT_NEAR(motion.last("J.angle.rate"), 1, 1e-14);
  written_and_read(other);
  EXPECT_EQ(test::SceneDump::of(other.with_outputs({"J"}).with_outputs({"K.displacement", "J.angle.rate"})),
            test::SceneDump::of(other));
}

// Parameters and tables are replaced by their values.
TEST(WriteScene, WritesValuesInsteadOfParametersAndTables) {
  const auto folder = std::filesystem::path(testing::TempDir());
  std::ofstream(folder / "lift.csv") << "t,value\n0,10\n1,20\n2,10.5\n";
  const Scene scene =
      parse_scene(R"({"assur": 1, "dimension": 2, "angles": "deg", "parameters": {"r": 0.1, "s": "=3*r"},
      "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": ["=s", 0]}},
      "drivers": {"m": {"angle": ["A", "B"], "law": {"table": "lift.csv"}}}})",
                  "crank", folder);
  const std::string text = write_scene(scene);
  EXPECT_NE(text.find(R"("B": {"at": [0.30000000000000004, 0]})"), std::string::npos) << text;
  EXPECT_NE(text.find(R"("law": {"table": [[0, 0.17453292519943295], [1, 0.3490658503988659], [2, 0.1832595)"),
            std::string::npos)
      << text;
  written_and_read(scene);
}

std::string refusal(const SceneBuilder& builder) {
  try {
    (void)write_scene(builder.build());
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "written";
}

TEST(WriteScene, NamesFunctionsThatAFileCannotHold) {
  const auto nothing = [](std::span<const double>, std::span<double>) {};
  Callback own{{"B.x", "B.y"}, 1, nothing, nothing, [](auto, auto, auto) {}};
  SceneBuilder b("functions", 2);
  b.fixed_point("A", {0, 0}).point("B", {1, 0}).constrain("own", own);
  b.drive("motor", PointAngle{"A", "B", "", Law::constant(1) + Law::function([](double t) {
                                              return Motion{t, 1, 0};
                                            })});
  EXPECT_EQ(refusal(b),
            "/constraints/own: equations of your own code cannot be written in a file; add a Callback in C++\n"
            "/drivers/motor: a law that is a function of the program cannot be written in a file; give a polynomial, "
            "harmonics or a table");
}

TEST(WriteScene, WritesFilesOrSaysWhyNot) {
  const auto file = std::filesystem::path(testing::TempDir()) / "written.json";
  const Scene scene = sample("four_bar");
  write_scene(scene, file);
  EXPECT_EQ(test::SceneDump::of(read_scene(file)), test::SceneDump::of(scene));
  std::filesystem::remove(file);
  try {
    write_scene(scene, "no/such/folder/scene.json");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_EQ(std::string(error.what()),
              "no/such/folder/scene.json: the scene cannot be written: No such file or directory");
  }
}

TEST(TablesInScenes, NameWrongRows) {
  const auto refused = [](const std::string& table) {
    try {
      (void)parse_scene(R"({"assur": 1, "dimension": 2, "points": {"A": {"at": [0, 0]}},
                          "drivers": {"m": {"coordinate": "A.x", "law": {"table": )" +
                        table + "}}}}");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused("[[0, 0], [1, \"=1/2\"]]"), "accepted");
  EXPECT_EQ(refused("[[0, 0], [1]]"), "scene: /drivers/m/law/table/1: 2 items are wanted here, e.g. [t, value], not 1");
  EXPECT_EQ(refused("[[0, 0]]"), "scene: /drivers/m/law/table: a table needs at least 2 rows, not 1");
  EXPECT_EQ(refused("[[1, 0], [1, 2]]"),
            "scene: /drivers/m/law/table: the times of a table must ascend, but time[1] = 1 follows 1");
  EXPECT_EQ(refused("[[0, 0], [1, true]]"),
            "scene: /drivers/m/law/table/1/1: a number is wanted here, not true or false");
}

}  // namespace
}  // namespace assur
