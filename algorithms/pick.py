"""A task for a mobile manipulator: it drives to a box by its own map, recognises the picture on it, and lifts it.

It knows the picture, the sizes of picture and box, and places to search. It measures the pose of the box.
"""

import math
from collections import deque
from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Command, Estimate, JointGoal, Observation, RobotInfo, Sighting, WorldMap
from mjsim.mechanics import placed

from .joint_path import between

RECENT = 1.5
"""Maximum age of a sighting of the box [s]."""
AWAY, CLOSE = 0.95, 0.72
"""Distances in front of the box to which it drives, one after the other [m]."""
REACH, BEFORE = 0.36, 0.13
"""Distance of the box from the arm's base when the arm reaches for it, and distance of the straight approach [m]."""
SLOW, TURN = 0.08, 0.7
"""Speed and turn rate near the box [m/s], [rad/s]."""
AIMED = 0.01
"""Tolerances of heading and position in front of the box [rad, m]."""
FINGERS = 2
"""Number of finger joints at the end of the arm; they close towards their lower limits."""


class PickUp:
    """Searches for a box by the picture on it, drives in front of it, grips it from the front, and lifts it.

    The base is controlled with the robot's estimated pose. The picture's four corners from the observer give the pose
    of the box's face (`cv2.solvePnP`); of the two solutions for a plane, the upright one is used. The arm moves through
    poses found by inverse kinematics; the fingers close with a given force.

    References:
        Collins and Bartoli, Infinitesimal Plane-Based Pose Estimation, Int. J. of Computer Vision 109, 2014, for the
        pose of a plane; Siciliano et al., Robotics (2009), section 3.7, for inverse kinematics along a path.
    """

    def __init__(
        self,
        picture: str,
        *,
        box: Sequence[float],
        width: float,
        search: Sequence[Sequence[float]] = (),
        camera: str = "front",
        arm: str = "arm",
        force: float = 8.0,
        lift: float = 0.12,
        speed: float = 0.35,
    ) -> None:
        """Set the task.

        Args:
            picture: Name of the beacon on the front of the box, at the centre of that side.
            box: Depth behind the picture, width and height of the box [m].
            width: Width of the picture, which is square [m].
            search: Places to search, [x, y] each, in the frame of the estimate [m]; the robot turns around at each.
            camera: The camera of the observer.
            arm: Its name; the last two joints are its fingers.
            force: Force of each finger [N].
            lift: Height by which the box is lifted [m].
            speed: Speed of driving [m/s].

        Raises:
            ValueError: A size is not above 0.
        """
        self._depth, self._wide, self._high = (float(size) for size in box)
        for name, value in (("box", min(box)), ("width", width), ("force", force), ("lift", lift), ("speed", speed)):
            if not value > 0.0:
                raise ValueError(f"{name} is {value}; it must be above 0")
        self._picture, self._width, self._search = picture, width, [np.array(place, dtype=float) for place in search]
        self._camera, self._arm, self._force, self._lift, self._speed = camera, arm, force, lift, speed

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Read the robot's data sheet.

        Raises:
            ValueError: It has no such camera, or no such arm with fingers.
        """
        sensor = robot.sensors.get(self._camera)
        if sensor is None or sensor.intrinsics is None:
            raise ValueError(f"robot '{robot.name}' has no camera '{self._camera}'")
        if self._arm not in robot.arms or len(robot.arms[self._arm].joints) <= FINGERS:
            raise ValueError(f"robot '{robot.name}' has no arm '{self._arm}' with two fingers")
        self._robot_from_camera, self._intrinsics = sensor.robot_from_sensor, sensor.intrinsics.matrix()
        self._info, self._dt = robot.arms[self._arm], robot.dt
        self._model = self._info.model
        self._foot = self._model.base[:3, 3]
        self._box_poses: deque[tuple[float, Array]] = deque()
        self._steps = self._script()

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the command of this tick; once the box is lifted, it is held."""
        self._pose, self._joints = belief.pose, np.array(seen.joints[self._arm].positions)
        self._update_box(seen)
        return next(self._steps)

    def _script(self) -> Iterator[Command]:
        """Yield the commands of the whole task, one per tick; observations are in the attributes."""
        self._still = self._goal = self._joints.copy()
        yield from self._find()
        for distance in (AWAY, CLOSE):
            yield from self._place_before(distance)
        yield from self._creep()
        at, azimuth = self._box_in_robot()
        yield from self._grasp(at, azimuth)
        for _ in range(round(1.5 / self._dt)):
            yield self._moving(forward=-SLOW)
        while True:
            yield self._moving()

    def _update_box(self, seen: Observation) -> None:
        """Store the pose of the box if the picture was seen at this tick: x, y, z and heading of its face, (4,)."""
        for sighting in seen.sightings:
            if sighting.name == self._picture and sighting.corners is not None:
                at, outward = self._face(sighting)
                middle = at - 0.5 * self._depth * outward
                x, y = self._pose.transform(middle[None, :2])[0]
                heading = math.atan2(outward[1], outward[0]) + self._pose.heading
                self._box_poses.append((seen.time, np.array([x, y, middle[2], heading])))
        while self._box_poses and self._box_poses[0][0] < seen.time - RECENT and len(self._box_poses) > 1:
            self._box_poses.popleft()

    def _face(self, sighting: Sighting) -> tuple[Array, Array]:
        """Return the centre of the picture [m] and the direction that it faces, robot frame, shape (3,) each."""
        half = 0.5 * self._width
        corners = np.array([[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]])
        _, turns, places, _ = cv2.solvePnPGeneric(
            corners, np.asarray(sighting.corners, dtype=float), self._intrinsics, None, flags=cv2.SOLVEPNP_IPPE
        )
        axes = self._robot_from_camera[:3, :3]
        found = []
        for turn, place in zip(turns, places, strict=True):
            outward = -axes @ cv2.Rodrigues(turn)[0][:, 2]
            found.append((abs(outward[2]), axes @ place[:, 0] + self._robot_from_camera[:3, 3], outward))
        _, at, outward = min(found, key=lambda each: each[0])
        return at, outward * [1.0, 1.0, 0.0] / np.hypot(*outward[:2])

    def _box(self) -> tuple[Array, float]:
        """Return the centre of the box, shape (3,) [m], and the direction of its face [rad], frame of the estimate."""
        rows = np.array([row for _, row in self._box_poses])
        middle = np.median(rows[:, :3], axis=0)
        heading = math.atan2(np.sin(rows[:, 3]).sum(), np.cos(rows[:, 3]).sum())
        return middle, heading

    def _box_in_robot(self) -> tuple[Array, float]:
        """Return the centre of the box in the robot's frame, shape (3,) [m], and its azimuth from the arm [rad]."""
        middle, _ = self._box()
        x, y = self._pose.inverse().transform(middle[None, :2])[0]
        return np.array([x, y, middle[2]]), math.atan2(y - self._foot[1], x - self._foot[0])

    def _find(self) -> Iterator[Command]:
        """Turn around here, then at each place to search, until the picture is seen."""
        for place in [None, *self._search]:
            if place is not None:
                yield from self._drive_to(place, until_seen=True)
            turned = 0.0
            while turned < 2.0 * math.pi and not self._box_poses:
                turned += TURN * self._dt
                yield self._moving(turn=TURN)
        while not self._box_poses:
            yield self._moving(turn=TURN)

    def _place_before(self, distance: float) -> Iterator[Command]:
        """Drive to a point at a distance in front of the box, and face it."""
        middle, facing = self._box()
        place = middle[:2] + distance * np.array([math.cos(facing), math.sin(facing)])
        if np.hypot(*(place - self._xy())) > 0.06:
            yield from self._drive_to(place)
        yield from self._turn_to(middle[:2])
        for _ in range(round(RECENT / self._dt)):  # only sightings from here count
            yield self._moving()
        yield from self._turn_to(self._box()[0][:2])

    def _xy(self) -> Array:
        return np.array([self._pose.x, self._pose.y])

    def _bearing(self, place: Array) -> float:
        x, y = place - self._xy()
        return wrap_angle(math.atan2(y, x) - self._pose.heading)

    def _drive_to(self, place: Array, *, until_seen: bool = False) -> Iterator[Command]:
        """Drive to a place in the frame of the estimate, backwards if that is shorter and the distance small."""
        while (left := float(np.hypot(*(place - self._xy())))) > 0.03 and not (until_seen and self._box_poses):
            bearing = self._bearing(place)
            back = left < 0.3 and abs(bearing) > 0.5 * math.pi
            error = wrap_angle(bearing + math.pi) if back else bearing
            speed = min(self._speed, 0.8 * left + 0.02) * max(math.cos(error), 0.0) ** 4
            yield self._moving(forward=-speed if back else speed, turn=min(max(1.8 * error, -TURN), TURN))

    def _turn_to(self, place: Array) -> Iterator[Command]:
        while abs(error := self._bearing(place)) > AIMED:
            yield self._moving(turn=min(max(1.5 * error, -TURN), TURN) + math.copysign(0.01, error))

    def _creep(self) -> Iterator[Command]:
        """Drive forward until the box is within reach, steering by its sightings; then wait for a good one."""
        while (left := self._box_in_robot()[0][0] - self._foot[0] - REACH) > AIMED:
            bearing = self._bearing(self._box()[0][:2])
            yield self._moving(forward=min(SLOW, 0.5 * left + 0.01), turn=min(max(bearing, -0.2), 0.2))
        for _ in range(round(1.5 * RECENT / self._dt)):
            yield self._moving()

    def _moving(self, *, forward: float = 0.0, turn: float = 0.0) -> Command:
        """Return a command to the base, with the arm held at its goal."""
        return Command(forward=forward, turn=turn, joints={self._arm: self._arm_goal(np.zeros_like(self._goal))})

    def _arm_goal(self, rates: Array) -> JointGoal:
        torques = np.zeros_like(self._goal)
        torques[-FINGERS:] = -self._grip
        return JointGoal(
            positions=tuple(self._goal.tolist()), velocities=tuple(rates.tolist()), torques=tuple(torques.tolist())
        )

    _grip = 0.0

    def _grasp(self, at: Array, azimuth: float) -> Iterator[Command]:
        """Move the hand in front of the box, around it, close the fingers, and lift."""
        ahead = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        wide = self._info.upper[-FINGERS:]
        self._fingers = wide
        yield from self._arm_to(self._reached(at - BEFORE * ahead, azimuth, self._still), seconds=3.0)
        yield from self._along(at - BEFORE * ahead, at, azimuth, seconds=2.5)
        self._grip, self._fingers = self._force, np.full(FINGERS, 0.5 * self._wide)
        yield from self._arm_to(np.concatenate([self._goal[:-FINGERS], self._fingers]), seconds=1.0)
        yield from self._along(at, at + np.array([0.0, 0.0, self._lift]), azimuth, seconds=2.0)

    def _reached(self, at: Array, azimuth: float, q0: Array) -> Array:
        """Return joint values that bring the tool to a place, level and pointing forward.

        Raises:
            ValueError: It is out of reach.
        """
        found = self._model.ikine(placed(at, (0.0, 0.0, azimuth)), q0)
        if found.distance > 1e-3 or found.angle > 1e-2:
            raise ValueError(f"the box at {np.round(at, 3).tolist()} m is out of the arm's reach")
        return np.concatenate([found.q[:-FINGERS], self._fingers])

    def _arm_to(self, q: Array, *, seconds: float) -> Iterator[Command]:
        """Move the joints to values, all at once."""
        start, count = self._goal.copy(), round(seconds / self._dt)
        for number in range(1, count + 1):
            share, rate = between("quintic", number / count)
            self._goal = start + share * (q - start)
            yield Command(joints={self._arm: self._arm_goal(rate / seconds * (q - start))})

    def _along(self, start: Array, end: Array, azimuth: float, *, seconds: float) -> Iterator[Command]:
        """Move the tool along a straight line."""
        count = round(seconds / self._dt)
        for number in range(1, count + 1):
            share, _ = between("quintic", number / count)
            q = self._reached(start + share * (end - start), azimuth, self._goal)
            rates, self._goal = (q - self._goal) / self._dt, q
            yield Command(joints={self._arm: self._arm_goal(rates)})
