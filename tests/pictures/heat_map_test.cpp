// Positions and texts of the cells of a heat map.
#include "pictures/heat_map.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <set>

namespace assur::pictures {
namespace {

HeatMap two_by_two() {
  HeatMap map;
  map.title = "winners <here>";
  map.columns = {"2", "3"};
  map.rows = {"1", "10"};
  map.kinds = {{"lanes", 0, 0.2}, {"klu & more", 1, 1}};
  map.cells = {{0, "lanes", "n = 2, 1 group", true}, {1, "klu", "n = 3, 1 group"}, {}, {1, "klu 2x1", "n = 3 < 4"}};
  map.mark = "measured";
  return map;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

std::string wide(const std::string& figure) {
  const std::size_t from = figure.find("<svg class=\"plot heat wide\"");
  return figure.substr(from, figure.find("</svg>", from) - from);
}

// "720" and "2000" once touched in the narrow picture and read as "7202000".
TEST(HeatMap, PutsTouchingColumnNamesInTwoLines) {
  static const std::regex kTick("<text class=\"tick\" x=\"[0-9.]+\" y=\"([0-9.]+)\" text-anchor=\"middle\">");
  const auto lines = [](const std::string& picture) {
    std::set<std::string> at;
    for (std::sregex_iterator i(picture.begin(), picture.end(), kTick), end; i != end; ++i) at.insert((*i)[1]);
    return at.size();
  };
  HeatMap map = two_by_two();
  EXPECT_EQ(lines(figure(map)), 2u);  // one in each of the two pictures
  map.columns = {std::string(40, '1'), std::string(40, '2')};
  EXPECT_EQ(lines(figure(map)), 3u);
}

TEST(HeatMap, HasACellForEachValue) {
  const std::string picture = wide(figure(two_by_two()));
  EXPECT_EQ(count(picture, "<rect"), 3u);
  EXPECT_EQ(count(picture, "class=\"measured\""), 1u);
  EXPECT_NE(picture.find("<title>n = 3 &lt; 4</title>"), std::string::npos);
  EXPECT_NE(picture.find("aria-label=\"winners &lt;here&gt;\""), std::string::npos);
}

TEST(HeatMap, RowsAscendAndColumnsGoToTheRight) {
  static const std::regex kCell("<rect x=\"([0-9.]+)\" y=\"([0-9.]+)\"");
  const std::string picture = wide(figure(two_by_two()));
  std::vector<std::pair<double, double>> at;
  for (std::sregex_iterator i(picture.begin(), picture.end(), kCell), end; i != end; ++i) {
    at.emplace_back(std::stod((*i)[1]), std::stod((*i)[2]));
  }
  ASSERT_EQ(at.size(), 3u);
  EXPECT_LT(at[0].first, at[1].first);
  EXPECT_EQ(at[0].second, at[1].second);
  EXPECT_EQ(at[1].first, at[2].first);
  EXPECT_GT(at[1].second, at[2].second);
}

TEST(HeatMap, TheLegendNamesEveryKindAndTheMark) {
  const std::string all = figure(two_by_two()), legend = all.substr(all.find("<ul"));
  for (const char* name : {"lanes", "klu &amp; more", "measured"})
    EXPECT_NE(legend.find(name), std::string::npos) << name;
  EXPECT_EQ(count(legend, "<li>"), 3u);
}

TEST(HeatMap, ShortensTextsThatDoNotFit) {
  HeatMap map = two_by_two();
  map.cells[0].text = std::string(100, 'm');
  const std::string all = figure(map);
  EXPECT_EQ(all.find(map.cells[0].text), std::string::npos);
  EXPECT_NE(wide(all).find(">lanes</text>"), std::string::npos);
}

}  // namespace
}  // namespace assur::pictures
