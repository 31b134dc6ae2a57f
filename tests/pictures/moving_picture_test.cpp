#include "pictures/moving_picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "numbers.hpp"
#include "pictures/animation.hpp"
#include "pictures/view.hpp"
#include "scene/triple.hpp"

namespace assur::pictures {
namespace {

std::string picture_of(const Scene& scene) {
  const Prepared wanted = prepare(scene), all = prepare(with_all_places(scene));
  Simulator simulator(all);
  Animation animation(wanted, all, scene.time().steps());
  animation.take(0, simulator);
  for (std::int64_t k = 1; k <= scene.time().steps(); ++k) {
    EXPECT_TRUE(simulator.step(scene.time().time(k)).arrived());
    animation.take(k, simulator);
  }
  return animation.picture();
}

using Path = std::vector<double>;  // x, y, x, y, ...

// The places of each polyline that moves, frame by frame.
std::vector<std::vector<Path>> moving_lines(const std::string& svg) {
  static const std::regex line(R"(<polyline points="[^"]*" id="[^"]*"><animate [^>]*values="([^"]*)\")");
  std::vector<std::vector<Path>> all;
  for (std::sregex_iterator at(svg.begin(), svg.end(), line), end; at != end; ++at) {
    std::vector<Path>& frames = all.emplace_back();
    std::istringstream values((*at)[1]);
    for (std::string frame; std::getline(values, frame, ';');) {
      std::replace(frame.begin(), frame.end(), ',', ' ');
      std::istringstream numbers(frame);
      Path& path = frames.emplace_back();
      for (double x = 0; numbers >> x;) path.push_back(x);
    }
  }
  return all;
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(MovingPicture, RodsKeepTheirLengthAndTheMotionCloses) {
  const std::string svg = picture_of(sample("four_bar"));
  const auto lines = moving_lines(svg);
  ASSERT_EQ(lines.size(), 3u);  // crank, coupler, rocker
  for (const std::vector<Path>& frames : lines) {
    ASSERT_EQ(frames.size(), 49u);
    EXPECT_EQ(frames.front(), frames.back());
    const auto length = [](const Path& p) { return std::hypot(p.at(2) - p.at(0), p.at(3) - p.at(1)); };
    for (const Path& p : frames) EXPECT_NEAR(length(p), length(frames[0]), 0.2);  // tenths of a pixel at each end
  }
  EXPECT_EQ(count(svg, "<circle class=\"j\""), 3u);
  EXPECT_EQ(count(svg, "<circle class=\"j d\""), 1u);  // the motor
}

// Of ten turns in ten seconds the picture shows one, in a second that is drawn out to three.
TEST(MovingPicture, ShowsOnePeriod) {
  const std::string svg = picture_of(sample("whitworth_joints"));
  EXPECT_NE(svg.find("dur=\"3s\""), std::string::npos);
  const auto lines = moving_lines(svg);
  ASSERT_FALSE(lines.empty());
  // The crank turns once: its angle changes by the same step from frame to frame, in a view that is no circle.
  std::size_t halves = 0;
  const std::vector<Path>& crank = lines.back();
  for (std::size_t f = 1; f < crank.size(); ++f)
    halves += (crank[f][2] > crank[f][0]) != (crank[f - 1][2] > crank[f - 1][0]);
  EXPECT_EQ(halves, 2u);
}

// A motion that does not come back is shown forwards and backwards.
TEST(MovingPicture, GoesThereAndBack) {
  const std::string svg = picture_of(sample("scissor").with_time({0, 2, 0.1}));
  for (const std::vector<Path>& frames : moving_lines(svg)) {
    for (std::size_t f = 0; f < frames.size(); ++f) EXPECT_EQ(frames[f], frames[frames.size() - 1 - f]);
  }
}

TEST(MovingPicture, FitsIntoSixtyThousandBytesAndNeedsNoOtherFile) {
  for (const std::string name : {"jansen", "stewart", "double_wishbone", "n_four_bar:40"}) {
    const std::string svg = picture_of(sample(name));
    EXPECT_LE(svg.size(), 60000u) << name;
    EXPECT_EQ(count(svg, "http"), 1u) << name;  // the name of SVG
    EXPECT_EQ(count(svg, "<g"), count(svg, "</g>")) << name;
    EXPECT_EQ(svg.find("nan"), std::string::npos) << name;
  }
}

TEST(MovingPicture, HasTheSymbolsOfJoints) {
  EXPECT_EQ(count(picture_of(sample("bennett")), "<path d=\"M"), 8u + 2u);   // outline and disc; two hatched grounds
  EXPECT_EQ(count(picture_of(sample("slider_crank")), "<polygon"), 1u);      // the block
  EXPECT_EQ(count(picture_of(sample("whitworth_joints")), "<polygon"), 3u);  // three faces of the block
}

// A single posture has nothing that moves.
TEST(MovingPicture, OfOnePostureStandsStill) {
  EXPECT_EQ(picture_of(sample("gough")).find("<animate"), std::string::npos);
}

TEST(View, FitsTheWidthAndKeepsTheScale) {
  const View view(2, {{0, 0, 0}, {4, 1, 0}}, 760);
  const Pixel a = view.at({0, 0, 0}), b = view.at({4, 1, 0});
  EXPECT_NEAR(a[0], 34, 1e-9);
  EXPECT_NEAR(b[0], 760 - 34, 1e-9);
  EXPECT_NEAR(a[1] - b[1], (b[0] - a[0]) / 4, 1e-9);  // y points down
  EXPECT_NEAR(a[1] + b[1], view.height(), 1e-9);
}

// Points on a circle in any plane: the picture is at least half as wide as long.
TEST(View, DoesNotShowAPlaneFromItsEdge) {
  for (const Triple& n :
       {Triple{1, 0, 0}, Triple{0, 1, 0}, Triple{0, 0, 1}, Triple{1, 2, 2}, Triple{1, 1, 0}, Triple{-2, 1, 0.3}}) {
    const Triple x = triple::cross(n, std::abs(n[2]) < 0.9 ? Triple{0, 0, 1} : Triple{1, 0, 0}),
                 y = triple::cross(n, x);
    std::vector<Triple> circle;
    for (int k = 0; k < 60; ++k) {
      const double a = k * kTurn / 60;
      circle.push_back(triple::add(triple::scale(std::cos(a) / triple::norm(x), x),
                                   triple::scale(std::sin(a) / triple::norm(y), y)));
    }
    const View view(3, circle, 760);
    double least = 1e300, most = 0;  // diameters
    for (int k = 0; k < 30; ++k) {
      const Pixel p = view.at(circle[static_cast<std::size_t>(k)]),
                  q = view.at(circle[static_cast<std::size_t>(k) + 30]);
      const double d = std::hypot(p[0] - q[0], p[1] - q[1]);
      least = std::min(least, d), most = std::max(most, d);
    }
    EXPECT_GE(least, 0.3 * most) << n[0] << ' ' << n[1] << ' ' << n[2];
  }
}

}  // namespace
}  // namespace assur::pictures
