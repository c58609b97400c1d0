"""Repeated and included items are told apart and become items of the text's own, in a real browser."""

import pytest
from playwright.sync_api import expect

from tests.sheet import sheet_of

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
name: room
include: [hall.yaml]   # the shell
obstacles:
  # Four desks.
  - {name: desk, box: [1.2, 0.8, 0.75], at: [1.5, 1.2], repeat: {times: 4, offset: [2, 0]}}   # oak
"""
HALL = "mjsim: 1\nobstacles: [{name: shelf, box: [2, 0.5, 1.8], at: [4, 3]}]\n"


def test_repeated_and_included_items_are_made_single(browser, tmp_path):
    (tmp_path / "hall.yaml").write_text(HALL)
    with sheet_of(browser, tmp_path, ROOM) as sheet:
        menu = sheet.page.get_by_role("menu")
        sheet.click(3.5, 1.2)
        expect(sheet.title).to_have_text("desk-2")
        expect(sheet.page.locator(".panel .note")).to_contain_text("one repetition of the item in line 6;")
        sheet.button("Make single").click()
        sheet.reads("name: desk-1, box: [1.2, 0.8, 0.75], at: [1.5, 1.2]}   # oak", 'name: "desk-${i + 3}"')
        expect(sheet.page.locator(".panel .note")).to_have_count(0)
        expect(sheet.title).to_have_text("desk-2")
        sheet.drag((3.5, 1.2), (3.5, 2))
        sheet.reads("name: desk-2, box: [1.2, 0.8, 0.75], at: [3.5, 2]")
        sheet.page.mouse.click(*sheet.pixel(5.5, 1.2), button="right")
        menu.get_by_role("menuitem", name="Make all single").click()
        sheet.reads('name: "desk-3"', "name: desk-4")
        sheet.page.mouse.click(*sheet.pixel(4, 3), button="right")
        expect(menu.get_by_role("menuitem", name="Go to line")).to_have_count(0)  # it stands in no line of this text
        menu.get_by_role("menuitem", name="Make single").click()
        expect(sheet.text).not_to_contain_text("include")
        sheet.reads("name: shelf", "# Four desks.")
        sheet.button("Undo steps").click()
        expect(menu.get_by_role("menuitemradio")).to_have_text(
            ["Make single shelf", "Make single desk-3", "Move desk-2", "Make single desk-2", "Opened"]
        )
        menu.get_by_text("Opened").click()
        expect(sheet.unsaved).to_be_hidden()
