"""Converts configurations of MATLAB simulators to worlds: walls, beacons, waypoints, a robot and its sensor.

References:
    The landmark maps of T. Bailey's SLAM simulators for MATLAB: `lm` (2 x n) are reflectors, `wp` (2 x m) waypoints.
"""

import io
import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.matlab.equipment import Equipment, equipment_of, owner_of
from mjsim.exchange.matlab.matlab_tables import Tables
from mjsim.exchange.matlab.matlab_text import read_assignments
from mjsim.exchange.matlab.named_pictures import NamedPictures, named_pictures
from mjsim.exchange.preset_files import inhabited, robot_of
from mjsim.exchange.start_place import ODOMETRY_NOISE, ROBOT, WAYPOINTS
from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem
from mjsim.sentences import number_of
from mjsim.world import Beacon, Modules, Robot, Run, Use, Wall, World

SLAM = "mjsim.algorithms.ekf_slam:EkfSlam"
WAYPOINT_SPEED = 0.6
"""Speed along the waypoints [m/s]."""
MAX_BYTES, MAX_LANDMARKS, MAX_WAYPOINTS, MAX_CORNERS = 10_000_000, 2000, 1000, 5000
MAX_DISTANCE = 5000.0
"""Maximum distance of a point from the map's origin [m]."""
DIGITS = 3
"""Coordinates are rounded to the millimetre."""
NAMES = {
    "landmarks": ("lm", "beacons", "beacon", "landmarks", "landmark", "reflectors", "baken", "landmarken",
                  "reflektoren", "balises", "amers", "balizas", "marcas", "features", "markers", "lms"),
    "waypoints": ("wp", "waypoints", "way", "path", "route", "wegpunkte", "bahn", "trajet", "ruta",
                  "viapoints", "goals"),
    "walls": ("walls", "wall", "corners", "room", "outline", "roomcorners", "wallcorners", "ecken", "waende", "raum",
              "murs", "coins", "paredes", "esquinas", "lines", "segments", "boundary"),
}  # fmt: skip
"""Names of the tables, without underscores, case and TABLE; also in German, French and Spanish."""
TABLE = re.compile(r"(positions?|list|table|matrix|data)$")
"""Possible ends of such a name."""
NESTED = 4
"""Maximum nesting of structs around the tables."""


@dataclass(frozen=True, slots=True)
class PlacedBeacon:
    """A beacon of such a file."""

    at: tuple[float, float]
    """[m]"""
    heading: float | None = None
    """[rad]"""
    picture: str | None = None
    """Picture file, relative to the world file or to assets; None for a reflector."""


@dataclass(frozen=True, slots=True, eq=False)
class LandmarkMap:
    """The contents of such a file, in metres."""

    landmarks: Array
    """Shape (n, 2) [m]."""
    waypoints: Array
    """Shape (m, 2) [m]; empty if the file has none."""
    walls: tuple[Array, ...] = ()
    """Corners of each wall, shape (k, 2) [m]; closed where the last is the first."""
    beacons: tuple[PlacedBeacon, ...] = ()
    """The landmarks with heading and picture, if the file states them."""
    equipment: Equipment = field(default_factory=Equipment)
    items: tuple[FileItem, ...] = ()
    """What became of the contents of the file."""

    def length(self) -> float:
        """Return the length of the path along the waypoints [m]."""
        return float(np.hypot(*np.diff(self.waypoints, axis=0).T).sum()) if len(self.waypoints) > 1 else 0.0

    @property
    def points(self) -> Array:
        """All points of the file, shape (k, 2) [m]."""
        return np.vstack([self.landmarks, self.waypoints, *self.walls])


def read_landmarks(path: Path, *, scale: float, rows: bool = False) -> LandmarkMap:
    """Return the configuration of a file.

    Args:
        path: A MAT-file, version 5 to 7, or a script of literal assignments.
        scale: Metres per unit of the file.
        rows: Whether a table that fits both ways has an item in each row.

    Raises:
        UsageError: The file is neither, or contains neither landmarks nor walls.
    """
    content, unread = _content(path)
    content = _opened(content)
    given = {key: _first(content, names) for key, names in NAMES.items()}
    if given["landmarks"] is None and given["walls"] is None:
        names = ", ".join(sorted(content)) or "nothing"
        raise UsageError(
            f"'{path}' holds no landmarks: lm, 2 x n; it holds {'; '.join([f'{names:.200}', *unread[:1]])}"
        )
    tables = Tables(str(path), rows)
    used = {each[0] for each in given.values() if each is not None}
    others = {key: value for key, value in content.items() if key not in used}
    pictures = named_pictures(path.parent, others)
    beacons = _beacons(path, tables, given["landmarks"], scale, pictures)
    name, value = given["waypoints"] or ("wp", np.zeros((2, 0)))
    waypoints = tables.points(name, value, limit=MAX_WAYPOINTS) * scale
    walls = tuple(_rounded(points * scale) for points in _walls(tables, given["walls"]))
    beacons, moved = _on_faces(beacons, walls)
    equipment, unused = equipment_of(others, scale=scale)
    kept = (*_told_walls(given["walls"], walls), *equipment.told, *pictures.told_taken())
    map = LandmarkMap(
        _rounded(np.array([beacon.at for beacon in beacons]).reshape(-1, 2)),
        _rounded(waypoints),
        walls,
        tuple(beacons),
        equipment,
        (
            *(FileItem(Fate.KEPT, line) for line in kept),
            *(FileItem(Fate.GUESSED, line) for line in (*tables.told, *moved)),
            *(FileItem(Fate.LEFT_OUT, line) for line in unread),
            *(FileItem(Fate.LEFT_OUT, "variable", name) for name in unused if name not in pictures.taken),
        ),
    )
    farthest = float(np.abs(map.points).max())
    if farthest > MAX_DISTANCE:
        raise UsageError(f"'{path}' extends to {farthest:g} m; the limit is {MAX_DISTANCE:g} m, give a smaller --scale")
    return map


def world_from_landmarks(
    map: LandmarkMap,
    *,
    name: str,
    preset: str | None,
    estimator: Use | None = None,
    folder: Path | None = None,
) -> World:
    """Return a world with walls and beacons, and a robot that drives along the waypoints.

    Args:
        map: The landmark map.
        name: Name of the world.
        preset: Preset of the robot; None for no robot.
        folder: Folder in which the world will be saved; the preset may be a file in it.
        estimator: The estimator; by default EKF-SLAM.

    Raises:
        UsageError: The preset does not exist, or the data of the robot in the file are invalid.
    """
    placed = map.beacons or tuple(PlacedBeacon(_at(point)) for point in map.landmarks)
    beacons = tuple(_beacon(f"lm{k}", beacon) for k, beacon in enumerate(placed, start=1))
    world = World(name=name, beacons=beacons, walls=tuple(_wall(points) for points in map.walls))
    if preset is None:
        return world
    start = map.waypoints[0] if len(map.waypoints) else map.points.mean(axis=0).round(DIGITS)
    heading = _heading(start, map.waypoints[1:])
    if (pose := map.equipment.pose) is not None:
        start, heading = np.array(pose[:2]), round(math.degrees(pose[2]), DIGITS)
    robot = _robot(preset, start, heading, folder, map.equipment)
    points = [list(_at(point)) for point in map.waypoints[1:]]
    length = Use.model_validate({"use": WAYPOINTS, "points": points, "speed": WAYPOINT_SPEED}) if points else None
    modules = Modules(estimator=estimator or Use(use=SLAM), navigator=length)
    seconds = float(max(60, math.ceil(1.4 * map.length() / WAYPOINT_SPEED)))
    run = Run(seconds=seconds, drivers={ROBOT: modules})
    return inhabited(world, robot, run, folder)


HDF5, USER_BLOCK = b"\x89HDF\r\n\x1a\n", 512
"""First bytes of HDF5, and the size of the text that MATLAB writes before them [bytes]."""


def _content(path: Path) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return variables by name, and lines about what could not be read."""
    data = read_bounded(path, limit=MAX_BYTES, kind="a landmark map")
    if path.suffix.lower() == ".m":
        found = read_assignments(data.decode("utf-8-sig", errors="replace"))
        return dict(found.values), found.unread
    if HDF5 in (data[: len(HDF5)], data[USER_BLOCK : USER_BLOCK + len(HDF5)]):
        raise UsageError(
            f"'{path}' is a MAT-file of version 7.3 (HDF5), which mjsim cannot read; write one of version 5 to 7 in"
            f" MATLAB or Octave: load('{path.name}'), then save('map.mat', '-v7')"
        )
    from scipy.io import loadmat

    content = loadmat(io.BytesIO(data))
    return {key: _plain(value) for key, value in content.items() if not key.startswith("__")}, ()


def _plain(value: Any) -> Any:
    """Return a value of a MAT-file in the form of `Assignments.values`."""
    if not isinstance(value, np.ndarray | np.void):
        return value
    if value.dtype.names:
        items = [{name: _plain(item[name]) for name in value.dtype.names} for item in np.atleast_1d(value).ravel()]
        return items[0] if len(items) == 1 else items
    if value.dtype.kind == "U":
        return "".join(map(str, value.ravel()))
    if value.dtype == object:
        return [[_plain(item) for item in row] for row in np.atleast_2d(value)]
    return value


def _opened(content: Mapping[str, Any], depth: int = NESTED) -> dict[str, Any]:
    """Return variables; a struct that holds other variables, as cfg.lm, is replaced by its fields."""
    known = {name for names in NAMES.values() for name in names}
    found: dict[str, Any] = {}
    for name, value in content.items():
        is_around = isinstance(value, Mapping) and (_bare(name) not in known or bool({*map(_bare, value)} & known))
        if depth and is_around and owner_of(name) is None:
            found |= {key: each for key, each in _opened(value, depth - 1).items() if key not in content}
        else:
            found[name] = value
    return found


def _bare(name: str) -> str:
    return TABLE.sub("", name.lower().replace("_", ""))


def _first(content: Mapping[str, Any], names: tuple[str, ...]) -> tuple[str, Any] | None:
    """Return the variable with one of the names, and its value; if there are several, the one with most values."""
    lower = {_bare(key): key for key in content}
    found = [(lower[name], content[lower[name]]) for name in names if name in lower]
    return max(found, key=lambda pair: np.size(pair[1]) if isinstance(pair[1], np.ndarray) else 1, default=None)


def _beacons(
    path: Path, tables: Tables, given: tuple[str, Any] | None, scale: float, pictures: NamedPictures
) -> list[PlacedBeacon]:
    if given is None:
        return []
    name, value = given
    items = tables.items(name, value, sizes=(4, 3, 2), columns="x above y", limit=MAX_LANDMARKS)
    if not items:
        raise UsageError(f"'{path}' has an empty {name}; a map has at least one landmark")
    numbers = tables.finite(name, np.array([item[:3] for item in items], dtype=float))
    turn = 1.0
    if numbers.shape[1] == 3 and float(np.abs(numbers[:, 2]).max()) > 2.0 * math.pi + 0.01:
        tables.told.append(f"the headings of {name} exceed 2 pi: they are taken as degrees")
        turn = math.pi / 180.0
    found = []
    for number, (item, row) in enumerate(zip(items, numbers, strict=True)):
        picture = pictures.of(item, number, len(items))
        heading = float(row[2]) * turn if len(row) == 3 else None
        found.append(PlacedBeacon(_at(_rounded(row[:2] * scale)), heading, picture))
    tables.told.extend(pictures.told_absent(name))
    return found


def _walls(tables: Tables, given: tuple[str, Any] | None) -> list[Array]:
    """Return the corners of each wall; columns of NaN, or cells, separate walls."""
    if given is None:
        return []
    name, value = given
    if isinstance(value, list) and not any(isinstance(item, str | dict) for item in value):
        parts = [part for item in value for part in (item if isinstance(item, list) else [item])]
        if len(parts) > 1 and all(isinstance(part, np.ndarray) and part.size == 2 for part in parts):
            return _walls(tables, (name, np.array([np.ravel(part) for part in parts]).T))
        if any(np.size(part) > 1 for part in parts):
            # A square part has the same orientation as the others.
            lie = {np.shape(part)[1:] == (2,) for part in parts if np.shape(part) != (2, 2)}
            rows = [lie == {True} and np.shape(part) == (2, 2) for part in parts]
            inner = [[tables.finite(name, part)] if row else _walls(tables, (name, part))
                     for part, row in zip(parts, rows, strict=True)]  # fmt: skip
            return [wall for each in inner for wall in each]
    shape = np.shape(value) if isinstance(value, np.ndarray) else ()
    if isinstance(value, list) and value and all(isinstance(item, Mapping) and len(item) == 4 for item in value):
        shape = (len(value), 4)
    if len(shape) == 2 and (2 not in shape or isinstance(value, list)) and 4 in shape:
        items = tables.items(name, value, sizes=(4,), columns="x1, y1, x2, y2", limit=MAX_CORNERS)
        return [tables.finite(name, np.array(item, dtype=float).reshape(2, 2)) for item in items]
    corners = np.array(tables.items(name, value, sizes=(2,), columns="x above y", limit=MAX_CORNERS), dtype=float)
    corners = corners.reshape(-1, 2)
    gaps = np.isnan(corners).all(axis=1)
    runs = np.split(corners, np.flatnonzero(gaps))
    walls = [run[~np.isnan(run).all(axis=1)] for run in runs]
    return [tables.finite(name, _distinct(wall)) for wall in walls if len(wall) > 1]


def _distinct(corners: Array) -> Array:
    """Return corners without consecutive duplicates."""
    keep = np.append(True, (np.diff(corners, axis=0) != 0.0).any(axis=1))
    return np.asarray(corners[keep])


def _on_faces(beacons: list[PlacedBeacon], walls: tuple[Array, ...]) -> tuple[list[PlacedBeacon], list[str]]:
    """Move beacons that would be inside walls, which have a thickness in a world, to the face on their side.

    Returns:
        The beacons, and a line about those that are moved.
    """
    ends = [pair for wall in walls for pair in itertools.pairwise(wall)]
    middle = np.vstack(walls).mean(axis=0) if walls else np.zeros(2)
    depth = Wall.model_fields["thickness"].default / 2.0
    placed = []
    for beacon in beacons:
        at = np.array(beacon.at)
        ahead = middle - at
        if beacon.heading is not None:
            ahead = np.array([math.cos(beacon.heading), math.sin(beacon.heading)])
        for start, end in ends:
            along = (end - start) / np.hypot(*(end - start))
            normal = np.array([-along[1], along[0]])
            normal = normal if normal @ ahead >= 0.0 else -normal
            reach = along @ (at - start)
            if abs(normal @ (at - start)) < depth and -depth < reach < np.hypot(*(end - start)) + depth:
                at = at + (depth - normal @ (at - start)) * normal
        placed.append(replace(beacon, at=_at(_rounded(at))))
    count = sum(new.at != old.at for new, old in zip(placed, beacons, strict=True))
    told = [f"{number_of(count, 'beacon')} in walls {2 * depth:g} m thick: moved to the faces"] if count else []
    return placed, told


def _told_walls(given: tuple[str, Any] | None, walls: tuple[Array, ...]) -> list[str]:
    if given is None:
        return []
    name = given[0]
    if not walls:
        return [f"{name} has fewer than two corners: no walls"]
    opened = sum(len(points) > 2 and not _is_closed(points) for points in walls)
    return [f"{name} does not end at its first corner: it stays open there"] if opened else []


def _is_closed(points: Array) -> bool:
    return len(points) > 3 and bool((points[0] == points[-1]).all())


def _wall(points: Array) -> Wall:
    closed = _is_closed(points)
    corners = points[:-1] if closed else points
    return Wall.model_validate({"points": corners.tolist(), "closed": closed})


def _beacon(name: str, placed: PlacedBeacon) -> Beacon:
    keys: dict[str, Any] = {"name": name, "at": placed.at}
    if placed.heading is not None:
        keys["heading_deg"] = round(math.degrees(placed.heading), DIGITS)
    if placed.picture is not None:
        keys |= {"image": placed.picture, "width": 0.6}
    return Beacon.model_validate(keys)


def _robot(preset: str, start: Array, heading: float, folder: Path | None, equipment: Equipment) -> Robot:
    noise = {"range": 0.05, "bearing_deg": 1.0}
    sensor = {"beacons": "ring", "range": [0.3, 8.0], "fov_deg": 180.0, "rate_hz": 5.0, "noise": noise}
    keys = {"name": ROBOT, "preset": equipment.preset or preset, "at": list(_at(start)), "heading_deg": heading}
    parts = {"sensors": [equipment.sensor_over(sensor)], "odometry": {"noise": ODOMETRY_NOISE}}
    return robot_of({**keys, **parts, **equipment.robot}, folder)


def _heading(start: Array, ahead: Array) -> float:
    """Return the direction from the start to the first waypoint that differs from it [deg]."""
    for point in ahead:
        if (point != start).any():
            dx, dy = point - start
            return round(math.degrees(math.atan2(dy, dx)), 1)
    return 0.0


def _rounded(points: Array) -> Array:
    return np.asarray(np.round(points, DIGITS) + 0.0)


def _at(point: Array) -> tuple[float, float]:
    x, y = point.tolist()
    return x, y
