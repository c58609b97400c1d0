"""Numbers that are typed into fields are read as they are meant, or refused in a line, in a real browser."""

import re

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
obstacles: [{name: post, box: [2, 2, 2], at: [1, 1], heading_deg: 20}]
people: [{name: eve, sex: female, at: [4, 1]}]
robots: [{name: scout, preset: pioneer3dx, at: [8, 8]}]
run: {drivers: {scout: {}}}
"""


def a_number_with_a_comma_is_refused_as_nobody_knows_what_it_separates(sheet):
    sheet.click(1, 1)
    field, line = sheet.field("At x"), sheet.page.locator(".field-error")
    for text in ("1,000", "1,5"):
        field.fill(text)
        field.press("Enter")
        expect(line).to_have_text(
            f"'{text}' has a comma; write decimals with a point, and thousands without a separator: 1.5, 1000"
        )
    field.fill("3.5")
    field.press("Enter")
    sheet.reads("box: [2, 2, 2], at: [3.5, 1]")
    expect(line).to_have_count(0)


def a_button_gets_its_click_although_a_line_appears_above_it_and_not_if_the_pointer_leaves_it(sheet):
    sheet.click(3.5, 1)
    button = sheet.page.locator(".panel").get_by_title("Reset heading to its default")
    press(sheet, button, leave=True)
    sheet.reads("heading_deg: 20")
    press(sheet, button, leave=False)
    expect(sheet.text).not_to_contain_text("heading_deg")


def press(sheet, button, *, leave):
    """Press a button while a field above it has a number with a comma: the line that says so moves the button."""
    field = sheet.field("At x")
    field.fill("1,5")
    box = button.bounding_box()
    sheet.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 3)
    sheet.page.mouse.down()
    expect(sheet.page.locator(".field-error")).to_have_count(1)
    assert button.bounding_box()["y"] > box["y"] + 3
    if leave:
        sheet.page.mouse.move(box["x"] - 40, box["y"] + 3)
    sheet.page.mouse.up()
    field.press("Escape")
    expect(sheet.page.locator(".field-error")).to_have_count(0)


def a_name_that_cannot_be_one_is_refused_in_a_line_and_is_followed_nowhere(sheet):
    sheet.click(3.5, 1)
    field = sheet.field("Name")
    for text in ("a/b", "my post", "-x"):
        field.fill(text)
        field.press("Enter")
        expect(sheet.page.locator(".field-error")).to_contain_text(f"'{text}' is not a name; use letters")
    sheet.reads("name: post")
    for text in ("кот-1", "pillar"):
        field.fill(text)
        field.press("Enter")
        sheet.reads(text)
    expect(sheet.page.locator(".field-error")).to_have_count(0)
    sheet.page.get_by_role("treeitem").filter(has_text="scout").click()
    field.fill("run")
    field.press("Enter")
    expect(sheet.page.locator(".field-error")).to_have_text(re.compile("^'run' is reserved"))
    field.fill("rover")
    field.press("Enter")
    sheet.reads("drivers: {rover: {}}")


def an_empty_field_of_a_joint_or_a_hand_moves_nothing(sheet):
    sheet.click(4, 1)
    for field in (sheet.page.get_by_label("left_elbow_flexion, °"), sheet.page.get_by_label("left hand x, m")):
        field.evaluate("field => { for (let each = field; each; each = each.parentElement) each.open = true; }")
        before = field.input_value()
        field.fill("")
        field.press("Tab")
        expect(field).to_have_value(before)
    sheet.reads("eve, sex: female, at: [4, 1]}")
    expect(sheet.unsaved).to_be_hidden()


def test_numbers_that_are_typed_are_read_as_they_are_meant_or_refused_in_a_line(sheet):
    an_empty_field_of_a_joint_or_a_hand_moves_nothing(sheet)
    a_number_with_a_comma_is_refused_as_nobody_knows_what_it_separates(sheet)
    a_button_gets_its_click_although_a_line_appears_above_it_and_not_if_the_pointer_leaves_it(sheet)
    a_name_that_cannot_be_one_is_refused_in_a_line_and_is_followed_nowhere(sheet)
