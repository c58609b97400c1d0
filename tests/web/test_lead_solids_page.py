"""Tools are led in the 3-D view of a run, in a real browser, and what was done is kept."""

import json
import re
from time import monotonic

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.browser import browser as listener
from tests.web.test_studio_touch_page import CELL, drag, pick, screen, tool_rests, until
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
name: room
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
people: [{name: anna, sex: female, at: [2, 2], heading_deg: 90}]
robots: [{name: scout, at: [0.5, 0.5]}]
run: {seconds: 1000, rate_hz: 10}
"""


def opened(page):
    """Open the view in 3-D of a run that can be touched, large, and return its canvas once it is drawn so."""
    page.evaluate("() => localStorage.setItem('mjsim.run.scene.slow', 'yes')")
    page.locator("#view-run").get_by_title("View in 3-D").click()
    expect(page.locator("#view-run .scene")).to_have_attribute("data-filled", "", timeout=PATIENCE)
    page.get_by_role("button", name="Touch: drag").click()
    canvas = page.locator("#view-run .scene canvas")
    small = canvas.evaluate("canvas => canvas.clientHeight")
    page.locator("#view-run [data-view=scene] .run-enlarge").click()
    page.wait_for_function("([canvas, small]) => canvas.clientHeight > small", arg=[canvas.element_handle(), small])
    drawn = int(canvas.get_attribute("data-frames"))
    expect(canvas).not_to_have_attribute("data-frames", re.compile(rf"^({drawn}|{drawn + 1})$"), timeout=PATIENCE)
    return canvas


def lead(canvas, key, way, by):
    """Drag a handle of what is led by so much [px], in the plane that faces the view for way ''."""
    expect(canvas).to_have_attribute("data-leads", re.compile(r"\["), timeout=PATIENCE)
    canvas.page.wait_for_function(
        "([canvas, key]) => JSON.parse(canvas.dataset.leads || '[]').some(([each]) => each.includes(key))",
        arg=[canvas.element_handle(), key],
        timeout=PATIENCE,
    )
    box = canvas.bounding_box()
    entries = json.loads(canvas.get_attribute("data-leads"))
    x, y = next((x, y) for each, along, x, y in entries if key in each and along == way)
    mouse = canvas.page.mouse
    mouse.move(box["x"] + x, box["y"] + y)
    mouse.down()
    mouse.move(box["x"] + x + by[0] / 2, box["y"] + y + by[1] / 2)
    mouse.move(box["x"] + x + by[0], box["y"] + y + by[1])
    mouse.up()


def tool(studio) -> np.ndarray:
    """Return where the tool in the cell is, frame of its robot, shape (3,) [m]."""
    with listener(studio.url) as watcher:
        return np.array(watcher.until("tick")["robots"]["r"]["arms"]["arm"]["tool"][:3])


def test_a_tool_is_led_in_3d_along_an_axis_and_freely_and_that_is_kept(browser, tmp_path):
    (tmp_path / "cell.yaml").write_text(CELL)
    with Studio(tmp_path, world="cell.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        canvas = opened(page)
        before = tool(studio)
        lead(canvas, "arm", "z", (0, 10))
        until(studio, page, lambda tick: tick["robots"]["r"]["arms"]["arm"]["tool"][2] < before[2] - 0.1)
        page.get_by_role("tab", name="Events").click()
        expect(page.get_by_role("button", name="Keep 1 as event")).to_be_enabled()
        # Inverse kinematics begin where the joints shall be: on the way another posture may be found, or none.
        until(studio, page, tool_rests())
        lead(canvas, "arm", "", (8, 4))  # away from its base
        expect(page.get_by_role("button", name="Keep 2 as events")).to_be_enabled()
        until(studio, page, tool_rests())  # what is led later would be another event
        page.get_by_role("button", name="Keep 2 as events").click()
        expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
        page.keyboard.press("Control+s")
        expect(page.locator(".world .dot")).to_be_hidden()
    down, aside = mjsim.load_world(tmp_path / "cell.yaml").run.events
    # Along z alone, to what the arm sags.
    assert np.allclose(down.tool[:2], before[:2], atol=5e-3)
    assert down.tool[2] < before[2] - 0.1
    assert np.linalg.norm(np.subtract(aside.tool, down.tool)) > 0.02


def hand(tick) -> np.ndarray:
    """Return where the right hand is, shape (3,) [m]."""
    return np.array(tick["hands"]["anna"]["right"])


def drawn(page, at) -> bytes:
    """Return a picture of the page around a place of the plan, some 12 px wide."""
    x, y = screen(page, *at)
    return page.screenshot(clip={"x": x - 6, "y": y - 6, "width": 12, "height": 12})


def expect_drawn(page, at, picture, *, same) -> None:
    """Wait until a place of the plan looks as in a picture, or otherwise."""
    ends = monotonic() + PATIENCE / 1000
    while (drawn(page, at) == picture) != same:
        assert monotonic() < ends


def rests():
    """Return a fact of a tick: the hand is where it was at the one before."""
    before = [np.full(3, np.nan)]

    def fact(tick) -> bool:
        before.append(hand(tick))
        return np.array_equal(*before[-2:])

    return fact


def test_a_hand_is_led_on_the_plan_and_in_3d_and_that_is_kept(browser, tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM)
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        with listener(studio.url) as watcher:
            start = hand(watcher.until("tick"))
        until(studio, page, lambda tick: "people" not in tick)
        empty = drawn(page, (2.3, 2.3))
        page.get_by_role("button", name="Touch: drag").click()
        drag(page, start[:2], (2.3, 2.3))
        until(studio, page, lambda tick: np.hypot(*(hand(tick)[:2] - (2.3, 2.3))) < 0.06)
        until(studio, page, rests())
        # The plan draws the arm where it is.
        page.get_by_role("button", name="Touch: drag").click()
        page.mouse.move(*screen(page, 1, 1))
        expect_drawn(page, (2.3, 2.3), empty, same=False)
        page.get_by_role("button", name="Touch: drag").click()
        # What is out of reach is told in a line, and among the events.
        drag(page, (2.3, 2.3), (3.8, 3.8))
        line = page.locator(".toast.done", has_text="The right hand of anna cannot reach that point:")
        expect(line).to_be_visible(timeout=PATIENCE)
        away = float(re.search(r": ([\d.]+) m", line.inner_text())[1])
        until(studio, page, lambda tick: abs(np.linalg.norm(hand(tick) - (3.8, 3.8, start[2])) - away) < 0.06)
        until(studio, page, rests())
        with listener(studio.url) as watcher:
            x, y, _ = hand(watcher.until("tick"))
        pick(page, (x, y), "Release")
        until(studio, page, lambda tick: np.linalg.norm(hand(tick) - start) < 1e-3)
        page.get_by_role("button", name="Touch: drag").click()
        page.mouse.move(*screen(page, 1, 1))
        expect_drawn(page, (2.3, 2.3), empty, same=True)
        canvas = opened(page)
        lead(canvas, "right", "", (0, -12))
        until(studio, page, lambda tick: hand(tick)[2] > start[2] + 0.05)
        page.get_by_role("tab", name="Events").click()
        page.get_by_role("button", name="Keep 4 as events").click()
        expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
        page.keyboard.press("Control+s")
        expect(page.locator(".world .dot")).to_be_hidden()
    events = mjsim.load_world(tmp_path / "room.yaml").run.events
    led, beyond, back, lifted = events
    assert [(event.reach, event.hand) for event in (led, beyond, lifted)] == [("anna", "right")] * 3
    assert (back.release, back.hand) == ("anna", "right")
    # On the plan it keeps its height.
    assert abs(events[0].to[2] - start[2]) < 1e-3
