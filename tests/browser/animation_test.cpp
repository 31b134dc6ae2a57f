// The page of `assur run --animate` in the hands of a reader.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "browser/browser.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

using Json = nlohmann::json;

class AnimationPage : public testing::Test {
 protected:
  void SetUp() override {
    if (Browser::program().empty()) GTEST_SKIP() << "no chromium: Debian's package chromium";
    browser_.emplace();
  }

  // The page of a scene, paused at its first frame.
  void open(const std::string& scene, const Window& window = {}, const std::vector<std::string>& more = {}) {
    const std::string file = scratch_.file("motion.html");
    std::vector<std::string> call = {"run", scene, "--quiet", "--animate", file};
    call.insert(call.end(), more.begin(), more.end());
    ASSERT_NE(run_command(call).status, 2);
    open_file(file, window);
  }
  void open_file(const std::string& file, const Window& window = {}) {
    browser_->open(file, window);
    (void)browser_->evaluate(R"(
      window.settled = () => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
      window.pixels = canvas => canvas.toDataURL();
      const play = document.getElementById('play');
      if (play.getAttribute('aria-label') === 'Pause') play.click();
      await seek(0);
      async function seek(k) {
        const slider = document.getElementById('frame');
        slider.value = k;
        slider.dispatchEvent(new Event('input'));
        await settled();
      }
      window.seek = seek)");
  }

  std::string picture() {
    return browser_->evaluate("await settled(); return pixels(document.getElementById('picture'))");
  }
  std::string clock() {
    return browser_->evaluate("await settled(); return document.getElementById('clock').textContent");
  }
  void expect_no_errors() { EXPECT_EQ(browser_->errors(), std::vector<std::string>()); }

  Scratch scratch_;
  std::optional<Browser> browser_;
};

TEST_F(AnimationPage, TheSliderMovesThePictureAndEveryCursor) {
  open("stewart", {}, {"--outputs", "handle1,P1"});
  const Json seen = browser_->evaluate(R"(
    const all = () => [document.getElementById('picture'), ...document.querySelectorAll('#panels canvas')].map(pixels);
    const before = all();
    await seek(300);
    const after = all();
    await seek(0);
    const back = all();
    return {count: before.length, moved: before.map((b, i) => b !== after[i]), back: before.map((b, i) => b === back[i])})");
  EXPECT_EQ(seen["count"], 1 + 3);  // handle1 and its two derivatives
  for (const auto& moved : seen["moved"]) EXPECT_TRUE(moved);
  for (const auto& back : seen["back"]) EXPECT_TRUE(back);
  EXPECT_EQ(clock(), "t = 0.00 s");
  expect_no_errors();
}

TEST_F(AnimationPage, ButtonsAndKeysStep) {
  open("four_bar");
  EXPECT_EQ(clock(), "t = 0.000 s");
  (void)browser_->evaluate("document.getElementById('forward').click(); document.activeElement.blur()");
  EXPECT_EQ(clock(), "t = 0.001 s");
  browser_->press("ArrowRight");
  EXPECT_EQ(clock(), "t = 0.002 s");
  browser_->press("ArrowLeft");
  EXPECT_EQ(clock(), "t = 0.001 s");
  browser_->press("End");
  EXPECT_EQ(clock(), "t = 1.000 s");
  browser_->press("Home");
  EXPECT_EQ(clock(), "t = 0.000 s");
  browser_->press(" ");
  (void)browser_->evaluate("await new Promise(r => setTimeout(r, 300))");
  browser_->press(" ");
  EXPECT_NE(clock(), "t = 0.000 s");
  expect_no_errors();
}

// Every gesture changes the picture, and Fit takes back what moved or zoomed.
TEST_F(AnimationPage, MouseAndKeysTurnMoveAndZoom) {
  for (const std::string scene : {"stewart", "four_bar"}) {
    open(scene);
    const Json at = browser_->evaluate(
        "const r = document.getElementById('picture').getBoundingClientRect(); return [r.x + r.width / 2, r.y + "
        "r.height / 2]");
    const double x = at[0], y = at[1];
    browser_->move(x, 5);
    std::set<std::string> seen = {picture()};
    const auto is_new = [&] { return seen.insert(picture()).second; };
    browser_->drag(x, y, x + 80, y + 40);
    browser_->move(x, 5);
    EXPECT_TRUE(is_new()) << "drag";
    browser_->wheel(x, y, -200);
    EXPECT_TRUE(is_new()) << "wheel";
    browser_->press("+");
    EXPECT_TRUE(is_new()) << "+";
    if (scene == "stewart") {
      browser_->press("a");
      EXPECT_TRUE(is_new()) << "a";
    }
    browser_->press("0");
    const std::string fitted = picture();
    browser_->wheel(x, y, -200);
    browser_->press("0");
    EXPECT_EQ(picture(), fitted);
    expect_no_errors();
  }
}

// To set the size of a canvas empties it. What is looked at is what the screen shows: after the frame in which the size
// changed, before the next one.
TEST_F(AnimationPage, IsNeverEmptyWhileTheWindowChangesItsSize) {
  open("stewart", {}, {"--outputs", "handle1"});
  const Json empty = browser_->evaluate(R"(
    const isEmpty = canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.every(v => v === 0);
    const seen = [];
    for (let k = 0; k < 5; ++k) {
      await new Promise(shown => requestAnimationFrame(() => {
        document.body.style.width = `${900 - 40 * k}px`;
        const {port1, port2} = new MessageChannel();
        port1.onmessage = shown;
        port2.postMessage('painted');
      }));
      seen.push([document.getElementById('picture'), ...document.querySelectorAll('#panels canvas')].map(isEmpty));
    }
    return seen)");
  ASSERT_EQ(empty.size(), 5u);
  for (const auto& canvases : empty) EXPECT_EQ(canvases, Json::parse("[false, false, false, false]"));
  expect_no_errors();
}

// Tabs in the background, and browsers that only take a picture, call no frames.
TEST_F(AnimationPage, IsThereBeforeTheFirstFrame) {
  const std::string file = scratch_.file("motion.html");
  ASSERT_EQ(run_command({"run", "stewart", "--outputs", "handle1", "--quiet", "--animate", file}).status, 0);
  std::string page = content(file);
  page.insert(page.find("<head>") + 6, "<script>window.requestAnimationFrame = () => 0</script>");
  browser_->open(scratch_.file("still.html", page));
  EXPECT_EQ(browser_->evaluate(R"(
    const isEmpty = canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.every(v => v === 0);
    return [document.getElementById('picture'), ...document.querySelectorAll('#panels canvas')].map(isEmpty))"),
            Json::parse("[false, false, false, false]"));
  expect_no_errors();
}

TEST_F(AnimationPage, TwoFingersZoomOnATelephone) {
  open("stewart", {.width = 390, .height = 844, .touch = true});
  const std::string before = picture();
  browser_->pinch(195, 300, 60, 180);
  EXPECT_NE(picture(), before);
  expect_no_errors();
}

TEST_F(AnimationPage, ItFitsEveryWindowInLightAndDark) {
  std::set<std::string> backgrounds;
  for (const std::string scene : {"bricard", "rings:legs=6,n=30,steps=50"}) {
    for (const int width : {390, 1280}) {
      for (const bool dark : {false, true}) {
        open(scene, {.width = width, .height = 844, .dark = dark});
        const Json seen = browser_->evaluate(R"(
          await settled();
          const canvas = document.getElementById('picture');
          const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
          let painted = 0;
          for (let i = 3; i < data.length; i += 4) painted += data[i] > 100;
          const sizes = [...document.querySelectorAll('p, label, button, select, output, figcaption, li')]
            .filter(e => e.offsetParent).map(e => parseFloat(getComputedStyle(e).fontSize));
          return {overflow: document.documentElement.scrollWidth - innerWidth, painted: painted,
                  stage: [canvas.clientWidth, canvas.clientHeight], smallest: Math.min(...sizes),
                  background: getComputedStyle(document.body).backgroundColor};)");
        EXPECT_LE(seen["overflow"], 0) << scene << " " << width;
        EXPECT_GT(seen["painted"], 500) << scene << " " << width;
        EXPECT_GE(seen["stage"][0], width * 8 / 10 < 1100 ? width * 8 / 10 : 1000);
        EXPECT_GE(seen["stage"][1], 300);
        EXPECT_GE(seen["smallest"], 13);
        backgrounds.insert(seen["background"]);
        expect_no_errors();
      }
    }
  }
  EXPECT_EQ(backgrounds.size(), 2u);
}

TEST_F(AnimationPage, ColoursNamesPathsAndOutputsCanBeChosen) {
  open("stewart");
  const Json seen = browser_->evaluate(R"(
    const canvas = document.getElementById('picture'), seen = new Set([pixels(canvas)]), fresh = {};
    const change = async (id, act) => {
      const element = document.getElementById(id);
      act(element);
      element.dispatchEvent(new Event('change'));
      await settled();
      const now = pixels(canvas);
      fresh[id] = !seen.has(now);
      seen.add(now);
    };
    await change('colour', e => e.value = 'level');
    const levels = document.querySelectorAll('#legend li').length;
    await change('names', e => e.checked = !e.checked);
    await change('paths', e => e.checked = !e.checked);
    const titles = () => [...document.querySelectorAll('figcaption')].map(e => e.firstChild.textContent);
    const before = titles();
    await change('output', e => e.value = 'B3');
    return {fresh: fresh, levels: levels, before: before, after: titles()})");
  for (const char* id : {"colour", "names", "paths"}) EXPECT_TRUE(seen["fresh"][id]) << id;
  EXPECT_EQ(seen["levels"], 2);
  EXPECT_EQ(seen["before"][0], "handle1, rad");
  EXPECT_EQ(seen["after"], Json::parse(R"(["B3, m", "B3, velocity, m/s", "B3, acceleration, m/s²"])"));
  expect_no_errors();
}

TEST_F(AnimationPage, WhoeverThePointerRestsOnIsNamed) {
  open("stewart");
  // The page's own projection says where B1 is.
  const Json at = browser_->evaluate(R"(
    const canvas = document.getElementById('picture'), box = canvas.getBoundingClientRect();
    const camera = new Camera(motion.box(), motion.dimension);
    camera.resize(canvas.clientWidth, canvas.clientHeight);
    const k = motion.points.findIndex(p => p.name === 'B1'), place = motion.posture(0).subarray(3 * k, 3 * k + 3);
    const [x, y] = camera.project(place);
    return [box.x + x, box.y + y])");
  browser_->move(at[0], at[1]);
  const std::string text = browser_->evaluate("await settled(); return document.getElementById('about').innerText");
  double place[3] = {};
  ASSERT_EQ(std::sscanf(text.c_str(), "B1 (%lf, %lf, %lf) m", &place[0], &place[1], &place[2]), 3) << text;
  const double written[3] = {0.60590, -0.20646, 0.14220};  // in scenes/stewart.json, with five decimals
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(place[k], written[k], 1e-5);
  EXPECT_NE(text.find("group SG_HS1, level 2"), std::string::npos) << text;
  browser_->move(1, 1);
  EXPECT_TRUE(browser_->evaluate("await settled(); return document.getElementById('about').hidden"));
  expect_no_errors();
}

// What is drawn are the lengths of the scene: a rod is as long in the last frame as in the first.
TEST_F(AnimationPage, RodsKeepTheirLengthFromFrameToFrame) {
  open("stewart");
  const Json lengths = browser_->evaluate(R"(
    const l = motion.links.find(l => l[3] === 'rod_length1');
    return [0, 321, motion.frames - 1].map(frame => {
      const p = motion.posture(frame);
      return Math.hypot(...[0, 1, 2].map(k => p[3 * l[0] + k] - p[3 * l[1] + k]));
    }))");
  for (const double length : lengths) EXPECT_NEAR(length, 0.55, 1e-6);  // 24 bits over 1.5 m, in three coordinates
  expect_no_errors();
}

TEST_F(AnimationPage, ASinglePostureHasNoPlayerAndNoFault) {
  open("gough");
  EXPECT_EQ(browser_->evaluate("return document.getElementById('player').offsetParent"), nullptr);
  EXPECT_TRUE(browser_->evaluate("return document.getElementById('picture').clientHeight > 200"));
  expect_no_errors();
}

// The crank turns until coupler and rocker are in line: the last posture is there, the outputs end a step before.
TEST_F(AnimationPage, OfAMotionThatEndsEarlyTheLastPostureIsShown) {
  const std::string scene = scratch_.file("fold.json", R"({
    "assur": 1, "name": "fold", "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true},
               "B": {"at": [1, 0]}, "C": {"at": [1.5, 0.8]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": 1}, "rocker": {"distance": ["D", "C"], "value": 1}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}}},
    "outputs": ["C.velocity"], "time": {"start": 0, "end": 2, "step": 0.01}})");
  open(scene);
  const Json seen = browser_->evaluate(R"(
    await seek(motion.frames - 1);
    const p = motion.posture(motion.frames - 1), [b, c] = ['B', 'C'].map(n => motion.points.findIndex(p => p.name === n));
    return {said: document.querySelector('.ended').textContent, t: motion.times[motion.frames - 1],
            x: p[3 * c] - (p[3 * b] + 2) / 2, reading: document.querySelector('figcaption span').textContent})");
  EXPECT_EQ(seen["said"].get<std::string>().find("The motion ends early: t = 1.3181"), 0u);
  EXPECT_NEAR(seen["t"], std::acos(0.25), 1e-6);
  EXPECT_NEAR(seen["x"], 0, 1e-3);  // C is halfway between B and D, as near as the square root of the time left
  EXPECT_EQ(seen["reading"], "x –");
  expect_no_errors();
}

TEST_F(AnimationPage, ThousandsOfPointsAreDrawnAtOnce) {
  open("rings:legs=64,n=120,steps=20");
  const Json seen = browser_->evaluate(
      "const before = pixels(document.getElementById('picture')); await seek(15);"
      "return [motion.points.length, before !== pixels(document.getElementById('picture'))]");
  EXPECT_GT(seen[0], 5000);
  EXPECT_TRUE(seen[1]);
  expect_no_errors();
}

}  // namespace
}  // namespace assur
