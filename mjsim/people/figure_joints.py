"""Joints of a figure: axes and ranges, with sources.

At zero the figure stands upright with arms hanging and thumbs forward; all segments are parallel to the world: x
forward, y left, z up. A positive value is the movement in the joint's name, equally on both sides.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

Vector3 = tuple[float, float, float]
SIDES = ("left", "right")

CFR = "38 CFR 4.71, plates I, II and V: normal ranges of motion"
VA = "U.S. Department of Veterans Affairs, joints examination worksheet: normal ranges of the hip"
AAOS = "American Academy of Orthopaedic Surgeons, Joint Motion (1965)"
MERCK = "Merck Manual, Normal Values for Range of Motion of Joints"
SPLIT = "; divided between two joints by an assumption, no source"
ASSUMED = "assumed, no source"


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint about one axis, at the origin of its segment."""

    name: str
    segment: str
    """The segment that it moves relative to that segment's parent."""
    axis: Vector3
    """Unit vector in the frame of the segment; right-handed about it is positive."""
    low: float
    """Minimum value [rad]."""
    high: float
    """Maximum value [rad]."""
    source: str
    """Source of both limits."""


_TRUNK = (
    # segment, joint, axis, range in degrees, source
    ("abdomen", "lumbar_flexion", (0.0, 1.0, 0.0), (-20, 60), CFR + SPLIT),
    ("abdomen", "lumbar_bend", (-1.0, 0.0, 0.0), (-15, 15), CFR + SPLIT),
    ("abdomen", "lumbar_twist", (0.0, 0.0, 1.0), (-10, 10), CFR + SPLIT),
    ("thorax", "thoracic_flexion", (0.0, 1.0, 0.0), (-10, 30), CFR + SPLIT),
    ("thorax", "thoracic_bend", (-1.0, 0.0, 0.0), (-15, 15), CFR + SPLIT),
    ("thorax", "thoracic_twist", (0.0, 0.0, 1.0), (-20, 20), CFR + SPLIT),
    ("neck", "neck_flexion", (0.0, 1.0, 0.0), (-30, 30), CFR + SPLIT),
    ("neck", "neck_bend", (-1.0, 0.0, 0.0), (-35, 35), CFR + SPLIT),
    ("neck", "neck_twist", (0.0, 0.0, 1.0), (-40, 40), CFR + SPLIT),
    ("head", "head_flexion", (0.0, 1.0, 0.0), (-15, 15), CFR + SPLIT),
    ("head", "head_bend", (-1.0, 0.0, 0.0), (-10, 10), CFR + SPLIT),
    ("head", "head_twist", (0.0, 0.0, 1.0), (-40, 40), CFR + SPLIT),
)
_LIMBS = (
    # As on the left; on the right, axes other than y are inverted.
    ("upper_arm", "shoulder_flexion", (0.0, -1.0, 0.0), (-60, 180), f"{CFR}; extension: {AAOS}"),
    ("upper_arm", "shoulder_abduction", (1.0, 0.0, 0.0), (-45, 180), f"{CFR}; adduction: {ASSUMED}"),
    ("upper_arm", "shoulder_rotation", (0.0, 0.0, -1.0), (-90, 90), CFR),
    ("forearm", "elbow_flexion", (0.0, -1.0, 0.0), (0, 145), CFR),
    ("forearm", "forearm_pronation", (0.0, 0.0, -1.0), (-85, 80), CFR),
    ("hand", "wrist_flexion", (-1.0, 0.0, 0.0), (-70, 80), CFR),
    ("hand", "wrist_deviation", (0.0, -1.0, 0.0), (-45, 20), CFR),
    ("thigh", "hip_flexion", (0.0, -1.0, 0.0), (-30, 125), VA),
    ("thigh", "hip_abduction", (1.0, 0.0, 0.0), (-25, 45), VA),
    ("thigh", "hip_rotation", (0.0, 0.0, -1.0), (-60, 40), VA),
    ("shank", "knee_flexion", (0.0, 1.0, 0.0), (0, 140), CFR),
    ("foot", "ankle_flexion", (0.0, -1.0, 0.0), (-45, 20), CFR),
    ("foot", "ankle_inversion", (-1.0, 0.0, 0.0), (-25, 35), MERCK),
)


def joints() -> tuple[Joint, ...]:
    """Return all joints of a figure, parents first; this is the order of joint values."""
    return (*(_joint("", *row) for row in _TRUNK), *_limb_joints())


def _limb_joints() -> Iterator[Joint]:
    for side in SIDES:
        for row in _LIMBS:
            yield _joint(side, *row)


def _joint(side: str, segment: str, name: str, axis: Vector3, degrees: tuple[int, int], source: str) -> Joint:
    prefix = f"{side}_" if side else ""
    x, y, z = axis
    mirrored = (-x or 0.0, y, -z or 0.0) if side == "right" else axis
    low, high = (math.radians(each) for each in degrees)
    return Joint(prefix + name, prefix + segment, mirrored, low, high, source)
