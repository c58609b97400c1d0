"""Joints of mechanisms in Run and Review, in a real browser: seen as they move, led by hand, let go, kept, and read."""

import math

import pytest
from playwright.sync_api import expect

import mjsim
from tests.browser import browser as listener
from tests.hands import (
    drag,
    drawn,
    expect_drawn,
    last_target,
    now,
    pick,
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
run: {seconds: 1000, rate_hz: 10}
"""


def degrees(tick, joint) -> float:
    """Return where a joint of the gate is [deg]."""
    return math.degrees(tick["joints"]["gate"][joint][0])


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
    empty = drawn(page, (2, 2.8))
    touch(page, on=True)
    drag(page, (2 + 1.2 * math.cos(math.radians(15)), 2 + 1.2 * math.sin(math.radians(15))), (2, 3.5))
    until(studio, page, lambda tick: abs(degrees(tick, "swing") - 90) < 0.1)
    touch(page, on=False)
    expect_drawn(page, (2, 2.8), empty, same=False)
    touch(page, on=True)
    pick(page, (2, 3.2), "Return to its signal")
    until(studio, page, lambda tick: abs(degrees(tick, "swing")) < 80)
    touch(page, on=False)
    *_, swung, back = touched(studio)
    assert (swung["lead"], swung["joint"], *last_target(swung)) == ("gate", "swing", pytest.approx(90, abs=2))
    assert (back["release"], back["joint"]) == ("gate", "swing")


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
    # The plan draws the bar as it is then and as it was at the start.
    late = drawn(page, (3, 2))
    page.keyboard.press("Home")
    expect_drawn(page, (3, 2), late, same=False)


def test_joints_of_mechanisms_are_led_kept_and_read(browser, tmp_path):
    with running(browser, tmp_path, WORLD, record=True) as (studio, page):
        joint_states_and_torques_are_read_and_plotted(studio, page)
        the_rest_of_a_drag_of_another_browser_is_kept_after_a_part_of_it_was(studio, page, tmp_path / "room.yaml")
        a_mechanism_is_drawn_as_it_moves_dragged_on_the_plan_and_given_back(studio, page)
        joints_are_read_and_drawn_in_review_as_they_were(page, tmp_path)
