"""What torques put into mechanisms is in their motion, at the second order of the step."""

import math

import pytest

import mjsim
from mjsim.errors import PhysicsFault

WHEEL = """
mjsim: 1
mechanisms:
  - name: m
    elevation: 2
    bodies: [{name: wheel, sphere: 0.1, mass: 5, inertia: [2, 2, 2, 0, 0, 0]}]
    joints: [{revolute: a, of: [ground, wheel], axis: [0, 0, 1], damping: %s, speed_deg: %s}]
    actuators: [{torque: a, signal: {pulse: {amplitude: %s, at: 0.1, width: 0.06}}}]
run: {step_ms: %d}
"""
FOURBAR = """
mjsim: 1
mechanisms:
  - name: m
    elevation: 4
    bodies: [{name: crank, rod: [0.3, 0.02]}, {name: coupler, rod: [0.9, 0.02]}, {name: rocker, rod: [0.7, 0.02]}]
    joints:
      - {revolute: a, of: [ground, crank], axis: [0, 1, 0], start_deg: 20, speed_deg: %d}
      - {revolute: b, of: [crank.end, coupler], near_deg: -60}
      - {revolute: c, of: [{ground: [0.8, 0, 0]}, rocker], near_deg: -70}
      - {revolute: d, of: [coupler.end, rocker.end]}
run: {step_ms: %d}
"""


def moved(text, seconds):
    """Return the speed of the first joint at the end, and by how much energies and work miss each other, by tick."""
    missed = []
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        while sim.time < seconds - 1e-9:
            sim.step()
            kinetic, height, springs, work, lost = sim.readings()["m"].values[-5:].tolist()
            missed.append(kinetic + height + springs + lost - work)
        return float(sim.motions()["m"].velocities[0]), [each - missed[0] for each in missed]


@pytest.mark.parametrize("step", [1, 4])
def test_a_pulse_of_torque_gives_its_impulse_and_its_work(step):
    speed, missed = moved(WHEEL % (0, 0, 10, step), 0.4)
    assert speed == pytest.approx(10 * 0.06 / 2, rel=1e-9)
    assert max(map(abs, missed)) < 7e-6 * step**2


@pytest.mark.parametrize(("step", "most"), [(2, 6e-6), (4, 2.4e-5)])
def test_a_damped_wheel_slows_down_as_its_exponential_says(step, most):
    speed, _ = moved(WHEEL % (3, 114.59155902616465, 0, step), 0.4)
    assert speed == pytest.approx(2 * math.exp(-3 / 2 * 0.4), rel=most)


def test_a_fourbar_that_is_spun_keeps_its_energy():
    # It turns by up to 8 degrees within one step.
    _, missed = moved(FOURBAR % (1200, 2), 0.5)
    assert max(map(abs, missed)) < 0.02 * 53.6


def test_a_fourbar_that_turns_too_far_within_a_step_is_refused():
    with pytest.raises(PhysicsFault, match=r"'m' turns by \d+ degrees in one step .* reduce run: step_ms"):
        moved(FOURBAR % (2400, 4), 0.5)
