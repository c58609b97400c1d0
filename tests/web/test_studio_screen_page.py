"""What a person sees on the page: mechanisms and the whole plan, charts without values, pictures of any kind."""

import json
import re

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.bench.entering import client_of
from mjsim.web import Studio
from mjsim.web.worlds.items import scene_of
from tests.asking import told
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
mechanisms:
  - name: fourbar
    at: [1, 1]
    elevation: 1
    bodies: [{name: crank, rod: [1.0, 0.1]}, {name: coupler, rod: [3.5, 0.1]}, {name: rocker, rod: [3.0, 0.1]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 0, 1], start_deg: 30}   # by hand
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
robots:
  - {name: scout, preset: pioneer3dx, at: [0, -2]}
beacons:
  - {name: poster, image: posters/lion.jpg, at: [6, 0], heading_deg: 180}
"""


def a_mechanism_is_on_the_plan_and_its_crank_is_dragged_with_the_loop_closed(sheet):
    # The middle of the crank, from 30 to 90 degrees.
    middle, above = (1 + 0.5 * np.cos(np.pi / 6), 1 + 0.5 * np.sin(np.pi / 6)), (1.0, 1.5)
    sheet.click(*middle)
    expect(sheet.title).to_have_text("q2")
    sheet.drag(middle, above)
    # As far as the body's middle was dragged, on the grid of the plan.
    expect(sheet.text).to_contain_text(re.compile(r"start_deg: (8[5-9]|9[0-5])(\.\d+)?}   # by hand"))
    world = mjsim.parse_world(ROOM.replace("start_deg: 30", "start_deg: 90"))
    bodies = next(item for item in scene_of(world)["items"] if item["kind"] == "mechanism")["polygons"]
    crank = min(bodies, key=lambda polygon: np.ptp(polygon, axis=0).max())
    assert np.max(crank, axis=0)[1] == pytest.approx(2.1, abs=0.01)
    sheet.press("Control+z")
    sheet.reads("start_deg: 30}   # by hand")


def a_webp_picture_is_imported_as_a_png(sheet, tmp_path):
    pixels = np.full((40, 60, 3), (40, 160, 220), np.uint8)
    data = cv2.imencode(".webp", pixels, [cv2.IMWRITE_WEBP_QUALITY, 101])[1].tobytes()
    sheet.click(6.0, 0.0)
    expect(sheet.title).to_have_text("poster")
    sheet.page.locator(".panel").get_by_role("button", name=re.compile("choose a picture")).click()
    chooser = sheet.page.locator("dialog input[type=file]")
    chooser.set_input_files({"name": "hill.webp", "mimeType": "image/webp", "buffer": data})
    sheet.reads("image: hill.png")
    brought = cv2.imread(str(tmp_path / "hill.png"))
    assert brought.shape == (40, 60, 3)
    assert np.abs(brought.astype(int) - pixels).max() <= 1


def charts_without_values_say_so_and_no_legend_is_cut(page):
    expect(page.locator(".run-chart:not(.unknown)", has_text="Time")).to_be_visible(timeout=PATIENCE)
    expect(page.locator(".run-chart", has_text="NEES")).to_have_class(re.compile("unknown"))
    cut = page.locator(".run-chart figcaption").evaluate_all(
        "all => all.filter((each) => each.scrollWidth > each.clientWidth + 1).length"
    )
    assert cut == 0


FAR = """
mjsim: 1
name: far
walls: [{points: [[500, 500], [1500, 500], [1500, 1500], [500, 1500]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [1000, 1000]}]
run: {seconds: 1000}
"""

COLOURS = """
canvas => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
}
"""
"""How many colours a picture has."""


def holds(plan, corners) -> bool:
    """Return whether these points of the world [m] are in sight on a plan that has come to rest."""
    left, top, scale = json.loads(at_rest(plan))
    box = plan.bounding_box()
    pixels = [(left + x * scale, top - y * scale) for x, y in corners]
    return all(0 < x < box["width"] and 0 < y < box["height"] for x, y in pixels)


def at_rest(plan) -> str:
    """Wait until a plan that follows its size shows the same for ten pictures of the page, and return its view."""
    return plan.evaluate(
        """async plan => {
            for (let view = plan.dataset.view, same = 0; same < 10; view = plan.dataset.view) {
                await new Promise(requestAnimationFrame);
                same = plan.dataset.view === view ? same + 1 : 0;
            }
            return plan.dataset.view;
        }"""
    )


def resized(page, plan, width, height) -> None:
    """Give the page another size, and wait until the plan has it."""
    before = at_rest(plan)
    page.set_viewport_size({"width": width, "height": height})
    expect(plan).not_to_have_attribute("data-view", before)


def a_plan_that_shows_all_still_does_in_another_size_and_one_that_was_moved_keeps_its_scale(sheet):
    corners = [(1.0, 1.0), (6.0, 0.0), (0.0, -2.0)]
    resized(sheet.page, sheet.plan, 900, 500)
    assert holds(sheet.plan, corners)
    before = at_rest(sheet.plan)
    sheet.plan.focus()
    sheet.press("+")
    expect(sheet.plan).not_to_have_attribute("data-view", before)
    scale = json.loads(at_rest(sheet.plan))[2]
    resized(sheet.page, sheet.plan, 1280, 720)
    assert json.loads(at_rest(sheet.plan))[2] == scale


def text_and_panels_stand_at_the_side_to_which_they_are_put_and_stay_there(sheet):
    page = sheet.page
    text, column = page.locator("#view-edit > .dock"), page.locator("#view-edit > .side-column")

    def stands(part, side):
        its, plan = part.bounding_box(), sheet.plan.bounding_box()
        low, size = ("y", "height") if side == "below" else ("x", "width")
        first, second = (its, plan) if side == "left" else (plan, its)
        assert first[low] + first[size] <= second[low]

    stands(text, "below")
    stands(column, "right")
    text.locator("h2").drag_to(sheet.plan, target_position={"x": 500, "y": 60})
    stands(text, "right")
    page.locator(".outline-head").press("Control+ArrowLeft")
    stands(column, "left")
    width = column.bounding_box()["width"]
    page.get_by_role("separator", name="Size of the panel").locator("visible=true").press("ArrowRight")
    assert column.bounding_box()["width"] == width + 24
    page.reload()
    sheet.settles()
    stands(text, "right")
    stands(column, "left")
    text.get_by_role("button", name="Hide").press("Control+ArrowDown")
    stands(text, "below")
    page.locator(".outline-head").press("Control+ArrowRight")
    stands(column, "right")


def test_a_plan_shows_all_of_itself_its_mechanisms_and_brought_pictures(sheet, tmp_path):
    text_and_panels_stand_at_the_side_to_which_they_are_put_and_stay_there(sheet)
    a_plan_that_shows_all_still_does_in_another_size_and_one_that_was_moved_keeps_its_scale(sheet)
    a_mechanism_is_on_the_plan_and_its_crank_is_dragged_with_the_loop_closed(sheet)
    a_webp_picture_is_imported_as_a_png(sheet, tmp_path)


def two_views_stand_beside_each_other_and_a_bar_gives_a_panel_its_size(page):
    large = page.locator("#view-run .run-stage .run-tile")
    page.locator("#view-run [data-view='plan']").get_by_role("button", name="Show beside").click()
    expect(large).to_have_count(2)
    page.locator("#view-run").get_by_role("separator", name="Size of the panel").press("ArrowRight")
    expect(page.locator("#view-run .run-side")).to_have_css("width", "304px")


def a_view_is_dragged_below_another_and_the_bar_between_them_moved(page):
    plan, outside = (page.locator(f"#view-run .run-stage [data-view='{key}']") for key in ("plan", "outside"))
    box = outside.bounding_box()
    plan.locator("h2").drag_to(outside, target_position={"x": box["width"] / 2, "y": box["height"] - 20})
    is_above(outside, plan)
    bar = page.locator("#view-run .run-stage").get_by_role("separator")
    before = outside.bounding_box()["height"]
    bar.press("ArrowUp")
    assert outside.bounding_box()["height"] == pytest.approx(before - 24, abs=1)


def is_above(one, other):
    upper, lower = one.bounding_box(), other.bounding_box()
    assert upper["y"] + upper["height"] <= lower["y"]
    assert (upper["x"], upper["width"]) == (lower["x"], lower["width"])


def a_panel_is_dragged_to_the_left_of_a_view_and_charts_go_below_all_by_keys(page):
    view = page.locator("#view-run")
    outside = view.locator(".run-stage [data-view='outside']")
    view.get_by_role("tab", name="Events").drag_to(outside, target_position={"x": 10, "y": 100})
    events = view.locator(".run-stage [data-view='panel:events']")
    expect(events).to_contain_text("Events appear here")
    expect(view.get_by_role("tab", name="Events")).to_be_hidden()
    assert events.bounding_box()["x"] < outside.bounding_box()["x"]
    view.locator(".run-dock").get_by_role("button", name="Show beside").press("Control+ArrowDown")
    charts = view.locator(".run-stage [data-view='panel:charts']")
    assert charts.bounding_box()["y"] > max(each.bounding_box()["y"] for each in (events, outside))
    expect(charts.get_by_role("button", name="Put back")).to_be_focused()
    page.keyboard.press("Enter")
    expect(charts).to_have_count(0)
    expect(view.locator(".run-dock .run-chart").first).to_be_visible()


def a_panel_that_was_elsewhere_is_there_after_a_reload_and_goes_back_to_its_tab(page):
    view = page.locator("#view-run")
    back = view.locator(".run-stage [data-view='panel:events']").get_by_role("button", name="Put back")
    back.click()
    expect(view.get_by_role("tab", name="Events")).to_be_focused()
    expect(view.get_by_role("tabpanel")).to_contain_text("Events appear here")


def a_chart_fills_the_window_until_escape(page):
    chart = page.locator("#view-run .run-chart").first
    before = chart.bounding_box()
    chart.get_by_role("button", name="Fill the window").click()
    assert chart.bounding_box()["width"] > 1200 > before["width"]
    page.keyboard.press("Escape")
    assert chart.bounding_box() == before


def test_beside_a_large_view_it_is_said_whose_run_it_is_and_all_of_a_far_world_is_in_sight(browser, tmp_path):
    (tmp_path / "far.yaml").write_text(FAR)
    (tmp_path / "near.yaml").write_text(ROOM)
    with Studio(tmp_path, world="far.yaml") as studio, page_at(browser, studio.url, outside=True) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        expect(page.get_by_text("Camera pictures appear here")).to_be_visible(timeout=PATIENCE)
        page.get_by_role("button", name="Start", exact=True).click()
        outside = page.locator("[data-view='outside']")
        outside.locator("canvas[data-filled]").wait_for(timeout=PATIENCE)
        # More than the sky, which the first picture may be.
        page.wait_for_function(f"canvas => ({COLOURS})(canvas) > 100", arg=outside.locator("canvas").element_handle())
        expect(page.get_by_text("Camera pictures appear here")).to_be_hidden()
        charts_without_values_say_so_and_no_legend_is_cut(page)
        plan = page.locator(".run-floor")
        before = at_rest(plan)
        outside.get_by_role("button", name="Show large").click()
        expect(plan).not_to_have_attribute("data-view", before)
        assert holds(plan, [(500, 500), (1500, 1500)])
        two_views_stand_beside_each_other_and_a_bar_gives_a_panel_its_size(page)
        a_view_is_dragged_below_another_and_the_bar_between_them_moved(page)
        a_panel_is_dragged_to_the_left_of_a_view_and_charts_go_below_all_by_keys(page)
        a_chart_fills_the_window_until_escape(page)
        page.keyboard.press("Control+o")
        page.get_by_role("dialog").get_by_role("button", name="near.yaml", exact=True).click()
        expect(page.locator(".world .name")).to_have_text("near.yaml")
        # Run stays in front, and says whose it is.
        expect(page.get_by_text("This is a run of far.yaml")).to_be_visible(timeout=PATIENCE)
        page.reload()
        expect(page.locator("#view-run .run-side")).to_have_css("width", "304px")
        expect(page.locator("#view-run .run-stage .run-tile")).to_have_count(3)
        a_panel_that_was_elsewhere_is_there_after_a_reload_and_goes_back_to_its_tab(page)
        is_above(*(page.locator(f"#view-run .run-stage [data-view='{key}']") for key in ("outside", "plan")))


def test_a_further_opening_is_written_where_a_person_would(tmp_path):
    wall = "{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, openings: [{segment: 0, at: 1, width: 1}]}"
    text = f"mjsim: 1\nwalls:\n  - {wall}\n"
    (tmp_path / "room.yaml").write_text(text)
    value = {"segment": 0, "at": 3.0, "width": 0.9}
    with Studio(tmp_path) as studio, client_of(studio.url) as client:
        change = {"op": "add", "path": ["walls", 0, "openings"], "value": value}
        found = told(client, "edit", path="room.yaml", text=text, changes=[change])["text"]
    assert len(mjsim.parse_world(found).walls[0].openings) == 2
    assert max(len(line) - len(line.lstrip()) for line in found.splitlines()) <= 8
