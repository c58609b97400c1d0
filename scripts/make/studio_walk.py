"""Walk from an empty page to a compared pair of runs, by mouse alone: docs/images/studio-walk-1.png and so on.

Drives the real page in chromium as docs/studio-walk.md tells it, keeps a picture of each step, and prints the time from
the first sight of the page to each of them. A person also needs time to read and to aim.
"""

import time

from first_slam import empty_studio, keep_picture
from playwright.sync_api import Page, expect


class Walk:
    """Operates the page, and measures the time that this takes."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self._start, self._number = time.monotonic(), 0

    def press(self, name: str) -> None:
        """Click a button."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def tab(self, name: str) -> None:
        """Show a view."""
        self.page.get_by_role("tab", name=name, exact=True).click()

    def keep(self, what: str) -> None:
        """Write what the page shows, and print when."""
        self._number += 1
        print(f"{self._number}. {time.monotonic() - self._start:6.1f} s  {what}", flush=True)
        keep_picture(self.page, f"studio-walk-{self._number}")

    def run(self) -> None:
        """Start a run and wait until it has been recorded."""
        self.press("Start")
        state = self.page.locator(".run-state:visible")
        expect(state).to_have_text("Running")
        expect(state).to_have_text("Ended")
        expect(self.page.get_by_role("button", name="Review it")).to_be_visible()


def main() -> None:
    """Walk, and make all pictures."""
    with empty_studio() as page:
        expect(page.get_by_text("Build a room for your robot")).to_be_visible()
        walk = Walk(page)
        begin(walk)
        record(walk)
        compare(walk)


def begin(walk: Walk) -> None:
    """Choose a world to begin with."""
    walk.keep("the empty page")
    walk.press("Start from a template")
    card = walk.page.get_by_role("dialog").get_by_role("button", name="The smallest useful world")
    expect(card).to_be_visible()
    walk.keep("templates, with a word about each")
    card.click()
    expect(walk.page.locator(".cm-content")).to_contain_text("name: empty")
    walk.keep("the world in Edit")


def record(walk: Walk) -> None:
    """Record a run of each of two variants of SLAM."""
    walk.tab("Run")
    walk.page.get_by_label("Record to a file").check()
    walk.page.get_by_label("Speed").and_(walk.page.locator(":visible")).select_option("max")
    walk.run()
    walk.keep("the first run has ended: EKF-SLAM, as the world has it")
    walk.press("scout: Estimator: EKF-SLAM; choose another")
    walk.page.get_by_role("dialog").get_by_title("mjsim.algorithms.fastslam:FastSlam").click()
    walk.run()
    walk.keep("the second has ended: FastSLAM, chosen in Setup")


def compare(walk: Walk) -> None:
    """Compare the two recordings."""
    walk.press("Review it")
    boxes = walk.page.get_by_role("checkbox", name="Compare")
    expect(boxes).to_have_count(2)
    for box in boxes.all():
        box.check()
    expect(walk.page.locator("#view-review .run-time")).to_contain_text(" of ")
    expect(walk.page.locator("#view-review .run-waiting").locator("visible=true")).to_have_count(0)
    walk.keep("both recordings ticked in Review")
    walk.press("Compare 2 chosen")
    expect(walk.page.locator(".compare-legend b")).to_have_count(2)
    walk.keep("their paths, errors and figures beside each other")


if __name__ == "__main__":
    main()
