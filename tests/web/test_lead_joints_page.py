"""Joints of mechanisms in Run and Review, in a real browser: seen as they move, led by hand, let go, kept, and read."""

import math
import re

import pytest
from playwright.sync_api import expect

import mjsim
from tests.browser import browser as listener
from tests.hands import (
    drag,
    drawn,
    expect_drawn,
    grip,
    last_target,
    lead,
    now,
    opened,
    pick,
    restart,
    running,
    tab,
    touch,
    touched,
    until,
)

pytestmark = pytest.mark.slow
WORLD = """\
mjsim: 1
name: gate
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
mechanisms:
  - name: gate
    at: [2, 2]
    bodies: [{name: bar, rod: [1.2, 0.05], mass: 2}, {name: slab, box: [0.4, 0.2, 0.1], mass: 2}]
    joints:
      - {revolute: swing, of: [ground, bar], axis: [0, 0, 1]}
      - {prismatic: slide, of: [{ground: [-1, -1, 0.1]}, slab], axis: [1, 0, 0], range: [-0.5, 0.5]}
    actuators:
      - {angle: swing, signal: {constant: {value_deg: 0}}}
      - {position: slide, signal: {constant: {value: 0}}}
  - name: mill
    at: [0.5, 0.5]
    elevation: 2
    bodies: [{name: sail, rod: [0.4, 0.05], mass: 2}]
    joints: [{revolute: turn, of: [ground, sail], axis: [0, 1, 0]}]
    actuators: [{angle: turn, signal: {ramp: {slope_deg: 30}}}]
  - name: wings
    at: [3.2, 3.2]
    bodies: [{name: wing, box: [1.2, 0.3, 0.1], mass: 2}, {name: flap, box: [0.3, 0.6, 0.1], mass: 1}]
    joints:
      - {revolute: sway, of: [ground, wing], axis: [0, 0, 1]}
      - {revolute: hinge, of: [{ground: [-2.6, 0, 0]}, flap]}
    actuators:
      - controller: {use: "mjsim.algorithms.linear_control:MechanismLoop", gain: {sway: [2, 1]}}
        torque: sway
      - {angle: hinge, signal: {constant: {value_deg: 0}}}
run: {seconds: 1000, rate_hz: 10}
"""


def degrees(tick, joint, of="gate") -> float:
    """Return where a joint is [deg]."""
    return math.degrees(tick["joints"][of][joint][0])


def cells(page, joint: str) -> list[str]:
    """Return position, speed and torque of a joint in the table that is seen."""
    return page.locator(f"[data-joint='{joint}'] td").locator("visible=true").all_inner_texts()


def joint_states_and_torques_are_read_and_plotted(studio, page):
    tab(page, "Joints")
    until(studio, page, lambda tick: tick["time"] > 0.5)
    position, speed, torque = cells(page, "mill.turn")
    assert position.endswith("°")
    assert speed == "30.0°/s"
    assert torque.endswith(" N m")
    tab(page, "Plot")
    page.get_by_label("Search topics and fields").locator("visible=true").fill("turn torque")
    page.get_by_role("button", name="/mill/joints.turn.torque", exact=True).click()
    expect(page.locator("#view-run .plotter-chart .run-chart")).to_have_count(1)


def a_mechanism_is_drawn_as_it_moves_dragged_on_the_plan_and_given_back(studio, page):
    until(studio, page, lambda tick: abs(degrees(tick, "swing")) < 0.1)
    empty = drawn(page, (2, 2.8))
    touch(page, on=True)
    drag(page, (3.2, 2), (2, 3.5))
    until(studio, page, lambda tick: abs(degrees(tick, "swing") - 90) < 0.1)
    # One that slides stays within its range.
    drag(page, (1, 1), (3, 1.2))
    until(studio, page, lambda tick: abs(tick["joints"]["gate"]["slide"][0] - 0.5) < 1e-3)
    touch(page, on=False)
    expect_drawn(page, (2, 2.8), empty, same=False)
    touch(page, on=True)
    pick(page, (2, 3.2), "Return to its signal")
    until(studio, page, lambda tick: abs(degrees(tick, "swing")) < 0.1)
    touch(page, on=False)
    expect_drawn(page, (2, 2.8), empty, same=True)
    swung, slid, back = touched(studio)
    assert (swung["lead"], swung["joint"], *last_target(swung)) == ("gate", "swing", pytest.approx(90, abs=2))
    assert (slid["joint"], *last_target(slid)) == ("slide", 0.5)
    assert (back["release"], back["joint"]) == ("gate", "swing")


def a_joint_that_a_controller_moves_is_held_by_a_hand_and_let_go(studio, page):
    until(studio, page, lambda tick: abs(degrees(tick, "sway", "wings")) < 1)
    tab(page, "Joints")
    page.get_by_label("sway, °").fill("60")
    page.get_by_label("sway, °").press("Enter")
    tick = until(studio, page, lambda tick: abs(degrees(tick, "sway", "wings") - 60) < 0.5)
    torque = page.locator("[data-joint='wings.sway'] td").locator("visible=true").nth(2)
    expect(torque).to_have_text(re.compile(r"^-2\.\d\d N m$"))  # 2 N m/rad, against the hand
    touch(page, on=True)
    handle = grip(tick, "sway")
    drag(page, handle["grip"], 2 * handle["at"] - handle["grip"])  # to the other side of its axis
    until(studio, page, lambda tick: abs(abs(degrees(tick, "sway", "wings") - 60) - 180) < 5)
    page.get_by_role("button", name="Let go of sway").click()
    until(studio, page, lambda tick: abs(degrees(tick, "sway", "wings")) < 5)
    assert [sorted({"lead", "release"} & set(event)) for event in touched(studio)[-3:]] == [
        ["lead"],
        ["lead"],
        ["release"],
    ]


def a_joint_is_led_in_3d_and_returned_by_its_button(studio, page):
    touch(page, on=False)
    canvas = opened(page)
    lead(canvas, "swing", "", (-120, -60))
    until(studio, page, lambda tick: abs(degrees(tick, "swing")) > 20)
    tab(page, "Joints")
    page.get_by_role("button", name="Return swing to its signal").click()
    until(studio, page, lambda tick: abs(degrees(tick, "swing")) < 0.1)
    led, back = touched(studio)[-2:]
    assert (led["lead"], led["joint"], back["release"], back["joint"]) == ("gate", "swing", "gate", "swing")
    page.locator("#view-run").get_by_title("View in 3-D").click()  # what comes does without


def the_rest_of_a_drag_of_another_browser_is_kept_after_a_part_of_it_was(studio, page, file):
    with listener(studio.url) as other:

        def drag(to_deg, drag):
            other.say("touch", event={"lead": "gate", "joint": "swing", "to_deg": to_deg}, drag=drag)
            while not ((events := other.until("run").get("touched")) and last_target(events[-1]) == [to_deg]):
                pass
            told = now(studio)["time"]
            until(studio, page, lambda tick: tick["time"] > told)  # what is told before it the page has too

        tab(page, "Events")
        keep, kept = (page.get_by_role("button", name=name) for name in ("Keep 1 as event", "Kept as events"))
        drag(5, "first")
        keep.click()
        expect(kept).to_be_disabled()
        for to_deg in (10, 15):
            drag(to_deg, "next")
        keep.click()
        expect(kept).to_be_disabled()
    page.keyboard.press("Control+s")
    expect(page.locator(".world .dot")).to_be_hidden()
    (event,) = mjsim.load_world(file).run.events
    assert (event.to_deg, [row[1] for row in event.then]) == (5, [10, 15])


def joints_are_read_and_drawn_in_review_as_they_were(page, folder):
    page.get_by_role("button", name="Stop the run").click()
    expect(page.locator(".run-state")).to_have_text("Ended")
    path = max(folder.glob("out/**/*.mcap"), key=lambda path: path.stat().st_mtime)
    page.get_by_role("tab", name="Review", exact=True).click()
    page.locator(f"#view-review [data-path$='{path.name}']").click()
    tab(page, "Joints")
    page.keyboard.press("End")
    track = mjsim.read_recording(path).joints["mill"]
    wanted = f"{math.degrees(track.positions[-1][0]):.1f}°"
    expect(page.locator("#view-review [data-joint='mill.turn'] td").first).to_have_text(wanted)
    torque = round(track.torques[-1][0], 2) + 0.0  # of a zero the page shows no sign
    assert cells(page, "mill.turn")[2] == f"{torque:.2f} N m"
    # The plan draws the bar as it is then, at 15 degrees, and as it was at the start.
    late = drawn(page, (3, 2))
    page.keyboard.press("Home")
    expect_drawn(page, (3, 2), late, same=False)


def test_joints_of_mechanisms_are_led_kept_and_read(browser, tmp_path):
    with running(browser, tmp_path, WORLD, record=True) as (studio, page):
        joint_states_and_torques_are_read_and_plotted(studio, page)
        a_mechanism_is_drawn_as_it_moves_dragged_on_the_plan_and_given_back(studio, page)
        a_joint_that_a_controller_moves_is_held_by_a_hand_and_let_go(studio, page)
        a_joint_is_led_in_3d_and_returned_by_its_button(studio, page)
        restart(studio, page)
        the_rest_of_a_drag_of_another_browser_is_kept_after_a_part_of_it_was(studio, page, tmp_path / "room.yaml")
        joints_are_read_and_drawn_in_review_as_they_were(page, tmp_path)
