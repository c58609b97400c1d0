"""The NEES chart in a real browser: it judges what an estimator claims, and says so where nothing can be judged."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
TEXT = "{http://www.w3.org/2000/svg}text"
NUMBER = re.compile("[-\N{MINUS SIGN}]?[0-9.]+")
ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0], odometry: {noise: {distance: 0, turn: 0}}}]
run:
  seconds: 2
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}
  events: [{time: 1, move: scout, to: [-1, -1]}]
"""


class Claiming:
    """Believes that the robot stands where it started, with the same covariance at all times."""

    def __init__(self, variance):
        self._covariance = variance * np.eye(3)

    def start(self, robot, catalogue, rng):
        self._prior = robot.prior

    def update(self, seen):
        return mjsim.Estimate(self._prior, self._covariance)


def recorded(place, variance=None):
    """Record a run; without a variance it has no estimator."""
    world = mjsim.parse_world(ROOM)
    with mjsim.Simulation(world, seed=1) as sim:
        drivers = None if variance is None else {"scout": mjsim.Driver(estimator=Claiming(variance))}
        return mjsim.run(sim, drivers=drivers, record=place)


def opened(page, name):
    """Open a recording in Review, and return its NEES chart."""
    page.get_by_role("tab", name="Review", exact=True).click()
    page.locator(f"[data-path='{name}']").click()
    expect(page.locator("#view-review .review-title")).to_have_text(name, timeout=PATIENCE)
    return page.locator("#view-review .run-chart", has_text="NEES")


def why(chart):
    """Return what an empty chart says."""
    expect(chart).to_have_class("run-chart unknown")
    return chart.locator(".run-chart-box").evaluate("box => getComputedStyle(box, '::after').content")


def without_an_estimator_the_chart_says_that_there_is_nothing_to_judge(page):
    assert "No estimator" in why(opened(page, "none.mcap"))
    assert "singular" in why(opened(page, "zero.mcap"))
    expect(opened(page, "tiny.mcap")).to_have_class("run-chart")


def a_run_without_an_estimator_says_so_while_it_goes(page):
    page.get_by_role("tab", name="Run", exact=True).click()
    run = page.locator("#view-run")
    run.get_by_role("button", name="Start", exact=True).click()
    expect(run.locator(".run-state")).to_have_text("Ended")
    expect(run.locator(".run-chart-box[data-empty^='No estimator']")).to_be_visible()
    page.reload()  # a page that comes later is told the same
    expect(run.locator(".run-chart-box[data-empty^='No estimator']")).to_be_visible()


def bounds_that_know_nothing_leave_the_error_to_be_seen(page):
    """A variance of 1e30 m^2 has bounds at 2e15 m: the axis goes to ten times the error, which is at least 1 m."""
    opened(page, "vast.mcap")
    chart = page.locator("#view-review .run-chart", has_text="x error")
    with page.expect_download(timeout=PATIENCE) as download:
        chart.get_by_label("Save as a file").click()
        chart.get_by_role("button", name="SVG").click()
    texts = [each.text for each in ElementTree.fromstring(download.value.path().read_bytes()).iter(TEXT)]
    levels = [float(text.replace("\N{MINUS SIGN}", "-")) for text in texts if NUMBER.fullmatch(text)]
    assert 5 <= max(levels) <= 15
    assert -15 <= min(levels) <= -5


def test_what_cannot_be_judged_is_said_and_wide_bounds_leave_the_error_to_be_seen(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    (tmp_path / "room.yaml").write_text(ROOM)
    recorded(tmp_path / "none.mcap")
    for name, variance in (("zero", 0.0), ("vast", 1e30), ("tiny", 1e-20)):
        recorded(tmp_path / f"{name}.mcap", variance)
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        a_run_without_an_estimator_says_so_while_it_goes(page)
        without_an_estimator_the_chart_says_that_there_is_nothing_to_judge(page)
        bounds_that_know_nothing_leave_the_error_to_be_seen(page)
