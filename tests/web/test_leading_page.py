"""Joints that controllers move are held by hand, and what cannot be led or reached says so, in a real browser."""

import json
import math
import re

import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.world import EVENT_KINDS, kind_of
from tests.browser import browser as listener
from tests.web.test_joints_page import joint_place, keep, running
from tests.web.test_lead_solids_page import ROOM, lead, opened
from tests.web.test_studio_touch_page import CELL, drag, until
from tests.windows import PATIENCE

pytestmark = pytest.mark.slow
SHORT = re.compile(r"^\d\.\d\d m short$")
PENDULUM = """\
mjsim: 1
name: hall
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
mechanisms:
  - name: gate
    at: [2, 2]
    bodies: [{name: bar, box: [1.2, 0.3, 0.1], mass: 2}, {name: flap, box: [0.3, 1.2, 0.1], mass: 1}]
    joints:
      - {revolute: swing, of: [ground, bar], axis: [0, 0, 1]}
      - {revolute: hinge, of: [{ground: [1, 1, 0]}, flap]}
    actuators:
      - controller: {use: "mjsim.algorithms.linear_control:MechanismLoop", gain: {swing: [2, 1]}}
        torque: swing
      - {angle: hinge, signal: {constant: {value_deg: 0}}}
run: {seconds: 1000, rate_hz: 10}
"""


def swing(tick) -> float:
    """Return where the bar swings [deg]."""
    return math.degrees(tick["joints"]["gate"]["swing"][0])


def test_a_joint_that_a_controller_moves_is_held_by_a_hand_let_go(browser, tmp_path):
    with running(browser, tmp_path, PENDULUM) as (studio, page):
        until(studio, page, lambda tick: abs(swing(tick)) < 1)
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        page.get_by_label("swing, °").fill("60")
        page.get_by_label("swing, °").press("Enter")
        until(studio, page, lambda tick: abs(swing(tick) - 60) < 0.5)
        torque = page.locator("[data-joint='gate.swing'] td").locator("visible=true").nth(2)
        expect(torque).to_have_text(re.compile(r"^-2\.\d\d N m$"))  # 2 N m/rad, against the hand
        page.get_by_role("button", name="Touch: drag").click()
        with listener(studio.url) as watcher:
            x, y = joint_place(watcher.until("tick"), "swing")
        drag(page, (x, y), (4 - x, 4 - y))  # to the other side of its axis at (2, 2)
        until(studio, page, lambda tick: abs(abs(swing(tick) - 60) - 180) < 5)
        page.get_by_role("button", name="Let go of swing").click()
        until(studio, page, lambda tick: abs(swing(tick)) < 5)
        page.get_by_role("button", name="Stop the run").click()
        expect(page.locator(".run-state")).to_have_text("Ended", timeout=PATIENCE)
        keep(page, 3)
    world = mjsim.load_world(tmp_path / "room.yaml")
    assert [kind_of(event, EVENT_KINDS) for event in world.run.events] == ["lead", "lead", "release"]


def test_a_tool_that_is_led_out_of_reach_says_by_how_much_as_a_hand_does(browser, tmp_path):
    with running(browser, tmp_path, CELL) as (studio, page):
        canvas = opened(page)
        with listener(studio.url) as watcher:
            before = watcher.until("tick")["robots"]["r"]["arms"]["arm"]["tool"]
        note = page.locator("#view-run .scene-notes span")
        expect(note).to_have_count(0)
        lead(canvas, "arm", "z", (0, -150))
        # While it is dragged it is said beside the handle alone.
        said = "The tool of arm of r cannot reach that point:"
        expect(page.locator(".toasts")).to_contain_text(said, timeout=PATIENCE)
        expect(note).to_have_text(SHORT)
        expect(page.locator(".toasts")).to_have_text(re.compile(f"^{said} {note.inner_text().split()[0]} m remain.?$"))
        # It goes as far as it can.
        until(studio, page, lambda tick: tick["robots"]["r"]["arms"]["arm"]["tool"][2] > before[2] + 0.1)
        lead(canvas, "arm", "z", (0, 10))
        expect(note).to_have_count(0, timeout=PATIENCE)


def test_a_hand_that_is_led_out_of_reach_says_by_how_much_it_misses_beside_its_handle(browser, tmp_path):
    with running(browser, tmp_path, ROOM) as (studio, page):
        canvas = opened(page)
        note = page.locator("#view-run .scene-notes span")
        expect(note).to_have_count(0)
        lead(canvas, "right", "", (0, -120))
        expect(page.locator(".toasts")).to_contain_text("cannot reach that point", timeout=PATIENCE)
        expect(note).to_have_text(SHORT)
        expect(page.locator(".toasts")).to_contain_text(f"{note.inner_text().split()[0]} m")
        # Beside the handle, wherever that is.
        box, at = canvas.bounding_box(), note.bounding_box()
        entries = json.loads(canvas.get_attribute("data-leads"))
        x, y = next((x, y) for key, way, x, y in entries if "right" in key and way == "")
        assert abs(at["x"] - box["x"] - x) < 40
        assert abs(at["y"] - box["y"] - y) < 40
        until(studio, page, lambda tick: tick["hands"]["anna"]["right"][2] > 1.2)  # at first it hangs as low as it can
        lead(canvas, "right", "", (0, 40))
        expect(note).to_have_count(0, timeout=PATIENCE)
