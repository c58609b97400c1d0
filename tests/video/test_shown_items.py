"""What modules show is drawn on the plan of a film: where it is, in its frame."""

import numpy as np

import mjsim
from mjsim.interface import ShownGrid, ShownLines, ShownPoints
from mjsim.plan import bounds_of
from mjsim.video.moment import Moment
from mjsim.video.run_plan import shown_items


def moment(*shown, estimate=(2.0, 1.0, np.pi / 2)):
    pose = np.array(estimate)
    return Moment(
        time=0.0, truth=np.zeros(3), estimate=pose, covariance=np.eye(3), odometry=pose, names=(),
        means=np.zeros((0, 2)), covariances=np.zeros((0, 2, 2)), sightings=(), picture=None, touched=False, shown=shown,
    )  # fmt: skip


def test_lines_and_points_are_drawn_in_their_frame_and_colour():
    line = ShownLines(name="way", points=[[0, 0], [1, 0]], frame="estimate", color="#112233")
    dots = ShownPoints(name="dots", points=[[5, 6]])
    path, points = shown_items(moment(line, dots))
    np.testing.assert_allclose(path.placed(1.0), [[[2, 1], [2, 2]]], atol=1e-12)
    assert path.paint().line == (0x11, 0x22, 0x33)
    np.testing.assert_allclose(points.placed(1.0), [[[5, 6]]])
    assert list(shown_items(moment(line, estimate=(np.nan, 0, 0)))) == []


def test_occupied_cells_of_a_grid_are_outlined():
    cells = np.zeros((4, 6))
    cells[1, 2:5] = 1.0
    cells[3, 0] = 0.7
    cells[0, 0] = np.nan
    grid = ShownGrid(name="map", cells=cells, resolution=0.5, origin=mjsim.Pose(1.0, 2.0, 0.0))
    (item,) = shown_items(moment(grid))
    _, run = item.placed(1.0)
    np.testing.assert_allclose([run.min(axis=0), run.max(axis=0)], [[2.0, 2.5], [3.5, 3.0]], atol=0.07)
    np.testing.assert_allclose(bounds_of([item])[0], [1.0, 2.5], atol=0.15)
