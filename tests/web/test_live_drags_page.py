"""What is dragged in a run follows while the drag goes on, in a real browser; of robots a ghost is shown."""

import math
import re

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from tests.web.test_joints_page import keep, running
from tests.web.test_lead_loops_page import FREE, degrees, now, shot
from tests.web.test_lead_solids_page import opened
from tests.web.test_studio_touch_page import CELL, HALL, near, screen, tool_at, until
from tests.windows import PATIENCE

pytestmark = pytest.mark.slow


def grip(tick, name) -> dict[str, np.ndarray]:
    """Return where the handle of a joint and its joint are on the plan [m]."""
    (found,) = (each for each in tick["grips"] if each["joint"] == name)
    return {key: np.array(found[key][:2]) for key in ("grip", "at")}


def turned(handle, angle) -> np.ndarray:
    """Return where a handle is on the plan once its joint was turned [m, deg]."""
    cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return handle["at"] + np.array([[cos, -sin], [sin, cos]]) @ (handle["grip"] - handle["at"])


def pull(page, handle, begin, end) -> None:
    """Move the pointer with the handle of a joint from angle to angle [deg]."""
    for angle in np.linspace(begin, end, 8).tolist():
        page.mouse.move(*screen(page, *turned(handle, angle)))
        page.wait_for_timeout(60)  # a hand moves so fast


def test_a_joint_follows_the_pointer_goes_back_with_escape_and_the_drag_is_one_event(browser, tmp_path):
    with running(browser, tmp_path, FREE) as (studio, page):
        page.get_by_role("button", name="Touch: drag").click()
        tick = now(studio)
        begin, handle = degrees(tick, "bars", "q2")[0], grip(tick, "q2")
        page.mouse.move(*screen(page, *handle["grip"]))
        page.mouse.down()
        pull(page, handle, 0, 25)
        # It is there while it is held, and nothing was told of its end.
        until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - begin - 25) < 2)
        shot(page, "drag-held")
        pull(page, handle, 25, 40)
        until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - begin - 40) < 2)
        page.keyboard.press("Escape")
        page.mouse.up()
        until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - begin) < 2)
        page.get_by_role("tab", name="Events").locator("visible=true").click()
        rows = page.locator(".run-events li").locator("visible=true")
        expect(rows).to_have_count(1)
        expect(rows).to_contain_text(re.compile(r"joint q2 of bars goes to [\d.]+, through \d+ targets in [\d.]+ s"))
        page.get_by_role("button", name="Stop the run").click()
        expect(page.locator(".run-state")).to_have_text("Ended", timeout=PATIENCE)
        keep(page, 1)
    (event,) = mjsim.load_world(tmp_path / "room.yaml").run.events
    assert len(event.then) >= 4
    assert event.then[-1][1] == pytest.approx(begin, abs=0.5)


def test_a_tool_follows_on_the_plan_and_its_joints_by_sliders_and_a_paused_run_waits_until_it_is_let_go(
    browser, tmp_path
):
    with running(browser, tmp_path, CELL) as (studio, page):
        page.get_by_role("button", name="Touch: drag").click()
        start = tool_at(now(studio))
        page.mouse.move(*screen(page, *start))
        page.mouse.down()
        page.mouse.move(*screen(page, 1.6, 2.4), steps=6)
        until(studio, page, lambda tick: near(tool_at(tick), 1.6, 2.4))
        page.mouse.up()
        page.get_by_role("button", name="Pause", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Paused", timeout=PATIENCE)
        before = now(studio)["time"]
        page.mouse.move(*screen(page, 1.6, 2.4))
        page.mouse.down()
        page.mouse.move(*screen(page, 1.7, 2.5), steps=6)
        page.wait_for_timeout(500)  # longer than a target would take
        assert now(studio)["time"] == before
        page.mouse.up()
        until(studio, page, lambda tick: tick["time"] == pytest.approx(before + 0.1))
        page.get_by_role("button", name="Resume", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        slider = page.get_by_role("slider", name="joint1").locator("visible=true")
        box = slider.bounding_box()
        y = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + box["width"] / 2, y)
        page.mouse.down()
        for part in (0.55, 0.6, 0.65, 0.7):
            page.mouse.move(box["x"] + part * box["width"], y)
            page.wait_for_timeout(120)  # so slowly that each is sent
        aim = float(slider.input_value())
        until(studio, page, lambda tick: abs(tick["joints"]["r/arm"]["joint1"][0] - aim) < 0.02)
        page.mouse.up()
        keep(page, 3)
    dragged, placed, slid = mjsim.load_world(tmp_path / "room.yaml").run.events
    assert dragged.then
    assert placed.then is None
    assert math.radians(slid.then[-1][1]) == pytest.approx(aim, abs=1e-3)


def test_a_robot_is_dragged_in_3d_with_a_ghost_and_put_there_when_it_is_let_go(browser, tmp_path):
    with running(browser, tmp_path, HALL) as (studio, page):
        canvas = opened(page)
        expect(canvas).to_have_attribute("data-moments", re.compile(r"\d"), timeout=PATIENCE)
        page.locator("#view-run .scene-bar select").locator("visible=true").last.select_option("scout/base")
        box = canvas.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2 - 5
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y - 20)
        page.mouse.move(x + 120, y - 40)
        expect(canvas).to_have_attribute("data-ghost", "scout")
        note = page.locator("#view-run .scene-notes span")
        expect(note).to_have_text(re.compile(r"^scout  [\d.]+, [\d.]+$"))
        shot(page, "ghost-3d")
        aim = [float(value) for value in note.inner_text().removeprefix("scout").split(",")]
        assert near(now(studio)["robots"]["scout"]["truth"], 1, 1.5)
        page.mouse.up()
        expect(canvas).not_to_have_attribute("data-ghost", "scout")
        until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], *aim))
        keep(page, 1)
    (event,) = mjsim.load_world(tmp_path / "room.yaml").run.events
    assert event.move == "scout"
