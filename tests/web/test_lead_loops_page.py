"""Joints of loops and ball joints are led by hand on the plan, in 3-D and by sliders, in a real browser."""

import math
import re

import numpy as np
import pytest
from playwright.sync_api import expect
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.web.run.jointed import grips_json
from tests.hands import drag, grip, lead, now, opened, restart, running, screen, tab, touch, touched, until

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
  - name: links                                # as the bars, a quarter of their size, and driven
    at: [6.3, 0.3]
    elevation: 0.3
    bodies: [{name: crank, rod: [0.25, 0.02]}, {name: coupler, rod: [0.875, 0.02]}, {name: rocker, rod: [0.75, 0.02]}]
    joints:
      - {revolute: p2, of: [ground, crank], axis: [0, 0, 1], start_deg: 60}
      - {revolute: p3, of: [crank.end, coupler]}
      - {revolute: p4, of: [{ground: [1, 0, 0]}, rocker], near_deg: 100}
      - {revolute: p5, of: [coupler.end, rocker.end]}
    actuators: [{angle: p2, signal: {constant: {value_deg: 60}}}]
run: {seconds: 1000, rate_hz: 10}
"""


def degrees(tick, mechanism, *joints) -> np.ndarray:
    """Return where joints are [deg]."""
    return np.degrees([tick["joints"][mechanism][joint][0] for joint in joints])


def rod(tick) -> np.ndarray:
    """Return where the rod of the bell points, a unit vector."""
    vector = [tick["joints"]["bell"][f"knot.r{axis}"][0] for axis in "xyz"]
    return Rotation.from_rotvec(vector).apply([1, 0, 0])


def handle_at(joint, to_deg) -> np.ndarray:
    """Return where the handle of a joint of the bars is on the plan once the joint is at a value [m]."""
    world = mjsim.parse_world(HALL)
    with mjsim.Simulation(world) as sim:
        sim.lead("bars", joint, float(to_deg))
        for _ in range(24):
            sim.step()
        grips = grips_json(world, {"bars": sim.motions()["bars"].positions}, {})
    return grip({"grips": grips}, joint)["grip"]


def turned(handle, angle) -> np.ndarray:
    """Return where a handle is on the plan once its joint was turned [m, deg]."""
    cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return handle["at"] + np.array([[cos, -sin], [sin, cos]]) @ (handle["grip"] - handle["at"])


def pull(page, handle, begin, end) -> None:
    """Move the pointer with the handle of a joint from angle to angle [deg]."""
    for angle in np.linspace(begin, end, 5).tolist():
        page.mouse.move(*screen(page, *turned(handle, angle)))
        page.wait_for_timeout(100)  # a hand moves so fast: each target is sent


def put(page, joint, value) -> None:
    """Type the value of a joint [deg]."""
    field = page.get_by_label(f"{joint}, °")
    field.fill(value)
    field.press("Enter")


def a_joint_follows_the_pointer_goes_back_with_escape_and_the_drag_is_one_event(studio, page):
    touch(page, on=True)
    tick = now(studio)
    begin, handle = degrees(tick, "bars", "q2")[0], grip(tick, "q2")
    page.mouse.move(*screen(page, *handle["grip"]))
    page.mouse.down()
    pull(page, handle, 0, 25)
    # It is there while it is held, and nothing was told of its end.
    until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - begin - 25) < 2)
    pull(page, handle, 25, 40)
    until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - begin - 40) < 2)
    page.keyboard.press("Escape")
    page.mouse.up()
    until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - begin) < 2)
    tab(page, "Events")
    # After a second of rest, a list of what happened begins another row.
    row = page.locator(".run-events li").locator("visible=true").last
    expect(row).to_contain_text(re.compile(r"joint q2 of bars goes to [\d.]+, through \d+ targets in [\d.]+ s"))
    (event,) = touched(studio)
    assert len(event["then"]) >= 4
    assert event["then"][-1][1] == pytest.approx(begin, abs=0.5)


def a_quick_flick_takes_a_joint_of_a_loop_all_the_way(studio, page):
    tick = now(studio)
    touch(page, on=True)
    there = handle_at("q5", degrees(tick, "bars", "q5")[0] + 40)  # more than one step of 20 degrees
    drag(page, grip(tick, "q5")["grip"], there)
    away = [now(studio)["time"]]

    def rests(tick):
        """Return whether it has been there for half a second: it swings past it first."""
        if np.abs(grip(tick, "q5")["grip"] - there).max() > 0.02:
            away.append(tick["time"])
        return tick["time"] > away[-1] + 0.5

    until(studio, page, rests)


def a_loop_and_a_ball_are_led_on_the_plan(studio, page):
    tick = now(studio)
    touch(page, on=True)
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


def a_ball_is_led_in_3d(studio, page):
    touch(page, on=False)
    canvas = opened(page)
    before = rod(now(studio))
    lead(canvas, "knot", "", (0, -60))
    until(studio, page, lambda tick: rod(tick)[2] > before[2] + 0.2)
    page.locator("#view-run").get_by_title("View in 3-D").click()  # what comes does without


def both_are_led_by_fields_and_let_go(studio, page):
    tab(page, "Joints")
    put(page, "knot.rz", "-40")
    until(studio, page, lambda tick: abs(degrees(tick, "bell", "knot.rz")[0] + 40) < 1)
    put(page, "q4", "110")
    page.get_by_role("button", name="Let go of q5").click()
    until(studio, page, lambda tick: abs(degrees(tick, "bars", "q4")[0] - 110) < 0.5)
    said = page.locator("#view-run .run-side").get_by_text("truss: t1, t2, t3 cannot be led by hand")
    expect(said).to_contain_text("they do not move")
    page.get_by_role("button", name="Let go of knot.rz").click()
    until(studio, page, lambda tick: rod(tick)[2] < -0.5)
    joints = [event["joint"] for event in touched(studio)]
    assert joints == ["q5", "knot", "knot", "knot.rz", "q4", "q5", "knot.rz"]


def a_joint_that_a_motion_moves_through_a_loop_is_led_by_that_motion_and_refused_where_the_loop_ends(studio, page):
    put(page, "p4", "110")
    tick = until(studio, page, lambda tick: abs(degrees(tick, "links", "p4")[0] - 110) < 0.1)
    p2, p4 = np.radians(degrees(tick, "links", "p2", "p4"))
    # The coupler is as long as it is.
    ends = np.array([[math.cos(p2), math.sin(p2)], [4 + 3 * math.cos(p4), 3 * math.sin(p4)]])
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(3.5, abs=0.01)
    put(page, "p4", "20")
    expect(page.locator(".toasts")).to_contain_text("Mechanism 'links' locks: with 'p4' at")
    page.get_by_role("button", name="Return p4 to its signal").click()
    until(studio, page, lambda tick: abs(degrees(tick, "links", "p2")[0] - 60) < 0.1)


def test_joints_of_loops_and_balls_are_led_by_hand(browser, tmp_path):
    with running(browser, tmp_path, HALL) as (studio, page):
        a_joint_follows_the_pointer_goes_back_with_escape_and_the_drag_is_one_event(studio, page)
        restart(studio, page)
        a_quick_flick_takes_a_joint_of_a_loop_all_the_way(studio, page)
        restart(studio, page)
        a_loop_and_a_ball_are_led_on_the_plan(studio, page)
        a_ball_is_led_in_3d(studio, page)
        both_are_led_by_fields_and_let_go(studio, page)
        a_joint_that_a_motion_moves_through_a_loop_is_led_by_that_motion_and_refused_where_the_loop_ends(studio, page)
