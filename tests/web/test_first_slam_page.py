"""From an empty folder to a first honest result of SLAM, as docs/studio-walk.md tells it."""

import runpy
from pathlib import Path

import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

WALK = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "make" / "first_slam.py"))
SECONDS = 4
"""Of the run whose figures are judged: the way to the first beacon and on."""


@pytest.mark.slow
def test_fifteen_clicks_lead_from_an_empty_folder_to_a_run_of_slam_that_is_honest(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        hand = WALK["Hand"](page)
        WALK["build"](hand, lambda _: None)
        WALK["start"](hand)
        assert hand.clicks <= 15
        expect(page.locator("#view-run .run-chart:not(.unknown)").first).to_be_visible()
    world = mjsim.load_world(tmp_path / "room.yaml")
    assert len({beacon.image for beacon in world.beacons}) == 4
    with mjsim.Simulation(world) as sim:
        recording = mjsim.run(sim, seconds=SECONDS, record=tmp_path / "run.mcap")
    figures = mjsim.statistics(recording)["robot"]
    assert figures["nees"]["mean"] < figures["nees"]["mean_band"][1]  # it does not claim more than it knows
    assert figures["landmark_error_m"]["count"] >= 1
    assert figures["landmark_error_m"]["false"] == 0
    assert figures["bumps"] == 0
