"""A run is touched by hand in a real browser, and what was done is kept as events of the world's text."""

import json
import math

import pytest
from playwright.sync_api import Page, expect

import mjsim
from mjsim.web import Studio
from mjsim.world import EVENT_KINDS, ReachEvent, kind_of
from tests.browser import browser as listener
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow

HALL = """\
mjsim: 1
name: hall
walls:
  - {points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}
  - points: [[4, 0], [4, 6]]
    openings: [{name: gate, segment: 0, at: 0.5, width: 1, door: {}}]
obstacles:
  - {cylinder: [0.3, 0.5], at: [2, 4.5], movable: true, mass: 3, name: bin}
beacons: [{name: lion, at: [7.9, 3], heading_deg: 180, center: 0.6}]
robots:
  - {name: scout, preset: pioneer3dx, at: [1, 1.5]}
run: {seconds: 1000, rate_hz: 10}
"""
CELL = """\
mjsim: 1
name: cell
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
robots:
  - {name: r, base: fixed, at: [2, 2], heading_deg: 90, arms: [{preset: puma560, start_deg: [0, 45, 0, 0, 30, 0]}]}
run: {seconds: 1000, rate_hz: 10}
"""
PRESS = """\
mjsim: 1
name: press
mechanisms:
  - name: lift
    at: [2, 2]
    bodies: [{name: table, box: [1, 1, 0.1], mass: 5}, {name: arm, rod: [0.8, 0.04]}]
    joints:
      - {prismatic: up, of: [ground, table], axis: [0, 0, 1], start: 0.5, range: [0, 1]}
      - {revolute: swing, of: [table, arm], axis: [0, 0, 1]}
    actuators:
      - {position: up, signal: {constant: {value: 0.5}}}
      - {angle: swing, signal: {ramp: {slope_deg: 400}}}
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
run: {seconds: 1000, rate_hz: 10}
"""
SHOWN = """time => {
  const parts = document.querySelector(".run-time").textContent.split(" ")[0].split(":");
  return parts.reduce((sum, part) => 60 * sum + Number(part), 0) >= time;
}"""


def screen(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return where a place of the world lies on the page [px]."""
    host = page.locator(".run-floor")
    left, top, scale = json.loads(host.get_attribute("data-view"))
    box = host.bounding_box()
    return box["x"] + left + x * scale, box["y"] + top - y * scale


def until(studio, page: Page, fact) -> None:
    """Wait until a tick has something, and until the page shows that tick or a later one."""
    with listener(studio.url) as watcher:
        while not fact(tick := watcher.until("tick")):
            pass
    page.wait_for_function(SHOWN, arg=tick["time"] - 0.005, timeout=PATIENCE)


def near(pose, x, y) -> bool:
    return abs(pose[0] - x) + abs(pose[1] - y) < 0.06


def drag(page: Page, begin, end) -> None:
    page.mouse.move(*screen(page, *begin))
    page.mouse.down()
    page.mouse.move(*screen(page, *end), steps=3)
    page.mouse.up()


def pick(page: Page, at, entry: str) -> None:
    page.mouse.click(*screen(page, *at), button="right")
    page.get_by_role("menuitem", name=entry, exact=True).click()


def test_a_run_is_touched_by_pointer_menu_and_keys_and_what_was_done_is_kept(browser, tmp_path):
    (tmp_path / "hall.yaml").write_text(HALL)
    with Studio(tmp_path, world="hall.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        state = page.locator(".run-state")
        expect(state).to_have_text("Running", timeout=PATIENCE)
        until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], 1, 1.5))
        page.get_by_role("button", name="Touch: drag").click()
        drag(page, (1, 1.5), (2.5, 2.5))
        until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], 2.5, 2.5))
        drag(page, (2, 4.5), (1, 4.5))
        until(studio, page, lambda tick: near(tick["things"]["obstacle/bin"], 1, 4.5))
        drag(page, (2.5, 2.5), (4, 4))
        expect(page.locator(".toast.error")).to_contain_text("inside walls[1]")
        pick(page, (4, 1), "Open gate")
        until(studio, page, lambda tick: tick["things"]["door/gate"][2] > 1.8)
        pick(page, (4, 1), "Close gate")
        until(studio, page, lambda tick: tick["things"]["door/gate"][2] < 1.7)
        pick(page, (7.9, 3), "Switch lion off")
        until(studio, page, lambda tick: tick.get("removed") == ["lion"])
        page.get_by_role("button", name="Pause", exact=True).click()
        expect(state).to_have_text("Paused", timeout=PATIENCE)
        page.locator(".run-floor").focus()
        for key in ("PageDown", "ArrowRight", "ArrowUp", "Enter"):
            page.keyboard.press(key)
        until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], 2.6, 2.6))
        pick(page, (7.9, 3), "Switch lion on")
        until(studio, page, lambda tick: "removed" not in tick)
        page.get_by_role("tab", name="Noise").click()
        slider = page.locator("[data-key='robots.scout.odometry.noise.turn']")
        slider.press("End")
        slider.press("ArrowLeft")  # before a tick: one event of the last value
        page.get_by_role("tab", name="Events").click()
        page.get_by_role("button", name="Keep 8 as events").click()
        expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
        page.get_by_role("tab", name="Edit", exact=True).click()
        text = page.locator(".cm-content")
        expect(text).to_contain_text("restore: lion")
        page.keyboard.press("Control+s")
        expect(page.locator(".world .dot")).to_be_hidden()
        kept = mjsim.load_world(tmp_path / "hall.yaml").run.events
        kinds = [kind_of(event, EVENT_KINDS) for event in kept]
        assert kinds == ["move", "move", "open", "close", "remove", "move", "restore", "noise"]
        assert kept[-1].noise == "robots.scout.odometry.noise.turn"
        assert kept[-1].value > 0.1
        assert near(kept[0].to, 2.5, 2.5)


def tool_rests():
    """Return a fact of a tick: the joints of the arm shall be where they were to be at the tick before."""
    before = [None]

    def fact(tick) -> bool:
        before.append(tick["robots"]["r"]["arms"]["arm"]["goal"])
        return before[-1] == before[-2]

    return fact


def tool_at(tick) -> tuple[float, float]:
    """Return where the tool in the cell is on the plan [m]; its robot stands at [2, 2] and faces along y."""
    x, y, *_ = tick["robots"]["r"]["arms"]["arm"]["tool"]
    return 2 - y, 2 + x


def test_a_tool_is_dragged_on_the_plan_and_its_arm_given_back_and_both_are_kept(browser, tmp_path):
    (tmp_path / "cell.yaml").write_text(CELL)
    item = mjsim.parse_world(CELL).robots[0].arms[0]
    x, y = item.arm.fkine(item.start())[:2, 3]
    start, goal = (2 - y, 2 + x), (1.6, 2.4)
    with Studio(tmp_path, world="cell.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        until(studio, page, lambda tick: near(tool_at(tick), *start))
        page.get_by_role("button", name="Touch: drag").click()
        drag(page, start, goal)
        until(studio, page, lambda tick: near(tool_at(tick), *goal))
        drag(page, goal, (3.8, 3.8))
        said = "The tool of arm of r cannot reach that point"
        expect(page.locator(".toasts")).to_contain_text(said, timeout=PATIENCE)
        # It goes there as far as it can.
        until(studio, page, lambda tick: math.dist(tool_at(tick), (3.8, 3.8)) < math.dist(goal, (3.8, 3.8)) - 0.3)
        until(studio, page, tool_rests())
        with listener(studio.url) as watcher:
            edge = tool_at(watcher.until("tick"))
        pick(page, edge, "Return control to its navigator")
        page.get_by_role("tab", name="Events").click()
        page.get_by_role("button", name="Keep 3 as events").click()
        expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
        page.keyboard.press("Control+s")
        expect(page.locator(".world .dot")).to_be_hidden()
    kept = mjsim.load_world(tmp_path / "cell.yaml").run.events
    assert [kind_of(event, EVENT_KINDS) for event in kept] == ["reach", "reach", "release"]
    assert isinstance(kept[0], ReachEvent)
    # One step of the drag at least; if the page was quick, that was all.
    x, y, _ = kept[0].then[-1][1:] if kept[0].then else kept[0].tool
    assert near((2 - y, 2 + x), *goal)


def test_joints_of_a_mechanism_are_led_by_sliders_and_that_is_kept(browser, tmp_path):
    (tmp_path / "press.yaml").write_text(PRESS)
    with Studio(tmp_path, world="press.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        page.get_by_role("tab", name="Joints").click()
        up, swing = (page.get_by_role("slider", name=name) for name in ("up", "swing"))
        expect(up).to_be_enabled(timeout=PATIENCE)
        expect(page.get_by_text("Start a run of a robot with an arm")).to_be_hidden()
        up.press("End")  # to the upper end of its range
        until(studio, page, lambda tick: abs(tick["mechanisms"]["lift"]["positions"][0] - 1) < 1e-3)
        expect(page.get_by_label("up, m")).to_have_value("1.00")
        swing.press("Home")  # to half a turn back, in the turn that it is in
        before = []
        until(
            studio,
            page,
            lambda tick: (
                before.append(tick["mechanisms"]["lift"]["positions"][1])
                or (len(before) > 5 and before[-1] == before[-6] and before[-1] > 0)
            ),
        )
        assert before[-1] / math.pi % 2 == pytest.approx(1, abs=0.01)
        field = page.get_by_label("up, m")
        field.fill("3")
        field.press("Enter")
        expect(page.locator(".toast.error")).to_contain_text("cannot go to 3; its range is 0 to 1")
        page.get_by_role("tab", name="Events").click()
        page.get_by_role("button", name="Keep 2 as events").click()
        expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
        page.keyboard.press("Control+s")
        expect(page.locator(".world .dot")).to_be_hidden()
    kept = mjsim.load_world(tmp_path / "press.yaml").run.events
    assert [(event.lead, event.joint) for event in kept] == [("lift", "up"), ("lift", "swing")]
    assert kept[0].to_deg == 1
