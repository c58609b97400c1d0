"""Finds the round rotating parts of a robot: candidates for wheels, measured from their shapes."""

import math
from dataclasses import dataclass, replace

import numpy as np

from mjsim.geometry import Array
from mjsim.models import Anatomy, FileJoint, Shape

MAX_AXLE_RISE = 0.2
"""Maximum vertical component of an axle's unit vector."""
MIN_STEERING_RISE = 0.85
"""Minimum vertical component of a steering axis."""
MIN_ROUND_RATIO = 0.85
"""Minimum width of a round part, as a fraction of its maximum width."""
MIN_BOX_RATIO = 0.69
"""The same for a box that stands for a wheel."""
RIM_RATIO = 0.9
"""The part of a wheel beyond this distance from its axle rolls on the floor, in wheel radii; the rest is hub and motor.
"""
DIRECTIONS = 24
"""Number of directions around an axle in which widths are compared."""
WHOLE_TURN = 2.0 * math.pi * 0.95
"""A joint with a smaller range is not a wheel's [rad]."""
MIN_CASTER_TRAIL = 0.2
"""A wheel farther than this behind its vertical joint is a caster, in wheel radii."""
MIN_AXLE_RATIO = 3.0
"""A part wider than this, in wheel radii, and round at both ends, has a wheel at each end."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundWheel:
    """A part that turns about a horizontal axle, in the file frame."""

    joint: FileJoint
    middle: Array
    """Centre of the wheel, on its axle, shape (3,) [m]."""
    axis: Array
    """Horizontal unit vector along the axle, shape (3,)."""
    radius: float
    """[m]; 0 if no shape shows it."""
    width: float
    """[m]"""
    steer: FileJoint | None = None
    """The vertical joint that steers it; None for a fixed wheel."""
    swivels: bool = False
    """Whether that joint turns freely, as on a caster."""

    @property
    def name(self) -> str:
        """Name of its joint."""
        return self.joint.name

    @property
    def bottom(self) -> float:
        """Height of its lowest point [m]."""
        return float(self.middle[2]) - self.radius


def found_wheels(anatomy: Anatomy) -> list[FoundWheel]:
    """Return the parts that turn about horizontal axles without limits; an axle with two wheels gives two."""
    found: list[FoundWheel] = []
    for joint in anatomy.joints:
        if could_be_axle(joint):
            found += measured(anatomy, joint)
    return found


def turns_freely(joint: FileJoint) -> bool:
    """Return whether a joint can turn without limit."""
    return not joint.slides and (joint.range is None or joint.range[1] - joint.range[0] > WHOLE_TURN)


def could_be_axle(joint: FileJoint) -> bool:
    """Return whether a joint is level and can turn without limit."""
    return turns_freely(joint) and abs(float(joint.axis[2])) < MAX_AXLE_RISE


def bare(joint: FileJoint) -> FoundWheel:
    """Return a wheel of unknown size on a joint."""
    axis = joint.axis * [1.0, 1.0, 0.0]
    return FoundWheel(joint, joint.at, axis / np.linalg.norm(axis), 0.0, 0.0)


def measured(anatomy: Anatomy, joint: FileJoint) -> list[FoundWheel]:
    """Return the wheels on a joint: one or two, or none if what turns is not round."""
    steer, swivels = _steered(anatomy, joint)
    unsized = replace(bare(joint), steer=steer, swivels=swivels)
    return [_settled(wheel) for wheel in _shaped(anatomy, unsized)]


def _settled(wheel: FoundWheel) -> FoundWheel:
    """Return a wheel on a joint with limits of 0 to 0 as steered, unless it trails behind that joint as a caster."""
    if wheel.steer is None or not (wheel.swivels and wheel.steer.placeholder):
        return wheel
    across = np.cross([0.0, 0.0, 1.0], wheel.axis)
    return replace(
        wheel, swivels=bool(abs(float((wheel.middle - wheel.steer.at) @ across)) > MIN_CASTER_TRAIL * wheel.radius)
    )


def _shaped(anatomy: Anatomy, unsized: FoundWheel) -> list[FoundWheel]:
    """Return the wheels on a joint as their shapes show them."""
    joint = unsized.joint
    shapes = [shape for shape in anatomy.shapes if shape.part == joint.part]
    if not shapes:
        return [unsized]
    solid = [shape for shape in shapes if shape.touched] or shapes
    called = "wheel" in " ".join([joint.name, *anatomy.parts[joint.part].names]).lower()
    pictured = [shape for shape in shapes if shape.seen] or shapes
    # The collision shape of a wheel may be a box, for speed; then its visual shape is round, or its sides are equal.
    for group, least in (
        (solid, MIN_ROUND_RATIO),
        (pictured, MIN_ROUND_RATIO),
        *(((solid, MIN_BOX_RATIO),) if called else ()),
    ):
        wheels = [_around(unsized, end, least) for end in _ends(unsized, group)]
        if found := [wheel for wheel in wheels if wheel.radius > 0.0]:
            return found
    return []


def _steered(anatomy: Anatomy, joint: FileJoint) -> tuple[FileJoint | None, bool]:
    """Return the vertical joint between a wheel and the base, and whether it turns freely, without a motor."""
    part = anatomy.parts[joint.part].parent
    while part > 0:
        for other in anatomy.joints:
            if other.part == part and not other.slides and abs(other.axis[2]) > MIN_STEERING_RISE:
                return other, turns_freely(other) and not other.driven
        part = anatomy.parts[part].parent
    return None, False


def _ends(unsized: FoundWheel, shapes: list[Shape]) -> list[list[Shape]]:
    """Return the shapes of a part in one group, or in two if they are the wheels of an axle."""
    along = [(shape.points - unsized.middle) @ unsized.axis for shape in shapes]
    width = max(float(a.max()) for a in along) - min(float(a.min()) for a in along)
    radius = max(_reach(unsized, shape) for shape in shapes)
    sides = [
        [shape for shape, a in zip(shapes, along, strict=True) if sign * float(a.mean()) > 0.25 * width]
        for sign in (1.0, -1.0)
    ]
    if width > MIN_AXLE_RATIO * radius and all(sides):
        return sides
    return [shapes]


def _reach(unsized: FoundWheel, shape: Shape) -> float:
    offsets = shape.points - unsized.middle
    return float(np.linalg.norm(offsets - np.outer(offsets @ unsized.axis, unsized.axis), axis=1).max())


def _around(unsized: FoundWheel, shapes: list[Shape], least: float) -> FoundWheel:
    """Return the wheel of given shapes; radius 0 if their minimum width is less than `least` times the maximum."""
    points = np.concatenate([shape.points for shape in shapes]) - unsized.middle
    across = np.cross([0.0, 0.0, 1.0], unsized.axis)
    angles = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
    widths = np.array([(points @ (math.cos(a) * across + math.sin(a) * np.array([0, 0, 1.0]))).max() for a in angles])
    if widths.min() < least * widths.max():
        return unsized
    # A polygon with few corners rolls on its corners, a box on its sides; the axle may be slightly tilted.
    axle = unsized.joint.axis
    distances = np.linalg.norm(points - np.outer(points @ axle, axle), axis=1)
    corners = float(distances.max())
    along = points[distances > RIM_RATIO * corners] @ unsized.axis
    return replace(
        unsized,
        middle=unsized.middle + unsized.axis * (along.min() + along.max()) / 2,
        radius=corners if widths.min() >= MIN_ROUND_RATIO * widths.max() else float(widths.min()),
        width=float(np.ptp(along)),
    )
