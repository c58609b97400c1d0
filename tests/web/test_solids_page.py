"""The view in 3-D, in a real browser: what is picked there is selected everywhere, and a run moves in it."""

import re
import time

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

from tests.windows import PATIENCE

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
obstacles:
  - {name: tower, box: [6, 6, 4], at: [0, 0]}
  - {name: post, cylinder: [0.2, 1], at: [8, 0]}
robots: [{name: scout, at: [-8, 0], sensors: [{camera: front, width: 64, height: 48, rate_hz: 1}]}]
run: {rate_hz: 10, events: [{time: 0.2, remove: post}]}
"""
TABLE = """mjsim: 1
floor: {color: "#c8c0b0"}
obstacles:
  - {box: [2, 1, 0.04], at: [0, 0], elevation: 0.7, color: "#c8c0b0"}
  - {box: [0.1, 0.1, 0.1], at: [3, 0]}
  - {box: [0.1, 0.1, 0.1], at: [-3, 0]}
"""
SLOW = """() => {
  const wait = (until) => { while (performance.now() < until); };
  const flush = WebGL2RenderingContext.prototype.flush;
  WebGL2RenderingContext.prototype.flush = function () { flush.call(this); wait(performance.now() + 60); };
}"""
COLORS = """() => new Promise((done) => {
  const canvas = document.querySelector("#view-edit .scene-canvas");
  document.querySelector("[title*='dark' i], [title*='light' i]").click();
  // After what draws with this frame, before the browser takes the picture.
  requestAnimationFrame(() => {
    const copy = Object.assign(document.createElement("canvas"), {width: 64, height: 40}).getContext("2d");
    copy.drawImage(canvas, 0, 0, 64, 40);
    const data = new Uint32Array(copy.getImageData(0, 0, 64, 40).data.buffer);
    done([new Set(data).size, canvas.dataset.share]);
  });
})"""
ZOOM = """canvas => canvas.dispatchEvent(
  new KeyboardEvent("keydown", {key: "0", ctrlKey: true, bubbles: true, cancelable: true})
)"""
NONE = """() => {
  const draw = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
    return kind.startsWith("webgl") ? null : draw.call(this, kind, ...more);
  };
}"""


def opened(page, view):
    """Open the view in 3-D of Edit or Run, and return its canvas once there is a scene in it."""
    page.locator(f"#view-{view}").get_by_title("View in 3-D").click()
    shown = page.locator(f"#view-{view} .scene")
    expect(shown).to_have_attribute("data-filled", "", timeout=PATIENCE)
    return shown.locator("canvas")


def things_are_picked_in_3d_measured_and_followed_through_a_run(sheet, canvas):
    page = sheet.page
    sheet.click(8, 0)
    expect(canvas).to_have_attribute("data-selected", "post")
    # The tower stands in the middle of all there is, and of the view.
    canvas.click()
    expect(canvas).to_have_attribute("data-selected", "tower")
    expect(sheet.title).to_have_text("tower")
    expect(page.locator(".outline-row[aria-selected=true]")).to_contain_text("tower")
    # The robot's camera looks at it from the other side.
    sheet.click(8, 0)
    expect(canvas).to_have_attribute("data-selected", "post")
    page.get_by_label("Look from").select_option("scout/front")
    canvas.click()
    expect(canvas).to_have_attribute("data-selected", "tower")
    assert canvas.evaluate(ZOOM)  # is the browser's own
    canvas.press("0")
    expect(page.get_by_label("Look from")).to_have_value("")
    page.get_by_role("button", name="Measure").click()
    box = canvas.bounding_box()
    canvas.click(position={"x": box["width"] / 2 - 5, "y": box["height"] / 2})
    canvas.click(position={"x": box["width"] / 2 + 5, "y": box["height"] / 2})
    expect(page.locator(".scene-said")).to_have_text(
        re.compile(r"^\d+\.\d{3} m; horizontal \d+\.\d{3} m, vertical -?\d")
    )
    expect(canvas).to_have_attribute("data-selected", "tower")
    page.get_by_role("tab", name="Run").click()
    page.locator(".run-main").click()
    # However slow the machine of the test is.
    page.evaluate("() => localStorage.setItem('mjsim.run.scene.slow', 'yes')")
    canvas = opened(page, "run")
    expect(canvas).to_have_attribute("data-time", re.compile("[1-9]"), timeout=PATIENCE)
    # What an event takes away is not seen; wheels and caster stand on the floor.
    expect(canvas).to_have_attribute("data-away", "post", timeout=PATIENCE)
    expect(canvas).to_have_attribute("data-contacts", re.compile(r"^[3-9]$"), timeout=PATIENCE)
    page.get_by_label("Follow").and_(page.locator("#view-run select")).select_option("scout/base")
    before = int(canvas.get_attribute("data-frames"))
    page.wait_for_function(f"() => Number(document.querySelector('#view-run .scene canvas').dataset.frames) > {before}")


def the_scene_comes_with_a_run_and_goes_off_where_it_slows_it_until_it_is_wanted_nonetheless(sheet):
    page = sheet.page
    page.get_by_role("tab", name="Run").click()
    page.locator("#view-run").get_by_title("View in 3-D").click()
    rest = page.locator("#view-run .scene-rest")
    expect(rest).to_have_text("The scene appears here with a run.")
    page.locator(".run-main").click()
    expect(page.locator("#view-run .scene")).to_be_visible(timeout=PATIENCE)
    expect(rest).to_be_hidden()
    page.evaluate(SLOW)
    expect(rest).to_contain_text(
        re.compile(r"^3-D reaches only [\d.]+ pictures per second here; it is off"), timeout=PATIENCE
    )
    expect(page.locator("#view-run .scene")).to_be_hidden()
    drawn = page.locator("#view-run .scene canvas").get_attribute("data-frames")
    rest.get_by_role("button", name="Show it anyway").click()
    expect(rest).to_be_hidden()
    expect(page.locator("#view-run .scene canvas")).not_to_have_attribute("data-frames", drawn, timeout=PATIENCE)
    assert page.evaluate("() => localStorage.getItem('mjsim.run.scene')") == "yes"


def a_browser_without_3d_says_so_in_one_line_and_runs_all_the_same(sheet):
    page = sheet.page
    page.evaluate(NONE)
    page.locator("#view-edit").get_by_title("View in 3-D").click()
    line = "This browser cannot draw 3-D here: switch on its graphics acceleration (WebGL 2)."
    expect(page.locator("#view-edit .scene-door")).to_have_text(line, timeout=PATIENCE)
    sheet.click(8, 0)
    expect(sheet.title).to_have_text("post")
    page.get_by_role("tab", name="Run").click()
    page.locator("#view-run").get_by_title("View in 3-D").click()
    page.locator(".run-main").click()
    expect(page.locator("#view-run .scene-door")).to_have_text(line, timeout=PATIENCE)
    expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)


def a_table_top_on_a_floor_of_its_own_colour_is_seen_from_above(sheet, canvas):
    sheet.put(TABLE)
    sheet.page.get_by_label("Look from").select_option("Top")
    until = time.monotonic() + PATIENCE / 1000
    while True:
        picture = cv2.imdecode(np.frombuffer(canvas.screenshot(), np.uint8), cv2.IMREAD_GRAYSCALE)
        height, width = picture.shape
        line = picture[height // 4 : -height // 4, width // 2]  # across the top, beside the posts
        if line.min() < 0.85 * line.max():
            break
        assert time.monotonic() < until, f"it has grey levels from {line.min()} to {line.max()} alone"
        sheet.page.wait_for_timeout(100)  # it is shaded once nothing moves


def the_picture_stays_while_the_number_of_pixels_changes(sheet, canvas):
    page = sheet.page
    expect(canvas).to_have_attribute("data-share", "1.00", timeout=PATIENCE)
    page.evaluate(SLOW)
    # Each picture is too slow, so that the next one has fewer pixels: a canvas of another size is empty at first.
    for _ in range(3):
        page.wait_for_timeout(150)  # the picture before is there: this one is not put off
        colors, _ = page.evaluate(COLORS)
        assert colors > 10


def test_things_are_shaded_picked_in_3d_measured_and_followed_through_a_run(sheet):
    canvas = opened(sheet.page, "edit")
    a_table_top_on_a_floor_of_its_own_colour_is_seen_from_above(sheet, canvas)
    sheet.put(ROOM)
    canvas.press("0")
    things_are_picked_in_3d_measured_and_followed_through_a_run(sheet, canvas)


def anew(sheet):
    """End the run, and load a page that remembers nothing."""
    sheet.page.get_by_role("button", name="Stop the run").click()
    sheet.page.evaluate("localStorage.clear()")
    sheet.page.reload()
    sheet.page.get_by_role("tab", name="Edit", exact=True).click()
    sheet.reads("mjsim: 1")


def test_where_3d_is_slow_it_has_fewer_pixels_or_goes_off_and_where_there_is_none_that_is_said(sheet):
    the_scene_comes_with_a_run_and_goes_off_where_it_slows_it_until_it_is_wanted_nonetheless(sheet)
    anew(sheet)
    a_browser_without_3d_says_so_in_one_line_and_runs_all_the_same(sheet)
    anew(sheet)
    the_picture_stays_while_the_number_of_pixels_changes(sheet, opened(sheet.page, "edit"))
