"""A run is touched by hand in a real browser: what was done is kept as events of the world, and repeats to the byte."""

import math

import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.record import same_run
from mjsim.world import EVENT_KINDS, kind_of
from tests.hands import drag, keep, near, pick, running, until
from tests.windows import PATIENCE

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
  - name: scout
    preset: pioneer3dx
    at: [1, 1.5]
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors: [{beacons: ring, range: [0.3, 8], fov_deg: 360, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}]
mechanisms:
  - name: lift
    at: [6.5, 1.2]
    bodies: [{name: table, box: [1, 1, 0.1], mass: 5}, {name: arm, rod: [0.8, 0.04]}]
    joints:
      - {prismatic: up, of: [ground, table], axis: [0, 0, 1], start: 0.5, range: [0, 1]}
      - {revolute: swing, of: [table, arm], axis: [0, 0, 1]}
    actuators:
      - {position: up, signal: {constant: {value: 0.5}}}
      - {angle: swing, signal: {ramp: {slope_deg: 400}}}
run: {seconds: 1000, rate_hz: 10}
"""
KINDS = [
    *("move", "move", "shove", "open", "close", "remove", "move", "restore", "noise"),
    *("lead", "lead"),
]


def a_robot_a_box_a_door_a_beacon_and_a_noise_are_touched_by_pointer_menu_and_keys(page, studio):
    state = page.locator(".run-state")
    until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], 1, 1.5))
    page.get_by_role("button", name="Touch: drag").click()
    drag(page, (1, 1.5), (2.5, 2.5))
    until(studio, page, lambda tick: near(tick["robots"]["scout"]["truth"], 2.5, 2.5))
    drag(page, (2, 4.5), (1, 4.5))
    until(studio, page, lambda tick: near(tick["things"]["obstacle/bin"], 1, 4.5))
    page.keyboard.down("Shift")
    drag(page, (1, 4.5), (1.5, 4.5))  # a push
    page.keyboard.up("Shift")
    until(studio, page, lambda tick: tick["things"]["obstacle/bin"][0] > 1.02)
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
    for key in (*["PageUp"] * 2, "ArrowRight", "ArrowUp", "Enter"):  # back past the box
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
    with running(browser, tmp_path, HALL, record=True) as (studio, page):
        a_robot_a_box_a_door_a_beacon_and_a_noise_are_touched_by_pointer_menu_and_keys(page, studio)
        joints_of_a_mechanism_are_led_by_sliders(page, studio)
        page.get_by_role("button", name="Stop the run").click()
        expect(page.locator(".run-state")).to_have_text("Ended")
        keep(page, len(KINDS))
    (hand,) = tmp_path.glob("out/**/*.mcap")
    world = mjsim.load_world(tmp_path / "room.yaml")
    are_the_touches(world.run.events)
    ticks = len(mjsim.read_recording(hand).time)
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, seconds=ticks / world.run.rate_hz, record=tmp_path / "again.mcap")
    assert same_run(hand, tmp_path / "again.mcap")


def are_the_touches(events):
    """Compare what was kept with what was done."""
    assert [kind_of(event, EVENT_KINDS) for event in events] == KINDS
    noise, up, swing = events[8:]
    assert near(events[0].to, 2.5, 2.5)
    assert noise.noise == "robots.scout.odometry.noise.turn"
    assert noise.value > 0.1
    assert [(each.lead, each.joint) for each in (up, swing)] == [("lift", "up"), ("lift", "swing")]
    assert up.to_deg == 1
