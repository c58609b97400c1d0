"""Building blocks of textures of surfaces: noise that repeats without a seam, relief, cells, and marks of use."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Texture = NDArray[np.uint8]
Rgb = tuple[float, float, float]


class Drawing(NamedTuple):
    """How a texture is drawn and stored."""

    draw: Callable[[Generator], Texture]
    seed: int
    quality: int
    """Quality of the JPEG."""


def smooth_noise(rng: Generator, shape: tuple[int, int], blur: tuple[float, float]) -> Array:
    """Return noise of unit deviation that repeats, blurred by (rows, columns) [px], shape (rows, columns)."""
    rows = np.fft.fftfreq(shape[0])[:, None] * blur[0]
    columns = np.fft.rfftfreq(shape[1])[None, :] * blur[1]
    return _filtered(rng, shape, np.exp(-2.0 * np.pi**2 * (rows**2 + columns**2)))


def cloud_noise(rng: Generator, side: int, *, slope: float, coarsest: float = 1.0, finest: float = np.inf) -> Array:
    """Return noise of unit deviation that repeats and has no scale of its own, shape (side, side).

    Args:
        rng: Generator of the noise.
        side: Side of the picture [px].
        slope: Amplitude falls with frequency to this power: 1 is rough, 2 is smooth.
        coarsest: Lowest frequency [cycles per side].
        finest: Highest frequency [cycles per side].
    """
    radius = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)[None, :]) * side
    inside = (radius >= coarsest) & (radius <= finest)
    return _filtered(rng, (side, side), np.where(inside, np.maximum(radius, 1.0) ** -slope, 0.0))


def _filtered(rng: Generator, shape: tuple[int, int], gain: Array) -> Array:
    """Return white noise after a filter, of mean 0 and deviation 1."""
    noise = np.fft.irfft2(np.fft.rfft2(rng.normal(size=shape)) * gain, s=shape)
    return np.asarray((noise - noise.mean()) / noise.std())


def lit_relief(height: Array, *, deviation: float) -> Array:
    """Return the shade of a relief under light from the upper left, scaled to a deviation; it repeats as it does."""
    slope = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) + 0.5 * (np.roll(height, -1, 1) - np.roll(height, 1, 1))
    return np.asarray(slope * (deviation / slope.std()))


def slabs(
    rng: Generator, side: int, *, rows: int, columns: int, stagger: bool, spread: float
) -> tuple[Array, Array, Array]:
    """Return slabs laid in rows, every other row moved by half a slab if they are staggered.

    Returns:
        shade: Shade of the slab of each pixel, of deviation `spread`, shape (side, side).
        warmth: The same, of a third of that deviation.
        border: Distance of each pixel from the nearest joint [px].
    """
    y, x = np.mgrid[0:side, 0:side] / side
    row = np.floor(y * rows).astype(int)
    along = x * columns + (0.5 * (row % 2) if stagger else 0.0)
    column = np.floor(along).astype(int) % columns
    shade = rng.normal(0.0, spread, (rows, columns))[row, column]
    warmth = rng.normal(0.0, spread / 3, (rows, columns))[row, column]
    across = np.minimum(along % 1.0, 1.0 - along % 1.0) * side / columns
    border = np.minimum(np.minimum(y * rows % 1.0, 1.0 - y * rows % 1.0) * side / rows, across)
    return shade, warmth, border


def cells(rng: Generator, side: int, count: int) -> tuple[NDArray[np.intp], Array]:
    """Return an irregular mosaic that repeats.

    Returns:
        owner: Index of the cell of each pixel, shape (side, side).
        border: Distance of each pixel from the border of its cell, approximately [px], shape (side, side).
    """
    tree = cKDTree(rng.uniform(0.0, side, (count, 2)), boxsize=side)
    pixels = np.stack(np.mgrid[0:side, 0:side], axis=-1).reshape(-1, 2).astype(float)
    distances, owners = tree.query(pixels, k=2)
    border = (distances[:, 1] - distances[:, 0]) / 2.0
    return owners[:, 0].reshape(side, side), border.reshape(side, side)


def specks(rng: Generator, side: int, *, count: int, radius: tuple[float, float]) -> Array:
    """Return round marks of random depth in [0, 1] with soft edges, shape (side, side); they repeat.

    Args:
        rng: Generator of their positions, sizes and depths.
        side: Side of the picture [px].
        count: Number of marks.
        radius: Minimum and maximum [px]; small ones are more frequent.
    """
    marks = np.zeros((side, side))
    reach = int(np.ceil(2.0 * radius[1]))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    for row, column in rng.uniform(0.0, side, (count, 2)):
        size = radius[0] * (radius[1] / radius[0]) ** (rng.random() ** 2)
        stretched = np.hypot(y * rng.uniform(0.8, 1.25) + (row % 1.0), x + (column % 1.0))
        mark = rng.uniform(0.35, 1.0) * np.clip((size - stretched) / max(0.6 * size, 1.0) + 0.5, 0.0, 1.0)
        rows, columns = (np.arange(-reach, reach + 1) + int(place) for place in (row, column))
        where = np.ix_(rows % side, columns % side)
        marks[where] = np.maximum(marks[where], mark)
    return marks


def scratches(
    rng: Generator, side: int, *, count: int, length: tuple[float, float], width: float, wander: float = 0.1
) -> Array:
    """Return thin wandering lines of random depth in [0, 1], shape (side, side); they repeat.

    Args:
        rng: Generator of their courses and depths.
        side: Side of the picture [px].
        count: Number of lines.
        length: Minimum and maximum [px].
        width: [px]
        wander: Deviation of the change of direction at each pixel step [rad].
    """
    marks = np.zeros((side, side))
    for _ in range(count):
        steps = int(rng.uniform(*length))
        heading = rng.uniform(0.0, 2.0 * np.pi) + np.cumsum(rng.normal(0.0, wander, steps))
        path = rng.uniform(0.0, side, (2, 1)) + np.cumsum([np.sin(heading), np.cos(heading)], axis=1)
        rows, columns = np.round(path).astype(int) % side
        fading = np.sin(np.linspace(0.1, np.pi - 0.1, steps))
        marks[rows, columns] = np.maximum(marks[rows, columns], rng.uniform(0.4, 1.0) * fading)
    wrapped = np.pad(marks, 8, mode="wrap")
    soft = cv2.GaussianBlur(wrapped, (0, 0), width)[8:-8, 8:-8]
    return np.asarray(soft / max(float(soft.max()), 1e-9))


def finished(base: Rgb, shade: Array, warmth: Array) -> Texture:
    """Return the picture of a base colour with shades and warmths, each (rows, columns)."""
    picture = np.array(base) + shade[..., None] * (1.0, 0.98, 0.95) + warmth[..., None] * (1.0, 0.0, -1.0)
    return np.clip(picture, 0, 255).astype(np.uint8)


def write(path: str, drawing: Drawing) -> None:
    """Draw a texture and write it below assets: as JPEG, or in grey as PNG, the only kind that MuJoCo itself reads."""
    place = Path(__file__).parents[2] / "assets" / path
    place.parent.mkdir(parents=True, exist_ok=True)
    picture = cv2.cvtColor(drawing.draw(np.random.default_rng(drawing.seed)), cv2.COLOR_RGB2BGR)
    if place.suffix == ".png":
        cv2.imwrite(str(place), cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    else:
        cv2.imwrite(str(place), picture, [cv2.IMWRITE_JPEG_QUALITY, drawing.quality])
