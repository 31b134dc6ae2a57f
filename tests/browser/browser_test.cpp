// The harness itself: what it finds wrong, and that it sees what a reader sees.
#include <gtest/gtest.h>

#include "browser/browser.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

class BrowserTest : public testing::Test {
 protected:
  void SetUp() override {
    if (Browser::program().empty()) GTEST_SKIP() << "no chromium: Debian's package chromium";
  }
  std::string page(const std::string& body) {
    return scratch_.file("page.html", "<!DOCTYPE html><html><body>" + body + "</body></html>");
  }
  Scratch scratch_;
};

TEST_F(BrowserTest, EveryKindOfFaultIsSeen) {
  Browser browser;
  browser.open(page("<p>nothing wrong</p><script>console.log('fine')</script>"));
  EXPECT_EQ(browser.errors(), std::vector<std::string>());
  for (const std::string fault :
       {"<script>console.error('a fault')</script>", "<script>throw new Error('a fault')</script>",
        "<script>Promise.reject(new Error('a fault'))</script>", "<img src='a_fault.png'>"}) {
    browser.open(page(fault));
    (void)browser.evaluate("await new Promise(r => setTimeout(r, 50))");
    ASSERT_GE(browser.errors().size(), 1u) << fault;
    EXPECT_NE(browser.errors()[0].find(fault.find("img") == 1 ? "a_fault" : "a fault"), std::string::npos);
  }
}

TEST_F(BrowserTest, TheWindowIsAsWideAndAsDarkAsAskedFor) {
  Browser browser;
  for (const int width : {390, 1280}) {
    for (const bool dark : {false, true}) {
      browser.open(page("<meta name='viewport' content='width=device-width'>"), {.width = width, .dark = dark});
      EXPECT_EQ(browser.evaluate("return innerWidth"), width);
      EXPECT_EQ(browser.evaluate("return matchMedia('(prefers-color-scheme: dark)').matches"), dark);
    }
  }
}

TEST_F(BrowserTest, MouseFingersAndKeysArrive) {
  Browser browser;
  const std::string script =
      "<script>const got = []; for (const type of ['pointerdown', 'pointermove', 'pointerup', 'wheel', 'keydown'])"
      " addEventListener(type, e => got.push([type, e.key ?? e.pointerId]));</script><style>body "
      "{touch-action: none}</style>";
  browser.open(page(script));
  browser.drag(100, 100, 200, 150);
  browser.wheel(100, 100, 120);
  browser.press("ArrowRight");
  const auto got = browser.evaluate(
      "await new Promise(r => setTimeout(r, 50));"
      "return Object.fromEntries(['pointerdown', 'pointermove', 'pointerup', 'wheel', 'keydown'].map("
      "t => [t, got.filter(g => g[0] === t).length]))");
  EXPECT_EQ(got["pointerdown"], 1);
  EXPECT_GE(got["pointermove"], 2);
  EXPECT_EQ(got["pointerup"], 1);
  EXPECT_EQ(got["wheel"], 1);
  EXPECT_EQ(got["keydown"], 1);
  browser.open(page(script), {.width = 390, .height = 800, .touch = true});
  browser.pinch(200, 300, 50, 150);
  EXPECT_EQ(browser.evaluate("return new Set(got.filter(g => g[0] === 'pointerdown').map(g => g[1])).size"), 2);
}

}  // namespace
}  // namespace assur
