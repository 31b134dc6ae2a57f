#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <tuple>

#include "assur/scene.hpp"

namespace assur {
namespace {

// what() of the refusal; "" if the text is accepted.
std::string refusal(const std::string& text, const Parameters& set = {}) {
  try {
    (void)parse_scene(text, "scene", ".", set);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "";
}

std::string plane(const std::string& rest) { return R"({"assur": 1, "dimension": 2, )" + rest + "}"; }
std::string space(const std::string& rest) { return R"({"assur": 1, "dimension": 3, )" + rest + "}"; }

template <class Kind, class Item>
const Kind& as(const Item& item) {
  if constexpr (requires { item.template as<Kind>(); }) {
    return *item.template as<Kind>();
  } else {
    return std::get<Kind>(item.kind);
  }
}

// The example in the description of the format, word for word.
constexpr const char* kFourBar = R"({
  "assur": 1,
  "name": "four_bar",
  "dimension": 2,                                   // 2 or 3
  "parameters": {"crank": 0.8},                     // any number may be written "=2*crank+0.1"
  "points":  {"A": {"at": [0, 0], "fixed": true},
              "D": {"at": [2, 0], "fixed": true},
              "B": {"at": [0.8, 0]},
              "C": {"at": [1.6, 1.2]}},
  "vectors": {},                                    // unit vectors {"u": {"at": [0,0,1], "fixed": true}}
  "bodies": {},
  "constraints": {"coupler": {"distance": ["B", "C"], "value": 1.8},
                  "rocker":  {"distance": ["D", "C"], "value": 1.3}},
  "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 6.283185307179586]}}},
  "measures": {"rocker_angle": {"angle": ["D", "C"]}},
  "groups": {},                                     // optional: {"SG_T": {"unknowns": ["O", "u", "v", "w"], "keep": true}}
  "outputs": ["C", "rocker_angle"],                 // left out: everything
  "time": {"start": 0, "end": 1, "step": 0.01}
})";

TEST(Json, ReadsTheExampleOfTheFormat) {
  const Scene scene = parse_scene(kFourBar);
  EXPECT_EQ(scene.name(), "four_bar");
  EXPECT_EQ(scene.dimension(), 2);
  ASSERT_EQ(scene.points().size(), 4u);
  EXPECT_EQ(scene.points()[0].name, "A");  // in the order of the file
  EXPECT_TRUE(scene.points()[1].fixed);
  EXPECT_EQ(scene.points()[1].at, (Triple{2, 0, 0}));
  EXPECT_FALSE(scene.points()[2].fixed);
  EXPECT_EQ(scene.points()[3].at, (Triple{1.6, 1.2, 0}));
  ASSERT_EQ(scene.constraints().size(), 2u);
  EXPECT_EQ(scene.constraints()[0].name, "coupler");
  EXPECT_EQ(as<Distance>(scene.constraints()[1]).p, "D");
  EXPECT_EQ(as<Distance>(scene.constraints()[1]).q, "C");
  EXPECT_EQ(as<Distance>(scene.constraints()[1]).value, 1.3);
  ASSERT_EQ(scene.drivers().size(), 1u);
  const auto& motor = as<PointAngle>(scene.drivers()[0]);
  EXPECT_EQ(motor.a + motor.b, "AB");
  EXPECT_EQ(motor.law(0.5).value, 6.283185307179586 * 0.5);
  EXPECT_EQ(motor.law(0.5).rate, 6.283185307179586);
  ASSERT_EQ(scene.measures().size(), 1u);
  EXPECT_EQ(as<AbsoluteAngle>(scene.measures()[0]).a, "D");
  EXPECT_EQ(scene.outputs(), (std::vector<std::string>{"C", "rocker_angle"}));
  EXPECT_EQ(scene.time().steps(), 100);
  EXPECT_TRUE(scene.warnings().empty());
}

TEST(Json, ReadsEveryConstraint) {
  const Scene scene = parse_scene(space(R"(
    "points": {"A": {"at": [0, 0, 0], "fixed": true}, "B": {"at": [1, 0, 0]}, "C": {"at": [0, 1, 0]}},
    "vectors": {"u": {"at": [1, 0, 0]}, "v": {"at": [0, 1, 0]}},
    "constraints": {
      "c0": {"distance": ["A", "B"]},
      "c1": {"equal_distance": [["A", "B"], ["A", "C"]]},
      "c2": {"dot": ["u", ["A", "C"]], "value": 0.5},
      "c3": {"dot": ["u", "v"]},
      "c4": {"parallel": [["B", "C"], "u"]},
      "c5": {"linear": [["A", 1], ["B", -2.5], ["u", 3]], "value": [1, 2, 3]},
      "c6": {"linear": [["B", 1], ["C", -1]], "value": 7},
      "c7": {"linear": [["B", 1], ["C", 1]]},
      "c8": {"coordinate": "c9.lambda", "value": -1},
      "c9": {"on_line": ["C", "A", "u"]},
      "c10": {"on_plane": ["B", "A", "u", ["A", "C"]]}})"));
  const auto& c = scene.constraints();
  ASSERT_EQ(c.size(), 11u);
  EXPECT_FALSE(as<Distance>(c[0]).value.has_value());
  const auto& equal = as<EqualDistance>(c[1]);
  EXPECT_EQ(equal.p + equal.q + equal.r + equal.s, "ABAC");
  EXPECT_EQ(as<Dot>(c[2]).d.first, "u");
  EXPECT_FALSE(as<Dot>(c[2]).d.is_pair());
  EXPECT_EQ(as<Dot>(c[2]).e.second, "C");
  EXPECT_EQ(as<Dot>(c[2]).value, 0.5);
  EXPECT_FALSE(as<Dot>(c[3]).value.has_value());
  EXPECT_EQ(as<Parallel>(c[4]).d.first + as<Parallel>(c[4]).d.second + as<Parallel>(c[4]).e.first, "BCu");
  ASSERT_EQ(as<Linear>(c[5]).terms.size(), 3u);
  EXPECT_EQ(as<Linear>(c[5]).terms[1], (std::pair<std::string, Number>{"B", -2.5}));
  EXPECT_EQ(as<Linear>(c[5]).value, (Triple{1, 2, 3}));
  EXPECT_EQ(as<Linear>(c[6]).value, (Triple{7, 7, 7}));
  EXPECT_EQ(as<Linear>(c[7]).value, (Triple{0, 0, 0}));
  EXPECT_EQ(as<FixedCoordinate>(c[8]).coordinate, "c9.lambda");
  EXPECT_EQ(as<FixedCoordinate>(c[8]).value, -1);
  EXPECT_EQ(as<OnLine>(c[9]).p + as<OnLine>(c[9]).a + as<OnLine>(c[9]).d.first, "CAu");
  EXPECT_EQ(as<OnPlane>(c[10]).e.second, "C");
}

TEST(Json, LinearHasAValueForEachCoordinateOfThePlane) {
  const Scene scene = parse_scene(plane(R"("points": {"B": {"at": [1, 0]}},
    "constraints": {"c": {"linear": [["B", 1]], "value": 2}})"));
  EXPECT_EQ(as<Linear>(scene.constraints()[0]).value, (Triple{2, 2, 0}));
}

TEST(Json, VectorsAreNormalised) {
  const Scene scene = parse_scene(space(R"("vectors": {
    "u": {"at": [0, 0, 1], "fixed": true}, "v": {"at": [3, 0, 4], "unit": false}, "w": {"at": [0.6, 0.8000004, 0]}},
    "bodies": {"ground": {"vectors": {"g": [0, 2, 0]}}})"));
  EXPECT_TRUE(scene.vectors()[0].fixed);
  EXPECT_TRUE(scene.vectors()[0].unit);
  EXPECT_FALSE(scene.vectors()[1].unit);
  EXPECT_EQ(scene.vectors()[1].at, (Triple{3 * 0.2, 0, 4 * 0.2}));
  EXPECT_NEAR(std::hypot(scene.vectors()[2].at[0], scene.vectors()[2].at[1]), 1, 4e-16);
  EXPECT_EQ(scene.bodies()[0].vectors[0].local, (Triple{0, 1, 0}));
  ASSERT_EQ(scene.warnings().size(), 1u);  // w is not listed, because it is off by 3.2e-7 only
  EXPECT_EQ(scene.warnings()[0].where, "/vectors");
  EXPECT_EQ(scene.warnings()[0].what, "2 vectors are normalised: v has length 5, g 2");
}

TEST(Json, ReportsNormalisedVectorsAndLimitsTheList) {
  const auto warning = [](int vectors) {
    std::string text;
    for (int i = 0; i < vectors; ++i) {
      text += (i == 0 ? "\"v" : ", \"v") + std::to_string(i) + R"(": {"at": [0, 0, 0.9486832980505138]})";
    }
    const Scene scene = parse_scene(space("\"vectors\": {" + text + "}"));
    EXPECT_EQ(scene.warnings().size(), 1u);
    return scene.warnings()[0].where + ": " + scene.warnings()[0].what;
  };
  EXPECT_EQ(warning(1), "/vectors/v0/at: the vector has length 0.948683 and is normalised");
  EXPECT_EQ(warning(8),
            "/vectors: 8 vectors are normalised: v0 has length 0.948683, v1 0.948683, v2 0.948683, v3 0.948683, v4 "
            "0.948683, v5 0.948683, and 2 more");
}

TEST(Json, ReadsBodiesAndPoses) {
  const Scene scene = parse_scene(space(R"(
    "points": {"O": {"at": [0, 0, 1]}, "Q": {"at": [2, 0, 0]}, "A": {"at": [0, 0, 0]}, "B": {"at": [1, 0, 0]},
               "C": {"at": [0, 1, 0]}},
    "vectors": {"u": {"at": [1, 0, 0]}, "v": {"at": [0, 1, 0]}, "w": {"at": [0, 0, 1]}},
    "bodies": {"terminal": {"origin": "O", "frame": ["u", "v", "w"], "points": {"P1": [0.3, 0, 0]},
      "vectors": {"t1": [0, 1, 0]}},
               "plate": {"base": ["A", "B", "C"], "points": {"M": [0.1, 0.2, 0.3]}},
               "cart": {"origin": "Q", "points": {"K": [1, 1, 1]}},
               "ground": {"points": {"G": [0, 0, 0]}}},
    "constraints": {"rod": {"distance": ["G", "P1"]}},
    "drivers": {"carry": {"pose": "terminal", "translation": [{"constant": 1}, {"constant": 2}, {"constant": 3}],
                          "rotation": {"euler_zyx": [{"constant": 4}, {"constant": 5}, {"constant": 6}]}},
                "push": {"pose": "cart", "translation": [{"constant": 1}, {"constant": 2}, {"constant": 3}]}},
    "groups": {"SG_T": {"unknowns": ["O", "u", "v", "w"], "keep": true}, "rest": {"unknowns": ["A"]}},
    "outputs": ["P1", "t1.velocity", "K.acceleration", "M.position"])"));
  ASSERT_EQ(scene.bodies().size(), 4u);
  EXPECT_EQ(scene.bodies()[0].origin, "O");
  EXPECT_EQ(scene.bodies()[0].frame, (std::vector<std::string>{"u", "v", "w"}));
  EXPECT_EQ(scene.bodies()[0].points[0].local, (Triple{0.3, 0, 0}));
  EXPECT_EQ(scene.bodies()[0].vectors[0].name, "t1");
  EXPECT_EQ(scene.bodies()[1].base, (std::vector<std::string>{"A", "B", "C"}));
  EXPECT_EQ(scene.bodies()[3].name, "ground");
  const auto& carry = as<Pose>(scene.drivers()[0]);
  EXPECT_EQ(carry.body, "terminal");
  ASSERT_EQ(carry.translation.size(), 3u);
  ASSERT_EQ(carry.rotation.size(), 3u);
  EXPECT_EQ(carry.translation[1](0).value, 2);
  EXPECT_EQ(carry.rotation[2](0).value, 6);
  EXPECT_TRUE(as<Pose>(scene.drivers()[1]).rotation.empty());
  EXPECT_TRUE(scene.groups()[0].keep);
  EXPECT_FALSE(scene.groups()[1].keep);
  EXPECT_EQ(scene.groups()[0].unknowns.size(), 4u);
}

TEST(Json, ReadsAPoseInThePlane) {
  const Scene scene = parse_scene(plane(R"(
    "points": {"A": {"at": [0, 0]}, "B": {"at": [1, 0]}},
    "bodies": {"bar": {"base": ["A", "B"]}},
    "drivers": {"carry": {"pose": "bar", "translation": [{"constant": 1}, {"constant": 2}],
      "rotation": {"angle": {"constant": 3}}}})"));
  ASSERT_EQ(as<Pose>(scene.drivers()[0]).rotation.size(), 1u);
  EXPECT_EQ(as<Pose>(scene.drivers()[0]).rotation[0](0).value, 3);
}

TEST(Json, ReadsDriversAndMeasuresInSpace) {
  const Scene scene = parse_scene(space(R"(
    "points": {"A": {"at": [0, 0, 0], "fixed": true}, "B": {"at": [1, 0, 0]}, "C": {"at": [0, 1, 0]},
      "D": {"at": [0, 1, 1]}},
    "vectors": {"z": {"at": [0, 0, 1], "fixed": true}, "u": {"at": [1, 0, 0]}, "v": {"at": [0, 1, 0]}},
    "constraints": {"slot": {"on_line": ["D", "A", "u"]}},
    "drivers": {"turn": {"angle": ["A", "B"], "axis": "z", "law": {"constant": 0}},
                "fold": {"angle": ["u", ["A", "C"]], "axis": "v", "law": {"constant": 1}},
                "pull": {"distance": ["A", "C"], "law": {"constant": 1}},
                "slide": {"coordinate": "slot.lambda", "law": {"constant": 1}}},
    "measures": {"m0": {"angle": ["u", "v"], "axis": "z"}, "m1": {"angle": [["A", "B"], ["A", "C"]]},
                 "m2": {"distance": ["B", "C"]}, "m3": {"coordinate": "slot.lambda"}},
    "outputs": ["m0", "m1.value", "m2.rate", "m3.acceleration", "slot.lambda", "slot.lambda.rate"])"));
  EXPECT_EQ(as<PointAngle>(scene.drivers()[0]).axis, Anchor("z"));
  EXPECT_EQ(as<RelativeAngle>(scene.drivers()[1]).e.second, "C");
  EXPECT_EQ(as<RelativeAngle>(scene.drivers()[1]).axis, Anchor("v"));
  EXPECT_EQ(as<DrivenDistance>(scene.drivers()[2]).b, "C");
  EXPECT_EQ(as<DrivenCoordinate>(scene.drivers()[3]).coordinate, "slot.lambda");
  EXPECT_EQ(as<AngleBetween>(scene.measures()[0]).axis, Anchor("z"));
  EXPECT_EQ(as<AngleBetween>(scene.measures()[1]).e.first, "A");
  EXPECT_EQ(as<AngleBetween>(scene.measures()[1]).axis, Anchor(""));
  EXPECT_EQ(as<MeasuredDistance>(scene.measures()[2]).a, "B");
  EXPECT_EQ(as<MeasuredCoordinate>(scene.measures()[3]).coordinate, "slot.lambda");
}

// Bounds of angles are in the unit of the angles of the file, those of lengths in m.
TEST(Json, Limits) {
  const Scene scene = parse_scene(plane(R"("angles": "deg",
    "bodies": {"crank": {}, "slider": {}},
    "joints": {"A": {"revolute": ["ground", "crank"], "at": [0, 0]}, "S": {"prismatic": ["ground", "slider"], "axis": [1, 0]}},
    "drivers": {"motor": {"coordinate": "A.angle", "law": {"constant": 0}},
                "cylinder": {"coordinate": "S.displacement", "law": {"constant": 0}}},
    "measures": {"turn": {"coordinate": "A.angle"}, "sum": {"sum": [["turn", 2]], "constant": 90},
                 "way": {"coordinate": "S.displacement"}},
    "parameters": {"most": 45},
    "limits": {"A.angle": {"min": -90, "max": "=2*most"}, "S.displacement": {"max": 2, "reaction": "end"},
               "sum": {"max": 180, "reaction": "flag"}, "way": {"min": -3}})"));
  ASSERT_EQ(scene.limits().size(), 4u);
  const auto& [angle, displacement, sum, way] =
      std::tie(scene.limits()[0], scene.limits()[1], scene.limits()[2], scene.limits()[3]);
  EXPECT_EQ(angle.quantity, "A.angle");
  EXPECT_DOUBLE_EQ(angle.min, -std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(angle.max, std::numbers::pi / 2);
  EXPECT_EQ(angle.reaction, Limit::Reaction::end);
  EXPECT_EQ(angle.driver, "motor");
  EXPECT_EQ(displacement.min, -HUGE_VAL);
  EXPECT_EQ(displacement.max, 2);
  EXPECT_EQ(displacement.driver, "cylinder");
  EXPECT_DOUBLE_EQ(sum.max, std::numbers::pi);
  EXPECT_EQ(sum.reaction, Limit::Reaction::flag);
  EXPECT_EQ(way.min, -3);
  EXPECT_EQ(way.driver, "");
}

TEST(Json, AngleOfMembersIsAnAngleOfPoints) {
  const Scene scene = parse_scene(plane(R"(
    "points": {"A": {"at": [0, 0]}, "B": {"at": [1, 0]}},
    "bodies": {"bar": {"base": ["A", "B"], "points": {"M": [0, 1]}}, "ground": {"points": {"G": [0, 0]},
      "vectors": {"x": [1, 0]}}},
    "drivers": {"turn": {"angle": ["G", "M"], "law": {"constant": 0}}},
    "measures": {"lean": {"angle": ["x", ["A", "M"]]}})"));
  EXPECT_EQ(as<PointAngle>(scene.drivers()[0]).b, "M");
  EXPECT_EQ(as<AngleBetween>(scene.measures()[0]).d.first, "x");
}

TEST(Json, ReadsLaws) {
  const std::filesystem::path folder = testing::TempDir();
  std::ofstream(folder / "line.csv") << "t, value\r\n# a comment\n0, 1\n\n 1 ,+3\n2,5e0\n";
  std::ofstream(folder / "wave.csv") << "0,0\n1,1\n2,0\n3,-1\n4,0\n";
  const Scene scene = parse_scene(plane(R"(
    "points": {"A": {"at": [0, 0]}, "B": {"at": [1, 0]}, "C": {"at": [0, 1]}},
    "drivers": {
      "d0": {"coordinate": "A.x", "law": {"constant": 4}},
      "d1": {"coordinate": "A.y", "law": {"harmonics": [{"amplitude": 2, "frequency": 0.25, "phase": 0.5},
                                                        {"amplitude": 1, "frequency": 1}], "offset": 3}},
      "d2": {"coordinate": "B.x", "law": {"table": "line.csv"}},
      "d3": {"coordinate": "B.y", "law": {"table": "wave.csv", "periodic": true}},
      "d4": {"coordinate": "C.x", "law": [{"constant": 1}, {"polynomial": [0, 2]}, {"table": "line.csv"}]}},
    "time": {"start": 0, "end": 2, "step": 0.5})"),
                                  "scene", folder);
  const auto law = [&](std::size_t i) { return as<DrivenCoordinate>(scene.drivers()[i]).law; };
  EXPECT_EQ(law(0)(1).value, 4);
  // A sine with two rounded terms: 4 roundings of numbers up to 6.
  EXPECT_NEAR(law(1)(1).value, 3 + 2 * std::sin(0.5 * std::numbers::pi + 0.5), 4 * 6 * 1.2e-16);
  EXPECT_NEAR(law(2)(1.5).value, 4, 4 * 4 * 1.2e-16);
  EXPECT_NEAR(law(2)(1.5).rate, 2, 4 * 4 * 1.2e-16);
  EXPECT_NEAR(law(3)(9).value, 1, 4 * 1.2e-16);  // after two periods
  EXPECT_NEAR(law(4)(1).value, 1 + 2 + 3, 4 * 6 * 1.2e-16);
}

TEST(Json, AcceptsExpressionsForEveryNumber) {
  const std::string text = plane(R"x(
    "parameters": {"rod": "=2*crank", "crank": 0.8, "omega": "=2*pi"},
    "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": ["=crank", "=sin(0)"]},
      "C": {"at": ["=crank + rod", 1]}},
    "constraints": {"link": {"distance": ["B", "C"], "value": "=rod+0.1"}, "half": {"linear": [["C", "=1/2"]],
      "value": "=crank"}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, "=omega"]}}},
    "time": {"start": "=0", "end": "=rod/1.6", "step": "=1/8"})x");
  const Scene scene = parse_scene(text);
  EXPECT_EQ(scene.points()[1].at, (Triple{0.8, 0, 0}));
  EXPECT_EQ(as<Distance>(scene.constraints()[0]).value, 2 * 0.8 + 0.1);
  EXPECT_EQ(as<Linear>(scene.constraints()[1]).terms[0].second, 0.5);
  EXPECT_EQ(as<PointAngle>(scene.drivers()[0]).law(0).rate, 2 * std::numbers::pi);
  EXPECT_EQ(scene.time().steps(), 8);

  const Scene longer = parse_scene(text, "scene", ".", {{"crank", 1.6}});
  EXPECT_EQ(longer.points()[1].at[0], 1.6);
  EXPECT_EQ(longer.time().steps(), 16);
  EXPECT_EQ(refusal(text, {{"crnak", 1}}),
            "scene: /parameters: there is no parameter 'crnak' to set; did you mean 'crank'?");
  EXPECT_EQ(refusal(text, {{"crank", std::nan("")}}),
            "scene: /parameters/crank: the parameter is set to nan; a finite number is wanted");
}

TEST(Json, SettingAParameterBreaksACycle) {
  const std::string text = plane(R"("parameters": {"a": "=b", "b": "=a"}, "points": {"A": {"at": ["=a", "=b"]}})");
  EXPECT_EQ(refusal(text), "scene: /parameters/a: parameters define each other in a circle: a -> b -> a");
  EXPECT_EQ(parse_scene(text, "scene", ".", {{"b", 2}}).points()[0].at, (Triple{2, 2, 0}));
}

TEST(Json, FindingsAreInDocumentOrder) {
  EXPECT_EQ(refusal(R"({"time": {"start": 0, "end": 1, "step": 0}, "outputs": ["Q"], "assur": 1, "dimension": 2,
                        "constraints": {"rod": {"distance": ["A", "B"], "value": -1}, "wrong": 3},
                        "points": {"A": {"at": [0, 0]}, "B": {"at": [1]}}})"),
            "scene: /time/step: the step is 0 s; it must be > 0\n"
            "scene: /outputs/0: there is no point, vector or measure 'Q'; there are: A, B\n"
            "scene: /constraints/rod/value: a distance must be > 0, not -1 m\n"
            "scene: /constraints/wrong: an object with one of the keys distance, equal_distance, dot, parallel, "
            "linear, coordinate, "
            "on_line, on_plane or gear is wanted here, not a number\n"
            "scene: /points/B/at: 2 numbers [x, y] are wanted in a scene of dimension 2, not 1");
}

TEST(Json, DiagnosticsHoldPointersWithoutTheFile) {
  try {
    (void)parse_scene(plane(R"("points": {"a/b~c": {"at": [0, 0]}})"), "my.json");
    FAIL();
  } catch (const Error& error) {
    ASSERT_EQ(error.diagnostics().size(), 1u);
    EXPECT_EQ(error.diagnostics()[0].where, "/points/a~1b~0c");
    EXPECT_EQ(std::string(error.what()).rfind("my.json: /points/a~1b~0c: 'a/b~c' is not a name", 0), 0u);
  }
}

TEST(Json, ReadsTheSmallestScene) {
  const Scene scene = parse_scene(plane(R"("points": {})"), "tiny");
  EXPECT_EQ(scene.name(), "tiny");
  EXPECT_EQ(scene.time().steps(), 0);
}

TEST(Json, ReportsAMissingFile) {
  for (void (*open)() :
       {+[] { (void)read_scene("no/such/scene.json"); }, +[] { (void)open_scene("no/such/scene.json"); }}) {
    try {
      open();
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::environment);
      EXPECT_STREQ(error.what(), "no/such/scene.json: the scene file cannot be read: no such file or directory");
    }
  }
}

TEST(Json, SceneHasTheNameOfItsFileAndFindsItsTables) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "scene_with_table";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "x.csv") << "0,0\n1,1\n";
  std::ofstream(folder / "mine.json") << plane(R"("points": {"A": {"at": [0, 0]}},
    "drivers": {"push": {"coordinate": "A.x", "law": {"table": "x.csv"}}})");
  const Scene scene = open_scene((folder / "mine.json").string());
  EXPECT_EQ(scene.name(), "mine");
  EXPECT_EQ(as<DrivenCoordinate>(scene.drivers()[0]).law(0.5).value, 0.5);
}

TEST(Json, RefusesTooManyValuesBeforeReading) {
  std::string text = R"({"a": /* ,, */ "[,\"{", "b": [[], {}, [ ]], // ,,
    "c": [0)";
  text.reserve(200'000'100);
  for (int i = 0; i < 100'000'000; ++i) text += ",0";
  text += "]}";
  try {
    (void)parse_scene(text, "zeros.json");
    FAIL() << "it is too large";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "zeros.json: it has 100000008 values; the limit is 100000000");
  }
}

}  // namespace
}  // namespace assur
