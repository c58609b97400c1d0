"""Area of the floor that the footprint of a robot has swept."""

import math
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.report.coverage import reachable_region
from mjsim.world import Robot, World

CELL_SIDE, MAX_CELLS = 0.01, 4_000_000
"""Side of a cell of the raster [m], and its maximum number of cells, above which cells are larger."""
STEP, TURN = 0.02, math.radians(3.0)
"""Poses that are nearer than this to the one before are left out [m, rad]; the area between two is swept too."""
FRACTION_BITS = 8
"""Bits of a fraction of a cell in the drawing of polygons."""


def swept_share(world: World, robot: Robot, poses: Array) -> float | None:
    """Return the share of the reachable area that the robot's footprint has swept.

    Args:
        world: Its world.
        robot: The robot.
        poses: x, y, heading of the robot over time, shape (N, 3) [m, rad]; the first is its start.

    Returns:
        In [0, 1]; None in a world without walls. The reachable area is where the robot can drive from its start with
        its centre and a margin of 0.15 m; `coverage` counts cells of 0.5 m of it that the footprint has touched.
    """
    import cv2
    import shapely

    region = reachable_region(world, poses[:, :2], radius=robot.body.radius)
    if region is None or not region.area:
        return None
    west, south, east, north = region.bounds
    cell = max(CELL_SIDE, math.sqrt((east - west) * (north - south) / MAX_CELLS))
    shape = (math.ceil((north - south) / cell), math.ceil((east - west) / cell))
    reachable, swept = np.zeros(shape, dtype=np.uint8), np.zeros(shape, dtype=np.uint8)

    def pixels(points: Any) -> Any:
        # The centre of the first cell is at half a cell.
        return np.round(((points - (west, south)) / cell - 0.5) * 2**FRACTION_BITS).astype(np.int32)

    for part in shapely.get_parts(region.buffer(-cell / 2)):
        cv2.fillPoly(reachable, [pixels(np.array(part.exterior.coords))], 1, shift=FRACTION_BITS)
        for hole in part.interiors:
            cv2.fillPoly(reachable, [pixels(np.array(hole.coords))], 0, shift=FRACTION_BITS)
    # OpenCV also fills the cells that a polygon's outline touches, half a cell too much.
    outline = shapely.Polygon(robot.body.outline()).buffer(-cell / 2, join_style="mitre").exterior.coords
    corners = [_placed(np.array(outline), pose) for pose in _thinned(poses)]
    for before, after in zip(corners, corners[1:] or corners, strict=False):
        hull = cv2.convexHull(np.concatenate([before, after]).astype(np.float32))[:, 0]
        cv2.fillConvexPoly(swept, pixels(hull), 1, shift=FRACTION_BITS)
    return float((swept & reachable).sum() / reachable.sum()) if reachable.any() else None


def _thinned(poses: Array) -> Array:
    """Return poses without those that hardly differ from the one before."""
    kept = [0]
    for number, (x, y, heading) in enumerate(poses):
        x0, y0, heading0 = poses[kept[-1]]
        if math.hypot(x - x0, y - y0) > STEP or abs(heading - heading0) > TURN:
            kept.append(number)
    return poses[[*kept, len(poses) - 1]]


def _placed(outline: Array, pose: Array) -> Array:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.asarray(outline @ np.array([[c, s], [-s, c]]) + pose[:2])
