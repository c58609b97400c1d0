"""axe-core finds no fault in any view of the studio, nor in the pages of results, light and dark."""

import re

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.cli.shell import typed
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
walls: [{points: [[-3, -3], [3, -3]]}]
beacons: [{name: poster, image: posters/lion.jpg, at: [2.9, 0], heading_deg: 180}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
people: [{name: eve, sex: female, at: [1, 2]}]
run: {seconds: 1, drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}}
"""
COLOURS = ("light", "dark")
IN_COLOURS = "colours => (document.documentElement.dataset.theme ?? colours) === colours"
"""The page has taken on its colours."""


def assert_faultless(page):
    """Fail with what axe-core finds on a page, in light and in dark colours."""
    for colours in COLOURS:
        page.emulate_media(color_scheme=colours, reduced_motion="reduce")
        page.wait_for_function(IN_COLOURS, arg=colours)
        found = Axe().run(page)
        assert found.violations_count == 0, f"{colours}: {found.generate_report()}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a world and a run of it."""
    place = tmp_path_factory.mktemp("axe")
    (place / "room.yaml").write_text(ROOM)
    for seed in (1, 2):
        with mjsim.Simulation(mjsim.load_world(place / "room.yaml"), seed=seed) as sim:
            mjsim.run(sim, record=place / f"run{seed}.mcap")
    return place


def test_every_view_of_the_studio_is_faultless(browser, folder):
    with Studio(folder, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        # Without motion no colour is on its way when it is looked at.
        page.emulate_media(reduced_motion="reduce")
        expect.set_options(timeout=PATIENCE)
        expect(page.locator("#view-edit .plan")).to_have_attribute("data-view", re.compile(","))
        page.keyboard.press("Control+a")
        page.keyboard.press("Shift+F10")
        expect(page.get_by_role("menu")).to_be_visible()
        assert_faultless(page)
        page.keyboard.press("Escape")
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-chart:not(.unknown)", has_text="Time")).to_be_visible()
        assert_faultless(page)
        page.get_by_role("tab", name="Review", exact=True).click()
        page.locator("[data-path='run1.mcap']").click()
        expect(page.locator(".run-time:visible")).to_contain_text("of 0.96 s")
        assert_faultless(page)
        review = page.locator("#view-review")
        review.get_by_role("tab", name="Plot", exact=True).click()
        review.get_by_label("Kind of chart 1").select_option("xy")
        for axis in "xy":
            review.get_by_label("Search topics and fields").fill(f"truth position.{axis}")
            review.locator(".plotter-found button").click()
        expect(review.locator(".plotter-xy circle")).to_be_visible()
        assert_faultless(page)
        review.get_by_role("tab", name="Recordings", exact=True).click()
        for seed in (1, 2):
            page.get_by_label(f"Compare run{seed}.mcap").check()
        page.get_by_role("button", name="Compare 2 chosen").click()
        expect(page.locator(".compare .run-chart:not(.unknown)", has_text="Position error")).to_be_visible()
        assert_faultless(page)


DIALOGS = {
    "open": lambda page: page.keyboard.press("Control+o"),
    "keys": lambda page: page.keyboard.press("?"),
    "new world": lambda page: page.get_by_role("button", name="New world", exact=True).click(),
    "save as": lambda page: page.keyboard.press("Control+Shift+s"),
    "another browser": lambda page: page.get_by_role("button", name="Open in another browser").click(),
    "models": lambda page: (choose(page, "model"), page.locator(".pick").first.click()),
    "arms": lambda page: (choose(page, "arm"), page.locator(".pick").first.click()),
    "module": lambda page: (
        page.get_by_text("mjsim.algorithms.waypoints:Waypoints").click(),
        page.keyboard.press("F12"),
    ),
}
"""What opens each dialog of the studio."""


def choose(page, kind):
    page.get_by_role("button", name="More things (M)").click()
    page.get_by_label("Kind").select_option(kind)


def test_every_dialog_menu_and_the_tour_are_faultless(browser, folder):
    with Studio(folder, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        expect.set_options(timeout=PATIENCE)
        page.emulate_media(reduced_motion="reduce")
        expect(page.locator("#view-edit .plan")).to_have_attribute("data-view", re.compile(","))
        for show in DIALOGS.values():
            show(page)
            expect(page.get_by_role("dialog")).to_be_visible()
            assert_faultless(page)
            page.keyboard.press("Escape")
            expect(page.get_by_role("dialog")).to_have_count(0)
        page.locator("#view-edit .plan").focus()
        page.keyboard.press("?")
        page.get_by_role("button", name="Take the tour").click()
        for _ in range(6):
            expect(page.locator(".tour")).to_be_visible()
            assert_faultless(page)
            page.keyboard.press("ArrowRight")


@pytest.mark.parametrize("size", [(390, 844), (640, 360)], ids=["phone", "200 %"])
def test_views_on_small_screens_are_faultless(browser, folder, size):
    with Studio(folder, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        expect.set_options(timeout=PATIENCE)
        page.set_viewport_size({"width": size[0], "height": size[1]})
        expect(page.locator("#view-edit .plan")).to_have_attribute("data-view", re.compile(","))
        assert_faultless(page)
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Setup, noise and events").click()
        expect(page.locator("#view-run .run-setup select").first).to_be_visible()
        assert_faultless(page)
        page.get_by_role("tab", name="Review", exact=True).click()
        page.locator("[data-path='run1.mcap']").click()
        expect(page.locator(".run-time:visible")).to_contain_text("of 0.96 s")
        page.locator("#view-review").get_by_role("tab", name="Plot", exact=True).click()
        page.locator("#view-review").get_by_role("button", name="3-D", exact=True).click()
        expect(page.locator("#view-review .scene[data-filled]")).to_be_attached()
        assert_faultless(page)


@pytest.mark.parametrize(
    "command",
    [
        ("report", "run1.mcap"),
        ("compare", "run1.mcap", "run2.mcap"),
        ("lab", "worlds/lab/lab-1-step.yaml"),
        ("ergonomics", "worlds/people/control_desk.yaml"),
    ],
    ids=lambda command: command[0],
)
def test_every_page_of_results_is_faultless(browser, folder, tmp_path, capsys, command):
    words = [str(folder / word) if word.endswith(".mcap") else word for word in command]
    assert typed(*words, "-o", str(tmp_path / "pages"), capsys=capsys)[0] == 0
    pages = sorted((tmp_path / "pages").glob("*.html"))
    assert pages
    for path in pages:
        with page_at(browser, path.as_uri()) as page:
            assert_faultless(page)
