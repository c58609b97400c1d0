"""Points on curves move as closed forms say."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.bench.closed_forms import CAM, FORMS
from mjsim.errors import PhysicsFault

HEAD = "mjsim: 1\nmechanisms:\n  - name: m\n    elevation: 3\n"
BEAD = """
    bodies: [{name: bead, sphere: 0.05, mass: 2}]
    joints: [{in_plane: j, of: [ground, bead], axis: [0, 1, 0]}]
    constraints: [{curve: bead, %s}]
    sensors: [{joint: curve1}, {reaction: curve1}]
"""
HELIX = """
    bodies: [{name: bead, sphere: 0.05, mass: 1}]
    joints: [{six_dof: b, of: [ground, bead]}]
    constraints: [{curve: bead, points: %s, start: 0.1}]
"""


def moved(text, *, step, seconds):
    """Return times, positions and accelerations of the joints, and the sensors' numbers, one row a tick."""
    rows = []
    with mjsim.Simulation(mjsim.parse_world(f"{HEAD}{text}run: {{step_ms: {step}}}\n")) as sim:
        while sim.time < seconds - 1e-9:
            motion = sim.motions()["m"]
            rows.append((sim.time, motion.positions, motion.accelerations, sim.readings()["m"].values))
            sim.step()
    return tuple(np.array(column) for column in zip(*rows, strict=True))


@pytest.mark.slow
def test_beads_on_a_cycloid_swing_in_the_same_time_from_near_and_far():
    error = FORMS["beads on a cycloid"].error
    coarse, fine = error(4), error(2)
    assert fine < 1e-5
    assert math.log2(coarse / fine) > 1.8


def test_a_bead_on_a_circle_is_pressed_as_a_pendulum_is():
    _, positions, _, numbers = moved(BEAD % "circle: 1.2, start: 0.3", step=4, seconds=0.4)
    fallen = 1.2 * (np.sin(positions[:, 2] / 1.2) - math.sin(0.25))
    # m v^2 / r + m g sin, towards the centre
    pressed = 2 * 9.81 * (2 * fallen / 1.2 + np.sin(positions[:, 2] / 1.2))
    np.testing.assert_allclose(np.linalg.norm(numbers[:, 4:7], axis=1), pressed, rtol=2e-4)


@pytest.mark.slow
def test_a_follower_rises_as_an_eccentric_cam_has_it():
    assert FORMS["cam"].error(4) < 1e-6


@pytest.mark.slow
def test_a_bead_slides_down_a_helix_with_a_steady_acceleration():
    turns = np.linspace(0, 14, 141)
    points = np.column_stack([0.5 * np.cos(turns), 0.5 * np.sin(turns), -0.1 * turns]).tolist()
    times, positions, accelerations, _ = moved(HELIX % points, step=4, seconds=0.6)
    steady = 9.81 * 0.1 / math.hypot(0.5, 0.1)
    np.testing.assert_allclose(positions[:, 6], 0.1 + steady * times**2 / 2, atol=3e-5)
    np.testing.assert_allclose(accelerations[:, 6], steady, rtol=2e-3)


def test_a_simulation_of_a_loop_or_a_curve_begins_again_byte_for_byte():
    with mjsim.Simulation(mjsim.parse_world(f"{HEAD}{CAM}run: {{step_ms: 4}}\n")) as sim:
        first = []
        for _ in range(5):
            sim.step()
            first.append(sim.data.qpos.copy())
        sim.reset()
        for before in first:
            sim.step()
            assert sim.data.qpos.tobytes() == before.tobytes()


LOCKING = """
    mode: %s
    bodies: [{name: crank, rod: [1.5, 0.05]}, {name: coupler, rod: [1.0, 0.05]}, {name: rocker, rod: [1.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0]}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [1, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
    actuators: [{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 400}}}]
"""


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["forward", "kinematics"])
def test_a_loop_that_locks_is_named_with_the_motion_that_it_does_not_allow(mode):
    with pytest.raises(PhysicsFault, match=r"at 0.2\d? s|at 0.19 s") as caught:
        moved(LOCKING % mode, step=4, seconds=1.0)
    assert "mechanism 'm' locks: with 'q2' at 1" in str(caught.value)
    assert "its loop at 'q5' does not close" in str(caught.value)
