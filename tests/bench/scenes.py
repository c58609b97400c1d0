"""The worlds that are measured, and where pictures of them are taken."""

import math
from importlib import resources
from pathlib import Path

import numpy as np

from mjsim.bench.large import large_floor
from mjsim.geometry import Pose
from mjsim.world import Camera, World, load_world, parse_world

LIDAR = "{lidar: scan, beams: 180, rate_hz: 12.5, noise: {range: 0.01}}"
CORNERS = ((2.7, 1.9), (11.3, 1.9), (11.3, 8.1), (2.7, 8.1))
"""Of the tour through the gallery, world frame [m]."""
OFFICE_ACROSS, OFFICE_UP = 7.0, 6.0
"""From room to room of the large floor [m]."""


def gallery() -> World:
    """Return the shipped gallery."""
    return load_world(Path(str(resources.files("mjsim.worlds") / "gallery.yaml")))


def gallery_with(width: int, height: int, **keys: object) -> World:
    """Return the gallery, its camera giving a picture of a size at every tick."""
    world = gallery()
    (robot,) = world.robots
    (camera,) = (sensor for sensor in robot.sensors if isinstance(sensor, Camera))
    wanted = {"width": width, "height": height, "rate_hz": world.run.rate_hz, **keys}
    changed = robot.model_copy(update={"sensors": (camera.model_copy(update=wanted),)})
    return world.model_copy(update={"robots": (changed,)})


def hall(sensors: str = "", *, robots: int = 1, walls: int = 100) -> World:
    """Return a hall with walls, 10 a column, and robots with some sensors."""
    standing = [
        f"{{points: [[{x}, {y}], [{x + 1}, {y + 0.5}]]}}"
        for x in range(-2 * (walls // 10), 2 * (walls // 10), 4)
        for y in range(1, 21, 2)
    ]
    team = [
        f"{{name: scout{k}, preset: pioneer3dx, at: [{4 * (k % 4)}, {-3 * (k // 4)}], sensors: [{sensors}]}}"
        for k in range(robots)
    ]
    return parse_world(f"mjsim: 1\nname: hall\nwalls: [{', '.join(standing)}]\nrobots: [{', '.join(team)}]\n")


def office(segments: int, width: int, height: int) -> World:
    """Return the large floor with so many wall segments, and a camera that gives a picture at every tick."""
    camera = f"{{camera: front, at: [0.1, 0, 1], width: {width}, height: {height}, rate_hz: 25, noise: 0}}"
    robot = f"robots: [{{name: scout, preset: pioneer3dx, at: [1.5, 1.5], sensors: [{camera}]}}]\n"
    return parse_world(large_floor(segments).partition("robots:")[0] + robot)


def gallery_places(count: int = 40) -> list[Pose]:
    """Return places on the tour through the gallery, looking about where it leads."""
    rng, places = np.random.default_rng(0), []
    for k in range(count):
        leg, way = divmod(4.0 * k / count, 1.0)
        (x, y), (x_next, y_next) = CORNERS[int(leg)], CORNERS[(int(leg) + 1) % 4]
        heading = math.atan2(y_next - y, x_next - x) + float(rng.uniform(-0.8, 0.8))
        places.append(Pose(x + way * (x_next - x), y + way * (y_next - y), heading))
    return places


def office_places(segments: int, count: int = 24) -> list[Pose]:
    """Return places in rooms of the large floor and between them, looking anywhere."""
    rng, across = np.random.default_rng(1), max(1, round((segments // 5) ** 0.5))
    within = ((1.5, 1.5), (4.5, 2.5), (-0.5, 2.0), (3.0, -0.5))
    places = []
    for k in range(count):
        (column, row), (x, y) = rng.integers(0, across, 2).tolist(), within[k % 4]
        places.append(Pose(OFFICE_ACROSS * column + x, OFFICE_UP * row + y, float(rng.uniform(-3.1, 3.1))))
    return places
