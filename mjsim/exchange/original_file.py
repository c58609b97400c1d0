"""Reads a map or drawing in its original form, to be drawn beside the world that was made from it."""

import re
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.import_world import drawing_of, plan_of
from mjsim.exchange.maps import is_picture, read_grid
from mjsim.exchange.world_import import Reading
from mjsim.geometry import Array, Pose
from mjsim.plan import Original, Stroke
from mjsim.world import Grid

OCCUPIED, FREE, UNKNOWN = 20, 255, 205
"""Grey values of the cells of a map."""
MARGIN_CELLS = 10
"""Margin around the known part of a map [cells]."""
_PLACED = re.compile(r"# From the drawing .*: (\S+) m to its unit, its place \[(\S+), (\S+)\] is \[0, 0\] here")

_CELL = re.compile(r"# From the map .*: \d+ x \d+ cells of (\S+) m\.")


def read_original(path: str | Path, *, world: str | Path | None = None, reading: Reading | None = None) -> Original:
    """Return the original map or drawing of a file.

    Args:
        path: The YAML file of a map, or an SVG or DXF drawing.
        world: The world file made from it; its first lines state the drawing's position in it.
        reading: How the drawing was read, if the world file no longer says so.

    Raises:
        UsageError: The file is none of these, or cannot be read.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind in (".yaml", ".yml"):
        return _of_grid(read_grid(path), path.name)
    if is_picture(path):
        cell = reading.scale if reading else _cell(world)
        return _of_grid(read_grid(path, resolution=cell), path.name)
    if kind in (".svg", ".dxf"):
        return _of_drawing(path, None if world is None else Path(world), reading or Reading())
    raise UsageError(f"'{path}' is not a supported file; name a map's .yaml, an .svg or a .dxf file")


def _of_grid(grid: Grid, name: str) -> Original:
    """Return the known part of a map, with a margin."""
    known = np.argwhere(grid.occupied | grid.free)
    shape = np.array(grid.occupied.shape)
    low = np.maximum(known.min(axis=0) - MARGIN_CELLS, 0) if len(known) else np.zeros(2, dtype=int)
    high = np.minimum(known.max(axis=0) + MARGIN_CELLS + 1, shape) if len(known) else shape
    gray = np.full(grid.occupied.shape, UNKNOWN, dtype=np.uint8)
    gray[grid.free], gray[grid.occupied] = FREE, OCCUPIED
    part = gray[low[0] : high[0], low[1] : high[1]]
    corner = grid.corners(low[::-1].astype(float))
    at = Pose(float(corner[0]), float(corner[1]), grid.world_from_grid.heading)
    rows, columns = part.shape
    corners = grid.corners(low[::-1] + np.array([[0, 0], [columns, 0], [columns, rows], [0, rows]], dtype=float))
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    picture = np.repeat(part[..., None], 3, axis=2)
    return Original(name, bounds, (), picture, grid.resolution, at)


def _of_drawing(path: Path, world: Path | None, reading: Reading) -> Original:
    if (placed := _placed(world)) is None:
        plan, drawing = plan_of(path, reading)
        scale, corner = plan.scale, np.array(plan.corner)
    else:
        drawing, (scale, corner) = drawing_of(path, reading), placed
    lines = [
        Stroke((line.points - corner) * scale, line.closed, line.path, line.dark)
        for line in drawing.lines
        if len(line.points) > 1
    ]
    if not lines:
        raise UsageError(f"'{path}' has no lines to show")
    points = np.concatenate([line.points for line in lines])
    return Original(path.name, np.stack([points.min(axis=0), points.max(axis=0)]), lines)


def _placed(world: Path | None) -> tuple[float, Array] | None:
    """Return the placement of a drawing stated in a world file's first lines: metres per unit, and where [0, 0] is."""
    found = _numbers_in(world, _PLACED)
    return (found[0], np.array(found[1:])) if found else None


def _cell(world: str | Path | None) -> float | None:
    """Return the side of a map's cell from the first lines of a world file [m]."""
    found = _numbers_in(None if world is None else Path(world), _CELL)
    return found[0] if found else None


def _numbers_in(world: Path | None, line: re.Pattern[str]) -> list[float] | None:
    """Return the numbers in a matching line among the first lines of a world file; None if there is none."""
    if world is None:
        return None
    head = read_bounded(world, limit=50_000_000, kind="a world file")[:4096].decode("utf-8", "replace")
    found = line.search(head)
    try:
        return [float(number) for number in found.groups()] if found else None
    except ValueError:
        return None
