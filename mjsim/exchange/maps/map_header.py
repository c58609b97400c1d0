"""The YAML file of a map in the form of ROS map_server and Nav2: names the image and what its greys mean."""

import math
import re
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from mjsim.errors import UsageError, file_meant
from mjsim.exchange.bounded_file import read_bounded
from mjsim.geometry import Pose
from mjsim.world import Node, read_text

_TABS = re.compile(r"(?<=\S)[ \t]+")
"""Spaces and tabs between words and at ends of lines, where YAML takes either."""
MAX_YAML = 100_000
"""Maximum size of the file [bytes]."""
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
"""Thresholds as map_saver writes them; cells between them are unknown."""
MODES = ("trinary", "scale", "raw")
NO, YES = {"", "0", "n", "no", "false", "off"}, {"1", "y", "yes", "true", "on"}
"""Words that mean false, and true, in YAML 1.1, which ROS reads."""
MAX_ORIGIN = 9000.0
"""Maximum absolute value of x and y of an origin [m]."""
MAX_YAW = 6.3
"""Maximum absolute value of the yaw of an origin, a little more than a whole turn [rad]."""


@dataclass(frozen=True, slots=True)
class MapHeader:
    """The contents of a map's YAML file."""

    image: str
    """File name of the image, as written."""
    resolution: float
    """Side of a cell [m]."""
    origin: Pose = Pose(0.0, 0.0, 0.0)  # noqa: RUF009 - a frozen value
    """Pose of the grid in the map frame: outer corner of its lower left cell, and direction of its rows [m, m, rad]."""
    occupied_thresh: float = OCCUPIED_THRESH
    """Cells with a higher occupancy are occupied, 0 to 1."""
    free_thresh: float = FREE_THRESH
    """Cells with a lower occupancy are free, 0 to 1."""
    mode: str = "trinary"
    negate: bool = False
    """Whether white is occupied."""


def read_header(path: Path) -> MapHeader:
    """Return the keys of a map's YAML file: image, resolution, origin, negate, occupied_thresh, free_thresh, mode.

    Raises:
        UsageError: The file does not exist, is too large, or is not a map; with line and column where known.
    """
    data = read_bounded(path, limit=MAX_YAML, kind="the YAML file of a map")
    text = _TABS.sub(lambda match: " " * len(match[0]), data.decode("utf-8-sig", "replace"))
    node, problems = read_text(text, file=str(path))
    if problems and data.strip():
        raise UsageError("\n".join(map(str, problems)))
    if node is not None and isinstance(node.value, dict) and "mjsim" in node.value:
        raise UsageError(f"{path}: this is already a world of mjsim; run it, or copy it")
    if node is None or not isinstance(node.value, dict) or "image" not in node.value:
        raise UsageError(f"{path}: this is not a map; a map names an image, a resolution and an origin")
    keys = _Keys(path, node)
    occupied = keys.number("occupied_thresh", OCCUPIED_THRESH)
    free = keys.number("free_thresh", FREE_THRESH)
    if not 0.0 <= free <= occupied <= 1.0:
        last = "free_thresh" if "free_thresh" in node.value else "occupied_thresh"
        raise UsageError(
            f"{keys.at(last)}: free_thresh is {free:g} and occupied_thresh {occupied:g};"
            " they must lie between 0 and 1, free_thresh below"
        )
    if "resolution" not in node.value:
        raise UsageError(f"{path}: key 'resolution' is missing; add it: side of a cell [m]")
    resolution = checked_resolution(keys.number("resolution"), keys.at("resolution"))
    return MapHeader(_image(keys), resolution, _origin(keys), occupied, free, _mode(keys), keys.flag("negate"))


@dataclass(frozen=True, slots=True)
class _Keys:
    """The keys of a file, with their positions."""

    path: Path
    node: Node

    def get(self, key: str) -> Any:
        """Return the value of a key; None if it is missing."""
        return self.node.value.get(key)

    def at(self, key: str) -> str:
        """Return file, line and column of a value; only the file if the key is missing."""
        item = self.node.items.get(key)
        return str(self.path) if item is None else f"{self.path}:{item.line}:{item.column}"

    def number(self, key: str, default: float = math.nan) -> float:
        """Return a number.

        Raises:
            UsageError: The value is not a finite number.
        """
        value = self.node.value.get(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise UsageError(f"{self.at(key)}: {key} is {value!r:.40}; it must be a number")
        return float(value)

    def flag(self, key: str) -> bool:
        """Return whether a value is true: a number other than 0, or a word that means true."""
        value = self.get(key)
        if not isinstance(value, str):
            return bool(value)
        if value.lower() not in NO | YES:
            raise UsageError(f"{self.at(key)}: {key} is {value!r:.40}; it must be 0 or 1")
        return value.lower() in YES


def _image(keys: _Keys) -> str:
    name = keys.get("image")
    if not isinstance(name, str) or not name:
        raise UsageError(f"{keys.at('image')}: image is {name!r:.40}; name the picture of a map")
    parts = PurePosixPath(name).parts if not _absolute(name) else ()
    if ".." in parts or not name.isprintable():
        raise UsageError(f"{keys.at('image')}: image {name!r:.60} is outside its folder; put it beside the YAML file")
    picture = picture_beside(keys.path, name)
    if not picture.exists():
        meant = file_meant(picture, (picture.suffix.lower(),), otherwise="the picture of the map")
        raise UsageError(f"{keys.at('image')}: no file '{picture.name}' beside it{meant}")
    return name


def picture_beside(path: Path, name: str) -> Path:
    """Return the path of a map's image; an absolute path of another machine gives the file beside the YAML file."""
    if _absolute(name):
        name = PurePosixPath(name.replace("\\", "/")).name
    return path.parent / name


def _absolute(name: str) -> bool:
    """Return whether a name is an absolute path: map_saver of ROS 1 writes those of its machine."""
    return name.startswith(("/", "~", "file:")) or name[1:3] in (":\\", ":/")


def checked_resolution(resolution: float, place: str) -> float:
    """Return the side of a cell, checked [m].

    Args:
        resolution: The given value [m].
        place: Where it was given, for messages.

    Raises:
        UsageError: It is not a plausible cell size.
    """
    if not 1e-3 <= resolution <= 10.0:
        raise UsageError(f"{place}: resolution is {resolution:g} m; cells must be 0.001 to 10 m")
    return resolution


def _mode(keys: _Keys) -> str:
    mode = keys.get("mode")
    if mode is None:
        return MODES[0]
    if str(mode).lower() not in MODES:
        raise UsageError(f"{keys.at('mode')}: mode is '{mode!s:.40}'; it must be trinary, scale or raw")
    return str(mode).lower()


def _origin(keys: _Keys) -> Pose:
    origin = keys.get("origin")
    if origin is None:
        return Pose(0.0, 0.0, 0.0)
    numbers = isinstance(origin, list) and all(
        isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= MAX_ORIGIN for value in origin
    )
    if not numbers or len(origin) not in (2, 3):
        raise UsageError(
            f"{keys.at('origin')}: origin is {origin!r:.60}; write [x, y, yaw] in metres, within 9 km, and radians"
        )
    yaw = float(origin[2]) if len(origin) == 3 else 0.0
    if abs(yaw) > MAX_YAW:
        raise UsageError(
            f"{keys.at('origin')}: the yaw of origin is {yaw:g} rad; it must be between -{MAX_YAW:g} and {MAX_YAW:g}"
        )
    return Pose(float(origin[0]), float(origin[1]), yaw)
