"""Mechanisms move as closed forms say."""

import math
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.bench.closed_forms import FORMS, fourbar, lifted

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


def moved(text, name, ticks):
    """Return times, and positions of all joints at each tick."""
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        rows = []
        for _ in range(ticks):
            rows.append((sim.time, sim.motions()[name].positions))
            sim.step()
    times, positions = zip(*rows, strict=True)
    return np.array(times), np.array(positions)


QUICK = {"screw", "gear", "distance driver"}
ASKED = [name for name, form in FORMS.items() if not math.isnan(form.asked[0])]


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in QUICK else [pytest.mark.slow]) for n in ASKED])
def test_mechanisms_move_as_closed_forms_say(name):
    form = FORMS[name]
    for step, most in zip((1, 4), form.asked, strict=True):
        assert math.isnan(most) or form.error(step) < most


@pytest.mark.slow
def test_errors_of_a_fourbar_fall_with_the_square_of_the_step():
    error = FORMS["four-bar"].error
    assert math.log2(error(4) / error(2)) > 1.8


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


def test_inverse_dynamics_of_a_slow_fourbar_is_the_slope_of_its_energy():
    text = FOURBAR.replace("at: [3, 2]", "mode: inverse").replace("slope_deg: 114.6", "slope_deg: 0.001") % 4
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        motion = sim.motions()["fourbar"]
    crank, step = math.radians(28.6), 1e-5
    ahead, behind = lifted(crank + step * np.array([1.0, -1.0]))
    slope = (ahead - behind) / (2 * step)
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
