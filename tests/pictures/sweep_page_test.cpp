// The page of `assur sweep --html`.
#include "pictures/sweep_page.hpp"

#include <gtest/gtest.h>

#include "numbers.hpp"

namespace assur::test {
namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

sweep::DesignSample row(std::int64_t sample, const std::string& status, double a, double b, double figure) {
  return {.sample = sample, .parameters = {a, b}, .status = status, .reached = 1, .figures = {figure}, .why = {}};
}

pictures::SweepPage example() {
  const sweep::DesignSample best = row(2, "ok", 0.3, 3, 0.1);
  return {"a<b",
          {"4 of 4 samples."},
          {{"first", 0, 1}, {"second", 1, 4}},
          {"C.x.max"},
          {row(0, "ok", 0.1, 1, 0.5), row(1, "fold", 0.2, 2, 0.7), best,
           row(3, sweep::DesignSample::kNotAssembled, 0.4, 4, kNan)},
          {best},
          {"Man"}};
}

TEST(SweepPage, ShowsFiguresOverParametersAndEnds) {
  const std::string page = pictures::page_of(example());
  EXPECT_NE(page.find("<h1>a&lt;b: samples of a design space</h1>"), std::string::npos);
  EXPECT_EQ(count(page, "<svg"), 3u) << "the figure over two parameters, and one parameter over the other";
  EXPECT_EQ(count(page, "sample 0, ok, first = 0.1, second = 1"), 3u);
  EXPECT_EQ(count(page, "sample 1, fold, first = 0.2, second = 2"), 3u);
  EXPECT_EQ(count(page, "sample 3, not_assembled, first = 0.4, second = 4"), 1u) << "it has no figures";
  EXPECT_EQ(page.find("http:"), page.find("http://www.w3.org")) << "loads nothing";
}

TEST(SweepPage, ShowsTheBestInMotion) {
  pictures::SweepPage page = example();
  EXPECT_NE(pictures::page_of(page).find("src=\"data:image/svg+xml;base64,TWFu\""), std::string::npos);
  page.motions[0] = "Ma";
  EXPECT_NE(pictures::page_of(page).find("base64,TWE=\""), std::string::npos);
  page.motions[0] = "M";
  EXPECT_NE(pictures::page_of(page).find("base64,TQ==\""), std::string::npos);
  page.motions[0] = "";
  EXPECT_EQ(count(pictures::page_of(page), "<img"), 0u);
  page.best.clear();
  page.motions.clear();
  EXPECT_EQ(count(pictures::page_of(page), "The best"), 0u);
}

}  // namespace
}  // namespace assur::test
