"""The steps of undo are listed by what they did, and any of them is gone to, in a real browser."""

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
name: room
robots:
  - {name: scout, preset: pioneer3dx, at: [1, 1]}
obstacles:
  - {name: crate, box: [0.6, 0.4, 0.5], at: [2, 2]}
  - {name: bin, cylinder: [0.2, 0.5], at: [3, 3]}
"""


def steps_of_undo_are_named_and_gone_to(sheet):
    steps, menu = sheet.button("Undo steps"), sheet.page.get_by_role("menu")
    expect(steps).to_be_disabled()
    sheet.drag((2, 2), (3, 2.5))
    sheet.reads("at: [3, 2.5]")
    sheet.press("[")
    sheet.reads("heading_deg: 15")
    sheet.press("Control+a", "Delete")
    expect(sheet.text).not_to_contain_text("crate")
    sheet.press("b")
    sheet.click(1, 1)
    sheet.reads("box: [0.6, 0.6, 0.6]")
    expect(sheet.page.locator(".panel .kind")).to_have_text("Box")
    sheet.text.press("Control+End")
    sheet.type("# the end")
    sheet.reads("# the end")
    steps.click()
    entries = menu.get_by_role("menuitemradio")
    expect(entries).to_have_text(["Type in line 6", "Add box", "Delete 3 things", "Turn crate", "Move crate", "Opened"])
    expect(entries.first).to_be_focused()
    expect(entries.first).to_be_checked()
    menu.get_by_text("Move crate").click()
    sheet.reads("at: [3, 2.5]}", "name: bin")
    steps.click()
    expect(menu.get_by_role("menuitemradio", checked=True)).to_have_text("Move crate")
    sheet.press("ArrowUp", "ArrowUp", "Enter")
    expect(sheet.text).not_to_contain_text("crate")
    sheet.press("Control+z", "Control+z", "Control+z")
    expect(sheet.unsaved).to_be_hidden()


def steps_by_keys_before_the_answer_to_a_drag_go_on_from_where_it_ended(sheet):
    sheet.shows(2, 2)
    sheet.page.route("**/api/edit", lambda _: None)  # held until it is unrouted
    sheet.drag((2, 2), (3, 2.5))
    sheet.press("[", "ArrowRight")
    sheet.page.unroute("**/api/edit")
    sheet.reads("crate, box: [0.6, 0.4, 0.5], at: [3.05, 2.5], heading_deg: 15}")
    sheet.press("Control+z", "Control+z")
    sheet.reads("crate, box: [0.6, 0.4, 0.5], at: [3, 2.5]}")


def test_steps_of_undo_are_named_gone_to_and_go_on_from_where_a_drag_ended(sheet):
    steps_of_undo_are_named_and_gone_to(sheet)
    sheet.plan.focus()
    sheet.press("v")
    steps_by_keys_before_the_answer_to_a_drag_go_on_from_where_it_ended(sheet)
