"""An arm is led by hand in Run, in a real browser: its tool and its joints, on the plan, in 3-D and by sliders."""

import math

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from tests.hands import (
    CELL,
    keep,
    lead,
    near,
    now,
    opened,
    pick,
    restart,
    running,
    screen,
    shown,
    tab,
    tool_at,
    tool_rests,
    touch,
    touched,
    until,
)

pytestmark = pytest.mark.slow


def tool(tick) -> np.ndarray:
    """Return where the tool in the cell is, frame of its robot, shape (3,) [m]."""
    return np.array(tick["robots"]["r"]["arms"]["arm"]["tool"][:3])


def pointer_drags(page, begin, end):
    """Take what is at a place of the plan to another one, and hold it there [m]."""
    page.mouse.move(*screen(page, *begin))
    page.mouse.down()
    page.mouse.move(*screen(page, *end), steps=6)


def a_tool_follows_the_pointer_and_in_a_paused_run_waits_until_it_is_let_go(studio, page):
    touch(page, on=True)
    pointer_drags(page, tool_at(shown(studio, page)), (1.5, 2.3))
    until(studio, page, lambda tick: near(tool_at(tick), 1.5, 2.3))
    page.mouse.move(*screen(page, 1.6, 2.4))  # at a later tick, however slow the page is
    until(studio, page, lambda tick: near(tool_at(tick), 1.6, 2.4))
    page.mouse.up()
    page.get_by_role("button", name="Pause", exact=True).click()
    expect(page.locator(".run-state")).to_have_text("Paused")
    before = now(studio)["time"]
    pointer_drags(page, (1.6, 2.4), (1.7, 2.5))
    page.wait_for_timeout(300)  # longer than a target would take
    assert now(studio)["time"] == before
    page.mouse.up()
    until(studio, page, lambda tick: tick["time"] == pytest.approx(before + 0.1))
    page.get_by_role("button", name="Resume", exact=True).click()
    expect(page.locator(".run-state")).to_have_text("Running")
    until(studio, page, lambda tick: near(tool_at(tick), 1.7, 2.5))
    pick(page, tool_at(until(studio, page, tool_rests())), "Return control to its navigator")
    until(studio, page, lambda _: len(touched(studio)) == 3)
    dragged, placed, back = touched(studio)
    assert dragged["then"]
    assert "then" not in placed
    assert back["release"] == "r"


def a_joint_follows_its_slider(studio, page):
    tab(page, "Joints")
    slider = page.get_by_role("slider", name="joint1").locator("visible=true")
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 2, y)
    page.mouse.down()
    for part in (0.55, 0.6, 0.65, 0.7):
        page.mouse.move(box["x"] + part * box["width"], y)
        page.wait_for_timeout(100)  # so slowly that each is sent
    aim = float(slider.input_value())
    until(studio, page, lambda tick: abs(tick["joints"]["r/arm"]["joint1"][0] - aim) < 0.02)
    page.mouse.up()
    slid = touched(studio)[-1]
    assert math.radians(slid["then"][-1][1]) == pytest.approx(aim, abs=1e-3)


def a_tool_is_led_in_3d_along_an_axis_and_freely_and_that_is_kept(studio, page, canvas, file):
    before = tool(now(studio))
    lead(canvas, "arm", "z", (0, 10))
    until(studio, page, lambda tick: tool(tick)[2] < before[2] - 0.1)
    # Inverse kinematics begin where the joints shall be: on the way another posture may be found, or none.
    until(studio, page, tool_rests())
    lead(canvas, "arm", "", (8, 4))  # away from its base
    tab(page, "Events")
    expect(page.get_by_role("button", name="Keep 2 as events")).to_be_enabled()
    until(studio, page, tool_rests())  # what is led later would be another event
    keep(page, 2)
    down, aside = mjsim.load_world(file).run.events
    # Along z alone, to what the arm sags.
    assert np.allclose(down.tool[:2], before[:2], atol=5e-3)
    assert down.tool[2] < before[2] - 0.1
    assert np.linalg.norm(np.subtract(aside.tool, down.tool)) > 0.02


def test_an_arm_is_led_by_its_tool_and_by_its_joints(browser, tmp_path):
    with running(browser, tmp_path, CELL) as (studio, page):
        # What has no drive is not to be driven.
        expect(page.locator(".run-pad")).to_be_hidden()
        expect(page.locator(".run-advice")).to_be_hidden()
        a_tool_follows_the_pointer_and_in_a_paused_run_waits_until_it_is_let_go(studio, page)
        a_joint_follows_its_slider(studio, page)
        restart(studio, page)
        canvas = opened(page)
        a_tool_is_led_in_3d_along_an_axis_and_freely_and_that_is_kept(studio, page, canvas, tmp_path / "room.yaml")
