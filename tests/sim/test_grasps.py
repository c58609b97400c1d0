"""What a hand holds of a mechanism: its values and Jacobians, compared with small steps of the state."""

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn

from mjsim.compile import compile_world
from mjsim.sim.mechanisms.grasps import Along, Rotation, SingleValue, grasp_of, period_of, shorter, yielding
from mjsim.sim.mechanisms.mechanism_state import Places
from mjsim.world import parse_world

BODIES = "bodies: [{name: rod, rod: [1.0, 0.05], mass: 2}, {name: tip, rod: [0.5, 0.05], mass: 1}]"
TEXT = """
mjsim: 1
mechanisms:
  - name: m
    at: [1, 2]
    heading_deg: 30
    elevation: 3
    BODIES
    joints: JOINTS
""".replace("BODIES", BODIES)
BALLS = "[{spherical: knot, of: [ground, rod], start_deg: [20, 50, 10]}, {spherical: wrist, of: [rod.end, tip]}]"
BACKWARDS = "[{spherical: knot, of: [rod, ground], start_deg: [20, 50, 10]}, {revolute: q, of: [rod.end, tip]}]"
HINGES = "[{revolute: p, of: [ground, rod], axis: [0, 1, 0]}, {revolute: q, of: [rod.end, tip], axis: [0, 0, 1]}]"
BEAD = """
mjsim: 1
mechanisms:
  - name: m
    at: [1, 2]
    heading_deg: 30
    elevation: 3
    bodies: [{name: bead, sphere: 0.05, mass: 2}]
    joints: [{in_plane: j, of: [ground, bead], axis: [0, 1, 0]}]
    constraints: [{curve: bead, circle: 0.7, axis: [0, 1, 0]}]
"""


def scene(joints, text=TEXT):
    world = parse_world(text.replace("JOINTS", joints))
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    mujoco.mj_integratePos(model, data.qpos, np.random.default_rng(4).normal(size=model.nv), 0.3)
    mujoco.mj_forward(model, data)
    return model, data, world.mechanisms[0]


def moved(model, data, speeds, seconds):
    """Return another state, after a time at constant speeds."""
    other = mujoco.MjData(model)
    other.qpos[:] = data.qpos
    mujoco.mj_integratePos(model, other.qpos, speeds, seconds)
    mujoco.mj_forward(model, other)
    return other


@pytest.mark.parametrize("joints", [BALLS, BACKWARDS])
def test_the_jacobian_of_a_ball_is_the_angular_velocity_that_brings_it_to_its_goal(joints):
    model, data, mechanism = scene(joints)
    name = next(name for name in mechanism.assembly.names if name.startswith("knot"))
    grasp, columns = grasp_of(model, mechanism, Places(model, mechanism), name)
    assert isinstance(grasp, Rotation)
    assert (grasp.size, len(columns), grasp.period) == (3, 3, 0.0)
    step = 1e-6
    for speeds in np.eye(model.nv):
        ahead = grasp.now(moved(model, data, speeds, step))
        # What is missing to where the joint is a moment later is the motion of that moment.
        missing = grasp.missing(data, ahead, np.zeros(3), 0.0) / step
        np.testing.assert_allclose(missing, grasp.slopes(data) @ speeds, atol=1e-5)
    speeds = np.random.default_rng(5).normal(size=model.nv)
    now, later = grasp.now(data), grasp.now(moved(model, data, speeds, step))
    np.testing.assert_allclose(grasp.rates(now, (later - now) / step), grasp.slopes(data) @ speeds, atol=1e-5)


def test_what_is_missing_of_a_ball_is_what_its_speeds_do_not_bring():
    model, data, mechanism = scene(BALLS)
    grasp, _ = grasp_of(model, mechanism, Places(model, mechanism), mechanism.assembly.names[0])
    assert isinstance(grasp, Rotation)
    goal, speeds = np.array([0.4, -0.3, 0.8]), np.array([0.2, 0.1, -0.4])
    ahead = Turn.from_rotvec(0.5 * speeds) * Turn.from_rotvec(grasp.now(data))
    np.testing.assert_allclose(
        grasp.missing(data, goal, speeds, 0.5), (Turn.from_rotvec(goal) * ahead.inv()).as_rotvec(), atol=1e-9
    )
    np.testing.assert_allclose(grasp.missing(data, grasp.now(data), np.zeros(3), 0.0), 0.0, atol=1e-9)


def test_one_value_of_a_joint_is_its_place_in_the_state():
    model, data, mechanism = scene(HINGES)
    places = Places(model, mechanism)
    grasp, columns = grasp_of(model, mechanism, places, "q")
    assert isinstance(grasp, SingleValue)
    assert columns == (mechanism.assembly.names.index("q"),)
    joint = model.joint("m/q")
    assert grasp.now(data)[0] == data.qpos[joint.qposadr[0]]
    row = np.zeros((1, model.nv))
    row[0, joint.dofadr[0]] = 1.0
    np.testing.assert_array_equal(grasp.slopes(data), row)
    np.testing.assert_allclose(grasp.missing(data, np.array([1.0]), np.array([0.5]), 0.2), 0.9 - grasp.now(data))
    np.testing.assert_array_equal(grasp.rates(np.array([1.0]), np.array([0.3])), [0.3])
    assert period_of(mechanism.assembly, columns[0]) == 2.0 * math.pi


def test_a_difference_goes_the_shorter_way_around():
    np.testing.assert_allclose(
        shorter(np.array([4.0, -4.0, 7.0]), 2 * math.pi),
        np.array([4.0, -4.0, 7.0]) - 2 * math.pi * np.array([1, -1, 1]),
    )
    np.testing.assert_array_equal(shorter(np.array([4.0]), 0.0), [4.0])


def test_an_axis_between_two_bodies_is_held_by_its_angle():
    model, data, _ = scene(HINGES)
    bodies = model.body("m/rod").id, model.body("m/tip").id
    grasp = Rotation(
        model=model, bodies=bodies, before=np.eye(3), after=np.eye(3), sign=1.0, axis=np.array([0.0, 0.0, 1.0])
    )
    angle = float(data.qpos[model.joint("m/q").qposadr[0]])
    assert grasp.now(data)[0] == pytest.approx(angle)
    assert (grasp.size, grasp.period) == (1, 2 * math.pi)
    row = np.zeros((1, model.nv))
    row[0, model.joint("m/q").dofadr[0]] = 1.0
    np.testing.assert_allclose(grasp.slopes(data), row, atol=1e-12)
    assert grasp.missing(data, np.array([angle + 6.0]), np.zeros(1), 0.0)[0] == pytest.approx(6.0 - 2 * math.pi)
    assert grasp.rates(np.array([angle]), np.array([2.0]))[0] == 2.0


def test_what_yields_is_the_inverse_of_the_inertia_where_nothing_holds_it():
    model, data, _ = scene(HINGES)
    slopes = np.eye(model.nv)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    found = yielding(model, data, slopes, np.zeros(0, dtype=int))
    np.testing.assert_allclose(found, np.linalg.inv(M), rtol=1e-6)


def test_a_point_on_a_circle_is_held_by_the_way_around_it():
    model, data, mechanism = scene("", BEAD)
    grasp, _ = grasp_of(model, mechanism, Places(model, mechanism), "curve1")
    assert isinstance(grasp, Along)
    assert grasp.period == pytest.approx(2 * math.pi * 0.7, rel=1e-6)
    step = 1e-6
    for speeds in np.eye(model.nv):
        change = shorter(
            grasp.now(moved(model, data, speeds, step)) - grasp.now(moved(model, data, speeds, -step)), 4.4
        )
        # Beside the circle its nearest point moves by the ratio of both radii.
        place = grasp._inner(data)
        ratio = 0.7 / np.linalg.norm(place)
        np.testing.assert_allclose(change / (2 * step), ratio * grasp.slopes(data) @ speeds, atol=1e-4)
    there = grasp.now(data)
    assert grasp.missing(data, there + 4.0, np.zeros(1), 0.0)[0] == pytest.approx(4.0 - grasp.period)
    assert grasp.missing(data, there + 1.0, np.full(1, 0.5), 0.4)[0] == pytest.approx(0.8)
    assert grasp.rates(there, np.full(1, 0.3))[0] == 0.3
    column = mechanism.assembly.names.index("curve1")
    assert period_of(mechanism.assembly, column) == pytest.approx(grasp.period)
