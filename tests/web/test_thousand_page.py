"""A thousand things are deleted and brought back in the studio, in a real browser, by processor time."""

import time
from itertools import pairwise

import pytest
from playwright.sync_api import expect

from mjsim.bench.large import large_floor
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
BOXES = "".join(f"  - {{box: [0.4, 0.4, 0.5], at: [{n % 40}, {n // 40}]}}\n" for n in range(1000))
WORLDS = {
    "boxes": f"mjsim: 1\nname: many\nobstacles:\n{BOXES}",
    "walls": large_floor(1000),
}
TIMES = 1.5
"""Deleting, or bringing back, takes at most so many times as long as opening such a world; it takes half as long.

A time in seconds would be a fact about the machine and what else it does.
"""


class Clock:
    """Processor time of the page's main thread and of this process, which serves it."""

    def __init__(self, page):
        self._page = page
        self._session = page.context.new_cdp_session(page)
        self._session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def now(self) -> float:
        metrics = self._session.send("Performance.getMetrics")["metrics"]
        (page,) = (each["value"] for each in metrics if each["name"] == "TaskDuration")
        return page + time.process_time()

    def settled(self) -> float:
        """Return the time once both have little to do: less than 0.03 s in 0.3 s."""
        before = self.now()
        while True:
            self._page.wait_for_timeout(300)  # the page goes on meanwhile
            if (now := self.now()) < before + 0.03:
                return now
            before = now


def opened_deleted_and_brought_back(page, name) -> list[float]:
    """Open a world, delete all its things and undo that; return what each took [s]."""
    clock, listed = Clock(page), page.locator(".outliner [role=treeitem]")
    times = [clock.settled()]
    page.keyboard.press("Control+o")
    page.get_by_role("searchbox", name="Find a world").fill(name)
    page.keyboard.press("Enter")
    expect(page.locator(".world .name")).to_have_text(f"{name}.yaml")
    expect(listed).not_to_have_count(0)
    times.append(clock.settled())
    page.locator("#view-edit .plan").click(position={"x": 5, "y": 5})
    page.keyboard.press("Control+a")
    times.append(clock.settled())
    page.keyboard.press("Delete")
    expect(listed).to_have_count(0)
    times.append(clock.settled())
    page.keyboard.press("Control+z")
    expect(listed).not_to_have_count(0)
    times.append(clock.settled())
    opened, _, deleted, brought_back = (after - before for before, after in pairwise(times))
    return [opened, deleted, brought_back]


def test_a_thousand_things_are_deleted_and_brought_back_no_slower_than_they_are_opened(browser, tmp_path):
    for name, text in WORLDS.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    expect.set_options(timeout=PATIENCE)
    with Studio(tmp_path) as studio, page_at(browser, studio.url, own=True) as page:
        for name in WORLDS:
            opened, deleted, brought_back = opened_deleted_and_brought_back(page, name)
            assert max(deleted, brought_back) < TIMES * opened, name
