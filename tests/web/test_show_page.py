"""What modules show, and any number of a recording, in a real browser."""

import csv
import time
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
COLOR = "#ff00fe"
NAME = "<img src=x onerror=document.title='owned'>"
COUNT = """() => [...document.querySelectorAll('.run-floor canvas')].reduce((sum, canvas) => {
  const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  for (let k = 0; k < data.length; k += 4) sum += data[k] > 240 && data[k + 1] < 10 && data[k + 2] > 240;
  return sum;
}, 0)"""


class Showing:
    """Stands still, and shows a path of an odd name."""

    def start(self, robot, catalogue, rng):
        self.prior = robot.prior

    def update(self, seen):
        line = mjsim.ShownLines(name=NAME, points=[[-1, -1], [1, 1]], width=0.2, color=COLOR)
        return mjsim.Estimate(self.prior, 0.01 * np.eye(3), show=(line,))


@pytest.fixture
def review(browser, tmp_path):
    """The Review view with a recording open; the page and the recording."""
    (tmp_path / "out").mkdir()
    path = tmp_path / "out" / "run.mcap"
    world = mjsim.parse_world("robots: [{name: scout, at: [0, 0]}]\nwalls: [{points: [[-2, -2], [2, -2], [2, 2]]}]")
    with mjsim.Simulation(world) as sim:
        recording = mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=Showing())}, seconds=0.8, record=path)
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        page.locator("[data-path='out/run.mcap']").click()
        expect(page.locator(".run-time")).to_contain_text("of 0.76 s", timeout=PATIENCE)
        yield page, recording


def until_drawn(page, *, drawn):
    """Wait until the line is on the plan, or is not."""
    until = time.monotonic() + PATIENCE / 1000
    while (page.evaluate(COUNT) > 50) != drawn:
        assert time.monotonic() < until
        page.wait_for_timeout(50)  # the page goes on meanwhile


def what_an_estimator_shows_is_drawn_and_switched_off_by_its_name_which_is_no_markup(review):
    page, _ = review
    until_drawn(page, drawn=True)
    page.get_by_label("What is shown").first.click()
    box = page.get_by_role("checkbox", name=NAME)
    expect(box).to_be_checked(timeout=PATIENCE)
    box.uncheck()
    until_drawn(page, drawn=False)
    page.keyboard.press("Escape")
    page.get_by_title("View in 3-D").locator("visible=true").click()
    scene = page.locator(".scene-canvas").locator("visible=true")
    drawn = int(scene.get_attribute("data-thoughts", timeout=PATIENCE) or 0)
    page.get_by_label("What is shown").first.click()
    assert page.title() != "owned"
    page.get_by_role("checkbox", name=NAME).check()
    until_drawn(page, drawn=True)
    expect(scene).to_have_attribute("data-thoughts", str(drawn + 1), timeout=PATIENCE)


def any_number_is_found_drawn_kept_and_given_away_as_csv(review):
    page, recording = review
    page.get_by_role("tab", name="Plot", exact=True).click()
    page.get_by_label("Search topics and fields").fill("observation forward")
    page.get_by_role("button", name="/scout/observation.odometry.forward", exact=True).click()
    the_message_of_a_topic_is_a_table_with_units(page)
    expect(page.locator(".plotter-chart .run-chart")).to_have_count(1, timeout=PATIENCE)
    chart = page.locator(".plotter-chart .run-chart")
    chart.get_by_label("Save as a file").click()
    with page.expect_download(timeout=PATIENCE) as waiting:
        chart.get_by_role("button", name="CSV").click()
    head, *rows = csv.reader(Path(waiting.value.path()).read_text().splitlines())
    assert head == ["time [s]", "/scout/observation.odometry.forward"]
    told = [seen.odometry.forward for seen in recording.observations("scout")]
    np.testing.assert_allclose([float(value) for _, value in rows], told, atol=1e-9)
    page.reload()
    page.get_by_role("tab", name="Recordings", exact=True).click()
    page.locator("[data-path='out/run.mcap']").click()
    expect(page.locator(".plotter-chart .run-chart")).to_have_count(1, timeout=PATIENCE)


def a_layer_takes_a_colour_that_is_kept(review):
    page, _ = review
    page.reload()
    page.locator("[data-path='out/run.mcap']").click()
    page.get_by_label("What is shown").first.click()
    for name in (NAME, "Estimate", "Odometry"):
        page.get_by_role("checkbox", name=name).uncheck()
    until_drawn(page, drawn=False)
    for wanted in (COLOR, "#0072b2"):
        page.get_by_label("Colour of Truth").fill(wanted)
        until_drawn(page, drawn=wanted == COLOR)
    assert "0072b2" in page.evaluate("localStorage.getItem('mjsim.displays')")


def the_message_of_a_topic_is_a_table_with_units(page):
    topic = page.locator(".topic", has_text="/scout/observation")
    expect(topic.locator("summary")).to_contain_text("mjsim.Observation")
    topic.get_by_role("button", name="Message").click()
    expect(topic.get_by_role("row", name="odometry.turn")).to_contain_text("rad")


def a_list_of_hidden_names_that_cannot_be_read_is_as_if_there_were_none(review):
    page, _ = review
    for kept in ("{", '{"a": 1}', "7"):
        page.evaluate("kept => localStorage.setItem('mjsim.plan.hidden', kept)", kept)
        page.reload()
        page.get_by_role("tab", name="Run", exact=True).click()
        expect(page.locator("#view-run .run-floor").first).to_be_visible()


def test_what_is_shown_and_any_number_are_found_drawn_and_kept(review):
    any_number_is_found_drawn_kept_and_given_away_as_csv(review)
    what_an_estimator_shows_is_drawn_and_switched_off_by_its_name_which_is_no_markup(review)
    a_layer_takes_a_colour_that_is_kept(review)
    a_list_of_hidden_names_that_cannot_be_read_is_as_if_there_were_none(review)
