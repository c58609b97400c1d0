"""The Edit view of the studio's page, worked with mouse and keys by metres of the world, for tests."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, expect

from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

DRAWN = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""What was asked to be drawn with the next picture is drawn."""

STILL = """plan => new Promise(done => {
    const seen = plan.dataset.view;
    requestAnimationFrame(() => requestAnimationFrame(() => done(seen?.includes(",") && seen === plan.dataset.view)));
})"""
"""Whether the plan has its place and keeps it for two pictures."""


class Sheet:
    """A page with a world in its Edit view."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.plan = page.locator("#view-edit .plan")
        self.text = page.locator(".cm-content")
        self.unsaved = page.locator(".world .dot")
        self.title = page.locator(".panel h2")

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the world [m] lies on the page [px]."""
        box = self.plan.bounding_box()
        left, top, scale = json.loads(self.plan.get_attribute("data-view"))
        return box["x"] + left + x * scale, box["y"] + top - y * scale

    def click(self, x: float, y: float) -> None:
        self.page.mouse.click(*self.pixel(x, y))

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self.page.mouse.move(*self.pixel(*start))
        self.page.mouse.down()
        self.page.mouse.move(*self.pixel(*end), steps=2)
        self.page.mouse.up()

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def type(self, text: str) -> None:
        self.page.keyboard.type(text)

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name)

    def field(self, label: str) -> Locator:
        return self.page.locator(".panel").get_by_label(label, exact=True)

    def settles(self) -> None:
        """Wait until the plan stands still."""
        self.page.wait_for_function(STILL, arg=self.plan.element_handle())

    def shows(self, x: float, y: float) -> None:
        """Wait until the plan has a thing that the pointer can take at a place [m]."""
        self.settles()
        for step in range(PATIENCE // 50):
            self.page.mouse.move(*self.pixel(x + 0.02 * (step % 2), y))
            if self.plan.evaluate("plan => plan.style.cursor") == "move":
                return
            self.page.wait_for_timeout(50)  # the page goes on meanwhile
        raise AssertionError(f"nothing to take at {x}, {y}")

    def put(self, text: str) -> None:
        """Put another text in the place of all, as one step, and go back to the plan, where clicks select."""
        self.text.click()
        self.press("Control+a")
        with self.page.expect_response("**/api/parse"):
            self.page.keyboard.insert_text(text)
        self.plan.focus()
        self.press("Escape", "v")

    def save(self) -> None:
        with self.page.expect_response("**/api/save"):  # a step that is still on its way has no dot yet
            self.press("Control+s")
        expect(self.unsaved).to_be_hidden()

    def reads(self, *pieces: str) -> None:
        """Wait until the text has these pieces."""
        for piece in pieces:
            expect(self.text).to_contain_text(piece)


@contextmanager
def sheet_of(browser: Browser, folder: Path, text: str, *, own: bool = False) -> Iterator[Sheet]:
    """Open the studio on a world `room.yaml` of a folder, in a window of its own or in one that was left."""
    (folder / "room.yaml").write_bytes(text.encode())
    expect.set_options(timeout=PATIENCE)
    studio = Studio(folder, world="room.yaml")
    try:
        with page_at(browser, studio.url, own=own) as page:
            sheet = Sheet(page)
            sheet.reads("mjsim: 1")
            sheet.settles()
            yield sheet
    finally:
        studio.close()
