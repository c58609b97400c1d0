"""Measure whether memory stays flat while a run goes on with its page: that of the server, and that of the page.

    scripts/measure/memory.py [MINUTES]

A robot drives rounds with a lidar and a camera, as fast as it goes, and the page shows the plan with scans, the camera,
the view from outside and the 3-D view. The first fifth is left out: caches fill. The server is a process of its own;
its memory is what is resident of it and its children. That of the page is its heap of JavaScript after a collection.
"""

import multiprocessing
import os
import sys
import tempfile
import time
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from playwright.sync_api import CDPSession, Page, expect

from mjsim.bench.chromium import PATIENCE, chromium, page_at
from mjsim.web import Studio

WORLD = """\
mjsim: 1
walls: [{points: [[-4, -3], [4, -3], [4, 3], [-4, 3]], closed: true}]
obstacles: [{name: table, box: [2, 1, 0.7], at: [0, 0]}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [-3, -2]
    sensors:
      - {lidar: scan, at: [0.1, 0, 0.3], beams: 180, range: [0.05, 8], rate_hz: 12.5, noise: {range: 0.01}}
      - {camera: front, width: 320, height: 240}
run:
  seconds: 1000000
  drivers:
    scout:
      navigator:
        use: "mjsim.algorithms.waypoints:Waypoints"
        points: [[3, -2], [3, 2], [-3, 2], [-3, -2]]
        laps: 100000
"""
WARM = 0.2
"""Share of the time that is left out at the beginning."""
EVERY = 5.0
"""Between two readings [s]."""


def main(minutes: float) -> None:
    """Print by how much the memory of server and page grows over so many minutes on the clock."""
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        Path(folder, "room.yaml").write_text(WORLD)
        ours, theirs = multiprocessing.Pipe()
        server = multiprocessing.get_context("spawn").Process(target=serve, args=[theirs, folder])
        server.start()
        try:
            with page_at(browser, ours.recv()) as page:
                begin(page)
                read = readings(page, server.pid or 0, 60.0 * minutes)
                simulated = page.locator(".run-time:visible").inner_text()
        finally:
            ours.send("end")
            server.join()
    print(f"{minutes:g} minutes on the clock, {simulated} simulated")
    for name, column in (("server, resident", 1), ("page, JavaScript heap", 2)):
        slope, error, mean = growth(read[:, 0], read[:, column])
        print(f"{name:22} {mean:7.1f} MB, grows by {slope:+.2f} +- {error:.2f} MB in 10 minutes")


def begin(page: Page) -> None:
    """Start the run with all that can be seen of it."""
    page.get_by_role("tab", name="Run", exact=True).click()
    view = page.locator("#view-run")
    view.get_by_role("button", name="3-D", exact=True).click()
    view.get_by_label("Speed").select_option("max")
    view.get_by_role("button", name="Start", exact=True).click()
    expect(page.locator(".run-state:visible")).to_have_text("Running", timeout=PATIENCE)
    view.locator(".scene[data-filled]").wait_for(timeout=PATIENCE)


def readings(page: Page, pid: int, seconds: float) -> np.ndarray:
    """Return times [s], the server's memory and the page's [MB], shape (n, 3), without those while it gets warm."""
    client = page.context.new_cdp_session(page)
    rows, start = [], time.monotonic()
    while (now := time.monotonic() - start) < seconds:
        rows.append((now, resident(pid), heap(client)))
        page.wait_for_timeout(1000 * EVERY)
    found = np.array(rows)
    return found[found[:, 0] > WARM * seconds]


def resident(pid: int) -> float:
    """Return what a process and its children hold of the memory [MB], from /proc."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6 + sum(resident(int(child)) for child in children)


def heap(client: CDPSession) -> float:
    """Return what a page's JavaScript holds after a collection [MB]."""
    client.send("HeapProfiler.collectGarbage")
    return float(client.send("Runtime.getHeapUsage")["usedSize"]) / 1e6


def growth(t: np.ndarray, megabytes: np.ndarray) -> tuple[float, float, float]:
    """Return the slope of a line through readings and its standard error [MB in 10 minutes], and their mean [MB].

    The error takes them for independent: that of memory which wanders is larger.
    """
    (slope, _), P = np.polyfit(t, megabytes, 1, cov=True)
    return 600.0 * slope, 600.0 * float(np.sqrt(P[0, 0])), float(megabytes.mean())


def serve(told: Connection, folder: str) -> None:
    """Serve a studio until it is told to end."""
    with Studio(folder, world="room.yaml") as studio:
        told.send(studio.url)
        told.recv()


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 30.0)
