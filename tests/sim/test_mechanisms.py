"""Mechanisms move as closed forms say."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.special import ellipk

import mjsim

FOURBAR = """
mjsim: 1
mechanisms:
  - name: fourbar
    at: [3, 2]
    elevation: 4
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: coupler, rod: [3.5, 0.05]}, {name: rocker, rod: [3.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0], start_deg: 28.6}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
    actuators: [{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}]
    sensors: [{joint: q4}, {reaction: q5}, {actuator: q2}, {body: coupler.end}]
run: {step_ms: %d}
"""
PENDULUM = """
mjsim: 1
mechanisms:
  - name: pendulum
    elevation: 3
    bodies: [{name: bob, sphere: 0.1, mass: 2, center: [1.2, 0, 0], inertia: [0, 0, 0, 0, 0, 0], at: [1.2, 0, 0]}]
    joints: [{revolute: swing, of: [ground, bob], axis: [0, 1, 0], start_deg: 30, speed_deg: %g}]
run: {step_ms: 1, rate_hz: 100}
"""


def moved(text, name, ticks):
    """Return times, and positions of all joints at each tick."""
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        rows = []
        for _ in range(ticks):
            rows.append((sim.time, sim.motions()[name].positions))
            sim.step()
    times, positions = zip(*rows, strict=True)
    return np.array(times), np.array(positions)


def fourbar(crank, *, lengths=(1.0, 3.5, 3.0, 4.0)):
    """Return the angles of coupler and rocker against the ground for those of the crank, by two circles [rad]."""
    a, b, c, d = lengths
    tip = a * np.exp(1j * crank)
    between = d - tip
    along = (b**2 - c**2 + np.abs(between) ** 2) / (2 * np.abs(between))
    meeting = tip + between / np.abs(between) * (along + 1j * np.sqrt(b**2 - along**2))
    return np.angle(meeting - tip), np.angle(meeting - d)


def fourbar_error(step):
    times, q = moved(FOURBAR % step, "fourbar", 30)
    crank = math.radians(28.6) + math.radians(114.6) * times
    coupler, rocker = fourbar(crank)
    expected = np.column_stack([crank, coupler - crank, rocker, rocker - coupler])
    return np.abs(np.angle(np.exp(1j * (q - expected)))).max()


@pytest.mark.slow
@pytest.mark.parametrize(("step", "most"), [(1, 5e-6), (4, 7e-5)])
def test_a_driven_fourbar_moves_as_two_circles_say(step, most):
    assert fourbar_error(step) < most


@pytest.mark.slow
def test_errors_of_a_fourbar_fall_with_the_square_of_the_step():
    assert math.log2(fourbar_error(4) / fourbar_error(2)) > 1.8


@pytest.mark.slow
def test_a_pendulum_swings_with_the_period_of_the_elliptic_integral():
    times, q = moved(PENDULUM % 0, "pendulum", 520)
    angle = q[:, 0] - math.pi / 2  # from straight down
    rising = np.flatnonzero((angle[:-1] < 0) & (angle[1:] >= 0))
    crossings = [brentq(CubicSpline(times, angle), times[row], times[row + 1], xtol=1e-12) for row in rising]
    period = 4 * math.sqrt(1.2 / 9.81) * ellipk(math.sin(math.radians(60) / 2) ** 2)
    assert np.diff(crossings) == pytest.approx(period, rel=1e-5)


def test_speeds_of_the_start_follow_from_the_loop():
    mechanism = mjsim.parse_world(FOURBAR % 4).mechanisms[0]
    speed, step = math.radians(114.6), 1e-6
    crank = math.radians(28.6) + speed * step * np.array([1.0, -1.0])
    rocker = np.diff(fourbar(crank)[1][::-1])[0] / (2 * step)
    np.testing.assert_allclose(mechanism.assembly.speeds[[0, 2]], [speed, rocker], rtol=1e-8)


def values(text, *, step=4, ticks=25):
    """Return the assembly, times, positions and speeds of the one mechanism of a text."""
    world = mjsim.parse_world(f"mjsim: 1\nmechanisms:\n  - name: m\n    elevation: 4\n{text}run: {{step_ms: {step}}}\n")
    with mjsim.Simulation(world) as sim:
        rows = []
        for _ in range(ticks):
            rows.append((sim.time, sim.motions()["m"]))
            sim.step()
    times = np.array([time for time, _ in rows])
    return world.mechanisms[0].assembly, times, [motion for _, motion in rows]


def column(motions, place):
    """Return the positions of one value over time."""
    return np.array([motion.positions[place] for motion in motions])


SLIDER = """
    bodies: [{name: crank, rod: [0.5, 0.03]}, {name: rod, rod: [1.5, 0.03]}, {name: slider, box: [0.2, 0.2, 0.2]}]
    joints:
      - {revolute: a, of: [ground, crank], axis: [0, 1, 0]}
      - {revolute: b, of: [crank.end, rod]}
      - {revolute: c, of: [rod.end, slider]}
      - {prismatic: s, of: [ground, slider], axis: [1, 0, 0]}
    actuators: [{angle: a, signal: {ramp: {from_deg: 20, slope_deg: 120}}}]
"""


@pytest.mark.slow
@pytest.mark.parametrize(("step", "most"), [(1, 1e-5), (4, 2e-4)])
def test_a_slider_crank_slides_as_its_triangle_says(step, most):
    _, times, motions = values(SLIDER, step=step)
    crank = np.radians(20 + 120 * times)
    expected = 0.5 * np.cos(crank) + np.sqrt(1.5**2 - (0.5 * np.sin(crank)) ** 2)
    assert np.abs(column(motions, 3) - expected).max() < most


@pytest.mark.parametrize(("step", "most"), [(1, 3e-6), (4, 4e-5)])
def test_a_screw_slides_by_its_pitch(step, most):
    text = """
    bodies: [{name: nut, cylinder: [0.1, 0.1]}]
    joints: [{screw: s, of: [ground, nut], axis: [0, 0, 1], pitch: 0.02}]
    actuators: [{angle: s.turn, signal: {sine: {amplitude_deg: 720, frequency_hz: 0.5}}}]
"""
    _, times, motions = values(text, step=step)
    assert np.abs(column(motions, 1) - 0.04 * np.sin(np.pi * times)).max() < most


@pytest.mark.parametrize(("step", "most"), [(1, 1e-8), (4, 1e-7)])
def test_a_gear_turns_by_its_ratio(step, most):
    text = """
    bodies: [{name: one, cylinder: [0.1, 0.1]}, {name: two, cylinder: [0.3, 0.1]}]
    joints: [{revolute: a, of: [ground, one], axis: [0, 0, 1]}, {revolute: b, of: [{ground: [0.4, 0, 0]}, two]}]
    constraints: [{gear: [a, b], ratio: -3}]
    actuators: [{angle: a, signal: {sine: {amplitude_deg: 90, frequency_hz: 0.5}}}]
"""
    _, times, motions = values(text, step=step)
    assert np.abs(column(motions, 1) + np.pi / 6 * np.sin(np.pi * times)).max() < most


@pytest.mark.slow
@pytest.mark.parametrize(("step", "most"), [(1, 6e-6), (4, 1e-4)])
def test_a_universal_joint_turns_as_hooke_says(step, most):
    text = """
    bodies: [{name: inp, rod: [0.5, 0.03]}, {name: out, rod: [0.5, 0.03]}]
    joints:
      - {revolute: a, of: [ground, inp], axis: [1, 0, 0]}
      - {universal: u, of: [inp.end, out], near_deg: [0, 30]}
      - {revolute: b, of: [{ground: [0.9330127018922193, 0.25, 0]}, out.end], axis: [0.8660254037844387, 0.5, 0],
         rpy_deg: [0, 0, 30]}
    actuators: [{angle: a, signal: {ramp: {slope_deg: 120}}}]
"""
    _, times, motions = values(text, step=step)
    turned = np.radians(120) * times
    expected = np.unwrap(np.arctan2(np.sin(turned), np.cos(turned) * np.cos(np.pi / 6)))
    assert np.abs(column(motions, 3) - expected).max() < most


@pytest.mark.parametrize(("step", "most"), [(1, 5e-6), (4, 7e-5)])
def test_a_distance_follows_its_motion(step, most):
    text = """
    bodies: [{name: arm, rod: [1.0, 0.03]}]
    joints: [{revolute: a, of: [ground, arm], axis: [0, 1, 0], near_deg: 30}]
    actuators: [{distance: [{ground: [0, 0, -2]}, arm.end], name: ram,
                 signal: {sine: {amplitude: 0.3, frequency_hz: 0.5, offset: 2.0}}}]
"""
    _, times, motions = values(text, step=step)
    apart = np.sqrt(5 - 4 * np.sin(column(motions, 0)))
    assert np.abs(apart - 2 - 0.3 * np.sin(np.pi * times)).max() < most


def lifted(crank):
    """Return the potential energy of the four-bar [J]; a positive angle turns downwards."""
    coupler, rocker = fourbar(crank)
    centers = (np.sin(crank) / 2, np.sin(crank) + 1.75 * np.sin(coupler), 1.5 * np.sin(rocker))
    masses = 1000 * math.pi * 0.05**2 * np.array([1.0, 3.5, 3.0])
    return -9.81 * (masses * centers).sum()


def test_inverse_dynamics_of_a_slow_fourbar_is_the_slope_of_its_energy():
    text = FOURBAR.replace("at: [3, 2]", "mode: inverse").replace("slope_deg: 114.6", "slope_deg: 0.001") % 4
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        motion = sim.motions()["fourbar"]
    crank, step = math.radians(28.6), 1e-5
    slope = (lifted(crank + step) - lifted(crank - step)) / (2 * step)
    assert motion.torques[0] == pytest.approx(slope, rel=1e-7)


@pytest.mark.slow
def test_kinematics_closes_loops_to_rounding():
    text = FOURBAR.replace("at: [3, 2]", "mode: kinematics") % 4
    times, q = moved(text, "fourbar", 10)
    crank = math.radians(28.6) + math.radians(114.6) * times
    coupler, rocker = fourbar(crank)
    expected = np.column_stack([crank, coupler - crank, rocker, rocker - coupler])
    assert np.abs(np.angle(np.exp(1j * (q - expected)))).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(("step", "most"), [(1, 2e-4), (4, 5e-4)])
def test_the_torque_of_a_driven_fourbar_is_that_of_inverse_dynamics(step, most):
    torques = []
    for mode in ("forward", "inverse"):
        text = FOURBAR.replace("at: [3, 2]", f"mode: {mode}") % step
        with mjsim.Simulation(mjsim.parse_world(text)) as sim:
            for _ in range(8):
                sim.step()
            torques.append(sim.motions()["fourbar"].torques[0])
    assert torques[0] == pytest.approx(torques[1], abs=most * 200)  # of the largest torque


def test_a_trimmed_arm_stays_at_rest_under_the_torque_that_was_found():
    text = """
    mode: trim
    bodies: [{name: upper, rod: [1.0, 0.03]}, {name: lower, rod: [0.7, 0.02]}]
    joints: [{revolute: a, of: [ground, upper], axis: [0, 1, 0], start_deg: 30},
             {revolute: b, of: [upper.end, lower], near_deg: 20}]
    actuators: [{torque: a, find: true}]
"""
    assembly, _, motions = values(text)
    upper, lower = 1000 * math.pi * 0.03**2, 1000 * math.pi * 0.02**2 * 0.7
    expected = -9.81 * math.cos(math.radians(30)) * (upper / 2 + lower)
    assert assembly.found[0] == pytest.approx(expected, rel=1e-9)
    assert np.abs(motions[-1].positions - np.radians([30, 60])).max() < 1e-9


def test_what_stands_on_a_weld_presses_with_its_weight():
    text = """
    bodies: [{name: bar, rod: [1.0, 0.03], mass: 2}]
    joints: [{weld: w, of: [ground, bar]}]
    sensors: [{reaction: w}]
"""
    world = mjsim.parse_world(f"mjsim: 1\nmechanisms:\n  - name: m\n    elevation: 4\n{text}")
    with mjsim.Simulation(world) as sim:
        force = sim.readings()["m"].values[:6]
    np.testing.assert_allclose(force, [0, 0, 19.62, 0, -9.81, 0], atol=1e-9)


@pytest.mark.parametrize(
    "name", ["joints", "linkages", "modes", "turnstile", "fourbar", "seesaw", "scissor_lift", "press"]
)
def test_worlds_of_mechanisms_run(name):
    path = Path(mjsim.__file__).parent.parent / "worlds" / "mechanisms" / f"{name}.yaml"
    with mjsim.Simulation(mjsim.load_world(path)) as sim:
        sim.step()
        assert all(np.isfinite(motion.positions).all() for motion in sim.motions().values())
