"""Visibility: geoms outside the view of a camera, or behind walls, are not rendered.

In a world of many rooms a camera sees few of them. From below the top of a wall that stands on the floor, nothing
behind it is visible unless it is higher. A plan is therefore sufficient: one depth per column of the picture, that of
the nearest wall; whatever is farther in all its columns is hidden. A level camera sees along each column in one
direction of the plan, so no pixel changes.

The rest is sorted: if near things are rendered first, hidden surfaces behind them are neither lit nor textured.

References:
    Teller, Sequin, Visibility preprocessing for interactive walkthroughs, SIGGRAPH 1991: walls of buildings as
    occluders; here they are drawn into a buffer of one row, as Greene, Kass, Miller, Hierarchical Z-buffer visibility,
    SIGGRAPH 1993, draw into one of many.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import WALL_DETAILS, rgba_of, wall_lines
from mjsim.geometry import Array
from mjsim.sim.rendering.geom_boxes import GeomBoxes
from mjsim.sim.rendering.scene_geoms import as_bytes, geoms_of, same_layout


@dataclass(frozen=True, slots=True, eq=False)
class Frustum:
    """Pose and field of view of a camera; world frame."""

    eye: Array
    """Shape (3,) [m]."""
    ahead: Array
    """Along the optical axis, shape (3,)."""
    up: Array
    """Shape (3,)."""
    right: Array
    """Shape (3,)."""
    half_width: float
    """Tangent of half the horizontal field of view."""
    half_height: float
    """Tangent of half the vertical field of view."""
    columns: int
    """Columns of the picture [px]."""

    def beside(self, offsets: Array, radii: Array) -> NDArray[np.bool_]:
        """Return which balls lie wholly beside or behind the view, given their centres from the eye, shape (n, 3)."""
        right, up, ahead = offsets @ self.right, offsets @ self.up, offsets @ self.ahead
        wide, high = self.half_width, self.half_height
        beside = np.abs(right) - wide * ahead > radii * np.hypot(1.0, wide)
        beside |= np.abs(up) - high * ahead > radii * np.hypot(1.0, high)
        beside |= ahead < -radii
        return np.asarray(beside)


def frustum_of(scene: mujoco.MjvScene, *, width: int, height: int) -> Frustum:
    """Return the view of a scene whose camera is up to date, for pictures of a size [px]."""
    first, second = scene.camera[0], scene.camera[1]
    ahead, up = np.array(first.forward, dtype=float), np.array(first.up, dtype=float)
    half_height = float(first.frustum_top / first.frustum_near)
    return Frustum(
        eye=(np.asarray(first.pos, dtype=float) + second.pos) / 2,
        ahead=ahead,
        up=up,
        right=np.array(
            [
                ahead[1] * up[2] - ahead[2] * up[1],
                ahead[2] * up[0] - ahead[0] * up[2],
                ahead[0] * up[1] - ahead[1] * up[0],
            ]
        ),
        half_width=half_height * width / height,
        half_height=half_height,
        columns=width,
    )


class InView:
    """Finds the geoms that a camera may see; constant values are computed once."""

    def __init__(self, model: mujoco.MjModel, drawn: NDArray[np.intp]) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            drawn: Geoms that are drawn at all.
        """
        self._drawn = drawn
        self.clear = np.array([geom for geom in drawn.tolist() if rgba_of(model, geom)[3] < 1.0], dtype=np.intp)
        """Those that are transparent."""
        self._planes = np.asarray(model.geom_type[drawn] == mujoco.mjtGeom.mjGEOM_PLANE)
        sizes = model.geom_size[drawn]
        # Radius of a sphere around each [m]; a plane without sizes is infinite.
        flat = np.where(sizes[:, :2].min(axis=1, initial=np.inf) > 0.0, np.hypot(sizes[:, 0], sizes[:, 1]), np.inf)
        self._radii = np.where(self._planes, flat, model.geom_rbound[drawn])
        self._boxes = GeomBoxes(model, drawn)
        self._on_walls = np.array([str(model.geom(geom).name).startswith(WALL_DETAILS) for geom in drawn], dtype=bool)
        self._places = np.zeros(model.ngeom, dtype=np.intp)
        self._places[drawn] = np.arange(len(drawn))
        self._sortable: bool | None = None
        self._hiding = Hiding(model)

    def sort(self, scene: mujoco.MjvScene, view: Frustum) -> None:
        """Sort the geoms of a scene: those in front first, level ones such as floors and ceilings last.

        Args:
            scene: Scene in the state of the last call of `unseen`.
            view: Its view.
        """
        if self._sortable is None and scene.ngeom > 1:
            self._sortable = same_layout(scene)
        if not self._sortable:
            return
        geoms = geoms_of(scene)[: scene.ngeom]
        own = np.flatnonzero(geoms["objtype"] == mujoco.mjtObj.mjOBJ_GEOM)
        order = np.zeros(scene.ngeom)
        order[own] = self._from_front(self._places[geoms["objid"][own]], view.eye)
        rows = as_bytes(geoms)
        rows[:] = rows[np.argsort(order, kind="stable")]

    def _from_front(self, chosen: NDArray[np.intp], eye: Array) -> Array:
        """Return a number for each of some geoms, given by their places among the drawn ones: smaller if in front.

        That is its distance. If the eye is within the box around a geom, such as the walls of a room, things within
        that box are in front of it, and everything else behind it.
        """
        low, high = (each[chosen] for each in self._boxes.last)
        order = np.linalg.norm(np.clip(eye, low, high) - eye, axis=1)
        level = ((high - low < LEVEL_HEIGHT) == (False, False, True)).all(axis=1)
        around, on_walls = (order == 0.0) & ~level, self._on_walls[chosen]
        rooms = np.flatnonzero(around & ~on_walls)
        within = (low >= low[rooms, None] - WALL_DEPTH) & (high <= high[rooms, None] + WALL_DEPTH)
        order += FAR * np.count_nonzero(~within.all(axis=2), axis=0)
        order[rooms] += FAR / 2
        order[around & on_walls] = 0.0
        order[level] += LAST
        return np.asarray(order)

    def unseen(self, data: mujoco.MjData, view: Frustum) -> NDArray[np.intp]:
        """Return the drawn geoms that lie wholly outside the view or behind walls, or only show their back."""
        offsets = data.geom_xpos[self._drawn] - view.eye
        normals = data.geom_xmat[self._drawn, 2::3]
        unseen = self._planes & (np.einsum("ij,ij->i", offsets, normals) > 0.0)
        unseen |= view.beside(offsets, self._radii)
        low, high = self._boxes.update(data)
        self._hiding.add_to(unseen, low, high, view)
        return np.asarray(self._drawn[unseen])


MIN_GEOMS = 16
"""With fewer geoms in front of a camera, drawing them is faster than this test."""
MAX_WALLS = 100
"""Maximum number of walls tested, the nearest ones in all directions."""
MAX_LEVEL_RISE = 0.02
"""A camera whose axes rise by more than this sees several directions along one column."""
NEAR_PLANE = 0.01
"""Points closer in front of the eye than this count as behind it [m]."""
HEIGHT_TOLERANCE = 1e-4
"""Tolerance on heights, because meshes are stored in single precision [m]."""
WALL_EXTENSION = 1e-9
"""Extension of a wall beyond its ends in the picture, so that no column falls between two adjoining walls [m at 1 m].
"""
LEVEL_HEIGHT, LAST = 0.4, 1e12
"""Maximum height of a level geom, which is longer and wider [m], and offset added to its distance [m]."""
FAR, WALL_DEPTH = 1e6, 0.3
"""Offset added to the distance of geoms behind a room, and how far things on its walls extend outside it [m]."""


class Hiding:
    """Determines which geoms are hidden by walls."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Find the occluding walls, all as high as most walls are."""
        lines = wall_lines(model)
        self._top = _usual_top(lines)
        hides = lines[lines[:, 4] >= self._top]
        self._x, self._y, self._x_end, self._y_end = np.ascontiguousarray(hides[:, :4].T)
        self._middle = np.stack([(self._x + self._x_end) / 2, (self._y + self._y_end) / 2])
        self._reach = ((self._x_end - self._x) ** 2 + (self._y_end - self._y) ** 2) / 4

    def add_to(self, unseen: NDArray[np.bool_], low: Array, high: Array, camera: Frustum) -> None:
        """Mark hidden geoms.

        Args:
            unseen: For each drawn geom whether it is known to be invisible, shape (n,); modified.
            low: Minimum corners of their boxes, world frame, shape (n, 3) [m].
            high: Maximum corners, shape (n, 3) [m].
            camera: The view.
        """
        eye, ahead, right = camera.eye, camera.ahead, camera.right
        half_width, columns = camera.half_width, camera.columns
        if eye[2] >= self._top or abs(ahead[2]) > MAX_LEVEL_RISE or abs(right[2]) > MAX_LEVEL_RISE:
            return
        candidates = np.flatnonzero(~unseen & (high[:, 2] <= self._top + HEIGHT_TOLERANCE))
        if len(candidates) < MIN_GEOMS:
            return
        view = np.stack([right[:2] / np.hypot(*right[:2]), ahead[:2] / np.hypot(*ahead[:2])])
        (x, y, _), (x_far, y_far, _) = (low[candidates] - eye).T, (high[candidates] - eye).T
        x, y = np.stack([x, x, x_far, x_far], axis=1), np.stack([y, y_far, y, y_far], axis=1)
        lateral, far = view[0, 0] * x + view[0, 1] * y, view[1, 0] * x + view[1, 1] * y
        nearest = far.min(axis=1)
        before = nearest > NEAR_PLANE
        candidates, nearest = candidates[before], nearest[before]
        columns_at = (lateral[before] / far[before]) / half_width
        # One more column on each side, against rounding.
        first = np.clip(np.floor((columns_at.min(axis=1) + 1.0) * (columns / 2) - 0.5).astype(int), 0, columns - 1)
        last = np.clip(np.ceil((columns_at.max(axis=1) + 1.0) * (columns / 2) - 0.5).astype(int), 0, columns - 1)
        walls = np.append(self._nearness(view, eye[:2], half_width, columns), 0.0)
        least = np.minimum.reduceat(walls, np.stack([first, last + 1], axis=1).ravel())[::2] if len(first) else nearest
        unseen[candidates[least > 1.0 / nearest]] = True

    def _nearness(self, view: Array, eye: Array, half_width: float, columns: int) -> Array:
        """Return 1 / depth of the nearest occluding wall in each column, 0 without one, shape (columns,) [1/m]."""
        x, z, x_end, z_end = self._nearest(view, eye)
        x, z = _clipped(x, z, x_end, z_end)
        x_end, z_end = _clipped(x_end, z_end, x, z)
        tangent, tangent_end = x / z, x_end / z_end
        in_view = (np.maximum(tangent, tangent_end) > -half_width) & (np.minimum(tangent, tangent_end) < half_width)
        in_view &= np.abs(tangent - tangent_end) > WALL_EXTENSION
        tangent, tangent_end, inverse, inverse_end = (
            tangent[in_view],
            tangent_end[in_view],
            1.0 / z[in_view],
            1.0 / z_end[in_view],
        )
        at = ((np.arange(columns) + 0.5) * (2.0 / columns) - 1.0) * half_width
        # The inverse depth of a straight wall is linear across a picture.
        slope = (inverse_end - inverse) / (tangent_end - tangent)
        nearness = np.outer(slope, at)
        nearness += (inverse - slope * tangent)[:, None]
        nearness[at < np.minimum(tangent, tangent_end)[:, None] - WALL_EXTENSION] = 0.0
        nearness[at > np.maximum(tangent, tangent_end)[:, None] + WALL_EXTENSION] = 0.0
        return np.asarray(nearness.max(axis=0, initial=0.0), dtype=float)

    def _nearest(self, view: Array, eye: Array) -> tuple[Array, Array, Array, Array]:
        """Return the nearest walls that are not behind the eye: right and ahead coordinates of both ends [m]."""
        x, y, x_end, y_end = self._x, self._y, self._x_end, self._y_end
        if len(x) > MAX_WALLS:
            far = (self._middle[0] - eye[0]) ** 2 + (self._middle[1] - eye[1]) ** 2 - self._reach
            nearest = np.argpartition(far, MAX_WALLS)[:MAX_WALLS]
            x, y, x_end, y_end = x[nearest], y[nearest], x_end[nearest], y_end[nearest]
        lateral, far = view @ np.stack([x - eye[0], y - eye[1]])
        lateral_end, far_end = view @ np.stack([x_end - eye[0], y_end - eye[1]])
        before = np.maximum(far, far_end) > NEAR_PLANE
        return lateral[before], far[before], lateral_end[before], far_end[before]


def _clipped(x: Array, z: Array, x_end: Array, z_end: Array) -> tuple[Array, Array]:
    """Return the starts of lines; those behind the eye are moved along the line to just in front of it."""
    share = np.where(z < NEAR_PLANE, (NEAR_PLANE - z) / np.where(z_end == z, 1.0, z_end - z), 0.0)
    return x + share * (x_end - x), np.maximum(z, NEAR_PLANE)


def _usual_top(lines: Array) -> float:
    """Return the height of most walls, weighted by length [m]; below the floor if there are none."""
    if not len(lines):
        return -1.0
    tops, which = np.unique(lines[:, 4], return_inverse=True)
    lengths = np.hypot(*(lines[:, 2:4] - lines[:, :2]).T)
    return float(tops[int(np.argmax(np.bincount(which.ravel(), weights=lengths)))])
