"""Maps as robots make them: turned, with frayed walls, beams that missed, specks, parts that nobody saw."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from mjsim.exchange.maps.map_pixels import Cells
from mjsim.geometry import Pose
from mjsim.world import Grid, World, grid_of


@dataclass(frozen=True, slots=True)
class Noise:
    """What is wrong with a map."""

    fray: float = 0.18
    """Standard deviation of how far a cell at a wall is occupied, 0 to 1."""
    missed: float = 0.03
    """Share of occupied cells that are lost, one by one."""
    specks: float = 5e-4
    """Share of free cells that are occupied, one by one."""
    bent: float = 0.0
    """Standard deviation of a slow drift of the walls [m]."""


def mapped(world: World, *, turn: float, seed: int, resolution: float = 0.05, noise: Noise | None = None) -> Grid:
    """Return a map as SLAM gives it."""
    return mapped_with_pose(world, turn=turn, seed=seed, resolution=resolution, noise=noise)[0]


def mapped_with_pose(
    world: World, *, turn: float, seed: int, resolution: float = 0.05, noise: Noise | None = None
) -> tuple[Grid, Pose]:
    """Return a map as SLAM gives it, and map_from_world."""
    noise = noise or Noise()
    rng = np.random.default_rng(seed)
    clean = grid_of(world, resolution=resolution)
    rows, columns = clean.occupied.shape
    size = math.ceil(math.hypot(rows, columns)) + 20
    c, s = math.cos(turn), math.sin(turn)
    # In cells, from the lower left corner; OpenCV counts from the middle of the first cell.
    shift = size / 2 - np.array([[c, -s], [s, c]]) @ [columns / 2, rows / 2]
    matrix = np.array([[c, -s, shift[0]], [s, c, shift[1]]])
    matrix[:, 2] += matrix[:, :2] @ [0.5, 0.5] - 0.5
    share = cv2.warpAffine(clean.occupied.astype(np.float32), matrix, (size, size), flags=cv2.INTER_LINEAR)
    free = cv2.warpAffine(clean.free.astype(np.uint8), matrix, (size, size), flags=cv2.INTER_NEAREST) > 0
    if noise.bent:
        share, free = _bent(share, free, noise.bent / resolution, 2.0 / resolution, rng)
    fray = rng.normal(0.0, noise.fray, share.shape) * (cv2.dilate(share, np.ones((3, 3))) > 0.05)
    occupied = (share + fray > 0.5) & (rng.random(share.shape) > noise.missed)
    occupied |= free & (rng.random(share.shape) < noise.specks)
    corner = -size * resolution / 2
    grid = Grid(occupied, free & ~occupied, resolution, Pose(corner, corner, 0.0))
    at = np.array([corner, corner]) + shift * resolution
    old = clean.world_from_grid
    return grid, Pose(at[0], at[1], turn) @ Pose(old.x, old.y, old.heading).inverse()


def _bent(
    share: Cells, free: Cells, drift: float, length: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return a map moved by a slow random drift [cells] that changes over a length [cells]."""
    rows, columns = share.shape
    field = rng.standard_normal((2, rows, columns)).astype(np.float32)
    waves = np.stack([cv2.GaussianBlur(layer, (0, 0), length) for layer in field])
    waves *= drift / waves.std()
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    x, y = x + waves[0], y + waves[1]
    moved = [cv2.remap(layer.astype(np.float32), x, y, cv2.INTER_LINEAR) for layer in (share, free)]
    return moved[0], moved[1] > 0.5
