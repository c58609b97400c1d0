"""The studio on small screens: nothing lies out of reach at 390 px nor at 200 %, and fingers do what a mouse does."""

import json
import re
from shutil import copytree

import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.sheet import DRAWN, Sheet
from tests.windows import PATIENCE, page_at, without_portraits

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
walls: [{points: [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0], sensors: [{camera: front, width: 160, height: 120}]}]
run: {seconds: 1, drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}}
"""
SIZES = ((390, 844), (640, 400))
"""Of a phone, and of a window of 1280 x 800 at 200 % [px]."""
LEAST = 40
"""Of what a finger presses [px]."""
FAULTS = """
least => {
  const top = document.querySelector("dialog[open]") ?? document;
  const name = each => (each.ariaLabel || each.title || each.textContent || each.type).trim().slice(0, 40);
  const hits = (each, hit) => each.contains(hit) || [...(each.labels ?? [])].some(label => label.contains(hit));
  const fault = each => {
    each.scrollIntoView({block: "center", inline: "center"});
    const box = each.getBoundingClientRect();
    const [x, y] = [(box.left + box.right) / 2, (box.top + box.bottom) / 2];
    if (box.left < -1 || box.right > innerWidth + 1 || y < 0 || y > innerHeight) return "is out of sight";
    const hit = document.elementFromPoint(x, y);
    if (!hits(each, hit)) return `is under ${hit?.outerHTML.slice(0, 60)}`;
    const pressed = each.matches("button:not([data-event]), summary, select");
    if (pressed && Math.min(box.width, box.height) < least) return `is ${box.width} x ${box.height} px`;
    return null;
  };
  const seen = each => each.checkVisibility({visibilityProperty: true}) && !each.closest("[inert], .sr");
  const faults = [...top.querySelectorAll("button:enabled, select, summary, input, a[href]")]
    .filter(seen).map(each => [name(each), fault(each)]).filter(([_, what]) => what);
  const hides = each => getComputedStyle(each).overflowX === "hidden" && each.querySelector("button");
  for (const each of [document.scrollingElement, ...[...document.querySelectorAll(".view, .view *")].filter(hides)])
    if (each.scrollWidth > each.clientWidth + 1) faults.push([each.className, "is cut off at its side"]);
  return faults;
}
"""
"""What of what can be pressed or filled in cannot be brought into sight, is covered, or is too small for a finger."""


def assert_in_reach(page, shown):
    """Fail with what is out of reach on a page, once what it is to show is there."""
    expect(shown).to_be_visible(timeout=PATIENCE)
    page.evaluate(DRAWN)
    assert page.evaluate(FAULTS, LEAST) == []


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a world and two runs of it."""
    place = tmp_path_factory.mktemp("small")
    (place / "room.yaml").write_text(ROOM)
    for seed in (1, 2):
        with mjsim.Simulation(mjsim.load_world(place / "room.yaml"), seed=seed) as sim:
            mjsim.run(sim, record=place / f"run{seed}.mcap")
    return place


def test_fingers_reach_all_there_is_on_a_small_screen_drag_pinch_and_ask_for_the_menu(browser, folder):
    with Studio(folder, world="room.yaml") as studio, page_at(browser, studio.url, touch=True) as page:
        expect.set_options(timeout=PATIENCE)
        for width, height in SIZES:
            page.set_viewport_size({"width": width, "height": height})
            walk_edit(page)
            walk_dialogs(page)
            walk_run_and_review(page)
            page.get_by_role("button", name="Keys (?)").tap()
            assert_in_reach(page, page.get_by_role("dialog"))
            page.keyboard.press("Escape")
            page.locator(".bar .world").tap()
            assert_in_reach(page, page.get_by_role("dialog"))
            page.keyboard.press("Escape")
        page.set_viewport_size({"width": 390, "height": 844})
        page.get_by_role("tab", name="Edit", exact=True).tap()
        fingers_drag_pinch_and_ask_for_the_menu(page)


def walk_edit(page):
    page.get_by_role("tab", name="Edit", exact=True).tap()
    assert_in_reach(page, page.locator("#view-edit .plan"))
    fields, text = (page.get_by_role("button", name=name, exact=True) for name in ("Fields", "Text"))
    fields.tap()
    page.locator(".outline-row", has_text="scout").tap()
    assert_in_reach(page, page.locator(".panel").get_by_label("Name", exact=True))
    text.tap()
    expect(page.locator(".panel")).to_be_hidden()
    assert_in_reach(page, page.locator(".cm-content"))
    text.tap()
    expect(page.locator(".cm-content")).to_be_hidden()


def walk_dialogs(page):
    """Go through what is opened from the bar and from Edit, and through the tour."""
    plan, dialog = page.locator("#view-edit .plan"), page.get_by_role("dialog")

    def button(name):
        return page.get_by_role("button", name=name, exact=True).locator("visible=true").first

    without_portraits(page)
    shows = [
        lambda: button("New world").tap(),
        lambda: page.keyboard.press("Control+Shift+s"),
        lambda: button("Open in another browser").tap(),
        lambda: page.locator(".pick").first.tap(),
    ]
    button("More things (M)").tap()
    page.get_by_label("Kind").select_option("model")
    for show in shows:
        show()
        assert_in_reach(page, dialog)
        page.keyboard.press("Escape")
        expect(dialog).to_have_count(0)
    plan.focus()
    page.keyboard.press("v")
    page.keyboard.press("?")
    button("Take the tour").tap()
    for step in (1, 2):  # its other steps differ in their words
        expect(dialog).to_contain_text(f"{step} of 6")
        assert_in_reach(page, dialog)
        page.keyboard.press("ArrowRight")
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)


def walk_run_and_review(page):
    page.get_by_role("tab", name="Run", exact=True).tap()
    side = page.get_by_role("button", name="Setup, noise and events")
    expect(page.locator("#view-run .run-side")).to_be_hidden()
    side.tap()
    assert_in_reach(page, page.locator("#view-run .run-side"))
    side.tap()
    expect(page.locator("#view-run .run-side")).to_be_hidden()
    page.get_by_role("button", name="Start", exact=True).tap()
    picture = page.locator("#view-run [data-view='scout/front'] canvas[data-filled]")
    picture.wait_for(state="attached")
    expect(page.locator(".run-state:visible")).to_have_text("Ended")
    assert_in_reach(page, picture)
    page.get_by_role("tab", name="Review", exact=True).tap()
    page.locator("[data-path='run1.mcap']").tap()
    expect(page.locator(".run-time:visible")).to_contain_text("of 0.96 s")
    assert_in_reach(page, page.get_by_role("slider", name="Time"))
    for seed in (1, 2):
        page.get_by_label(f"Compare run{seed}.mcap").check()
    page.get_by_role("button", name="Compare 2 chosen").tap()
    assert_in_reach(page, page.locator(".compare-legend"))
    page.get_by_role("button", name="Back", exact=True).tap()


class Fingers:
    """Fingers on a page, by events as a screen of glass sends them."""

    def __init__(self, page) -> None:
        self._send = page.context.new_cdp_session(page).send

    def put(self, kind: str, *points: tuple[float, float]) -> None:
        """Put fingers at points of the page [px], move them there, or (without points) take them away."""
        touches = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        self._send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self.put("touchStart", start)
        for share in (0.5, 1.0):
            self.put("touchMove", tuple(a + share * (b - a) for a, b in zip(start, end, strict=True)))
        self.put("touchEnd")


def fingers_drag_pinch_and_ask_for_the_menu(page):
    sheet, fingers = Sheet(page), Fingers(page)
    expect(sheet.plan).to_have_attribute("data-view", re.compile(","))
    fingers.drag(sheet.pixel(0, 0), sheet.pixel(1, 1))
    page.get_by_role("button", name="Text", exact=True).click()
    expect(sheet.text).to_be_visible()
    sheet.reads("at: [1, 1]")
    page.get_by_role("button", name="Text", exact=True).click()
    expect(sheet.text).to_be_hidden()
    page.evaluate(DRAWN)
    scale = json.loads(sheet.plan.get_attribute("data-view"))[2]
    x, y = sheet.pixel(-2, 0)
    fingers.put("touchStart", (x, y), (x + 40, y))
    fingers.put("touchMove", (x - 20, y), (x + 60, y))
    fingers.put("touchEnd")
    page.wait_for_function(
        "least => JSON.parse(document.querySelector('.plan').dataset.view)[2] > least", arg=1.9 * scale
    )
    fingers.put("touchStart", sheet.pixel(1, 1))
    expect(page.get_by_role("menu", name="scout")).to_be_visible()
    fingers.put("touchEnd")
    page.get_by_role("menuitem", name="Rename").click()
    expect(page.locator(".outline-row input")).to_be_focused()


CUT_HEADS = """() => [...document.querySelectorAll(".view h2, .run-legend")].filter(
  each => each.checkVisibility() && each.scrollWidth > each.clientWidth).map(each => each.textContent)"""
TEXTS_OUT = """svg => { const outer = svg.getBoundingClientRect();
return [...svg.querySelectorAll("text")].filter(text => {
  const box = text.getBoundingClientRect();
  return box.top < outer.top || box.bottom > outer.bottom || box.left < outer.left || box.right > outer.right;
}).map(text => text.textContent); }"""


def heads_of_views_and_names_of_axes_are_whole_on_a_phone_and_the_plan_fills_a_low_window(page):
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("tab", name="Run", exact=True).click()
    expect(page.locator("#view-run .run-floor canvas").first).to_be_visible(timeout=PATIENCE)
    assert page.evaluate(CUT_HEADS) == []
    for width in (760, 820):
        page.set_viewport_size({"width": width, "height": 844})
        assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth"), width
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("tab", name="Review", exact=True).click()
    review = page.locator("#view-review")
    review.locator("[data-path='run1.mcap']").click()
    review.get_by_role("tab", name="Plot", exact=True).click()
    review.get_by_label("Kind of chart 1").select_option("xy")
    for axis in "xy":
        review.get_by_label("Search topics and fields").fill(f"truth position.{axis}")
        review.locator(".plotter-found li button").click()
    drawn = review.locator(".plotter-xy svg")
    expect(drawn).to_be_visible(timeout=PATIENCE)
    expect(drawn.locator("text").last).to_have_text(re.compile(r"\.y$"))  # y was added
    assert drawn.evaluate(TEXTS_OUT) == []
    review.get_by_role("tab", name="Recordings", exact=True).click()
    for seed in (1, 2):
        page.get_by_label(f"Compare run{seed}.mcap").check()
    page.get_by_role("button", name="Compare 2 chosen").click()
    expect(page.locator(".compare-legend")).to_be_visible(timeout=PATIENCE)
    assert page.evaluate(CUT_HEADS) == []
    page.set_viewport_size({"width": 640, "height": 360})
    page.get_by_role("tab", name="Run", exact=True).click()
    page.evaluate(DRAWN)
    plan = page.locator("#view-run .run-floor")
    _, _, scale = json.loads(plan.get_attribute("data-view"))
    assert 6 * scale > 0.5 * plan.bounding_box()["height"]  # the room is 6 m wide


def the_view_in_3d_is_seen_among_other_pictures(page):
    page.set_viewport_size({"width": 1280, "height": 720})
    page.get_by_role("tab", name="Review", exact=True).click()
    review = page.locator("#view-review")
    review.locator("[data-path='run1.mcap']").click()
    review.get_by_role("button", name="3-D", exact=True).click()
    scene = review.locator(".scene[data-filled]")
    expect(scene).to_be_visible(timeout=PATIENCE)
    # The bar leaves two thirds of a small view to the scene, and offers all where there is room.
    assert scene.locator(".scene-bar").bounding_box()["height"] < scene.bounding_box()["height"] / 3
    tile = review.locator("[data-view='scene'].run-tile").bounding_box()
    canvas = scene.locator("canvas").bounding_box()
    assert canvas["y"] + canvas["height"] <= tile["y"] + tile["height"]
    expect(scene.get_by_role("button", name="Measure")).to_be_hidden()
    review.locator("[data-view='scene']").get_by_role("button", name="Show large").first.click()
    expect(scene.get_by_role("button", name="Measure")).to_be_visible()
    review.get_by_role("button", name="3-D", exact=True).click()


def the_bar_of_a_low_window_names_what_it_opens(page):
    page.set_viewport_size({"width": 640, "height": 360})
    name = page.locator(".bar .world .name")
    expect(name).to_have_text("Open a world", timeout=PATIENCE)
    assert name.evaluate("name => name.scrollWidth <= name.clientWidth")
    assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth")


def the_panels_of_run_come_back_with_the_room_for_them(page):
    page.get_by_role("tab", name="Run", exact=True).click()
    side = page.locator("#view-run .run-side")
    for width, shown in ((640, False), (1280, True)):
        page.set_viewport_size({"width": width, "height": 720})
        expect(side).to_be_visible(visible=shown)


def test_windows_that_are_low_or_narrow_show_names_heads_and_the_view_in_3d_whole(browser, folder, tmp_path):
    own = copytree(folder, tmp_path / "own")  # the test with fingers leaves an unsaved text
    with Studio(own) as studio, page_at(browser, studio.url) as page:
        the_bar_of_a_low_window_names_what_it_opens(page)
        the_view_in_3d_is_seen_among_other_pictures(page)
        page.keyboard.press("Control+o")
        page.get_by_role("dialog").get_by_role("button", name="room.yaml").click()
        expect(page.locator(".cm-content")).to_contain_text("mjsim: 1", timeout=PATIENCE)
        heads_of_views_and_names_of_axes_are_whole_on_a_phone_and_the_plan_fills_a_low_window(page)
        the_panels_of_run_come_back_with_the_room_for_them(page)
