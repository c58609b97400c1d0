"""What was done by hand in Run, in a real browser, repeats to the byte once it is kept and the world is run again."""

import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.record import same_run
from mjsim.world import EVENT_KINDS, kind_of
from tests.hands import drag, keep, now, pick, running, tab, touch, until

pytestmark = pytest.mark.slow
HALL = """\
mjsim: 1
name: hall
walls:
  - {points: [[0, 0], [12, 0], [12, 8], [0, 8]], closed: true}
  - points: [[8, 0], [8, 8]]
    openings: [{name: gate, segment: 0, at: 0.5, width: 1, door: {}}]
obstacles: [{cylinder: [0.3, 0.5], at: [2, 6], movable: true, mass: 3, name: bin}]
beacons: [{name: lion, at: [0.1, 4], center: 0.6}]
people: [{name: anna, sex: female, at: [10, 4], heading_deg: 90}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 1.5]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors: [{beacons: ring, range: [0.3, 8], fov_deg: 360, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}]
  - {name: r, base: fixed, at: [5.5, 2], heading_deg: 90, arms: [{preset: puma560, start_deg: [0, 45, 0, 0, 30, 0]}]}
mechanisms:
  - name: bar
    at: [5, 6]
    bodies: [{name: bar, rod: [1.2, 0.05], mass: 2}]
    joints: [{revolute: swing, of: [ground, bar], axis: [0, 0, 1]}]
    actuators: [{angle: swing, signal: {sine: {amplitude_deg: 20, frequency_hz: 0.2}}}]
run:
  seconds: 1000
  rate_hz: 10
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[6, 4], [1, 4]], laps: 9}}}
"""
KINDS = ["move", "move", "shove", "open", "remove", "reach", "lead", "reach", "noise", "release", "release", "reach"]


def test_everything_done_by_hand_repeats_to_the_byte(browser, tmp_path):
    with running(browser, tmp_path, HALL, record=True) as (studio, page):
        first = now(studio)
        touch(page, on=True)
        x, y, _ = first["hands"]["anna"]["right"]
        tool = first["robots"]["r"]["arms"]["arm"]["tool"]
        page.get_by_role("button", name="Pause", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Paused")
        place = now(studio)["robots"]["scout"]["truth"][:2]
        until(studio, page, lambda tick: tick["robots"]["scout"]["truth"][:2] == place)
        drag(page, place, (2, 2.5))  # a robot
        done(page, 1)
        drag(page, (2, 6), (3, 7))  # a thing
        done(page, 2)
        page.get_by_role("button", name="Resume", exact=True).click()
        page.keyboard.down("Shift")
        drag(page, (3, 7), (3.5, 7))  # a push
        page.keyboard.up("Shift")
        done(page, 3)
        pick(page, (8, 1), "Open gate")
        done(page, 4)
        pick(page, (0.1, 4), "Switch lion off")
        done(page, 5)
        drag(page, (x, y), (x + 0.1, y + 0.2))  # a hand
        done(page, 6)
        tab(page, "Joints")
        page.get_by_label("swing, °").fill("60")
        page.get_by_label("swing, °").press("Enter")
        done(page, 7)
        page.locator("#view-run").get_by_label("Robot", exact=True).select_option("r")
        page.get_by_role("slider", name="joint1").fill("0.5")
        done(page, 8)
        tab(page, "Noise")
        page.locator("[data-key='robots.scout.odometry.noise.turn']").press("End")
        done(page, 9)
        tab(page, "Joints")
        page.get_by_role("button", name="Return swing to its signal").click()
        done(page, 10)
        page.get_by_role("button", name="Release", exact=True).click()
        done(page, 11)
        drag(page, (5.5 - tool[1], 2 + tool[0]), (5.5 - tool[1] + 0.1, 2 + tool[0] + 0.1))
        done(page, 12)
        page.wait_for_timeout(1500)  # what was done last goes on for a while
        page.get_by_role("button", name="Stop the run").click()
        expect(page.locator(".run-state")).to_have_text("Ended")
        keep(page, 12)
    (hand,) = tmp_path.glob("out/**/*.mcap")
    world = mjsim.load_world(tmp_path / "room.yaml")
    assert [kind_of(event, EVENT_KINDS) for event in world.run.events] == KINDS
    ticks = len(mjsim.read_recording(hand).time)
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, seconds=ticks / world.run.rate_hz, record=tmp_path / "again.mcap")
    again = mjsim.read_recording(tmp_path / "again.mcap")
    np.testing.assert_array_equal(again.qpos, mjsim.read_recording(hand).qpos)
    assert same_run(hand, tmp_path / "again.mcap")


def done(page, count: int) -> None:
    """Wait until so many things were done by hand."""
    text = f"Keep {count} as event"
    page.wait_for_function("text => document.querySelector('.run-keep button').textContent.startsWith(text)", arg=text)
