"""Lens distortion: a precomputed table with the position of each pixel in undistorted pictures.

A planar picture grows with the tangent of the angle, and most pixels of a wide one map to few pixels of the lens. A
wide lens therefore looks at several planes, each turned to its part of the view.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Intrinsics, Picture
from mjsim.mechanics import rotation_of
from mjsim.world import Camera, Lens

MAX_TANGENT = math.tan(math.radians(80.0))
"""Pixels farther from the axis are black, as outside the circle of a fisheye."""
MAX_SIDE = 3072
"""Maximum side of an undistorted picture [px]."""
TILTS_DEG = (25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 60.0)
"""Angles between the axes of a lens and of a plane that are tried."""
FIXED_COST_PIXELS = 100_000
"""Number of pixels that take as long as the constant part of a picture: a third of 640 x 480."""
RAY_STRIDE = 17
"""Every n-th ray is used to choose the planes."""


def intrinsics_of(camera: Camera) -> Intrinsics:
    """Return the calibration of a camera with square pixels and the principal point at the centre of the picture.

    Pixel centres are at integers, so the centre is at (width - 1) / 2.
    """
    lens = camera.lens
    kind: str = "pinhole"
    distortion: tuple[float, ...] = ()
    if lens is not None:
        kind, distortion = ("fisheye", lens.fisheye) if lens.fisheye is not None else ("brown", lens.brown or ())
    return Intrinsics(
        width=camera.width,
        height=camera.height,
        fx=camera.focal,
        fy=camera.focal,
        cx=(camera.width - 1) / 2,
        cy=(camera.height - 1) / 2,
        lens=kind,
        distortion=distortion,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Planes:
    """Where rays meet planes at distance 1, each ray the plane whose axis is nearest."""

    turned: tuple[Array, ...]
    """Axes (x right, y down, z ahead) of each plane in the optical frame, columns, shape (3, 3)."""
    which: NDArray[np.intp]
    """Index of the plane of each ray, shape (n,)."""
    points: Array
    """Position of each ray on it, shape (n, 2), as the tangent of the angle from its axis."""
    ahead: Array
    """Distance along the axis of the plane for one along that of the lens, shape (n,)."""

    @property
    def half(self) -> Array:
        """Half the sides of a plane that holds all points, shape (2,)."""
        return np.asarray(np.abs(self.points).max(axis=0, initial=0.1))


def _planes(turned: Sequence[Array], rays: Array) -> _Planes:
    """Return where rays, shape (n, 3) with z = 1, meet planes."""
    which = np.argmax(rays @ np.stack([axes[:, 2] for axes in turned], axis=1), axis=1)
    places = np.einsum("ni,nij->nj", rays, np.stack(turned)[which])
    return _Planes(tuple(turned), which, places[:, :2] / places[:, 2:], places[:, 2])


def _layouts() -> Iterator[Sequence[Array]]:
    """Yield sets of planes: one, then two and three beside and above each other, and five."""
    ahead = np.eye(3)
    yield [ahead]
    for tilt in np.radians(TILTS_DEG):
        aside, upright = ([rotation_of(sign * tilt * axis) for sign in (-1.0, 1.0)] for axis in (ahead[1], ahead[0]))
        yield from (aside, [*aside, ahead], upright, [*upright, ahead], [*aside, *upright, ahead])


def _cheapest(rays: Array, focal: float) -> _Planes:
    """Return the planes that are drawn fastest for a focal length [px]."""

    def cost(turned: Sequence[Array]) -> float:
        found = _planes(turned, rays[::RAY_STRIDE])
        sides = 2.0 * focal * found.half
        return (
            len(turned) * (FIXED_COST_PIXELS + float(sides.prod())) if found.ahead.min(initial=1.0) > 0.0 else math.inf
        )

    return _planes(min(_layouts(), key=cost), rays)


class BentView:
    """The undistorted pictures for a camera with a lens, all of one size, and their distortion."""

    def __init__(self, intrinsics: Intrinsics, lens: Lens) -> None:
        """Compute the table.

        Args:
            intrinsics: Calibration of the camera.
            lens: Its lens.
        """
        v, u = np.mgrid[: intrinsics.height, : intrinsics.width].reshape(2, -1)
        bent = np.stack([(u - intrinsics.cx) / intrinsics.fx, (v - intrinsics.cy) / intrinsics.fy], axis=-1)
        straight = lens.straighten(bent)
        seen = np.abs(straight).max(axis=1) <= MAX_TANGENT  # NaN compares as false.
        planes = _cheapest(np.column_stack([straight[seen], np.ones(seen.sum())]), intrinsics.fx)
        # As fine as the camera's own pixels at the centre, unless that is too large.
        focal = min(intrinsics.fx, MAX_SIDE / 2 / float(planes.half.max()) - 1.0)
        self.width, self.height = (2 * math.ceil(focal * float(side)) + 2 for side in planes.half)
        """Size of an undistorted picture [px]."""
        self.fov_y_deg = math.degrees(2 * math.atan(self.height / 2 / focal))
        """Vertical field of view of an undistorted picture [deg]."""
        self.turned = planes.turned
        """Axes (x right, y down, z ahead) of each picture in the optical frame, columns, shape (3, 3)."""
        shape = intrinsics.height, intrinsics.width
        places = np.full((len(seen), 2), -10.0)
        places[seen] = planes.points * focal + [(self.width - 1) / 2, (self.height - 1) / 2]
        places[seen, 1] += planes.which * self.height
        x, y = places.astype(np.float32).reshape(*shape, 2).transpose(2, 0, 1)
        self._places = np.ascontiguousarray(x), np.ascontiguousarray(y)
        self._seen = seen.reshape(shape)
        self._nearest = tuple(np.rint(np.where(seen, each, 0.0)).astype(int).reshape(shape) for each in places.T)
        self._ahead = np.ones(shape)
        self._ahead[self._seen] = planes.ahead

    def bend(self, pictures: Picture) -> Picture:
        """Return the distorted picture; black where the lens sees nothing.

        Args:
            pictures: The undistorted ones, one below the other.
        """
        bent = cv2.remap(pictures, *self._places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
        return np.asarray(bent, dtype=np.uint8)

    def bend_depth(self, depths: Array) -> Array:
        """Return the distorted depth, taken from the nearest pixel; +inf where the lens sees nothing."""
        x, y = self._nearest
        return np.where(self._seen, depths[y, x] / self._ahead, np.inf)

    def bend_instances(self, instances: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the distorted instances, taken from the nearest pixel; -1 where the lens sees nothing."""
        x, y = self._nearest
        return np.where(self._seen, instances[y, x], np.int32(-1))
