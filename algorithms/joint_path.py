"""Trajectories of arms: joint motions or straight tool motions, as goals for an arm's controller.

Both are navigators: they keep the base at rest, and give a goal with velocities and accelerations at each tick, which
the simulation extrapolates until the next.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array
from mjsim.interface import ArmInfo, Command, Estimate, JointGoal, Observation, RobotInfo, WorldMap
from mjsim.mechanics import ctraj, placed

Law = Literal["linear", "cubic", "quintic", "trapezoidal"]
PEAKS: Mapping[Law, float] = {"linear": 1.0, "cubic": 1.5, "quintic": 1.875, "trapezoidal": 1.5}
"""Largest speed of each law from rest to rest, as a multiple of the mean."""
BLEND = 1.0 / 3.0
"""Part of the time of a trapezoidal leg for acceleration, and for deceleration."""
FINE = 2
"""Points of a tool's path per tick."""
MISS = 1e-6
"""Maximum deviation of a tool from its path [m, rad]."""

ROUNDING = 1e-9
"""Rounding error of a time [s]."""
Moving = tuple[Array, Array]
"""Values and rates, shape (joints,) each."""


def between(law: Law, s: float) -> tuple[float, float]:
    """Return the normalised position at the normalised time s (0 to 1), and its derivative by s.

    References:
        Craig, Introduction to Robotics (1989), section 7.3; Lynch and Park, Modern Robotics (2017), section 9.2.2.
    """
    if law == "linear":
        return s, 1.0
    if law == "cubic":
        return s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s)
    if law == "quintic":
        return s**3 * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) ** 2
    gain = 1.0 / (BLEND * (1.0 - BLEND))
    if s < BLEND:
        return 0.5 * gain * s * s, gain * s
    if s > 1.0 - BLEND:
        return 1.0 - 0.5 * gain * (1.0 - s) ** 2, gain * (1.0 - s)
    return gain * BLEND * (s - 0.5 * BLEND), gain * BLEND


def passing_speeds(postures: Array, seconds: Array) -> Array:
    """Return rates at which joints pass postures, 0 at both ends, shape (k, joints) like the postures.

    The mean of the speeds before and after, and 0 for a joint that reverses.

    References:
        Craig, Introduction to Robotics (1989), section 7.3.
    """
    speeds = np.diff(postures, axis=0) / seconds[:, None]
    rates = np.zeros_like(postures)
    rates[1:-1] = np.where(speeds[1:] * speeds[:-1] > 0.0, 0.5 * (speeds[1:] + speeds[:-1]), 0.0)
    return rates


def nearest_turn(start: Array, goal: Array, arm: ArmInfo) -> Array:
    """Return the goal shifted by whole turns to be closest to the start, for revolute joints within their limits."""
    revolves = np.array([not link.slide for link in arm.model.links])
    nearer = start + (goal - start + np.pi) % (2.0 * np.pi) - np.pi
    return np.where(revolves & (nearer >= arm.lower) & (nearer <= arm.upper), nearer, goal)


class _ArmPath(ABC):
    """Base class of both kinds of paths: their start, and the goal of a tick."""

    def __init__(self, arm: str, *, wait: float, repeat: bool) -> None:
        if not (math.isfinite(wait) and wait >= 0.0):
            raise ValueError(f"wait is {wait}; it must be 0 or more [s]")
        self._arm, self._wait, self._repeat = arm, wait, repeat

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Store the data sheet of the arm.

        Raises:
            ValueError: The robot has no such arm.
        """
        if self._arm not in robot.arms:
            raise ValueError(f"robot '{robot.name}' has no arm '{self._arm}'; its arms are {', '.join(robot.arms)}")
        self._info, self._dt = robot.arms[self._arm], robot.dt
        self._began: float | None = None

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the goal of this tick; the base stands still."""
        if self._began is None:
            self._began = seen.time + self._wait
            self._seconds, self._at = self._planned(seen.joints[self._arm].positions)
        q, qd = self._motion(seen.time - self._began)
        _, ahead = self._motion(seen.time + self._dt - self._began)
        # The mean acceleration until the next goal, so that the speed is right there too, and does not reverse at the
        # end.
        goal = JointGoal(positions=_floats(q), velocities=_floats(qd), accelerations=_floats((ahead - qd) / self._dt))
        return Command(joints={self._arm: goal})

    def _motion(self, time: float) -> tuple[Array, Array]:
        """Return values and rates at a time since the start of the path [s]."""
        time = max(time, 0.0)
        if self._repeat:
            turns, within = divmod(time, self._seconds)
            q, qd = self._at(within if turns % 2 == 0 else self._seconds - within)
            return q, qd if turns % 2 == 0 else -qd
        q, qd = self._at(min(time, self._seconds))
        return q, qd if time < self._seconds - ROUNDING else 0.0 * qd

    @abstractmethod
    def _planned(self, start: Array) -> tuple[float, Callable[[float], Moving]]:
        """Return the duration of the path [s], and a function of time that gives the motion."""


def _floats(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())


class JointPath(_ArmPath):
    """Moves the joints of an arm to a posture, optionally via others."""

    def __init__(
        self,
        to_deg: Sequence[float],
        *,
        arm: str = "arm",
        via_deg: Sequence[Sequence[float]] = (),
        seconds: float | Sequence[float] | None = None,
        law: Law = "quintic",
        shortest: bool = False,
        wait: float = 0.0,
        repeat: bool = False,
    ) -> None:
        """Set the path.

        Args:
            to_deg: Final posture, one value per joint [deg], [m] for prismatic ones.
            arm: Its name.
            via_deg: Intermediate postures; cubic and quintic paths pass them, the others stop there.
            seconds: Duration, or that of each leg [s]; by default as fast as the arm's speed limits allow.
            law: Motion on a leg: 'linear' at constant speed, 'cubic', 'quintic' or 'trapezoidal'.
            shortest: Whether revolute joints turn the shorter way, if their limits allow it.
            wait: Time to wait first [s].
            repeat: Whether to move back and forth repeatedly.

        Raises:
            ValueError: A value is out of its range.
        """
        super().__init__(arm, wait=wait, repeat=repeat)
        if law not in PEAKS:
            raise ValueError(f"law is '{law}'; it must be {', '.join(PEAKS)}")
        self._postures = [np.array(posture, dtype=float) for posture in (*via_deg, to_deg)]
        legs = None if seconds is None else np.array(seconds, dtype=float)
        if legs is not None and not (np.isfinite(legs).all() and (legs > 0.0).all()):
            raise ValueError(f"seconds is {seconds}; it must be above 0")
        if legs is not None and legs.ndim and legs.shape != (len(self._postures),):
            raise ValueError(f"seconds has {legs.size} legs; the path has {len(self._postures)}")
        self._legs, self._law, self._shortest = legs, law, shortest

    def _planned(self, start: Array) -> tuple[float, Callable[[float], Moving]]:
        postures = self._through(np.asarray(start, dtype=float))
        seconds = self._leg_seconds(postures)
        ends = np.cumsum(seconds)
        smooth = self._law in ("cubic", "quintic")
        rates = passing_speeds(postures, seconds) if smooth else np.zeros_like(postures)

        def at(time: float) -> Moving:
            leg = min(int(np.searchsorted(ends, time, side="right")), len(seconds) - 1)
            s = min(max((time - (ends[leg] - seconds[leg])) / seconds[leg], 0.0), 1.0)
            return self._on_leg(postures[leg : leg + 2], rates[leg : leg + 2], seconds[leg], s)

        return float(ends[-1]), at

    def _on_leg(self, ends: Array, rates: Array, seconds: float, s: float) -> Moving:
        displacement = ends[1] - ends[0]
        done, speed = between(self._law, s)
        q, qd = ends[0] + done * displacement, speed * displacement / seconds
        if not rates.any():
            return q, qd
        # The effect of rates at both ends of a law, for s from 0 to 1.
        (a, da), (b, db) = by_rate(self._law, s)
        return q + seconds * (a * rates[0] + b * rates[1]), qd + da * rates[0] + db * rates[1]

    def _through(self, start: Array) -> Array:
        """Return the start and all postures, shape (legs + 1, joints) [rad, m]."""
        slides = np.array([link.slide for link in self._info.model.links])
        through = [start]
        for posture in self._postures:
            if posture.shape != start.shape:
                raise ValueError(f"a posture has {posture.size} values; arm '{self._arm}' has {start.size} joints")
            goal = np.where(slides, posture, np.radians(posture))
            goal = nearest_turn(through[-1], goal, self._info) if self._shortest else goal
            beyond = (goal < self._info.lower - 1e-9) | (goal > self._info.upper + 1e-9)
            if beyond.any():
                joint = int(np.argmax(beyond))
                raise ValueError(f"{self._info.joints[joint]} cannot go to {posture[joint]:g}; it is out of its range")
            through.append(goal)
        return np.array(through)

    def _leg_seconds(self, postures: Array) -> Array:
        """Return the duration of each leg, shape (legs,) [s]."""
        distances = np.abs(np.diff(postures, axis=0))
        least = np.max(PEAKS[self._law] * distances / self._info.max_velocity, axis=1)
        if self._legs is None:
            if not (least > 0.0).any():
                raise ValueError(f"arm '{self._arm}' has no speed limits; give seconds")
            return np.asarray(np.maximum(least, self._dt))
        if self._legs.ndim:
            seconds = self._legs
        else:
            share = distances.max(axis=1) + 1e-9
            seconds = self._legs * share / share.sum()
        if (seconds < 0.999 * least).any():
            leg = int(np.argmax(least - seconds))
            text = f"leg {leg + 1} of the path takes {seconds[leg]:.3g} s; the joints need {least[leg]:.3g} s for it"
            raise ValueError(text)
        return np.asarray(seconds, dtype=float)


def by_rate(law: Law, s: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the effects of unit rates at start and end on the position at s, with derivatives by s."""
    if law == "cubic":
        return (s * (1.0 - s) ** 2, (1.0 - s) * (1.0 - 3.0 * s)), (s * s * (s - 1.0), s * (3.0 * s - 2.0))
    # The quintic Hermite polynomials, whose second derivatives vanish at both ends.
    first = s + s**3 * (-6.0 + s * (8.0 - 3.0 * s)), 1.0 + s * s * (-18.0 + s * (32.0 - 15.0 * s))
    return first, (s**3 * (-4.0 + s * (7.0 - 3.0 * s)), s * s * (-12.0 + s * (28.0 - 15.0 * s)))


class ToolPath(_ArmPath):
    """Moves the tool of an arm along a straight line to a pose in the robot's frame, by inverse kinematics."""

    def __init__(
        self,
        to: Sequence[float],
        *,
        seconds: float,
        rpy_deg: Sequence[float] | None = None,
        arm: str = "arm",
        wait: float = 0.0,
        repeat: bool = False,
    ) -> None:
        """Set the path.

        Args:
            to: Final position of the tool, [x, y, z] in the robot's frame [m].
            seconds: Duration [s].
            rpy_deg: Final orientation, [roll, pitch, yaw] in the robot's frame, right-handed about fixed axes; by
                default as at the start.
            arm: Its name.
            wait: Time to wait first [s].
            repeat: Whether to move back and forth repeatedly.

        Raises:
            ValueError: A value is out of its range.
        """
        super().__init__(arm, wait=wait, repeat=repeat)
        if not (math.isfinite(seconds) and seconds > 0.0):
            raise ValueError(f"seconds is {seconds}; it must be above 0")
        self._to, self._length = np.array(to, dtype=float), seconds
        self._turn = None if rpy_deg is None else np.radians(np.array(rpy_deg, dtype=float))
        for name, value in (("to", self._to), ("rpy_deg", self._turn)):
            if value is not None and (value.shape != (3,) or not np.isfinite(value).all()):
                raise ValueError(f"{name} is {value.tolist()}; it must be three numbers")

    def _planned(self, start: Array) -> tuple[float, Callable[[float], Moving]]:
        arm = self._info.model
        first = arm.fkine(start)
        last = first.copy()
        if self._turn is not None:
            last = placed(self._to, self._turn)
        last[:3, 3] = self._to
        times = np.linspace(0.0, self._length, max(math.ceil(self._length / self._dt), 2) * FINE + 1)
        joints = self._joints_along(ctraj(first, last, times), start, times)
        rates = np.gradient(joints, times, axis=0, edge_order=2)
        rates[[0, -1]] = 0.0

        def at(time: float) -> Moving:
            q, qd = (np.array([np.interp(time, times, column) for column in rows.T]) for rows in (joints, rates))
            return q, qd

        return self._length, at

    def _joints_along(self, poses: Array, start: Array, times: Array) -> Array:
        """Return the values of the joints at each pose, each found from the one before, shape (k, joints)."""
        arm, found, q = self._info.model, [], start
        mask = (1.0,) * 6 if arm.n >= 6 else (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
        for pose, time in zip(poses, times, strict=True):
            reached = arm.ikine(pose, q, mask=mask)
            jumped = np.abs(reached.q - q).max() > np.pi / 4
            if max(reached.distance, reached.angle) > MISS or jumped:
                why = "the joints would jump there" if jumped else f"it misses by {reached.distance:.3g} m"
                raise ValueError(f"the tool cannot follow its path beyond {time:.3g} s; {why}")
            q = reached.q
            found.append(q)
        return np.array(found)
