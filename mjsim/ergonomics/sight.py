"""The visible part of a display for both eyes, and what hides the rest."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.people import SIDES, Figure
from mjsim.posture import SIGHT
from mjsim.world import DisplayTarget, PlacedTarget

FIELD: Mapping[str, float] = {"temporal": 100.0, "nasal": 60.0, "up": 60.0, "down": 75.0}
"""Extent of the visual field of a stationary eye from its line of sight [deg]: Spector, Visual Fields, in Clinical
Methods (3rd edition, 1990), chapter 116. Between these directions the edge is taken as a quarter of an ellipse."""
MIN_DISPLAY_ANGLE = 45.0
"""Minimum angle between the line of sight and the face of a display [deg]: NUREG-0700 rev. 3, 11.2.1.1-5."""
SEEN = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)
"""Visible geom groups."""
SURFACE_TOLERANCE = 0.005
"""Tolerance for the position of a display on the surface of its object [m]."""
RAY_COUNT = 1000
"""Approximate number of rays from an eye to a display."""
VISIBLE, BEYOND, BEHIND = -1, -2, -3
"""Codes in place of the geom that hides a point: none does, it is outside the field, or the display faces away."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Eye:
    """An eye and its line of sight."""

    side: str
    place: Array
    """Position of the pupil, world frame, shape (3,) [m]."""
    axes: Array
    """world_from_eye, x along the line of sight, y left, shape (3, 3)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DisplayView:
    """The visible part of a display."""

    shares: Mapping[str, float]
    """Visible fraction for the 'left' and 'right' eye, for 'both' at once, and for 'either'."""
    hidden_by: Mapping[str, float]
    """Fraction that neither eye sees, by what hides it from each eye, half and half; 'outside the field' and 'facing
    away' are possible causes. Their sum is 1 minus the fraction of 'either'."""
    distance: float
    """Distance from the midpoint of the eyes to the centre of the display [m]."""
    incidence_deg: float
    """Angle between the line to its centre and its face; 90 is perpendicular [deg]."""


def eyes_of(figure: Figure, poses: Mapping[str, Array], *, gaze: Array | None = None) -> tuple[Eye, Eye]:
    """Return both eyes.

    Args:
        figure: The body.
        poses: world_from_segment by the segment's name, shape (4, 4) each [m].
        gaze: Point at which they look, world frame, shape (3,) [m]; by default along the normal line of sight.
    """
    spots, head = figure.spots(poses), poses["head"][:3, :3]
    found = []
    for side in SIDES:
        place = spots[f"{side}_eye"]
        ahead = head @ SIGHT if gaze is None else (gaze - place) / np.linalg.norm(gaze - place)
        left = np.cross(head[:, 2], ahead)
        left /= np.linalg.norm(left)
        axes = np.column_stack([ahead, left, np.cross(ahead, left)])
        found.append(Eye(side=side, place=place, axes=axes))
    return found[0], found[1]


def in_field(eye: Eye, points: Array) -> NDArray[np.bool_]:
    """Return which points are in the field of an eye, shape (n,); points are in the world frame, shape (n, 3) [m]."""
    x, y, z = ((points - eye.place) @ eye.axes).T
    away = np.degrees(np.arctan2(np.hypot(y, z), x))
    across = np.maximum(np.hypot(y, z), 1e-12)
    outward = y if eye.side == "left" else -y
    wide = np.where(outward > 0.0, FIELD["temporal"], FIELD["nasal"])
    high = np.where(z > 0.0, FIELD["up"], FIELD["down"])
    return np.asarray((away * outward / across / wide) ** 2 + (away * z / across / high) ** 2 <= 1.0)


def points_on(display: PlacedTarget, *, count: int = RAY_COUNT) -> Array:
    """Return about `count` evenly spaced points of a display, world frame, shape (n, 3) [m]."""
    assert isinstance(display.target, DisplayTarget)
    width, height = display.target.size
    columns = max(1, round(math.sqrt(count * width / height)))
    rows = max(1, round(count / columns))
    across = (np.arange(columns) + 0.5) / columns - 0.5
    up = (np.arange(rows) + 0.5) / rows - 0.5
    y, z = (each.ravel() for each in np.meshgrid(across * width, up * height))
    pose = display.world_from_target
    return np.asarray(np.column_stack([np.zeros_like(y), y, z]) @ pose[:3, :3].T + pose[:3, 3])


def hiders(
    model: mujoco.MjModel, data: mujoco.MjData, eye: Eye, points: Array, facing: Array, *, head: int
) -> NDArray[np.int64]:
    """Return what hides points from an eye: a geom, `VISIBLE`, `BEYOND` or `BEHIND`, shape (n,).

    Args:
        model: The compiled world.
        data: Its state after `mj_kinematics`.
        eye: The eye.
        points: World frame, shape (n, 3) [m].
        facing: Normal of the display that contains them, world frame, shape (3,).
        head: The body that contains the eye; it hides nothing beyond the limits of the visual field.
    """
    found = np.where(in_field(eye, points), VISIBLE, BEYOND)
    found[(eye.place - points) @ facing <= 0.0] = BEHIND
    for number in np.flatnonzero(found == VISIBLE):
        found[number] = first_between(model, data, eye.place, points[number], without=head)
    return found


def first_between(model: mujoco.MjModel, data: mujoco.MjData, start: Array, end: Array, *, without: int) -> int:
    """Return the first geom on the line between two points of the world; `VISIBLE` if there is none."""
    direction = end - start
    length = float(np.linalg.norm(direction))
    geom = np.full(1, -1, dtype=np.int32)
    distance = mujoco.mj_ray(model, data, start, direction / length, SEEN, True, without, geom, None)
    return int(geom[0]) if 0.0 <= distance < length - SURFACE_TOLERANCE else VISIBLE


def view_of(
    model: mujoco.MjModel, data: mujoco.MjData, eyes: tuple[Eye, Eye], display: PlacedTarget, *, head: int
) -> DisplayView:
    """Return the visible part of a display for both eyes; arguments as for `hiders`."""
    points, facing = points_on(display), display.world_from_target[:3, 0]
    by_eye = [hiders(model, data, eye, points, facing, head=head) for eye in eyes]
    left, right = (each == VISIBLE for each in by_eye)
    shares = {"left": left, "right": right, "both": left & right, "either": left | right}
    neither = ~(left | right)
    names = Counter(name_of(model, geom) for each in by_eye for geom in each[neither].tolist())
    offset = display.world_from_target[:3, 3] - (eyes[0].place + eyes[1].place) / 2
    distance = float(np.linalg.norm(offset))
    return DisplayView(
        shares={name: float(seen.mean()) for name, seen in shares.items()},
        hidden_by={name: count / (2 * len(points)) for name, count in names.most_common()},
        distance=distance,
        incidence_deg=math.degrees(math.asin(float(np.clip(-offset @ facing / distance, -1.0, 1.0)))),
    )


def name_of(model: mujoco.MjModel, geom: int) -> str:
    """Return the name of the owner of a geom: the name of an object, or PERSON/SEGMENT."""
    if geom in (BEYOND, BEHIND):
        return "outside the field" if geom == BEYOND else "facing away"
    name, body = str(model.geom(geom).name), str(model.body(int(model.geom_bodyid[geom])).name)
    # Additional parts of a segment are named SEGMENT-2 and so on.
    whole = body if not name or name.startswith(f"{body}-") else name
    return whole.removeprefix("obstacle/") or "an unnamed part"
