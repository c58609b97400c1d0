"""Masses, centres of mass and inertias of the segments of a body, from de Leva's tables."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Solid, six_of, tensor
from mjsim.people.deleva import PAIRED, share_of
from mjsim.people.figure_frame import BodyFrame, Vector3
from mjsim.people.measures import Measures

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
