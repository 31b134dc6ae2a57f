#include "pictures/animation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pictures/unpacked.hpp"

namespace assur::pictures {
namespace {

struct Shown {
  nlohmann::json data;
  std::vector<double> places, values;
  std::string page;
};

Shown show(const Scene& scene, std::int64_t until = -1) {
  const Prepared wanted = prepare(scene), all = prepare(with_all_places(scene));
  Simulator simulator(all);
  const std::int64_t steps = scene.time().steps();
  Animation animation(wanted, all, steps);
  animation.take(0, simulator);
  for (std::int64_t k = 1; k <= (until < 0 ? steps : until); ++k) {
    EXPECT_TRUE(simulator.step(scene.time().time(k)).ok());
    animation.take(k, simulator);
  }
  if (until >= 0) animation.end(simulator, "the </script> of it");
  Shown out{{}, {}, {}, animation.page({"a <b> sentence"})};
  const std::string begin = "id=\"motion\">";
  const std::size_t from = out.page.find(begin) + begin.size();
  out.data = nlohmann::json::parse(out.page.substr(from, out.page.find("</script>", from) - from));
  const auto unpack = [&](const char* key) {
    const auto& packed = out.data[key];
    return unpacked(packed["text"], packed["low"], packed["span"]);
  };
  out.places = unpack("places");
  out.values = unpack("values");
  return out;
}

// All postures of a four-bar are exact to 24 bits of the range of its points.
TEST(Animation, HasThePosturesOfTheRun) {
  const Scene scene = sample("four_bar").with_outputs({"rocker_angle"});
  const Shown shown = show(scene);
  Simulator simulator(prepare(scene.with_outputs({"B0.position", "B1.position", "rocker_angle.value"})));
  const Trajectory run = simulator.run();
  ASSERT_EQ(run.rows(), 1001u);
  const std::size_t frames = shown.data["times"].size();
  ASSERT_EQ(shown.places.size(), frames * 4);
  ASSERT_EQ(shown.values.size(), frames * 3);  // with rate and acceleration
  const double span = shown.data["places"]["span"][0], angle = shown.data["values"]["span"][0];
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = shown.data["times"][f];
    const auto k = static_cast<std::size_t>(std::llround(t / scene.time().step));
    EXPECT_EQ(run.times()[k], t);
    for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(shown.places[4 * f + c], run(k, c), span * 1e-7);
    EXPECT_NEAR(shown.values[3 * f], run(k, 4), angle * 1e-7);
  }
  EXPECT_EQ(shown.data["outputs"].size(), 3u);
  EXPECT_EQ(shown.data["outputs"][0]["of"], "rocker_angle");
}

TEST(Animation, ThinsManyStepsEvenlyAndKeepsBothEnds) {
  const Shown shown = show(sample("slider_crank").with_time({0, 1, 1.0 / 4321}));
  const std::vector<double> times = shown.data["times"];
  EXPECT_LE(times.size(), 1001u);
  EXPECT_GE(times.size(), 500u);
  EXPECT_EQ(times.front(), 0);
  EXPECT_EQ(times.back(), 1);
  for (std::size_t i = 1; i + 1 < times.size(); ++i) EXPECT_NEAR(times[i] - times[i - 1], 5.0 / 4321, 1e-12);
  EXPECT_NE(shown.page.find(" of 4,322 postures are shown, every 5th."), std::string::npos);
}

TEST(Animation, ShowsAMotionThatEndsEarlyAndTheReason) {
  const Shown shown = show(sample("four_bar"), 40);
  EXPECT_EQ(shown.data["times"].size(), 41u);
  EXPECT_NE(shown.page.find("The motion ends early: the &lt;/script&gt; of it."), std::string::npos);
  EXPECT_NE(shown.page.find("a &lt;b&gt; sentence"), std::string::npos);
}

TEST(Animation, LimitsTheFileSizeOfALargeScene) {
  const Shown shown = show(sample("rings:legs=64,n=120,steps=40"));
  EXPECT_GT(shown.data["points"].size(), 5000u);
  EXPECT_EQ(shown.data["times"].size(), 41u);
  EXPECT_LT(shown.page.size(), 4u << 20U);
  EXPECT_NE(shown.page.find("200 of 17,334 diagrams can be chosen"), std::string::npos);
}

TEST(Animation, PageNeedsNoOtherFiles) {
  const std::string page = show(sample("gough")).page;
  EXPECT_EQ(page.find("src="), std::string::npos);
  EXPECT_EQ(page.find("<link"), std::string::npos);
  EXPECT_EQ(page.find("url("), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos);
}

// The axes of hinges turn with the bodies; the page has them in every frame.
TEST(Animation, HasTheDirectionsOfTheJoints) {
  const Scene scene = sample("bennett").with_outputs({"A.angle"});
  const Shown shown = show(scene);
  const auto& joints = shown.data["joints"];
  ASSERT_EQ(joints.size(), 4u);
  EXPECT_EQ(joints[1]["symbol"], "revolute");
  EXPECT_EQ(joints[0]["driven"], true);
  EXPECT_EQ(joints[1]["driven"], false);
  EXPECT_EQ(joints[1]["of"], (nlohmann::json{"input", "coupler"}));
  Simulator simulator(prepare(scene.with_outputs({"B.axis.position", "C.axis.position"})));
  const Trajectory run = simulator.run();
  const std::vector<double> ways =
      unpacked(shown.data["ways"]["text"], shown.data["ways"]["low"], shown.data["ways"]["span"]);
  const std::size_t frames = shown.data["times"].size();
  ASSERT_EQ(run.rows(), frames);
  ASSERT_EQ(ways.size(), frames * 6);  // the axes of A and D rest
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t c = 0; c < 6; ++c) EXPECT_NEAR(ways[6 * f + c], run(f, c), 2e-7);
  }
}

// A coupler with two ball joints turns about itself: its point beside the line is not computed, and not drawn.
TEST(Animation, LeavesOutPointsThatNothingDetermines) {
  const Scene scene = SceneBuilder("rssr", 3)
                          .add(Body{.name = "a"})
                          .add(Body{.name = "c", .points = {{"side", {0.5, 1.1, 0.2}, true}}})
                          .add(Body{.name = "b"})
                          .joint("A", Revolute{"ground", "a", Triple{0, 0, 0}, Triple{0, 0, 1}})
                          .joint("P", Spherical{"a", "c", Triple{0.4, 0.1, 0.05}})
                          .joint("Q", Spherical{"c", "b", Triple{0.9, 1.6, 0.5}})
                          .joint("B", Revolute{"ground", "b", Triple{1.5, 0.6, 0.4}, Triple{0.3, 0.1, 1}})
                          .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, 6})})
                          .output("Q")
                          .time(0, 1, 1.0 / 64)
                          .build();
  const Shown shown = show(scene);
  std::vector<std::string> names;
  for (const auto& point : shown.data["points"]) names.push_back(point["name"]);
  const auto has = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  EXPECT_TRUE(has("P") && has("Q") && has("A") && has("B"));
  EXPECT_FALSE(has("side"));
  const Trajectory run = Simulator(prepare(scene)).run();
  const auto q = static_cast<std::size_t>(std::find(names.begin(), names.end(), "Q") - names.begin());
  const std::size_t frames = shown.data["times"].size(), moving = shown.places.size() / 3 / frames;
  ASSERT_EQ(frames, run.rows());
  ASSERT_LT(q, moving);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(shown.places[3 * (f * moving + q) + k], run(f, k), 1e-6);
  }
}

TEST(WithAllPlaces, AddsMissingPointsAndVectorsAfterTheRequestedOutputs) {
  const Scene scene = with_all_places(sample("stewart").with_outputs({"handle1", "B1"}));
  EXPECT_EQ(scene.outputs().size(), 2 + 13u + 3 + 6 * 5);  // u, v, w; e, r, c, d, t of each leg
  EXPECT_EQ(scene.outputs()[0], "handle1");
  EXPECT_TRUE(with_all_places(sample("stewart")).outputs().empty());  // everything is an output
}

}  // namespace
}  // namespace assur::pictures
