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

BASE = (6, 4)
"""Where the base of the arm is [m]; it faces along y."""
HALL = f"""\
mjsim: 1
name: hall
walls:
  - {{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}}
  - points: [[4, 0], [4, 6]]
    openings: [{{name: gate, segment: 0, at: 0.5, width: 1, door: {{}}}}]
obstacles:
  - {{cylinder: [0.3, 0.5], at: [2, 4.5], movable: true, mass: 3, name: bin}}
beacons: [{{name: lion, at: [7.9, 3], heading_deg: 180, center: 0.6}}]
robots:
  - {{name: scout, preset: pioneer3dx, at: [1, 1.5]}}
  - name: r
    base: fixed
    at: {[*BASE]}
    heading_deg: 90
    arms: [{{preset: puma560, start_deg: [0, 45, 0, 0, 30, 0]}}]
mechanisms:
  - name: lift
    at: [6.5, 1.2]
    bodies: [{{name: table, box: [1, 1, 0.1], mass: 5}}, {{name: arm, rod: [0.8, 0.04]}}]
    joints:
      - {{prismatic: up, of: [ground, table], axis: [0, 0, 1], start: 0.5, range: [0, 1]}}
      - {{revolute: swing, of: [table, arm], axis: [0, 0, 1]}}
    actuators:
      - {{position: up, signal: {{constant: {{value: 0.5}}}}}}
      - {{angle: swing, signal: {{ramp: {{slope_deg: 400}}}}}}
run: {{seconds: 1000, rate_hz: 10}}
"""
GOAL = (5.6, 4.4)
"""Where the tool is dragged [m]."""
KINDS = [
    *("move", "move", "open", "close", "remove", "move", "restore", "noise"),
    *("reach", "reach", "release"),
    *("lead", "lead"),
]
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


def a_robot_a_box_a_door_a_beacon_and_a_noise_are_touched_by_pointer_menu_and_keys(page, studio):
    state = page.locator(".run-state")
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
    for key in (*["PageUp"] * 3, "ArrowRight", "ArrowUp", "Enter"):  # back past the box and the arm
        page.keyboard.press(key)
    until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], 2.6, 2.6))
    pick(page, (7.9, 3), "Switch lion on")
    until(studio, page, lambda tick: "removed" not in tick)
    page.get_by_role("tab", name="Noise").click()
    slider = page.locator("[data-key='robots.scout.odometry.noise.turn']")
    slider.press("End")
    slider.press("ArrowLeft")  # before a tick: one event of the last value
    page.get_by_role("button", name="Resume").click()
    expect(state).to_have_text("Running", timeout=PATIENCE)


def tool_rests():
    """Return a fact of a tick: the joints of the arm shall be where they were to be at the tick before."""
    before = [None]

    def fact(tick) -> bool:
        before.append(tick["robots"]["r"]["arms"]["arm"]["goal"])
        return before[-1] == before[-2]

    return fact


def on_plan(x: float, y: float) -> tuple[float, float]:
    """Return where a point of the frame of the base is on the plan [m]."""
    return BASE[0] - y, BASE[1] + x


def tool_at(tick) -> tuple[float, float]:
    """Return where the tool is on the plan [m]; its base faces along y."""
    x, y, *_ = tick["robots"]["r"]["arms"]["arm"]["tool"]
    return on_plan(x, y)


def a_tool_is_dragged_on_the_plan_and_its_arm_given_back(page, studio):
    item = mjsim.parse_world(HALL).robots[1].arms[0]
    start, far = on_plan(*item.arm.fkine(item.start())[:2, 3]), (7.8, 5.8)
    until(studio, page, lambda tick: near(tool_at(tick), *start))
    drag(page, start, GOAL)
    until(studio, page, lambda tick: near(tool_at(tick), *GOAL))
    drag(page, GOAL, far)
    said = "The tool of arm of r cannot reach that point"
    expect(page.locator(".toasts")).to_contain_text(said, timeout=PATIENCE)
    # It goes there as far as it can.
    until(studio, page, lambda tick: math.dist(tool_at(tick), far) < math.dist(GOAL, far) - 0.3)
    until(studio, page, tool_rests())
    with listener(studio.url) as watcher:
        edge = tool_at(watcher.until("tick"))
    pick(page, edge, "Return control to its navigator")


def joints_of_a_mechanism_are_led_by_sliders(page, studio):
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
    expect(page.locator(".toast.error", has_text="cannot go to 3; its range is 0 to 1")).to_be_visible()


def test_a_run_is_touched_by_pointer_menu_keys_and_sliders_and_what_was_done_is_kept(browser, tmp_path):
    (tmp_path / "hall.yaml").write_text(HALL)
    with Studio(tmp_path, world="hall.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
        a_robot_a_box_a_door_a_beacon_and_a_noise_are_touched_by_pointer_menu_and_keys(page, studio)
        a_tool_is_dragged_on_the_plan_and_its_arm_given_back(page, studio)
        joints_of_a_mechanism_are_led_by_sliders(page, studio)
        page.get_by_role("tab", name="Events").click()
        page.get_by_role("button", name=f"Keep {len(KINDS)} as events").click()
        expect(page.get_by_role("button", name="Kept as events")).to_be_disabled()
        page.get_by_role("tab", name="Edit", exact=True).click()
        expect(page.locator(".cm-content")).to_contain_text("restore: lion")
        page.keyboard.press("Control+s")
        expect(page.locator(".world .dot")).to_be_hidden()
    are_the_touches(mjsim.load_world(tmp_path / "hall.yaml").run.events)


def are_the_touches(events):
    """Compare what was kept with what was done."""
    assert [kind_of(event, EVENT_KINDS) for event in events] == KINDS
    noise, reach, up, swing = events[7], events[8], *events[11:]
    assert near(events[0].to, 2.5, 2.5)
    assert noise.noise == "robots.scout.odometry.noise.turn"
    assert noise.value > 0.1
    assert isinstance(reach, ReachEvent)
    # One step of the drag at least; if the page was quick, that was all.
    x, y, _ = reach.then[-1][1:] if reach.then else reach.tool
    assert near(on_plan(x, y), *GOAL)
    assert [(each.lead, each.joint) for each in (up, swing)] == [("lift", "up"), ("lift", "swing")]
    assert up.to_deg == 1
