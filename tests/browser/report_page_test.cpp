// The page of `assur report` as a browser shows it.
#include <gtest/gtest.h>

#include "browser/browser.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

// Text that is cut off or runs out of the window, beyond boxes that scroll by themselves.
constexpr const char* kMisfits = R"(
  const out = [];
  const wide = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > wide) out.push('the page is ' + document.documentElement.scrollWidth + ' wide');
  for (const e of document.querySelectorAll('p, li, dd, dt, h1, h2, h3, h4, summary, figure, .scroll')) {
    const r = e.getBoundingClientRect();
    if (r.width > 0 && (r.right > wide + 0.5 || r.left < -0.5)) out.push(e.tagName + ': ' + e.textContent.slice(0, 40));
  }
  return out)";

// Tables that are wider than their room.
constexpr const char* kCutTables = R"(
  document.querySelectorAll('details').forEach(d => d.open = true);
  return [...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth)
      .map(e => (e.closest('section') || document.body).id + ': ' + e.scrollWidth + ' over ' + e.clientWidth + ': ' + e.textContent.slice(0, 40)))";

TEST(ReportPage, IsLegibleInEveryWindow) {
  if (Browser::program().empty()) GTEST_SKIP() << "no chromium: Debian's package chromium";
  const Scratch scratch;
  const Outcome made = run_command({"report", "--quick", "--budget", "2", "--out", scratch.file("r"), "--quiet"});
  ASSERT_EQ(made.status, 0) << made.err;
  Browser browser;
  for (const int width : {1920, 1280, 390}) {
    for (const bool dark : {false, true}) {
      browser.open(scratch.file("r") + "/index.html", {.width = width, .dark = dark});
      EXPECT_EQ(browser.evaluate(kMisfits), nlohmann::json::array()) << width;
      if (width >= 1280) {  // on a narrow window tables scroll, here they are seen whole
        EXPECT_EQ(browser.evaluate(kCutTables), nlohmann::json::array()) << width;
      }
      // Of the two sizes of every picture one is shown, and it is as wide as its figure.
      const auto seen = browser.evaluate(R"(
        return [...document.querySelectorAll('figure')].map(f => {
          const shown = [...f.querySelectorAll('svg.plot:not(.key)')].filter(s => s.getBoundingClientRect().width > 0);
          return [shown.length, shown.length && shown[0].getBoundingClientRect().width / f.getBoundingClientRect().width]}))");
      ASSERT_GE(seen.size(), 6u);
      for (const auto& figure : seen) {
        EXPECT_EQ(figure[0], 1);
        EXPECT_GT(figure[1], 0.99);
      }
      for (const char* id : {"winners", "regret", "work-precision", "scaling", "steps"}) {
        EXPECT_GT(browser.evaluate("return document.getElementById('" + std::string(id) +
                                   "').querySelectorAll('svg.plot, table').length"),
                  0)
            << id;
      }
      // Ink on paper: the contrast of WCAG's AA for small text is 4.5.
      const double contrast = browser.evaluate(R"(
        const light = c => { const v = c.match(/[0-9.]+/g).slice(0, 3).map(x => { x /= 255;
          return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4 });
          return 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2] };
        const paper = light(getComputedStyle(document.body).backgroundColor);
        return Math.min(...['p', 'p.faint', 'td', 'summary'].map(s => {
          const ink = light(getComputedStyle(document.querySelector(s)).color);
          return (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05) })))");
      EXPECT_GE(contrast, 4.5) << width << (dark ? " dark" : " light");
      EXPECT_EQ(browser.errors(), std::vector<std::string>());
    }
  }
  // What a reader opens is there, and every entry of the contents leads somewhere.
  EXPECT_EQ(
      browser.evaluate("return [...document.querySelectorAll('nav a')].every(a => document.querySelector(a.hash))"),
      true);
  (void)browser.evaluate("for (const d of document.querySelectorAll('details')) d.open = true");
  EXPECT_EQ(browser.evaluate(kMisfits), nlohmann::json::array()) << "with all tables open";
}

// A front of many ways that are about equally fast and exact has its labels side by side.
TEST(ComparisonPage, IsLegibleInEveryWindow) {
  if (Browser::program().empty()) GTEST_SKIP() << "no chromium: Debian's package chromium";
  const Scratch scratch;
  const std::string file = scratch.file("compare.html");
  const Outcome made = run_command(
      {"compare", "stewart", "--steps", "20", "--accuracy", "1e-4,1e-8,1e-12", "--html", file, "--quiet",
       "--strategies",
       "irreducible/lanes:8+float+once+predict=hermite:5,irreducible/lanes:8+refine+reuse=step+predict=past:5,"
       "irreducible/lanes:8+predict=past:3,irreducible/lanes:4,groups/lanes:8,groups/lanes:4,groups/eigen"});
  ASSERT_EQ(made.status, 0) << made.err;
  Browser browser;
  for (const int width : {1920, 1280, 390}) {
    browser.open(file, {.width = width});
    EXPECT_EQ(browser.evaluate(kMisfits), nlohmann::json::array()) << width;
    if (width >= 1280) {
      EXPECT_EQ(browser.evaluate(kCutTables), nlohmann::json::array()) << width;
    }
    EXPECT_EQ(browser.evaluate(R"(
      const boxes = [...document.querySelectorAll('.label')].map(e => e.getBoundingClientRect()).filter(b => b.width > 0);
      const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
      return boxes.flatMap((a, i) => boxes.slice(0, i).filter(b => overlap(a, b)))
          .map(b => `${b.left} ${b.top}`))"),
              nlohmann::json::array())
        << width;
    EXPECT_EQ(browser.errors(), std::vector<std::string>());
  }
}

}  // namespace
}  // namespace assur
