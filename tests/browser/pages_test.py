"""Tests of the pages of assur in a headless Chromium: windows of several sizes, light and dark, mouse, touch and keys.

    pages_test.py ASSUR [TestClass[.test]]...

Exit status 77: skipped, because the named program or package is missing.
"""
import json
import math
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.action_builder import ActionBuilder
    from selenium.webdriver.common.actions.interaction import POINTER_TOUCH
    from selenium.webdriver.common.actions.pointer_input import PointerInput
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
    from selenium.webdriver.common.keys import Keys
except ImportError:
    webdriver = None

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
ASSUR = ""  # path of the program `assur`

# Helpers of the tests, for all pages.
HELPERS = """
window.settled = () => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
window.seek = async k => {
  const slider = document.getElementById('frame');
  slider.value = k;
  slider.dispatchEvent(new Event('input'));
  await settled();
};
window.canvases = () => [document.getElementById('picture'), ...document.querySelectorAll('#panels canvas')];
window.pixels = canvas => canvas.toDataURL();
window.data = canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
window.isEmpty = canvas => data(canvas).every(v => v === 0);

// Text that is cut off or runs out of the window, beyond boxes that scroll by themselves.
window.misfits = () => {
  const wide = document.documentElement.clientWidth, page = document.documentElement.scrollWidth;
  const cut = [...document.querySelectorAll('p, li, dd, dt, h1, h2, h3, h4, summary, figure, .scroll')].filter(e => {
    const r = e.getBoundingClientRect();
    return r.width > 0 && (r.right > wide + 0.5 || r.left < -0.5);
  });
  return [...(page > wide ? [`the page is ${page} wide`] : []),
          ...cut.map(e => `${e.tagName}: ${e.textContent.slice(0, 40)}`)];
};
// Tables that are wider than their room.
window.cutTables = () => {
  document.querySelectorAll('details').forEach(d => d.open = true);
  return [...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth)
      .map(e => `${e.scrollWidth} over ${e.clientWidth}: ${e.textContent.slice(0, 40)}`);
};
"""


class Pages(unittest.TestCase):
    url = "about:blank"  # of the open page

    @classmethod
    def setUpClass(cls):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        # No sandbox, because tests also run as root and in containers; all pages are trusted.
        for flag in ("headless=new", "no-sandbox", "disable-gpu", "disable-dev-shm-usage", "disable-extensions",
                     "disable-background-networking", "hide-scrollbars", "force-device-scale-factor=1"):
            options.add_argument("--" + flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        cls.driver = webdriver.Chrome(service=Service(DRIVER), options=options)
        cls.addClassCleanup(cls.driver.quit)
        folder = tempfile.TemporaryDirectory(prefix="assur-pages-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)

    def assur(self, *arguments, statuses=(0,)):
        done = subprocess.run([ASSUR, *arguments, "--quiet"], capture_output=True, text=True, check=False)
        self.assertIn(done.returncode, statuses, done.stderr)

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")
        return self.folder / name

    def open(self, page, width=1280, height=900, dark=False, touch=False):
        """Shows a page in a window of this size, CSS pixels."""
        tell = self.driver.execute_cdp_cmd
        tell("Emulation.setDeviceMetricsOverride",
             {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": touch})
        tell("Emulation.setTouchEmulationEnabled", {"enabled": touch, "maxTouchPoints": 2})
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        tell("Emulation.setEmulatedMedia", {"features": [scheme]})
        self.driver.get("about:blank")
        self.faults()  # discards faults of the previous page
        self.url = page.absolute().as_uri()
        self.driver.get(self.url)
        self.js(HELPERS)
        seen = self.js("return [innerWidth, matchMedia('(prefers-color-scheme: dark)').matches]")
        self.assertEqual(seen, [width, dark])

    def js(self, body):
        """Result of an async function with this body."""
        return self.driver.execute_script(f"return (async () => {{{body}\n}})()")

    def faults(self):
        """New console errors, exceptions, warnings of the browser, and requests for other files."""
        said = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]
        for entry in self.driver.get_log("performance"):
            event = json.loads(entry["message"])["message"]
            if event["method"] == "Network.requestWillBeSent":
                url = event["params"]["request"]["url"]
                if url not in (self.url, "about:blank") and not url.startswith(("data:", "blob:")):
                    said.append("asks for " + url)
        return said

    # Gestures with the mouse, in client coordinates.
    def move(self, x, y):
        mouse = ActionBuilder(self.driver, duration=0)
        mouse.pointer_action.move_to_location(x, y)
        mouse.perform()

    def drag(self, x, y, right, down):
        mouse = ActionBuilder(self.driver, duration=0)
        mouse.pointer_action.move_to_location(x, y).pointer_down()
        for i in range(1, 6):
            mouse.pointer_action.move_to_location(round(x + right * i / 5), round(y + down * i / 5))
        mouse.pointer_action.pointer_up()
        mouse.perform()

    def wheel(self, x, y, down):
        ActionChains(self.driver, duration=0).scroll_from_origin(ScrollOrigin.from_viewport(x, y), 0, down).perform()

    def press(self, key):
        ActionChains(self.driver).send_keys(key).perform()

    def pinch(self, x, y, start, end):
        """Two fingers on a horizontal line around (x, y), from one distance to another."""
        hand = ActionBuilder(self.driver, duration=0)
        for side in (-1, 1):
            finger = hand.add_pointer_input(POINTER_TOUCH, f"finger{side}")
            for i in range(6):
                finger.create_pointer_move(0, round(x + side * (start + (end - start) * i / 5) / 2), y)
                if i == 0:
                    finger.create_pointer_down()
            finger.create_pointer_up(0)
        hand.perform()


class Faults(Pages):
    """Without this, pages with faults could pass."""

    def test_every_kind_is_seen(self):
        def page(body):
            self.open(self.write("page.html", f"<!DOCTYPE html><html><body>{body}</body></html>"))
            self.js("await new Promise(r => setTimeout(r, 50))")
            return self.faults()

        self.assertEqual(page("<p>nothing wrong</p><script>console.log('fine')</script>"), [])
        for fault in ("<script>console.error('a_fault')</script>", "<script>console.assert(false, 'a_fault')</script>",
                      "<script>throw new Error('a_fault')</script>",
                      "<script>Promise.reject(new Error('a_fault'))</script>", "<img src='a_fault.png'>",
                      "<script>fetch('https://a_fault.invalid').catch(() => 0)</script>"):
            self.assertIn("a_fault", "".join(page(fault)), fault)


class Animation(Pages):
    """The page of `assur run --animate`."""

    def show(self, scene, *more, **window):
        """The page of a scene, paused at its first frame."""
        page = self.folder / "motion.html"
        self.assur("run", str(scene), "--animate", str(page), *more, statuses=(0, 1))  # status 1: the motion ends early
        self.open(page, **window)
        self.js("const play = document.getElementById('play');"
                "if (play.getAttribute('aria-label') === 'Pause') play.click();"
                "await seek(0)")

    def picture(self):
        return self.js("await settled(); return pixels(document.getElementById('picture'))")

    def clock(self):
        return self.js("await settled(); return document.getElementById('clock').textContent")

    def tearDown(self):
        self.assertEqual(self.faults(), [])

    def test_the_slider_moves_the_picture_and_every_cursor(self):
        self.show("stewart", "--outputs", "handle1,P1")
        before, after, back = self.js("""
            const all = () => canvases().map(pixels), before = all();
            await seek(300);
            const after = all();
            await seek(0);
            return [before, after, all()]""")
        self.assertEqual(len(before), 1 + 3)  # handle1 and its two derivatives
        for one, other in zip(before, after):
            self.assertNotEqual(one, other)
        self.assertEqual(back, before)
        self.assertEqual(self.clock(), "t = 0.00 s")

    def test_buttons_and_keys_step(self):
        self.show("four_bar")
        self.assertEqual(self.clock(), "t = 0.000 s")
        self.js("document.getElementById('forward').click(); document.activeElement.blur()")
        self.assertEqual(self.clock(), "t = 0.001 s")
        for key, time in ((Keys.ARROW_RIGHT, "0.002"), (Keys.ARROW_LEFT, "0.001"), (Keys.END, "1.000"),
                          (Keys.HOME, "0.000")):
            self.press(key)
            self.assertEqual(self.clock(), f"t = {time} s")
        self.press(" ")
        self.js("await new Promise(r => setTimeout(r, 300))")
        self.press(" ")
        self.assertNotEqual(self.clock(), "t = 0.000 s")

    def test_mouse_and_keys_turn_move_and_zoom(self):
        """Every gesture changes the picture, and Fit undoes moves and zooms."""
        for scene in ("stewart", "four_bar"):
            self.show(scene)
            x, y = self.js("const r = document.getElementById('picture').getBoundingClientRect();"
                           "return [r.x + r.width / 2, r.y + r.height / 2].map(Math.round)")
            self.move(x, 5)
            seen = {self.picture()}

            def is_new(gesture):
                now = self.picture()
                self.assertNotIn(now, seen, f"{scene}: {gesture}")
                seen.add(now)

            self.drag(x, y, 80, 40)
            self.move(x, 5)
            is_new("drag")
            self.wheel(x, y, -200)
            is_new("wheel")
            for key in ("+", "a") if scene == "stewart" else ("+",):
                self.press(key)
                is_new(key)
            self.press("0")
            fitted = self.picture()
            self.wheel(x, y, -200)
            self.assertNotEqual(self.picture(), fitted)
            self.press("0")
            self.assertEqual(self.picture(), fitted)

    def test_is_never_empty_while_the_window_changes_its_size(self):
        """Setting the size of a canvas clears it. The test examines the screen after the frame in which the size
        changed, before the next frame."""
        self.show("stewart", "--outputs", "handle1")
        empty = self.js("""
            const seen = [];
            for (let k = 0; k < 5; ++k) {
              await new Promise(shown => requestAnimationFrame(() => {
                document.body.style.width = `${900 - 40 * k}px`;
                const {port1, port2} = new MessageChannel();
                port1.onmessage = shown;
                port2.postMessage('painted');
              }));
              seen.push(canvases().map(isEmpty));
            }
            return seen""")
        self.assertEqual(empty, [[False] * 4] * 5)

    def test_is_there_before_the_first_frame(self):
        """Background tabs, and browsers that only take a screenshot, request no frames."""
        page = self.folder / "motion.html"
        self.assur("run", "stewart", "--outputs", "handle1", "--animate", str(page))
        self.open(self.write("still.html", page.read_text(encoding="utf-8").replace(
            "<head>", "<head><script>window.requestAnimationFrame = () => 0</script>", 1)))
        self.assertEqual(self.js("return canvases().map(isEmpty)"), [False] * 4)

    def test_two_fingers_zoom_on_a_telephone(self):
        self.show("stewart", width=390, height=844, touch=True)
        before = self.picture()
        self.pinch(195, 300, 60, 180)
        self.assertNotEqual(self.picture(), before)

    def test_fits_every_window_in_light_and_dark(self):
        backgrounds = set()
        for scene in ("bricard", "rings:legs=6,n=30,steps=50"):
            for width in (390, 1280):
                for dark in (False, True):
                    self.show(scene, width=width, height=844, dark=dark)
                    seen = self.js("""
                        await settled();
                        const canvas = document.getElementById('picture');
                        let painted = 0;
                        data(canvas).forEach((v, i) => painted += i % 4 === 3 && v > 100);
                        const texts = [...document.querySelectorAll(
                            'p, label, button, select, output, figcaption, li')].filter(e => e.offsetParent);
                        return {overflow: document.documentElement.scrollWidth - innerWidth, painted: painted,
                                stage: [canvas.clientWidth, canvas.clientHeight],
                                smallest: Math.min(...texts.map(e => parseFloat(getComputedStyle(e).fontSize))),
                                background: getComputedStyle(document.body).backgroundColor}""")
                    with self.subTest(scene=scene, width=width, dark=dark):
                        self.assertLessEqual(seen["overflow"], 0)
                        self.assertGreater(seen["painted"], 500)
                        self.assertGreaterEqual(seen["stage"][0], min(width * 8 // 10, 1000))
                        self.assertGreaterEqual(seen["stage"][1], 300)
                        self.assertGreaterEqual(seen["smallest"], 13)
                        self.assertEqual(self.faults(), [])
                    backgrounds.add(seen["background"])
        self.assertEqual(len(backgrounds), 2)

    def test_colours_names_paths_and_outputs_can_be_chosen(self):
        self.show("stewart")
        seen = self.js("""
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
            return {fresh: fresh, levels: levels, before: before, after: titles()}""")
        for name in ("colour", "names", "paths"):
            self.assertTrue(seen["fresh"][name], name)
        self.assertEqual(seen["levels"], 2)
        self.assertEqual(seen["before"][0], "handle1, rad")
        self.assertEqual(seen["after"], ["B3, m", "B3, velocity, m/s", "B3, acceleration, m/s²"])

    def test_whoever_the_pointer_rests_on_is_named(self):
        self.show("stewart")
        # The projection of the page gives the position of B1.
        x, y = self.js("""
            const canvas = document.getElementById('picture'), box = canvas.getBoundingClientRect();
            const camera = new Camera(motion.box(allRails()), motion.dimension);
            camera.resize(canvas.clientWidth, canvas.clientHeight);
            const k = motion.points.findIndex(p => p.name === 'B1');
            const [x, y] = camera.project(motion.posture(0).subarray(3 * k, 3 * k + 3));
            return [box.x + x, box.y + y].map(Math.round)""")
        self.move(x, y)
        text = self.js("await settled(); return document.getElementById('about').innerText")
        place = re.match(r"B1 \((\S+), (\S+), (\S+)\) m", text)
        self.assertTrue(place, text)
        for seen, written in zip(place.groups(), (0.60590, -0.20646, 0.14220)):  # scenes/stewart.json, five decimals
            self.assertAlmostEqual(float(seen), written, delta=1e-5)
        self.assertIn("group SG_HS1, level 2", text)
        self.move(1, 1)
        self.assertTrue(self.js("await settled(); return document.getElementById('about').hidden"))

    def test_bodies_and_joints_are_drawn_and_named(self):
        """Sarrus' linkage: a colour for each body, hinges as symbols, names of joints and bodies at the pointer."""
        self.show("sarrus")
        x, y, colours, legend, symbols = self.js("""
            const canvas = document.getElementById('picture'), box = canvas.getBoundingClientRect();
            const camera = new Camera(motion.box(allRails()), motion.dimension);
            camera.resize(canvas.clientWidth, canvas.clientHeight);
            const place = name => {
              const k = motion.points.findIndex(p => p.name === name);
              return camera.project(motion.posture(0).subarray(3 * k, 3 * k + 3));
            };
            const [px, py] = place('knee_x'), pixel = new Set(), all = data(canvas);
            for (let i = 0; i < all.length; i += 4) if (all[i + 3] === 255) pixel.add(`${all.slice(i, i + 3)}`);
            const texts = id => [...document.querySelectorAll(`#${id} li`)].map(e => e.textContent);
            const drawn = [...document.querySelectorAll('#legend i')].map(e =>
                pixel.has(getComputedStyle(e).backgroundColor.match(/[0-9]+/g).join(',')));
            return [box.x + px, box.y + py, drawn, texts('legend'), texts('symbols')]""")
        self.assertEqual(legend, ["lower_x", "upper_x", "lower_y", "upper_y", "platform"])
        self.assertEqual(symbols, ["revolute joint", "driven joint"])
        self.assertEqual(colours, [True] * 5)
        self.move(round(x), round(y))
        text = self.js("await settled(); return document.getElementById('about').innerText")
        self.assertRegex(text, r"^knee_x \(.*\) m\nrevolute joint of lower_x and upper_x\n")

    def test_symbols_are_as_large_as_a_joint(self):
        """A symbol fills its place with the colour of the paper, on an outline of ink, in every window."""
        for scene, point in (("slider_crank", "B"), ("bennett", "B"), ("geared_five_bar", "C")):
            for width in (400, 1280):
                self.show(scene, width=width)
                with self.subTest(scene=scene, width=width):
                    size = self.js(f"""
                        document.getElementById('names').click();
                        await settled();
                        const canvas = document.getElementById('picture');
                        const camera = new Camera(motion.box(allRails()), motion.dimension);
                        camera.resize(canvas.clientWidth, canvas.clientHeight);
                        const k = motion.points.findIndex(p => p.name === '{point}');
                        const [x, y] = camera.project(motion.posture(0).subarray(3 * k, 3 * k + 3)).map(Math.round);
                        const all = canvas.getContext('2d').getImageData(x - 12, y - 12, 25, 25).data;
                        let paper = 0;
                        for (let i = 0; i < all.length; i += 4) paper += all[i + 3] === 255 && all[i] > 240 && all[i + 1] > 240;
                        return paper""")
                    self.assertGreaterEqual(size, 20)  # pixels

    def test_a_slider_and_its_rail_stay_in_the_picture(self):
        for width in (400, 1280):
            self.show("whitworth_joints", width=width)
            outside = self.js("""
                const canvas = document.getElementById('picture'), rails = allRails();
                const camera = new Camera(motion.box(rails), motion.dimension);
                camera.resize(canvas.clientWidth, canvas.clientHeight);
                let outside = 0;
                for (let frame = 0; frame < motion.frames; ++frame) {
                  for (const end of railEnds(rails[0], frame, motion.posture(frame))) {
                    const [x, y] = camera.project(end);
                    outside += x < 0 || y < 0 || x > canvas.clientWidth || y > canvas.clientHeight;
                  }
                }
                return [rails.length, outside]""")
            self.assertEqual(outside, [1, 0])

    def test_rods_keep_their_length_from_frame_to_frame(self):
        """The picture has the lengths of the scene: a rod has the same length in the first and the last frame."""
        self.show("stewart")
        lengths = self.js("""
            const l = motion.links.find(l => l[3] === 'rod_length1');
            return [0, 321, motion.frames - 1].map(frame => {
              const p = motion.posture(frame);
              return Math.hypot(...[0, 1, 2].map(k => p[3 * l[0] + k] - p[3 * l[1] + k]));
            })""")
        for length in lengths:
            self.assertAlmostEqual(length, 0.55, delta=1e-6)  # 24 bits of a range of 1.5 m, in three coordinates

    def test_a_single_posture_has_no_player_and_no_fault(self):
        self.show("gough")
        self.assertIsNone(self.js("return document.getElementById('player').offsetParent"))
        self.assertGreater(self.js("return document.getElementById('picture').clientHeight"), 200)

    def test_of_a_motion_that_ends_early_the_last_posture_is_shown(self):
        """The crank turns until coupler and rocker are in line: the page shows the last posture, the outputs end a step
        before."""
        self.show(self.write("fold.json", """{
            "assur": 1, "name": "fold", "dimension": 2,
            "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true},
                       "B": {"at": [1, 0]}, "C": {"at": [1.5, 0.8]}},
            "constraints": {"coupler": {"distance": ["B", "C"], "value": 1},
                            "rocker": {"distance": ["D", "C"], "value": 1}},
            "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}}},
            "outputs": ["C.velocity"], "time": {"start": 0, "end": 2, "step": 0.01}}"""))
        seen = self.js("""
            const last = motion.frames - 1;
            await seek(last);
            const p = motion.posture(last), [b, c] = ['B', 'C'].map(n => motion.points.findIndex(p => p.name === n));
            return {said: document.querySelector('.ended').textContent, t: motion.times[last],
                    x: p[3 * c] - (p[3 * b] + 2) / 2,
                    reading: document.querySelector('figcaption span').textContent}""")
        self.assertRegex(seen["said"], "^The motion ends early: t = 1.3181")
        self.assertAlmostEqual(seen["t"], math.acos(0.25), delta=1e-6)
        # C is halfway between B and D, up to the square root of the remaining time.
        self.assertAlmostEqual(seen["x"], 0, delta=1e-3)
        self.assertEqual(seen["reading"], "x –")

    def test_thousands_of_points_are_drawn_at_once(self):
        self.show("rings:legs=64,n=120,steps=20")
        before = self.picture()
        self.assertGreater(self.js("await seek(15); return motion.points.length"), 5000)
        self.assertNotEqual(self.picture(), before)


class Picture(Pages):
    """The SVG of `assur run --picture`."""

    def test_shows_the_whole_motion(self):
        """At every time, everything that is drawn lies in the picture, and something moves."""
        for scene in ("whitworth_joints", "jansen", "sarrus", "excavator", "stewart"):
            page = self.folder / "motion.svg"
            self.assur("run", scene, "--picture", str(page))
            svg = page.read_text(encoding="utf-8")
            self.open(self.write("picture.html", f"<!DOCTYPE html><html><head></head><body>{svg}</body></html>"))
            outside, places = self.js("""
                const svg = document.querySelector('svg'), {width, height} = svg.viewBox.baseVal;
                svg.pauseAnimations();
                let outside = 0;
                const places = new Set();
                for (let k = 0; k < 40; ++k) {
                  svg.setCurrentTime(k * 0.2);
                  const box = svg.getBBox();
                  outside += box.x < 0 || box.y < 0 || box.x + box.width > width || box.y + box.height > height;
                  places.add([...svg.querySelectorAll('polyline, polygon, g')].map(e => {
                    const b = e.getBoundingClientRect();
                    return `${b.x} ${b.y}`;
                  }).join());
                }
                return [outside, places.size]""")
            with self.subTest(scene=scene):
                self.assertEqual(outside, 0)
                self.assertGreater(places, 10)
                self.assertEqual(self.faults(), [])


class Report(Pages):
    """The page of `assur report`."""

    def test_is_legible_in_every_window(self):
        self.assur("report", "--quick", "--budget", "2", "--out", str(self.folder / "report"))
        for width in (1920, 1280, 390):
            for dark in (False, True):
                self.open(self.folder / "report" / "index.html", width=width, dark=dark)
                with self.subTest(width=width, dark=dark):
                    self.check_page(width)
        # All details can be opened, and every entry of the contents has a target.
        self.assertEqual(self.js("return [...document.querySelectorAll('nav a')]"
                                 ".filter(a => !document.querySelector(a.hash)).map(a => a.hash)"), [])
        self.js("for (const d of document.querySelectorAll('details')) d.open = true")
        self.assertEqual(self.js("return misfits()"), [])

    def check_page(self, width):
        self.assertEqual(self.js("return misfits()"), [])
        if width >= 1280:  # only narrow windows scroll tables
            self.assertEqual(self.js("return cutTables()"), [])
        # One of the two sizes of every picture is shown, and it is as wide as its figure.
        figures = self.js("""
            const width = e => e.getBoundingClientRect().width;
            return [...document.querySelectorAll('figure')].map(f => {
              const shown = [...f.querySelectorAll('svg.plot:not(.key)')].filter(s => width(s) > 0);
              return [shown.length, shown.length && width(shown[0]) / width(f)];
            })""")
        self.assertGreaterEqual(len(figures), 6)
        for shown, filled in figures:
            self.assertEqual(shown, 1)
            self.assertGreater(filled, 0.99)
        for section in ("winners", "regret", "work-precision", "scaling", "steps"):
            self.assertTrue(self.js(f"return document.querySelector('#{section} svg.plot, #{section} table') !== null"),
                            section)
        # WCAG AA requires a contrast of 4.5 between small text and its background.
        contrast = self.js("""
            const light = c => { const v = c.match(/[0-9.]+/g).slice(0, 3).map(x => { x /= 255;
              return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4 });
              return 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2] };
            const paper = light(getComputedStyle(document.body).backgroundColor);
            return Math.min(...['p', 'p.faint', 'td', 'summary'].map(s => {
              const ink = light(getComputedStyle(document.querySelector(s)).color);
              return (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05) }))""")
        self.assertGreaterEqual(contrast, 4.5)
        self.assertEqual(self.faults(), [])


class Comparison(Pages):
    """The page of `assur compare --html`."""

    def test_is_legible_in_every_window(self):
        """Labels of a front with many similar strategies do not overlap."""
        page = self.folder / "compare.html"
        self.assur("compare", "stewart", "--steps", "20", "--accuracy", "1e-4,1e-8,1e-12", "--html", str(page),
                   "--strategies",
                   "irreducible/lanes:8+float+once+predict=hermite:5,"
                   "irreducible/lanes:8+refine+reuse=step+predict=past:5,"
                   "irreducible/lanes:8+predict=past:3,irreducible/lanes:4,groups/lanes:8,groups/lanes:4,groups/eigen")
        for width in (1920, 1280, 390):
            self.open(page, width=width)
            with self.subTest(width=width):
                self.assertEqual(self.js("return misfits()"), [])
                if width >= 1280:
                    self.assertEqual(self.js("return cutTables()"), [])
                self.assertEqual(self.js("""
                    const boxes = [...document.querySelectorAll('.label')].map(e => e.getBoundingClientRect())
                        .filter(b => b.width > 0);
                    const overlap = (a, b) =>
                        a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
                    return boxes.flatMap((a, i) => boxes.slice(0, i).filter(b => overlap(a, b)))
                        .map(b => `${b.left} ${b.top}`)"""), [])
                self.assertEqual(self.faults(), [])


if __name__ == "__main__":
    lacking = [what for what, found in (("chromium", CHROMIUM), ("chromium-driver", DRIVER),
                                        ("python3-selenium", webdriver)) if not found]
    if lacking:
        print("skipped: pages are tested with Debian's packages " + ", ".join(lacking))
        sys.exit(77)
    ASSUR = sys.argv.pop(1)
    unittest.main(verbosity=2)
