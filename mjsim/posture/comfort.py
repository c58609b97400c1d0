"""Published angles of comfortable sitting, and the joint values derived from them.

Rebiffé's angles and the line of sight of MIL-STD-1472G are as commonly quoted in the field: neither source was
available.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.people import SIDES, Figure

REBIFFE = "Rebiffé (1969), as commonly quoted, not checked: driving"
OSHA = "OSHA, Computer Workstations eTool, good working positions: desk"
SIGHT_DOWN = math.radians(15.0)
"""Angle of the normal line of sight below the horizontal of the head [rad]; MIL-STD-1472G, as commonly quoted."""


@dataclass(frozen=True, slots=True)
class ComfortRange:
    """A published range of comfort."""

    angle: str
    """Name of the angle in `posture_angles`, without the side."""
    low: float
    """[deg]"""
    high: float
    """[deg]"""
    source: str

    @property
    def middle(self) -> float:
        """Return the centre of the range [rad]."""
        return math.radians((self.low + self.high) / 2)


COMFORT = (
    ComfortRange("trunk", 20.0, 30.0, REBIFFE),
    ComfortRange("trunk_thigh", 95.0, 120.0, REBIFFE),
    ComfortRange("knee", 95.0, 135.0, REBIFFE),
    ComfortRange("foot_calf", 90.0, 110.0, REBIFFE),
    ComfortRange("upper_arm", 10.0, 45.0, REBIFFE),
    ComfortRange("elbow", 80.0, 120.0, REBIFFE),
    ComfortRange("elbow", 90.0, 120.0, OSHA),
)
"""Known comfort ranges; for all other joints there is no citable source, and the centre of their range is preferred."""
ANGLES: Mapping[str, str] = {
    "trunk": "trunk back from upright, from hips to shoulders",
    "trunk_thigh": "between trunk and thigh",
    "knee": "between thigh and shank",
    "foot_calf": "between shank and sole",
    "upper_arm": "upper arm from hanging straight down",
    "elbow": "between upper arm and forearm",
}
"""Definitions of the angles."""


def preferred_values(back: float) -> dict[str, float]:
    """Return preferred joint values by name [rad]: centres of Rebiffé's ranges; others are 0.

    Args:
        back: Backward lean of the trunk from vertical [rad].
    """
    middle = {each.angle: each.middle for each in COMFORT if each.source == REBIFFE}
    found = {}
    for side in SIDES:
        found[f"{side}_hip_flexion"] = math.pi - middle["trunk_thigh"]
        found[f"{side}_knee_flexion"] = math.pi - middle["knee"]
        found[f"{side}_ankle_flexion"] = math.pi / 2 - middle["foot_calf"]
        # An arm parallel to a trunk that leans back points forward by that angle.
        found[f"{side}_shoulder_flexion"] = middle["upper_arm"] - back
        found[f"{side}_elbow_flexion"] = math.pi - middle["elbow"]
    return found


def posture_angles(figure: Figure, poses: Mapping[str, Array]) -> dict[str, float]:
    """Return the angles that describe a posture, by name; those of limbs with their side [deg].

    Args:
        figure: The body.
        poses: world_from_segment, as returned by `Figure.poses`.
    """
    at = {name: pose[:3, 3] for name, pose in poses.items()}
    spots = figure.spots(poses)
    shoulders = (at["left_upper_arm"] + at["right_upper_arm"]) / 2
    trunk, ahead = shoulders - at["pelvis"], poses["pelvis"][:3, 1]
    forward = np.cross(ahead, [0.0, 0.0, 1.0])
    found = {"trunk": -math.degrees(math.atan2(trunk @ forward, trunk[2]))}
    for side in SIDES:
        hip, knee, ankle = (at[f"{side}_{name}"] for name in ("thigh", "shank", "foot"))
        shoulder, elbow, wrist = (at[f"{side}_{name}"] for name in ("upper_arm", "forearm", "hand"))
        sole = spots[f"{side}_ball"] - spots[f"{side}_heel"]
        found |= {
            f"{side}_trunk_thigh": _between(trunk, knee - hip),
            f"{side}_knee": _between(hip - knee, ankle - knee),
            f"{side}_foot_calf": _between(knee - ankle, sole),
            f"{side}_upper_arm": _between(elbow - shoulder, np.array([0.0, 0.0, -1.0])),
            f"{side}_elbow": _between(shoulder - elbow, wrist - elbow),
        }
    return found


def comfort_of(angle: str) -> tuple[ComfortRange, ...]:
    """Return the published ranges of an angle, named with or without its side."""
    bare = angle.removeprefix("left_").removeprefix("right_")
    return tuple(each for each in COMFORT if each.angle == bare)


def _between(first: Array, second: Array) -> float:
    """Return the angle between two vectors, in [0, 180] [deg]."""
    return math.degrees(math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second)))
