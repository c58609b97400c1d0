"""Who edits with the keyboard alone, many things at once, or faster than the server answers, gets what was meant."""

import re

import pytest
from playwright.sync_api import expect

from tests.sheet import DRAWN, sheet_of
from tests.windows import without_portraits

pytestmark = pytest.mark.slow

LONG = "x" * 64
ROOM = f"""\
mjsim: 1
walls:
  - {{name: slant, points: [[1, 1], [3, 4]], openings: [{{name: gate, at: 1, width: 0.9}}]}}
  - {{name: far, points: [[1, 5], [3, 5]]}}
  - {{name: near, points: [[1, 5.06], [3, 5.06]]}}
  - {{name: downwards, points: [[9, 4], [9, 0]]}}
  - {{name: short, points: [[4, 5], [4.555, 5]]}}
obstacles:
  - {{name: desk, box: [0.8, 0.4, 0.7], at: [6, 2], movable: true, friction: 0.00002}}
  - {{name: stool, box: [0.4, 0.3, 0.5], at: [6, 4], seat: {{at: [0, 0, 0.5]}}}}
  - {{name: {LONG}, box: [0.4, 0.3, 0.5], at: [8, 5]}}
beacons:
  - {{name: lion, image: posters/owl.jpg, at: [0.41, 0], on: desk, heading_deg: 0}}
  - {{name: mirror, at: [-0.41, 0], on: desk, heading_deg: 180}}
  - {{name: tag, marker: {{dictionary: 4x4_50, id: 49}}, at: [8, 0], heading_deg: 90}}
people:
  - {{name: ann, sex: female, seat: stool}}
robots:
  - {{name: puma, base: fixed, at: [4, -2], arms: [{{preset: puma560}}], sensors: [{{camera: eye, on: arm/tool}}]}}
"""
JUDGED = {"distance": 3.2, "fault": "it resembles posters/lion.jpg so much that one is taken for the other"}
WEDGES = """() => {
  window.wedges = 0;
  const { createRadialGradient } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.createRadialGradient = function (...circles) {
    window.wedges += 1;
    return createRadialGradient.apply(this, circles);
  };
}"""
LATE = """() => {
  const { fetch } = window;
  window.fetch = async (address, request) => {
    if (address === "/api/edit") await new Promise((done) => setTimeout(done, 300));
    return fetch(address, request);
  };
}"""


def row(sheet, name):
    return sheet.page.get_by_role("treeitem").filter(has_text=name).first


def choose(sheet, name):
    """Click a row, and wait until the panel is that of its thing: it is drawn with the next picture."""
    row(sheet, name).click()
    expect(sheet.title).to_contain_text(name)


def both(sheet, one, other):
    row(sheet, one).click()
    row(sheet, other).click(modifiers=["Control"])


def fields_of_several_things_say_what_differs_and_leave_it_as_it_is(sheet):
    missing = []
    sheet.page.on("response", lambda answer: missing.append(answer.url) if answer.status >= 400 else None)
    both(sheet, "lion", "tag")
    expect(sheet.page.locator(".panel .pick .path")).to_have_text("several")
    both(sheet, "desk", "stool")
    expect(sheet.field("Box width")).to_have_attribute("placeholder", "several")
    sheet.field("Box height").fill("0.6")
    sheet.press("Enter")
    sheet.reads("name: desk, box: [0.8, 0.4, 0.6]", "name: stool, box: [0.4, 0.3, 0.6]")
    assert missing == []


def the_keyboard_stays_where_it_was_or_goes_to_what_is_next_to_it(sheet):
    row(sheet, "desk").click()
    expect(sheet.field("Friction")).to_have_value("0.00002")  # no zero
    reset = sheet.button("Reset friction to its default")
    reset.focus()
    sheet.press("Enter")
    expect(reset).to_have_count(0)
    expect(sheet.field("Friction")).to_be_focused()
    sheet.plan.focus()
    sheet.press("p")
    expect(sheet.page.get_by_title("View in 3-D")).to_be_visible()  # beside the choices of any tool
    kind = sheet.page.get_by_label("Kind")
    kind.focus()
    sheet.press("ArrowDown", "ArrowDown")
    expect(kind).to_be_focused()
    expect(kind).to_have_value("reflector")
    kind.select_option("picture")


def what_is_drawn_fits_the_walls(sheet):
    sheet.plan.focus()
    sheet.press("w")
    sheet.click(2.02, 5.08)  # on the nearest of two walls
    sheet.click(2.02, 5.5)
    sheet.press("Enter")
    sheet.reads("points: [[2.02, 5.06], [2.02, 5.")
    sheet.press("p")
    sheet.click(8.8, 2)
    sheet.reads("heading_deg: 180")  # not -180
    sheet.press("d")
    sheet.click(4.3, 5)
    sheet.reads("width: 0.55")
    sheet.press("Escape")
    row(sheet, "gate").click()
    sheet.drag((1 + 1.9 * 0.5547, 1 + 1.9 * 0.83205), (3.4, 4.6))
    expect(sheet.text).to_contain_text(re.compile(r"at: 1, width: 2\.6\d"))
    expect(sheet.page.locator(".problems")).to_have_text("No problems")


def what_a_camera_on_an_arm_has_in_view_is_not_drawn_as_if_it_were_on_the_base(sheet):
    sheet.page.route("**/api/preview", lambda route: route.fulfill(content_type="image/jpeg", body=b""))
    sheet.page.evaluate(WEDGES)
    sheet.click(4, -2)
    expect(sheet.title).to_have_text("puma")
    sheet.page.evaluate(DRAWN)
    assert sheet.page.evaluate("window.wedges") == 0


def a_space_bar_that_is_let_go_in_another_window_is_not_held_here(sheet):
    sheet.plan.focus()
    sheet.press("v")
    sheet.page.mouse.move(*sheet.pixel(8, 5))
    sheet.page.keyboard.down(" ")
    sheet.page.evaluate("window.dispatchEvent(new Event('blur'))")
    sheet.drag((8, 5), (8, 4))
    sheet.page.keyboard.up(" ")
    sheet.reads(f"name: {LONG}, box: [0.4, 0.3, 0.5], at: [8, 4]")  # the thing is moved, not the paper


def a_press_that_ends_outside_a_dialog_or_on_its_edge_leaves_it_open(sheet):
    sheet.plan.focus()
    without_portraits(sheet.page)
    sheet.press("r")
    sheet.page.get_by_title("Choose a robot").click()
    dialog = sheet.page.get_by_role("dialog")
    search, box = dialog.locator("input").bounding_box(), dialog.bounding_box()
    sheet.page.mouse.click(box["x"] + 6, box["y"] + 100)
    sheet.page.mouse.move(search["x"] + 20, search["y"] + 10)
    sheet.page.mouse.down()
    sheet.page.mouse.move(5, 300)
    sheet.page.mouse.up()
    expect(dialog).to_be_visible()
    sheet.page.mouse.click(5, 300)
    expect(dialog).to_have_count(0)


def names_are_followed_fit_and_are_free_before_the_last_change_is_answered(sheet):
    choose(sheet, "stool")
    sheet.field("Name").fill("chair")
    sheet.press("Enter")
    sheet.reads("name: chair, box", "seat: chair")
    sheet.page.evaluate(LATE)
    choose(sheet, "desk")
    sheet.field("Box length").fill("1.1")
    sheet.press("Tab")
    sheet.type("0.9")
    sheet.press("Enter")
    sheet.reads("name: desk, box: [1.1, 0.9, 0.")
    sheet.press("p")
    sheet.page.get_by_label("Kind").select_option("marker")
    sheet.click(3, 1)
    sheet.click(4, 1)
    sheet.reads(*(f'name: tag{k}, marker: {{dictionary: "4x4_50", id: {k}}}' for k in (0, 1)))
    sheet.press("Escape")
    both(sheet, "desk", "mirror")
    sheet.plan.focus()
    sheet.press("Control+d", "Control+d")
    # What hangs on the desk hangs on its copy, at the same place of that.
    sheet.reads("name: desk-2", "at: [-0.41, 0], on: desk-2", "name: desk-3", "at: [-0.41, 0], on: desk-3")
    desks = re.findall(r"name: desk.*? at: (\[.*?\])", sheet.text.inner_text())
    assert len(set(desks)) == 3  # each beside the one before
    row(sheet, LONG).click()
    sheet.plan.focus()
    sheet.press("Control+d")
    sheet.reads(f"name: {LONG[:-2]}-2")  # no longer than names may be
    expect(sheet.page.locator(".problems")).to_have_text("No problems")


def a_press_counts_although_what_was_typed_before_it_draws_the_panel_anew(sheet):
    sheet.plan.focus()
    sheet.press("v")
    choose(sheet, "stool")
    sheet.field("Box height").fill("0.55")
    hold(sheet, sheet.page.get_by_title("Duplicate (Ctrl+D)"), until="[0.4, 0.3, 0.55]")
    sheet.reads("name: stool-2")
    sheet.press("Control+z", "Control+z")
    sheet.reads("name: stool, box: [0.4, 0.3, 0.6]")


def what_is_typed_and_marked_stays_while_the_answer_to_the_last_change_draws_the_panel_anew(sheet):
    choose(sheet, "chair")
    sheet.field("Box length").fill("0.45")
    sheet.press("Tab")
    sheet.type("0.35")
    sheet.press("Shift+ArrowLeft", "Shift+ArrowLeft")
    field = sheet.page.evaluate_handle("document.activeElement")
    sheet.reads("name: chair, box: [0.45, 0.3, ")
    sheet.page.evaluate(DRAWN)
    assert field.evaluate("each => each === document.activeElement && each.isConnected")
    assert field.evaluate("each => [each.value, each.selectionStart, each.selectionEnd]") == ["0.35", 2, 4]
    sheet.press("Escape")
    expect(sheet.field("Box width")).to_have_value("0.3")


def hold(sheet, button, *, until):
    """Press a button, and let it go when the text reads something else, and all is drawn."""
    box = button.bounding_box()
    sheet.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    sheet.page.mouse.down()
    sheet.reads(until)
    sheet.page.evaluate(DRAWN)
    sheet.page.mouse.up()


def a_picture_keeps_its_place_and_its_name_while_recognition_judges_it(sheet):
    asked = []
    sheet.page.route("**/api/judge", lambda route: asked.append(route))
    sheet.plan.focus()
    sheet.press("p")
    sheet.page.get_by_label("Kind").select_option("picture")
    sheet.page.locator(".strip-tool .pick").click()
    picture = sheet.page.get_by_role("dialog").get_by_role("button", name="cat.jpg", exact=True)
    picture.scroll_into_view_if_needed()
    box = picture.bounding_box()
    sheet.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] - 4)
    sheet.page.mouse.down()
    (route,) = asked
    route.fulfill(json={"pictures": {f"posters/{name}.jpg": JUDGED for name in ("cat", "lion", "bear", "fox")}})
    expect(picture).to_contain_text("resembles")
    assert picture.bounding_box() == box
    sheet.page.mouse.up()
    sheet.click(8.8, 3)
    sheet.reads("image: posters/cat.jpg")


def test_a_quick_hand_gets_what_was_meant(browser, tmp_path):
    with sheet_of(browser, tmp_path, ROOM) as sheet:  # each part has things of its own
        sheet.page.set_viewport_size({"width": 1400, "height": 1300})  # so that each thing has its row in sight
        sheet.page.evaluate(DRAWN)
        what_is_drawn_fits_the_walls(sheet)
        fields_of_several_things_say_what_differs_and_leave_it_as_it_is(sheet)
        the_keyboard_stays_where_it_was_or_goes_to_what_is_next_to_it(sheet)
        sheet.plan.focus()
        sheet.press("v")
        what_a_camera_on_an_arm_has_in_view_is_not_drawn_as_if_it_were_on_the_base(sheet)
        a_space_bar_that_is_let_go_in_another_window_is_not_held_here(sheet)
        a_press_that_ends_outside_a_dialog_or_on_its_edge_leaves_it_open(sheet)
        a_press_counts_although_what_was_typed_before_it_draws_the_panel_anew(sheet)
        a_picture_keeps_its_place_and_its_name_while_recognition_judges_it(sheet)
        names_are_followed_fit_and_are_free_before_the_last_change_is_answered(sheet)
        what_is_typed_and_marked_stays_while_the_answer_to_the_last_change_draws_the_panel_anew(sheet)
