"""Coverage against a raster, and the area that a footprint sweeps against geometry."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import ndimage

import mjsim
from mjsim.report.coverage import coverage, reachable_region
from mjsim.report.statistics import swept_share
from mjsim.world import solid
from tests.report.test_statistics import ROOM


def raster_coverage(world, positions, radius, *, step=0.01):
    """Count cells on a fine raster: flood fill for reach, distance to every position for touch."""
    import shapely

    things = solid(world)
    west, south, east, north = things.bounds
    x, y = np.arange(west + step / 2, east, step), np.arange(south + step / 2, north, step)
    points = shapely.points(*np.meshgrid(x, y))
    free = shapely.distance(things, points) > radius + 0.15
    labels, _ = ndimage.label(free)
    home = labels[np.searchsorted(y, positions[0, 1]), np.searchsorted(x, positions[0, 0])]
    reached = touched = 0
    for low_x in np.arange(np.floor(west / 0.5), np.ceil(east / 0.5)) * 0.5:
        for low_y in np.arange(np.floor(south / 0.5), np.ceil(north / 0.5)) * 0.5:
            column, row = np.searchsorted(x, low_x + 0.25), np.searchsorted(y, low_y + 0.25)
            if not (column < len(x) and row < len(y) and labels[row, column] == home):
                continue
            reached += 1
            nearest = np.clip(positions, [low_x, low_y], [low_x + 0.5, low_y + 0.5])
            touched += np.hypot(*(positions - nearest).T).min() <= radius
    return touched / reached


@pytest.mark.slow
def test_coverage_equals_that_of_a_fine_raster():
    world = mjsim.parse_world(ROOM)
    way = np.concatenate([np.linspace([0.8, 2.53], [2.9, 2.53], 400), np.linspace([2.9, 2.53], [3.1, 0.9], 400)])
    share = coverage(world, way, radius=0.2)
    assert share == pytest.approx(raster_coverage(world, way, 0.2), abs=1e-9)
    assert 0.3 < share < 1.0


def test_a_room_that_cannot_be_reached_does_not_count():
    world = mjsim.parse_world(ROOM)
    sweep = np.array([(x, y) for y in np.arange(0.4, 3.7, 0.1) for x in np.arange(0.4, 3.7, 0.1)])
    assert coverage(world, sweep[::-1], radius=0.2) == 1.0


@pytest.mark.slow
def test_a_hundred_laps_cover_what_one_does_and_standing_still_covers_a_disc():
    world = mjsim.parse_world(ROOM)
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    lap = np.stack([2.0 + np.cos(turn), 2.0 + np.sin(turn)], axis=1)
    assert coverage(world, np.tile(lap, (100, 1)), radius=0.2) == coverage(world, lap, radius=0.2)
    share = coverage(world, lap[:1], radius=0.2)
    assert share == coverage(world, np.repeat(lap[:1], 3, axis=0), radius=0.2) == raster_coverage(world, lap[:1], 0.2)


BOX_ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, thickness: 0.1}]
robots: [{name: scout, preset: pioneer3dx, at: [1, 2], body: BODY}]
"""


@pytest.mark.parametrize(
    ("body", "path", "width"),
    [
        ("{box: [0.6, 0.4, 0.3]}", [(1, 2, 0), (5, 2, 0)], 0.4),
        ("{box: [0.6, 0.4, 0.3]}", [(1, 2, np.pi / 2), (5, 2, np.pi / 2)], 0.6),
        ("{radius: 0.25}", [(1, 2, 0), (5, 2, 0)], 0.5),
    ],
)
def test_swept_area_is_that_of_the_footprint_along_its_way(body, path, width):
    world = mjsim.parse_world(BOX_ROOM.replace("BODY", body))
    (robot,) = world.robots
    poses = np.concatenate([np.linspace(path[0], path[1], 300)] * 3)
    margin = 0.05 + robot.body.radius + 0.15
    reachable = (6 - 2 * margin) * (4 - 2 * margin)
    ahead = robot.body.outline() @ [[np.cos(path[0][2])], [np.sin(path[0][2])]]
    swept = width * 4 + (np.ptp(ahead) * width if "box" in body else np.pi * 0.25**2)
    inside = width * (6 - 2 * margin)
    assert swept_share(world, robot, poses) == pytest.approx(min(swept, inside) / reachable, rel=0.02)


def test_swept_area_is_that_of_every_pose_on_the_way():
    from shapely import MultiPoint, Polygon, affinity, union_all

    text = BOX_ROOM.replace("BODY", "{box: [0.6, 0.3, 0.3]}").replace(
        "6, 0], [6, 4], [0, 4", "4, 0], [4, 3.4], [0, 3.4"
    )
    world = mjsim.parse_world(text + "obstacles: [{box: [0.2, 0.2, 1.0], at: [2.0, 1.7]}]\n")
    (robot,) = world.robots

    def placed(x, y, heading):
        there = affinity.rotate(Polygon(robot.body.outline()), heading, origin=(0, 0), use_radians=True)
        return affinity.translate(there, x, y)

    for start, end in [((0.8, 1.0, 0.0), (0.8, 1.0, 2.0)), ((0.7, 0.8, 0.6), (1.1, 0.8 + 0.4 * np.tan(0.6), 0.6))]:
        path = np.linspace(start, end, 60)
        corners = [list(placed(*pose).exterior.coords) for pose in path]
        swept = union_all([MultiPoint(a + b).convex_hull for a, b in pairwise(corners)])
        region = reachable_region(world, path[:, :2], radius=robot.body.radius)
        expected = swept.intersection(region).area / region.area
        assert swept_share(world, robot, path) == pytest.approx(expected, rel=0.0095)
    start, end = np.array([0.8, 1.0, 0.0]), np.array([0.819, 1.0, 0.0])
    added = swept_share(world, robot, np.array([start, end])) - swept_share(world, robot, start[None])
    region = reachable_region(world, start[None, :2], radius=robot.body.radius)
    assert added == pytest.approx(0.019 * 0.3 / region.area, rel=0.3)


def test_a_world_without_walls_has_no_coverage():
    world = mjsim.parse_world("mjsim: 1\nrobots: [{name: scout, at: [0, 0]}]\n")
    assert coverage(world, np.zeros((2, 2)), radius=0.2) is None
