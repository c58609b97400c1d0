"""The Run view of the studio's page, where a run is touched by hand, for tests."""

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

import numpy as np
from playwright.sync_api import Browser, Locator, Page, expect

from mjsim.web import Studio
from tests.browser import browser as listener
from tests.windows import PATIENCE, page_at

CELL = """\
mjsim: 1
name: cell
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
robots:
  - {name: r, base: fixed, at: [2, 2], heading_deg: 90, arms: [{preset: puma560, start_deg: [0, 45, 0, 0, 30, 0]}]}
run: {seconds: 1000, rate_hz: 10}
"""
SHOWN = """time => {
  const parts = document.querySelector(".run-time").textContent.split(" ")[0].split(":");
  return parts.reduce((sum, part) => 60 * sum + Number(part), 0) >= time;
}"""
LOOK = 50
"""Between two looks at the page [ms]: one with each frame asks the page for frames."""
IS_LED = "([canvas, key]) => JSON.parse(canvas.dataset.leads || '[]').some(([each]) => each.includes(key))"
LARGER = "([canvas, small]) => canvas.clientHeight > small"


@contextmanager
def running(browser: Browser, folder: Path, text: str, *, record: bool = False) -> Iterator[tuple[Studio, Page]]:
    """Run a world, which may be recorded, on the page of a studio."""
    (folder / "room.yaml").write_text(text)
    expect.set_options(timeout=PATIENCE)
    with Studio(folder, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        expect(page.get_by_label("Duration", exact=True)).to_be_visible()  # what comes above moves the rest down
        page.get_by_label("Record to a file").set_checked(record)
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running")
        yield studio, page


def restart(studio: Studio, page: Page) -> None:
    """Run the world from the beginning, where nothing is touched yet."""
    touch(page, on=False)
    before = now(studio)["time"]
    page.get_by_role("button", name="Restart from the beginning").click()
    until(studio, page, lambda tick: tick["time"] < before)
    expect(page.locator("#view-run .run-keep")).to_have_attribute("hidden", "")
    expect(page.locator(".run-state")).to_have_text("Running")


def tab(page: Page, name: str) -> None:
    """Show a tab beside the plan."""
    page.get_by_role("tab", name=name, exact=True).locator("visible=true").click()


def touch(page: Page, *, on: bool) -> None:
    """Begin to touch the run by hand, or end it."""
    button = page.get_by_role("button", name="Touch: drag")
    if (button.get_attribute("aria-pressed") == "true") != on:
        button.click()


def now(studio: Studio, kind: str = "tick") -> dict:
    """Return the newest tick, or other news."""
    with listener(studio.url) as watcher:
        return watcher.until(kind)


def touched(studio: Studio) -> list[dict]:
    """Return what was done by hand, as events."""
    return now(studio, "run").get("touched", [])


def last_target(event: dict) -> list[float]:
    """Return where an event takes joints at last [deg]."""
    return event["then"][-1][1:] if event.get("then") else event.get("joints_deg", [event.get("to_deg")])


def until(studio: Studio, page: Page, fact: Callable[[dict], bool]) -> dict:
    """Wait until a tick has something, and until the page shows that tick or a later one; return the tick."""
    with listener(studio.url) as watcher:
        while not fact(tick := watcher.until("tick")):
            pass
    page.wait_for_function(SHOWN, arg=tick["time"] - 0.005, timeout=PATIENCE, polling=LOOK)
    return tick


def shown(studio: Studio, page: Page) -> dict:
    """Return a new tick, once the page shows it or a later one: what is dragged is then where it says."""
    return until(studio, page, lambda _: True)


def same(value: Callable[[dict], object]) -> Callable[[dict], bool]:
    """Return a fact of a tick: a value is what it was at the tick before."""
    before: list[object] = [None]

    def fact(tick: dict) -> bool:
        before.append(value(tick))
        return before[-1] == before[-2]

    return fact


def near(pose: tuple[float, ...], x: float, y: float) -> bool:
    return abs(pose[0] - x) + abs(pose[1] - y) < 0.06


def screen(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return where a place of the world [m] lies on the page [px]."""
    host = page.locator(".run-floor")
    left, top, scale = json.loads(host.get_attribute("data-view"))
    box = host.bounding_box()
    return box["x"] + left + x * scale, box["y"] + top - y * scale


def drag(page: Page, begin: tuple[float, float], end: tuple[float, float]) -> None:
    """Drag from a place of the world to another one [m]."""
    page.mouse.move(*screen(page, *begin))
    page.mouse.down()
    page.mouse.move(*screen(page, *end), steps=2)
    page.mouse.up()


def pick(page: Page, at: tuple[float, float], entry: str) -> None:
    """Choose from the menu of a place of the world [m]."""
    page.mouse.click(*screen(page, *at), button="right")
    page.get_by_role("menuitem", name=entry, exact=True).click()


def tool_at(tick: dict) -> tuple[float, float]:
    """Return where the tool in the cell is on the plan [m]; its robot stands at [2, 2] and faces along y."""
    x, y, *_ = tick["robots"]["r"]["arms"]["arm"]["tool"]
    return 2 - y, 2 + x


def goal(tick: dict) -> list[float]:
    """Return where the joints of the arm in the cell shall be [rad]."""
    return tick["robots"]["r"]["arms"]["arm"]["goal"]


def tool_rests() -> Callable[[dict], bool]:
    """Return a fact of a tick: the joints of the arm shall be where they were to be at the tick before."""
    return same(goal)


def grip(tick: dict, name: str) -> dict[str, np.ndarray]:
    """Return where the handle of a joint and the joint are on the plan [m]."""
    (found,) = (each for each in tick["grips"] if each["joint"] == name)
    return {key: np.array(found[key][:2]) for key in ("grip", "at")}


def metres_missed(page: Page, what: str) -> str:
    """Return how far a hand or a tool stays away from where it was led, as it is told once at the end [m]."""
    line = page.locator(".toast.done", has_text=f"{what} cannot reach that point:")  # a second line would fail
    # A line stays for seconds: it is taken away, as the next one is of another time.
    text = line.evaluate("line => { line.remove(); return line.textContent; }")
    return re.search(r"stops ([\d.]+) m away", text)[1]


def keep(page: Page, count: int) -> None:
    """Keep what was done as events, and save the world."""
    tab(page, "Events")
    page.get_by_role("button", name=f"Keep {count} as event").click()
    expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
    page.keyboard.press("Control+s")
    expect(page.locator(".world .dot")).to_be_hidden()


def drawn(page: Page, at: tuple[float, float]) -> bytes:
    """Return a picture of the page around a place of the plan, some 12 px wide; the pointer is elsewhere."""
    page.mouse.move(5, 5)
    x, y = screen(page, *at)
    return page.screenshot(clip={"x": x - 6, "y": y - 6, "width": 12, "height": 12})


def expect_drawn(page: Page, at: tuple[float, float], picture: bytes, *, same: bool) -> None:
    """Wait until a place of the plan looks as in a picture, or otherwise."""
    ends = monotonic() + PATIENCE / 1000
    while (drawn(page, at) == picture) != same:
        assert monotonic() < ends
        page.wait_for_timeout(100)  # the page goes on meanwhile


def opened(page: Page) -> Locator:
    """Open the view in 3-D of a run that can be touched, large, and return its canvas once it is drawn so."""
    page.evaluate("() => localStorage.setItem('mjsim.run.scene.slow', 'yes')")
    page.locator("#view-run").get_by_title("View in 3-D").click()
    expect(page.locator("#view-run .scene")).to_have_attribute("data-filled", "")
    touch(page, on=True)
    canvas = page.locator("#view-run .scene canvas")
    small = canvas.evaluate("canvas => canvas.clientHeight")
    page.locator("#view-run [data-view=scene] .run-enlarge").click()
    page.wait_for_function(LARGER, arg=[canvas.element_handle(), small])
    redrawn(canvas)
    return canvas


def redrawn(canvas: Locator) -> None:
    """Wait until a view in 3-D was drawn twice: a picture that was begun before may be on its way."""
    count = int(canvas.get_attribute("data-frames"))
    expect(canvas).not_to_have_attribute("data-frames", re.compile(rf"^({count}|{count + 1})$"))


def lead(
    canvas: Locator, key: str, way: str, by: tuple[float, float], *, between: Callable[[], None] = lambda: None
) -> None:
    """Drag a handle of what is led by so much [px], in the plane that faces the view for way ''.

    `between` is called between its two moves.
    """
    canvas.page.wait_for_function(IS_LED, arg=[canvas.element_handle(), key], timeout=PATIENCE)
    box = canvas.bounding_box()
    entries = json.loads(canvas.get_attribute("data-leads"))
    x, y = next((x, y) for each, along, x, y in entries if key in each and along == way)
    mouse = canvas.page.mouse
    mouse.move(box["x"] + x, box["y"] + y)
    mouse.down()
    mouse.move(box["x"] + x + 0.5 * by[0], box["y"] + y + 0.5 * by[1])
    between()
    mouse.move(box["x"] + x + by[0], box["y"] + y + by[1])
    mouse.up()
