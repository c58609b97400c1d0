#!/usr/bin/env python3
"""Measure what the Run view with 3-D and scans costs the server, in a real chromium, and how soon the page can be used.

    scripts/measure/run_3d.py [SECONDS]

The gallery with a lidar in the place of its camera runs at real time, 25 ticks a second, in a process of its own. The
share is that process's processor time a second while a page shows plan, 3-D and scans, less that of the same run while
nobody watches: of one core. Places are how often the page put bodies where they are. The page can be used once the
plan shows the world that is open.
"""

import multiprocessing
import re
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

from playwright.sync_api import Browser, Page, expect

import mjsim
from mjsim.bench.chromium import PATIENCE, chromium, page_at
from mjsim.web import Studio

GALLERY = (Path(mjsim.__file__).parent.parent / "worlds" / "gallery.yaml").read_text()
LIDAR = "{lidar: scan, at: [0.1, 0, 0.3], beams: 360, fov_deg: 270, rate_hz: 12.5}"


class Figures(NamedTuple):
    """What was found in some seconds on the clock."""

    share: float
    """Processor time of the server's process a second."""
    pace: float
    """Simulated seconds a second, until the page told the time again."""
    drawn: float
    """Pictures of the view in 3-D a second."""
    moved: float
    """How often a second bodies were put where they are."""


def main(seconds: float) -> None:
    """Print the figures, each over so many seconds on the clock."""
    expect.set_options(timeout=PATIENCE)
    with chromium() as browser:
        starts = sorted(opened(browser) for _ in range(5))
        print(f"the gallery can be used after {starts[2]:.2f} s ({starts[0]:.2f} to {starts[-1]:.2f})")
        print(f"{'run view':22} {'share of a core':>15}  real time  pictures/s  places/s")
        alone, watched = (found(browser, seconds, watched=watched) for watched in (False, True))
    for name, each in (("nobody watches", alone), ("plan, 3-D and scans", watched)):
        print(f"{name:22} {100 * each.share:13.1f} %  {each.pace:9.3f}  {each.drawn:10.1f}  {each.moved:8.1f}")
    print(f"{'for the page':22} {100 * (watched.share - alone.share):13.1f} %")


def opened(browser: Browser) -> float:
    """Return how long after it was asked for a page of the gallery can be used [s]."""
    with serving(GALLERY) as (_, url), page_at(browser, "about:blank") as page:
        began = time.perf_counter()
        page.goto(url)
        page.locator("#view-edit .plan[data-view]").wait_for()
        page.locator(".outline-row").first.wait_for()
        return time.perf_counter() - began


def found(browser: Browser, seconds: float, *, watched: bool) -> Figures:
    """Return the figures of a run that a page watches or has left."""
    with serving(with_lidar()) as (server, url), page_at(browser, url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Outside", exact=True).click()
        page.evaluate("() => localStorage.setItem('mjsim.run.scene.slow', 'yes')")  # it stays on
        page.locator("#view-run").get_by_title("View in 3-D").click()
        page.get_by_role("button", name="Start", exact=True).click()
        page.locator("#view-run .scene[data-filled]").wait_for()
        page.wait_for_timeout(3000)
        begins, clock = simulated(page), time.perf_counter()
        address = page.url
        if not watched:
            page.goto("about:blank")
        before, began = state(server, page), time.perf_counter()
        page.wait_for_timeout(1000 * seconds)
        after, took = state(server, page), time.perf_counter() - began
        if not watched:
            page.goto(address)
            page.get_by_role("tab", name="Run", exact=True).click()
            expect(page.locator(".run-state")).to_have_text("Running")
        pace = (simulated(page) - begins) / (time.perf_counter() - clock)
        share, drawn, moved = ((late - early) / took for early, late in zip(before, after, strict=True))
        return Figures(share, pace, drawn, moved)


def state(server: Connection, page: Page) -> tuple[float, float, float]:
    """Return processor time of the server [s], pictures that were drawn, and how often bodies were moved until now."""
    server.send("state")
    used = float(server.recv())
    canvas = page.locator("#view-run .scene canvas")
    if not canvas.count():
        return used, 0.0, 0.0
    return used, float(canvas.get_attribute("data-frames") or 0), float(canvas.get_attribute("data-moments") or 0)


def simulated(page: Page) -> float:
    """Return the simulated time that the page tells [s], of '1:02.04 of 2:05'."""
    shown = page.locator("#view-run .run-time")
    expect(shown).to_contain_text(" of ")
    minutes, _, seconds = shown.inner_text().split(" ")[0].rpartition(":")
    return 60.0 * float(minutes or 0.0) + float(seconds)


def with_lidar() -> str:
    """Return the gallery with a lidar in the place of its camera; what looked at pictures is gone."""
    text = re.sub(r"- \{camera: front.*\}", f"- {LIDAR}", GALLERY)
    return re.sub(r"\n +observer: .*", "", text)


@contextmanager
def serving(text: str) -> Iterator[tuple[Connection, str]]:
    """Yield the way to a process that serves a studio with a world, and the page's address."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "gallery.yaml").write_text(text)
        ours, theirs = multiprocessing.Pipe()
        process = multiprocessing.get_context("spawn").Process(target=serve, args=[theirs, folder])
        process.start()
        try:
            yield ours, ours.recv()
        finally:
            ours.send("end")
            process.join()


def serve(told: Connection, folder: str) -> None:
    """Serve a studio, and tell its processor time [s] when asked, until it is told to end."""
    with Studio(folder, world="gallery.yaml") as studio:
        told.send(studio.url)
        while told.recv() == "state":
            told.send(time.process_time())


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 30.0)
