"""A figure: segments of a body with given measures, connected by joints; their inertias are from de Leva's tables."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.mechanics import Solid, screw, six_of, tensor
from mjsim.people.deleva import PAIRED, share_of
from mjsim.people.figure_frame import BodyFrame, Spot, Vector3, body_frame
from mjsim.people.figure_joints import SIDES, Joint, joints
from mjsim.people.measures import Measures
from mjsim.sentences import Sentence

PARENTS: Mapping[str, str | None] = {
    "pelvis": None,
    "abdomen": "pelvis",
    "thorax": "abdomen",
    "neck": "thorax",
    "head": "neck",
    **{
        f"{side}_{segment}": f"{side}_{parent}" if parent not in ("thorax", "pelvis") else parent
        for side in SIDES
        for segment, parent in (
            ("upper_arm", "thorax"),
            ("forearm", "upper_arm"),
            ("hand", "forearm"),
            ("thigh", "pelvis"),
            ("shank", "thigh"),
            ("foot", "shank"),
        )
    },
}
"""Each segment's parent, parents first; the pelvis has none."""


HAND_BESIDE = 0.025
"""Distance of the middle of a hanging hand from the side of the hips [m]; assumed."""
MIN_ABDUCTION, ELBOW_AT_EASE = math.radians(3.0), math.radians(12.0)
"""Minimum angle of hanging arms from the trunk, and relaxed elbow flexion [rad]; assumed."""


@dataclass(frozen=True, slots=True)
class Segment:
    """A rigid part of a figure; the origin of its frame is its upper joint, for the pelvis the H-point."""

    name: str
    parent: str | None
    """None for the pelvis."""
    at: Vector3
    """Its origin in the frame of its parent; for the pelvis, in the world frame of the upright figure [m]."""
    solid: Solid
    """Mass, centre of mass and inertia, in its frame."""
    joints: tuple[Joint, ...]
    """Joints between its parent and itself, in order."""


@dataclass(frozen=True, slots=True)
class Landmark:
    """A point on a segment."""

    segment: str
    at: Vector3
    """Position in the frame of the segment [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """A body with given measures: its segments, joints and landmarks."""

    measures: Measures
    segments: Mapping[str, Segment]
    """By name, parents first."""
    joints: Mapping[str, Joint]
    """By name, in the order of joint values, n in total."""
    landmarks: Mapping[str, Landmark]
    """By name."""
    seat_to_hip: float
    """Height of the H-point above a hard seat, sitting erect [m]."""

    @classmethod
    def of(cls, measures: Measures) -> Self:
        """Return the figure with these measures.

        Raises:
            MeasureError: No body has this combination of measures.
        """
        frame = body_frame(measures)
        origins = _both_sides(frame.joints)
        solids = solids_of(measures, frame)
        turning = joints()
        segments = {
            name: Segment(
                name,
                parent,
                origins[name] if parent is None else _minus(origins[name], origins[parent]),
                solids[name],
                tuple(joint for joint in turning if joint.segment == name),
            )
            for name, parent in PARENTS.items()
        }
        return cls(
            measures,
            MappingProxyType(segments),
            MappingProxyType({joint.name: joint for joint in turning}),
            MappingProxyType(_landmarks(frame, origins)),
            frame.seat_to_hip,
        )

    @property
    def limits(self) -> Array:
        """Return minimum and maximum of all joints, shape (n, 2) [rad]."""
        return np.array([[joint.low, joint.high] for joint in self.joints.values()])

    @property
    def upright(self) -> Array:
        """world_from_pelvis of the upright figure above the origin, shape (4, 4) [m]."""
        pose = np.eye(4)
        pose[:3, 3] = self.segments["pelvis"].at
        return pose

    @property
    def at_ease(self) -> Array:
        """Joint values of a relaxed standing person: arms hang beside the hips, shape (n,) [rad]."""
        shoulder, hip = self.segments["left_upper_arm"], self.landmarks["left_hip_side"]
        thorax = self.poses()["thorax"][:3, 3] + shoulder.at
        height = thorax[2] - self.segments["pelvis"].at[2]
        abduction = math.atan2(hip.at[1] + HAND_BESIDE - thorax[1], height)
        angles = {"shoulder_abduction": max(abduction, MIN_ABDUCTION), "elbow_flexion": ELBOW_AT_EASE}
        return self.values({f"{side}_{name}": angle for side in SIDES for name, angle in angles.items()})

    def values(self, angles: Mapping[str, float]) -> Array:
        """Return all joint values, shape (n,) [rad]: those given by name, 0 for the others.

        Raises:
            ValueError: The joint does not exist.
        """
        names = list(self.joints)
        found = np.zeros(len(names))
        for name, angle in angles.items():
            if name not in self.joints:
                raise ValueError(Sentence("no joint '{name}'{did_you_mean}", name, did_you_mean(name, names)))
            found[names.index(name)] = angle
        return found

    def poses(self, values: ArrayLike | None = None, root: Array | None = None) -> dict[str, Array]:
        """Return the poses of all segments.

        Args:
            values: Joint values in order, shape (..., n) [rad]; by default zeros.
            root: world_from_pelvis, shape (..., 4, 4) [m]; by default upright above the origin.

        Returns:
            world_from_segment by the segment's name, shape (..., 4, 4) [m].
        """
        angles = np.zeros(len(self.joints)) if values is None else np.asarray(values, dtype=float)
        columns = {name: angles[..., place] for place, name in enumerate(self.joints)}
        found: dict[str, Array] = {}
        for name, segment in self.segments.items():
            if segment.parent is None:
                found[name] = self.upright if root is None else np.asarray(root, dtype=float)
                continue
            step = np.eye(4)
            step[:3, 3] = segment.at
            for joint in segment.joints:
                axis = int(np.argmax(np.abs(joint.axis)))
                step = step @ screw(columns[joint.name] * math.copysign(1.0, joint.axis[axis]), 0.0, axis=axis)
            found[name] = found[segment.parent] @ step
        return found

    def lowest(self, values: ArrayLike | None = None) -> float:
        """Return the height of the lowest point of the soles [m], with the pelvis in its upright pose.

        Args:
            values: Joint values in order, shape (n,) [rad]; by default zeros.
        """
        spots = self.spots(self.poses(values))
        return min(float(spots[f"{side}_{part}"][2]) for side in SIDES for part in ("heel", "ball", "toe"))

    def spots(self, poses: Mapping[str, Array]) -> dict[str, Array]:
        """Return the positions of all landmarks, world frame, by name, shape (..., 3) [m].

        Args:
            poses: world_from_segment, as returned by `poses`.
        """
        return {
            name: poses[mark.segment][..., :3, :3] @ mark.at + poses[mark.segment][..., :3, 3]
            for name, mark in self.landmarks.items()
        }


def _both_sides(left: Mapping[str, Vector3]) -> dict[str, Vector3]:
    """Return points by name, with those of the right side mirrored from the left."""
    paired = [name for name in left if name.startswith("left_")]
    right = {name.replace("left_", "right_"): (left[name][0], -left[name][1], left[name][2]) for name in paired}
    return {**left, **right}


def _landmarks(frame: BodyFrame, origins: Mapping[str, Vector3]) -> dict[str, Landmark]:
    spots: dict[str, Spot] = dict(frame.landmarks)
    for name, spot in frame.landmarks.items():
        if name.startswith("left_"):
            x, y, z = spot.at
            segment = spot.segment.replace("left_", "right_")
            spots[f"right_{name.removeprefix('left_')}"] = Spot(segment, (x, -y, z))
    return {name: Landmark(spot.segment, _minus(spot.at, origins[spot.segment])) for name, spot in spots.items()}


def _minus(point: Vector3, origin: Vector3) -> Vector3:
    return point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]


NECK_RADIUS = 0.33
"""Radius of the neck, as a fraction of head length; assumed."""
SKULL_HEIGHT = 1.7
"""Height of the head from chin to vertex, as a fraction of its height above the tragion; assumed."""


def solids_of(measures: Measures, frame: BodyFrame) -> dict[str, Solid]:
    """Return mass, centre of mass and inertia of each segment, in its frame; the masses add up to the body's weight."""
    found: dict[str, Solid] = {}
    for name, (upper, lower) in _ends(measures, frame).items():
        kind = name.removeprefix("left_")
        solid = _solid(measures, kind, upper, lower, frame.joints[name])
        found[name] = solid
        if kind in PAIRED:
            found[f"right_{kind}"] = _mirrored(solid)
    whole = found.pop("head")
    found["neck"], found["head"] = _divided(measures, whole, frame)
    return found


def _ends(m: Measures, frame: BodyFrame) -> dict[str, tuple[Vector3, Vector3]]:
    """Return the endpoints of the segments as defined by de Leva, world frame [m]; of the foot from heel to toe."""
    joints, marks = frame.joints, frame.landmarks
    omphalion, xiphion = joints["abdomen"][2], joints["thorax"][2]
    middle = 0.5 * (marks["chest_back"].at[0] + marks["chest_front"].at[0])
    waist = 0.5 * (marks["waist_back"].at[0] + marks["waist_front"].at[0])
    ankle, heel, toe = joints["left_foot"], marks["left_heel"].at, marks["left_toe"].at
    return {
        "head": (marks["vertex"].at, (marks["vertex"].at[0], 0.0, m["cervicale_height"])),
        "thorax": ((middle, 0.0, m["suprasternale_height"]), (middle, 0.0, xiphion)),
        "abdomen": ((middle, 0.0, xiphion), (waist, 0.0, omphalion)),
        "pelvis": ((waist, 0.0, omphalion), joints["pelvis"]),
        "left_upper_arm": (joints["left_upper_arm"], joints["left_forearm"]),
        "left_forearm": (joints["left_forearm"], joints["left_hand"]),
        "left_hand": (joints["left_hand"], marks["left_fingertip"].at),
        "left_thigh": (joints["left_thigh"], joints["left_shank"]),
        "left_shank": (joints["left_shank"], joints["left_foot"]),
        "left_foot": ((heel[0], heel[1], 0.5 * ankle[2]), (toe[0], toe[1], 0.5 * ankle[2])),
    }


def _solid(m: Measures, kind: str, upper: Vector3, lower: Vector3, origin: Vector3) -> Solid:
    share = share_of(m.sex, kind)
    mass = share.mass * m["weight"]
    # Along the segment; the endpoints of trunk and head are slightly offset forward or backward.
    length = abs(lower[0] - upper[0]) if kind == "foot" else abs(upper[2] - lower[2])
    x, y, z = (a + share.center * (b - a) - c for a, b, c in zip(upper, lower, origin, strict=True))
    about = (share.sagittal, share.transverse, share.longitudinal)
    if kind == "foot":  # its length points forward
        about = (share.longitudinal, share.transverse, share.sagittal)
    xx, yy, zz = (mass * (radius * length) ** 2 for radius in about)
    return Solid(mass, (x, y, z), (xx, yy, zz, 0.0, 0.0, 0.0))


def _mirrored(solid: Solid) -> Solid:
    x, y, z = solid.center
    return Solid(solid.mass, (x, -y, z), solid.inertia)


def _divided(m: Measures, whole: Solid, frame: BodyFrame) -> tuple[Solid, Solid]:
    """Return neck and head, together de Leva's head: a cylinder and an ellipsoid share its mass by volume."""
    shift = np.subtract(frame.joints["head"], frame.joints["neck"])
    radius, length = NECK_RADIUS * m["head_length"], float(shift[2])
    tube = math.pi * radius**2 * length
    skull = math.pi / 6.0 * m["head_length"] * m["head_breadth"] * SKULL_HEIGHT * m["tragion_to_vertex"]
    mass = whole.mass * tube / (tube + skull)
    across, axial = mass * (radius**2 / 4.0 + length**2 / 12.0), 0.5 * mass * radius**2
    # The whole is given in the frame of the head, which is parallel to that of the neck.
    together = np.add(whole.center, shift)
    # Directly below the head, so that no product of inertia remains.
    neck = np.array([together[0], 0.0, 0.5 * length])
    rest = whole.mass - mass
    head = (whole.mass * together - mass * neck) / rest
    inertia = tensor(whole.inertia) - np.diag([across, across, axial])
    inertia -= _moved(mass, neck - together) + _moved(rest, head - together)
    return (
        Solid(mass, _vector(neck), (across, across, axial, 0.0, 0.0, 0.0)),
        Solid(rest, _vector(head - shift), six_of(inertia)),
    )


def _moved(mass: float, offset: Array) -> Array:
    """Return the increase of an inertia for a mass offset from the reference point, shape (3, 3) [kg m^2]."""
    return np.asarray(mass * (offset @ offset * np.eye(3) - np.outer(offset, offset)))


def _vector(values: Array) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
