"""The robots, obstacles and beacons of a running world, and where they are."""

import math

import numpy as np

from mjsim.geometry import Array, Pose, Pose3, wrap_angle
from mjsim.record import Tick
from mjsim.session import Session
from mjsim.world import MoveEvent, RemoveEvent


class Entities:
    """Their names and states at the newest tick of a session."""

    def __init__(self, session: Session) -> None:
        """Take those of its world.

        Args:
            session: The run.
        """
        self._session, world = session, session.world
        self._before: Tick | None = None
        self._newest: Tick | None = None
        self._robots = [robot.name for robot in world.robots]
        named = [each for each in world.obstacles if each.name is not None]
        self._standing = {
            **{str(each.name): _at(each.at, 0.0, math.radians(each.heading_deg)) for each in named},
            **{each.name: _at(each.at, each.center, math.radians(each.heading_deg)) for each in world.beacons},
        }
        """Of what is no robot, where it stands at the start."""

    def see(self, tick: Tick) -> None:
        """Take the newest tick."""
        self._before, self._newest = self._newest, tick

    def names(self) -> list[str]:
        """Return the names of all that were not removed."""
        removed = {event.remove for event in self._session.touched if isinstance(event, RemoveEvent)}
        if self._newest is not None and self._newest.looks is not None:
            removed |= self._newest.looks.removed
        return [name for name in (*self._robots, *self._standing) if name not in removed]

    def state(self, name: str) -> tuple[float, Pose3, Array]:
        """Return time [s], world_from_entity, and (x, y, turn) velocity in the world frame [m/s, m/s, rad/s].

        The velocity of a robot is its mean over the newest tick; that of others is not told.
        """
        newest = self._newest
        if newest is None or name not in newest.poses:
            moved = None if newest is None else newest.things.get(f"obstacle/{name}")
            pose = self._standing.get(name, _ORIGIN) if moved is None else Pose3.from_planar(moved)
            return 0.0 if newest is None else newest.time, pose, np.zeros(3)
        return newest.time, newest.poses[name], self._velocity(newest, name)

    def _velocity(self, newest: Tick, name: str) -> Array:
        before = self._before
        jumped = any(isinstance(event, MoveEvent) and event.move == name for event in newest.events)
        if jumped or before is None or not before.time < newest.time or name not in before.truth:
            return np.zeros(3)
        step = newest.truth[name].as_array() - before.truth[name].as_array()
        step[2] = wrap_angle(float(step[2]))
        return np.asarray(step / (newest.time - before.time))


def _at(place: tuple[float, ...], z: float, heading: float) -> Pose3:
    """Return the pose of what stands upright at a height."""
    level = Pose3.from_planar(Pose(place[0], place[1], heading))
    return Pose3(level.x, level.y, z, level.qx, level.qy, level.qz, level.qw)


_ORIGIN = _at((0.0, 0.0), 0.0, 0.0)
