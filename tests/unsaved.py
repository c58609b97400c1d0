"""What tests of unsaved work do with the sheet of a studio, and the drafts that its server keeps."""

import re
import time

from playwright.sync_api import expect

from mjsim.web.worlds.drafts import ID, drafts_folder
from tests.sheet import Sheet
from tests.windows import PATIENCE

ROOM = """\
mjsim: 1
walls:
  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}
obstacles:
  - {name: crate, box: [0.6, 0.4, 0.5], at: [2, 2]}
"""
THEIRS = ROOM.replace("crate", "barrel")
"""What another program makes of the room."""
LOOK = 0.02
"""Between two looks at the drafts [s]: what waits must leave the processor to what it waits for."""


def write_line(sheet, text):
    """Type a line at the end of the text."""
    sheet.text.click()
    sheet.press("Control+End")
    sheet.type(text)


def put_in(sheet, text):
    """Put something at the end of the text at once, which is one step however slow the machine is."""
    sheet.text.click()
    sheet.press("Control+End")
    sheet.page.keyboard.insert_text(text)


def kept(text):
    """Wait until a draft has a text."""
    end = time.monotonic() + PATIENCE / 1000
    while not any(text in draft for draft in drafts()):
        assert time.monotonic() < end, drafts()
        time.sleep(LOOK)


def drafts():
    """Return all drafts as they are kept; a file that is still being written beside its place is none."""
    found = []
    for file in drafts_folder().glob("*-*"):
        if not ID.fullmatch(file.name):
            continue
        try:
            found.append(file.read_text())
        except FileNotFoundError:
            continue
    return found


def number_kept(count):
    """Wait until there are so many drafts."""
    end = time.monotonic() + PATIENCE / 1000
    while len(drafts()) != count:
        assert time.monotonic() < end, drafts()
        time.sleep(LOOK)


def opened(page, text="mjsim: 1"):
    """Return the sheet of another tab once its world is there."""
    sheet = Sheet(page)
    sheet.reads(text)
    expect(sheet.plan).to_have_attribute("data-view", re.compile(","))
    return sheet


def notice(sheet, text):
    found = sheet.page.locator(".notice").filter(has_text=text)
    expect(found).to_be_visible()
    return found


def offer(page):
    return page.get_by_role("dialog", name="Unsaved changes")


def leave(page):
    page.on("dialog", lambda question: question.accept())  # of the browser: leave the page?


def close(page):
    with page.expect_event("close"):
        page.close(run_before_unload=True)


def second_tab(sheet, *, duplicate=False):
    """Open the same address in another tab; a duplicate has what the browser remembers for the first one."""
    if not duplicate:
        page = sheet.page.context.new_page()
        page.goto(sheet.page.url.partition("#")[0])
        return opened(page)
    with sheet.page.context.expect_page() as found:
        sheet.page.evaluate("window.open(location.href)")
    return opened(found.value)
