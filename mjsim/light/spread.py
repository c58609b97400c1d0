"""Values of cells and texels spread over an atlas, without crossing walls or the borders of charts."""

import numpy as np
from numpy.typing import NDArray

from mjsim.light.charts import Whole
from mjsim.light.light_rays import Light
from mjsim.light.texel_links import Links
from mjsim.light.texels import Cells, Texels

SMOOTHING_ROUNDS = 3
"""Rounds of smoothing for each texel of a cell's side."""


def on_image(shape: tuple[int, int], at: Whole, values: NDArray[np.generic], empty: float) -> NDArray[np.generic]:
    """Return an image of an atlas with the values of some texels, shape (rows, columns, ...)."""
    image = np.full((shape[0] * shape[1], *values.shape[1:]), empty, values.dtype)
    image[at] = values
    return image.reshape(*shape, *values.shape[1:])


def filled(image: NDArray[np.generic], known: NDArray[np.bool_]) -> NDArray[np.generic]:
    """Return an image whose unknown texels have the value of the nearest known one."""
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        return image
    rows, columns = distance_transform_edt(~known, return_distances=False, return_indices=True)
    whole: NDArray[np.generic] = image[rows, columns]
    return whole


def finer(values: Light, cells: Cells, texels: Texels, links: Links, side: int) -> Light:
    """Return values of cells at texels: linear between cells that links join.

    Args:
        values: Values of each cell, shape (cells, k).
        cells: Cells of the texels.
        texels: All texels.
        links: Links between them.
        side: Texels along the side of a cell.

    Returns:
        Shape (texels, k); zero for texels without a cell.
    """
    valid, shape = np.flatnonzero(cells.of >= 0), links.right.shape
    image = np.asarray(on_image(shape, texels.at, cells.of.astype(np.int32), -1))
    at = np.stack([texels.at % shape[1], texels.at // shape[1]], axis=1)[valid]
    total = np.zeros((len(valid), values.shape[1]), np.float32)
    weights = np.zeros((len(valid), 1), np.float32)
    low = np.floor(side / 2)
    for dx, dy in ((-low, -low), (-low, low), (low, -low), (low, low)):
        there = np.clip(at + np.array([dx, dy], dtype=np.int64), 0, np.array(shape)[::-1] - 1)
        cell = image[there[:, 1], there[:, 0]]
        middle = cells.middles[cell]
        near = np.clip(1.0 - np.abs(at - middle) / (side + 0.5), 0.0, None).prod(axis=1)
        near[cell < 0] = 0.0
        some = np.flatnonzero(near)
        near[some] *= links.reach(at[some], middle[some], side + 1)
        total += near[:, None].astype(np.float32) * values[cell]
        weights += near[:, None].astype(np.float32)
    found = np.zeros((len(cells.of), values.shape[1]), np.float32)
    found[valid] = np.where(weights > 1e-3, total / np.maximum(weights, 1e-3), values[cells.of[valid]])
    return found
