// Positions of numbers in a picture.
#include "pictures/plot.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <regex>

#include "pictures/html.hpp"
#include "pictures/ticks.hpp"

namespace assur::pictures {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

struct Place {
  double x, y;
};

std::vector<Place> circles(const std::string& picture) {
  static const std::regex kCircle("<circle cx=\"([-0-9.]+)\" cy=\"([-0-9.]+)\"");
  std::vector<Place> all;
  for (std::sregex_iterator at(picture.begin(), picture.end(), kCircle), end; at != end; ++at) {
    all.push_back({std::stod((*at)[1]), std::stod((*at)[2])});
  }
  return all;
}

Plot logarithmic(std::vector<Point> points) {
  Plot plot;
  plot.title = "errors & times";
  plot.x = {"error", true, power_of_ten};
  plot.y = {"time", true, time_text};
  plot.series.push_back({.name = "solver", .points = std::move(points)});
  return plot;
}

TEST(Plot, SpacesLogarithmsEvenly) {
  const auto at = circles(drawn(logarithmic({{1e-12, 1e-6}, {1e-8, 1e-5}, {1e-4, 1e-4}}), {600, 400}));
  ASSERT_EQ(at.size(), 3u);
  // Positions are written with one decimal.
  EXPECT_NEAR(at[1].x - at[0].x, at[2].x - at[1].x, 0.2);
  EXPECT_NEAR(at[1].y - at[0].y, at[2].y - at[1].y, 0.2);
  EXPECT_GT(at[1].x, at[0].x + 100);
  EXPECT_LT(at[1].y, at[0].y - 100);  // upwards
  for (const Place& p : at) {
    EXPECT_GE(p.x, 0);
    EXPECT_LE(p.x, 600);
    EXPECT_GE(p.y, 0);
    EXPECT_LE(p.y, 400);
  }
}

TEST(Plot, LeavesOutPointsOutsideTheAxis) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::string picture =
      drawn(logarithmic({{1e-9, 1e-6}, {0, 1e-6}, {1e-9, kNaN}, {-1, 1}, {HUGE_VAL, 1e-6}, {1e-3, 1e-5}}), {600, 400});
  EXPECT_EQ(circles(picture).size(), 2u);
  EXPECT_EQ(picture.find("nan"), std::string::npos);
  EXPECT_EQ(picture.find("inf"), std::string::npos);
}

TEST(Plot, DrawsAxesWithoutPoints) {
  const std::string picture = drawn(logarithmic({}));
  EXPECT_EQ(circles(picture).size(), 0u);
  EXPECT_GE(count(picture, "class=\"grid\""), 4u);
}

TEST(Plot, AStaircaseGoesAlongXFirst) {
  Plot plot = logarithmic({{1e-12, 1e-4}, {1e-8, 1e-5}});
  plot.series[0].line = Series::Line::steps;
  const std::string picture = drawn(plot, {600, 400});
  EXPECT_TRUE(std::regex_search(picture, std::regex("d=\"M[0-9.]+ [0-9.]+H[0-9.]+V[0-9.]+\"")));
}

TEST(Plot, MovesOverlappingLabels) {
  Plot plot = logarithmic({});
  plot.series[0].points = {{1e-9, 1e-8}, {1e-2, 1e-4}};  // these points set the ends of the axes
  for (int i = 0; i < 12; ++i) plot.series[0].points.push_back({1e-6, 1e-6, "", std::to_string(i)});
  plot.series[0].points.push_back({1e-4, 1e-5, "", "apart"});
  EXPECT_EQ(count(drawn(plot), "class=\"label\""), 8u + 1u);  // 8 labels around the points, and the one apart
}

// A narrow front of many almost equally fast strategies. Its first point is on an axis.
TEST(Plot, LabelsLieApartAndBesideTheMarks) {
  Plot plot = logarithmic({{1e-3, 1e-2}});
  for (int i = 0; i < 14; ++i) {
    plot.series[0].points.push_back({1e-15 * std::pow(1.3, i), 1e-6 * std::pow(0.97, i), "", std::to_string(i + 1)});
  }
  for (const Size size : {Size{960, 560}, Size{360, 400}}) {
    const std::string picture = drawn(plot, size);
    struct Label {
      double x, y, half;
    };
    std::vector<Label> labels;
    const std::regex form("<text class=\"label\" x=\"([0-9.]+)\" y=\"([0-9.]+)\"[^>]*>([0-9]+)</text>");
    for (std::sregex_iterator it(picture.begin(), picture.end(), form), end; it != end; ++it) {
      // A bold figure is 9.1 px wide and 9.5 px high at 13 px.
      labels.push_back({std::stod((*it)[1]), std::stod((*it)[2]), 9.1 / 2 * static_cast<double>((*it)[3].length())});
    }
    EXPECT_GE(labels.size(), 6u);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_TRUE(std::abs(labels[i].x - labels[j].x) > labels[i].half + labels[j].half + 1 ||
                    std::abs(labels[i].y - labels[j].y) > 9.5 + 1)
            << i << " and " << j;
      }
    }
    EXPECT_EQ(picture.find("class=\"label\" x=\"-"), std::string::npos);
  }
}

TEST(Plot, TextsCannotBreakThePage) {
  Plot plot = logarithmic({{1e-9, 1e-6, "a<b & \"c\""}});
  const std::string page = figure(plot);
  EXPECT_NE(page.find("<title>a&lt;b &amp; &quot;c&quot;</title>"), std::string::npos);
  EXPECT_NE(page.find("errors &amp; times"), std::string::npos);
  EXPECT_EQ(page.find("a<b"), std::string::npos);
}

TEST(Plot, AFigureHasTwoPicturesAndOneLegend) {
  const std::string page = figure(logarithmic({{1e-9, 1e-6}}));
  EXPECT_EQ(count(page, "class=\"plot wide\""), 1u);
  EXPECT_EQ(count(page, "class=\"plot narrow\""), 1u);
  EXPECT_EQ(count(page, "<li>"), 1u);
  for (const std::string element : {"svg", "g", "text", "circle", "figure", "ul"}) {
    EXPECT_EQ(count(page, "<" + element + " ") + count(page, "<" + element + ">"), count(page, "</" + element + ">"))
        << element;
  }
}

TEST(Html, EveryCellOfATableIsThere) {
  const HtmlTable table{
      {"a", "b"}, {HtmlTable::Column::text, HtmlTable::Column::number}, {{{"x<y", "1"}}, {{"z", "2"}, "strong"}}};
  const std::string text = html(table);
  EXPECT_NE(text.find("<td>x&lt;y</td><td class=\"number\">1</td>"), std::string::npos);
  EXPECT_NE(text.find("<tr class=\"strong\"><td>z</td>"), std::string::npos);
}

TEST(Html, APageNeedsNoOtherFiles) {
  const std::string page = html_page("a & b", plot_style(), figure(logarithmic({{1e-9, 1e-6}})));
  EXPECT_EQ(page.find("src="), std::string::npos);
  EXPECT_EQ(page.find("<link"), std::string::npos);
  EXPECT_EQ(page.find("url("), std::string::npos);
  EXPECT_NE(page.find("<title>a &amp; b</title>"), std::string::npos);
  EXPECT_NE(page.find("prefers-color-scheme: dark"), std::string::npos);
}

TEST(Plot, BarsStandOnTheAxisFromEachXToTheNext) {
  Plot plot = logarithmic({{1, 10}, {10, 0}, {100, 1000}, {1000, 1}});
  plot.series[0].mark = Series::Mark::none;
  plot.series[0].line = Series::Line::bars;
  const std::string picture = drawn(plot, {600, 400});
  static const std::regex kBar("<rect x=\"([0-9.]+)\" y=\"([0-9.]+)\" width=\"([0-9.]+)\" height=\"([0-9.]+)\"");
  std::vector<std::array<double, 4>> bars;
  for (std::sregex_iterator at(picture.begin(), picture.end(), kBar), end; at != end; ++at) {
    bars.push_back({std::stod((*at)[1]), std::stod((*at)[2]), std::stod((*at)[3]), std::stod((*at)[4])});
  }
  // On a logarithmic axis 0 has no bar, and the last point only ends the bar before it.
  ASSERT_EQ(bars.size(), 2u);
  EXPECT_NEAR(bars[0][2], bars[1][2], 0.2);                            // each is a decade wide
  EXPECT_NEAR(bars[1][0], bars[0][0] + 2 * bars[0][2], 0.3);           // an empty decade is between them
  EXPECT_NEAR(bars[0][1] + bars[0][3], bars[1][1] + bars[1][3], 0.2);  // both stand on the axis
  EXPECT_LT(bars[1][1], bars[0][1]);
}

}  // namespace
}  // namespace assur::pictures
