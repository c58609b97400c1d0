"""Reach of limbs in single directions, seats, eyes, clearances, and pictures from eyes."""

import math
from dataclasses import replace
from types import SimpleNamespace

import cv2
import mujoco
import numpy as np
import pytest

from mjsim.ergonomics.clearance import clearances
from mjsim.ergonomics.reach import TargetReach, reach_envelope, settled, target_reach
from mjsim.ergonomics.sight import Eye, eyes_of
from mjsim.ergonomics.workplace_files import write_ergonomics
from mjsim.ergonomics.workplace_page import pictures_of
from mjsim.ergonomics.workplace_study import seat_settings, studies
from mjsim.errors import UsageError
from mjsim.people import Figure, Measures
from mjsim.posture import Goals, Seating, Sitter, Workstation
from mjsim.world import parse_world, placed_targets
from tests.ergonomics.test_parts import TURNED, WORLD


def upright(back_deg=5.0):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = TURNED, (1.0, 2.0, 0.5)
    figure = Figure.of(Measures.at_percentile("male", 50.0))
    return Sitter(figure, Seating(world_from_seat=pose, back=math.radians(back_deg)))


def target(kind, at):
    world = parse_world(
        "mjsim: 1\nobstacles: [{name: b, box: [0.1, 0.1, 0.05], at: [0, 0],"
        f" targets: [{{{kind}: t, at: [0, 0, 0]}}]}}]\n"
    )
    (placed,) = placed_targets(world)
    pose = np.eye(4)
    pose[:3, 3] = at
    return replace(placed, world_from_target=pose)


@pytest.fixture(scope="module")
def sitter():
    return upright()


@pytest.mark.parametrize(
    ("at", "kind", "limb"),
    [
        ((0.8, 2.4, 0.7), "grip", "left"),
        ((1.2, 2.4, 0.7), "grip", "right"),
        ((0.85, 2.6, 0.1), "pedal", "left"),
        ((1.15, 2.6, 0.1), "pedal", "right"),
    ],
)
def test_the_nearer_limb_reaches_what_is_near(sitter, at, kind, limb):
    assert target_reach(sitter, Goals(), target(kind, at)) == TargetReach("b.t", limb, 0.0, 0.0)


class Short:
    """Stands for a figure that reaches so far from the hip point, farther when it leans; its left is 5 mm better."""

    seating = Seating(world_from_seat=np.eye(4), back=0.0)

    def sit(self, goals):
        ((name, point),) = [
            *((f"{side} hand", point) for side, (_, point) in goals.hands.items()),
            *((f"{side} foot", point) for side, point in goals.feet.items() if side == "left"),
        ]
        assert goals.gaze is None
        reach = (0.8 if goals.leans else 1.2) + 0.005 * name.startswith("left")
        return SimpleNamespace(errors={name: max(float(np.linalg.norm(point)) - reach, 0.0)})


@pytest.mark.parametrize(
    ("at", "short", "leaning"), [(0.804, 0.0, 0.0), (1.0, 0.195, 0.0), (2.0, 1.195, 0.795), (0.80505, 0.0, 0.0)]
)
def test_a_target_that_the_nearer_hand_misses_is_tried_with_the_other_and_by_leaning(at, short, leaning):
    placed = target("grip", (0.0, -at, 0.0))
    found = target_reach(Short(), Goals(gaze=np.zeros(3)), placed)
    assert (found.target, found.limb) == ("b.t", "left")
    assert (found.short, found.leaning) == (pytest.approx(short), pytest.approx(leaning))


def test_a_target_of_the_gaze_has_no_reach():
    assert target_reach(Short(), Goals(), target("sight", (1.0, 4.0, 1.0))) is None


@pytest.mark.parametrize(("azimuth", "elevation"), [(0.0, 0.0), (0.6, 0.3)])
def test_an_envelope_is_along_its_directions_in_the_frame_of_the_seat(sitter, azimuth, elevation):
    found = reach_envelope(sitter, Goals(), "left", azimuths=np.array([azimuth]), elevations=np.array([elevation]))
    (way,) = (found.points[0] - found.shoulder) / found.distances[0][:, None]
    flat = math.cos(elevation)
    seat = [flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)]
    np.testing.assert_allclose(TURNED.T @ way, seat, atol=1e-9)
    # The arm is as long as its parts, and the chest leans on the backrest.
    spots = sitter.figure.landmarks
    arm = -sitter.figure.segments["left_forearm"].at[2] - sitter.figure.segments["left_hand"].at[2]
    arm += float(np.linalg.norm(spots["left_thumb_tip"].at))
    assert arm - 0.03 < found.distances.item() < arm + 0.25
    relaxed = sitter.sit(Goals())
    poses = sitter.figure.poses(relaxed.values, relaxed.world_from_pelvis)
    np.testing.assert_allclose(found.shoulder, poses["left_upper_arm"][:3, 3])


def test_a_seat_stays_where_it_was_set(sitter):
    found = SimpleNamespace(set_by=(0.1, -0.05))
    seat = settled(replace(sitter.seating, travel=(0.2, 0.1)), found)
    np.testing.assert_allclose(seat.world_from_seat[:3, 3], [1.0, 2.1, 0.45])
    np.testing.assert_array_equal(seat.world_from_seat[:3, :3], TURNED)
    assert seat.travel == (0.0, 0.0)


def test_small_and_large_figures_want_the_seat_elsewhere():
    world = parse_world(WORLD)
    place = Workstation.of(world, world.people[0])
    free = seat_settings(place, [50.0])
    assert [(each.sex, each.percentile) for each in free] == [("female", 50.0), ("male", 50.0)]
    for each in free:
        assert abs(each.set_by[0]) <= 0.1 + 1e-9
        assert abs(each.set_by[1]) <= 0.05 + 1e-9
        assert np.abs(each.ideal).max() <= 0.5 + 1e-9
    fixed = replace(place, seating=replace(place.seating, travel=(0.0, 0.0)))
    assert all(each.set_by == each.ideal == (0.0, 0.0) for each in seat_settings(fixed, [50.0]))


def test_eyes_look_along_the_head_or_at_a_point():
    figure = Figure.of(Measures.at_percentile("female", 50.0))
    poses = figure.poses(np.zeros(len(figure.joints)), np.eye(4))
    spots = figure.spots(poses)
    left, right = eyes_of(figure, poses)
    assert (left.side, right.side) == ("left", "right")
    for eye in (left, right):
        np.testing.assert_allclose(eye.axes.T @ eye.axes, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(eye.place, spots[f"{eye.side}_eye"])
        assert np.linalg.det(eye.axes) == pytest.approx(1.0)
        assert eye.axes[0, 0] > 0.9  # ahead, and a little down
        assert eye.axes[2, 0] < 0.0
        np.testing.assert_allclose(eye.axes[:, 1], [0.0, 1.0, 0.0], atol=1e-12)
    at = np.array([1.0, 1.0, 1.0])
    for eye in eyes_of(figure, poses, gaze=at):
        np.testing.assert_allclose(np.cross(eye.axes[:, 0], at - eye.place), 0.0, atol=1e-12)
        assert eye.axes[:, 0] @ (at - eye.place) > 0.0
        assert eye.axes[2, 1] == pytest.approx(0.0)
        assert eye.axes[2, 2] > 0.0


BODIES = """
<mujoco><worldbody>
  <geom type="plane" size="5 5 1"/>
  <geom name="wall" type="box" size="0.1 1 1" pos="0.5 0 1"/>
  <geom type="box" size="0.1 0.1 0.1" pos="0.25 0.3 0.5" contype="0" conaffinity="0"/>
  <geom type="box" size="0.1 0.1 0.1" pos="0 0 1.2" group="2"/>
  <body name="anna/hand" pos="0.1 0 0.5"><freejoint/><geom type="sphere" size="0.1"/>
    <geom type="sphere" size="0.05"/></body>
  <body name="anna/head" pos="0.44 0 1.5"><freejoint/><geom type="sphere" size="0.1"/></body>
  <body name="anna/foot" pos="-0.1 0 0.2"><freejoint/><geom type="sphere" size="0.1"/></body>
  <body name="bob/hand" pos="0.1 0 0.85"><freejoint/><geom type="sphere" size="0.1"/></body>
</worldbody></mujoco>
"""


def test_clearances_are_distances_to_what_is_solid_and_of_others():
    model = mujoco.MjModel.from_xml_string(BODIES)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = clearances(model, data, "anna")
    assert [each.segment for each in found] == ["head", "hand", "hand"]
    assert [each.distance for each in found] == pytest.approx([-0.14, 0.15, 0.2], abs=1e-6)
    assert found[1].thing.startswith("bob")
    assert len(clearances(model, data, "anna", count=2)) == 2
    assert [each.segment for each in clearances(model, data, "anna", count=0)] == ["head"]


EYES = """
<mujoco><visual><global offwidth="640" offheight="480"/></visual><worldbody>
  <light pos="0 0 3"/>
  <body name="anna/pelvis" pos="0 0 0.5" euler="0 0 90">
    <geom type="sphere" size="0.15" rgba="1 0 0 1"/>
    <camera name="anna/left_eye" pos="0 0 0.7" xyaxes="1 0 0 0 1 0"/>
    <camera name="anna/right_eye" pos="0 0 0.7"/></body>
  <geom type="sphere" size="0.3" pos="2 0 1.2" rgba="0 1 0 1"/>
  <geom type="sphere" size="0.1" pos="2 -0.6 1.2" rgba="0 0 1 1"/>
</worldbody></mujoco>
"""


def test_eyes_see_what_they_look_at_and_the_picture_from_outside_has_the_person():
    model = mujoco.MjModel.from_xml_string(EYES)
    place = np.array([0.0, 0.0, 1.2])
    eyes = tuple(Eye(side=side, place=place, axes=np.eye(3)) for side in ("left", "right"))
    found = pictures_of(model, "anna", eyes)
    assert list(found) == ["outside", "left_eye", "right_eye"]
    seen = {
        name: cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR).astype(int) for name, data in found.items()
    }
    assert {each.shape for each in seen.values()} == {(480, 640, 3)}
    for name in ("left_eye", "right_eye"):
        blue, green, red = seen[name][240, 320]
        assert green > 2 * max(blue, red, 10)
        rows, columns = np.nonzero(seen[name][:, :, 0] > 2 * seen[name][:, :, 1] + 20)
        assert columns.min() > 360  # to the right
        assert abs(rows.mean() - 240) < 5
    rows, columns = np.nonzero(seen["outside"][:, :, 2] > 2 * seen["outside"][:, :, 1] + 20)
    # The camera looks at a point 0.25 m above, from 2.6 m: 45 degrees are 480 pixels high.
    focal = 240 / math.tan(math.radians(22.5))
    down = math.radians(16.0)
    depth = 2.6 + 0.25 * math.sin(down)
    assert abs(columns.mean() - 320) < 5
    assert rows.mean() - 240 == pytest.approx(focal * 0.25 * math.cos(down) / depth, abs=10)
    assert np.ptp(columns) == pytest.approx(2 * focal * 0.15 / depth, rel=0.1)


def test_where_nobody_sits_there_is_no_study(tmp_path):
    nobody = parse_world("mjsim: 1\nwalls: [{points: [[0, 0], [1, 0]]}]\n")
    for ask in (lambda: studies(nobody), lambda: write_ergonomics(nobody, tmp_path)):
        with pytest.raises(UsageError, match="no person in this world is seated"):
            ask()
    (tmp_path / "anna.json").write_text("kept")
    with pytest.raises(UsageError, match=r"anna\.json"):
        write_ergonomics(parse_world(WORLD), tmp_path)
    assert (tmp_path / "anna.json").read_text() == "kept"
