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

TEST(Drawing, ASliderSlidesOnItsRail) {
  const Drawing d = drawing_of(sample("slider_crank"));
  EXPECT_TRUE(point(d, "C").slides);
  EXPECT_FALSE(point(d, "B").slides);
  EXPECT_EQ(links(d), (std::map<std::string, Kind>{{"B-O", Kind::rod}, {"B-C", Kind::rod}, {"C-Q", Kind::rail}}));
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
}

}  // namespace
}  // namespace assur::pictures
