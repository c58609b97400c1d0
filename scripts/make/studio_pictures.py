"""Make the pictures of the studio: docs/images/studio-edit.png, studio-3d.png, studio-run.png and studio-review.png.

Drives the real page over the gallery in chromium: opens it, runs a quarter of its way while it is recorded, and marks a
part of the recording.
"""

import re
import tempfile
from pathlib import Path

from playwright.sync_api import Browser, Page, expect

import mjsim
from mjsim.bench.chromium import chromium
from mjsim.web import Studio

ROOT = Path(__file__).parents[2]

GALLERY = Path(mjsim.__file__).parent.parent / "worlds" / "gallery.yaml"
IMAGES = ROOT / "docs" / "images"
SIZE = {"width": 1280, "height": 720}
SHARP = 1.5
"""Pixels of the picture for one of the page."""
UNTIL = 24.0
"""Simulated time of the picture of a run [s]."""
REACHED = """until => {
  const shown = document.querySelector(".run-time").textContent.split(" ")[0];
  return shown.split(":").reduce((sum, part) => 60 * sum + Number(part), 0) >= until;
}"""
PATIENCE = 900_000
"""Time limit for an action of the page [ms]."""


def main() -> None:
    """Make all four."""
    expect.set_options(timeout=PATIENCE)
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        Path(folder, "gallery.yaml").write_text(GALLERY.read_text())
        with Studio(folder, world="gallery.yaml") as studio:
            page = window(browser, studio.url, "light")
            edit(page)
            solids(page)
            run(page)
            review(window(browser, studio.url, "dark"))


def window(browser: Browser, url: str, scheme: str) -> Page:
    """Open the studio."""
    context = browser.new_context(viewport=SIZE, color_scheme=scheme, device_scale_factor=SHARP)
    context.set_default_timeout(PATIENCE)
    page = context.new_page()
    page.goto(url)
    return page


def keep(page: Page, name: str) -> None:
    """Write what the page shows."""
    page.mouse.move(2, 2)
    page.wait_for_timeout(3000)
    page.screenshot(path=IMAGES / f"{name}.png")
    print(IMAGES / f"{name}.png")


def edit(page: Page) -> None:
    """Show the plan, with a picture on a wall selected."""
    plan = page.locator("#view-edit .plan")
    expect(plan).to_have_attribute("data-view", re.compile(","))
    left, top, scale = plan.evaluate("plan => JSON.parse(plan.dataset.view)")
    box = plan.bounding_box()
    assert box is not None, "the plan is on the page"
    # The whale hangs across a corner of the east room.
    page.mouse.click(box["x"] + left + 12.593 * scale, box["y"] + top - 4.923 * scale)
    keep(page, "studio-edit")


def solids(page: Page) -> None:
    """Show the same picture beside the plan in 3-D."""
    press = page.locator("#view-edit").get_by_title("View in 3-D")
    press.click()
    page.locator("#view-edit .scene[data-filled]").wait_for()
    keep(page, "studio-3d")
    press.click()


def run(page: Page) -> None:
    """Show the run in the east, on its first round."""
    page.get_by_role("tab", name="Run", exact=True).click()
    page.get_by_label("Record to a file").check()
    page.get_by_label("Speed", exact=True).select_option("max")
    page.get_by_role("button", name="Start", exact=True).click()
    page.wait_for_function(REACHED, arg=UNTIL)
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_role("tab", name="Noise", exact=True).click()
    page.locator("[data-view='outside'] canvas[data-filled]").wait_for()
    keep(page, "studio-run")
    page.get_by_role("button", name="Stop the run").click()
    expect(page.locator(".run-state")).to_have_text("Ended")


def review(page: Page) -> None:
    """Show the recording at a doorway, with a part of it marked."""
    page.get_by_role("tab", name="Review", exact=True).click()
    page.locator("[data-path='out/gallery/run.mcap']").click()
    page.locator(".review[data-open]").wait_for()
    charts = page.locator(".run-chart .u-over")
    box = charts.nth(1).bounding_box()
    assert box is not None, "charts are on the page"
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 30, steps=5)
    page.mouse.up()
    page.get_by_role("slider", name="Time").evaluate(
        "slider => { slider.value = 15.2; slider.dispatchEvent(new Event('input')) }"
    )
    page.locator("[data-view='scout/front'] canvas[data-time='15.2']").wait_for()
    page.locator("[data-figure='Position error, RMSE']").wait_for()
    keep(page, "studio-review")


if __name__ == "__main__":
    main()
