"""The gallery as it is laid out, by geometry alone: what the camera can see on the tour, and room to pass."""

import itertools
import math
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely

import mjsim
from mjsim.geometry import Array
from mjsim.world import obstacle_polygons, solid, wall_polygons

GALLERY = Path(__file__).parents[2] / "worlds" / "gallery.yaml"
CORNERS = [(11.3, 1.9, 0), (11.3, 8.1, 90), (2.7, 8.1, 180), (2.7, 1.9, 270)]
"""Where the robot turns to the left, and its heading before [m, m, deg]."""
NEAR_WALL = 0.02
"""Points on pictures are taken this far in front of them, lest the wall behind hides them [m]."""


@pytest.fixture(scope="module")
def world() -> mjsim.World:
    return mjsim.load_world(GALLERY)


@pytest.fixture(scope="module")
def tour(world: mjsim.World) -> Array:
    """Poses every 10 cm along the lines between the waypoints, shape (n, 3)."""
    robot = world.robots[0]
    plan = world.run.drivers[robot.name].navigator.arguments()
    corners = np.array([robot.at, *plan["points"] * plan["laps"]])
    poses = []
    for start, stop in itertools.pairwise(corners):
        length = np.hypot(*(stop - start))
        shares = np.arange(0.0, 1.0, 0.1 / length)[:, None]
        heading = np.full((len(shares), 1), np.arctan2(*(stop - start)[::-1]))
        poses.append(np.hstack([start + shares * (stop - start), heading]))
    return np.concatenate(poses)


def in_view(world: mjsim.World, poses: Array, *, within: float) -> Array:
    """Return which beacons are wholly in the image, near, faced within 60 degrees, not hidden: (n, beacons)."""
    camera = world.robots[0].sensors[0]
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    eyes = poses[:, :2] + np.stack([c * camera.at[0], s * camera.at[0]], axis=1)
    wide = math.tan(math.radians(camera.fov_deg / 2))
    tall = wide * camera.height / camera.width
    high = wall_polygons(world, height=1.2) + obstacle_polygons(world, height=0.7)
    hiding = shapely.union_all([shapely.Polygon(outline) for outline in high])
    shapely.prepare(hiding)
    seen = np.zeros((len(poses), len(world.beacons)), dtype=bool)
    for column, beacon in enumerate(world.beacons):
        picture = cv2.imdecode(np.frombuffer(world.read_asset(beacon.image), dtype=np.uint8), cv2.IMREAD_COLOR)
        half = 0.5 * beacon.width * picture.shape[0] / picture.shape[1]
        facing = math.radians(beacon.heading_deg)
        normal = np.array([math.cos(facing), math.sin(facing)])
        to_eye = eyes - beacon.at
        distance = np.hypot(*to_eye.T)
        good = (to_eye @ normal > 0.5 * distance) & (distance < within)
        for share in (-0.5, 0.0, 0.5):
            point = beacon.at + share * beacon.width * np.array([-normal[1], normal[0]]) + NEAR_WALL * normal
            away = point - eyes
            ahead, left = away[:, 0] * c + away[:, 1] * s, away[:, 1] * c - away[:, 0] * s
            furthest = max(abs(beacon.center + half - camera.at[2]), abs(beacon.center - half - camera.at[2]))
            good &= (np.abs(left) < wide * ahead) & (furthest < tall * ahead)
            rays = np.stack([eyes, np.broadcast_to(point, eyes.shape)], axis=1)
            good &= ~shapely.intersects(hiding, shapely.linestrings(rays))
        seen[:, column] = good
    return seen


@pytest.mark.slow
def test_two_pictures_are_in_view_within_5_m_on_90_percent_of_the_tour(world, tour):
    assert np.mean(in_view(world, tour, within=5.0).sum(axis=1) >= 2) > 0.9


@pytest.mark.slow
def test_every_picture_is_well_seen_from_within_4_m(world, tour):
    """Over 1.5 m of the two laps or 20 degrees of a turn, which is at least some 15 images."""
    turns = [np.column_stack([np.tile(xy, (90, 1)), np.radians(np.arange(90) + begin)]) for *xy, begin in CORNERS]
    seen = in_view(world, tour, within=4.0).sum(axis=0) * 0.1
    turning = in_view(world, np.concatenate(turns), within=4.0).sum(axis=0)
    never = [beacon.name for beacon, m, deg in zip(world.beacons, seen, turning, strict=True) if m < 1.5 and deg < 20]
    assert never == []


def test_the_robot_passes_everything_with_35_cm_to_spare(world, tour):
    clearance = shapely.distance(solid(world), shapely.points(tour[:, :2])).min()
    assert clearance - world.robots[0].body.radius > 0.35


def test_pictures_hang_on_walls_that_reach_beyond_them(world):
    walls = shapely.union_all([shapely.Polygon(outline) for outline in wall_polygons(world, height=1.2)])
    for beacon in world.beacons:
        facing = math.radians(beacon.heading_deg)
        along, behind = np.array([-math.sin(facing), math.cos(facing)]), -np.array([math.cos(facing), math.sin(facing)])
        for share in (-0.49, 0.49):
            edge = beacon.at + share * beacon.width * along
            assert 0.0 < shapely.distance(walls, shapely.Point(edge)) < NEAR_WALL, beacon.name
            assert walls.contains(shapely.Point(edge + 0.03 * behind)), beacon.name


def test_pictures_do_not_overlap(world):
    lines = []
    for beacon in world.beacons:
        facing = math.radians(beacon.heading_deg)
        half = 0.5 * beacon.width * np.array([-math.sin(facing), math.cos(facing)])
        lines.append(shapely.LineString([beacon.at - half, beacon.at + half]))
    assert min(lines[i].distance(lines[k]) for i in range(len(lines)) for k in range(i)) > 0.03


def test_the_tour_fits_into_the_time_of_the_run(world, tour):
    plan = world.run.drivers["scout"].navigator.arguments()
    turns = 2 * len(plan["points"]) - 1
    assert 0.1 * len(tour) / plan["speed"] + 1.5 * turns < world.run.seconds < 150
