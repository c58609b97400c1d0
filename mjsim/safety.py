"""What keeps a robot whole: the reaction to a bump, always on, and the built-in obstacle avoidance."""

import math
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array
from mjsim.interface import Command, Observation, RobotInfo, WheelCommand

NOTHING = 1e6
"""Where a ray that hit nothing is put [m]: finite, so that arithmetic on it stays quiet."""
GRAZING = 0.05
"""Cosine beyond which a contact counts as in the way; a robot may slide along what it touches at 87 degrees."""


def react_to_bump(command: Command | WheelCommand, bump: tuple[float, ...]) -> Command | WheelCommand:
    """Return the command without the motion that would press into what is touched; turning stays."""
    if not bump:
        return command
    if isinstance(command, WheelCommand):
        # All wheels of a differential drive at their mean speed drive straight; the rest only turns.
        mean = sum(command.speeds) / len(command.speeds)
        if not _in_the_way(mean, 0.0, bump):
            return command
        return replace(command, speeds=tuple(speed - mean for speed in command.speeds))
    if not _in_the_way(command.forward, command.left, bump):
        return command
    return replace(command, forward=0.0, left=0.0)


def _in_the_way(forward: float, left: float, bump: tuple[float, ...]) -> bool:
    speed = math.hypot(forward, left)
    return any(forward * math.cos(b) + left * math.sin(b) > GRAZING * speed for b in bump)


class RingAvoidance:
    """Keep clear of obstacles with the ring of proximity rays, changing the command as little as can be.

    The 16 rays leave gaps, so the points that they hit are remembered for some seconds and carried along by
    odometry. Among arcs with turn rates around the commanded one, the one is taken that keeps most of the speed,
    then most of the turn; speed is bounded so that the robot can stop before the nearest point on its arc. With no
    way ahead it turns on the spot, one way until there is one, so that it leaves dead ends.

    References:
        Fox, Burgard, Thrun, The Dynamic Window Approach to Collision Avoidance, IEEE RAM 4(1), 1997: arcs, and
        speeds that allow a stop. Remembered points: ours.
    """

    MARGIN = 0.12
    """Kept between the rim and anything [m]."""
    HORIZON = 1.6
    """How far ahead an arc is looked at [s]."""
    MEMORY = 96
    """Ticks for which hits are remembered."""

    def start(self, robot: RobotInfo, rng: Generator) -> None:
        """Forget what was seen; make the arcs to choose from."""
        self._reach = robot.radius + self.MARGIN
        self._radius = robot.radius
        self._deceleration = 0.5 * robot.max_acceleration
        self._max_turn = robot.max_turn
        self._rng = rng
        self._spin = 0.0
        self._points = np.full((self.MEMORY, 16, 2), NOTHING)
        self._row = 0
        angles = np.arange(16) * (2.0 * np.pi / 16)
        self._rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        self._times = np.linspace(0.1, self.HORIZON, 12)
        self._offsets = np.linspace(-1.0, 1.0, 21) * min(robot.max_turn, 1.2)

    def adjust(self, command: Command, seen: Observation) -> Command:
        """Return the command that is safe, as near as can be to the one given."""
        self._remember(seen)
        if abs(command.forward) < 1e-9:
            self._spin = 0.0
            return command
        points = self._near(abs(command.forward))
        if not len(points):
            self._spin = 0.0
            return command
        direction = math.copysign(1.0, command.forward)
        turns = np.clip(command.turn + self._offsets, -self._max_turn, self._max_turn)
        free = self._free_distance(points, abs(command.forward), turns * direction, direction)
        speeds = np.minimum(abs(command.forward), np.sqrt(2.0 * self._deceleration * free))
        if self._spin and speeds[len(turns) // 2] < 0.5 * abs(command.forward):
            return replace(command, forward=0.0, turn=self._spin)
        best = int(np.argmax(speeds - 0.15 * np.abs(turns - command.turn)))
        if speeds[best] < 0.1 * abs(command.forward):
            self._spin = self._choose_spin(points, direction)
            return replace(command, forward=0.0, turn=self._spin)
        self._spin = 0.0
        return replace(command, forward=direction * float(speeds[best]), turn=float(turns[best]))

    def _remember(self, seen: Observation) -> None:
        """Carry the remembered hits into the robot's frame of now, and add those of this tick."""
        moved, turn = np.array([seen.odometry.forward, seen.odometry.left]), seen.odometry.turn
        c, s = math.cos(turn), math.sin(turn)
        self._points -= moved
        self._points[:] = self._points @ np.array([[c, -s], [s, c]])
        distances = np.minimum(seen.proximity + self._radius, NOTHING)
        np.multiply(self._rays, distances[:, None], out=self._points[self._row])
        self._row = (self._row + 1) % self.MEMORY

    def _near(self, speed: float) -> Array:
        """Return the remembered points that an arc could come near to, shape (n, 2) [m]."""
        points = self._points.reshape(-1, 2)
        squared = np.einsum("ij,ij->i", points, points)
        near: Array = points[squared < (speed * self.HORIZON + self._reach) ** 2]
        return near

    def _free_distance(self, points: Array, speed: float, turns: Array, direction: float) -> Array:
        """Return how far the robot can drive along each arc before its margin meets a point, shape (k,) [m]."""
        angles = np.outer(turns, self._times)
        # Chord of an arc: length v t sinc(w t / 2), at half the angle turned.
        chords = speed * self._times * np.sinc(angles / (2.0 * np.pi))
        x, y = direction * chords * np.cos(angles / 2.0), direction * chords * np.sin(angles / 2.0)
        squared = (x[..., None] - points[:, 0]) ** 2 + (y[..., None] - points[:, 1]) ** 2
        # A point inside the margin already only counts while the arc comes nearer to it.
        limit = np.minimum(self._reach**2, np.einsum("ij,ij->i", points, points) * 0.999)
        blocked = (squared < limit).any(axis=-1)
        first = np.where(blocked.any(axis=1), blocked.argmax(axis=1), len(self._times))
        return np.where(first == 0, 0.0, speed * self._times[np.maximum(first, 1) - 1])

    def _choose_spin(self, points: Array, direction: float) -> float:
        """Return the turn rate towards the emptier side; by chance when both are alike [rad/s]."""
        nearness = 1.0 / np.maximum(np.hypot(points[:, 0], points[:, 1]), 0.05)
        balance = float(np.sum(np.sign(points[:, 1]) * nearness * (points[:, 0] * direction > 0.0)))
        side = -math.copysign(1.0, balance) if abs(balance) > 1.0 else float(self._rng.choice((-1.0, 1.0)))
        return side * min(self._max_turn, 1.0)
