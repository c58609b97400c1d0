"""What was chosen last is shown, and pictures have the shape of their own camera, in a real browser."""

import pytest
from playwright.sync_api import expect

import mjsim
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
run: {seconds: SECONDS, drivers: {scout: {}}}
"""


def test_a_recording_that_comes_late_does_not_take_the_place_of_the_one_chosen_after_it(browser, tmp_path):
    for name, seconds in (("slow", 1), ("quick", 2)):
        with mjsim.Simulation(mjsim.parse_world(ROOM.replace("SECONDS", str(seconds)))) as sim:
            mjsim.run(sim, record=tmp_path / f"{name}.mcap")
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        held = []
        page.route("**/api/recording?*slow*", lambda route: held.append(route))
        page.locator("#view-review [data-path='slow.mcap']").click()
        page.locator("#view-review [data-path='quick.mcap']").click()
        shown = page.locator("#view-review .run-time")
        expect(shown).to_contain_text("of 1.96 s", timeout=PATIENCE)
        with page.expect_response("**/api/recording?*slow*", timeout=PATIENCE) as late:
            held[0].continue_()
        assert late.value.ok
        late.value.body()
        page.wait_for_timeout(300)  # it would be taken up in this time
        expect(shown).to_contain_text("of 1.96 s")
        expect(page.locator("#view-review .review-title")).to_have_text("quick.mcap")


def test_each_picture_has_the_shape_of_its_own_camera_in_each_world(browser, tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM.replace("SECONDS", "1000"))
    (tmp_path / "other.yaml").write_text(ROOM.replace("SECONDS", "1000").replace("height: 240", "height: 160"))
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()

        def ratio(camera):
            """Return the aspect ratio of the frame of a camera's pictures."""
            return page.locator(f"#view-run [data-view='scout/{camera}'] .run-picture").evaluate(
                "frame => frame.style.aspectRatio"
            )

        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        assert (ratio("eye"), ratio("eye2")) == ("320 / 240", "320 / 80")
        page.get_by_role("button", name="Stop the run").click()
        expect(page.locator(".run-state")).to_have_text("Ended", timeout=PATIENCE)
        page.keyboard.press("Control+o")
        page.get_by_role("dialog").get_by_role("button", name="other.yaml").click()
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        assert (ratio("eye"), ratio("eye2")) == ("320 / 160", "320 / 80")


def test_a_world_that_opens_late_is_the_one_that_start_begins_and_leaves_the_person_where_they_went(browser, tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM.replace("SECONDS", "1000"))
    (tmp_path / "other.yaml").write_text(ROOM.replace("SECONDS", "1000").replace("height: 240", "height: 160"))
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        run = page.get_by_role("tab", name="Run", exact=True)
        run.click()
        held = []
        page.route("**/api/open", lambda route: held.append(route))
        page.keyboard.press("Control+o")
        with page.expect_request("**/api/open"):
            page.get_by_role("dialog").get_by_role("button", name="other.yaml").click()
        run.click()
        page.get_by_role("button", name="Start", exact=True).click()
        held[0].continue_()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        expect(run).to_have_attribute("aria-selected", "true")
        frame = page.locator("#view-run [data-view='scout/eye'] .run-picture")
        assert frame.evaluate("frame => frame.style.aspectRatio") == "320 / 160"
