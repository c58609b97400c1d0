"""Importers as the guarded reader runs them: paths and options in, plain values out."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from mjsim.exchange.maps import claimed_size as size_of_file
from mjsim.exchange.maps import name_of, read_grid, world_from_grid
from mjsim.exchange.world_import import SCENE_SUFFIXES, Newcomer, Reading
from mjsim.guarded import Plain
from mjsim.world import format_world

NAMED_FILE, MAX_NAMED = 50_000, 500
"""Size counted for each file that a scene names [bytes], and the maximum number of files counted."""
NAMING = (b"<uri>", b"<mesh ", b"Mesh {", b"EXTERNPROTO")
"""Text before the name of a file in a scene."""
MAX_SCENE = 8_000_000
"""Maximum size of a scene in which such names are counted [bytes]."""


def claimed_size(path: Path) -> int:
    """Return the size with which the limits of reading a file grow: with those that a scene names [bytes]."""
    size = size_of_file(path)
    if path.suffix.lower() not in SCENE_SUFFIXES or size > MAX_SCENE:
        return size
    text = path.read_bytes()
    return size + NAMED_FILE * min(sum(map(text.count, NAMING)), MAX_NAMED)


def world_file(path: Path, robot: Newcomer | None, reading: Reading | None) -> Plain:
    """Return the text of a world made from a file, the lines of the report, and the files that the world names."""
    from mjsim.exchange.import_world import bring_file

    brought = bring_file(path, robot=robot, reading=reading)
    return brought.text, list(brought.report), dict(brought.files)


def dxf_world(path: Path, reading: Reading) -> Plain:
    """Return the text of the world in a DXF drawing."""
    from mjsim.exchange.drawings import read_dxf

    return _drawn(read_dxf(path, layers=reading.layers), path, reading)


def svg_world(path: Path, reading: Reading) -> Plain:
    """Return the text of the world in an SVG drawing."""
    from mjsim.exchange.drawings import read_svg

    return _drawn(read_svg(path, layers=reading.layers), path, reading)


def _drawn(drawing: Any, path: Path, reading: Reading) -> str:
    from mjsim.exchange.drawings import read_plan

    plan = read_plan(drawing, name=name_of(path), scale=reading.scale, thickness=reading.thickness)
    return format_world(plan.world)


def map_world(path: Path) -> Plain:
    """Return the text of the world of a map."""
    return format_world(world_from_grid(read_grid(path), name=name_of(path)))


def grid(path: Path, resolution: float | None) -> Plain:
    """Return the fields of the grid of a map."""
    found = read_grid(path, resolution=resolution)
    return found.occupied, found.free, found.resolution, _pose(found.world_from_grid)


def original(path: Path, world: Path | None, reading: Reading | None) -> Plain:
    """Return the fields of a map or drawing in its original form."""
    from mjsim.exchange.original_file import read_original

    found = _shallow(read_original(path, world=world, reading=reading))
    strokes = [_shallow(line) for line in found["strokes"]]
    return {**found, "strokes": strokes, "world_from_picture": _pose(found["world_from_picture"])}


def robot(path: Path, **options: Any) -> Plain:
    """Return the text of the preset of a robot, its files, and the lines of the report."""
    from mjsim.exchange.robots import bring_robot

    brought = bring_robot(path, **options)
    return brought.text, dict(brought.files), list(brought.report)


def _shallow(value: Any) -> Mapping[str, Any]:
    return {field.name: getattr(value, field.name) for field in fields(value)}


def _pose(pose: Any) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.heading
