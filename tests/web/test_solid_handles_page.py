"""Handles in 3-D, in a real browser: they write what the plan's drags write, as one step each."""

import json
import re

import pytest
from playwright.sync_api import expect

from tests.windows import PATIENCE

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
walls:
  - {points: [[-4, -3], [4, -3]], openings: [{at: 3, width: 2}]}
obstacles:
  - {name: crate, box: [2, 1, 1], at: [0, 0]}  # a crate
"""


def knob(canvas, kind, number=0):
    """Where a handle is seen on the page [px], once there is one."""
    expect(canvas.page.locator("#view-edit .scene-door")).to_have_attribute("data-scene", "there", timeout=PATIENCE)
    expect(canvas).to_have_attribute("data-handles", re.compile(f'"{kind}"'), timeout=PATIENCE)
    box = canvas.bounding_box()
    _, x, y = [entry for entry in json.loads(canvas.get_attribute("data-handles")) if entry[0] == kind][number]
    return box["x"] + x, box["y"] + y


def pulled(page, canvas, kind, by, number=0):
    x, y = knob(canvas, kind, number)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + by[0] / 2, y + by[1] / 2)
    page.mouse.move(x + by[0], y + by[1])


REST = """async canvas => {
  for (let seen = "", same = 0; same < 10; ) {
    await new Promise(requestAnimationFrame);
    same = canvas.dataset.handles === seen ? same + 1 : 0;
    seen = canvas.dataset.handles;
  }
}"""


def let_go(page, canvas):
    """Let a handle go, and wait until the scene of the changed text is there and its handles rest."""
    with page.expect_response("**/api/scene", timeout=PATIENCE):
        page.mouse.up()
    expect(page.locator("#view-edit .scene-door")).to_have_attribute("data-scene", "there", timeout=PATIENCE)
    canvas.evaluate(REST)


def test_things_are_moved_turned_and_lifted_in_3d_and_each_is_one_step_back(sheet):
    page = sheet.page
    page.locator("#view-edit").get_by_title("View in 3-D").click()
    expect(page.locator("#view-edit .scene")).to_have_attribute("data-filled", "", timeout=PATIENCE)
    canvas = page.locator("#view-edit .scene canvas")
    sheet.click(0, 0)
    text = page.locator(".cm-content")
    pulled(page, canvas, "lift", (0, -30))
    expect(page.locator(".scene-said")).to_have_text(re.compile(r"^\d\.\d\d m high$"))
    let_go(page, canvas)
    expect(text).to_contain_text(re.compile(r"at: \[0, 0\], elevation: [\d.]+\}  # a crate"))
    pulled(page, canvas, "turn", (-40, 0))
    let_go(page, canvas)
    # Turned by a multiple of 15 degrees, as on the plan.
    expect(text).to_contain_text(re.compile(r"heading_deg: -?(15|30|45|60|75|90|105|120|135|150|165|180), elevation"))
    pulled(page, canvas, "move", (30, 0), number=1)
    let_go(page, canvas)
    # Along x alone.
    expect(text).to_contain_text(re.compile(r"at: \[-?[1-9\d.]+, 0\], heading_deg"))
    pulled(page, canvas, "move", (40, 20))
    page.keyboard.press("Escape")
    page.mouse.up()
    expect(text).to_contain_text(re.compile(r"at: \[-?[1-9\d.]+, 0\], heading_deg"))
    for _ in range(3):
        page.keyboard.press("Control+z")
    expect(text).to_contain_text("- {name: crate, box: [2, 1, 1], at: [0, 0]}  # a crate")
    sheet.click(0, -3)
    expect(canvas).to_have_attribute("data-handles", re.compile(r'^\[\["move",-?\d+,-?\d+\]\]$'))
    sheet.click(3, -3)
    expect(canvas).to_have_attribute("data-handles", re.compile("turn"))
    expect(canvas).not_to_have_attribute("data-handles", re.compile("lift"))
