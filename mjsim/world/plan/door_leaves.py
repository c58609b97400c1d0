"""Doors: position, range and hinge joints of their leaves."""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.world.ground import item_names
from mjsim.world.items import Door, MotorJoint, Opening, Wall, World
from mjsim.world.plan.pieces import SLIVER

THICKNESS = 0.04
"""Thickness of a leaf [m]."""
DAMPING = 0.6
"""Damping of the hinge, as a fraction of the leaf's inertia: a push decays within some seconds [1/s]."""
PUSH = 40.0
"""Force of the motor at the edge of a leaf [N]: less than a robot of average weight withstands."""
SPEED = math.radians(60.0)
"""Speed at which a motor swings a leaf [rad/s]."""
LEAD = math.radians(10.0)
"""Maximum lead of the motor's set-point over an obstructed leaf [rad]."""
TOLERANCE = math.radians(0.1)
"""A leaf has reached its goal when it is this close [rad] and this slow [rad/s]."""


@dataclass(frozen=True, slots=True)
class Leaf:
    """The leaf of a door; the origin of its frame is the hinge, at floor level, with x along the leaf."""

    name: str
    """Name of its opening, or its number among all doors, from 1."""
    door: Door
    hinge: tuple[float, float]
    """Hinge, world frame [m]."""
    closed: float
    """Direction of the closed leaf from the hinge, counter-clockwise from x [rad]."""
    turn: float
    """1 if a positive angle rotates it counter-clockwise, -1 if clockwise."""
    width: float
    """[m]"""
    low: float
    """Height of its lower edge [m]."""
    high: float
    """Height of its upper edge [m]."""

    def pose(self, angle: float) -> Pose:
        """Return world_from_leaf at an opening angle, positive to the left side of its wall [rad]."""
        return Pose(*self.hinge, self.closed + self.turn * angle)

    def joint(self) -> MotorJoint:
        """Return its hinge joint: 0 when closed, positive to the left side of its wall."""
        inertia, limit = self.door.mass * self.width**2 / 3, math.radians(self.door.limit_deg)
        return MotorJoint(
            name=f"door/{self.name}",
            axis=(0.0, 0.0, self.turn),
            start=math.radians(self.door.angle_deg),
            lower=-limit,
            upper=limit,
            damping=DAMPING * inertia,
            stiffness=self.door.spring,
            locked=self.door.locked,
            inertia=inertia,
            effort=PUSH * self.width,
            speed=SPEED,
            lead=LEAD,
            tolerance=TOLERANCE,
        )

    def outline(self) -> Array:
        """Return its corners from above, in its own frame, counter-clockwise, shape (4, 2) [m]."""
        half = THICKNESS / 2
        return np.array([[0.0, -half], [self.width, -half], [self.width, half], [0.0, half]])


def leaves(world: World) -> list[Leaf]:
    """Return the leaves of all doors, wall by wall, without those of openings outside their wall."""
    openings = [(wall, opening) for wall in world.walls for opening in wall.openings if opening.door is not None]
    names = item_names([opening for _, opening in openings])
    found = (_leaf(wall, opening, name) for (wall, opening), name in zip(openings, names, strict=True))
    return [leaf for leaf in found if leaf is not None]


def _leaf(wall: Wall, opening: Opening, name: str) -> Leaf | None:
    first, last = (np.array(end) for end in wall.segments()[opening.segment])
    length = float(np.hypot(*(last - first)))
    along = (last - first) / length
    begin, end = min(opening.at, length), min(opening.at + opening.width, length)
    high = min(opening.head, wall.height)
    if opening.door is None or end - begin < SLIVER or high - opening.sill < SLIVER:
        return None
    heading, right = math.atan2(along[1], along[0]), opening.door.hinge == "right"
    x, y = (first + along * (end if right else begin)).tolist()
    return Leaf(
        name=name,
        door=opening.door,
        hinge=(x, y),
        closed=heading + math.pi if right else heading,
        turn=-1.0 if right else 1.0,
        width=end - begin,
        low=opening.sill,
        high=high,
    )
