"""Several things are made one group: selected, moved, turned and copied as one, kept in the text, in a real browser."""

import math

import numpy as np
import pytest
from playwright.sync_api import expect

from mjsim.world import load_world

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
walls:
  - {points: [[0, 0], [9, 0], [9, 6], [0, 6]], closed: true}
  - {name: screen, points: [[2, 3], [3, 3]]}   # beside the desk
obstacles:
  - {name: desk, box: [0.8, 0.4, 0.7], at: [2, 2], heading_deg: 0}
  - {name: bin, cylinder: [0.2, 0.5], at: [3, 2]}
  - {name: chest, box: [0.4, 0.4, 0.5], at: [6, 4]}
beacons:
  - {name: lion, image: posters/lion.jpg, at: [0.41, 0], on: desk, heading_deg: 0}
"""


def row(sheet, name):
    return sheet.page.get_by_role("treeitem").filter(has_text=name)


def chosen(sheet):
    return sheet.page.locator(".outline-row[aria-selected=true]")


def select(sheet, *names):
    for index, name in enumerate(names):
        row(sheet, name).first.click(modifiers=["Control"] if index else [])


def test_a_group_is_one_thing_on_the_plan_and_is_kept_in_the_text(sheet, tmp_path):
    select(sheet, "desk", "bin", "screen")
    sheet.button("Group").click()
    sheet.reads("group: group-1}   # beside the desk", "heading_deg: 0, group: group-1", "at: [3, 2], group: group-1")
    sheet.page.keyboard.press("Escape")
    sheet.click(6, 4)
    expect(sheet.title).to_have_text("chest")
    sheet.click(2, 2)  # one of them takes all
    expect(sheet.title).to_have_text("group-1")
    expect(chosen(sheet)).to_have_count(3)
    sheet.drag((2, 2), (2, 2.5))
    sheet.reads("at: [2, 2.5]", "at: [3, 2.5]", "points: [[2, 3.5], [3, 3.5]]", "at: [6, 4]}", "at: [0.41, 0]")
    sheet.save()
    sheet.page.reload()  # what is kept is in the file
    sheet.reads("group: group-1")
    sheet.shows(3, 2.5)
    sheet.click(3, 2.5)
    expect(sheet.title).to_have_text("group-1")
    sheet.plan.focus()
    sheet.press("Control+Shift+G")
    expect(sheet.text).not_to_contain_text("group")
    sheet.press("Escape")
    sheet.click(3, 2.5)
    expect(sheet.title).to_have_text("bin")
    sheet.press("Control+z")
    sheet.reads("group: group-1")
    sheet.button("Undo steps").click()
    expect(sheet.page.get_by_role("menuitemradio").filter(has_text="Ungroup 3 things")).to_be_visible()


def test_a_group_turns_about_its_middle_as_if_it_were_one_thing(sheet, tmp_path):
    select(sheet, "desk", "bin", "screen")
    sheet.plan.focus()
    sheet.press("Control+g")
    sheet.reads("group: group-1")

    def places():
        sheet.save()
        world = load_world(tmp_path / "room.yaml")
        desk, bin_, _ = world.obstacles
        return np.array([desk.at, bin_.at, *world.walls[1].points]), desk.heading_deg

    before, _ = places()
    sheet.press("[")
    sheet.press("[")
    sheet.reads("heading_deg: 30")
    after, heading = places()
    assert heading == 30
    # Every distance within the group stays, and so does the mean of what it consists of; 0.1 mm is what the text has.
    apart = np.linalg.norm(before[:, None] - before[None], axis=2)
    np.testing.assert_allclose(np.linalg.norm(after[:, None] - after[None], axis=2), apart, atol=3e-4)
    turn = np.array([[math.cos(math.pi / 6), -math.sin(math.pi / 6)], [math.sin(math.pi / 6), math.cos(math.pi / 6)]])
    np.testing.assert_allclose(after - after[0], (before - before[0]) @ turn.T, atol=3e-4)
    middle = (before[0] + before[1] + (before[2] + before[3]) / 2) / 3
    np.testing.assert_allclose((after[0] + after[1] + (after[2] + after[3]) / 2) / 3, middle, atol=3e-4)
    # What hangs on the desk is written in its frame, and goes with it.
    assert load_world(tmp_path / "room.yaml").beacons[0].at == (0.41, 0)


def test_one_of_a_group_is_taken_alone_and_a_copy_is_a_group_of_its_own(sheet):
    select(sheet, "desk", "bin")
    sheet.plan.focus()
    sheet.press("Control+g")
    sheet.reads("at: [3, 2], group: group-1")
    sheet.press("Escape")
    sheet.page.mouse.dblclick(*sheet.pixel(3, 2))
    expect(sheet.title).to_have_text("bin")
    sheet.drag((3, 2), (3, 2.5))
    sheet.reads("at: [3, 2.5], group: group-1", "at: [2, 2], heading_deg: 0, group: group-1")
    sheet.page.mouse.click(*sheet.pixel(3, 2.5), button="right")
    sheet.page.get_by_role("menuitem", name="Select the whole group").click()
    expect(chosen(sheet)).to_have_count(2)
    sheet.press("Control+d")
    expect(row(sheet, "group-2")).to_have_count(2)
    expect(row(sheet, "group-1")).to_have_count(2)
    select(sheet, "bin-2")
    sheet.plan.focus()
    sheet.press("Control+d")  # one of a group, copied alone, is of none
    expect(row(sheet, "bin-3")).to_have_count(1)
    expect(row(sheet, "group-2")).to_have_count(2)


def test_what_hangs_on_a_thing_that_is_moved_too_is_not_moved_twice(sheet):
    sheet.plan.focus()
    sheet.press("Control+a", "ArrowUp")
    sheet.reads("at: [3, 2.1]", "at: [0.41, 0], on: desk")
