"""Pictures go with the wall on which they hang, in a real browser."""

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
walls:
  - {points: [[0, 0], [4, 0]]}
beacons:
  - {name: south, image: posters/lion.jpg, at: [1, -0.06], heading_deg: -90}   # outside
  - {name: north, image: posters/lion.jpg, at: [3, 0.06], heading_deg: 90}
  - {name: inward, image: posters/lion.jpg, at: [2.5, 0.06], heading_deg: -90}
  - {name: far, image: posters/lion.jpg, at: [2, 5], heading_deg: -90}
obstacles:
  - {box: [1, 1, 1], at: [2, -6]}
"""

QUARTER = """plan => {
  for (let k = 0; k < 6; k++) plan.dispatchEvent(new KeyboardEvent("keydown", { key: "[", bubbles: true }));
}"""
"""A quarter turn by keys, all before the first answer: what is written meanwhile is rounded to 0.1 mm."""


def pictures_go_with_their_wall_when_it_is_moved_turned_and_reshaped(sheet):
    stays = "name: inward, image: posters/lion.jpg, at: [2.5, 0.06]", "name: far, image: posters/lion.jpg, at: [2, 5]"
    sheet.click(0.4, 0)
    expect(sheet.title).to_contain_text("wall")
    sheet.drag((0, 0), (4, -4))  # the other end stays
    sheet.reads(
        "points: [[4, -4], [4, 0]]", "at: [4.06, -3], heading_deg: 0}   # outside", "at: [3.94, -1], heading_deg: 180}"
    )
    sheet.save()  # the text is ahead of the plan while a drag is on its way
    sheet.drag((4, -3.6), (5, -3.6))
    sheet.reads("points: [[5, -4], [5, 0]]", "at: [5.06, -3], heading_deg: 0}", "at: [4.94, -1], heading_deg: 180}")
    sheet.save()
    sheet.plan.evaluate(QUARTER)  # about its middle
    sheet.reads(
        "points: [[7, -2], [3, -2]]", "at: [6, -1.94], heading_deg: 90}", "at: [4, -2.06], heading_deg: -90}", *stays
    )
    sheet.press("Control+z", "Control+z", "Control+z")  # a step each
    sheet.reads(
        "points: [[0, 0], [4, 0]]", "at: [1, -0.06], heading_deg: -90}   # outside", "at: [3, 0.06], heading_deg: 90}"
    )
    sheet.page.keyboard.down("Shift")
    sheet.click(2, -6)
    sheet.page.keyboard.up("Shift")
    sheet.button("Align bottom edges").click()  # of the wall and the box, which is the lower one
    sheet.reads("points: [[0, -6.45], [4, -6.45]]", "at: [1, -6.51], heading_deg: -90}", "at: [3, -6.39]", *stays)


def pictures_go_with_their_wall_when_its_numbers_are_typed(sheet):
    sheet.click(0.4, 0)
    expect(sheet.title).to_contain_text("wall")
    sheet.page.locator(".panel summary", has_text="Points").click()
    corner = sheet.field("Points: 2 y")
    corner.fill("3")
    corner.press("Enter")
    sheet.reads("points: [[0, 0], [4, 3]]", "at: [0.836, 0.552], heading_deg: -53.13}   # outside")
    sheet.reads("at: [2.364, 1.848], heading_deg: 126.87}", "at: [2.5, 0.06], heading_deg: -90}")
    sheet.press("Control+z")  # a step of its own
    sheet.reads("points: [[0, 0], [4, 0]]", "at: [1, -0.06], heading_deg: -90}   # outside", "at: [3, 0.06]")


def pictures_stay_on_the_faces_of_a_wall_whose_thickness_is_typed(sheet):
    sheet.click(0.4, 0)
    expect(sheet.title).to_contain_text("wall")
    thickness = sheet.field("Thickness")
    thickness.fill("0.5")
    thickness.press("Enter")
    sheet.reads("thickness: 0.5", "at: [1, -0.26], heading_deg: -90}   # outside", "at: [3, 0.26], heading_deg: 90}")
    sheet.reads("inward, image: posters/lion.jpg, at: [2.5, 0.06]")
    sheet.press("Control+z")
    sheet.reads("at: [1, -0.06], heading_deg: -90}   # outside", "at: [3, 0.06], heading_deg: 90}")


def test_pictures_go_with_the_wall_on_which_they_hang(sheet):
    pictures_go_with_their_wall_when_its_numbers_are_typed(sheet)
    sheet.press("Escape")
    pictures_stay_on_the_faces_of_a_wall_whose_thickness_is_typed(sheet)
    sheet.press("Escape")
    pictures_go_with_their_wall_when_it_is_moved_turned_and_reshaped(sheet)
