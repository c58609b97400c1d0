"""Measure the Run view in a real chromium: pictures shown a second, and whether the run keeps real time.

    scripts/measure/studio_page.py [SECONDS]

The gallery runs with its estimator while its onboard camera, 640 x 480, is on the page; the server is a process of its
own. Pictures are counted where the page paints them. Late frames are frames of the screen that took over 50 ms: what a
person sees as a stutter.
"""

import multiprocessing
import sys
import tempfile
from multiprocessing.connection import Connection
from pathlib import Path

from playwright.sync_api import Page, expect

import mjsim
from mjsim.bench.chromium import PATIENCE, chromium, page_at
from mjsim.web import Studio

ROOT = Path(__file__).parents[2]

GALLERY = Path(mjsim.__file__).parent.parent / "worlds" / "gallery.yaml"
SLOW = GALLERY.read_text()
FAST = SLOW.replace("rate_hz: 12.5}", "rate_hz: 25}")
CASES = (
    ("camera at 25 Hz", FAST, False, 1),
    ("camera at 25 Hz and the view from outside", FAST, True, 1),
    ("camera at 12.5 Hz and the view from outside", SLOW, True, 1),
    ("camera at 12.5 Hz in two browsers", SLOW, False, 2),
)
COUNT = """
() => {
  window.painted = {};
  window.late = 0;
  const draw = CanvasRenderingContext2D.prototype.drawImage;
  CanvasRenderingContext2D.prototype.drawImage = function (...given) {
    const view = this.canvas.closest("[data-view]")?.dataset.view;
    if (view && given[0] instanceof ImageBitmap) window.painted[view] = (window.painted[view] ?? 0) + 1;
    return draw.apply(this, given);
  };
  let last = performance.now();
  const frame = (now) => {
    window.late += now - last > 50;
    last = now;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}
"""
READ = """() => ({
  painted: {...window.painted}, late: window.late, now: performance.now() / 1000,
  time: document.querySelector(".run-time").textContent,
})"""


def main(seconds: float) -> None:
    """Print the figures of all cases, each over so many seconds on the clock."""
    print(f"{'the gallery, wanted: 1 x real time':46} {'real time':>9}  late frames  pictures/s")
    for name, text, outside, browsers in CASES:
        print(f"{name:46} {measured(text, seconds, outside=outside, browsers=browsers)}", flush=True)


def measured(text: str, seconds: float, *, outside: bool, browsers: int) -> str:
    """Return the figures of one case."""
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        Path(folder, "gallery.yaml").write_text(text)
        ours, theirs = multiprocessing.Pipe()
        server = multiprocessing.get_context("spawn").Process(target=serve, args=[theirs, folder])
        server.start()
        first, second = ours.recv()
        with page_at(browser, first) as page, page_at(browser, second if browsers > 1 else "about:blank") as other:
            for each in (page, other)[:browsers]:
                each.get_by_role("tab", name="Run", exact=True).click()
            if not outside:
                page.get_by_role("button", name="Outside", exact=True).click()
            if browsers > 1:
                other.get_by_role("button", name="Outside", exact=True).click()
            page.get_by_role("button", name="Start", exact=True).click()
            expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
            page.wait_for_timeout(5000)
            found = figures(page, seconds)
        ours.send("end")
        server.join()
    return found


def figures(page: Page, seconds: float) -> str:
    """Return what a page showed in so many seconds."""
    page.evaluate(COUNT)
    before = page.evaluate(READ)
    page.wait_for_timeout(1000 * seconds)
    after = page.evaluate(READ)
    took = after["now"] - before["now"]
    factor = (simulated(after["time"]) - simulated(before["time"])) / took
    rates = [
        f"{view} {(count - before['painted'].get(view, 0)) / took:.1f}" for view, count in after["painted"].items()
    ]
    return f"{factor:9.3f}  {after['late'] - before['late']:11d}  {', '.join(rates)}"


def simulated(shown: str) -> float:
    """Return the seconds of a time as the page writes it, '1:02.04 of 2:05'."""
    minutes, _, seconds = shown.split(" ")[0].rpartition(":")
    return 60.0 * float(minutes or 0.0) + float(seconds)


def serve(told: Connection, folder: str) -> None:
    """Serve a studio until it is told to end."""
    with Studio(folder, world="gallery.yaml") as studio:
        told.send((studio.url, studio.url))
        told.recv()


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
