"""Postures of a plain tree of joints: contacts, limits, preferences, and what cannot be had."""

import math

import mujoco
import numpy as np
import pytest
from scipy.optimize import least_squares

from mjsim.posture import (
    BACK,
    FEET,
    TOUCH,
    GazeContact,
    LineContact,
    PlaneContact,
    PointContact,
    limits,
    range_preference,
    solve_posture,
)

UPPER, FORE = 0.30, 0.35
TREE = f"""
<mujoco><compiler angle="degree"/><worldbody>
  <body name="trunk">
    <joint name="along" type="slide" axis="1 0 0" range="-0.1 0.1" limited="true"/>
    <joint name="lean" axis="0 1 0" range="-40 60" limited="true"/>
    <geom size="0.01" mass="1"/>
    <site name="hip"/><site name="back" pos="-0.1 0 0.4"/><site name="buttock" pos="-0.1 0 0"/>
    <body name="head" pos="0 0 0.6">
      <joint name="nod" axis="0 1 0" range="-50 60" limited="true"/>
      <joint name="look" axis="0 0 1" range="-70 70" limited="true"/>
      <geom size="0.01" mass="1"/><site name="eyes" pos="0.1 0 0.1"/>
    </body>
    <body name="upper" pos="0 -0.2 0.5">
      <joint name="flexion" axis="0 -1 0" range="-60 180" limited="true"/>
      <joint name="abduction" axis="-1 0 0" range="-40 120" limited="true"/>
      <joint name="rotation" axis="0 0 1" range="-60 90" limited="true"/>
      <geom size="0.01" mass="1"/>
      <body name="fore" pos="0 0 -{UPPER}">
        <joint name="elbow" axis="0 -1 0" range="0 140" limited="true"/>
        <geom size="0.01" mass="1"/><site name="hand" pos="0 0 -{FORE}"/>
      </body>
    </body>
  </body>
</worldbody></mujoco>
"""
SHOULDER = np.array([0.0, -0.2, 0.5])
LEANT = math.radians(20.0)


@pytest.fixture(scope="module")
def tree():
    return mujoco.MjModel.from_xml_string(TREE)


def backrest():
    normal = np.array([math.cos(LEANT), 0.0, math.sin(LEANT)])
    return PlaneContact(name="back", site="back", base="buttock", normal=normal, rank=BACK)


def hand(*at):
    return PointContact(name="hand", site="hand", target=np.array(at))


def gaze(*at):
    sight = np.array([math.cos(math.radians(15.0)), 0.0, -math.sin(math.radians(15.0))])
    return GazeContact(name="gaze", site="eyes", target=np.array(at), sight=sight)


def brought(model, values):
    data = mujoco.MjData(model)
    data.qpos[:] = values
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return model, data


def place(model, values, site):
    return brought(model, values)[1].site_xpos[model.site(site).id]


def test_jacobians_of_contacts_match_central_differences(tree):
    values, step = np.random.default_rng(0).uniform(*limits(tree)), 1e-6
    line = LineContact(name="line", site="hand", point=SHOULDER, direction=np.array([0.6, 0.0, 0.8]))
    for contact in (backrest(), hand(0.3, -0.2, 0.3), gaze(2.0, 0.5, 0.3), line):
        slopes = [
            (contact.error(brought(tree, values + offset)) - contact.error(brought(tree, values - offset))) / (2 * step)
            for offset in np.eye(tree.nv) * step
        ]
        np.testing.assert_allclose(contact.jacobian(brought(tree, values)), np.transpose(slopes), atol=1e-7)


def test_contacts_hold_within_the_limits_of_joints(tree):
    found = solve_posture(tree, [backrest(), hand(0.35, -0.2, 0.35), gaze(2, 0, 0.4)], range_preference(tree, {}))
    lower, upper = limits(tree)
    assert found.holds
    assert max(found.errors.values()) < 1e-5
    assert np.all((found.values >= lower) & (found.values <= upper))
    np.testing.assert_allclose(place(tree, found.values, "hand"), [0.35, -0.2, 0.35], atol=1e-5)


@pytest.mark.slow
def test_a_posture_is_that_of_another_solver(tree):
    contacts = [backrest(), hand(0.35, -0.1, 0.35), gaze(2, 0.3, 0.4)]
    preference = range_preference(tree, {"elbow": math.radians(80), "flexion": math.radians(30)})

    def strained(values):
        state = brought(tree, values)
        return np.concatenate(
            [preference.weights * (values - preference.values), *(2e3 * contact.error(state) for contact in contacts)]
        )

    lower, upper = limits(tree)
    other = least_squares(strained, np.clip(preference.values, lower + 1e-6, upper - 1e-6), bounds=(lower, upper))
    found = solve_posture(tree, contacts, preference)
    # Both have the same cost to lower; the last degree is a matter of when they stop.
    np.testing.assert_allclose(np.degrees(found.values), np.degrees(other.x), atol=1.0)


def test_without_contacts_the_preferred_posture_is_kept(tree):
    found = solve_posture(tree, [], range_preference(tree, {"elbow": 1.0, "lean": 9.0}))
    assert found.values[tree.joint("elbow").id] == pytest.approx(1.0)
    assert found.values[tree.joint("lean").id] == pytest.approx(math.radians(60.0))


def test_out_of_reach_is_said_with_the_distance(tree):
    # Against the backrest the shoulder is where the slide and the lean leave it, and the arm is straight.
    target = np.array([1.5, -0.2, 0.5])
    found = solve_posture(
        tree, [backrest(), PointContact(name="hand", site="hand", target=target)], range_preference(tree, {})
    )
    shoulder = np.array([0.1 - 0.5 * math.sin(LEANT), -0.2, 0.5 * math.cos(LEANT)])
    assert found.missed == ("hand",)
    assert found.errors["back"] < TOUCH
    # The nearest that it can come, and what the preference holds back: no more than a millimetre.
    assert found.errors["hand"] == pytest.approx(np.linalg.norm(target - shoulder) - UPPER - FORE, abs=1e-3)


def test_what_cannot_be_had_leaves_what_ranks_before_it_in_place(tree):
    near = PointContact(name="hip", site="hip", target=np.array([0.05, 0.0, 0.0]), rank=FEET)
    found = solve_posture(tree, [hand(5.0, 0.0, 0.0), near], range_preference(tree, {}))
    assert found.missed == ("hand",)
    assert found.errors["hip"] < TOUCH
