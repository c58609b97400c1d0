"""Keys of the text are explained where the pointer rests on them, in a real browser."""

import re

import pytest
from playwright.sync_api import expect

from tests.sheet import sheet_of

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
name: room
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 1]
    sensors:
      - {lidar: scan, beams: 180, range: [0.05, 10]}
obstacles:
  - {box: [1, 1, 1], at: [3, 3], elevation: 0.5}
run:
  map: unknown
  drivers:
    scout:
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 1]]}
"""


def hovering_a_key_shows_its_unit_meaning_and_default(sheet):
    hint = sheet.page.locator(".cm-hint")
    for key, pieces in {
        "elevation": ["elevation [m]", "default 0"],
        "beams": ["beams", "default"],
        "map": ["map", "one of unknown, known"],
    }.items():
        sheet.text.locator("span").get_by_text(key, exact=True).hover()
        for piece in pieces:
            expect(hint).to_contain_text(piece)


def keys_and_values_are_offered_where_they_may_stand(sheet):
    page, options = sheet.page, sheet.page.locator(".cm-tooltip-autocomplete li")
    at_the_end_of(sheet, "at: [1, 1]", 0)
    page.keyboard.press("Enter")
    page.keyboard.type("odo")
    expect(options).to_have_text(["odometry"])
    page.keyboard.press("Escape")
    page.keyboard.type("metry: {tyres: {sw")
    expect(options).to_have_text(["swing[s]"])
    options.click()
    expect(sheet.text).to_contain_text("tyres: {swing: ")
    page.keyboard.type("0.01}}")
    at_the_end_of(sheet, "preset: pioneer3dx", 0)
    page.keyboard.press("Control+Backspace")
    page.keyboard.press("Control+Space")
    expect(options.filter(has_text="turtlebot3-burger").or_(options.filter(has_text="burger")).first).to_be_visible()
    page.keyboard.type("pioneer3dx ")
    expect(options).to_have_count(0)
    at_the_end_of(sheet, "map: unknown", 0)
    page.keyboard.press("Enter")
    page.keyboard.press("Control+Space")
    expect(options.filter(has_text="seconds")).to_be_visible()
    # What stands there already is not offered again.
    expect(options.filter(has_text="drivers")).to_have_count(0)


def robots_and_modules_are_offered_and_a_colon_that_stands_is_kept(sheet):
    options = sheet.page.locator(".cm-tooltip-autocomplete li")
    at_the_end_of(sheet, "scout:", 0)
    sheet.press("ArrowLeft", "Backspace", "Control+Space")
    expect(options).to_have_text(["scout"])
    options.click()
    expect(sheet.text.locator(".cm-line").filter(has_text=re.compile(r"^ +scout:$"))).to_have_count(1)
    sheet.press("End", "Enter")
    sheet.page.keyboard.insert_text("  estimator: {use: ")
    sheet.press("Control+Space")
    options.filter(has_text="EkfSlam").first.click()
    sheet.reads("estimator: {use: mjsim.algorithms.ekf_slam:EkfSlam")


def f12_leads_to_a_thing_by_its_name_and_to_the_text_of_a_module(sheet):
    page = sheet.page
    at_the_end_of(sheet, "    scout:", 1)
    page.keyboard.press("F12")
    dialog = page.get_by_role("dialog")
    expect(dialog).to_have_count(0)
    at_the_end_of(sheet, "mjsim.algorithms.waypoints:Way", 0)
    page.keyboard.press("F12")
    expect(dialog.get_by_role("heading")).to_have_text("mjsim.algorithms.waypoints")
    expect(dialog.locator(".begins")).to_contain_text("class Waypoints")
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)


def a_file_with_an_odd_name_is_offered_and_written_with_quotes(sheet):
    at_the_end_of(sheet, "include: [", 0)
    sheet.page.keyboard.type("rä")
    sheet.page.locator(".cm-tooltip-autocomplete li").click()
    sheet.reads('include: ["räum #2.yaml"')


def test_keys_and_values_of_the_text_are_explained_offered_and_lead_to_what_they_name(browser, tmp_path):
    (tmp_path / "räum #2.yaml").write_text("mjsim: 1\n")
    with sheet_of(browser, tmp_path, ROOM) as sheet:
        hovering_a_key_shows_its_unit_meaning_and_default(sheet)
        f12_leads_to_a_thing_by_its_name_and_to_the_text_of_a_module(sheet)
        keys_and_values_are_offered_where_they_may_stand(sheet)
        sheet.put(ROOM)
        robots_and_modules_are_offered_and_a_colon_that_stands_is_kept(sheet)
        sheet.put("mjsim: 1\ninclude: [\nname: room\n")
        a_file_with_an_odd_name_is_offered_and_written_with_quotes(sheet)


SELECT = """(line, columns) => {
  const places = columns.flatMap((left) => {
    const texts = document.createTreeWalker(line, NodeFilter.SHOW_TEXT);
    while (texts.nextNode() && left > texts.currentNode.length) left -= texts.currentNode.length;
    return [texts.currentNode, left];
  });
  getSelection().setBaseAndExtent(...places);
}"""


def stand(line, column: int, end: int | None = None) -> None:
    """Stand behind so many letters of a line of the text, or select from there to another column."""
    line.click()
    line.evaluate(SELECT, [column, column if end is None else end])


def at_the_end_of(sheet, piece: str, back: int) -> None:
    """Stand behind a piece of the text, or some letters before its end."""
    line = sheet.text.locator(".cm-line").filter(has_text=piece.strip()).first
    stand(line, line.inner_text().index(piece) + len(piece) - back)
