"""What is shown whole stays so in another size of the page, in a real browser: 3-D, charts, pictures, plans."""

import json

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.sheet import DRAWN
from tests.web.test_studio_compare_page import CLEAN
from tests.web.test_studio_screen_page import holds
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = CLEAN.replace("robots: [{", "robots: [{sensors: [{camera: front, width: 160, height: 120}], ")
LONG = """\
mjsim: 1
name: long
walls: [{points: [[-4, -1], [4, -1], [4, 1], [-4, 1]], closed: true}]
obstacles:
  - {name: west, box: [0.4, 0.4, 0.5], at: [-3.7, 0]}
  - {name: east, box: [0.4, 0.4, 0.5], at: [3.7, 0]}
  - {name: mast, box: [20, 40, 40], at: [250, 0], color: "#ff0000"}
robots: [{name: scout, at: [0, 0], sensors: [{camera: front, width: 160, height: 120}]}]
"""
HEAD = 40
"""Of a tile [px]."""
WIDE, NARROW = {"width": 1400, "height": 720}, {"width": 760, "height": 720}


def in_sight(page, canvas, name) -> bool:
    """Select a thing, and return whether its handles in 3-D lie on the canvas."""
    page.locator(".outliner").get_by_text(name, exact=True).click()
    expect(canvas).to_have_attribute("data-selected", name)
    page.evaluate(DRAWN)
    box = canvas.bounding_box()
    knobs = json.loads(canvas.get_attribute("data-handles"))
    middle = next((x, y) for kind, x, y in knobs if kind == "move")
    return 0 < middle[0] < box["width"] and 0 < middle[1] < box["height"]


def look_along_x(page, canvas) -> None:
    """Turn a view that shows all, from the south-west and above, to the east."""
    box = canvas.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 0.149 * box["height"], y - 0.097 * box["height"], steps=4)
    page.mouse.up()


def reddish(canvas) -> int:
    """Return how many pixels of a view are red."""
    picture = cv2.imdecode(np.frombuffer(canvas.screenshot(), np.uint8), cv2.IMREAD_COLOR_RGB).astype(int)
    red, green, blue = np.moveaxis(picture, -1, 0)
    return int(((red > green + 60) & (red > blue + 60)).sum())


def sized(page, canvas, size) -> None:
    """Give the page another size, and wait for the pictures of the canvas in that size."""
    drawn = int(canvas.get_attribute("data-frames"))
    page.set_viewport_size(size)
    page.wait_for_function("([canvas, drawn]) => +canvas.dataset.frames > drawn", arg=[canvas.element_handle(), drawn])
    page.evaluate(DRAWN)


def the_tools_of_the_view_in_3d_stand_in_one_row(page):
    for width in (1024, 390):
        page.set_viewport_size({"width": width, "height": 720})
        page.evaluate(DRAWN)
        tools = page.locator("#view-edit .scene-bar > :is(select, button)")
        boxes = [tool.bounding_box() for tool in tools.all()]
        assert len(boxes) == 5
        assert max(box["y"] for box in boxes) < min(box["y"] + box["height"] for box in boxes), width


def the_view_in_3d_shows_all_in_another_size(page, canvas):
    for size in (NARROW, WIDE):
        sized(page, canvas, size)
        assert in_sight(page, canvas, "west"), size
        assert in_sight(page, canvas, "east"), size


def it_keeps_where_it_was_turned_to(page, canvas):
    look_along_x(page, canvas)
    for _ in range(30):
        canvas.press("+")
    page.evaluate(DRAWN)
    assert reddish(canvas) > 1000  # the mast, 120 m away, though what is looked at is 1 m away


def of_a_page_at_200_percent_all_pixels_are_drawn(page):
    zoomed = {"width": WIDE["width"] // 2, "height": WIDE["height"] // 2, "deviceScaleFactor": 2, "mobile": False}
    page.context.new_cdp_session(page).send("Emulation.setDeviceMetricsOverride", zoomed)
    for drawn in ("#view-edit .plan canvas", "#view-edit .scene canvas"):
        page.wait_for_function(
            "drawn => [...document.querySelectorAll(drawn)].every(each => each.width === 2 * each.clientWidth)",
            arg=drawn,
        )


def test_the_view_in_3d_shows_all_in_another_size_and_keeps_where_it_was_turned_to(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    (tmp_path / "long.yaml").write_text(LONG)
    with Studio(tmp_path, world="long.yaml") as studio, page_at(browser, studio.url, **WIDE, own=True) as page:
        page.locator("#view-edit").get_by_text("3-D", exact=True).click()
        canvas = page.locator("#view-edit .scene canvas")
        expect(page.locator("#view-edit .scene")).to_have_attribute("data-filled", "")
        the_view_in_3d_shows_all_in_another_size(page, canvas)
        it_keeps_where_it_was_turned_to(page, canvas)
        the_tools_of_the_view_in_3d_stand_in_one_row(page)
        of_a_page_at_200_percent_all_pixels_are_drawn(page)


def charts_fill_their_places_in_another_size(page, review):
    for size in (NARROW, WIDE):
        page.set_viewport_size(size)
        page.evaluate(DRAWN)
        page.evaluate(DRAWN)
        for box in review.locator(".run-sheet .run-chart-box").all():
            plot = box.locator(".u-wrap")
            assert plot.evaluate("wrap => wrap.clientWidth") == box.evaluate("box => box.clientWidth")
            assert plot.evaluate("wrap => wrap.clientHeight") == box.evaluate("box => box.clientHeight")


def pictures_fill_their_places_when_they_are_enlarged(page, review):
    tile = review.locator("[data-view='scout/front'], .run-tile", has_text="front").last
    tile.locator(".run-enlarge").click()
    page.evaluate(DRAWN)
    for size in (WIDE, NARROW):
        page.set_viewport_size(size)
        page.evaluate(DRAWN)
        page.evaluate(DRAWN)
        stage = review.locator(".run-stage").bounding_box()
        large = tile.locator("canvas, img").first.bounding_box()
        assert large["width"] <= stage["width"]
        assert large["height"] <= stage["height"]
        filled = max(large["width"] / stage["width"], large["height"] / (stage["height"] - HEAD))
        assert filled > 0.9, (size, large, stage)


def the_plan_of_a_comparison_shows_all_in_another_size(page):
    for name in ("one", "two"):
        page.get_by_label(f"Compare {name}.mcap").check()
    page.get_by_role("button", name="Compare 2 chosen").click()
    plan = page.locator(".compare .run-floor")
    for size in (WIDE, NARROW, WIDE):
        page.set_viewport_size(size)
        page.evaluate(DRAWN)
        assert holds(plan, [(-2, -2), (2, 2), (-2, 2), (2, -2)]), size


def test_charts_pictures_and_plans_in_review_fill_their_places_in_another_size(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    for seed, name in enumerate(("one", "two")):
        with mjsim.Simulation(mjsim.parse_world(ROOM), seed=seed) as sim:
            mjsim.run(sim, record=tmp_path / f"{name}.mcap")
    with Studio(tmp_path) as studio, page_at(browser, studio.url, **WIDE) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        page.locator("[data-path='one.mcap']").click()
        review = page.locator("#view-review")
        expect(review.locator(".run-time")).to_contain_text("of 1.96 s")
        charts_fill_their_places_in_another_size(page, review)
        pictures_fill_their_places_when_they_are_enlarged(page, review)
        the_plan_of_a_comparison_shows_all_in_another_size(page)
