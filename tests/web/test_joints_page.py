"""Joints of mechanisms and arms in Run and Review, in a real browser: seen as they move, dragged, given back."""

import json
import math
from contextlib import contextmanager

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.browser import browser as listener
from tests.web.test_lead_solids_page import drawn, expect_drawn, lead, opened
from tests.web.test_studio_touch_page import CELL, drag, pick, screen, until
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
GATE = """\
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
run: {seconds: 1000, rate_hz: 10}
"""


@contextmanager
def running(browser, folder, text, *, record=False):
    """A run of a world, which may be recorded, on the page of a studio."""
    (folder / "room.yaml").write_text(text)
    with Studio(folder, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_label("Record to a file").set_checked(record)
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        yield studio, page


def angle(tick) -> float:
    """Return where the bar swings [deg]."""
    return math.degrees(tick["joints"]["gate"]["swing"][0])


def keep(page, count: int) -> None:
    """Keep what was done as events, and save the world."""
    page.get_by_role("tab", name="Events").locator("visible=true").click()
    page.get_by_role("button", name=f"Keep {count} as event").click()
    expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
    page.keyboard.press("Control+s")
    expect(page.locator(".world .dot")).to_be_hidden()


def last_target(event) -> tuple[float, ...]:
    """Return where an event takes something at last."""
    goal = getattr(event, "joints_deg", None) or (getattr(event, "to_deg", None),)
    return event.then[-1][1:] if event.then else goal


def test_a_mechanism_is_drawn_as_it_moves_dragged_on_the_plan_and_in_3d_and_given_back(browser, tmp_path):
    with running(browser, tmp_path, GATE) as (studio, page):
        until(studio, page, lambda tick: abs(angle(tick)) < 0.1)
        page.mouse.move(*screen(page, 3.5, 0.5))
        empty = drawn(page, (2, 2.8))
        page.get_by_role("button", name="Touch: drag").click()
        drag(page, (3.2, 2), (2, 3.5))
        until(studio, page, lambda tick: abs(angle(tick) - 90) < 0.1)
        # One that slides stays within its range.
        drag(page, (1, 1), (3, 1.2))
        until(studio, page, lambda tick: abs(tick["joints"]["gate"]["slide"][0] - 0.5) < 1e-3)
        page.get_by_role("button", name="Touch: drag").click()
        page.mouse.move(*screen(page, 3.5, 0.5))
        expect_drawn(page, (2, 2.8), empty, same=False)
        page.get_by_role("button", name="Touch: drag").click()
        pick(page, (2, 3.2), "Return to its signal")
        until(studio, page, lambda tick: abs(angle(tick)) < 0.1)
        page.get_by_role("button", name="Touch: drag").click()
        page.mouse.move(*screen(page, 3.5, 0.5))
        expect_drawn(page, (2, 2.8), empty, same=True)
        canvas = opened(page)
        lead(canvas, "swing", "", (-120, -60))
        until(studio, page, lambda tick: abs(angle(tick)) > 20)
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        page.get_by_role("button", name="Return swing to its signal").click()
        until(studio, page, lambda tick: abs(angle(tick)) < 0.1)
        keep(page, 5)
    swung, slid, back, turned, last = mjsim.load_world(tmp_path / "room.yaml").run.events
    assert (swung.lead, swung.joint, last_target(swung)[0]) == ("gate", "swing", pytest.approx(90, abs=2))
    assert (slid.joint, *last_target(slid)) == ("slide", 0.5)
    assert [(each.release, each.joint) for each in (back, last)] == [("gate", "swing")] * 2
    assert turned.joint == "swing"


def joint_place(tick, name) -> tuple[float, float]:
    """Return where the handle of a joint of the arm is on the plan [m]."""
    (found,) = (grip for grip in tick["grips"] if grip["joint"] == name)
    return found["grip"][0], found["grip"][1]


def standing_apart(canvas) -> str:
    """Go nearer until the handle of a joint stands apart from those of the tool, and return its name."""
    canvas.focus()
    for _ in range(12):
        entries = json.loads(canvas.get_attribute("data-leads"))
        others = np.array([(x, y) for key, _, x, y in entries if "joint" not in key])
        box = canvas.bounding_box()
        for key, _, *at in entries:
            inside = 20 < at[0] < box["width"] - 20 and 60 < at[1] < box["height"] - 20
            if "joint" in key and inside and np.linalg.norm(others - at, axis=1).min() > 26:
                return json.loads(key)[3]
        canvas.page.keyboard.press("+")
        canvas.page.wait_for_timeout(200)  # it is drawn meanwhile
    raise AssertionError(f"no joint stands apart in {entries}")


def test_a_joint_of_an_arm_is_dragged_on_the_plan_and_in_3d_and_no_other_turns(browser, tmp_path):
    with running(browser, tmp_path, CELL) as (studio, page):
        with listener(studio.url) as watcher:
            tick = watcher.until("tick")
        # What has no drive is not to be driven.
        expect(page.locator(".run-pad")).to_be_hidden()
        expect(page.locator(".run-advice")).to_be_hidden()
        begin, at = np.array(joint_place(tick, "joint1")), (2.0, 2.0)
        way = begin - at
        turned = at + np.array([-way[1], way[0]])  # a quarter to the left
        # So near that its handle stands apart from that of the tool.
        page.mouse.move(*screen(page, *at))
        page.mouse.wheel(0, -1200)
        page.get_by_role("button", name="Touch: drag").click()
        drag(page, begin, turned)
        until(studio, page, lambda tick: abs(math.degrees(tick["joints"]["r/arm"]["joint1"][0]) - 90) < 3)
        page.get_by_role("button", name="Touch: drag").click()
        canvas = opened(page)
        number = int(standing_apart(canvas)[-1]) - 1
        with listener(studio.url) as watcher:
            before = watcher.until("tick")["robots"]["r"]["arms"]["arm"]["goal"][number]
        lead(canvas, f"joint{number + 1}", "", (30, -30))
        until(studio, page, lambda tick: abs(tick["robots"]["r"]["arms"]["arm"]["goal"][number] - before) > 0.05)
        keep(page, 2)
    first, second = map(last_target, mjsim.load_world(tmp_path / "room.yaml").run.events)
    assert first[0] == pytest.approx(90, abs=3)
    assert first[1:] == pytest.approx((45, 0, 0, 30, 0))
    assert [first[k] == pytest.approx(second[k], abs=0.05) for k in range(6)].count(False) == 1
    assert abs(first[number] - second[number]) > 2


def cells(page, joint: str) -> list[str]:
    """Return position, speed and torque of a joint in the table that is seen."""
    return page.locator(f"[data-joint='{joint}'] td").locator("visible=true").all_inner_texts()


def test_joint_states_and_torques_are_read_in_run_and_in_review_and_plotted(browser, tmp_path):
    text = GATE.replace("constant: {value_deg: 0}", "ramp: {slope_deg: 30}").replace(
        "axis: [0, 0, 1]}", "axis: [0, 1, 0]}"
    )
    with running(browser, tmp_path, text, record=True) as (studio, page):
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        until(studio, page, lambda tick: tick["time"] > 0.5)
        position, speed, torque = cells(page, "gate.swing")
        assert position.endswith("°")
        assert speed == "30.0°/s"
        # 2 kg at 0.6 m of a level bar.
        assert torque.endswith(" N m")
        page.get_by_role("tab", name="Plot").locator("visible=true").click()
        page.get_by_label("Search topics and fields").locator("visible=true").fill("swing torque")
        page.get_by_role("button", name="/gate/joints.swing.torque", exact=True).click()
        expect(page.locator("#view-run .plotter-chart .run-chart")).to_have_count(1, timeout=PATIENCE)
        page.get_by_role("button", name="Stop the run").click()
        expect(page.locator(".run-state")).to_have_text("Ended", timeout=PATIENCE)
        page.get_by_role("tab", name="Review", exact=True).click()
        page.locator("#view-review [data-path$='.mcap']").click()
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        page.keyboard.press("End")
        (path,) = tmp_path.glob("out/**/*.mcap")
        track = mjsim.read_recording(path).joints["gate"]
        wanted = f"{math.degrees(track.positions[-1][0]):.1f}°"
        expect(page.locator("#view-review [data-joint='gate.swing'] td").first).to_have_text(wanted, timeout=PATIENCE)
        assert cells(page, "gate.swing")[2] == f"{track.torques[-1][0]:.2f} N m"
        # The plan draws it as it is then, and as it was at the start.
        page.mouse.move(5, 5)
        late = drawn(page, (3, 2))
        page.keyboard.press("Home")
        expect_drawn(page, (3, 2), late, same=False)
