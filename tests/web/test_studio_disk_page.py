"""Changes on disk, by other tabs or programs, are seen; nobody's text is lost by them."""

import json
import re

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

from tests.sheet import DRAWN, sheet_of
from tests.unsaved import ROOM, THEIRS, kept, notice, number_kept, second_tab, write_line

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("state")]
OWN_WINDOW = True


def test_what_one_tab_saves_the_other_reads_unless_it_has_changes_of_its_own(sheet, tmp_path):
    reader, writer = second_tab(sheet), second_tab(sheet)
    write_line(writer, "# writer's")
    kept("# writer's")
    write_line(sheet, "# saved")
    sheet.save()
    reader.reads("# saved")
    expect(reader.unsaved).to_be_hidden()
    reader.press("Control+z")
    expect(reader.text).not_to_contain_text("# saved")
    found = notice(writer, "room.yaml changed on disk, and you have unsaved changes here.")
    found.get_by_role("button", name="Keep both").click()
    expect(writer.page.locator(".world .name")).to_have_text("room-2.yaml")
    expect(writer.unsaved).to_be_hidden()
    assert (tmp_path / "room.yaml").read_text() == ROOM + "# saved"
    assert (tmp_path / "room-2.yaml").read_text() == ROOM + "# writer's"


def test_a_file_that_changes_on_disk_is_read_again_as_a_step_that_can_be_undone(sheet, tmp_path):
    sheet.click(2, 2)
    expect(sheet.title).to_have_text("crate")
    (tmp_path / "room.yaml").write_text(THEIRS)
    sheet.reads("barrel")
    expect(sheet.page.locator(".toast")).to_contain_text("room.yaml changed on disk and was reloaded")
    expect(sheet.unsaved).to_be_hidden()
    expect(sheet.page.locator(".panel .kind")).to_have_text("World")  # what is there now is another thing
    sheet.press("Control+z")
    sheet.reads("crate")
    expect(sheet.unsaved).to_be_visible()
    sheet.save()  # what was undone is what the person wants
    assert (tmp_path / "room.yaml").read_text() == ROOM
    (tmp_path / "room.yaml").write_bytes(THEIRS.replace("\n", "\r\n").encode())
    sheet.reads("barrel")
    write_line(sheet, "# mine")
    sheet.press("Enter")
    sheet.save()
    assert (tmp_path / "room.yaml").read_bytes() == (THEIRS + "# mine\n").replace("\n", "\r\n").encode()


def test_a_late_notice_of_the_pages_own_save_is_ignored(sheet, tmp_path):
    links = []
    sheet.page.route_web_socket(re.compile("/api/tab"), lambda link: links.append((link, link.connect_to_server())))
    sheet.page.reload()
    sheet.reads("mjsim: 1")
    write_line(sheet, "# mine")
    sheet.save()
    write_line(sheet, " and more")
    with sheet.page.expect_response("**/api/open*"):
        links[-1][0].send(json.dumps({"kind": "disk", "path": "room.yaml", "stamp": "of a save before"}))
    sheet.page.evaluate(DRAWN)
    expect(sheet.page.locator(".notice")).to_have_count(0)
    (tmp_path / "room.yaml").write_text(THEIRS)
    notice(sheet, "room.yaml changed on disk, and you have unsaved changes here.")


def test_with_changes_of_ones_own_one_is_asked_and_nothing_is_lost(sheet, tmp_path):
    place = tmp_path / "room.yaml"
    write_line(sheet, "# mine")
    place.write_text(THEIRS)
    found = notice(sheet, "room.yaml changed on disk, and you have unsaved changes here.")
    write_line(sheet, " too")  # it does not take the keyboard
    found.get_by_role("button", name="Load the file on disk").click()
    sheet.reads("barrel")
    expect(found).to_be_hidden()
    expect(sheet.unsaved).to_be_hidden()
    sheet.press("Control+z")
    sheet.reads("crate", "# mine too")
    place.write_text(ROOM.replace("crate", "bin"))
    found = notice(sheet, "room.yaml changed on disk")
    found.get_by_role("button", name="Keep mine").click()
    expect(found).to_be_hidden()
    sheet.reads("crate", "# mine too")
    assert "bin" in place.read_text()
    sheet.save()
    assert place.read_text() == ROOM + "# mine too"


def what_is_typed_into_a_field_while_the_file_changes_is_given_on_at_enter_and_not_before(sheet, tmp_path):
    sheet.click(2, 2)
    mass = sheet.field("Mass")
    mass.click()
    sheet.type("1")
    (tmp_path / "room.yaml").write_text(ROOM + "# theirs")
    sheet.reads("# theirs")
    sheet.page.evaluate(DRAWN)
    sheet.type("2")
    expect(mass).to_have_value("12")
    expect(sheet.text).not_to_contain_text("mass")
    sheet.press("Shift+ArrowLeft")  # marked, it is still so when all is drawn anew
    (tmp_path / "room.yaml").write_text(ROOM + "# theirs again")
    sheet.reads("# theirs again")
    sheet.page.evaluate(DRAWN)
    sheet.type("5")
    (tmp_path / "room.yaml").write_text(ROOM + "# theirs at last")
    sheet.reads("# theirs at last")
    sheet.page.evaluate(DRAWN)
    sheet.press("Enter")
    sheet.reads("mass: 15")


def test_a_drag_that_goes_on_while_the_file_changes_is_not_lost(sheet, tmp_path):
    other = second_tab(sheet)
    sheet.page.bring_to_front()
    sheet.page.mouse.move(*sheet.pixel(2, 2))
    sheet.page.mouse.down()
    sheet.page.mouse.move(*sheet.pixel(3, 2.5), steps=4)
    sheet.reads("at: [3, 2.5]")  # as it would be
    (tmp_path / "room.yaml").write_text(THEIRS + "light: 0.5\n")
    other.reads("barrel")
    sheet.page.mouse.up()
    notice(sheet, "room.yaml changed on disk").get_by_role("button", name="Load the file on disk").click()
    sheet.reads("barrel", "at: [2, 2]")
    sheet.press("Control+z")
    sheet.reads("crate", "at: [3, 2.5]")


def a_notice_that_was_closed_comes_back_when_the_file_changes_again(sheet, tmp_path):
    write_line(sheet, "# mine")
    (tmp_path / "room.yaml").write_text(THEIRS)
    found = notice(sheet, "room.yaml changed on disk")
    found.get_by_role("button", name="Close").click()
    write_line(sheet, " more")
    kept("# mine more")
    expect(found).to_be_hidden()
    sheet.press("Control+s")  # which asks all the same
    expect(sheet.page.get_by_role("dialog")).to_contain_text("has changed since it was read")
    sheet.press("Escape")
    assert (tmp_path / "room.yaml").read_text() == THEIRS
    (tmp_path / "room.yaml").write_text(ROOM + "# third\n")
    notice(sheet, "room.yaml changed on disk")
    (tmp_path / "room.yaml").write_text(ROOM)  # as it was read
    expect(found).to_be_hidden()
    (tmp_path / "room.yaml").write_text(ROOM + "# mine more")  # as it is here
    expect(sheet.unsaved).to_be_hidden()


def test_restored_changes_of_an_older_file_are_not_saved_over_a_newer_one_unasked(browser, tmp_path):
    with sheet_of(browser, tmp_path, ROOM, own=True) as sheet:
        write_line(sheet, "# mine")
        kept("# mine")
    with sheet_of(browser, tmp_path, THEIRS, own=True) as sheet:
        sheet.button("Restore").click()
        sheet.reads("# mine", "crate")
        notice(sheet, "room.yaml changed on disk, and you have unsaved changes here.")
        sheet.press("Control+s")
        expect(sheet.page.get_by_role("dialog")).to_contain_text("has changed since it was read")
        assert (tmp_path / "room.yaml").read_text() == THEIRS


def a_file_that_is_removed_can_be_saved_again(sheet, tmp_path):
    (tmp_path / "room.yaml").unlink()
    found = notice(sheet, "room.yaml is no longer on disk")
    expect(sheet.unsaved).to_be_visible()
    kept("crate")
    found.get_by_role("button", name="Save it again").click()
    expect(sheet.unsaved).to_be_hidden()
    expect(found).to_be_hidden()
    assert (tmp_path / "room.yaml").read_text() == ROOM
    (tmp_path / "room.yaml").rename(tmp_path / "away.yaml")
    notice(sheet, "room.yaml is no longer on disk")
    (tmp_path / "away.yaml").rename(tmp_path / "room.yaml")
    expect(found).to_be_hidden()
    expect(sheet.unsaved).to_be_hidden()
    number_kept(0)


def test_a_file_that_is_removed_or_changes_while_one_types_loses_nothing(sheet, tmp_path):
    a_file_that_is_removed_can_be_saved_again(sheet, tmp_path)
    a_notice_that_was_closed_comes_back_when_the_file_changes_again(sheet, tmp_path)
    what_is_typed_into_a_field_while_the_file_changes_is_given_on_at_enter_and_not_before(sheet, tmp_path)


def png(value):
    return cv2.imencode(".png", np.full((30, 40, 3), value, np.uint8))[1].tobytes()


def test_included_files_and_pictures_that_change_on_disk_are_seen(browser, tmp_path):
    (tmp_path / "hall.yaml").write_text("mjsim: 1\nobstacles: [{name: chest, box: [1, 1, 1], at: [3, 3]}]\n")
    text = ROOM + "include: [hall.yaml]\nbeacons: [{name: lion, image: lion.png, at: [1, 1]}]\n"
    with sheet_of(browser, tmp_path, text, own=True) as sheet:
        problem = sheet.page.locator(".problem.error")
        expect(problem).to_contain_text("no file 'lion.png'")
        (tmp_path / "lion.png").write_bytes(png(20))
        expect(problem).to_have_count(0)
        sheet.click(1, 1)
        picture = sheet.page.locator(".panel button img")
        before = picture.evaluate(SHADE)
        (tmp_path / "lion.png").write_bytes(png(220))
        sheet.page.wait_for_function(
            f"before => ({SHADE})(document.querySelector('.panel button img')) !== before", arg=before
        )
        sheet.click(3, 3)
        expect(sheet.title).to_have_text("chest")
        (tmp_path / "hall.yaml").write_text("mjsim: 1\nobstacles: [{name: trunk, box: [1, 1, 1], at: [3, 3]}]\n")
        expect(sheet.title).to_have_text("trunk")
        expect(sheet.unsaved).to_be_hidden()


SHADE = """image => {
    const canvas = document.createElement("canvas");
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0, 1, 1);
    return context.getImageData(0, 0, 1, 1).data[0];
}"""
