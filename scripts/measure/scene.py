"""Measure the view in 3-D of the studio's page in a real chromium: until it is there, and its pictures a second.

    scripts/measure/scene.py [SECONDS]

The canvas covers a window of 1280 x 720; the view is turned with each frame of the screen, as by a hand. `share` is how
many of the pixels along a side were drawn at the end: fewer where the machine is too slow for all.
"""

import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Browser, expect

import mjsim
from mjsim.bench.chromium import PATIENCE, chromium, page_at
from mjsim.bench.large import large_floor
from mjsim.web import Studio

GALLERY = Path(mjsim.__file__).parent.parent / "worlds" / "gallery.yaml"
PEOPLE = "people:\n" + "".join(
    f"  - {{name: p{k}, sex: female, at: [{4.5 + k % 4}, {3 + k // 4}]}}\n" for k in range(8)
)
CASES = (
    ("the gallery", GALLERY.read_text()),
    ("the gallery, 8 people", GALLERY.read_text() + PEOPLE),
    ("1000 segments of walls", large_floor(1000)),
)
TURN = """([canvas, seconds]) => new Promise((done) => {
  const key = {code: "ArrowLeft", key: "ArrowLeft", ctrlKey: true, bubbles: true, cancelable: true};
  const frames = () => Number(canvas.dataset.frames);
  const turn = (until, then) => {
    canvas.dispatchEvent(new KeyboardEvent("keydown", key));
    if (performance.now() < until) requestAnimationFrame(() => turn(until, then));
    else then();
  };
  // The first second finds how many pixels there is time for.
  turn(performance.now() + 1000, () => {
    const [began, first] = [performance.now(), frames()];
    turn(began + 1000 * seconds, () => {
      const rate = (frames() - first) / (performance.now() - began) * 1000;
      done({rate, share: canvas.dataset.share});
    });
  });
})"""


def main(seconds: float) -> None:
    """Print the figures of all cases, each over so many seconds on the clock."""
    expect.set_options(timeout=PATIENCE)
    print(f"{'1280 x 720':24} {'there after':>11}  pictures/s  share")
    with chromium() as browser:
        for name, text in CASES:
            there, rate, share = measured(browser, text, seconds)
            print(f"{name:24} {there:9.2f} s  {rate:10.1f}  {share:>5}")


def measured(browser: Browser, text: str, seconds: float) -> tuple[float, float, str]:
    """Return how long it took to open the view [s], its pictures a second, and the share of pixels along a side."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "world.yaml").write_text(text)
        with Studio(folder, world="world.yaml") as studio, page_at(browser, studio.url) as page:
            press = page.locator("#view-edit").get_by_title("View in 3-D")
            press.wait_for()
            began = time.perf_counter()
            press.click()
            page.locator("#view-edit .scene[data-filled]").wait_for()
            there = time.perf_counter() - began
            canvas = page.locator("#view-edit .scene-canvas")
            canvas.evaluate("canvas => Object.assign(canvas.style, {position: 'fixed', zIndex: 9})")
            for part in (".scene", ".scene-door"):
                page.add_style_tag(content=f"{part} {{ position: static !important; }}")
            page.wait_for_function("() => document.querySelector('.scene-canvas').clientWidth === 1280")
            told = page.evaluate(TURN, [canvas.element_handle(), seconds])
    return there, told["rate"], told["share"]


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0)
