#include "pictures/drawing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace assur::pictures {
namespace {

using Kind = Drawing::Kind;

const Drawing::Point& point(const Drawing& d, const std::string& name) {
  const auto at = std::find_if(d.points.begin(), d.points.end(), [&](const auto& p) { return p.name == name; });
  if (at == d.points.end()) throw std::runtime_error("no point " + name);
  return *at;
}

std::string group(const Drawing& d, const std::string& name) {
  return d.groups.at(static_cast<std::size_t>(point(d, name).group)).name;
}

// The links by name, "A-B" with the names in alphabetic order.
std::map<std::string, Kind> links(const Drawing& d) {
  std::map<std::string, Kind> all;
  for (const Drawing::Link& l : d.links) {
    const auto [a, b] =
        std::minmax(d.points[static_cast<std::size_t>(l.from)].name, d.points[static_cast<std::size_t>(l.to)].name);
    EXPECT_TRUE(all.emplace(a + "-" + b, l.kind).second) << a << "-" << b << " twice";
  }
  return all;
}

TEST(Drawing, AStewartPlatformHasItsTerminalAndTwoRodsInEachLeg) {
  const Drawing d = drawing_of(sample("stewart"));
  EXPECT_EQ(d.dimension, 3);
  EXPECT_EQ(d.moving, 13u);  // O, B1..B6, P1..P6
  EXPECT_EQ(d.points.size(), 19u);
  for (std::size_t i = 0; i < d.points.size(); ++i)
    EXPECT_EQ(d.points[i].group == Drawing::Point::kFixed, i >= d.moving);
  EXPECT_EQ(group(d, "O"), "SG_T");
  EXPECT_EQ(group(d, "P3"), "SG_T");  // a member belongs to the group of its body
  EXPECT_EQ(group(d, "B3"), "SG_HS3");
  EXPECT_LT(d.groups[static_cast<std::size_t>(point(d, "O").group)].level,
            d.groups[static_cast<std::size_t>(point(d, "B1").group)].level);
  std::map<std::string, Kind> expected;
  for (const std::string k : {"1", "2", "3", "4", "5", "6"}) {
    expected["A" + k + "-B" + k] = expected["B" + k + "-P" + k] = Kind::rod;
  }
  EXPECT_EQ(links(d), expected);
  ASSERT_EQ(d.bodies.size(), 1u);
  EXPECT_EQ(d.bodies[0].points.size(), 7u);
}

TEST(Drawing, DrawsPointsThatTheOutputsDoNotNeed) {
  const Drawing d = drawing_of(sample("four_bar:3").with_outputs({"B1"}));
  EXPECT_EQ(d.moving, 4u);
  EXPECT_EQ(point(d, "B0").group, Drawing::Point::kDriven);
  EXPECT_EQ(group(d, "B3"), "B3");
  EXPECT_EQ(links(d).size(), 7u);  // the crank, three couplers, three rockers
}

// "revolute at B about u", "prismatic slide at C along rail from Q", "spherical J at P of a, b", sorted.
std::multiset<std::string> joints(const Drawing& d) {
  static constexpr const char* kNames[] = {"revolute", "prismatic", "cylindrical", "spherical", "universal", "planar"};
  const auto named = [&](int i) { return d.points.at(static_cast<std::size_t>(i)).name; };
  std::multiset<std::string> all;
  for (const Drawing::Joint& j : d.joints) {
    std::string said = kNames[static_cast<std::size_t>(j.symbol)];
    if (j.name != named(j.point)) said += " " + j.name;
    said += " at " + named(j.point);
    for (const Drawing::Axis& a : j.axes) {
      if (a.direction < 0) {
        said += " along " + named(a.from) + "-" + named(a.to);
        continue;
      }
      const Drawing::Direction& way = d.directions.at(static_cast<std::size_t>(a.direction));
      said += " along " + (way.name.empty() ? std::string(1, "xyz"[way.at[0] == 1   ? 0
                                                                   : way.at[1] == 1 ? 1
                                                                                    : 2])
                                            : way.name);
    }
    if (j.origin >= 0) said += " from " + named(j.origin);
    if (!j.of.empty()) said += " of " + j.of[0] + ", " + j.of[1];
    all.insert(said);
  }
  return all;
}

TEST(Drawing, ASliderSlidesOnItsRail) {
  const Drawing d = drawing_of(sample("slider_crank"));
  EXPECT_EQ(links(d), (std::map<std::string, Kind>{{"B-O", Kind::rod}, {"B-C", Kind::rod}}));
  EXPECT_EQ(joints(d),
            (std::multiset<std::string>{"revolute at O", "revolute at B", "prismatic slide at C along rail from Q"}));
}

TEST(Drawing, JointsOfTheSceneHaveTheirAxesAndBodies) {
  const Drawing d = drawing_of(sample("whitworth_joints"));
  EXPECT_EQ(joints(d), (std::multiset<std::string>{"revolute at O along O.axis of ground, crank",
                                                   "revolute at B along B.axis of crank, block",
                                                   "revolute at Q along Q.axis of ground, link",
                                                   "prismatic S at B along S.axis from S.origin of link, block"}));
  ASSERT_EQ(d.bodies.size(), 2u);  // the block is a point
  EXPECT_EQ(d.bodies[0].name, "crank");
  EXPECT_EQ(d.bodies[0].points.size(), 2u);
}

std::set<std::string> driven(const Scene& scene) {
  std::set<std::string> names;
  for (const Drawing::Joint& j : drawing_of(scene).joints) {
    if (j.driven) names.insert(j.name);
  }
  return names;
}

TEST(Drawing, DrivenJointsAreMarked) {
  EXPECT_EQ(driven(sample("slider_crank")), (std::set<std::string>{"O"}));      // the angle of two points
  EXPECT_EQ(driven(sample("whitworth_joints")), (std::set<std::string>{"O"}));  // a joint of the ground
  EXPECT_EQ(driven(sample("scissor")), (std::set<std::string>{"B0"}));          // a coordinate of a point
  EXPECT_EQ(driven(sample("stewart")), (std::set<std::string>{}));              // a pose
  const Scene moving = SceneBuilder("arm", 2)
                           .add(Body{.name = "arm"})
                           .add(Body{.name = "hand"})
                           .add(Body{.name = "finger"})
                           .joint("A", Revolute{"ground", "arm", Triple{0, 0}})
                           .joint("B", Revolute{"arm", "hand", Triple{1, 0}})
                           .joint("S", Prismatic{"hand", "finger", Triple{1, 1}})
                           .drive("turn", DrivenCoordinate{"A.angle", Law::polynomial({0, 1})})
                           .drive("bend", DrivenCoordinate{"B.angle", Law::polynomial({0, 1})})
                           .drive("reach", DrivenCoordinate{"S.displacement", Law::polynomial({0, 0.1})})
                           .time(0, 0.1, 0.1)
                           .build();
  EXPECT_EQ(driven(moving), (std::set<std::string>{"A", "B", "S"}));
}

// One of each joint in space, in a chain from the ground.
TEST(Drawing, EveryJointInSpaceHasItsSymbol) {
  const Scene scene = SceneBuilder("all", 3)
                          .add(Body{.name = "a"})
                          .add(Body{.name = "b"})
                          .add(Body{.name = "c"})
                          .add(Body{.name = "d"})
                          .add(Body{.name = "e", .points = {{"tip", {2, 2, 0}, true}}})
                          .joint("C", Cylindrical{"ground", "a", Triple{0, 0, 0}, Triple{1, 0, 0}})
                          .joint("S", Spherical{"a", "b", Triple{1, 0, 0}})
                          .joint("U", Universal{"b", "c", Triple{1, 1, 0}, Triple{0, 0, 1}, Triple{1, 0, 0}})
                          .joint("F", Planar{"c", "d", Triple{0, 0, 1}})
                          .joint("W", Fixed{"d", "e"})
                          .drive("one", DrivenCoordinate{"C.displacement", Law::polynomial({0, 1})})
                          .time(0, 0.1, 0.1)
                          .build();
  std::set<Drawing::Symbol> symbols;
  for (const Drawing::Joint& j : drawing_of(scene).joints) symbols.insert(j.symbol);
  using Symbol = Drawing::Symbol;
  EXPECT_EQ(symbols, (std::set<Symbol>{Symbol::cylindrical, Symbol::spherical, Symbol::universal, Symbol::planar}));
}

// Points and equations: rods along a vector at right angles to a fixed one are hinges on the ground; a point with one
// free coordinate is a slider; arms are bodies, of which no rod is drawn.
TEST(Drawing, FindsTheJointsOfPointsAndEquations) {
  const std::multiset<std::string> platform = joints(drawing_of(sample("stewart")));
  EXPECT_EQ(platform.size(), 18u);
  for (const std::string k : {"1", "2", "3", "4", "5", "6"}) {
    EXPECT_EQ(platform.count("revolute at A" + k + " along a" + k), 1u);
    EXPECT_EQ(platform.count("spherical at B" + k) + platform.count("spherical at P" + k), 2u);
  }
  const Drawing lift = drawing_of(sample("scissor"));
  EXPECT_EQ(joints(lift).count("prismatic at B0 along x"), 1u);
  EXPECT_EQ(joints(lift).count("revolute at A0"), 1u);
  EXPECT_EQ(joints(lift).count("revolute at N3"), 1u);  // where two arms cross: M3 = N3
  ASSERT_EQ(lift.links.size(), 8u);
  for (const Drawing::Link& l : lift.links) EXPECT_TRUE(l.inside) << l.name;
}

TEST(Drawing, AConstantActuatorHoldsAPlatformAtRest) {
  const Drawing d = drawing_of(sample("gough"));
  EXPECT_EQ(d.moving, 6u);
  for (std::size_t i = 0; i < d.moving; ++i) EXPECT_EQ(d.points[i].group, Drawing::Point::kResting);
  for (const auto& [pair, kind] : links(d)) EXPECT_EQ(kind, Kind::actuator) << pair;
  EXPECT_EQ(d.links.size(), 6u);
}

// The scene has one of each remaining element that relates two or more points.
TEST(Drawing, DrawsEveryElementThatRelatesPoints) {
  const Scene scene = SceneBuilder("all", 2)
                          .fixed_point("A", {0, 0})
                          .fixed_point("G", {0, 1})
                          .point("B", {1, 0})
                          .point("C", {1, 1})
                          .point("M", {0.5, 0})
                          .point("E", {2, 1})
                          .constrain("square", EqualDistance{"A", "G", "A", "B"})
                          .constrain("middle", Linear{{{"M", 2}, {"A", -1}, {"B", -1}}})
                          .constrain("side", Dot{{"A", "B"}, {"B", "C"}, 0.0})
                          .constrain("top", Distance{"B", "C", 1.0})
                          .constrain("flat", Parallel{{"A", "B"}, {"C", "E"}})
                          .constrain("level", FixedCoordinate{"E.x", 2})
                          .drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 1})})
                          .time(0, 1, 0.1)
                          .build();
  const auto found = links(drawing_of(scene));
  EXPECT_EQ(found, (std::map<std::string, Kind>{{"A-G", Kind::relation},
                                                {"A-B", Kind::rod},  // an equal_distance, too
                                                {"A-M", Kind::relation},
                                                {"B-M", Kind::relation},
                                                {"B-C", Kind::rod},
                                                {"C-E", Kind::relation}}));
  for (const Drawing::Link& l : drawing_of(scene).links)
    EXPECT_EQ(l.inside, l.name == "square" && l.kind == Kind::relation) << l.name;
}

}  // namespace
}  // namespace assur::pictures
