"""Things are found in the outliner, have a menu, and are aligned and spread, in a real browser."""

import pytest
from playwright.sync_api import expect

from mjsim.world import load_world

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
walls:
  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}
robots:
  - {name: scout, preset: pioneer3dx, at: [1, 1]}
run:
  drivers:
    scout: {avoidance: true}
obstacles:
  - {name: crate, box: [0.6, 0.4, 0.5], at: [2, 2]}
  - {name: bin, cylinder: [0.2, 0.5], at: [3.25, 2.5]}
  - {name: chest, box: [0.4, 0.4, 0.5], at: [5, 3]}
  - {name: "post", cylinder: [0.02, 1], at: [1, 3.5], repeat: {times: 300, offset: [0.016, 0]}}
"""


def chosen(sheet):
    return sheet.page.locator(".outline-row[aria-selected=true]")


def row(sheet, name):
    return sheet.page.get_by_role("treeitem").filter(has_text=name)


def the_outliner_is_tied_to_the_plan_searched_and_worked_by_keys(sheet):
    tree, search = sheet.page.get_by_role("tree"), sheet.page.get_by_label("Search things")
    expect(sheet.page.locator(".outline-head .count")).to_have_text("305")
    assert sheet.page.get_by_role("treeitem").count() < 40  # of 305 things and four kinds
    sheet.click(2, 2)
    expect(chosen(sheet)).to_contain_text("crate")
    search.fill("POST-29")
    expect(sheet.page.locator(".outline-head .count")).to_have_text("11 of 305")
    row(sheet, "post-299").click()
    expect(sheet.title).to_have_text("post-299")
    expect(chosen(sheet)).to_contain_text("one repetition")
    search.fill("pioneer")
    search.press("ArrowDown")
    sheet.press("Home", "ArrowDown")
    expect(tree).to_be_focused()
    expect(sheet.title).to_have_text("scout")
    sheet.press("F2")
    name = sheet.page.get_by_label("New name")
    name.dispatch_event("keydown", {"key": "Escape", "isComposing": True, "bubbles": True})  # of an input method
    expect(name).to_be_focused()
    sheet.type("rover")
    sheet.press("Enter")
    sheet.reads("name: rover", "rover: {avoidance: true}")


def the_menu_offers_what_applies_by_mouse_and_by_keys(sheet):
    menu = sheet.page.get_by_role("menu")
    sheet.page.mouse.click(*sheet.pixel(2, 2), button="right")
    expect(menu).to_have_accessible_name("crate")
    expect(menu.get_by_role("menuitem", name="Paste")).to_be_visible()
    menu.get_by_role("menuitem", name="Turn 90° left").click()
    sheet.reads("heading_deg: 90")
    sheet.plan.focus()
    sheet.press("Shift+F10")
    expect(menu.get_by_role("menuitem", name="Cut")).to_be_focused()
    sheet.press("Escape")
    expect(menu).to_have_count(0)
    expect(sheet.plan).to_be_focused()
    sheet.press("Shift+F10", "ArrowUp", "ArrowUp", "Enter")
    expect(sheet.text).to_be_focused()
    sheet.page.mouse.click(*sheet.pixel(2, 3.5), button="right")
    expect(menu.get_by_role("menuitem", name="Copy")).to_be_visible()
    expect(menu.get_by_role("menuitem", name="Delete")).to_have_count(0)  # one repetition of several


def several_things_are_aligned_and_distributed_each_by_one_step_of_undo(sheet, tmp_path):
    def places():
        return [thing.at for thing in load_world(tmp_path / "room.yaml").obstacles[:3]]

    row(sheet, "crate").click()
    row(sheet, "chest").click(modifiers=["Shift"])
    expect(sheet.title).to_have_text("3 selected")
    sheet.field("Elevation").fill("0.25")  # boxes and a cylinder share it
    sheet.press("Enter")
    sheet.reads("at: [2, 2], elevation: 0.25", "at: [3.25, 2.5], elevation: 0.25", "at: [5, 3], elevation: 0.25")
    expect(sheet.page.locator(".panel").get_by_label("Box", exact=True)).to_have_count(0)
    sheet.press("Control+z")
    sheet.reads("at: [2, 2]}", "at: [5, 3]}")
    sheet.button("Align bottom edges").click()
    sheet.reads("at: [5, 2]")
    sheet.save()
    assert places() == [(2, 2), (3.25, 2), (5, 2)]
    sheet.press("Control+z")
    sheet.reads("at: [5, 3]", "at: [3.25, 2.5]")
    sheet.button("Distribute left to right").click()
    sheet.reads("at: [3.5, 2.5]", "at: [5, 3]")
    sheet.press("Control+z")
    sheet.reads("at: [3.25, 2.5]")


def test_things_are_aligned_have_a_menu_and_are_found_and_renamed_in_the_outliner(sheet, tmp_path):
    several_things_are_aligned_and_distributed_each_by_one_step_of_undo(sheet, tmp_path)
    sheet.press("Escape")
    the_menu_offers_what_applies_by_mouse_and_by_keys(sheet)
    sheet.press("Escape")
    the_outliner_is_tied_to_the_plan_searched_and_worked_by_keys(sheet)
