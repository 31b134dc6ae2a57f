#include "pictures/outputs_over_time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>

#include "assur/simulator.hpp"

namespace assur::pictures {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

std::string picture(const Scene& scene, const std::string& why = "") {
  const Prepared prepared = prepare(scene);
  return outputs_over_time(prepared, Simulator(prepared).run(), why);
}

// The y of each vertex of the n-th curve.
std::vector<double> heights(const std::string& svg, std::size_t n) {
  static const std::regex kPath("class=\"line [^\"]*\" d=\"([^\"]*)\"");
  auto at = std::sregex_iterator(svg.begin(), svg.end(), kPath);
  std::advance(at, static_cast<std::ptrdiff_t>(n));
  std::string path = (*at)[1];
  for (char& c : path) {
    if (c == 'M' || c == 'L') c = ' ';
  }
  std::istringstream numbers(path);
  std::vector<double> all;
  for (double x = 0, y = 0; numbers >> x >> y;) all.push_back(y);
  return all;
}

TEST(OutputsOverTime, HasADiagramForEachQuantityAndACurveForEachComponent) {
  const std::string svg = picture(sample("slider_crank").with_outputs({"rod_angle", "C"}));
  EXPECT_EQ(count(svg, "<svg "), 1 + 2 * 6u);  // one of the file, two of each diagram
  EXPECT_EQ(count(svg, "<svg "), count(svg, "</svg>"));
  EXPECT_EQ(count(svg, "<path class=\"line"), 3 + 3 * 2u);
  EXPECT_NE(svg.find("rod_angle, acceleration, rad/s²"), std::string::npos);
  EXPECT_EQ(svg.find("Left out"), std::string::npos);
  EXPECT_EQ(svg.find("var("), std::string::npos);  // only browsers know variables
}

TEST(OutputsOverTime, NamesOutputsThatDoNotFit) {
  const std::string svg = picture(sample("stewart"), "t = 1 s, group <X>");
  EXPECT_EQ(count(svg, "aria-label"), kMostDiagrams);
  EXPECT_NE(svg.find("Left out (select outputs with --outputs): handle5, handle6, O, "), std::string::npos);
  EXPECT_NE(svg.find("The motion ends early: t = 1 s, group &lt;X&gt;."), std::string::npos);
}

// A turn of the crank has 50,000 steps. Each stretch of the curve keeps its smallest and largest value.
TEST(OutputsOverTime, ThinsManyStepsWithoutLosingPeaks) {
  const Scene scene = sample("slider_crank").with_outputs({"C.position"}).with_time({0, 1, 2e-5});
  const std::vector<double> y = heights(picture(scene), 0);
  EXPECT_LT(y.size(), 2100u);
  EXPECT_GT(y.size(), 500u);
  // C.x goes from crank + rod, 0.4, to rod - crank, 0.2, and C.y is 0, so the axis is twice as long. Pixels have one
  // digit.
  // digit.
  const auto [top, bottom] = std::minmax_element(y.begin(), y.end());
  const double axis = 260 - 46 - 34;
  EXPECT_NEAR(*bottom - *top, axis / 2, 0.11);
  EXPECT_NEAR(y.front(), *top, 0.11);
  EXPECT_NEAR(y.back(), *top, 0.11);
}

TEST(OutputsOverTime, DrawsASinglePostureAsADot) {
  EXPECT_EQ(count(picture(sample("gough").with_outputs({"B1.position"})), "<circle"), 3u);
}

}  // namespace
}  // namespace assur::pictures
