"""How mechanisms move by closed forms, and by how much the simulation misses them."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.special import ellipk

import mjsim
from mjsim.geometry import Array
from mjsim.mechanics import JointMotion

SECONDS = 1.2

FOURBAR = """
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: coupler, rod: [3.5, 0.05]}, {name: rocker, rod: [3.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0]}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
    actuators: [{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}]
"""
SLIDER = """
    bodies: [{name: crank, rod: [0.5, 0.03]}, {name: rod, rod: [1.5, 0.03]}, {name: slider, box: [0.2, 0.2, 0.2]}]
    joints:
      - {revolute: a, of: [ground, crank], axis: [0, 1, 0]}
      - {revolute: b, of: [crank.end, rod]}
      - {revolute: c, of: [rod.end, slider]}
      - {prismatic: s, of: [ground, slider], axis: [1, 0, 0]}
    actuators: [{angle: a, signal: {ramp: {from_deg: 20, slope_deg: 180}}}]
"""
SCREW = """
    bodies: [{name: nut, cylinder: [0.1, 0.1]}]
    joints: [{screw: s, of: [ground, nut], axis: [0, 0, 1], pitch: 0.02}]
    actuators: [{angle: s.turn, signal: {sine: {amplitude_deg: 720, frequency_hz: 0.5}}}]
"""
HOOKE = """
    bodies: [{name: inp, rod: [0.5, 0.03]}, {name: out, rod: [0.5, 0.03]}]
    joints:
      - {revolute: a, of: [ground, inp], axis: [1, 0, 0]}
      - {universal: u, of: [inp.end, out], near_deg: [0, 30]}
      - {revolute: b, of: [{ground: [0.9330127018922193, 0.25, 0]}, out.end], axis: [0.8660254037844387, 0.5, 0],
         rpy_deg: [0, 0, 30]}
    actuators: [{angle: a, signal: {ramp: {slope_deg: 180}}}]
"""
GEAR = """
    bodies: [{name: one, cylinder: [0.1, 0.1]}, {name: two, cylinder: [0.3, 0.1]}]
    joints: [{revolute: a, of: [ground, one], axis: [0, 0, 1]}, {revolute: b, of: [{ground: [0.4, 0, 0]}, two]}]
    constraints: [{gear: [a, b], ratio: -3}]
    actuators: [{angle: a, signal: {sine: {amplitude_deg: 90, frequency_hz: 0.5}}}]
"""
DISTANCE = """
    bodies: [{name: arm, rod: [1.0, 0.03]}]
    joints: [{revolute: a, of: [ground, arm], axis: [0, 1, 0], near_deg: 30}]
    actuators: [{distance: [{ground: [0, 0, -2]}, arm.end], name: ram,
                 signal: {sine: {amplitude: 0.3, frequency_hz: 0.5, offset: 2.0}}}]
"""
PENDULUM = """
    bodies: [{name: bob, sphere: 0.1, mass: 2, center: [1.2, 0, 0], inertia: [0, 0, 0, 0, 0, 0], at: [1.2, 0, 0]}]
    joints: [{revolute: swing, of: [ground, bob], axis: [0, 1, 0], start_deg: 30}]
"""
BEAD = """
    bodies: [{name: bead, sphere: 0.05, mass: 2}]
    joints: [{in_plane: j, of: [ground, bead], axis: [0, 1, 0]}]
    constraints: [{curve: bead, start: %s, points: %s}]
"""
CAM = """
    bodies: [{name: cam, cylinder: [0.3, 0.05], rpy_deg: [90, 0, 0]}, {name: follower, rod: [0.8, 0.02]}]
    joints:
      - {revolute: a, of: [ground, cam], axis: [0, 1, 0]}
      - {prismatic: s, of: [ground, follower], rpy_deg: [0, -90, 0], axis: [0, 0, 1], near: 0.4}
    constraints: [{curve: follower, on: cam, circle: 0.3, at: [0.1, 0, 0]}]
    actuators: [{angle: a, signal: {ramp: {slope_deg: 180}}}]
"""
HOOP = """
    bodies: [{name: hoop, sphere: 0.1, mass: 1}, {name: bead, sphere: 0.05, mass: 1}]
    joints:
      - {revolute: a, of: [ground, hoop], axis: [0, 0, 1]}
      - {six_dof: b, of: [ground, bead], near: [0.9, 0, -0.5]}
    constraints: [{curve: bead, on: hoop, circle: 1, axis: [0, 1, 0], start: 0.5}]
    actuators: [{angle: a, signal: {ramp: {slope_deg: 180}}}]
"""
TRIM = """
    mode: trim
    bodies: [{name: upper, rod: [1.0, 0.03]}, {name: lower, rod: [0.7, 0.02]}]
    joints: [{revolute: a, of: [ground, upper], axis: [0, 1, 0], start_deg: 30},
             {revolute: b, of: [upper.end, lower], near_deg: 20}]
    actuators: [{torque: a, find: true}]
"""


def moved(text: str, step: int, seconds: float = SECONDS) -> tuple[Array, list[JointMotion]]:
    """Return times, shape (N,) [s], and how the joints of one mechanism move, at a step of the physics [ms]."""
    head = "mjsim: 1\nmechanisms:\n  - name: m\n    elevation: 4\n"
    world = mjsim.parse_world(f"{head}{text}run: {{step_ms: {step}, rate_hz: 25}}\n")
    times, motions = [], []
    with mjsim.Simulation(world) as sim:
        while sim.time < seconds - 1e-9:
            times.append(sim.time)
            motions.append(sim.motions()["m"])
            sim.step()
    return np.array(times), motions


def positions(motions: list[JointMotion]) -> Array:
    """Return positions over time, shape (N, values) [rad, m]."""
    return np.array([motion.positions for motion in motions])


def fourbar(crank: Array) -> tuple[Array, Array]:
    """Return the angles of coupler and rocker against the ground, by two circles, shape (N,) each [rad]."""
    a, b, c, d = 1.0, 3.5, 3.0, 4.0
    tip = a * np.exp(1j * crank)
    between = d - tip
    along = (b**2 - c**2 + np.abs(between) ** 2) / (2 * np.abs(between))
    meeting = tip + between / np.abs(between) * (along + 1j * np.sqrt(b**2 - along**2))
    return np.angle(meeting - tip), np.angle(meeting - d)


def fourbar_error(step: int) -> float:
    """Return the largest error of the four-bar's angles [rad]."""
    times, motions = moved(FOURBAR, step)
    crank = math.radians(28.6) + math.radians(114.6) * times
    coupler, rocker = fourbar(crank)
    expected = np.column_stack([crank, coupler - crank, rocker, rocker - coupler])
    return float(np.abs(np.angle(np.exp(1j * (positions(motions) - expected)))).max())


def slider_error(step: int) -> float:
    """Return the largest error of the slider [m]."""
    times, motions = moved(SLIDER, step)
    crank = np.radians(20 + 180 * times)
    expected = 0.5 * np.cos(crank) + np.sqrt(1.5**2 - (0.5 * np.sin(crank)) ** 2)
    return float(np.abs(positions(motions)[:, 3] - expected).max())


def screw_error(step: int) -> float:
    """Return the largest error of the nut [m]."""
    times, motions = moved(SCREW, step)
    return float(np.abs(positions(motions)[:, 1] - 0.04 * np.sin(np.pi * times)).max())


def hooke_error(step: int) -> float:
    """Return the largest error of the driven shaft [rad]."""
    times, motions = moved(HOOKE, step)
    turned = math.pi * times
    expected = np.unwrap(np.arctan2(np.sin(turned), np.cos(turned) * np.cos(np.pi / 6)))
    return float(np.abs(positions(motions)[:, 3] - expected).max())


def gear_error(step: int) -> float:
    """Return the largest error of the second wheel [rad]."""
    times, motions = moved(GEAR, step)
    return float(np.abs(positions(motions)[:, 1] + np.pi / 6 * np.sin(np.pi * times)).max())


def distance_error(step: int) -> float:
    """Return the largest error of the distance [m]."""
    times, motions = moved(DISTANCE, step)
    apart = np.sqrt(5 - 4 * np.sin(positions(motions)[:, 0]))
    return float(np.abs(apart - 2 - 0.3 * np.sin(np.pi * times)).max())


def lifted(crank: Array) -> Array:
    """Return the potential energy of the four-bar, shape (N,) [J]; a positive angle turns downwards."""
    coupler, rocker = fourbar(crank)
    masses = 1000 * math.pi * 0.05**2 * np.array([1.0, 3.5, 3.0])
    heights = np.array([np.sin(crank) / 2, np.sin(crank) + 1.75 * np.sin(coupler), 1.5 * np.sin(rocker)])
    return np.asarray(-9.81 * masses @ heights)


def kinetic(crank: Array) -> Array:
    """Return the kinetic energy of the four-bar at 2.0 rad/s for angles of its crank, shape (N,) [J]."""
    speed, step = math.radians(114.6), 1e-4
    total = np.zeros_like(crank)
    for length, index in ((1.0, 0), (3.5, 1), (3.0, 2)):

        def center(angle: Array, length: float = length, index: int = index) -> tuple[Array, Array]:
            coupler, rocker = fourbar(angle)
            foot = [0.0, np.exp(1j * angle), 4.0][index]
            turn = (angle, coupler, rocker)[index]
            return foot + length / 2 * np.exp(1j * turn), np.exp(1j * turn)

        (ahead, turned), (behind, before) = center(crank + step), center(crank - step)
        mass = 1000 * math.pi * 0.05**2 * length
        across = mass * (length**2 / 12 + 0.05**2 / 4)
        rate = np.angle(turned / before) * speed / (2 * step)
        total += 0.5 * mass * np.abs((ahead - behind) * speed / (2 * step)) ** 2 + 0.5 * across * rate**2
    return total


def torque_error(step: int) -> float:
    """Return the largest error of the driver's torque by the slope of the energy, of the largest torque [%]."""
    times, motions = moved(FOURBAR, step)
    crank, small = math.radians(28.6) + math.radians(114.6) * times, 1e-4
    ahead, behind = (lifted(angle) + kinetic(angle) for angle in (crank + small, crank - small))
    expected = (ahead - behind) / (2 * small)
    found = np.array([motion.torques[0] for motion in motions])
    return float(100.0 * np.abs(found - expected).max() / np.abs(expected).max())


def period_error(step: int) -> float:
    """Return the error of a pendulum's period by the elliptic integral [%]."""
    times, motions = moved(PENDULUM, step, 5.2)
    angle = positions(motions)[:, 0] - math.pi / 2
    course = CubicSpline(times, angle)
    rows = np.flatnonzero((angle[:-1] < 0) & (angle[1:] >= 0))
    crossings = [brentq(course, times[row], times[row + 1], xtol=1e-13) for row in rows]
    period = 4 * math.sqrt(1.2 / 9.81) * ellipk(math.sin(math.radians(60) / 2) ** 2)
    return float(100.0 * np.abs(np.diff(crossings) / period - 1.0).max())


def cycloid_error(step: int) -> float:
    """Return the largest error of beads that swing on a cycloid of radius 0.5 m from near and from far [m].

    Both swing harmonically along it, with one period: Huygens (1673).
    """
    turns, worst = np.linspace(-0.85 * math.pi, 0.85 * math.pi, 161), 0.0
    points = 0.5 * np.column_stack([turns + np.sin(turns), 0.0 * turns, -1.0 - np.cos(turns)])
    middle = 2.0 * math.sin(0.425 * math.pi)
    for amplitude in (0.3, 1.4):
        times, motions = moved(BEAD % (middle - amplitude, points.tolist()), step)
        expected = middle - amplitude * np.cos(math.sqrt(9.81 / 2.0) * times)
        worst = max(worst, float(np.abs(positions(motions)[:, 2] - expected).max()))
    return worst


def cam_error(step: int) -> float:
    """Return the largest error of a follower on an eccentric circle [m]."""
    times, motions = moved(CAM, step)
    turned = math.pi * times
    lift = -0.1 * np.sin(turned) + np.sqrt(0.3**2 - (0.1 * np.cos(turned)) ** 2)
    return float(np.abs(positions(motions)[:, 1] - lift).max())


def hoop_error(step: int) -> float:
    """Return the largest error of a bead on a hoop that turns about its diameter, by its own equation [m]."""
    times, motions = moved(HOOP, step)

    def change(_: float, state: Array) -> tuple[float, float]:
        angle, speed = state
        return speed, 9.81 * math.cos(angle) - math.pi**2 * math.cos(angle) * math.sin(angle)

    expected = solve_ivp(change, (0.0, times[-1] + 0.1), [0.5, 0.0], rtol=1e-12, atol=1e-13, t_eval=times).y[0]
    return float(np.abs(positions(motions)[:, -1] - expected).max())


def trim_error(step: int) -> float:
    """Return how far a trimmed arm moves from rest [rad]."""
    _, motions = moved(TRIM, step)
    return float(np.abs(positions(motions) - np.radians([30, 60])).max())


@dataclass(frozen=True, slots=True)
class Form:
    """A closed form: what is asked at 1 and 4 ms, and how the error is found."""

    unit: str
    asked: tuple[float, float]
    error: Callable[[int], float]
    has_order: bool = True


FORMS = {
    "four-bar": Form("rad", (5e-6, 7e-5), fourbar_error),
    "slider-crank": Form("m", (1e-5, 2e-4), slider_error),
    "screw": Form("m", (3e-6, 4e-5), screw_error),
    "universal joint": Form("rad", (6e-6, 1e-4), hooke_error),
    "gear": Form("rad", (1e-8, 1e-7), gear_error),
    "distance driver": Form("m", (5e-6, 7e-5), distance_error),
    "torque of the four-bar": Form("%", (0.02, 0.05), torque_error),
    "pendulum period": Form("%", (0.001, math.nan), period_error),
    "beads on a cycloid": Form("m", (math.nan, math.nan), cycloid_error),
    "cam": Form("m", (math.nan, math.nan), cam_error),
    "bead on a turning hoop": Form("m", (math.nan, math.nan), hoop_error),
    "trimming": Form("rad", (1e-9, 1e-9), trim_error, has_order=False),
}
