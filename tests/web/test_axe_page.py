"""axe-core finds no fault in any view of the studio, nor in the pages of results, light and dark."""

import re
from functools import partial

import cv2
import numpy as np
import pytest
from axe_playwright_python.base import AXE_SCRIPT, AxeResults
from playwright.sync_api import expect

import mjsim
from mjsim.ergonomics import workplace_study
from mjsim.ergonomics.reach import AZIMUTHS, ELEVATIONS, reach_envelope
from mjsim.report import drawings
from mjsim.web import Studio
from tests.cli.shell import typed
from tests.sheet import DRAWN
from tests.windows import PATIENCE, page_at, without_portraits

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
walls: [{points: [[-3, -3], [3, -3]]}]
beacons: [{name: poster, image: posters/lion.jpg, at: [2.9, 0], heading_deg: 180}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
people: [{name: eve, sex: female, at: [1, 2]}]
run: {seconds: 1, drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}}
"""
ALL = {"resultTypes": ["violations"], "preload": False}
LIGHT = {"light": ALL}
COLOURS = LIGHT | {"dark": ALL | {"runOnly": ["color-contrast"]}}
"""What axe-core is asked in which colours: all other rules find the same in the dark.

Of what shows in few places only light ones are looked at: tests/page/theme.test.mjs compares all colours of texts.
"""
SHAPES = {"light": ALL | {"rules": {"color-contrast": {"enabled": False}}}}
"""All but contrast, which takes longer than all else, where the page has the colours that were looked at before."""
AXE = "([within, options]) => axe.run(within, options).then(({ violations }) => ({ violations }))"
IN_COLOURS = "colours => (document.documentElement.dataset.theme ?? colours) === colours"
"""The page has taken on its colours."""
SIZES = {"phone": (390, 844), "200 %": (640, 360)}


def assert_faultless(page, within="html", colours=COLOURS):
    """Fail with what axe-core finds on a page or in a part of it, in light and in dark colours."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(AXE_SCRIPT)
    for scheme, options in colours.items():
        page.emulate_media(color_scheme=scheme)
        page.wait_for_function(IN_COLOURS, arg=scheme)
        found = AxeResults(page.evaluate(AXE, [within, options]))
        assert found.violations_count == 0, f"{scheme}: {found.generate_report()}"


def faultless_on_small_screens_too(page):
    """Of another size, the page has the same colours."""
    before = page.viewport_size
    assert_faultless(page)
    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(DRAWN)
        assert_faultless(page, colours=SHAPES)
    page.set_viewport_size(before)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a world and a run of it."""
    place = tmp_path_factory.mktemp("axe")
    (place / "room.yaml").write_text(ROOM)
    for seed in (1, 2):
        with mjsim.Simulation(mjsim.load_world(place / "room.yaml"), seed=seed) as sim:
            mjsim.run(sim, record=place / f"run{seed}.mcap")
    return place


DIALOGS = {
    "open": lambda page: page.keyboard.press("Control+o"),
    "keys": lambda page: page.keyboard.press("?"),
    "new world": lambda page: page.get_by_role("button", name="New world", exact=True).click(),
    "save as": lambda page: page.keyboard.press("Control+Shift+s"),
    "another browser": lambda page: page.get_by_role("button", name="Open in another browser").click(),
    "arms": lambda page: (
        page.get_by_role("button", name="More things (M)").click(),
        page.get_by_label("Kind").select_option("arm"),
        page.locator(".pick").first.click(),
    ),
    "modules of a robot": lambda page: (
        page.locator(".outline-name", has_text="scout").click(),
        page.get_by_role("button", name="scout: Navigator").first.click(),
    ),
    "module": lambda page: (
        page.get_by_text("mjsim.algorithms.waypoints:Waypoints").click(),
        page.keyboard.press("F12"),
    ),
}
"""What opens each dialog of the studio; models, pictures and arms are offered in the same one."""


def dialogs_and_the_tour_are_faultless(page):
    without_portraits(page)
    for show in DIALOGS.values():
        show(page)
        expect(page.get_by_role("dialog")).to_be_visible()
        assert_faultless(page, "dialog[open]", LIGHT)
        page.keyboard.press("Escape")
        expect(page.get_by_role("dialog")).to_have_count(0)
    page.locator("#view-edit .plan").focus()
    page.keyboard.press("?")
    page.get_by_role("button", name="Take the tour").click()
    assert_faultless(page, ".tour", LIGHT)  # its steps differ in their words
    page.keyboard.press("Escape")


def edit_is_faultless(page):
    faultless_on_small_screens_too(page)
    page.locator("#view-edit .plan").focus()
    page.keyboard.press("Control+a")
    page.keyboard.press("Shift+F10")
    expect(page.get_by_role("menu")).to_be_visible()
    assert_faultless(page, "[role=menu]", LIGHT)
    page.keyboard.press("Escape")


def run_is_faultless(page):
    page.get_by_role("tab", name="Run", exact=True).click()
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page.locator(".run-chart:not(.unknown)", has_text="Time")).to_be_visible()
    expect(page.locator("#view-run .run-setup select").first).to_be_visible()
    faultless_on_small_screens_too(page)


def review_is_faultless(page):
    page.get_by_role("tab", name="Review", exact=True).click()
    page.locator("[data-path='run1.mcap']").click()
    expect(page.locator(".run-time:visible")).to_contain_text("of 0.96 s")
    review = page.locator("#view-review")
    review.get_by_role("tab", name="Plot", exact=True).click()
    review.get_by_label("Kind of chart 1").select_option("xy")
    for axis in "xy":
        review.get_by_label("Search topics and fields").fill(f"truth position.{axis}")
        review.locator(".plotter-found li button").click()
    expect(review.locator(".plotter-xy circle")).to_be_visible()
    faultless_on_small_screens_too(page)
    review.get_by_role("button", name="3-D", exact=True).click()
    expect(review.locator(".scene[data-filled]")).to_be_attached()
    assert_faultless(page, "#view-review", SHAPES)


def comparison_is_faultless(page):
    page.locator("#view-review").get_by_role("tab", name="Recordings", exact=True).click()
    for seed in (1, 2):
        page.get_by_label(f"Compare run{seed}.mcap").check()
    page.get_by_role("button", name="Compare 2 chosen").click()
    expect(page.locator(".compare .run-chart:not(.unknown)", has_text="Position error")).to_be_visible()
    assert_faultless(page)


def test_every_view_dialog_menu_and_the_tour_are_faultless(browser, folder):
    with Studio(folder, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        expect.set_options(timeout=PATIENCE)
        expect(page.locator("#view-edit .plan")).to_have_attribute("data-view", re.compile(","))
        dialogs_and_the_tour_are_faultless(page)
        edit_is_faultless(page)
        run_is_faultless(page)
        review_is_faultless(page)
        comparison_is_faultless(page)


RESULTS = {
    "report": ["run1.mcap"],
    "compare": ["run1.mcap", "run2.mcap"],
    "lab": ["lab.yaml"],
    "ergonomics": ["desk.yaml"],
}
"""Commands that write pages, and for what."""
LAB = """\
mjsim: 1
name: lab
robots: [{name: scout, preset: pioneer3dx, at: [0, 0], odometry: {noise: {distance: 0, turn: 0}}}]
plants: [{name: motor, of: scout, input: forward, outputs: [way.rate], amplitude: 0.3}]
run:
  seconds: 2
  drivers: {scout: {navigator: {use: "mjsim.algorithms.signal:Signal", forward: {step: {to: 0.3, at: 1}}}}}
"""
DESK = """\
mjsim: 1
name: desk
obstacles:
  - name: desk
    box: [0.6, 1.2, 0.74]
    at: [0.7, 0]
    targets:
      - {at: [-0.2, -0.2, 0.78], grip: bar, touch: finger}
      - {at: [0.1, 0, 1.1], display: screen, size: [0.5, 0.3]}
  - {name: chair, box: [0.4, 0.4, 0.45], at: [0, 0], seat: {at: [0, 0, 0.45], travel: [0.1, 0.1]}}
people: [{name: operator, sex: female, percentile: 5, seat: chair, hands: {right: desk.bar}, gaze: desk.screen}]
"""


def test_every_page_of_results_is_faultless(browser, folder, tmp_path, capsys, monkeypatch):
    # Reaches in two directions, and drawings of one pixel: they would take longer than the rest, and a page names them.
    few = partial(reach_envelope, azimuths=AZIMUTHS[:2], elevations=ELEVATIONS[:1])
    monkeypatch.setattr(workplace_study, "reach_envelope", few)
    pixel = cv2.imencode(".png", np.zeros((1, 1, 3), np.uint8))[1].tobytes()
    monkeypatch.setattr(drawings, "drawing_as", lambda *_: pixel)
    (folder / "lab.yaml").write_text(LAB)
    (folder / "desk.yaml").write_text(DESK)
    for command, names in RESULTS.items():
        words = [command, *(str(folder / name) for name in names), "-o", str(tmp_path / command)]
        assert typed(*words, capsys=capsys)[0] == 0
        assert list((tmp_path / command).glob("*.html")), command
    first, *others = sorted(tmp_path.glob("*/*.html"))
    with page_at(browser, first.as_uri(), own=True) as page:
        assert_faultless(page)
        for path in others:
            page.goto(path.as_uri())
            assert_faultless(page)
