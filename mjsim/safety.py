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
ROUND = 1.1
"""A body whose outline reaches no further than so many times its nearest side is treated as round."""


def react_to_bump(
    command: Command | WheelCommand, bump: tuple[float, ...], robot: RobotInfo | None = None
) -> Command | WheelCommand:
    """Return the command without the motion that would press into what is touched.

    Turning stays, as it presses nowhere, but for robots that are not round: one that would swing a side or its tail
    into what is touched stops turning too.

    Args:
        command: Of the navigator, or of the avoidance.
        bump: Bearings of contacts now [rad].
        robot: Whose command it is; a round one with two driven wheels unless given.
    """
    if not bump:
        return command
    if isinstance(command, WheelCommand):
        return _react_with_wheels(command, bump, robot)
    forward, left, turn = command.forward, command.left, command.turn
    if _in_the_way(forward, left, bump):
        forward, left = 0.0, 0.0
    if robot is not None and turn and _swings_into(turn, bump, robot):
        turn = 0.0
    if (forward, left, turn) == (command.forward, command.left, command.turn):
        return command
    return replace(command, forward=forward, left=left, turn=turn)


def _react_with_wheels(command: WheelCommand, bump: tuple[float, ...], robot: RobotInfo | None) -> WheelCommand:
    """Return the speeds without their part that would press into what is touched."""
    if robot is None or robot.twist_from_wheels is None:
        # All wheels of a differential drive at their mean speed drive straight; the rest only turns.
        mean = sum(command.speeds) / len(command.speeds)
        if not _in_the_way(mean, 0.0, bump):
            return command
        return replace(command, speeds=tuple(speed - mean for speed in command.speeds))
    speeds, twists = np.asarray(command.speeds, dtype=float), robot.twist_from_wheels
    forward, left, turn = (twists @ speeds).tolist()
    safe = react_to_bump(Command(forward, left, turn), bump, robot)
    assert isinstance(safe, Command)
    if (safe.forward, safe.left, safe.turn) == (forward, left, turn):
        return command
    lost = np.array([forward - safe.forward, left - safe.left, turn - safe.turn])
    kept = speeds - np.asarray(np.linalg.pinv(twists), dtype=float) @ lost
    return replace(command, speeds=tuple(kept.tolist()))


def _in_the_way(forward: float, left: float, bump: tuple[float, ...]) -> bool:
    speed = math.hypot(forward, left)
    return any(forward * math.cos(b) + left * math.sin(b) > GRAZING * speed for b in bump)


def _swings_into(turn: float, bump: tuple[float, ...], robot: RobotInfo) -> bool:
    """Say whether turning moves a side of a robot that is not round towards what it touches."""
    if robot.outline is None or is_round(robot.outline):
        return False
    start = robot.outline
    edge = np.roll(start, -1, axis=0) - start
    for bearing in bump:
        along = np.array([math.cos(bearing), math.sin(bearing)])
        # The side that the bearing leaves through: its corners lie to the right and to the left of the bearing.
        cross = start[:, 0] * along[1] - start[:, 1] * along[0]
        leaves = int(np.argmax((cross >= 0.0) & (np.roll(cross, -1) < 0.0)))
        point = along * rim(robot.outline, bearing)
        # Outward normal of a side of a counter-clockwise outline, and the point's motion.
        normal = np.array([edge[leaves, 1], -edge[leaves, 0]]) / np.hypot(*edge[leaves])
        motion = turn * np.array([-point[1], point[0]])
        if motion @ normal > GRAZING * np.hypot(*motion):
            return True
    return False


def is_round(outline: Array) -> bool:
    """Say whether an outline around the origin, shape (n, 2), is about a circle."""
    reach = np.hypot(outline[:, 0], outline[:, 1])
    return bool(reach.max() < ROUND * reach.min()) and len(outline) > 8


def rim(outline: Array, bearing: float) -> float:
    """Return how far an outline, shape (n, 2), reaches from the origin along a bearing [m]."""
    start = outline
    edge = np.roll(start, -1, axis=0) - start
    along = np.array([math.cos(bearing), math.sin(bearing)])
    across = along[0] * edge[:, 1] - along[1] * edge[:, 0]
    safe = np.where(across == 0.0, np.inf, across)
    distance = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / safe
    share = (start[:, 0] * along[1] - start[:, 1] * along[0]) / safe
    met = (across != 0.0) & (share >= -1e-9) & (share <= 1 + 1e-9) & (distance >= 0.0)
    return float(np.where(met, distance, 0.0).max())


class RingAvoidance:
    """Keep clear of obstacles with the ring of proximity rays, changing the command as little as can be.

    The 16 rays leave gaps, so the points that they hit are remembered for some seconds and carried along by
    odometry. Among arcs with turn rates around the commanded one, as far as the robot can steer, the one is taken
    that keeps most of the speed, then most of the turn; speed is bounded so that the robot can stop before the nearest
    point on its arc. With no way ahead, a robot that can turns on the spot, one way until there is one, so that it
    leaves dead ends; one that cannot, or that has no room for it, backs off in the arc that has the most. A robot told
    to go sideways goes straight in the free direction nearest to the one it is told, within 81 degrees of it, and keeps
    its turn rate; with none free it rests.

    References:
        Fox, Burgard, Thrun, The Dynamic Window Approach to Collision Avoidance, IEEE RAM 4(1), 1997: arcs, and
        speeds that allow a stop. Remembered points, and the ways out: ours.
    """

    MARGIN = 0.12
    """Kept between the rim and anything [m]."""
    HORIZON = 1.6
    """How far ahead an arc is looked at [s]."""
    MEMORY = 96
    """Ticks for which hits are remembered."""
    BACKING = 1.5
    """For how long it backs off before it looks ahead again [s]."""

    def start(self, robot: RobotInfo, rng: Generator) -> None:
        """Forget what was seen; make the arcs to choose from."""
        self._reach = robot.radius + self.MARGIN
        self._deceleration = 0.5 * robot.max_acceleration
        self._max_turn, self._sharpest = robot.max_turn, robot.max_curvature
        self._rng = rng
        self._spin, self._back, self._dt = 0.0, 0, robot.dt
        self._points = np.full((self.MEMORY, 16, 2), NOTHING)
        self._row = 0
        angles = np.arange(16) * (2.0 * np.pi / 16)
        self._rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        outline = robot.outline
        self._box: tuple[Array, Array] | None = None
        self._rims = np.full(16, robot.radius)
        if outline is not None and not is_round(outline):
            self._rims = np.array([rim(outline, angle) for angle in angles.tolist()])
            low, high = outline.min(axis=0), outline.max(axis=0)
            self._box = (low + high) / 2, (high - low) / 2
        self._times = np.linspace(0.1, self.HORIZON, 12)
        self._offsets = np.linspace(-1.0, 1.0, 21) * min(robot.max_turn, 1.2)

    def adjust(self, command: Command, seen: Observation) -> Command:
        """Return the command that is safe, as near as can be to the one given."""
        self._remember(seen)
        if command.left:
            return self._sidestep(command)
        if abs(command.forward) < 1e-9:
            self._spin, self._back = 0.0, 0
            return command if not command.turn or self._can_spin(command.turn) else replace(command, turn=0.0)
        points = self._near(abs(command.forward))
        if not len(points):
            self._spin, self._back = 0.0, 0
            return command
        direction = math.copysign(1.0, command.forward)
        if self._back > 0:
            return self._back_off(command, points, direction)
        turns = self._turns(command.turn, abs(command.forward))
        free = self._free_distance(points, abs(command.forward), turns * direction, direction)
        speeds = np.minimum(abs(command.forward), np.sqrt(2.0 * self._deceleration * free))
        if self._spin and speeds[len(turns) // 2] < 0.5 * abs(command.forward) and self._can_spin(self._spin):
            return replace(command, forward=0.0, turn=self._spin)
        best = int(np.argmax(speeds - 0.15 * np.abs(turns - command.turn)))
        if speeds[best] < 0.1 * abs(command.forward):
            return self._leave(command, points, direction)
        self._spin = 0.0
        chosen, speed = float(turns[best]), float(speeds[best])
        # A robot that cannot turn on the spot turns less while it is slower.
        chosen = min(max(chosen, -self._sharpest * speed), self._sharpest * speed)
        return replace(command, forward=direction * speed, turn=chosen)

    def _turns(self, wanted: float, speed: float) -> Array:
        """Return the turn rates to choose from at a speed [rad/s], the wanted one in the middle."""
        most = min(self._max_turn, self._sharpest * speed)
        return np.clip(wanted + self._offsets, -most, most)

    def _leave(self, command: Command, points: Array, direction: float) -> Command:
        """Return the way out where there is no way on: turn on the spot, or back off."""
        if math.isinf(self._sharpest):
            spin = self._choose_spin(points, direction)
            for turn in (spin, -spin):
                if self._can_spin(turn):
                    self._spin = turn
                    return replace(command, forward=0.0, turn=turn)
        self._back = round(self.BACKING / self._dt)
        return self._back_off(command, points, direction)

    def _back_off(self, command: Command, points: Array, direction: float) -> Command:
        """Return the arc backward that has the most room, its nose swung toward the emptier side."""
        self._back -= 1
        speed = 0.6 * abs(command.forward)
        if not self._spin:
            self._spin = self._choose_spin(points, direction)
        most = min(self._max_turn, self._sharpest * speed)
        turns = math.copysign(most, self._spin) * np.array([1.0, 0.5, 0.0, -0.5, -1.0])
        free = self._free_distance(points, speed, -turns * direction, -direction)
        best = int(np.argmax(np.minimum(free, 0.6 * speed * self.HORIZON) - 1e-3 * np.arange(5)))
        slow = min(speed, math.sqrt(2.0 * self._deceleration * float(free[best])))
        if slow < 0.1 * speed:
            self._back, self._spin = 0, 0.0
        if self._back == 0:
            self._spin = 0.0
        return replace(command, forward=-direction * slow, turn=float(turns[best]) * slow / speed)

    def _sidestep(self, command: Command) -> Command:
        """Return the free direction nearest to the one commanded, for robots that go in any; rest with none."""
        speed = math.hypot(command.forward, command.left)
        points = self._near(speed)
        self._spin, self._back = 0.0, 0
        if not len(points):
            return command
        wanted = math.atan2(command.left, command.forward)
        bearings = wanted + np.linspace(-1.0, 1.0, 25) * 0.45 * np.pi
        free = np.array([float(self._straight(points, speed, bearing)) for bearing in bearings.tolist()])
        speeds = np.minimum(speed, np.sqrt(2.0 * self._deceleration * free))
        best = int(np.argmax(speeds * (1.0 - 0.3 * np.abs(bearings - wanted))))
        ahead, left = math.cos(float(bearings[best])), math.sin(float(bearings[best]))
        turn = command.turn if not command.turn or self._can_spin(command.turn) else 0.0
        return replace(command, forward=float(speeds[best]) * ahead, left=float(speeds[best]) * left, turn=turn)

    def _remember(self, seen: Observation) -> None:
        """Carry the remembered hits into the robot's frame of now, and add those of this tick."""
        moved, turn = np.array([seen.odometry.forward, seen.odometry.left]), seen.odometry.turn
        c, s = math.cos(turn), math.sin(turn)
        self._points -= moved
        self._points[:] = self._points @ np.array([[c, -s], [s, c]])
        distances = np.minimum(seen.proximity + self._rims, NOTHING)
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
        return self._until_blocked(points, x, y, direction * angles) * speed

    def _straight(self, points: Array, speed: float, bearing: float) -> float:
        """Return how far the robot can go straight along a bearing without turning [m]."""
        x, y = speed * self._times[None] * math.cos(bearing), speed * self._times[None] * math.sin(bearing)
        return float(self._until_blocked(points, x, y, np.zeros_like(x))[0]) * speed

    def _can_spin(self, turn: float) -> bool:
        """Say whether the robot can turn on the spot by 40 degrees, or as far as it comes in the time looked ahead."""
        if self._box is None:
            return True
        points, still = self._near(0.0), np.zeros((1, 12))
        angles = math.copysign(1.0, turn) * np.linspace(0.06, 0.7, 12)[None]
        return not len(points) or bool(self._until_blocked(points, still, still, angles)[0] >= self._times[4])

    def _until_blocked(self, points: Array, x: Array, y: Array, headings: Array) -> Array:
        """Return until when motions keep the margin from all points.

        Args:
            points: In the robot's frame of now, shape (n, 2) [m].
            x: Where the robot is at each of the times looked at, along its x axis of now, shape (k, 12) [m].
            y: The same along its y axis.
            headings: Which way it then looks [rad].

        Returns:
            Time of the last place before the first blocked one, 0 when that is the first, shape (k,) [s].
        """
        dx, dy = points[:, 0] - x[..., None], points[:, 1] - y[..., None]
        if self._box is None:
            # A point inside the margin already only counts while the robot comes nearer to it.
            limit = np.minimum(self._reach**2, np.einsum("ij,ij->i", points, points) * 0.999)
            blocked = (dx**2 + dy**2 < limit).any(axis=-1)
        else:
            (middle_x, middle_y), (half_x, half_y) = self._box
            c, s = np.cos(headings)[..., None], np.sin(headings)[..., None]
            along, aside = np.abs(c * dx + s * dy - middle_x) - half_x, np.abs(c * dy - s * dx - middle_y) - half_y
            now = np.maximum(np.abs(points[:, 0] - middle_x) - half_x, np.abs(points[:, 1] - middle_y) - half_y)
            limit = np.where(now > 0.0, np.minimum(self.MARGIN, now - 0.002), -NOTHING)
            blocked = (np.maximum(along, aside) < limit).any(axis=-1)
        first = np.where(blocked.any(axis=1), blocked.argmax(axis=1), len(self._times))
        return np.where(first == 0, 0.0, self._times[np.maximum(first, 1) - 1])

    def _choose_spin(self, points: Array, direction: float) -> float:
        """Return the turn rate towards the emptier side; by chance when both are alike [rad/s]."""
        nearness = 1.0 / np.maximum(np.hypot(points[:, 0], points[:, 1]), 0.05)
        balance = float(np.sum(np.sign(points[:, 1]) * nearness * (points[:, 0] * direction > 0.0)))
        side = -math.copysign(1.0, balance) if abs(balance) > 1.0 else float(self._rng.choice((-1.0, 1.0)))
        return side * min(self._max_turn, 1.0)
