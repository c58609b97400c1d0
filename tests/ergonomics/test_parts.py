"""What a page says of a workplace, its plots in numbers, and reach in single directions."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mjsim.ergonomics.clearance import Clearance
from mjsim.ergonomics.reach import Envelope, TargetReach
from mjsim.ergonomics.sight import FIELD, DisplayView, eyes_of, in_field
from mjsim.ergonomics.workplace_page import _blocks, fault_lines, posture_plot, reach_plot, sight_plot
from mjsim.ergonomics.workplace_study import PersonStudy, SeatSetting, figures_of
from mjsim.people import SIDES
from mjsim.posture import ANGLES, Seated, Workstation, comfort_of, posture_angles
from mjsim.report import html_page, picture
from mjsim.world import parse_world

WORLD = """mjsim: 1
obstacles:
  - name: chair
    box: [0.4, 0.5, 0.4]
    at: [1, 2]
    heading_deg: 90
    seat: {at: [0, 0, 0.49], back_deg: 10, travel: [0.2, 0.1]}
  - name: desk
    box: [0.6, 1.2, 0.3]
    at: [1, 2.6]
    heading_deg: 90
    elevation: 0.4
    targets:
      - {grip: key, at: [-0.2, 0.1, 0.35]}
      - {grip: far, at: [3, 0, 0.5]}
      - {pedal: brake, at: [0.1, -0.1, -0.3]}
      - {display: screen, at: [0, 0, 0.6], size: [0.4, 0.3]}
      - {sight: clock, at: [1, 0, 1]}
people: [{name: anna, sex: female, seat: chair, hands: {left: desk.key}, gaze: desk.screen}]
"""
SETTING = SeatSetting(sex="male", percentile=95.0, set_by=(0.1, -0.05), ideal=(0.25, 0.0), missed=("left foot",))
TURNED = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""world_from_seat: the chair heads along y."""


@pytest.fixture(scope="module")
def study():
    world = parse_world(WORLD)
    (anna,) = world.people
    place, figure = Workstation.of(world, anna), anna.figure
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = TURNED, (1.0, 2.02, 0.5)
    errors = {"left hand": 0.25, "gaze": math.radians(3.0), "back": 0.0}
    solution = SimpleNamespace(errors=errors, missed=("left hand", "gaze"))
    sitting = Seated(
        values=np.radians(np.arange(len(figure.joints)) / 10),
        world_from_pelvis=pose,
        set_by=(0.02, -0.03),
        solution=solution,
    )
    poses = figure.poses(sitting.values, pose)
    points = np.array([[[1.0, 3.0, 1.0], [np.nan] * 3], [[1.5, 2.5, 1.2], [0.5, 2.5, 0.6]]])
    view = DisplayView(
        shares={"left": 0.5, "right": 0.25, "both": 0.125, "either": 0.625},
        hidden_by={"desk": 0.375},
        distance=0.654,
        incidence_deg=44.0,
    )
    hit = Clearance("left_thigh", "desk", -0.05)
    return PersonStudy(
        model=None,
        person=anna,
        place=place,
        seated=sitting,
        poses=poses,
        angles=posture_angles(figure, poses),
        reaches=[TargetReach("desk.key", "left", 0.0, 0.0), TargetReach("desk.far", "right", 2.5, 2.25)],
        views={"desk.screen": view},
        clearances=[hit, Clearance("head", "lamp", 0.1)],
        collisions=[hit],
        settings=[SETTING],
        envelopes=[Envelope(side=side, shoulder=np.array([1.0, 2.0, 1.0]), points=points) for side in SIDES],
        eyes=eyes_of(figure, poses, gaze=place.goals.gaze),
    )


def local(points):
    """Return points of the world in the frame of the seat: ahead, left, up."""
    x, y, z = np.moveaxis(np.asarray(points) - [1.0, 2.0, 0.49], -1, 0)
    return np.stack([y, -x, z], axis=-1)


def test_a_page_has_posture_contacts_reach_sight_clearance_and_seat_in_this_order(study):
    images = {name: picture(name, b"") for name in ("posture", "reach", "sight", "outside", "left_eye", "right_eye")}
    page = html_page("anna", "mjsim", *_blocks(study, images))
    stature = 1000 * study.person.figure.measures["stature"]
    bare = {name for name in study.angles if not name.startswith(("left_", "right_"))}
    sided = next(name for name in study.angles if name.startswith("left_"))
    facts = [
        f"female, stature {stature:.0f} mm, on chair, set +20 mm along and -30 mm up",
        "left hand is out of reach by 250.0 mm",
        "gaze is off by 3.0 degrees",
        "left_thigh goes 50 mm into desk",
        'alt="outside"',
        "Posture</h2>",
        'alt="posture"',
        "Contacts</h2>",
        "250.0000 mm",
        "3.0000 deg",
        "Reach</h2>",
        'alt="reach"',
        "reached",
        "out of reach by 2500 mm",
        "out of reach by 2250 mm",
        "Sight</h2>",
        'alt="sight"',
        "50.0 %",
        "25.0 %",
        "12.5 %",
        "62.5 %",
        "desk 37.5 %",
        "0.65",
        "44 (below 45)",
        'alt="left_eye"',
        'alt="right_eye"',
        "Clearance</h2>",
        "-50",
        "100",
        "Seat</h2>",
        "male, percentile 95",
        "+100",
        "-50",
        "+250",
        "+0",
        "left foot",
    ]
    at = 0
    for fact in facts:
        found = page.find(fact, at)
        assert found >= 0, fact
        at = found + 1
    assert all(ANGLES[name] in page for name in bare)
    assert f"left, {ANGLES[sided.removeprefix('left_')]}" in page
    assert all(f"{each.low:g} to {each.high:g} ({each.source})" in page for name in bare for each in comfort_of(name))
    assert ("none</td>" in page) == any(not comfort_of(name) for name in study.angles)


def test_a_page_without_displays_faults_and_pictures_has_none(study):
    plain = replace(
        study, views={}, collisions=[], seated=replace(study.seated, solution=SimpleNamespace(errors={}, missed=()))
    )
    images = {name: picture(name, b"") for name in ("posture", "reach", "sight")}
    page = html_page("anna", "mjsim", *_blocks(plain, images))
    assert "There is no display." in page
    assert "NUREG" not in page
    assert "eye" not in page.partition("<body")[2].replace("left eye", "").partition("Sight</h2>")[0]
    assert fault_lines(plain) == []
    assert [f"{name} is" in " ".join(fault_lines(study)) for name in ("left hand", "gaze", "back")] == [
        True,
        True,
        False,
    ]


def test_figures_have_units_in_their_keys(study):
    told = figures_of(study)
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert (told["person"], told["sex"], told["seat"]) == ("anna", "female", "chair")
    assert (told["seat_set_by_m"], told["missed"]) == ([0.02, -0.03], ["left hand", "gaze"])
    assert told["stature_m"] == study.person.figure.measures["stature"]
    assert list(told["joints_deg"].values()) == pytest.approx(np.arange(len(study.seated.values)) / 10)
    assert told["contacts"]["left hand"] == {"error_mm": 250.0}
    assert told["contacts"]["gaze"]["error_deg"] == pytest.approx(3.0)
    assert told["reach"]["desk.far"] == {"limb": "right", "short_m": 2.5, "short_leaning_m": 2.25}
    shown = told["displays"]["desk.screen"]
    assert (shown["visible"]["either"], shown["hidden_by"]) == (0.625, {"desk": 0.375})
    assert (shown["distance_m"], shown["incidence_deg"]) == (0.654, 44.0)
    hit = {"segment": "left_thigh", "thing": "desk", "distance_m": -0.05}
    assert (told["collisions"], told["clearances"][0], len(told["clearances"])) == ([hit], hit, 2)
    (setting,) = told["seat_travel"]
    assert (setting["set_by_m"], setting["wished_m"], setting["missed"]) == ([0.1, -0.05], [0.25, 0.0], ["left foot"])
    assert (setting["sex"], setting["percentile"]) == ("male", 95.0)
    envelope = told["envelopes"]["right"]
    assert envelope["shoulder"] == [1.0, 2.0, 1.0]
    assert envelope["points"][0] == [[1.0, 3.0, 1.0], None]
    for name, angle in told["angles_deg"].items():
        assert angle["value"] == study.angles[name]
        assert [(each["low"], each["high"], each["source"]) for each in angle["published"]] == [
            (each.low, each.high, each.source) for each in comfort_of(name)
        ]


def test_a_posture_is_drawn_from_the_right_and_from_above_in_the_frame_of_the_seat(study):
    figure = posture_plot(study)
    side, above = figure.axes
    assert (side.get_title(), side.get_ylabel(), above.get_title(), above.get_ylabel()) == (
        "from the right", "up [m]", "from above", "left [m]",
    )  # fmt: skip
    assert {axes.get_xlabel() for axes in figure.axes} == {"ahead of the hip point [m]"}
    assert {axes.get_aspect() for axes in figure.axes} == {1.0}
    assert [text.get_text() for text in side.get_legend().get_texts()] == [
        "reach of the left thumb", "reach of the right thumb",
    ]  # fmt: skip
    spots = study.person.figure.spots(study.poses)
    for axes, across in ((side, 2), (above, 1)):
        drawn = [np.column_stack(line.get_data()) for line in axes.lines]
        body = [line for line, each in zip(drawn, axes.lines, strict=True) if each.get_marker() == "o"]
        trunk = local(
            [*(study.poses[name][:3, 3] for name in ("pelvis", "abdomen", "thorax", "neck", "head")), spots["vertex"]]
        )
        leg = local([*(study.poses[f"right_{name}"][:3, 3] for name in ("thigh", "shank", "foot")), spots["right_toe"]])
        arm = local(
            [*(study.poses[f"left_{name}"][:3, 3] for name in ("upper_arm", "forearm", "hand")), spots["left_grip"]]
        )
        assert len(body) == 5
        for chain in (trunk, leg, arm):
            assert any(line.shape == (len(chain), 2) and np.allclose(line, chain[:, [0, across]]) for line in body)
        # A reach has its rows and columns, and an entry of the legend, for each hand.
        assert sum(each.get_lw() == 0.7 for each in axes.lines) == 8
        row = local(study.envelopes[0].points)[1][:, [0, across]]
        assert any(line.shape == row.shape and np.allclose(line, row) for line in drawn)
        # What is near is named, and a display has its face in points.
        assert {text.get_text() for text in axes.texts} == {"key", "brake", "screen"}
        crosses = [np.ravel(each.get_data()) for each in axes.lines if each.get_marker() == "x"]
        key = local(study.place.targets["desk.key"].world_from_target[:3, 3])[[0, across]]
        assert len(crosses) == 3  # the clock is too far away
        assert any(np.allclose(cross, key) for cross in crosses)
        (face,) = (np.column_stack(each.get_data()) for each in axes.lines if each.get_marker() == ".")
        middle = local(study.place.targets["desk.screen"].world_from_target[:3, 3])
        np.testing.assert_allclose(np.mean(face, axis=0), middle[[0, across]], atol=1e-9)
        assert 0.2 < np.ptp(face[:, 1]) <= {2: 0.3, 1: 0.4}[across]


def test_reach_is_drawn_as_surfaces_of_both_hands(study):
    full = replace(
        study, envelopes=[replace(each, points=np.nan_to_num(each.points, nan=1.0)) for each in study.envelopes]
    )
    (axes,) = reach_plot(full).axes
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()) == (
        "ahead of the hip point [m]",
        "left [m]",
        "up [m]",
    )
    assert (axes.elev, axes.azim) == (20.0, -55.0)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "reach of the left thumb",
        "reach of the right thumb",
    ]
    assert {text.get_text().strip() for text in axes.texts} == {"key", "brake", "screen"}
    assert len(axes.collections) == 2
    assert len(axes.lines) == 5 + 3
    key = local(study.place.targets["desk.key"].world_from_target[:3, 3])
    assert any(np.allclose(np.ravel(line.get_data_3d()), key) for line in axes.lines if line.get_marker() == "x")
    assert axes.zz_dataLim.xmax >= local([1.5, 2.5, 1.2])[2]
    assert axes.xy_dataLim.ymin == pytest.approx(local([1.5, 2.5, 1.2])[1])
    assert [each.get_edgecolor()[0][:3].round(2).tolist() for each in axes.collections] == [
        [0.17, 0.5, 0.72],
        [0.85, 0.37, 0.05],
    ]


def test_fields_and_displays_are_drawn_as_angles_from_the_line_of_sight(study):
    (axes,) = sight_plot(study).axes
    (left, right) = (np.column_stack(line.get_data()) for line in axes.lines if line.get_marker() != ".")
    assert (left[:, 0].min(), left[:, 0].max()) == pytest.approx((-FIELD["temporal"], FIELD["nasal"]), abs=0.1)
    assert (right[:, 0].min(), right[:, 0].max()) == pytest.approx((-FIELD["nasal"], FIELD["temporal"]), abs=0.1)
    for edge in (left, right):
        assert (edge[:, 1].min(), edge[:, 1].max()) == pytest.approx((-FIELD["down"], FIELD["up"]), abs=0.1)
    # Just inside of the edge is in the field, just outside is not.
    for eye, edge in zip(study.eyes, (left, right), strict=True):
        for scale, inside in ((0.99, True), (1.01, False)):
            across, up = scale * edge[5::9].T
            away = np.radians(np.hypot(across, up))
            flat = np.sin(away) / np.hypot(across, up)
            ways = np.column_stack([np.cos(away), -across * flat, up * flat]) @ eye.axes.T
            assert (in_field(eye, eye.place + ways) == inside).all()
    shown = [np.column_stack(line.get_data()) for line in axes.lines if line.get_marker() == "."]
    assert len(shown) == 2
    for eye, dots in zip(study.eyes, shown, strict=True):
        # Eyes look at the middle of the display, which is 0.4 m wide and upright.
        target = study.place.targets["desk.screen"].world_from_target[:3, 3]
        away = np.linalg.norm(target - eye.place)
        assert np.abs(dots.mean(axis=0)).max() < 1.5
        assert np.ptp(dots[:, 0]) == pytest.approx(2 * np.degrees(np.arctan2(0.2, away)), rel=0.12)
    (name,) = axes.texts
    assert (name.get_text(), abs(name.xy[0]) < 1.0, name.xy[1] == pytest.approx(shown[0][:, 1].max())) == (
        "desk.screen",
        True,
        True,
    )
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "to the right of the line of sight [deg]",
        "above the line of sight [deg]",
    )
    assert len(axes.get_legend().get_texts()) == 2


def test_what_is_to_the_right_and_below_of_where_one_looks_is_drawn_there(study):
    target = study.place.targets["desk.screen"].world_from_target[:3, 3]
    # The person heads along y, so that x is to its right: it looks to the left of the display, and above it.
    eyes = eyes_of(study.person.figure, study.poses, gaze=target + np.array([-0.4, 0.0, 0.3]))
    (axes,) = sight_plot(replace(study, eyes=eyes)).axes
    for dots in (np.column_stack(line.get_data()) for line in axes.lines if line.get_marker() == "."):
        assert dots[:, 0].mean() > 5.0
        assert dots[:, 1].mean() < -5.0
