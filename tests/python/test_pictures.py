"""Pages for notebooks, and plots."""

import builtins
import html
import re
import shutil
import time

import pytest

import assur


def page_in(notebook):
    return html.unescape(re.fullmatch(r'<iframe srcdoc="([^"]*)" [^>]*></iframe>', notebook)[1])


def frames(page):
    return re.search(r'"times":\[([^]]*)\]', page)[1].split(",")


def test_notebooks_show_the_mechanism(mechanism):
    motion = assur.run(mechanism, [0, 0.1, 0.3])
    for item, times in ((mechanism, 201), (assur.prepare(mechanism), 201), (motion, 3)):
        page = item.page()
        assert page.startswith("<!DOCTYPE html>") and "four_bar" in page and len(frames(page)) == times
        assert "http" not in re.sub(r"http://www\.w3\.org/\S+", "", page), "the page needs a network"
        shown = page_in(item._repr_html_())
        assert shown.replace(".stage { height: 380px; }</style>", "</style>") == page
    assert [float(t) for t in frames(motion.page())] == [0, 0.1, 0.3]
    assert len(frames(mechanism.with_time(0, 10, 0.001).page())) <= 502


def test_mechanisms_that_cannot_move_are_shown_as_far_as_possible(tmp_path, mechanism):
    apart = mechanism.with_values(rocker=0.2, coupler=0.3)
    assert "cannot be assembled" in page_in(apart._repr_html_())
    jams = mechanism.with_values(rocker=1.4, coupler=2.0)
    assert "The motion ends early" in page_in(jams._repr_html_())
    free = assur.SceneBuilder("free", 2).point("A", (0, 0), fixed=True).point("B", (1, 0)).distance("rod", "A", "B")
    text = free.time(0, 1, 0.1).build()._repr_html_()
    assert text.startswith("<pre>Scene(&#x27;free") and "undetermined" in text
    assur.prepare(mechanism).save(tmp_path / "plan")
    loaded = assur.load_plan(tmp_path / "plan")
    assert "no scene" in loaded._repr_html_()
    with pytest.raises(assur.InputError, match="no scene"):
        assur.run(loaded).page()


def test_pages_start_in_the_mode_of_the_plan(mechanism):
    def low_of_y(item):
        return float(re.findall(r'"places":{"low":\[[^,]*,([^,\]]*)', item.page())[0])

    other = assur.prepare(mechanism, modes={"C": 1})
    assert low_of_y(other) < -2 < low_of_y(assur.prepare(mechanism)) and low_of_y(assur.run(other)) < -2


def test_plots(mechanism, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    motion = assur.run(mechanism)
    assert motion.units["C.x"] == "m" and motion.units["C.ay"] == "m/s²"
    assert motion.units["rocker_angle.rate"] == "rad/s"
    figure = motion.plot()
    lengths, angle = figure.axes
    assert [line.get_label() for line in lengths.lines] == ["C.x", "C.y"] and lengths.get_ylabel() == "m"
    assert angle.get_ylabel() == "rocker_angle (rad)" and angle.get_xlabel() == "t (s)"
    assert (angle.lines[0].get_ydata() == motion["rocker_angle"]).all()
    assert (angle.lines[0].get_xdata() == motion.t).all()
    own = matplotlib.figure.Figure().subplots()
    assert motion.plot("C.vx", axes=own) is own.figure and own.get_ylabel() == "C.vx (m/s)"
    assert assur.plot(motion, ["C.x"]).axes[0].get_ylabel() == "C.x (m)"
    for columns, what in ((["C.x", "C.vx"], "one unit"), (["C.q"], "C.q"), ([], "column")):
        with pytest.raises(assur.InputError, match=what):
            motion.plot(columns, axes=own)
    matplotlib.pyplot.close("all")

    def without(name, *rest):
        if name.startswith("matplotlib"):
            raise ImportError("no matplotlib here")
        return real(name, *rest)

    real = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(assur.MachineError, match="matplotlib"):
        motion.plot()


def test_a_frame_in_a_browser(tmp_path, mechanism):
    """The mechanism moves in a frame that gets its size later, and its styles do not reach the notebook around it."""
    webdriver = pytest.importorskip("selenium.webdriver")
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if not chromium or not shutil.which("chromedriver"):
        pytest.skip("no Chromium")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1000,1000"):
        options.add_argument(argument)
    browser = webdriver.Chrome(service=webdriver.chrome.service.Service(shutil.which("chromedriver")), options=options)
    try:
        size = "width: 100%; height: 900px"
        frame = mechanism._repr_html_().replace(size, "width: 0; height: 0")
        body = "<body style='margin: 3px'><h1>Notebook</h1>"
        (tmp_path / "notebook.html").write_text("<!DOCTYPE html>" + body + frame)
        browser.get((tmp_path / "notebook.html").as_uri())
        browser.execute_script(f"document.querySelector('iframe').style = '{size}'")
        assert browser.execute_script("return getComputedStyle(document.body).margin") == "3px"
        browser.switch_to.frame(browser.find_element("tag name", "iframe"))
        clock = "return document.getElementById('clock').textContent"
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline and browser.execute_script(clock) in ("", "t = 0 s"):
            time.sleep(0.1)
        assert re.fullmatch(r"t = 0\.\d+ s", browser.execute_script(clock)), "nothing moves"
        pixels = "const c = document.getElementById('picture'); return c.getContext('2d').getImageData(0, 0, c.width, "
        assert browser.execute_script(pixels + "c.height).data.some(v => v != 0)"), "the picture is empty"
    finally:
        browser.quit()
