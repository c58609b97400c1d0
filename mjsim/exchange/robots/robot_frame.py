"""The robot's own frame in its file, its points of support on the floor, and its size."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.robots.driven_wheels import CASTER, Gear
from mjsim.geometry import Array
from mjsim.models import Anatomy, Shape

MAX_SUPPORT_HEIGHT = 0.3
"""A fixed part this close to the floor supports the robot, as a fraction of the wheel radius."""
MIN_SLACK = 0.006
"""Minimum value of this distance [m]."""
MIN_POINTS = 0.003
"""Points of a shape within this height above its lowest point touch the floor [m]."""
MIN_SUPPORT = 0.004
"""Smaller shapes only mark a frame, such as that of the footprint, and support nothing [m]."""
SAME_PLACE = 0.02
"""Casters closer together than this are one [m]."""
MAX_CASTERS = 12
GRAVITY = 9.81
CASTER_POSITION = 0.8
"""Position of a caster that the file lacks, as a fraction of the extent of the body's lower part."""
BASE_HEIGHT = 1.5
"""Height of that part, which has no arms, in wheel diameters."""


@dataclass(frozen=True, slots=True, eq=False)
class Stand:
    """Geometry of a robot in its own frame: x forward, y left, origin on the floor."""

    origin: Array
    """Origin of that frame, file frame, shape (3,) [m]."""
    heading: float
    """Direction of its x axis in the file frame, counter-clockwise [rad]."""
    casters: tuple[tuple[float, float, float], ...]
    """x, y and radius of each sliding contact, robot frame [m]."""
    radius: float
    """Radius of the circle around it [m]."""
    height: float
    """Height above the floor [m]."""
    center: Array
    """Centre of mass, robot frame, shape (3,) [m]."""
    notes: tuple[str, ...]

    def point(self, p_file: Array) -> Array:
        """Return points of the file frame in the robot frame, shape (..., 3) [m]."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray((p_file - self.origin) @ turn)

    def direction(self, d_file: Array) -> Array:
        """Return a direction of the file frame in the robot frame, shape (3,)."""
        return self.point(d_file + self.origin)


def find_stand(anatomy: Anatomy, gear: Gear, *, acceleration: float, ahead: float = 0.0) -> Stand:
    """Return the frame, supports and size of a robot.

    Args:
        anatomy: Contents of its file.
        gear: Its wheels.
        acceleration: Acceleration at which it must not tip over [m/s^2].
        ahead: Distance of its origin ahead of the centre of its wheels, or of its rear axle [m].
    """
    row = gear.rows[-1:] if gear.drive == "ackermann" else gear.rows
    pairs = [(pair[0][0].middle + pair[1][0].middle) / 2 for pair in row]
    middles = np.array(pairs or [wheel.middle for wheel in gear.single])
    origin = np.array([*(middles[:, :2].mean(axis=0) + ahead * gear.forward), gear.floor])
    heading = math.atan2(gear.forward[1], gear.forward[0])
    bare = Stand(origin, heading, (), 0.0, 0.0, np.zeros(3), ())
    moving = {wheel.joint.part for wheel in gear.wheels()}
    body = [shape for shape in anatomy.shapes if shape.part not in moving]
    solid = [shape for shape in body if shape.touched] or body
    points, everything = (_all_points(bare, gear, shapes) for shapes in (solid or anatomy.shapes, anatomy.shapes))
    center = bare.point(anatomy.center)
    casters = _casters(anatomy, gear, bare, solid)
    wheels = [bare.point(wheel.middle) for wheel in gear.wheels()]
    casters, notes = _steadied(casters, wheels, center, points, acceleration=acceleration)
    wheel_rims = [np.hypot(*w[:2]) + 0.5 * r.width for w, r in zip(wheels, gear.wheels(), strict=True)]
    radius = max(float(np.hypot(points[:, 0], points[:, 1]).max()), *wheel_rims)
    height = max(float(everything[:, 2].max()), 0.02)
    return Stand(origin, heading, tuple(casters[:MAX_CASTERS]), radius, height, center, notes)


def _all_points(stand: Stand, gear: Gear, shapes: Sequence[Shape]) -> Array:
    """Return the points of shapes in the robot frame, those of wheels where there are no shapes, shape (n, 3) [m]."""
    wheels = gear.wheels()
    rims = np.array([wheel.middle + sign * wheel.radius * np.eye(3)[2] for wheel in wheels for sign in (-1.0, 1.0)])
    return np.concatenate([stand.point(points) for points in ([shape.points for shape in shapes] or [rims])])


def _casters(anatomy: Anatomy, gear: Gear, stand: Stand, solid: list[Shape]) -> list[tuple[float, float, float]]:
    """Return the supports of a robot besides its wheels: small wheels, balls, and low parts."""
    found: list[tuple[float, float, float]] = []
    least = min(wheel.radius for wheel in gear.wheels())
    for wheel in gear.bearing:
        x, y, _ = stand.point(wheel.middle)
        _keep(found, x, y, min(wheel.radius, 0.5 * least))
    turning = {wheel.joint.part for wheel in gear.bearing}
    for shape in solid:
        if shape.part in turning:
            continue
        points = stand.point(shape.points)
        if float(np.ptp(points, axis=0).max()) < MIN_SUPPORT:
            continue
        lowest = float(points[:, 2].min())
        named = any(CASTER.search(name) for name in shape.names)
        if lowest < max(MAX_SUPPORT_HEIGHT * least * (1.5 if named else 0.5), MIN_SLACK):
            low = points[points[:, 2] < lowest + MIN_POINTS]
            x, y = (low[:, :2].min(axis=0) + low[:, :2].max(axis=0)) / 2
            size = float(np.ptp(points, axis=0).max()) / 2
            _keep(found, x, y, float(np.clip(size, 0.2 * least, 0.5 * least)))
    return found


def _keep(found: list[tuple[float, float, float]], x: float, y: float, radius: float) -> None:
    if all(math.hypot(x - other[0], y - other[1]) > SAME_PLACE for other in found):
        found.append((float(x), float(y), float(radius)))


def _steadied(
    casters: list[tuple[float, float, float]],
    wheels: list[Array],
    center: Array,
    points: Array,
    *,
    acceleration: float,
) -> tuple[list[tuple[float, float, float]], tuple[str, ...]]:
    """Return casters with which a robot neither tips over nor rests on its front, and notes on those added."""
    along = [float(x) for x, *_ in (*casters, *(wheel.tolist() for wheel in wheels))]
    spare = max(0.002, float(center[2]) * acceleration / GRAVITY)
    small = 0.3 * min(float(wheel[2]) for wheel in wheels)
    notes, steady = [], list(casters)
    below = points[points[:, 2] < 2.0 * BASE_HEIGHT * max(float(wheel[2]) for wheel in wheels)]
    for sign, word in ((1.0, "ahead"), (-1.0, "behind")):
        if max(sign * x for x in along) >= sign * float(center[0]) + spare:
            continue
        reach = CASTER_POSITION * float((sign * (below if len(below) else points)[:, 0]).max())
        x = sign * max(sign * float(center[0]) + spare, reach)
        steady.append((x, 0.0, small))
        notes.append(f"a frictionless caster at {x:.3f} m {word}: without it, the robot would tip over")
    return steady, tuple(notes)
