"""Things go between worlds and texts through the clipboard of the system, in a real browser."""

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
name: room
walls:
  - {name: shell, points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, openings: [{name: gate, segment: 0, at: 1, width: 1}]}
obstacles:
  - {name: crate, box: [0.6, 0.4, 0.5], at: [2, 2]}   # it can be pushed
  - {name: bin, cylinder: [0.2, 0.5], at: [4, 3]}
"""  # noqa: E501


def things_go_through_the_clipboard_to_the_text_and_to_another_world(sheet):
    names = sheet.page.locator(".outline-row[aria-level='2'] .outline-name")
    sheet.click(2, 2)
    sheet.press("Control+c", "Control+v")
    sheet.reads("name: crate-2, box: [0.6, 0.4, 0.5], at:")
    expect(sheet.title).to_have_text("crate-2")
    sheet.text.press("Control+End")
    sheet.press("Control+v")  # below the list of its kind: the item alone
    expect(names).to_have_text(["shell", "crate", "bin", "crate-2"])
    expect(sheet.page.locator(".problems")).to_contain_text("crate")  # two of one name
    sheet.press("Control+z")
    expect(sheet.page.locator(".problems")).to_have_text("No problems")
    sheet.plan.focus()
    sheet.press("Control+z")
    expect(names).to_have_text(["shell", "crate", "bin"])
    sheet.press("Control+a", "Control+x")
    expect(sheet.text).not_to_contain_text("crate")
    sheet.press("Control+z")
    expect(sheet.unsaved).to_be_hidden()
    sheet.button("New world").click()
    sheet.button("Empty room").click()
    expect(sheet.text).not_to_contain_text("crate")
    sheet.plan.focus()
    sheet.press("Control+v", "Control+v")
    sheet.reads("name: gate-2", "name: bin-2")
    expect(names).to_have_text(["shell", "shell-2", "crate", "bin", "crate-2", "bin-2"])
    expect(sheet.page.locator(".problems")).to_have_text("No problems")


def text_with_items_is_pasted_on_the_plan_and_other_text_refused_in_a_line(sheet):
    sheet.page.get_by_label("Search things").fill("hello")
    sheet.press("Control+a", "Control+c")
    sheet.plan.focus()
    sheet.press("Control+v")
    expect(sheet.page.locator(".toast.error")).to_contain_text("This text contains no item of a world")
    sheet.button("Close").click()
    sheet.page.get_by_label("Search things").fill("")
    sheet.text.get_by_text("name: bin").click()
    sheet.press("End", "Shift+Home", "Control+c")
    sheet.plan.focus()
    sheet.press("Control+v")
    sheet.reads("name: bin-2, cylinder: [0.2, 0.5], at:")
    menu = sheet.page.get_by_role("menu")
    sheet.page.mouse.click(*sheet.pixel(2, 2), button="right")
    menu.get_by_role("menuitem", name="Copy").click()
    sheet.press("Control+v")
    sheet.reads("name: crate-2")


def test_the_clipboard_holds_things_and_texts_with_items(sheet):
    text_with_items_is_pasted_on_the_plan_and_other_text_refused_in_a_line(sheet)
    sheet.put(ROOM)
    sheet.save()
    things_go_through_the_clipboard_to_the_text_and_to_another_world(sheet)
