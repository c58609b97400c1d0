"""Initial poses of seats and targets in the world frame."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.ground import item_names
from mjsim.world.items import Obstacle, Target, World


@dataclass(frozen=True, slots=True, eq=False)
class PlacedTarget:
    """A target at the initial pose of its object."""

    name: str
    """'OBJECT.TARGET'."""
    target: Target
    world_from_target: Array
    """For a display, x is the direction it faces and y its left seen from behind; z is up; shape (4, 4) [m]."""


def world_from_seat(thing: Obstacle) -> Array:
    """Return the frame of an object's seat: the hip point in the middle of its travel, x forward, shape (4, 4) [m].

    Raises:
        ValueError: The object has no seat.
    """
    if thing.seat is None:
        raise ValueError(Sentence("'{name}' is not a seat; give it seat: {{at: [x, y, z]}}", thing.name))
    return np.asarray(thing.world_from_thing() @ aimed(thing.seat.at))


def placed_targets(world: World) -> Iterator[PlacedTarget]:
    """Yield the targets of all objects, in the order of the world."""
    for thing, name in zip(world.obstacles, item_names(world.obstacles), strict=True):
        for target in thing.targets:
            yaw, pitch = (math.radians(getattr(target, key, 0.0)) for key in ("yaw_deg", "pitch_deg"))
            pose = thing.world_from_thing() @ aimed(target.at, yaw=yaw, pitch=pitch)
            yield PlacedTarget(f"{name}.{target.name}", target, pose)


def aimed(at: Sequence[float], *, yaw: float = 0.0, pitch: float = 0.0) -> Array:
    """Return a pose at a point [m], turned left about z, then up about its own y [rad], shape (4, 4)."""
    (c, s), (u, v) = (math.cos(yaw), math.sin(yaw)), (math.cos(pitch), math.sin(pitch))
    pose = np.eye(4)
    pose[:3, :3] = [[c * u, -s, -c * v], [s * u, c, -s * v], [v, 0.0, u]]
    pose[:3, 3] = at
    return pose
