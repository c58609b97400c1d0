"""Joints of loops and ball joints are led by hand on the plan, in 3-D and by sliders, in a real browser."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.web.run.jointed import grips_json
from tests.browser import browser as listener
from tests.web.test_joints_page import keep, running
from tests.web.test_lead_solids_page import lead, opened
from tests.web.test_studio_touch_page import drag, screen, until
from tests.windows import PATIENCE

pytestmark = pytest.mark.slow
HALL = """\
mjsim: 1
name: hall
walls: [{points: [[0, 0], [8, 0], [8, 5], [0, 5]], closed: true}]
mechanisms:
  - name: bars                                 # lies level: its weight does not move it
    at: [1.5, 1]
    elevation: 0.3
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: coupler, rod: [3.5, 0.05]}, {name: rocker, rod: [3.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 0, 1], start_deg: 60, damping: 20}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker], near_deg: 100}
      - {revolute: q5, of: [coupler.end, rocker.end]}
    ACTUATORS
  - name: bell
    at: [6.5, 2]
    elevation: 1.5
    bodies: [{name: rod, rod: [1.0, 0.05], mass: 2}]
    joints: [{spherical: knot, of: [ground, rod], start_deg: [0, 90, 0]}]
  - name: truss                                # a triangle, which nothing moves
    at: [6, 4]
    bodies: [{name: left, rod: [0.7, 0.05]}, {name: right, rod: [0.7, 0.05]}]
    joints:
      - {revolute: t1, of: [ground, left], axis: [0, 0, 1], near_deg: 45}
      - {revolute: t2, of: [left.end, right.end], near_deg: 90}
      - {revolute: t3, of: [{ground: [1, 0, 0]}, right]}
run: {seconds: 1000, rate_hz: 10}
"""
FREE = HALL.replace("ACTUATORS", "")
DRIVEN = HALL.replace("ACTUATORS", "actuators: [{angle: q2, signal: {constant: {value_deg: 60}}}]")


def degrees(tick, mechanism, *joints) -> np.ndarray:
    """Return where joints are [deg]."""
    return np.degrees([tick["joints"][mechanism][joint][0] for joint in joints])


def rod(tick) -> np.ndarray:
    """Return where the rod of the bell points, a unit vector."""
    vector = [tick["joints"]["bell"][f"knot.r{axis}"][0] for axis in "xyz"]
    return Rotation.from_rotvec(vector).apply([1, 0, 0])


def grip(tick, name) -> dict[str, np.ndarray]:
    """Return where the handle of a joint and the joint are on the plan [m]."""
    (found,) = (each for each in tick["grips"] if each["joint"] == name)
    return {key: np.array(found[key][:2]) for key in ("grip", "at")}


def handle_at(joint, to_deg) -> np.ndarray:
    """Return where the handle of a joint of the bars is on the plan once the joint is at a value [m]."""
    world = mjsim.parse_world(FREE)
    with mjsim.Simulation(world) as sim:
        sim.lead("bars", joint, float(to_deg))
        for _ in range(24):
            sim.step()
        grips = grips_json(world, {"bars": sim.motions()["bars"].positions}, {})
    return grip({"grips": grips}, joint)["grip"]


def now(studio) -> dict:
    """Return the newest tick."""
    with listener(studio.url) as watcher:
        return watcher.until("tick")


def shot(page, name) -> None:
    """Keep a picture for who wants to look at it."""
    if folder := os.environ.get("MJSIM_TEST_PICTURES"):
        page.screenshot(path=Path(folder) / f"{name}.png")


def test_a_quick_flick_takes_a_joint_of_a_loop_all_the_way(browser, tmp_path):
    with running(browser, tmp_path, FREE) as (studio, page):
        tick = now(studio)
        page.get_by_role("button", name="Touch: drag").click()
        there = handle_at("q5", degrees(tick, "bars", "q5")[0] + 40)  # more than one step of 20 degrees
        drag(page, grip(tick, "q5")["grip"], there)
        away = [now(studio)["time"]]

        def rests(tick):
            """Return whether it has been there for a second: it swings past it first."""
            if np.abs(grip(tick, "q5")["grip"] - there).max() > 0.02:
                away.append(tick["time"])
            return tick["time"] > away[-1] + 1.0

        until(studio, page, rests)


def test_a_loop_and_a_ball_are_led_on_the_plan_in_3d_and_by_fields(browser, tmp_path):
    with running(browser, tmp_path, FREE) as (studio, page):
        tick = now(studio)
        page.get_by_role("button", name="Touch: drag").click()
        # q5 is where the loop is cut: the physics has no joint there.
        begin, handle = degrees(tick, "bars", "q5")[0], grip(tick, "q5")
        # Its axis moves with it: it comes nearer step by step, while it is held.
        page.mouse.move(*screen(page, *handle["grip"]))
        page.mouse.down()
        page.mouse.move(*screen(page, *handle_at("q5", begin + 15)), steps=3)
        until(studio, page, lambda tick: abs(degrees(tick, "bars", "q5")[0] - begin - 15) < 1)
        page.mouse.up()
        # The rod hangs: its handle is below its joint, and goes aside on a sphere.
        handle = grip(tick, "knot")
        np.testing.assert_allclose(handle["grip"], handle["at"], atol=0.06)
        drag(page, handle["at"], handle["at"] + (0.4, 0.3))
        until(studio, page, lambda tick: np.abs(rod(tick)[:2] - (0.4, 0.3)).max() < 0.07 and rod(tick)[2] < 0)
        shot(page, "loops-plan")
        page.get_by_role("button", name="Touch: drag").click()
        canvas = opened(page)
        before = rod(now(studio))
        lead(canvas, "knot", "", (0, -60))
        until(studio, page, lambda tick: rod(tick)[2] > before[2] + 0.2)
        shot(page, "loops-3d")
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        page.get_by_label("knot.rz, °").fill("-40")
        page.get_by_label("knot.rz, °").press("Enter")
        until(studio, page, lambda tick: abs(degrees(tick, "bell", "knot.rz")[0] + 40) < 1)
        page.get_by_label("q4, °").fill("110")
        page.get_by_label("q4, °").press("Enter")
        page.get_by_role("button", name="Let go of q5").click()
        until(studio, page, lambda tick: abs(degrees(tick, "bars", "q4")[0] - 110) < 0.5)
        said = page.locator("#view-run .run-side").get_by_text("truss: t1, t2, t3 cannot be led by hand")
        expect(said).to_contain_text("they do not move")
        shot(page, "loops-joints")
        page.get_by_role("button", name="Let go of knot.rz").click()
        until(studio, page, lambda tick: rod(tick)[2] < -0.5)
        page.get_by_role("button", name="Stop the run").click()
        expect(page.locator(".run-state")).to_have_text("Ended", timeout=PATIENCE)
        keep(page, 7)
    world = mjsim.load_world(tmp_path / "room.yaml")
    assert [event.joint for event in world.run.events] == ["q5", "knot", "knot", "knot.rz", "q4", "q5", "knot.rz"]


def test_a_joint_that_a_motion_moves_through_a_loop_is_led_by_that_motion_and_refused_where_the_loop_ends(
    browser, tmp_path
):
    with running(browser, tmp_path, DRIVEN) as (studio, page):
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        page.get_by_label("q4, °").fill("110")
        page.get_by_label("q4, °").press("Enter")
        until(studio, page, lambda tick: abs(degrees(tick, "bars", "q4")[0] - 110) < 0.1)
        q2 = math.radians(degrees(now(studio), "bars", "q2")[0])
        # The coupler is as long as it is.
        ends = np.array(
            [[math.cos(q2), math.sin(q2)], [4 + 3 * math.cos(math.radians(110)), 3 * math.sin(math.radians(110))]]
        )
        assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(3.5, abs=0.01)
        page.get_by_label("q4, °").fill("20")
        page.get_by_label("q4, °").press("Enter")
        expect(page.locator(".toasts")).to_contain_text("Mechanism 'bars' locks: with 'q4' at", timeout=PATIENCE)
        page.get_by_role("button", name="Return q4 to its signal").click()
        until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - 60) < 0.1)
