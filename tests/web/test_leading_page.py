"""What cannot be led in a run says so, and what is led out of reach says by how much it misses, in a real browser."""

import json
import re

import pytest
from playwright.sync_api import expect

from tests.web.test_joints_page import running
from tests.web.test_lead_solids_page import ROOM, lead, opened
from tests.web.test_studio_touch_page import screen
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
      - {torque: swing, signal: {constant: {value: 0}}}
      - {angle: hinge, signal: {constant: {value_deg: 0}}}
run: {seconds: 1000}
"""


def test_a_joint_that_torques_move_says_why_it_cannot_be_led_and_what_to_do(browser, tmp_path):
    with running(browser, tmp_path, PENDULUM) as (_, page):
        page.get_by_role("tab", name="Joints").locator("visible=true").click()
        said = page.locator("#view-run .run-side").get_by_text("swing cannot be led by hand")
        expect(said).to_contain_text("give it an actuator such as angle: swing")
        page.get_by_role("button", name="Touch: drag").click()
        page.mouse.click(*screen(page, 2, 2))
        expect(page.locator(".toasts")).to_contain_text("swing cannot be led by hand")


def test_a_hand_that_is_led_out_of_reach_says_by_how_much_it_misses_beside_its_handle(browser, tmp_path):
    with running(browser, tmp_path, ROOM) as (_, page):
        canvas = opened(page)
        note = page.locator("#view-run .scene-notes span")
        expect(note).to_have_count(0)
        lead(canvas, "right", "", (0, -120))
        expect(note).to_have_text(SHORT, timeout=PATIENCE)
        away = float(note.inner_text().split()[0])
        expect(page.locator(".toasts")).to_contain_text(f"{away:.2f} m")
        # Beside the handle, wherever that is.
        box, at = canvas.bounding_box(), note.bounding_box()
        entries = json.loads(canvas.get_attribute("data-leads"))
        x, y = next((x, y) for key, way, x, y in entries if "right" in key and way == "")
        assert abs(at["x"] - box["x"] - x) < 40
        assert abs(at["y"] - box["y"] - y) < 40
        lead(canvas, "right", "", (0, 40))
        expect(note).to_have_count(0, timeout=PATIENCE)
