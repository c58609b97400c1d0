"""What of a robot turns and is round: candidates for wheels, measured from their shapes."""

import math
from dataclasses import dataclass, replace

import numpy as np

from mjsim.geometry import Array
from mjsim.models import Anatomy, FileJoint, Shape

LEVEL = 0.2
"""Largest vertical part of an axle's direction."""
UPRIGHT = 0.85
"""Smallest vertical part of the axis that steers."""
ROUND = 0.85
"""Least width of a round part, of its largest."""
SQUARE = 0.69
"""The same of a box that stands for a wheel."""
RIM = 0.9
"""What of a wheel is this far from its axle rolls on the floor, in radii; the rest is its hub and its motor."""
DIRECTIONS = 24
"""Around an axle, in which widths are compared."""
WHOLE_TURN = 2.0 * math.pi * 0.95
"""A joint that turns less is no wheel [rad]."""
AXLE = 3.0
"""A part that is wider, in radii, and round at both ends has a wheel at each."""


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """A part that turns about a level axle, file frame."""

    joint: FileJoint
    middle: Array
    """Of the wheel, on its axle, shape (3,) [m]."""
    axis: Array
    """Unit vector along the axle, level, shape (3,)."""
    radius: float
    """[m]; 0 where no shape tells it."""
    width: float
    """[m]"""
    steer: FileJoint | None = None
    """The upright joint that turns it; None for a wheel that points one way."""
    swivels: bool = False
    """Whether that joint turns freely: a caster."""

    @property
    def name(self) -> str:
        """Of its joint."""
        return self.joint.name

    @property
    def bottom(self) -> float:
        """Height of its lowest point [m]."""
        return float(self.middle[2]) - self.radius


def rounds(anatomy: Anatomy) -> list[Round]:
    """Return what turns about level axles without limits; two for an axle with a wheel at each end."""
    found: list[Round] = []
    for joint in anatomy.joints:
        if turns_freely(joint) and abs(joint.axis[2]) < LEVEL:
            found += measured(anatomy, joint)
    return found


def turns_freely(joint: FileJoint) -> bool:
    """Return whether a joint turns round and round."""
    return not joint.slides and (joint.range is None or joint.range[1] - joint.range[0] > WHOLE_TURN)


def measured(anatomy: Anatomy, joint: FileJoint) -> list[Round]:
    """Return the wheels on a joint: one or two, none where what turns is not round."""
    shapes = [shape for shape in anatomy.shapes if shape.part == joint.part]
    axis = joint.axis * [1.0, 1.0, 0.0]
    axis /= np.linalg.norm(axis)
    steer, swivels = _steered(anatomy, joint)
    bare = Round(joint, joint.at, axis, 0.0, 0.0, steer, swivels)
    if not shapes:
        return [bare]
    solid = [shape for shape in shapes if shape.touched] or shapes
    called = "wheel" in " ".join([joint.name, *anatomy.parts[joint.part].names]).lower()
    pictured = [shape for shape in shapes if shape.seen] or shapes
    # What a wheel touches with may be a box, for speed; then its picture is round, or its sides are equal.
    for group, least in ((solid, ROUND), (pictured, ROUND), *(((solid, SQUARE),) if called else ())):
        wheels = [_around(bare, end, least) for end in _ends(bare, group)]
        if found := [wheel for wheel in wheels if wheel.radius > 0.0]:
            return found
    return []


def _steered(anatomy: Anatomy, joint: FileJoint) -> tuple[FileJoint | None, bool]:
    """Return the upright joint between a wheel and the base, and whether it turns freely, unmoved by a motor."""
    part = anatomy.parts[joint.part].parent
    while part > 0:
        for other in anatomy.joints:
            if other.part == part and not other.slides and abs(other.axis[2]) > UPRIGHT:
                return other, turns_freely(other) and not other.driven
        part = anatomy.parts[part].parent
    return None, False


def _ends(bare: Round, shapes: list[Shape]) -> list[list[Shape]]:
    """Return the shapes of a part in one group, or in two where they are the wheels of an axle."""
    along = [(shape.points - bare.middle) @ bare.axis for shape in shapes]
    width = max(float(a.max()) for a in along) - min(float(a.min()) for a in along)
    radius = max(_reach(bare, shape) for shape in shapes)
    sides = [
        [shape for shape, a in zip(shapes, along, strict=True) if sign * float(a.mean()) > 0.25 * width]
        for sign in (1.0, -1.0)
    ]
    if width > AXLE * radius and all(sides):
        return sides
    return [shapes]


def _reach(bare: Round, shape: Shape) -> float:
    offsets = shape.points - bare.middle
    return float(np.linalg.norm(offsets - np.outer(offsets @ bare.axis, bare.axis), axis=1).max())


def _around(bare: Round, shapes: list[Shape], least: float) -> Round:
    """Return the wheel that shapes make; of radius 0 where their narrowest is less than a fraction of their widest."""
    points = np.concatenate([shape.points for shape in shapes]) - bare.middle
    across = np.cross([0.0, 0.0, 1.0], bare.axis)
    angles = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
    widths = np.array([(points @ (math.cos(a) * across + math.sin(a) * np.array([0, 0, 1.0]))).max() for a in angles])
    if widths.min() < least * widths.max():
        return bare
    # Of a circle with few corners the corners are what rolls, of a box the sides; the axle may not be quite level.
    axle = bare.joint.axis
    distances = np.linalg.norm(points - np.outer(points @ axle, axle), axis=1)
    corners = float(distances.max())
    along = points[distances > RIM * corners] @ bare.axis
    return replace(
        bare,
        middle=bare.middle + bare.axis * (along.min() + along.max()) / 2,
        radius=corners if widths.min() >= ROUND * widths.max() else float(widths.min()),
        width=float(np.ptp(along)),
    )
