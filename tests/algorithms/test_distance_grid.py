"""Distances to walls in a grid, compared with those that shapely works out."""

import numpy as np
import pytest
import shapely

from mjsim.algorithms.scans.distance_grid import DistanceGrid

CORNERS = np.array([(0, 0), (10, 0), (10, 4), (6, 4), (6, 7), (0, 7)], dtype=float)
POST = np.array([(2, 3), (3, 3), (3, 3.5), (2, 3.5)], dtype=float)
WALLS = np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in (CORNERS, POST)])
ROOM = shapely.Polygon(CORNERS).difference(shapely.Polygon(POST))


def test_the_distance_is_that_to_the_nearest_wall():
    grid = DistanceGrid.from_segments(WALLS, cell=0.05)
    points = np.random.default_rng(1).uniform((0, 0), (10, 7), (300, 2))
    expected = shapely.distance(shapely.points(points), shapely.MultiLineString(WALLS.tolist()))
    np.testing.assert_allclose(grid.at(points), expected, atol=0.09)


def test_centres_lie_in_their_cells():
    grid = DistanceGrid(np.zeros((4, 7), dtype=bool), lower=np.array([-1.0, 2.0]), cell=0.5)
    cells = np.argwhere(np.ones((4, 7), dtype=bool))
    np.testing.assert_array_equal(grid.cells(grid.centres(cells)), cells)
    assert grid.centres(cells).min(axis=0).tolist() == [-0.75, 2.25]


def test_the_largest_region_is_what_walls_enclose():
    places = DistanceGrid.from_segments(WALLS, cell=0.05).largest_region(0.2)
    assert shapely.contains_xy(ROOM, *places.T).all()
    assert len(places) * 0.05**2 == pytest.approx(ROOM.buffer(-0.2).area, rel=0.05)


def test_a_line_is_clear_where_a_disc_could_pass():
    grid = DistanceGrid.from_segments(WALLS, cell=0.02)
    rng = np.random.default_rng(2)
    for one, other in rng.uniform((0.4, 0.4), (5.6, 6.6), (200, 2, 2)):
        room = shapely.distance(shapely.LineString([one, other]), shapely.MultiLineString(WALLS.tolist()))
        inside = not shapely.Polygon(POST).intersects(shapely.LineString([one, other]))
        if inside and abs(room - 0.3) > 0.04:
            assert grid.is_clear(one, other, 0.3) == (room > 0.3)


def test_a_map_without_walls_is_an_error():
    with pytest.raises(ValueError, match="no walls"):
        DistanceGrid.from_segments(np.zeros((0, 2, 2)))


def test_a_wall_that_is_drawn_finer_than_cells_is_where_it_is():
    wall = np.array([[[0.0, 0.0], [2.0, 0.0]], [[0.0, 0.513], [2.0, 0.513]]])
    off = []
    for finer in (1, 5):
        grid = DistanceGrid.from_segments(wall, cell=0.05, finer=finer)
        rows = np.arange(grid.distance.shape[0])
        centres = grid.lower[1] + (rows + 0.5) * grid.cell
        expected = np.minimum(np.abs(centres), np.abs(centres - 0.513))
        off.append(np.abs(grid.distance[:, grid.distance.shape[1] // 2] - expected).max())
    assert off[0] > 0.015
    # Half of a fifth of a cell, and the rounding of OpenCV.
    assert off[1] < 0.007
