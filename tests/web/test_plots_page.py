"""Plots of chosen numbers in a real browser: over time and against each other, of recordings and of a live run."""

import csv
import json
import time

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.sheet import DRAWN
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0], odometry: {noise: {distance: 0.05, turn: 0.1}}}]
run:
  seconds: 2
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0], [1, 1]]}}}
"""
SIGMA, MINUS = "\N{GREEK SMALL LETTER SIGMA}", "\N{MINUS SIGN}"
X, Y = "/scout/truth.pose.position.x", "/scout/truth.pose.position.y"


def draw(view, field, words=""):
    """Put a number into the chart that takes the next one."""
    view.get_by_label("Search topics and fields").fill(words or field)
    view.locator(".plotter-found").get_by_role("button", name=field, exact=True).click()
    expect(view.locator(".plotter-card[data-current] .plotter-list")).to_contain_text(field)


def numbers(page, chart):
    """Return the rows of the CSV that the menu of a chart gives."""
    chart.get_by_label("Save as a file").click()
    with page.expect_download(timeout=PATIENCE) as download:
        chart.get_by_role("button", name="CSV").click()
    return list(csv.reader(download.value.path().read_text().splitlines()))


def opened(page):
    """Return the Review view with the recording open and its plots shown."""
    page.get_by_role("tab", name="Review", exact=True).click()
    review = page.locator("#view-review")
    review.get_by_role("tab", name="Recordings", exact=True).click()
    review.locator("[data-path='run.mcap']").click()
    expect(review.locator(".run-time")).to_contain_text("of 1.96 s")
    review.get_by_role("tab", name="Plot", exact=True).click()
    return review


def layouts_that_stay_have_numbers_drawn_against_each_other(page, track):
    kept = [1, {"name": 2}, *({"name": f"Layout {k}", "charts": []} for k in range(1, 40))]
    page.evaluate("kept => localStorage.setItem('mjsim.review.layouts', kept)", json.dumps({"layouts": kept}))
    page.reload()
    review = opened(page)
    draw(review, X)
    review.get_by_role("button", name="Add chart").click()
    review.get_by_label("Kind of chart 2").select_option("xy")
    draw(review, X)
    expect(review.locator(".run-chart.unknown", has_text="add a number for y")).to_be_visible()
    draw(review, Y)
    expect(review.locator(".plotter-chart .run-chart")).to_have_count(2)
    spot = review.locator(".plotter-xy circle")
    expect(spot).to_have_count(1)
    before = spot.get_attribute("cx")
    page.keyboard.press("Escape")
    review.locator(".run-time").click()
    page.keyboard.press("ArrowRight")
    reading = review.locator(".run-chart", has_text="against").locator("output")
    expect(reading).to_have_text(", ".join(f"{value:.5g}" for value in np.round(track.truth[25, :2], 9)))
    assert spot.get_attribute("cx") != before
    review.get_by_role("button", name="New …").click()
    page.get_by_label("Name of the layout").fill("empty one")
    page.get_by_role("button", name="Keep").click()
    expect(review.locator(".plotter-chart .run-chart")).to_have_count(0)
    review.get_by_role("button", name="Rename …").click()  # though there can be no more of them
    page.get_by_label("Name of the layout").fill("an empty one")
    page.keyboard.press("Enter")
    layout = review.get_by_label("Layout", exact=True)
    expect(layout).to_have_value("an empty one")
    page.reload()
    review = opened(page)
    expect(layout).to_have_value("an empty one")
    layout.select_option("Layout 1")
    expect(review.locator(".plotter-chart .run-chart")).to_have_count(2)
    chart = review.locator(".run-chart", has_text="against")
    head, *rows = numbers(page, chart)
    assert head == ["curve", "time [s]", X, "value"]
    np.testing.assert_allclose([[float(x), float(y)] for *_, x, y in rows], track.truth[:, :2], atol=1e-6)


def numbers_of_a_live_run_are_drawn_as_they_come(page):
    page.get_by_role("tab", name="Run", exact=True).click()
    run = page.locator("#view-run")
    run.get_by_role("tab", name="Plot", exact=True).click()
    run.get_by_role("button", name="Start", exact=True).click()
    draw(run, "/scout.truth.x")
    draw(run, "/scout.estimate.x")
    run.locator(".topic").get_by_role("button", name="Message").click()
    expect(run.locator(".run-state")).to_have_text("Ended")
    expect(run.get_by_role("row", name="timing.step")).to_contain_text("ms")
    chart = run.locator(".plotter-chart .run-chart")
    expect(chart).to_have_count(1)
    until = time.monotonic() + PATIENCE / 1000
    while float((table := numbers(page, chart))[-1][0]) < 1.9:
        assert time.monotonic() < until, table[-1]
    assert table[0] == ["time [s]", "/scout.truth.x", "/scout.estimate.x"]
    assert float(table[-1][1]) > 0.5
    kept = json.loads(page.evaluate("localStorage.getItem('mjsim.run.layouts')"))
    assert len(kept["layouts"][0]["charts"][0]["fields"]) == 2


def far_away(route):
    """Answer with numbers as of a world in UTM coordinates."""
    answer = route.fetch()
    told = answer.json()
    route.fulfill(response=answer, json={**told, "values": [value + 6.25e6 for value in told["values"]]})


SIZES = ((1280, 720, 150), (640, 360, 200), (390, 844, 250))
"""Of windows, the second is one of 1280 x 720 at 200 %, and the least height of a chart there [px]."""


def numbers_at_axes_differ_far_from_the_origin_in_charts_high_enough_to_read(page):
    page.route("**/api/recording/column*", far_away)
    page.evaluate("localStorage.clear()")
    page.reload()
    review = opened(page)
    draw(review, X)
    chart = review.locator(".plotter-chart .run-chart canvas")
    page.wait_for_function(f"canvas => ({LABELS_OF})(canvas).length > 1", arg=chart.element_handle())
    labels = chart.evaluate(LABELS_OF)
    assert len(set(labels)) == len(labels)
    review.get_by_label("Kind of chart 1").select_option("xy")
    draw(review, Y)
    expect(review.locator(".plotter-xy circle")).to_have_count(1)
    for width, height, least in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(DRAWN)
        page.evaluate(DRAWN)
        assert review.locator(".plotter-xy").bounding_box()["height"] >= least, width
        across = review.locator(".plotter-xy text[text-anchor=middle]").all_text_contents()[:-2]  # without names
        assert len(across) == len(set(across)) >= 2, width


SWATCHES = """list => [...list.querySelectorAll("i")].map(swatch => {
  const root = getComputedStyle(document.documentElement);
  const painted = document.body.appendChild(document.createElement("i"));
  const names = ["truth", "estimate", "odometry", "seen", "scanned", "beacon"];
  const found = names.find(name => {
    painted.style.background = root.getPropertyValue(`--${name}`);
    return getComputedStyle(painted).backgroundColor === getComputedStyle(swatch).backgroundColor;
  });
  painted.remove();
  return found;
})"""


def the_lines_of_errors_have_names_the_narrow_bound_before_the_wide(page, review):
    chart = review.locator(".run-chart", has_text="x error").first
    expect(chart.locator(".run-chart-legend > span")).to_have_text(["error", f"2{SIGMA}", f"3{SIGMA}"])
    bounds = [f"{sign}{factor}{SIGMA}" for factor in (2, 3) for sign in ("", MINUS)]
    assert numbers(page, chart)[0][1:] == ["error", *bounds]


def truth_estimate_and_odometry_have_their_own_colours(page, review):
    for field in ("odometry.pose.position.x", "estimate.pose.position.x", "estimate.pose.position.y"):
        draw(review, f"/scout/{field}")
    chart = review.locator(".plotter-chart .run-chart")
    expect(chart.locator(".run-chart-legend i")).to_have_count(3)
    colors = ["odometry", "estimate", "truth"]
    assert review.locator(".plotter-list").evaluate(SWATCHES) == colors
    assert chart.locator(".run-chart-legend").evaluate(SWATCHES) == colors
    page.get_by_role("button", name="Dark colours").click()
    assert review.locator(".plotter-list").evaluate(SWATCHES) == colors


LABELS = """() => {
  const { fillText } = CanvasRenderingContext2D.prototype;
  window.labels = new WeakMap();
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
    const frames = window.labels.get(this.canvas) ?? new Map();
    // Those of the upright axis are drawn from its right; a number that is drawn again at its place is the same.
    if (this.textAlign === "right") frames.set(`${text} ${Math.round(y)}`, text);
    window.labels.set(this.canvas, frames);
    fillText.call(this, text, x, y);
  };
  const { clearRect } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.clearRect = function (...box) {
    window.labels.delete(this.canvas);
    clearRect.apply(this, box);
  };
}"""
LABELS_OF = "canvas => [...(window.labels.get(canvas) ?? new Map()).values()]"


NAMED = f"""charts => charts.map(chart => [
  chart.querySelector("strong").innerText, ({LABELS_OF})(chart.querySelector("canvas")).length
])"""
"""Titles of charts, and how many numbers stand at their upright axes."""


def an_axis_names_two_numbers_at_least_so_that_its_scale_can_be_read(page, review):
    for height in range(90, 150, 6):  # windows and heads of several lines make the same chart lower or higher
        review.locator(".run-sheet").evaluate("(sheet, high) => sheet.style.height = `${high}px`", height)
        page.evaluate(DRAWN)
        named = review.locator(".run-chart").evaluate_all(NAMED)
        assert named
        assert [each for each in named if each[1] < 2] == [], height


def test_numbers_of_recordings_and_of_a_live_run_are_plotted(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    (tmp_path / "room.yaml").write_text(ROOM)
    with mjsim.Simulation(mjsim.load_world(tmp_path / "room.yaml"), seed=1) as sim:
        mjsim.run(sim, record=tmp_path / "run.mcap")
    track = mjsim.read_recording(tmp_path / "run.mcap").robots["scout"]
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url, own=True) as page:
        page.add_init_script(f"({LABELS})()")
        page.reload()
        review = opened(page)
        the_lines_of_errors_have_names_the_narrow_bound_before_the_wide(page, review)
        an_axis_names_two_numbers_at_least_so_that_its_scale_can_be_read(page, review)
        truth_estimate_and_odometry_have_their_own_colours(page, review)
        layouts_that_stay_have_numbers_drawn_against_each_other(page, track)
        numbers_of_a_live_run_are_drawn_as_they_come(page)
        numbers_at_axes_differ_far_from_the_origin_in_charts_high_enough_to_read(page)
