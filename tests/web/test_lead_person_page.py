"""The hand of a person is led in Run, and a robot is put elsewhere with a ghost, in a real browser."""

import json
import re

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.hands import (
    drag,
    drawn,
    expect_drawn,
    lead,
    metres_missed,
    near,
    now,
    opened,
    pick,
    redrawn,
    running,
    same,
    shown,
    touch,
    touched,
    until,
)

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
name: room
walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}]
people: [{name: anna, sex: female, at: [2, 2], heading_deg: 90}]
robots: [{name: scout, preset: pioneer3dx, at: [4, 1.5]}]
run: {seconds: 1000, rate_hz: 10}
"""


def hand(tick) -> np.ndarray:
    """Return where the right hand is, shape (3,) [m]."""
    return np.array(tick["hands"]["anna"]["right"])


def rests():
    """Return a fact of a tick: the hand is where it was at the one before."""
    return same(lambda tick: tick["hands"]["anna"]["right"])


def a_hand_is_led_on_the_plan_as_far_as_it_reaches_and_released(studio, page):
    start = hand(shown(studio, page))
    until(studio, page, lambda tick: "people" not in tick)
    empty = drawn(page, (2.3, 2.3))
    touch(page, on=True)
    drag(page, start[:2], (2.3, 2.3))
    until(studio, page, lambda tick: np.hypot(*(hand(tick)[:2] - (2.3, 2.3))) < 0.06)
    until(studio, page, rests())
    # What is out of reach is told in a line, and among the events.
    drag(page, (2.3, 2.3), (3.8, 3.8))
    away = float(metres_missed(page, "The right hand of anna"))
    until(studio, page, lambda tick: abs(np.linalg.norm(hand(tick) - (3.8, 3.8, start[2])) - away) < 0.06)
    x, y, _ = hand(until(studio, page, rests()))
    # The plan draws the arm where it is.
    touch(page, on=False)
    expect_drawn(page, (2.3, 2.3), empty, same=False)
    touch(page, on=True)
    pick(page, (x, y), "Release")
    until(studio, page, lambda tick: np.hypot(*(hand(tick)[:2] - (x, y))) > 0.1)
    led, beyond, back = touched(studio)
    assert [(event["reach"], event["hand"]) for event in (led, beyond)] == [("anna", "right")] * 2
    assert (back["release"], back["hand"]) == ("anna", "right")
    # On the plan it keeps its height.
    assert abs(led["to"][2] - start[2]) < 1e-3


def a_hand_that_is_led_out_of_reach_in_3d_says_by_how_much_it_misses_beside_its_handle(studio, page, canvas):
    note = page.locator("#view-run .scene-notes span")
    expect(note).to_have_count(0)
    lead(canvas, "right", "", (0, -120))
    expect(note).to_have_text(f"{metres_missed(page, 'The right hand of anna')} m short")
    # Beside the handle, wherever that is.
    box, at = canvas.bounding_box(), note.bounding_box()
    entries = json.loads(canvas.get_attribute("data-leads"))
    x, y = next((x, y) for key, way, x, y in entries if "right" in key and way == "")
    assert abs(at["x"] - box["x"] - x) < 40
    assert abs(at["y"] - box["y"] - y) < 40
    until(studio, page, lambda tick: hand(tick)[2] > 1.2)  # at first it hangs as low as it can
    lead(canvas, "right", "", (0, 40))
    expect(note).to_have_count(0)


def a_robot_is_dragged_in_3d_with_a_ghost_and_put_there_when_it_is_let_go(studio, page, canvas):
    expect(canvas).to_have_attribute("data-moments", re.compile(r"\d"))
    page.locator("#view-run .scene-bar select").locator("visible=true").last.select_option("scout/base")
    redrawn(canvas)
    box = canvas.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2 - 5
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y - 20)
    page.mouse.move(x + 120, y - 40)
    expect(canvas).to_have_attribute("data-ghost", "scout")
    note = page.locator("#view-run .scene-notes span", has_text="scout")  # that of the hand may come back as it swings
    expect(note).to_have_text(re.compile(r"^scout  [\d.]+, [\d.]+$"))
    aim = [float(value) for value in note.inner_text().removeprefix("scout").split(",")]
    assert near(now(studio)["robots"]["scout"]["truth"], 4, 1.5)
    page.mouse.up()
    expect(canvas).not_to_have_attribute("data-ghost", "scout")
    until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], *aim))
    *_, led, reached, moved = touched(studio)
    assert [(event["reach"], event["hand"]) for event in (led, reached)] == [("anna", "right")] * 2
    assert moved["move"] == "scout"


def test_a_hand_is_led_on_the_plan_and_in_3d_and_a_robot_is_put_elsewhere_there(browser, tmp_path):
    with running(browser, tmp_path, ROOM) as (studio, page):
        a_hand_is_led_on_the_plan_as_far_as_it_reaches_and_released(studio, page)
        canvas = opened(page)
        a_hand_that_is_led_out_of_reach_in_3d_says_by_how_much_it_misses_beside_its_handle(studio, page, canvas)
        a_robot_is_dragged_in_3d_with_a_ghost_and_put_there_when_it_is_let_go(studio, page, canvas)
