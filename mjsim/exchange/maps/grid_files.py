"""Occupancy grids in the form of ROS map_server and Nav2: an image and a YAML file."""

from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.maps.map_header import (
    FREE_THRESH,
    OCCUPIED_THRESH,
    MapHeader,
    checked_resolution,
    picture_beside,
    read_header,
)
from mjsim.exchange.maps.map_pixels import Cells, claimed_pixels, gray_of
from mjsim.geometry import Array
from mjsim.output import free_paths, write_files
from mjsim.world import SLICE, Grid, World, grid_of

MAX_BYTES = 200_000_000
"""Maximum size of an image [bytes]."""
OCCUPIED, UNKNOWN, FREE = 0, 205, 254
"""Grey values as map_saver writes them."""
UNKNOWN_TOLERANCE = 0.6 / 255
"""Tolerance for the grey of unknown cells, with 8 and with 16 bits [fraction of white]."""
PICTURES = (".pgm", ".ppm", ".pbm", ".pnm", ".png", ".jpg", ".jpeg", ".bmp")
"""File suffixes of map images."""
HEADERS = (".yaml", ".yml")
"""File suffixes of the files that name them."""
PIXELS_PER_BYTE = 10
"""Pixels of a map that take as much time and memory as a byte of a drawing."""
FILES = ("map.pgm", "map.yaml")
"""Files of a written map."""


def read_grid(path: str | Path, *, resolution: float | None = None) -> Grid:
    """Return the map of a YAML file and the image it names, or of an image without a YAML file.

    Args:
        path: The YAML file; or an image, black where occupied, white where free.
        resolution: Side of a cell, for an image without a YAML file [m].

    Raises:
        UsageError: The map does not exist, is too large, or is not a map.

    References:
        Nav2, nav2_map_server, map_io.cpp: how a pixel becomes a cell in the modes trinary, scale and raw.
    """
    path = Path(path)
    if is_picture(path):
        return _grid_of(MapHeader(path.name, _given(resolution, path)), path)
    if resolution is not None:
        raise UsageError(f"{path}: the YAML file of a map states its resolution; leave out --scale")
    header = read_header(path)
    return _grid_of(header, picture_beside(path, header.image))


def claimed_size(path: Path) -> int:
    """Return the size with which the limits of reading a file grow: that of a map's picture, or of the file [bytes].

    Raises:
        UsageError: The file is the YAML file of a map, and malformed.
    """
    file = picture_beside(path, read_header(path).image) if path.suffix.lower() in HEADERS else path
    if not is_picture(file):
        return file.stat().st_size if file.is_file() else 0
    data = read_bounded(file, limit=MAX_BYTES, kind="the picture of a map")
    return max(len(data), claimed_pixels(data) // PIXELS_PER_BYTE)


def is_picture(path: Path) -> bool:
    """Return whether a file is a map image, judging by its suffix."""
    return path.suffix.lower() in PICTURES


def _given(resolution: float | None, path: Path) -> float:
    """Return the given side of a cell of an image [m].

    Raises:
        UsageError: It is not given, or is not a valid resolution.
    """
    if resolution is None:
        beside = [file for kind in (".yaml", ".yml") if (file := path.with_suffix(kind)).is_file()]
        hint = f"name '{beside[0]}' beside it" if beside else "name the YAML file beside it, or give"
        raise UsageError(f"'{path}' is a map image; {hint}" + ("" if beside else " --scale METRES to a pixel"))
    return checked_resolution(resolution, str(path))


def _grid_of(header: MapHeader, file: Path) -> Grid:
    """Return the grid of an image, interpreted as its header states."""
    share, known = _shares(*_picture_of(file), header)
    occupied_above, free_below = header.occupied_thresh, header.free_thresh
    if header.mode == "scale":
        occupied_above = free_below = (occupied_above + free_below) / 2
    occupied = (share > occupied_above) & known
    free = (share < free_below) & known
    return Grid(occupied[::-1].copy(), free[::-1].copy(), header.resolution, header.origin)


def write_grid(grid: Grid, folder: str | Path, *, overwrite: bool = False) -> Path:
    """Write `map.yaml` and `map.pgm` into a folder and return the path of `map.yaml`.

    Raises:
        UsageError: A file exists and `overwrite` is false, or a file cannot be written.
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


def _picture_of(file: Path) -> tuple[Array, Cells]:
    """Return the whiteness of each pixel of a map image, 0 to 1, and whether it is opaque."""
    data = read_bounded(file, limit=MAX_BYTES, kind="the picture of a map")
    try:
        return gray_of(data)
    except ValueError as error:
        raise UsageError(f"'{file}' {error}") from None


def _shares(gray: Array, opaque: Cells, header: MapHeader) -> tuple[Array, Cells]:
    """Return the occupancy of each pixel, 0 to 1, and whether it is known."""
    if header.mode == "raw":
        percent = gray * np.float32(255.0)
        return np.asarray(percent / 100.0), opaque & (percent <= 100.5)
    # In mode scale, map_saver writes unknown cells in middle grey and transparent; PGM keeps only the grey.
    # In mode trinary it writes them as 205, which is below the threshold of 0.25 that Nav2 writes for free cells.
    unknown = 0.5 if header.mode == "scale" else UNKNOWN / 255
    known = (
        opaque if header.negate and header.mode != "scale" else opaque & (np.abs(gray - unknown) > UNKNOWN_TOLERANCE)
    )
    return np.asarray(gray if header.negate else 1.0 - gray), known


def write_map(
    world: World, folder: str | Path, *, resolution: float = 0.05, height: float = SLICE, overwrite: bool = False
) -> Path:
    """Write `map.yaml` and `map.pgm` of a world in the form that Nav2 reads; return the path of `map.yaml`.

    Args:
        world: The world.
        folder: Output folder; it is created if needed.
        resolution: Side of a cell [m].
        height: Height of the horizontal section through the world [m].
        overwrite: Whether existing files may be replaced.

    Raises:
        UsageError: Nothing is solid at this height, the map would be too large, or a file exists or cannot be written.
    """
    free_paths(folder, FILES, overwrite=overwrite)
    return write_grid(grid_of(world, resolution=resolution, height=height), folder, overwrite=overwrite)
