// Scenes with other values of their parameters and numbers.
#include <gtest/gtest.h>

#include <string>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/simulator.hpp"
#include "refusal.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using test::refusal;

std::string file(const std::string& name) { return std::string(ASSUR_SOURCE_DIR) + "/scenes/" + name + ".json"; }

double length(const Scene& scene, const std::string& constraint) {
  for (const Constraint& c : scene.constraints()) {
    if (c.name == constraint) return *c.as<Distance>()->value;
  }
  return 0;
}
Triple place(const Scene& scene, const std::string& point) {
  for (const Point& p : scene.points()) {
    if (p.name == point) return p.at;
  }
  return {};
}

TEST(SceneValues, ParametersOfAFunction) {
  const auto make = [](const Parameters& of) {
    return SceneBuilder("f", 2)
        .fixed_point("A", {0, 0})
        .point("B", {of.at("crank"), of.at("rise")})
        .constrain("crank", Distance{"A", "B", of.at("crank") * 2})
        .build();
  };
  const Scene scene = parametric_scene({{"rise", 0.5}, {"crank", 1}}, make);
  EXPECT_EQ(scene.parameters(), (std::vector<std::string>{"crank", "rise"}));
  EXPECT_EQ(length(scene, "crank"), 2);
  const Scene other = scene.with_values({{"crank", 3}, {"B.x", 7}});
  EXPECT_EQ(length(other, "crank"), 6);
  EXPECT_EQ(place(other, "B"), (Triple{7, 0.5, 0}));
  EXPECT_EQ(length(other.with_values({{"rise", 1}}), "crank"), 6);
  EXPECT_NE(refusal([&] { (void)scene.with_values({{"crnk", 1}}); }).find("crank"), std::string::npos);
}

TEST(SceneValues, ParametersOfAFile) {
  const Scene scene = read_scene(file("four_bar"));
  const std::vector<std::string> names = {"crank_length", "coupler_length", "rocker_length", "omega", "step", "steps"};
  EXPECT_EQ(scene.parameters(), names);
  const Scene other = scene.with_values({{"crank_length", 0.7}});
  EXPECT_EQ(length(other, "crank"), 0.7);
  EXPECT_EQ(place(other, "B0")[0], 0.7);
  EXPECT_EQ(length(other, "coupler1"), 1.8);
  EXPECT_EQ(length(scene, "crank"), 0.8);
  // Values that were set before stay.
  const Scene both = other.with_values({{"rocker_length", 1.2}});
  EXPECT_EQ(length(both, "crank"), 0.7);
  EXPECT_EQ(length(both, "rocker1"), 1.2);
  const Scene set = read_scene(file("four_bar"), {{"crank_length", 0.6}}).with_values({{"rocker_length", 1.2}});
  EXPECT_EQ(length(set, "crank"), 0.6);
}

TEST(SceneValues, OptionsOfASample) {
  const Scene other = sample("slider_crank:rod_length=0.4").with_values({{"crank_length", 0.2}});
  EXPECT_EQ(length(other, "crank"), 0.2);
  EXPECT_EQ(length(other, "rod"), 0.4);
}

TEST(SceneValues, NumbersAsWritten) {
  const Scene scene = read_scene(file("four_bar"));
  const Scene other = scene.with_values({{"A1.x", 2.5}, {"A1.y", 0.1}, {"coupler1", 1.9}});
  EXPECT_EQ(place(other, "A1"), (Triple{2.5, 0.1, 0}));
  EXPECT_EQ(length(other, "coupler1"), 1.9);
  // A parameter that is set later keeps them, and the other way round.
  const Scene later = other.with_values({{"crank_length", 0.7}});
  EXPECT_EQ(length(later, "coupler1"), 1.9);
  EXPECT_EQ(length(later, "crank"), 0.7);
  EXPECT_EQ(length(scene.with_values({{"crank_length", 0.7}}).with_values({{"coupler1", 1.9}}), "crank"), 0.7);
  const Scene in_one = scene.with_values({{"crank_length", 0.7}, {"coupler1", 1.9}});
  EXPECT_EQ(length(in_one, "coupler1"), 1.9);
  EXPECT_EQ(length(in_one, "crank"), 0.7);
}

// Joints are expanded into constraints; their places are numbers as written.
TEST(SceneValues, PlacesOfJoints) {
  const Scene scene = read_scene(file("watt"));
  const auto end = [](const Scene& s) { return Simulator(prepare(s, {"groups/eigen"})).run().last("M.x"); };
  EXPECT_NE(end(scene), end(scene.with_values({{"B.x", 0.1}})));
  EXPECT_EQ(end(scene), end(scene.with_values({{"B.x", 0}})));
}

TEST(SceneValues, OutputsAndTimesStay) {
  const Scene scene = read_scene(file("four_bar")).with_outputs({"rocker_angle"}).with_time({0, 0.5, 0.25});
  for (const Scene& other : {scene.with_values({{"crank_length", 0.7}}), scene.with_values({{"A1.x", 2.1}}),
                             scene.with_values({{"A1.x", 2.1}}).with_values({{"crank_length", 0.7}})}) {
    EXPECT_EQ(other.outputs(), scene.outputs());
    EXPECT_EQ(other.time().step, 0.25);
    EXPECT_EQ(other.time().end, 0.5);
  }
  // Without with_time(), the grid follows its parameters.
  EXPECT_EQ(read_scene(file("four_bar")).with_values({{"step", 0.002}}).time().step, 0.002);
}

TEST(SceneValues, Refusals) {
  const Scene scene = read_scene(file("four_bar"));
  EXPECT_EQ(refusal([&] {
              (void)scene.with_values({{"A1.z", 1}});
            }),
            "the scene has no parameter and no number 'A1.z'; did you mean 'A1.y'?");
  EXPECT_NE(refusal([&] { (void)scene.with_values({{"crank_length", -1}}); }), "");
  EXPECT_NE(refusal([&] { (void)scene.with_values({{"coupler1", 0}}); }), "");
  const Scene with_laws = scene.with_laws([](const std::string&, const Law& law) { return law; });
  EXPECT_TRUE(with_laws.parameters().empty());
  EXPECT_NE(refusal([&] { (void)with_laws.with_values({{"crank_length", 0.7}}); }), "");
  EXPECT_EQ(length(with_laws.with_values({{"coupler1", 1.9}}), "coupler1"), 1.9);
}

TEST(SceneValues, ScenesOfTheProgramHaveNoParameters) {
  SceneBuilder b("program", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0}).constrain("rod", Distance{"A", "B", 1.0});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 1})}).time(0, 1, 0.1);
  const Scene scene = std::move(b).build();
  EXPECT_TRUE(scene.parameters().empty());
  EXPECT_EQ(length(scene.with_values({{"rod", 2}}), "rod"), 2);
}

}  // namespace
}  // namespace assur
