"""Wheels with rollers, and omnidirectional bases on them: mecanum with four, omni3 with three in a ring."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.robots.found_wheels import FoundWheel, turns_freely
from mjsim.geometry import Array, wrap_angle
from mjsim.models import Anatomy
from mjsim.world import OMNI3_BEARINGS

ROLLERS = re.compile(r"mecanum|omni_?wheel|swedish|rotacaster", re.IGNORECASE)
MIN_ROLLERS = 4
"""Minimum number of rollers on a wheel."""
MECANUM_WHEELS = 4
PARALLEL = math.cos(math.radians(12.0))
TOLERANCE = math.radians(10.0)
"""Maximum deviation of wheels from the arrangement of their drive [rad]."""
OWN = "describe another base with drive: {use: FILE.py:CLASS}"


def without_rollers(anatomy: Anatomy) -> tuple[Anatomy, set[int]]:
    """Return a robot with its rollers merged into their wheels, and the indices of these wheels.

    A wheel has rollers if at least four parts turn freely on it about axes other than its own, and it has a free axle
    itself.
    """
    free = {joint.part: joint for joint in anatomy.joints if turns_freely(joint)}
    wheel_of: dict[int, int] = {}
    for number, hub in free.items():
        on_it = [part for part in free if anatomy.parts[part].parent == number]
        # The gears of a differential turn about the axis of their ring gear.
        on_it = [part for part in on_it if abs(float(free[part].axis @ hub.axis)) < PARALLEL]
        if len(on_it) >= MIN_ROLLERS:
            wheel_of |= dict.fromkeys(on_it, number)
    joints = tuple(joint for joint in anatomy.joints if joint.part not in wheel_of)
    shapes = tuple(replace(shape, part=wheel_of.get(shape.part, shape.part)) for shape in anatomy.shapes)
    return replace(anatomy, joints=joints, shapes=shapes), set(wheel_of.values())


def is_omnidirectional(anatomy: Anatomy, wheels: Sequence[FoundWheel], hubs: set[int]) -> bool:
    """Return whether wheels have rollers, according to their parts or names, or are arranged as in omni3."""
    if any(wheel.joint.part in hubs for wheel in wheels):
        return True
    turning = {wheel.joint.part for wheel in wheels}
    names = [wheel.name for wheel in wheels]
    names += [name for part in turning for name in anatomy.parts[part].names]
    # A wheel with rollers may also be a caster of a base with two driven wheels.
    mine = [shape for shape in anatomy.shapes if shape.part in turning or len(wheels) == MECANUM_WHEELS]
    names += [name for shape in mine for name in shape.names]
    return any(ROLLERS.search(name) for name in names) or (len(wheels) == 3 and _in_a_ring(wheels))


def omni_kind(wheels: Sequence[FoundWheel], file: str) -> str:
    """Return the drive of wheels with rollers.

    Raises:
        UsageError: mjsim has no such drive.
    """
    axes = [wheel.axis[:2] / np.linalg.norm(wheel.axis[:2]) for wheel in wheels]
    if len(wheels) == MECANUM_WHEELS and all(abs(float(axis @ axes[0])) > PARALLEL for axis in axes):
        return "mecanum"
    if len(wheels) == 3 and _in_a_ring(wheels):
        return "omni3"
    names = ", ".join(f"'{wheel.name}'" for wheel in wheels[:8])
    raise UsageError(
        f"{file}: {names} have rollers; for these mjsim has mecanum, four on parallel axles, and omni3, three in a"
        f" ring: name the wheels with --left-wheel and --right-wheel, or {OWN}"
    )


def _in_a_ring(wheels: Sequence[FoundWheel]) -> bool:
    """Return whether three wheels are evenly spaced on a circle and roll along it."""
    places = np.array([wheel.middle[:2] for wheel in wheels])
    arms = places - places.mean(axis=0)
    bearings = np.sort(np.arctan2(arms[:, 1], arms[:, 0]))
    gaps = np.diff([*bearings, bearings[0] + 2.0 * math.pi])
    along = [abs(float(w.axis[:2] @ arm)) / (np.linalg.norm(arm) + 1e-9) for w, arm in zip(wheels, arms, strict=True)]
    return bool(np.abs(gaps - 2.0 * math.pi / 3.0).max() < TOLERANCE and min(along) > PARALLEL)


def ring_forward(wheels: Sequence[FoundWheel], requested: Array | None) -> Array:
    """Return the forward direction of a robot with three wheels for which one wheel is at the rear.

    Args:
        wheels: The three wheels of the ring.
        requested: Preferred direction, horizontal unit vector, file frame, shape (2,); by default x.
    """
    places = np.array([wheel.middle[:2] for wheel in wheels])
    arms = places - places.mean(axis=0)
    ahead = -arms / np.linalg.norm(arms, axis=1)[:, None]
    best = int(np.argmax(ahead @ (np.array([1.0, 0.0]) if requested is None else requested)))
    return np.asarray(ahead[best])


def in_the_ring(wheels: Sequence[FoundWheel], forward: Array) -> tuple[FoundWheel, ...]:
    """Return three wheels in the order of the drive: front left, rear, front right."""
    places = np.array([wheel.middle[:2] for wheel in wheels])
    arms = places - places.mean(axis=0)
    heading = math.atan2(forward[1], forward[0])
    bearings = [math.atan2(y, x) - heading for x, y in arms.tolist()]
    return tuple(
        wheels[int(np.argmin([abs(wrap_angle(bearing - bearing_of)) for bearing in bearings]))]
        for bearing_of in OMNI3_BEARINGS.values()
    )
