"""Importers of untrusted files: the guarded reader reads the files, and these functions convert its plain results."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from mjsim.errors import UsageError, how_to_install
from mjsim.exchange.world_import import SCENE_SUFFIXES, Brought, Newcomer, Reading
from mjsim.guarded import guarded, reader_for

if TYPE_CHECKING:
    from mjsim.exchange.robots import BroughtRobot, RobotOptions
    from mjsim.plan import Original
    from mjsim.world import Grid, World

INSIDE = "mjsim.exchange.inside"
ADVICE: Mapping[str, str] = {
    ".dxf": "save it as DXF R2000 or later",
    ".svg": "save it as plain SVG",
    ".m": "check that it is a script of literal assignments",
    ".world": "check that Gazebo opens it",
    ".sdf": "check that Gazebo opens it",
    ".xml": "check that MuJoCo opens it",
    ".wbt": "check that Webots opens it",
    ".mat": "write a MAT-file of version 5 to 7 with: save('-v7', 'map.mat', 'lm', 'wp')",
}
"""Kind of a file -> what to do if it cannot be read."""
SEEN_ABOVE = 4
"""Number of folders above the file of a robot in which its ROS packages are searched."""
DESCRIPTIONS = ("urdf", "xacro", "robots", "sdf")
"""Folders beside that of the meshes."""
MAX_MESHES = 16_000_000
"""Maximum size of meshes with which the limits grow [bytes]."""
MODEL_PATHS = ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH")
"""Variables of Gazebo with folders of models."""
MAX_LINKS = 1000
"""Maximum number of links beside a map that are followed."""


def bring_file(path: Path, *, robot: Newcomer | None, reading: Reading | None = None) -> Brought:
    """Return the world of a map's YAML file, a drawing, a MATLAB landmark map, or a scene of Gazebo, MuJoCo or Webots.

    Raises:
        UsageError: The file is none of these, or cannot be read.
    """
    place = [] if robot is None or robot.folder is None else [robot.folder]
    if path.suffix.lower() in SCENE_SUFFIXES:
        above, search = path.absolute().parents, _model_folders()
        place += [above[min(SEEN_ABOVE, len(above) - 1)], *search]
        reading = replace(reading or Reading(), models=search)
    return Brought(*_read("world_file", path, robot, reading, folders=place))


def world_from_dxf(
    path: str | Path, *, scale: float | None = None, thickness: float | None = None, layers: Sequence[str] = ()
) -> "World":
    """Return the world of the floor plan in a DXF file; its lower left corner becomes [0, 0].

    Args:
        path: The file.
        scale: Metres per unit of the drawing; required unless the file states it.
        thickness: Thickness of the walls [m]; by default as drawn, or 0.1 m for a wall drawn as one hairline.
        layers: Layers that contain walls; by default those whose names say so, or all that are visible.

    Raises:
        UsageError: The file cannot be read, or does not show the walls of a building.
    """
    return _world(_read("dxf_world", Path(path), Reading(scale, thickness, tuple(layers))))


def world_from_svg(
    path: str | Path, *, scale: float | None = None, thickness: float | None = None, layers: Sequence[str] = ()
) -> "World":
    """Return the world of the floor plan in an SVG file; its lower left corner becomes [0, 0].

    Args:
        path: The file.
        scale: Metres per user unit; required unless the file states it.
        thickness: Thickness of the walls [m]; by default as drawn, or 0.1 m for a wall drawn as one hairline.
        layers: Ids or Inkscape labels of the groups that contain walls; by default those whose names say so, or all.

    Raises:
        UsageError: The file cannot be read, or does not show the walls of a building.
    """
    return _world(_read("svg_world", Path(path), Reading(scale, thickness, tuple(layers))))


def world_from_map(path: str | Path) -> "World":
    """Return a world with the walls and obstacles of a ROS map_server or Nav2 map.

    Args:
        path: The map's YAML file.

    Raises:
        UsageError: The file is not a map, or is too large.
    """
    return _world(_read("map_world", Path(path)))


def read_grid(path: str | Path, *, resolution: float | None = None) -> "Grid":
    """Return the map of a YAML file and the image it names, or of an image without a YAML file.

    Args:
        path: The YAML file; or an image, black where occupied, white where free.
        resolution: Side of a cell, for an image without a YAML file [m].

    Raises:
        UsageError: The map does not exist, is too large, or is not a map.
    """
    from mjsim.geometry import Pose
    from mjsim.world import Grid

    occupied, free, cell, pose = _read("grid", Path(path), resolution)
    return Grid(occupied, free, cell, Pose(*pose))


def read_original(path: str | Path, *, world: str | Path | None = None, reading: Reading | None = None) -> "Original":
    """Return the original map or drawing of a file.

    Args:
        path: The YAML file of a map, or an SVG or DXF drawing.
        world: The world file made from it; its first lines state the drawing's position in it.
        reading: How the drawing was read, if the world file no longer says so.

    Raises:
        UsageError: The file is none of these, or cannot be read.
    """
    from mjsim.geometry import Pose
    from mjsim.plan import Original, Stroke

    made = None if world is None else Path(world)
    found = _read("original", Path(path), made, reading, folders=[] if made is None else _beside(made))
    strokes = [Stroke(**stroke) for stroke in found["strokes"]]
    return Original(**{**found, "strokes": strokes, "world_from_picture": Pose(*found["world_from_picture"])})


def bring_robot(
    path: Path,
    *,
    name: str,
    options: "RobotOptions",
    packages: Mapping[str, Path],
    arguments: Mapping[str, str],
    environment: Mapping[str, str] = MappingProxyType({}),
) -> "BroughtRobot":
    """Return the preset of a robot from a URDF, xacro, SDF or MJCF file.

    Args:
        path: The file.
        name: Name of the robot, and of the folder of its files.
        options: What the file leaves open.
        packages: Folders of ROS packages by name.
        arguments: Arguments of xacro.
        environment: Values of `$(env NAME)` and `$(optenv NAME)` in xacro; a file reads no other variables.

    Raises:
        UsageError: The file cannot be read, its wheels are missing or ambiguous, or the robot does not drive.
        PhysicsFault: The simulation became unstable.
    """
    from mjsim.exchange.robots import BroughtRobot

    above = Path(os.path.realpath(path)).parents
    search = [*_package_folders(), *_model_folders()]
    folders = [above[min(SEEN_ABOVE, len(above) - 1)], *packages.values(), *search]
    xacro = {"arguments": dict(arguments), "environment": dict(environment)}
    keywords: dict[str, Any] = {"name": name, "options": options, "packages": dict(packages), "search": search, **xacro}
    size = _size_with_meshes(path)
    return BroughtRobot(*guarded(f"{INSIDE}:robot", path, about=path, size=size, folders=folders, **keywords))


def _size_with_meshes(path: Path) -> int:
    """Return the size of the files around a robot's, of which its meshes are the largest [bytes]."""
    folder = path.absolute().parent
    around = folder.parent if folder.name in DESCRIPTIONS else folder
    files = (Path(place, name) for place, _, names in os.walk(around) for name in names)
    return min(sum(file.stat().st_size for file in islice(files, MAX_LINKS) if file.is_file()), MAX_MESHES)


def _model_folders() -> list[Path]:
    """Return the folders in which the user keeps models of Gazebo, as its variables name them."""
    entries = [entry for key in MODEL_PATHS for entry in os.environ.get(key, "").split(os.pathsep)]
    return [Path(entry) for entry in entries if entry]


def _package_folders() -> list[Path]:
    """Return the folders in which the user keeps ROS packages, as the variables of ROS 1 and ROS 2 name them."""
    first, second = (os.environ.get(key, "").split(os.pathsep) for key in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"))
    return [*(Path(entry) for entry in first if entry), *(Path(entry) / "share" for entry in second if entry)]


def _read(function: str, path: Path, *arguments: Any, folders: Sequence[Path] = ()) -> Any:
    """Return the result of a function of `inside` for a file."""
    if path.suffix.lower() == ".dxf":
        _require_ezdxf()
    called = f"{INSIDE}:{function}"
    advice = ADVICE.get(path.suffix.lower(), "check that it is a complete map, drawing or landmark map")
    with reader_for(called, folders=[*_beside(path), *folders]) as reader:
        size = reader.call(f"{INSIDE}:claimed_size", path, about=path, advice=advice)
        return reader.call(called, path, *arguments, about=path, size=size, advice=advice)


def _require_ezdxf() -> None:
    """Raise UsageError if the library that reads DXF is not installed."""
    try:
        found = find_spec("ezdxf") is not None
    except ValueError:  # it is blocked
        found = False
    if not found:
        raise UsageError(f"DXF files need ezdxf, which is not installed; type: {how_to_install('ezdxf')}")


def _beside(path: Path) -> list[Path]:
    """Return the folder of a file, and the targets of links: of the file itself, and beside it."""
    folder = path.absolute().parent
    links = []
    if folder.is_dir():
        with os.scandir(folder) as entries:
            links = [
                Path(os.path.realpath(entry.path))
                for _, entry in zip(range(MAX_LINKS), entries, strict=False)
                if entry.is_symlink()
            ]
    return [folder, Path(os.path.realpath(path)).parent, *links]


def _world(text: str) -> "World":
    from mjsim.world import parse_world

    return parse_world(text)
