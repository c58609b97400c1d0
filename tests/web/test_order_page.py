"""The world that was chosen last runs, and pictures have the shape of their own camera, in a real browser."""

import pytest
from playwright.sync_api import expect

from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
robots:
  - name: scout
    at: [0, 0]
    sensors:
      - {camera: eye, at: [0.15, 0, 0.35], width: 320, height: 240, fov_deg: 60, rate_hz: 5}
      - {camera: eye2, at: [0.15, 0, 0.35], width: 320, height: 80, fov_deg: 60, rate_hz: 5}
run: {seconds: 1000, drivers: {scout: {}}}
"""


def ratio(page, camera):
    """Return the aspect ratio of the frame of a camera's pictures."""
    frame = page.locator(f"#view-run [data-view='scout/{camera}'] .run-picture")
    return frame.evaluate("frame => frame.style.aspectRatio")


def start(page):
    page.get_by_role("button", name="Start", exact=True).click()


def each_picture_has_the_shape_of_its_own_camera(page):
    start(page)
    expect(page.locator(".run-state")).to_have_text("Running")
    assert (ratio(page, "eye"), ratio(page, "eye2")) == ("320 / 240", "320 / 80")
    page.get_by_role("button", name="Stop the run").click()
    expect(page.locator(".run-state")).to_have_text("Ended")


def a_world_that_opens_late_is_the_one_that_start_begins_and_leaves_the_person_where_they_went(page, run):
    held = []
    page.route("**/api/open", lambda route: held.append(route))
    page.keyboard.press("Control+o")
    with page.expect_request("**/api/open"):
        page.get_by_role("dialog").get_by_role("button", name="other.yaml").click()
    run.click()
    start(page)
    held[0].continue_()
    expect(page.locator(".run-state")).to_have_text("Running")
    expect(run).to_have_attribute("aria-selected", "true")
    assert (ratio(page, "eye"), ratio(page, "eye2")) == ("320 / 160", "320 / 80")


def test_what_was_chosen_last_runs_and_has_the_shapes_of_its_own_cameras(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    (tmp_path / "room.yaml").write_text(ROOM)
    (tmp_path / "other.yaml").write_text(ROOM.replace("height: 240", "height: 160"))
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        run = page.get_by_role("tab", name="Run", exact=True)
        run.click()
        each_picture_has_the_shape_of_its_own_camera(page)
        a_world_that_opens_late_is_the_one_that_start_begins_and_leaves_the_person_where_they_went(page, run)
