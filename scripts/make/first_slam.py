"""Walk from an empty folder to a first result of SLAM, counting clicks: docs/images/studio-first-1.png and so on.

Drives the real page in chromium as docs/studio-walk.md tells it. A test walks the same way.
"""

import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Locator, Page, expect

from mjsim.bench.chromium import chromium, page_at
from mjsim.web import Studio

IMAGES = Path(__file__).parents[2] / "docs" / "images"
SIZE = (1280, 720)
SMALL = (800, 450)
"""Size of a page and of its picture [px]."""
PATIENCE = 300_000
"""Time limit of a run, even on a busy machine [ms]."""
ROOM = ((-4.0, -3.0), (4.0, 3.0))
"""Opposite corners of the room [m]."""
PICTURES = ((0.0, 2.9), (3.9, 0.0), (0.0, -2.9), (-3.9, 0.0))
"""Where pictures are hung [m]."""
ROBOT = (-2.0, -1.0)
"""[m]"""


class Hand:
    """Operates the mouse, and counts clicks; a drag counts as one."""

    def __init__(self, page: Page) -> None:
        self.page, self.clicks = page, 0
        self._plan = page.locator("#view-edit .plan")

    def press(self, target: Locator) -> None:
        """Click a button."""
        target.click()
        self.clicks += 1

    def click(self, at: tuple[float, float]) -> None:
        """Click a point of the plan [m]."""
        self.page.mouse.click(*self._pixel(at))
        self.clicks += 1

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag from one point of the plan to another [m]."""
        self.page.mouse.move(*self._pixel(start))
        self.page.mouse.down()
        self.page.mouse.move(*self._pixel(end), steps=4)
        self.page.mouse.up()
        self.clicks += 1

    def _pixel(self, at: tuple[float, float]) -> tuple[float, float]:
        box = self._plan.bounding_box()
        assert box is not None, "the plan is on the screen"
        left, top, scale = json.loads(self._plan.get_attribute("data-view") or "[]")
        return box["x"] + left + at[0] * scale, box["y"] + top - at[1] * scale


def build(hand: Hand, keep: Callable[[str], None]) -> None:
    """Make a world: a room, four pictures, a robot and its modules; and save it."""
    page = hand.page

    def button(name: str) -> Locator:
        return page.get_by_role("button", name=name).locator("visible=true").first

    new = page.locator("#view-edit").get_by_role("button", name="New world")
    expect(new).to_be_visible()
    keep("the empty page")
    hand.press(new)
    hand.press(button("Draw the first wall"))
    hand.drag(*ROOM)
    text = page.locator(".cm-content")
    expect(text).to_contain_text("closed: true")
    hand.press(button("Picture or marker (P)"))
    for number, place in enumerate(PICTURES, start=1):
        hand.click(place)
        expect(text.get_by_text("image:")).to_have_count(number)
    keep("a room with four pictures")
    hand.press(button("Robot (R)"))
    hand.click(ROBOT)
    hand.press(button("Use what fits"))
    expect(text).to_contain_text("EkfSlam")
    keep("the robot and its modules")
    hand.press(button("Save (Ctrl+S)"))
    hand.press(page.get_by_role("dialog").get_by_role("button", name="Save"))
    expect(page.locator(".world .dot")).to_be_hidden()


def start(hand: Hand) -> None:
    """Start a run of the world."""
    hand.press(hand.page.get_by_role("tab", name="Run", exact=True))
    hand.press(hand.page.get_by_role("button", name="Start", exact=True))
    expect(hand.page.locator(".run-state:visible")).to_have_text("Running")


@contextmanager
def empty_studio() -> Iterator[Page]:
    """Open the page of an empty folder."""
    expect.set_options(timeout=PATIENCE)
    with (
        tempfile.TemporaryDirectory() as folder,
        chromium() as browser,
        Studio(Path(folder)) as studio,
        page_at(browser, studio.url, width=SIZE[0], height=SIZE[1]) as page,
    ):
        page.set_default_timeout(PATIENCE)
        yield page


def keep_picture(page: Page, name: str) -> None:
    """Write what the page shows."""
    shot = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    small = cv2.resize(shot, SMALL, interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(IMAGES / f"{name}.png"), small, [cv2.IMWRITE_PNG_COMPRESSION, 9])


def main() -> None:
    """Walk, and make all pictures."""
    with empty_studio() as page:
        hand, number = Hand(page), 0

        def keep(what: str) -> None:
            nonlocal number
            number += 1
            print(f"{number}. after {hand.clicks} clicks: {what}", flush=True)
            page.wait_for_timeout(1500)  # pictures of a camera are on their way
            keep_picture(page, f"studio-first-{number}")

        build(hand, keep)
        start(hand)
        expect(page.locator(".run-state:visible")).to_have_text("Ended")
        keep("the first result")


if __name__ == "__main__":
    main()
