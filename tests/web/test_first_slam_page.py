"""From an empty folder to a first honest result of SLAM, as docs/studio-walk.md tells it."""

import runpy
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

import mjsim
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

WALK = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "make" / "first_slam.py"))
SECONDS = 4
"""Of the run whose figures are judged: the way to the first beacon and on."""


def what_is_set_for_a_run_is_kept_in_the_world_as_one_step(page: Page, file: Path) -> None:
    before, setup = file.read_text(), page.locator(".run-setup")
    setup.get_by_role("button", name="robot: Estimator").first.click()
    page.get_by_role("dialog").get_by_title("mjsim.algorithms.fastslam:FastSlam").click()
    setup.get_by_label("Duration", exact=True).fill("20")
    setup.get_by_label("Duration", exact=True).press("Enter")
    expect(setup.get_by_role("status")).to_contain_text("2")
    setup.get_by_role("button", name="Keep in the world").click()
    expect(setup.get_by_role("status")).to_have_count(0)
    saved = kept(page, file)
    assert "FastSlam" in saved
    assert "seconds: 20" in saved
    page.get_by_role("button", name="Undo (Ctrl+Z)").click()
    assert kept(page, file) == before


def kept(page: Page, file: Path) -> str:
    with page.expect_response("**/api/save"):
        page.keyboard.press("Control+s")
    expect(page.locator(".world .dot")).to_be_hidden()
    return file.read_text()


def maps_grow_by_a_button(page: Page) -> None:
    page.get_by_role("tab", name="Edit", exact=True).click()
    page.locator("#view-edit .plan").focus()
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    panel = page.locator(".panel")
    panel.locator("summary", has_text="Run").click()
    panel.locator("summary", has_text="Modules").click()
    panel.get_by_label("New entry of Run: Modules").fill("second")
    panel.get_by_role("button", name="Add", exact=True).first.click()
    expect(page.locator(".cm-content")).to_contain_text("second: {}")


@pytest.mark.slow
def test_fifteen_clicks_lead_from_an_empty_folder_to_a_run_of_slam_that_is_honest(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        hand = WALK["Hand"](page)
        WALK["build"](hand, lambda _: None)
        world = mjsim.load_world(tmp_path / "room.yaml")
        WALK["start"](hand)
        assert hand.clicks <= 15
        expect(page.locator("#view-run .run-chart:not(.unknown)").first).to_be_visible()
        page.get_by_role("button", name="Stop the run").click()
        what_is_set_for_a_run_is_kept_in_the_world_as_one_step(page, tmp_path / "room.yaml")
        maps_grow_by_a_button(page)
    assert len({beacon.image for beacon in world.beacons}) == 4
    with mjsim.Simulation(world) as sim:
        recording = mjsim.run(sim, seconds=SECONDS, record=tmp_path / "run.mcap")
    figures = mjsim.statistics(recording)["robot"]
    assert figures["nees"]["mean"] < figures["nees"]["mean_band"][1]  # it does not claim more than it knows
    assert figures["landmark_error_m"]["count"] >= 1
    assert figures["landmark_error_m"]["false"] == 0
    assert figures["bumps"] == 0
