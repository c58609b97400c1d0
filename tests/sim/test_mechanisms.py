"""Mechanisms move as closed forms say."""

import math

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


@pytest.mark.parametrize(("step", "most"), [(1, 5e-6), (4, 7e-5)])
def test_a_driven_fourbar_moves_as_two_circles_say(step, most):
    assert fourbar_error(step) < most


def test_errors_of_a_fourbar_fall_with_the_square_of_the_step():
    assert math.log2(fourbar_error(4) / fourbar_error(2)) > 1.8


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
