"""Contact shadows: how much ambient light each moving object blocks from the floor around it.

The shadow of an object is a small picture that moves and turns with it, computed once from its shape at the start: for
each of many directions of light, the union of the outlines of its parts is projected on the floor.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import triangles_of
from mjsim.geometry import Array
from mjsim.light import DOOR, GAMMA
from mjsim.sim.rendering.in_view import Frustum
from mjsim.sim.rendering.merged_geoms import moving_bodies

SHADOW_SIDE = 64
"""Pixels along a side of a shadow."""
SHADOW_MARGIN = 0.45
"""Width of a shadow beyond the outline of the thing from above [m]."""
FADE_PIXELS = 8
"""Pixels along the border of a shadow over which it fades away."""
RINGS, SPOKES = 8, 12
"""Directions of light: rings of equal irradiance, from the zenith to the horizon, and their parts."""
FRACTION_BITS = 4
"""Fractional bits of coordinates of outlines [px]."""
MAX_OUTLINE_DISTANCE = 1000.0
"""Outlines are cut off at this distance [px]."""
MAX_LIFT = 0.4
"""Height above its initial one at which a thing no longer has a shadow [m]."""
CELLS_PER_SIDE, MAX_CORNERS = 10, 200
"""Shapes of more corners than this are simplified to cells, this many along their longest side."""
MIN_FREE_DOFS = 2
"""A body with at least this many degrees of freedom shares one shadow with all that is attached to it."""


@dataclass(frozen=True, slots=True, eq=False)
class Shadow:
    """The shadow of one thing."""

    body: int
    """Body that it moves with."""
    geom: int
    """One of the geoms that cast it; the shadow is drawn only while this one is."""
    low: Array
    """Its corner, relative to the body's origin and heading, shape (2,) [m]."""
    size: Array
    """Its sides, shape (2,) [m]."""
    height: float
    """Height of the body at the start [m]."""
    opacity: NDArray[np.uint8]
    """Share of the light that it blocks, encoded, shape (SHADOW_SIDE, SHADOW_SIDE); rows along y, columns along x."""


def shadows_of(model: mujoco.MjModel, geoms: NDArray[np.intp]) -> list[Shadow]:
    """Return the shadows of moving things.

    Args:
        model: The compiled world.
        geoms: Visible geoms that cast them; those that never move are left out.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    carriers = _carriers(model)
    parts: dict[int, dict[int, Array]] = defaultdict(dict)
    for geom in geoms.tolist():
        carrier = int(carriers[model.geom_bodyid[geom]])
        # The ambient light already includes the leaves of doors.
        if model.body(carrier).name.startswith(DOOR):
            continue
        if carrier > 0 and (points := _points(model, data, geom)) is not None:
            parts[carrier][geom] = points
    known: dict[bytes, NDArray[np.uint8]] = {}
    return [_shadow(data, body, shapes, known) for body, shapes in parts.items()]


class PlacedShadows:
    """Places shadows on the floor; constant values are computed once."""

    def __init__(self, shadows: Sequence[Shadow]) -> None:
        """Store the shadows."""
        self._bodies = np.array([shadow.body for shadow in shadows])
        self._heights = np.array([shadow.height for shadow in shadows])
        unit = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        at = np.array([shadow.low + unit * shadow.size for shadow in shadows])
        self._at = at.reshape(-1, 4, 2) @ [1.0, 1.0j]
        self._radii = np.abs(self._at).max(axis=1)

    def strengths(self, data: mujoco.MjData, view: Frustum) -> Array:
        """Return how strong each shadow is, 0 for one that is out of view, shape (n,)."""
        position = data.xpos[self._bodies]
        lifted = position[:, 2] - self._heights
        position[:, 2] = 0.0
        strengths = np.clip(1.0 - lifted / MAX_LIFT, 0.0, 1.0)
        strengths[view.beside(position - view.eye, self._radii)] = 0.0
        return np.asarray(strengths)

    def corners(self, data: mujoco.MjData, chosen: NDArray[np.intp]) -> NDArray[np.complex128]:
        """Return the corners of some shadows, counter-clockwise, as x + y i in the world frame, shape (n, 4) [m]."""
        bodies = self._bodies[chosen]
        axes = data.xmat[bodies][:, [0, 3]] @ [1.0, 1.0j]
        axes /= np.maximum(np.abs(axes), 1e-9)
        middles = data.xpos[bodies, :2] @ [1.0, 1.0j]
        return np.asarray(middles[:, None] + axes[:, None] * self._at[chosen])


def _carriers(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return for each body the body that its shadow moves with, 0 for none, shape (nbody,)."""
    moving = moving_bodies(model)
    found = moving.copy()
    for body in range(1, model.nbody):
        above = int(found[model.body_parentid[body]])
        free = above > 0 and (model.body_dofnum[above] >= MIN_FREE_DOFS or model.body_mocapid[above] >= 0)
        found[body] = above if free else moving[body]
    return found


def _points(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Array | None:
    """Return corners whose convex hull stands for a geom, world frame, shape (n, 3) [m]."""
    shape = triangles_of(model, geom)
    if shape is None or not len(shape.points):
        return None
    points = shape.points
    if len(points) > MAX_CORNERS:
        cell = max(float(np.ptp(points, axis=0).max()) / CELLS_PER_SIDE, 1e-6)
        points = points[np.unique(np.round(points / cell), axis=0, return_index=True)[1]]
    return np.asarray(points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])


def _shadow(
    data: mujoco.MjData, body: int, shapes: Mapping[int, Array], known: dict[bytes, NDArray[np.uint8]]
) -> Shadow:
    """Return the shadow of geoms, each given by points in the world.

    Args:
        data: The state in which the points are given.
        body: Body that they move with.
        shapes: Points of each geom, shape (n, 3) [m].
        known: Opacity by shape, for things of the same shape; added to.
    """
    x_axis = data.xmat[body].reshape(3, 3)[:2, 0]
    x_axis = x_axis / max(float(np.linalg.norm(x_axis)), 1e-9)
    body_from_world = np.array([x_axis, [-x_axis[1], x_axis[0]]])
    parts = [
        np.column_stack([(points[:, :2] - data.xpos[body, :2]) @ body_from_world.T, np.maximum(points[:, 2], 0.0)])
        for points in shapes.values()
    ]
    every = np.concatenate(parts)[:, :2]
    low, high = every.min(axis=0) - SHADOW_MARGIN, every.max(axis=0) + SHADOW_MARGIN
    shape = b"".join(np.round(part - [*low, 0.0], 4).tobytes() for part in parts)
    if shape not in known:
        known[shape] = _opacity(parts, low, (high - low) / SHADOW_SIDE)
    return Shadow(body, next(iter(shapes)), low, high - low, float(data.xpos[body, 2]), known[shape])


def _opacity(parts: list[Array], low: Array, pixel: Array) -> NDArray[np.uint8]:
    """Return how much light the parts block from each pixel, encoded, shape (SHADOW_SIDE, SHADOW_SIDE)."""
    covered, mask = np.zeros((SHADOW_SIDE, SHADOW_SIDE)), np.empty((SHADOW_SIDE, SHADOW_SIDE), dtype=np.uint8)
    for slope in _slopes():
        mask[:] = 0
        for points in parts:
            flat = (points[:, :2] - points[:, 2:] * slope - low) / pixel - 0.5
            hull = cv2.convexHull(np.clip(flat, -MAX_OUTLINE_DISTANCE, MAX_OUTLINE_DISTANCE).astype(np.float32))
            cv2.fillConvexPoly(mask, np.rint(hull * (1 << FRACTION_BITS)).astype(np.int32), 1, shift=FRACTION_BITS)
        covered += mask
    taken = 1.0 - (1.0 - covered / (RINGS * SPOKES)) ** (1.0 / GAMMA)
    smooth = np.asarray(cv2.GaussianBlur(taken, (0, 0), 1.0), dtype=float)
    edge = np.minimum(np.arange(SHADOW_SIDE), np.arange(SHADOW_SIDE)[::-1]) / FADE_PIXELS
    smooth *= np.clip(np.minimum.outer(edge, edge), 0.0, 1.0)
    return np.rint(smooth * 255.0).astype(np.uint8)


def _slopes() -> Array:
    """Return the sideways distance per height of light from directions with equal irradiance, shape (n, 2)."""
    ring, spoke = np.meshgrid(np.arange(RINGS), np.arange(SPOKES), indexing="ij")
    # The irradiance on the floor is proportional to the area of the hemisphere projected onto it.
    sine = np.sqrt((ring + 0.5) / RINGS)
    angle = 2.0 * np.pi * (spoke + 0.5 * (ring % 2)) / SPOKES
    tangent = sine / np.sqrt(1.0 - sine**2)
    return np.asarray(np.column_stack([(tangent * np.cos(angle)).ravel(), (tangent * np.sin(angle)).ravel()]))
