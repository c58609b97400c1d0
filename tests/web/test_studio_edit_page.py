import re

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

from mjsim.world import load_world
from tests.sheet import Sheet, sheet_of
from tests.windows import without_portraits

pytestmark = pytest.mark.slow

ROOM = """\
# A room with a crate in the way.
mjsim: 1
name: room   # as its folder
walls:
  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]   # the shell
    closed: true
robots:
  - {name: scout, preset: pioneer3dx,   at: [1, 1]}   # looks east
run:
  drivers:
    scout: {avoidance: true}
obstacles:
  - {name: crate, box: [0.6, 0.4, 0.5], at: [2, 2]}   # it can be pushed?  no
"""


ALT_GR = """plan => plan.dispatchEvent(new KeyboardEvent("keydown", {
  key: "[", code: "Digit8", ctrlKey: true, altKey: true, modifierAltGraph: true, bubbles: true, cancelable: true,
}))"""
"""The sign [ as it is typed on a German keyboard under Windows."""


def saved(sheet: Sheet, folder) -> str:
    sheet.save()
    return (folder / "room.yaml").read_bytes().decode()


def what_is_typed_comes_onto_the_plan(sheet):
    sheet.text.click()
    sheet.press("Control+End")
    sheet.page.keyboard.insert_text("  - {name: barrel, cylinder: [0.3, 1], at: [4, 2")
    sheet.type("]}")
    sheet.press("ArrowLeft", "ArrowLeft", "Backspace")
    sheet.type("3")
    expect(sheet.title).to_have_text("barrel")  # where the cursor stands
    sheet.click(2, 2)
    expect(sheet.title).to_have_text("crate")
    expect(sheet.page.locator(".cm-chosen")).to_contain_text("crate")
    sheet.drag((4, 3), (5, 3))
    sheet.reads("at: [5, 3]")


def walls_are_drawn_corner_by_corner(sheet, tmp_path):
    sheet.press("w")
    for corner in ((1, 3), (3.02, 2.97), (2.97, 2)):  # drawn to the grid and to right angles
        sheet.click(*corner)
    sheet.press("Enter")
    sheet.reads("[[1, 3], [3, 3], [3, 2]]")
    for corner in ((4, 1), (5, 1), (5, 2), (4.02, 1.02)):
        sheet.click(*corner)
    sheet.reads("closed: true")
    shell = "  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]   # the shell\n    closed: true\n"
    assert saved(sheet, tmp_path).startswith(ROOM.partition(shell)[0] + shell)
    assert "[[4, 1], [5, 1], [5, 2]]" in saved(sheet, tmp_path)


def the_page_offers_each_kind_of_sensor_as_the_schema_has_it(sheet, tmp_path):
    without_portraits(sheet.page)
    sheet.press("r")
    sheet.page.get_by_title("Choose a robot").click()
    sheet.page.get_by_title("turtlebot3_burger", exact=True).click()
    sheet.page.get_by_role("checkbox", name="Camera", exact=True).uncheck()
    sheet.page.get_by_role("checkbox", name="Encoders", exact=True).check()
    sheet.page.get_by_role("checkbox", name="UWB", exact=True).check()
    sheet.drag((4, 2), (4, 3))
    sheet.reads("encoders: wheels", "uwb: tag")
    sheet.save()
    assert [sensor.kind for sensor in load_world(tmp_path / "room.yaml").robots[1].sensors] == ["encoders", "uwb"]


def doors_and_pictures_find_their_wall_and_robots_bring_sensors(sheet):
    sheet.press("d")
    sheet.click(3, 0.05)
    sheet.reads("width: 0.9")
    sheet.press("p")
    sheet.click(4.5, 0.2)
    sheet.reads("image: posters/lion.jpg", "at: [4.5, 0.06]", "heading_deg: 90")
    sheet.press("r")
    sheet.page.get_by_role("checkbox", name="Camera", exact=True).uncheck()
    sheet.page.get_by_role("checkbox", name="Lidar", exact=True).check()
    sheet.drag((4, 2), (4, 3))
    sheet.reads("lidar: scan", "at: [4, 2]")


def the_plan_is_worked_by_keys_alone(sheet, tmp_path):
    sheet.plan.focus()
    sheet.press("Tab")  # one stop for all things
    expect(sheet.plan).not_to_be_focused()
    sheet.plan.focus()
    sheet.press("PageDown", "PageDown", "PageDown", "PageUp", "PageDown")  # the wall, the robot, the crate
    expect(sheet.title).to_have_text("crate")
    sheet.press("ArrowRight", "ArrowRight", "Shift+ArrowUp")
    sheet.plan.evaluate(ALT_GR)
    sheet.reads("heading_deg: 15")
    number = re.search(r"at: \[([\d.]+), ([\d.]+)\], heading_deg: 15", saved(sheet, tmp_path))
    assert 2.0 < float(number[1]) < 3.0
    assert number[2] == "2.01"
    sheet.press("Control+ArrowUp")
    sheet.reads("3.01]")
    sheet.press("Control+ArrowDown", "Control+s")  # saved before its step was written
    assert number[0] in saved(sheet, tmp_path)
    sheet.press("Enter")
    expect(sheet.field("Name")).to_be_focused()
    sheet.press("Tab", "Tab")  # past its reset, to the first number of its place
    expect(sheet.field("At x")).to_be_focused()
    sheet.press("ArrowUp", "Enter")
    sheet.reads(f"at: [{round(float(number[1]) + 0.1, 4):g}, 2.01]")
    sheet.plan.focus()
    sheet.press("w", "ArrowRight", " ", *["ArrowRight"] * 5, " ", "Enter")
    expect(sheet.page.locator(".panel .kind")).to_have_text("Wall")
    sheet.press("Delete", "Escape")
    expect(sheet.page.locator(".panel .kind")).to_have_text("World")


def an_error_is_shown_in_the_panel_in_the_text_and_at_the_item(sheet):
    sheet.click(2, 2)
    sheet.field("Mass").fill("-3")
    sheet.press("Enter")
    expect(sheet.page.locator(".field-error")).to_contain_text("mass is -3")
    expect(sheet.page.locator(".cm-lintRange-error")).to_have_text("-3")
    expect(sheet.page.locator(".problem.error")).to_contain_text("line 13")
    x, y = sheet.pixel(2, 2)
    clip = {"x": x - 60, "y": y - 60, "width": 120, "height": 120}
    png = np.frombuffer(sheet.page.screenshot(clip=clip), np.uint8)
    red, green, blue = np.moveaxis(cv2.imdecode(png, cv2.IMREAD_COLOR_RGB).astype(int), -1, 0)
    assert ((red > green + 60) & (red > blue + 60)).sum() > 50  # a red edge about it
    sheet.text.click()
    sheet.press("Control+a")
    sheet.page.keyboard.insert_text(
        '{mjsim: 1, name: "\N{ROBOT FACE}", walls: [{points: [[0, 0], [1, 0]], height: -5}]}'
    )
    expect(sheet.page.locator(".cm-lintRange-error").last).to_have_text("-5")  # the robot is one letter


def a_new_name_of_a_robot_is_that_of_its_driver_and_of_events_too(sheet, tmp_path):
    events = """\
  events:
    - {time: 1, move: scout, to: [3, 3]}   # lifted
    - {time: 2, noise: robots.scout.odometry.noise.turn, value: 0.1}
    - {time: 3, noise: robots.0.odometry.scale, value: 1.1}
    - {time: 4, remove: crate}
"""
    before = ROOM.replace("obstacles:", events + "obstacles:")
    sheet.put(before)
    sheet.click(1, 1)
    sheet.field("Name").fill("rover")
    sheet.press("Enter")
    expect(sheet.title).to_have_text("rover")
    assert saved(sheet, tmp_path) == before.replace("scout", "rover")


def a_wall_that_is_begun_stays_in_its_world(sheet):
    sheet.plan.focus()
    sheet.press("w")
    sheet.click(1, 3)
    sheet.click(2, 3)
    sheet.button("New world").click()
    sheet.button("Empty room").click()
    expect(sheet.title).to_have_text("room")
    sheet.plan.focus()
    sheet.press("v")
    expect(sheet.button("Draw the first wall")).to_be_visible()


def a_drag_changes_its_numbers_alone_undo_leads_back_to_the_same_bytes_and_redo_forth_again(sheet, tmp_path, text):
    sheet.drag((2, 2), (3, 2.5))
    sheet.reads("at: [3, 2.5]")
    assert saved(sheet, tmp_path) == text.replace("at: [2, 2]", "at: [3, 2.5]")
    sheet.press("Control+d")
    sheet.reads("crate-2")
    sheet.click(1, 1)
    sheet.press("Delete")
    expect(sheet.text).not_to_contain_text("scout")
    sheet.text.click()
    sheet.type("light: 0.5")
    changed = saved(sheet, tmp_path)
    assert "\n" not in changed.replace("\r\n", "")
    undo = sheet.button("Undo (Ctrl+Z)")
    expect(undo).to_be_enabled()
    while undo.is_enabled():
        sheet.press("Control+z")
    sheet.reads("at: [2, 2]", "scout")
    assert saved(sheet, tmp_path) == text
    redo = sheet.button("Redo (Ctrl+Shift+Z)")
    while redo.is_enabled():
        sheet.press("Control+Shift+z")
    assert saved(sheet, tmp_path) == changed


def work_that_was_not_saved_is_offered_after_a_reload_until_it_is_saved(sheet, tmp_path):
    sheet.drag((2, 2), (3, 2.5))
    expect(sheet.unsaved).to_be_visible()
    for answer, place in (("Restore", "at: [3, 2.5]"), ("Discard", "at: [2, 2]")):
        sheet.page.once("dialog", lambda question: question.accept())  # of the browser: leave the page?
        sheet.page.reload()
        expect(sheet.page.get_by_role("dialog", name="Unsaved changes")).to_contain_text("room.yaml")
        sheet.button(answer).click()
        expect(sheet.page.get_by_role("dialog")).to_have_count(0)
        sheet.reads(place)
    expect(sheet.unsaved).to_be_hidden()
    sheet.page.reload()
    sheet.reads("at: [2, 2]")
    expect(sheet.page.get_by_role("dialog")).to_have_count(0)
    assert (tmp_path / "room.yaml").read_text() == ROOM


def test_what_is_drawn_typed_or_put_down_is_in_the_text_and_on_the_plan(sheet, tmp_path):
    what_is_typed_comes_onto_the_plan(sheet)
    sheet.put(ROOM)
    walls_are_drawn_corner_by_corner(sheet, tmp_path)
    sheet.put(ROOM)
    the_page_offers_each_kind_of_sensor_as_the_schema_has_it(sheet, tmp_path)
    sheet.put(ROOM)
    doors_and_pictures_find_their_wall_and_robots_bring_sensors(sheet)
    sheet.put(ROOM)
    the_plan_is_worked_by_keys_alone(sheet, tmp_path)
    sheet.put(ROOM)
    an_error_is_shown_in_the_panel_in_the_text_and_at_the_item(sheet)
    a_new_name_of_a_robot_is_that_of_its_driver_and_of_events_too(sheet, tmp_path)
    a_wall_that_is_begun_stays_in_its_world(sheet)


def test_undo_leads_back_to_the_same_bytes_and_what_is_not_saved_is_offered_after_a_reload(browser, tmp_path):
    text = ROOM.replace("\n", "\r\n")
    with sheet_of(browser, tmp_path, text) as sheet:
        a_drag_changes_its_numbers_alone_undo_leads_back_to_the_same_bytes_and_redo_forth_again(sheet, tmp_path, text)
        (tmp_path / "room.yaml").write_text(ROOM)
        sheet.reads("at: [2, 2]")
        work_that_was_not_saved_is_offered_after_a_reload_until_it_is_saved(sheet, tmp_path)
