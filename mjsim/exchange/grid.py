"""Occupancy grids as ROS map_server and Nav2 write them: a picture and a YAML file beside it."""

import math
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.pixels import Cells, gray_of
from mjsim.geometry import Array, Pose
from mjsim.output import free_paths, write_files
from mjsim.world import SLICE, Grid, World, grid_of, read_text

MOST_BYTES = 200_000_000
"""Of a picture."""
MOST_YAML = 100_000
"""Bytes of the file beside it."""
OCCUPIED, UNKNOWN, FREE = 0, 205, 254
"""Gray values, as map_saver writes them."""
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
"""As map_saver writes them; what is unknown lies between."""
FILES = ("map.pgm", "map.yaml")
"""Of a map."""


def read_grid(path: str | Path) -> Grid:
    """Return the map of a YAML file and the picture that it names.

    Args:
        path: The YAML file: image, resolution, origin, negate, occupied_thresh, free_thresh, mode.

    Raises:
        UsageError: The map is not there, too large, or not a map.

    References:
        Nav2, nav2_map_server, map_io.cpp: how a pixel becomes a cell in the modes trinary, scale and raw.
    """
    path = Path(path)
    keys = _keys_of(path)
    resolution = _number(keys, "resolution", path)
    if not 1e-3 <= resolution <= 10.0:
        raise UsageError(f"{path}: resolution is {resolution:g} m; a map has cells of 0.001 to 10 m")
    occupied_above = _number(keys, "occupied_thresh", path, default=OCCUPIED_THRESH)
    free_below = _number(keys, "free_thresh", path, default=FREE_THRESH)
    if not 0.0 <= free_below <= occupied_above <= 1.0:
        raise UsageError(
            f"{path}: free_thresh is {free_below:g} and occupied_thresh {occupied_above:g};"
            " they must lie between 0 and 1, free_thresh below"
        )
    mode = keys.get("mode", "trinary")
    if mode not in ("trinary", "scale", "raw"):
        raise UsageError(f"{path}: mode is '{mode}'; it must be trinary, scale or raw")
    share, opaque = _shares(*_picture_of(path, keys), raw=mode == "raw", negate=bool(keys.get("negate", 0)))
    limit = (free_below + occupied_above) / 2 if mode == "scale" else None
    occupied = (share > (occupied_above if limit is None else limit)) & opaque
    free = (share < free_below if limit is None else share <= limit) & opaque
    return Grid(occupied[::-1].copy(), free[::-1].copy(), resolution, _origin(keys, path))


def write_grid(grid: Grid, folder: str | Path, *, overwrite: bool = False) -> Path:
    """Write `map.yaml` and `map.pgm` into a folder and return the path of `map.yaml`.

    Raises:
        UsageError: A file exists, unless `overwrite` allows to replace it, or cannot be written.
    """
    picture = np.full(grid.occupied.shape, UNKNOWN, dtype=np.uint8)
    picture[grid.free], picture[grid.occupied] = FREE, OCCUPIED
    rows, columns = len(picture), len(picture[0])
    at = grid.world_from_grid
    text = (
        "image: map.pgm\nmode: trinary\n"
        f"resolution: {grid.resolution:.9g}\norigin: [{at.x:.9g}, {at.y:.9g}, {at.heading:.9g}]\nnegate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESH}\nfree_thresh: {FREE_THRESH}\n"
    )
    pixels = b"P5\n%d %d\n255\n" % (columns, rows) + picture[::-1].tobytes()
    write_files(folder, dict(zip(FILES, (pixels, text.encode()), strict=True)), overwrite=overwrite)
    return Path(folder) / "map.yaml"


def read_bounded(path: Path, *, most: int, kind: str) -> bytes:
    """Return what a file holds.

    Raises:
        UsageError: It is not there, is no file, or has more bytes than allowed.
    """
    try:
        if not path.is_file():
            raise UsageError(f"no file '{path}'; name {kind}")
        size = path.stat().st_size
        if size > most:
            raise UsageError(f"'{path}' has {size / 1e6:.0f} MB; {kind} has at most {most / 1e6:g} MB")
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"'{path}' cannot be read: {error.strerror}") from None


def _keys_of(path: Path) -> dict[str, Any]:
    data = read_bounded(path, most=MOST_YAML, kind="the YAML file of a map")
    node, problems = read_text(data.decode("utf-8", "replace"), file=str(path))
    if problems:
        raise UsageError("\n".join(map(str, problems)))
    if node is None or not isinstance(node.value, dict) or "image" not in node.value:
        raise UsageError(f"{path}: this is not a map; it names an image, a resolution and an origin")
    return dict(node.value)


def _number(keys: dict[str, Any], key: str, path: Path, *, default: float | None = None) -> float:
    value = keys.get(key, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UsageError(f"{path}: {key} is {value!r:.40}; it must be a number")
    return float(value)


def _origin(keys: dict[str, Any], path: Path) -> Pose:
    origin = keys.get("origin", [0.0, 0.0, 0.0])
    numbers = isinstance(origin, list) and all(
        isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= 9000.0 for value in origin
    )
    if not numbers or len(origin) not in (2, 3):
        raise UsageError(f"{path}: origin is {origin!r:.60}; write [x, y, yaw] in metres, within 9 km, and radians")
    return Pose(float(origin[0]), float(origin[1]), float(origin[2]) if len(origin) == 3 else 0.0)


def _picture_of(path: Path, keys: dict[str, Any]) -> tuple[Array, Cells]:
    """Return how white each pixel of a map's picture is, 0 to 1, and whether it is opaque."""
    name = str(keys["image"])
    relative = PurePosixPath(name)
    if relative.is_absolute():  # map_saver of ROS 1 writes the whole path of the machine that it ran on
        relative = PurePosixPath(relative.name)
    if ".." in relative.parts or not name.isprintable():
        raise UsageError(f"{path}: image {name!r:.60} leaves its folder; put it beside the YAML file")
    file = path.parent / relative
    data = read_bounded(file, most=MOST_BYTES, kind="the picture of a map")
    try:
        return gray_of(data)
    except ValueError as error:
        raise UsageError(f"'{file}' {error}") from None


def _shares(gray: Array, opaque: Cells, *, raw: bool, negate: bool) -> tuple[Array, Cells]:
    """Return how far each pixel is occupied, 0 to 1, and whether it is known at all."""
    if raw:
        percent = gray * np.float32(255.0)
        return np.asarray(percent / 100.0), opaque & (percent <= 100.5)
    return np.asarray(gray if negate else 1.0 - gray), opaque


def write_map(
    world: World, folder: str | Path, *, resolution: float = 0.05, height: float = SLICE, overwrite: bool = False
) -> Path:
    """Write `map.yaml` and `map.pgm` of a world as Nav2 reads them, and return the path of `map.yaml`.

    Args:
        world: What is to be drawn.
        folder: Is made when it is not there.
        resolution: Side of a cell [m].
        height: At which a level plane cuts the world [m].
        overwrite: Whether files that exist may be replaced.

    Raises:
        UsageError: Nothing is solid at this height, the map would be too large, or a file exists or cannot be written.
    """
    free_paths(folder, FILES, overwrite=overwrite)
    return write_grid(grid_of(world, resolution=resolution, height=height), folder, overwrite=overwrite)
