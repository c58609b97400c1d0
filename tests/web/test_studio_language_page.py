"""Names in the text are suggested and lead to their items and parts, for each kind of item, in a real browser."""

import re

import pytest
from playwright.sync_api import expect

from tests.sheet import sheet_of
from tests.web.test_studio_hints_page import at_the_end_of, stand

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
include: [parts/hall.yaml]
walls:
  - {name: north, points: [[-4, 3], [4, 3]], openings: [{name: gate, at: 2, width: 1, door: {}}]}
obstacles:
  - {name: stool, box: [0.4, 0.4, 0.5], at: [-3, 1], seat: {at: [0, 0, 0.5]}, targets: [{grip: bar, at: [0, 0, 0.6]}]}
lamps: [{name: ceiling, at: [0, 0]}]
robots:
  - name: up6
    base: fixed
    at: [2, 1]
    arms: [{name: tall, preset: motoman_up6}]
    sensors: [{camera: eye, width: 64, height: 48, at: [0, 0, 1]}]
people:
  - {name: anna, sex: female, at: [-1, 1], joints_deg: {left_elbow_flexion: 20}}
mechanisms:
  - name: cart
    at: [0, -2]
    bodies: [{name: slider, box: [0.4, 0.2, 0.1], mass: 1}, {name: pole, rod: [0.6, 0.02], mass: 0.2}]
    joints:
      - {prismatic: x, of: [ground, slider], axis: [1, 0, 0]}
      - {revolute: q, of: [slider, pole], axis: [0, 1, 0], start_deg: -90}
    actuators: [{name: push, force: x, signal: {constant: {value: 0}}}]
plants:
  - {name: swing, of: cart, input: push, outputs: [x, q], around: {q_deg: -90}}
run:
  seconds: 2
  drivers:
    up6:
      observer: {use: "mjsim.algorithms.beacon_vision:BeaconVision", camera: eye}
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam", jacobians: standard}
      controllers: {tall: {use: "mjsim.algorithms.arm_control:ComputedTorque"}}
  events:
    - {time: 1, open: gate}
    - {time: 1, lamp: ceiling, brightness: 0.5}
    - {time: 1, reach: up6, arm: tall, joints_deg: [0, 0, 0, 0, 0, 0]}
    - {time: 1, reach: anna, hand: right, to: [-1, 1.2, 1]}
    - {time: 1, remove: far}
"""
HALL = """\
mjsim: 1
obstacles:
  - {name: near, box: [1, 1, 1], at: [3, -3]}
  - {name: far, box: [1, 1, 1], at: [-3, -3]}   # the one in the corner
"""


@pytest.fixture
def page_of(browser, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "hall.yaml").write_text(HALL)
    (tmp_path / "store.yaml").write_text("mjsim: 1\n")
    with sheet_of(browser, tmp_path, ROOM) as sheet:
        yield sheet


LEADS = {
    "open: gate": "name: north",
    "lamp: ceiling": "lamps:",
    "reach: up6": "name: up6",
    "arm: tall": "arms: [",
    "camera: eye": "sensors: [",
    "reach: anna": "name: anna",
    "of: cart": "name: cart",
    "input: push": "name: push",
    "outputs: [x": "prismatic: x",
    "{q_deg": "revolute: q",
    "force: x": "prismatic: x",
    "of: [slider, pole": "name: slider",
    "up6:": "name: up6",
    "controllers: {tall": "arms: [",
}
"""Where F12 at the end of a piece of the text leads: the line that it comes to stand in."""


def f12_leads_from_each_kind_of_name_to_where_it_is_given(page_of):
    active = page_of.page.locator(".cm-activeLine")
    for piece, line in LEADS.items():
        at_the_end_of(page_of, piece, 1 if piece.endswith(":") else 0)
        page_of.press("F12")
        expect(active, piece).to_contain_text(line)


def f12_shows_an_included_file_and_what_stands_in_it(page_of):
    dialog = page_of.page.get_by_role("dialog")
    at_the_end_of(page_of, "parts/hall.yaml", 0)
    page_of.press("F12")
    expect(dialog.get_by_role("heading")).to_have_text("parts/hall.yaml")
    page_of.press("Escape")
    at_the_end_of(page_of, "remove: far", 0)
    page_of.press("F12")
    expect(dialog.locator(".begins")).to_contain_text("the one in the corner")


OFFERED = {
    "include: [": ["parts/hall.yaml", "store.yaml"],
    "of: [": ["ground", "slider", "pole"],
    "force: ": ["x", "q"],
    "outputs: [": ["x", "q"],
    "remove: ": ["far", "near", "stool"],
    "arm: ": ["tall"],
    "camera: ": ["eye"],
    "preset: ": ["motoman_up6"],
    "joints_deg: {": ["neck_flexion", "right_elbow_flexion"],
}
"""What is offered behind a piece of the text, once what stands there is taken away."""


def files_bodies_joints_arms_and_cameras_are_offered(page_of):
    options = page_of.page.locator(".cm-tooltip-autocomplete li")
    for piece, names in OFFERED.items():
        last = page_of.text.locator(".cm-line").filter(has_text=piece).last
        text = last.inner_text()
        begin = text.index(piece) + len(piece)
        rest = re.match(r"[\w./]*", text[begin:])[0]
        stand(last, begin, begin + len(rest))
        page_of.press("Backspace")
        page_of.press("Control+Space")
        for name in names:
            expect(options.get_by_text(name, exact=True), f"{piece}{name}").to_be_visible()
        page_of.press("Escape")
        page_of.page.keyboard.insert_text(rest)
        expect(last).to_have_text(text)


def the_keys_of_a_module_are_explained_and_offered(page_of):
    hint, options = page_of.page.locator(".cm-hint"), page_of.page.locator(".cm-tooltip-autocomplete li")
    for key, piece in {"use": "dotted.module:Class", "jacobians": "default", "left_elbow_flexion": "[°]"}.items():
        line = page_of.text.locator(".cm-line").filter(has_text=f"{key}:").last
        line.locator("span").get_by_text(key, exact=True).hover()
        expect(hint, key).to_contain_text(key)
        expect(hint, key).to_contain_text(piece)
        page_of.page.mouse.move(0, 0)
        expect(hint).to_have_count(0)
    at_the_end_of(page_of, "jacobians: standard", 0)
    page_of.type(", ga")
    expect(options.get_by_text("gate", exact=True)).to_be_visible()


def test_keys_are_explained_and_names_are_offered_and_lead_to_what_they_name(page_of):
    files_bodies_joints_arms_and_cameras_are_offered(page_of)
    the_keys_of_a_module_are_explained_and_offered(page_of)
    page_of.put(ROOM)
    f12_leads_from_each_kind_of_name_to_where_it_is_given(page_of)
    f12_shows_an_included_file_and_what_stands_in_it(page_of)
