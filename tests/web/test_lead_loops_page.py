"""Joints of loops and ball joints are led by hand on the plan, in 3-D and by sliders, in a real browser."""

import math
import re

import numpy as np
import pytest
from playwright.sync_api import expect
from scipy.spatial.transform import Rotation

from tests.hands import drag, grip, lead, opened, running, screen, shown, tab, touch, touched, until

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
run: {seconds: 1000, rate_hz: 10}
"""


def degrees(tick, mechanism, *joints) -> np.ndarray:
    """Return where joints are [deg]."""
    return np.degrees([tick["joints"][mechanism][joint][0] for joint in joints])


def rod(tick) -> np.ndarray:
    """Return where the rod of the bell points, a unit vector."""
    vector = [tick["joints"]["bell"][f"knot.r{axis}"][0] for axis in "xyz"]
    return Rotation.from_rotvec(vector).apply([1, 0, 0])


def turned(handle, angle) -> np.ndarray:
    """Return where a handle is on the plan once its joint was turned [m, deg]."""
    cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return handle["at"] + np.array([[cos, -sin], [sin, cos]]) @ (handle["grip"] - handle["at"])


def pull(page, handle, begin, end) -> None:
    """Move the pointer with the handle of a joint from angle to angle [deg]."""
    for angle in np.linspace(begin, end, 5).tolist():
        page.mouse.move(*screen(page, *turned(handle, angle)))
        page.wait_for_timeout(100)  # a hand moves so fast: each target is sent


def a_joint_follows_the_pointer_goes_back_with_escape_and_the_drag_is_one_event(studio, page):
    touch(page, on=True)
    tick = shown(studio, page)
    begin, handle = degrees(tick, "bars", "q2")[0], grip(tick, "q2")
    page.mouse.move(*screen(page, *handle["grip"]))
    page.mouse.down()
    pull(page, handle, 0, 25)
    # It is there while it is held, and nothing was told of its end.
    until(studio, page, lambda tick: abs(degrees(tick, "bars", "q2")[0] - begin - 25) < 2)
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
    tab(page, "Joints")
    page.get_by_role("button", name="Let go of q2").click()
    # q5 is where the loop is cut: the physics has no joint there. It is led 20 degrees at once, so on and on.
    tick = shown(studio, page)
    begin, (q5,) = degrees(tick, "bars", "q5")[0], [each for each in tick["grips"] if each["joint"] == "q5"]
    drag(page, q5["grip"][:2], np.add(q5["grip"], q5["toward"])[:2])
    until(studio, page, lambda tick: degrees(tick, "bars", "q5")[0] > begin + 25)


def a_ball_is_led_on_the_plan(studio, page):
    # The rod hangs: its handle is below its joint, and goes aside on a sphere.
    handle = grip(shown(studio, page), "knot")
    np.testing.assert_allclose(handle["grip"], handle["at"], atol=0.06)
    drag(page, handle["at"], handle["at"] + (0.4, 0.3))
    until(studio, page, lambda tick: np.abs(rod(tick)[:2] - (0.4, 0.3)).max() < 0.07 and rod(tick)[2] < 0)


def a_ball_is_led_in_3d(studio, page):
    touch(page, on=False)
    canvas = opened(page)
    before = rod(shown(studio, page))
    lead(canvas, "knot", "", (0, -60))
    until(studio, page, lambda tick: rod(tick)[2] > before[2] + 0.2)
    page.locator("#view-run").get_by_title("View in 3-D").click()  # what comes does without


def a_ball_is_led_by_fields_and_let_go(studio, page):
    field = page.get_by_label("knot.rz, °")
    field.fill("-40")
    field.press("Enter")
    said = page.locator("#view-run .run-side").get_by_text("truss: t1, t2, t3 cannot be moved by hand")
    expect(said).to_contain_text("they are fixed")
    page.get_by_role("button", name="Let go of knot.rz").click()
    expect(page.locator(".run-keep button").first).to_contain_text("Keep 7 ")
    *before, led, released = touched(studio)
    assert [event["joint"] for event in before] == ["q2", "q2", "q5", "knot", "knot"]
    assert (led["lead"], led["joint"], led["to_deg"]) == ("bell", "knot.rz", -40)
    assert (released["release"], released["joint"]) == ("bell", "knot.rz")


def test_joints_of_loops_and_balls_are_led_by_hand(browser, tmp_path):
    with running(browser, tmp_path, HALL) as (studio, page):
        a_joint_follows_the_pointer_goes_back_with_escape_and_the_drag_is_one_event(studio, page)
        a_quick_flick_takes_a_joint_of_a_loop_all_the_way(studio, page)
        a_ball_is_led_on_the_plan(studio, page)
        a_ball_is_led_in_3d(studio, page)
        a_ball_is_led_by_fields_and_let_go(studio, page)
