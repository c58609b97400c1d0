"""A pole on a cart is that of the textbook, whatever drives it; a four-bar passes on an angle as its loop does."""

import re
from functools import partial
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.lab import ScenePlant, experiment, lqr_design, module_text

G = 9.81


@pytest.mark.slow
def test_what_the_page_says_to_write_into_the_world_holds_the_pole_upright():
    world = mjsim.load_world("lab-6-cart")
    found = experiment(world, world.plants[0], designers=[partial(lqr_design, weights=[1.0] * 4, effort=1.0)])
    written = module_text(world.plants[0], found.study.plant, found.designs[0])
    text = (Path(mjsim.__file__).parents[1] / "worlds/lab/lab-6-cart.yaml").read_text(encoding="utf-8")
    lines = "".join(f"    {line}\n" for line in written.splitlines())
    moved = mjsim.parse_world(text.replace("    elevation: 2\n", f"    elevation: 2\n{lines}"))
    with mjsim.Simulation(moved) as sim:
        while sim.time < 5.0:
            sim.step()
        place, angle = sim.motions()["cart"].positions
    assert angle == pytest.approx(-np.pi / 2, abs=0.02)
    assert abs(place) < 0.3


def test_a_plant_with_a_point_on_a_curve_is_refused_with_what_to_use():
    text = """mjsim: 1
mechanisms:
  - name: m
    bodies: [{name: bead, sphere: 0.1}]
    joints: [{in_plane: j, of: [ground, bead], axis: [0, 1, 0]}]
    constraints: [{curve: bead, circle: 1}]
plants: [{name: p, of: m, input: j.x, outputs: [j.x]}]
"""
    world = mjsim.parse_world(text)
    with pytest.raises(UsageError, match=r"'curve1'.*put a revolute joint"):
        ScenePlant(world, world.plants[0])


def test_a_cart_pole_is_that_of_the_textbook():
    world = mjsim.load_world("lab-6-cart")
    upright, hanging = (ScenePlant(world, plant) for plant in world.plants)
    body = upright.model.body("cart/pole")
    cart, m, half = 1.0, float(body.mass[0]), 0.5
    inertia = float(np.median(body.inertia))  # across a thin rod
    det = (cart + m) * (inertia + m * half**2) - (m * half) ** 2
    falls = m * G * half * (cart + m) / det
    back = (m * half) ** 2 * G / det
    A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, -back, 0, 0], [0, falls, 0, 0]]
    B = [[0], [0], [(inertia + m * half**2) / det], [-m * half / det]]
    found = upright.linear
    assert found.states == ("x", "q", "x.rate", "q.rate")
    np.testing.assert_allclose(found.A, A, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(found.B, B, rtol=1e-7)
    poles = np.linalg.eigvals(hanging.linear.A)
    assert np.abs(poles.real).max() < 1e-5
    np.testing.assert_allclose(np.abs(poles.imag).max() ** 2, falls, rtol=1e-7)


DRIVEN = """
mjsim: 1
mechanisms:
  - name: cart
    elevation: 2
    bodies: [{name: trolley, box: [0.3, 0.2, 0.1], mass: 1}, {name: pole, mass: 0.2, rod: [1.0, 0.03]}]
    joints:
      - {prismatic: x, of: [ground, trolley], axis: [1, 0, 0]}
      - {revolute: q, of: [trolley, pole], axis: [0, 1, 0], start_deg: 90, damping: 0.05}
    actuators: [{force: trolley, name: push, axis: [1, 0, 0], signal: {constant: {value: 1}}}]
  - name: fourbar
    at: [3, 2]
    elevation: 4
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: coupler, rod: [3.5, 0.05]}, {name: rocker, rod: [3.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0], start_deg: 28.6}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
    actuators: [{angle: q2, name: motor, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}]
run: {step_ms: 1}
plants: [{name: plant, KEYS}]
"""


def driven(keys: str) -> ScenePlant:
    world = mjsim.parse_world(DRIVEN.replace("KEYS", keys))
    return ScenePlant(world, world.plants[0])


@pytest.mark.slow
def test_a_force_on_a_body_is_that_on_its_joint():
    by_body, by_joint = (driven(f"of: cart, input: {name}, outputs: [x, q]").linear for name in ("push", "x.force"))
    np.testing.assert_allclose(by_body.A, by_joint.A, atol=1e-8)
    np.testing.assert_allclose(by_body.B, by_joint.B, atol=1e-8)


@pytest.mark.parametrize(("motion", "power"), [("x.position", 2), ("x.velocity", 1)])
def test_a_cart_that_is_led_moves_its_pole_as_the_textbook_has_it(motion, power):
    lab = driven(f"of: cart, input: {motion}, outputs: q")
    body, plant = lab.model.body("cart/pole"), lab.linear
    m, half, damping = float(body.mass[0]), 0.5, 0.05
    inertia = float(np.median(body.inertia)) + m * half**2
    s = np.array([0.3j, 2 + 1j, 40j])
    found = [(plant.C @ np.linalg.solve(at * np.eye(2) - plant.A, plant.B) + plant.D).item() for at in s]
    # Hanging at 90 degrees about y: a cart that speeds up along x turns the pole by + m l / I.
    expected = m * half * s**power / (inertia * s**2 + damping * s + m * G * half)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("crank_deg", [28.6, 60.0, -50.0])
def test_a_four_bar_passes_on_an_angle_as_its_loop_does(crank_deg):
    lab = driven(f"of: fourbar, input: motor, outputs: q4, around: {{q2_deg: {crank_deg}}}")
    crank, coupler, rocker = (lab.model.body(f"fourbar/{name}").id for name in ("crank", "coupler", "rocker"))
    data = mujoco.MjData(lab.model)
    data.qpos[:] = lab.setting.qpos
    mujoco.mj_kinematics(lab.model, data)
    ways = [data.xmat[body].reshape(3, 3)[:, 0] for body in (crank, coupler, rocker)]
    a, b, c = (np.arctan2(-way[2], way[0]) for way in ways)
    assert a == pytest.approx(np.radians(crank_deg), abs=1e-9)
    # The loop is closed, to 3 micrometres as it was put together: crank and coupler lead to the end of the rocker.
    ends = 1.0 * np.exp(1j * a) + 3.5 * np.exp(1j * b), 4.0 + 3.0 * np.exp(1j * c)
    assert abs(ends[0] - ends[1]) < 1e-5
    # Norton, Design of Machinery (2012), equation 6.18.
    ratio = 1.0 * np.sin(a - b) / (3.0 * np.sin(c - b))
    assert lab.linear.A.shape == (0, 0)
    np.testing.assert_allclose(lab.linear.D, [[ratio]], rtol=1e-6)
    # Of large worlds MuJoCo keeps the constraints sparse.
    dense = lab._reduced.basis(lab.setting)
    lab.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    np.testing.assert_allclose(lab._reduced.basis(lab.setting), dense, atol=1e-9)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("of: cart, input: x.position, outputs: [q.rate]", "a rate among the outputs is unbounded"),
        ("of: cart, input: x.angle, outputs: [q]", "no input 'x.angle' of cart"),
        ("of: cart, input: pull, outputs: [q]", "no input 'pull' of cart"),
    ],
)
def test_an_input_that_cannot_be_is_one_line(keys, message):
    with pytest.raises(UsageError, match=re.escape(message)):
        driven(keys)


def test_the_force_of_a_distance_moves_an_arm_by_its_lever():
    world = mjsim.parse_world(
        """
mjsim: 1
mechanisms:
  - name: m
    elevation: 4
    bodies: [{name: arm, rod: [1.0, 0.03]}]
    joints: [{revolute: a, of: [ground, arm], axis: [0, 1, 0], near_deg: 30}]
    actuators: [{distance: [{ground: [0, 0, -2]}, arm.end], name: ram, signal: {constant: {value: 1.7}}}]
plants: [{name: p, of: m, input: ram.force, outputs: [a, ram]}]
"""
    )
    scene = ScenePlant(world, world.plants[0])
    angle = float(scene.setting.qpos[0])
    mass = 1000 * np.pi * 0.03**2
    inertia = mass * (1 / 3 + 0.03**2 / 4)
    # d^2 = 5 - 4 sin(a), so that the distance changes by -2 cos(a) / d.
    lever = -2 * np.cos(angle) / 1.7
    assert 5 - 4 * np.sin(angle) == pytest.approx(1.7**2)
    assert scene.setting.value == pytest.approx(-mass * 9.81 / 2 * np.cos(angle) / lever, rel=1e-6)
    np.testing.assert_allclose(scene.linear.B[-1], lever / inertia, rtol=1e-6)
    np.testing.assert_allclose(scene.outputs(scene.setting.qpos, np.zeros(1)), [angle, 1.7], rtol=1e-9)
