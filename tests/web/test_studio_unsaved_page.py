"""Nothing that was typed is lost: not by a crash, nor by another tab, nor by a change on disk."""

import re
import sys
from contextlib import contextmanager

import pytest
from playwright.sync_api import Error, expect

from mjsim.web.studio import Studio
from tests.children import child
from tests.sheet import sheet_of
from tests.unsaved import (
    ROOM,
    close,
    drafts,
    kept,
    leave,
    notice,
    number_kept,
    offer,
    opened,
    put_in,
    second_tab,
    write_line,
)
from tests.windows import PATIENCE, page_at

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("state")]
OWN_WINDOW = True


def work_that_is_not_saved(sheet):
    """Do, undo and type what is not saved; some letters of it consist of two halves."""
    sheet.drag((2, 2), (3, 2.5))
    sheet.reads("at: [3, 2.5]")
    put_in(sheet, "# \U0001f916")
    sheet.click(3, 2.5)
    sheet.press("Delete")
    expect(sheet.text).not_to_contain_text("crate")
    put_in(sheet, "\U0001f917")  # half of it is as before
    sheet.press("Control+z")
    expect(sheet.text).not_to_contain_text("\U0001f917")
    kept('"Type in line 5"}], "at": 3}')  # what was undone last too


def is_restored_with_its_steps_both_ways(sheet):
    expect(offer(sheet.page)).to_contain_text("room.yaml")
    sheet.button("Restore").click()
    expect(sheet.text).not_to_contain_text("crate")
    expect(sheet.unsaved).to_be_visible()
    sheet.press("Control+Shift+z")
    sheet.reads("# \U0001f916\U0001f917")
    sheet.press("Control+z", "Control+z")
    sheet.reads("at: [3, 2.5]", "# \U0001f916")
    sheet.press("Control+z", "Control+z")
    sheet.reads("at: [2, 2]")
    sheet.press("Control+z")
    sheet.reads("# later")
    expect(sheet.button("Undo (Ctrl+Z)")).to_be_disabled()
    number_kept(0)


def two_tabs_are_left(sheet):
    write_line(sheet, "# one")
    write_line(second_tab(sheet), "# other")
    kept("# one")
    kept("# other")


def each_of_two_is_restored_or_discarded(sheet, place):
    expect(offer(sheet.page).get_by_role("listitem")).to_have_count(2)
    sheet.button("Discard").nth(0).click()
    expect(offer(sheet.page).get_by_role("listitem")).to_have_count(1)
    held = []
    sheet.page.route("**/api/draft/keep", lambda route: held.append(route), times=1)
    sheet.button("Restore").click()
    sheet.reads("# one")
    sheet.save()
    assert [route.request.post_data_json["text"][-5:] for route in held] == ["# one"]  # of this tab now
    number_kept(1)
    held[0].continue_()  # the server hears of it only after the file was saved
    number_kept(0)
    assert place.read_text().endswith("# one")


def a_new_world_and_one_that_is_removed_are_left(sheet, hall):
    hall.write_text(ROOM)
    other = sheet.page.context.new_page()
    other.goto(sheet.page.url.partition("#")[0] + "#edit?world=hall.yaml")
    write_line(opened(other), "# mine")
    kept("# mine")
    sheet.button("New world").first.click()
    sheet.button("Empty room").click()
    expect(sheet.text).not_to_contain_text("crate")
    write_line(sheet, "light: 0.25")
    kept("light: 0.25")
    hall.unlink()  # only the draft is left of it


def they_are_found_where_worlds_are_opened(sheet, folder):
    def restored(which, text, name):
        sheet.press("Control+o")
        row = sheet.page.get_by_role("dialog").get_by_role("listitem").filter(has_text=which)
        row.get_by_role("button", name="Restore").click()
        sheet.reads(text)
        sheet.press("Control+s")
        expect(sheet.page.get_by_role("dialog").get_by_label("File")).to_have_value(name)
        sheet.press("Enter")
        expect(sheet.unsaved).to_be_hidden()
        return (folder / name).read_text()

    expect(offer(sheet.page)).to_contain_text("hall.yaml")
    sheet.press("Escape")
    assert restored("hall.yaml", "# mine", "hall.yaml") == ROOM + "# mine"
    assert "light: 0.25" in restored("A new world", "light: 0.25", "room-2.yaml")
    number_kept(0)


def test_what_was_not_saved_is_offered_by_the_next_server_with_its_steps(browser, tmp_path):
    later = ROOM.replace("mjsim: 1", "mjsim: 1  # later")
    with sheet_of(browser, tmp_path, ROOM, own=True) as sheet:
        work_that_is_not_saved(sheet)
    with sheet_of(browser, tmp_path, later, own=True) as sheet:  # at another port
        is_restored_with_its_steps_both_ways(sheet)
        two_tabs_are_left(sheet)
    with sheet_of(browser, tmp_path, later, own=True) as sheet:
        each_of_two_is_restored_or_discarded(sheet, tmp_path / "room.yaml")
        a_new_world_and_one_that_is_removed_are_left(sheet, tmp_path / "hall.yaml")
    with sheet_of(browser, tmp_path, later, own=True) as sheet:
        they_are_found_where_worlds_are_opened(sheet, tmp_path)


@contextmanager
def command(folder):
    """Serve a folder in a process of its own; yields its address, and the process."""
    words = [sys.executable, "-m", "mjsim.cli", "studio", "room.yaml", "--no-browser"]
    with child(words, cwd=folder) as process:
        found = None
        while found is None:
            line = process.line("stderr")
            assert line, "the studio ended"
            found = re.search(r"http://[^\s;]+", line)
        yield found.group(), process


def test_a_server_that_is_killed_while_somebody_types_loses_nothing_that_it_kept_meanwhile(browser, tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM)
    expect.set_options(timeout=PATIENCE)
    with command(tmp_path) as (url, process), page_at(browser, url, own=True) as page:
        sheet = opened(page)
        write_line(sheet, "# ")
        texts, count = set(), 0
        while len(texts) < 3:  # without a pause
            assert count < 5000, texts
            count += 1
            sheet.type(f"{count},")
            texts.update(drafts())
        process.kill()
        write_line(sheet, "late")
        found = notice(sheet, "The studio does not answer: your changes are not kept")
        with page.expect_download() as download:
            found.get_by_role("button", name="Download").click()
        assert download.value.suggested_filename == "room.yaml"
        assert download.value.path().read_text().endswith(f"{count},late")
        # Every view says so; nothing of it is left to the browser's console.
        page.get_by_role("tab", name="Review", exact=True).click()
        expect(page.locator(".toast", has_text="The studio does not answer")).to_be_visible()
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url, own=True) as page:
        page.get_by_role("button", name="Restore").click()
        opened(page, "# 1,2,3")
        last = int(re.findall(r"(\d+),", page.locator(".cm-line").last.inner_text())[-1])  # it may end within a number
        assert last >= max(int(line.split(",")[-1]) for text in texts for line in re.findall(r"# ([\d,]+),", text))


def what_is_typed_without_a_pause_is_kept_meanwhile(sheet):
    sheet.text.click()
    sheet.press("Control+End")
    sheet.type("# ")
    for number in range(1000):
        sheet.type(f"{number},")
        if drafts():
            break
    else:
        pytest.fail("nothing was kept in 1000 words")
    expect(sheet.text).to_have_text(re.compile(rf"\b{number},\s*$"))


def what_was_typed_right_before_a_page_is_closed_is_kept(sheet):
    write_line(sheet, "# last")
    close(sheet.page)
    kept("# last")


def a_page_that_one_comes_back_to_has_what_it_had(sheet):
    leave(sheet.page)
    write_line(sheet, "# mine")
    sheet.page.goto("about:blank")
    sheet.page.go_back()
    restore = sheet.button("Restore")
    expect(restore.or_(sheet.page.locator(".cm-line", has_text="# mine"))).to_be_visible()
    if restore.is_visible():
        restore.click()
    sheet.reads("# mine")
    kept("# mine")


def a_page_that_crashes_loses_nothing_that_is_older(sheet):
    """Return the sheet of another page, which goes on from what was kept."""
    write_line(sheet, "# older")
    kept("# older")
    with sheet.page.expect_event("crash"), pytest.raises(Error):
        sheet.page.goto("chrome://crash", timeout=5000)
    again = sheet.page.context.new_page()
    again.goto(sheet.page.url.partition("#")[0])
    again.get_by_role("button", name="Restore").click()
    return opened(again, "# older")


def each_tab_has_its_own_draft_and_is_told_of_the_others(sheet, mine, theirs, *, duplicate):
    write_line(sheet, mine)
    kept(mine)
    other = second_tab(sheet, duplicate=duplicate)
    notice(other, "Another tab has unsaved changes in room.yaml.")
    expect(offer(other.page)).to_have_count(0)  # it is not left, it is open
    write_line(other, theirs)
    kept(theirs)
    number_kept(2)
    notice(sheet, "Another tab has unsaved changes in room.yaml.")
    leave(other.page)
    close(other.page)
    notice(sheet, "A closed tab left unsaved changes in room.yaml").get_by_role("button", name="Restore").click()
    sheet.reads(theirs)
    expect(sheet.page.locator(".notice")).to_have_count(0)
    sheet.press("Control+z")
    sheet.reads(mine)
    number_kept(1)


def test_each_tab_keeps_what_it_has_when_it_is_left_crashes_or_is_closed(sheet):
    each_tab_has_its_own_draft_and_is_told_of_the_others(sheet, "# one", "# other", duplicate=False)
    each_tab_has_its_own_draft_and_is_told_of_the_others(sheet, "# two", "# twin", duplicate=True)
    a_page_that_one_comes_back_to_has_what_it_had(sheet)
    what_was_typed_right_before_a_page_is_closed_is_kept(a_page_that_crashes_loses_nothing_that_is_older(sheet))


def when_changes_cannot_be_kept_the_page_says_so_and_why(sheet, state):
    for file in (state / "mjsim" / "drafts").iterdir():
        file.unlink()
    (state / "mjsim" / "drafts").rmdir()
    (state / "mjsim" / "drafts").write_text("in the way")
    write_line(sheet, "# mine")
    found = notice(sheet, "unsaved changes cannot be kept: File exists; save often")
    found.get_by_role("button", name="Close").click()
    write_line(sheet, " too")
    with sheet.page.expect_response("**/api/draft/keep"):
        pass
    expect(found).to_be_hidden()  # it was read
    (state / "mjsim" / "drafts").unlink()
    (state / "mjsim" / "drafts").symlink_to(state)
    notice(sheet, "is not a folder of your own; save often")  # another reason
    found = sheet.page.locator(".notice")
    (state / "mjsim" / "drafts").unlink()
    expect(found).to_be_hidden()  # it is tried again
    kept("# mine")


def a_save_that_is_refused_keeps_text_and_draft(sheet, tmp_path):
    write_line(sheet, "# mine")
    (tmp_path / "room.yaml").unlink()
    (tmp_path / "room.yaml").mkdir()
    sheet.press("Control+s")
    expect(sheet.page.locator(".toast.error")).to_contain_text("'room.yaml' cannot be written: File exists")
    sheet.reads("# mine")
    kept("# mine")


def test_what_is_typed_is_kept_and_where_that_fails_the_page_says_why(sheet, state, tmp_path):
    when_changes_cannot_be_kept_the_page_says_so_and_why(sheet, state)
    sheet.save()
    number_kept(0)
    what_is_typed_without_a_pause_is_kept_meanwhile(sheet)
    a_save_that_is_refused_keeps_text_and_draft(sheet, tmp_path)
