"""What depends on things goes with them, comes back with them, and follows their names, in a real browser."""

import pytest
from playwright.sync_api import expect

from mjsim.world import EVENT_KINDS, kind_of, load_world

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
walls:
  - points: [[0, 0], [8, 0], [8, 6], [0, 6]]
    closed: true
    openings: [{name: gate, segment: 0, at: 3, width: 1, door: {}}]
obstacles:
  - {name: chair, box: [0.5, 0.5, 0.5], at: [6, 4], seat: {at: [0, 0, 0.5]}, targets: [{sight: top, at: [0, 0, 1]}]}
beacons:
  - {name: lion, on: scout, at: [0, 0], heading_deg: 0}
  - {name: bear, at: [7.9, 3], heading_deg: 180}
robots:
  - {name: other, preset: pioneer3dx, at: [1, 1]}
  - name: scout
    base: fixed
    at: [4, 3]
    arms: [{name: arm, preset: puma560}]
    sensors:
      - {camera: front, on: arm/tool, width: 64, height: 48, fov_deg: 60, rate_hz: 5}
      - {lidar: scan, at: [0.1, 0, 0.3], beams: 9, fov_deg: 90, range: [0.1, 8], rate_hz: 5}
people: [{name: eve, sex: female, seat: chair, gaze: chair.top}]
mechanisms:
  - name: cart
    at: [2, 5]
    bodies: [{name: slider, box: [0.4, 0.2, 0.1], mass: 1}]
    joints: [{prismatic: x, of: [ground, slider], axis: [1, 0, 0]}]
    actuators: [{name: push, force: x, signal: {constant: {value: 0}}}]
plants: [{name: swing, of: cart, input: push, outputs: [x], around: {x: 0.1}}]
run:
  drivers:
    other: {observer: null}
    scout: {navigator: {use: "mjsim.algorithms.joint_path:JointPath", arm: arm, to_deg: [0, 0, 0, 0, 0, 0], seconds: 1}}
  events:
    - {time: 1, open: gate}
    - {time: 2, move: other, to: [2, 2]}
    - {time: 3, reach: scout, arm: arm, joints_deg: [0, 0, 0, 0, 0, 0]}
    - {time: 4, noise: robots.scout.sensors.scan.noise.range, value: 0.1}
    - {time: 5, remove: lion}
    - {time: 6, remove: chair}
"""


def saved(sheet, folder):
    """Save, and return the world of the text."""
    sheet.save()
    return load_world(folder / "room.yaml")


def choose(sheet, name):
    sheet.page.get_by_label("Search things").fill(name)
    sheet.page.get_by_role("treeitem").filter(has_text=name).last.click()
    expect(sheet.title).to_have_text(name)
    sheet.plan.focus()


def verbs(world):
    return [kind_of(event, EVENT_KINDS) for event in world.run.events]


def deleted_things_take_along_what_names_them_and_one_undo_brings_all_back(sheet, tmp_path):
    before = (tmp_path / "room.yaml").read_text()
    choose(sheet, "scout")
    sheet.press("Delete")
    expect(sheet.page.get_by_text("scout deleted, with what depended on it (5)")).to_be_visible()
    world = saved(sheet, tmp_path)
    assert verbs(world) == ["open", "move", "remove"]
    assert [beacon.name for beacon in world.beacons] == ["bear"]
    assert set(world.run.drivers) == {"other"}
    sheet.press("Control+z")
    sheet.save()
    assert (tmp_path / "room.yaml").read_text() == before
    choose(sheet, "chair")
    sheet.press("Delete")
    eve = saved(sheet, tmp_path).people[0]
    assert (eve.seat, eve.gaze) == (None, None)
    assert (round(eve.at[0], 1), round(eve.at[1], 1)) == (6, 4)
    choose(sheet, "cart")
    sheet.press("Delete")
    assert saved(sheet, tmp_path).plants == ()
    choose(sheet, "gate")
    sheet.press("Delete")
    assert verbs(saved(sheet, tmp_path)) == ["move", "reach", "noise", "remove"]
    sheet.button("Undo steps").click()
    expect(sheet.page.get_by_role("menuitemradio").first).to_have_text("Delete gate")


def rename(sheet, path, fresh):
    """Give another value to the field of a path."""
    field = sheet.page.locator(f"input[data-id='{path}']")
    field.evaluate("field => { for (let each = field; each; each = each.parentElement) each.open = true; }")
    field.fill(fresh)
    field.press("Enter")


def new_names_of_parts_are_followed(sheet, tmp_path):
    choose(sheet, "scout")
    rename(sheet, '["robots",1,"sensors",1,"lidar"]', "laser")
    sheet.reads("robots.scout.sensors.laser.noise.range")
    rename(sheet, '["robots",1,"arms",0,"name"]', "left")
    sheet.reads("on: left/tool", "arm: left, to_deg", "reach: scout, arm: left")
    choose(sheet, "cart")
    rename(sheet, '["mechanisms",0,"joints",0,"prismatic"]', "y")
    sheet.reads("force: y", "outputs: [y], around: {y: 0.1}")
    choose(sheet, "other")
    rename(sheet, '["robots",0,"name"]', "rover")
    sheet.reads("move: rover", "rover: {observer: null}")
    assert saved(sheet, tmp_path).run.events


def test_what_depends_on_things_goes_with_them_and_follows_their_names(sheet, tmp_path):
    deleted_things_take_along_what_names_them_and_one_undo_brings_all_back(sheet, tmp_path)
    sheet.put(ROOM)
    new_names_of_parts_are_followed(sheet, tmp_path)
