"""Figures on seats: contacts hold within joint limits, as another solver has it, and what is out of reach is said."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.optimize import least_squares

from mjsim.people import SEXES, Figure, Measures
from mjsim.posture import Goals, Seating, Sitter, Workstation, columns_of, comfort_of, limits, posture_angles
from mjsim.world import load_checked, parse_world, placed_targets

HIP = (0.0, 0.0, 0.30)
TRAVEL = (0.24, 0.06)
"""Of the seat of a car [m]."""
GOALS = Goals(
    hands={"left": ("fist", np.array([0.40, 0.18, 0.66])), "right": ("fist", np.array([0.40, -0.18, 0.66]))},
    feet={"left": np.array([0.87, 0.15, 0.15]), "right": np.array([0.87, -0.12, 0.16])},
    gaze=np.array([12.0, 0.0, 0.7]),
)
HOLDS = 1e-4
"""A contact is nearer than this [m, rad]."""
AGREES = 5.0
"""Two solvers [deg]."""


def sitter(sex="male", percentile=50.0, back_deg=23.0, travel=TRAVEL):
    pose = np.eye(4)
    pose[:3, 3] = HIP
    figure = Figure.of(Measures.at_percentile(sex, percentile))
    back = None if back_deg is None else math.radians(back_deg)
    return Sitter(figure, Seating(world_from_seat=pose, back=back, travel=travel))


@pytest.fixture(scope="module")
def driver():
    place = sitter()
    return place, place.sit(GOALS)


def test_a_sitting_figure_is_where_its_own_kinematics_put_it(driver):
    place, found = driver
    spots = place.figure.spots(place.figure.poses(found.values, found.world_from_pelvis))
    for side in ("left", "right"):
        np.testing.assert_allclose(spots[f"{side}_grip"], GOALS.hands[side][1], atol=HOLDS)
        np.testing.assert_allclose(spots[f"{side}_ball"], GOALS.feet[side], atol=HOLDS)


def test_the_hip_point_stays_within_the_travel_of_the_seat(driver):
    _, found = driver
    along, up = found.set_by
    np.testing.assert_allclose(found.world_from_pelvis[:3, 3], [along, 0.0, HIP[2] + up], atol=1e-9)
    assert abs(along) <= TRAVEL[0] / 2 + 1e-9
    assert abs(up) <= TRAVEL[1] / 2 + 1e-9


@pytest.mark.parametrize("percentile", [5.0, 95.0])
@pytest.mark.parametrize("sex", SEXES)
def test_contacts_of_small_and_tall_hold_within_joint_limits(sex, percentile):
    place = sitter(sex, percentile)
    found = place.sit(GOALS)
    assert not found.missed
    assert max(found.errors.values()) < HOLDS
    lower, upper = place.figure.limits.T
    assert np.all((found.values >= lower - 1e-9) & (found.values <= upper + 1e-9))


def test_the_trunk_leans_as_the_backrest_and_the_angles_are_those_of_the_joints(driver):
    place, found = driver
    angles = posture_angles(place.figure, place.figure.poses(found.values, found.world_from_pelvis))
    values = dict(zip(place.figure.joints, np.degrees(found.values), strict=True))
    assert angles["trunk"] == pytest.approx(23.0, abs=4.0)  # hips and shoulders lie deeper in the body than the back
    assert angles["left_knee"] == pytest.approx(180.0 - values["left_knee_flexion"], abs=1e-6)
    assert angles["left_elbow"] == pytest.approx(180.0 - values["left_elbow_flexion"], abs=1e-6)


def test_published_ranges_name_their_sources():
    for angle in ("trunk", "left_knee", "right_elbow"):
        assert all(each.source and each.low < each.high for each in comfort_of(angle))
    assert comfort_of("left_wrist") == ()


@pytest.mark.slow
def test_a_sitting_posture_is_that_of_another_solver():
    place = sitter("female", 5.0)
    model, data, contacts = place.model, mujoco.MjData(place.model), list(place.contacts(GOALS))
    weights, wanted = place.preference.weights, place.preference.values

    def brought(values):
        data.qpos[:] = values
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        return model, data

    def cost(values):
        state = brought(values)
        return np.concatenate([weights * (values - wanted), *(2e3 * each.error(state) for each in contacts)])

    def slope(values):
        state = brought(values)
        return np.vstack([np.diag(weights), *(2e3 * each.jacobian(state) for each in contacts)])

    lower, upper = limits(model)
    begin = np.clip(wanted, lower + 1e-6, upper - 1e-6)
    other = least_squares(cost, begin, slope, bounds=(lower, upper), xtol=1e-8, ftol=1e-8, gtol=1e-8)
    found = place.sit(GOALS).solution
    angles = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    assert np.abs(np.degrees(found.values - other.x))[angles].max() < AGREES


@pytest.mark.slow
def test_a_target_too_far_is_out_of_reach_by_its_distance_and_the_rest_holds(driver):
    place, _ = driver
    near, far = GOALS.hands["left"], GOALS.hands["right"][1] + [1.2, 0.0, 0.0]
    found = place.sit(replace(GOALS, hands={"left": near, "right": ("fist", far)}))
    assert found.missed == ("right hand",)
    spots = place.figure.spots(place.figure.poses(found.values, found.world_from_pelvis))
    assert found.errors["right hand"] == pytest.approx(np.linalg.norm(spots["right_grip"] - far), abs=1e-9)
    assert found.errors["right hand"] > 0.7
    assert max(error for name, error in found.errors.items() if name != "right hand") < HOLDS


def test_feet_without_pedals_stand_flat_on_the_floor():
    pose = np.eye(4)
    pose[:3, 3] = (0.0, 0.0, 0.52)
    place = Sitter(Figure.of(Measures.at_percentile("male", 50.0)), Seating(world_from_seat=pose))
    found = place.sit(Goals())
    spots = place.figure.spots(place.figure.poses(found.values, found.world_from_pelvis))
    for name in ("left_heel", "left_ball", "right_heel", "right_ball"):
        assert spots[name][2] == pytest.approx(0.0, abs=HOLDS)


@pytest.mark.slow
def test_a_high_stool_leaves_the_feet_above_the_floor():
    pose = np.eye(4)
    pose[:3, 3] = (0.0, 0.0, 1.3)
    place = Sitter(Figure.of(Measures.at_percentile("female", 5.0)), Seating(world_from_seat=pose))
    found = place.sit(Goals())
    assert set(found.missed) == {
        f"{side} {spot} on the floor" for side in ("left", "right") for spot in ("heel", "ball")
    }


def test_feet_rest_on_the_platform_that_the_seat_stands_on():
    text = """mjsim: 1
obstacles:
  - {name: podium, box: [3, 2, 0.4], at: [4, 0]}
  - {name: chair, box: [0.4, 0.5, 0.4], at: [4, 0], elevation: 0.4, seat: {at: [0, 0, 0.49], back_deg: 10}}
  - {name: shelf, box: [0.5, 1, 0.05], at: [4.5, 0], elevation: 1.2}
people: [{name: anna, sex: female, seat: chair}]
"""
    for more, floor in ((text, 0.4), (text.replace("box: [3, 2, 0.4]", "ramp: [3, 2, 0.4]"), 0.0)):
        world = parse_world(more)
        assert Workstation.of(world, world.people[0]).goals.floor == floor


@pytest.mark.slow
def test_plans_show_who_sits_as_the_posture_is_and_who_stands_as_he_or_she_stands():
    world = load_checked("driving_seat")
    (driver,) = world.people
    found = columns_of(world, driver)
    outline, low, high = found["left_hand"]
    grip = next(each for each in placed_targets(world) if each.name == "car.wheel_left").world_from_target[:3, 3]
    assert low < grip[2] < high
    beside = np.maximum(outline.min(axis=0) - grip[:2], grip[:2] - outline.max(axis=0))
    assert beside.max() < 0.02  # a fist holds beside its bones
    assert columns_of(world, driver) is found
    (anna,) = parse_world("mjsim: 1\npeople: [{name: anna, sex: female, at: [1, 2]}]\n").people
    assert columns_of(world, anna) is anna.prisms
