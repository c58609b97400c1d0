"""Parts of maps by themselves: pixels, rectangles, gaps, each of known figures."""

import math

import cv2
import numpy as np
import pytest
from scipy.signal import convolve2d

from mjsim.exchange.maps.cell_shapes import Bar, bar_between, cells_in, fitted_bar, fitted_disc, fitted_rectangle
from mjsim.exchange.maps.gather import gathered
from mjsim.exchange.maps.map_pixels import claimed_pixels, gray_of
from mjsim.exchange.maps.tidy import _without_pinholes, tidied
from mjsim.geometry import Pose
from mjsim.world import Grid


def pnm(kind: int, size: str, data: bytes) -> bytes:
    return b"P%d\n# a comment\n%s\n" % (kind, size.encode()) + data


GRAYS = np.array([[0.0, 0.2, 1.0], [0.4, 0.6, 0.8]])


@pytest.mark.parametrize(
    ("data", "levels"),
    [
        (pnm(2, "3 2\n10", b"0 2 10\n4 6 8"), 10),
        (pnm(5, "3 2\n10", bytes([0, 2, 10, 4, 6, 8])), 10),
        (pnm(5, "3 2\n1000", np.array([0, 200, 1000, 400, 600, 800], ">u2").tobytes()), 1000),
        (pnm(3, "3 2\n10", b" ".join(b"%d %d %d" % (k, k, k) for k in (0, 2, 10, 4, 6, 8))), 10),
        (pnm(6, "3 2\n10", bytes(k for k in (0, 2, 10, 4, 6, 8) for _ in range(3))), 10),
    ],
)
def test_portable_greymaps_are_shares_of_white(data, levels):
    gray, opaque = gray_of(data)
    assert gray == pytest.approx(GRAYS, abs=1e-6)
    assert opaque.all()
    assert claimed_pixels(data) == 6


def test_bits_of_a_bitmap_are_black():
    for data in (pnm(1, "3 2", b"101\n0 1 0"), pnm(4, "3 2", bytes([0b10100000, 0b01000000]))):
        assert gray_of(data)[0].tolist() == [[0, 1, 0], [1, 0, 1]]
    wide = np.zeros((2, 9), np.uint8)
    wide[1, 8] = 1
    assert gray_of(pnm(4, "9 2", np.packbits(wide, axis=1).tobytes()))[0].tolist() == (1 - wide).tolist()


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (pnm(5, "3 2\n255", bytes(5)), "is truncated; 3 x 2 pixels need 6 numbers"),
        (pnm(5, "0 2\n255", bytes(5)), "is a picture of 0 x 2 pixels with values up to 255"),
        (pnm(5, "3 0\n255", bytes(5)), "is a picture of 3 x 0 pixels"),
        (pnm(5, "3 2\n0", bytes(6)), "up to 0; write 8 or 16 bits per pixel"),
        (pnm(5, "3 2\n65536", bytes(12)), "up to 65536"),
        (pnm(2, "3 2\n9", b"1 2 x 4 5 6"), "a value that is not a number"),
        (b"P9 3 2", "is not a PGM, PPM, PNG or JPEG"),
        (b"BM nothing", "is a truncated picture"),
    ],
)
def test_what_is_no_picture_of_a_map_is_refused(data, said):
    with pytest.raises(ValueError, match=said):
        gray_of(data)
    assert claimed_pixels(b"nothing") == 0


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_channels_of_a_png_are_averaged_and_half_transparent_is_unknown(kind, channels):
    top = int(np.iinfo(kind).max)
    picture = np.zeros((2, 3, channels), kind)
    picture[0, 1, : min(channels, 3)] = top
    picture[1, 2, 0] = top
    if channels == 4:
        picture[..., 3] = top
        picture[0, 0, 3] = int(top * 0.4)
    gray, opaque = gray_of(cv2.imencode(".png", picture if channels > 1 else picture[..., 0])[1].tobytes())
    expected = np.zeros((2, 3))
    expected[0, 1], expected[1, 2] = 1.0, 1.0 / min(channels, 3)
    assert gray == pytest.approx(expected, abs=1e-6)
    assert np.argwhere(~opaque).tolist() == ([[0, 0]] if channels == 4 else [])


@pytest.mark.parametrize("heading", [0.0, 0.4, 1.2, -0.9])
def test_rectangles_and_discs_are_fitted_to_cells(heading):
    bar = Bar(40.0, 35.0, heading, 40.0, 8.0)
    window, cells = cells_in(bar.outline(), (80, 80))
    grid = np.zeros((80, 80), bool)
    grid[window] = cells
    assert np.count_nonzero(grid) == pytest.approx(320, rel=0.05)
    found, share = fitted_bar(np.argwhere(grid)[:, ::-1] + 0.5)
    assert (found.x, found.y, found.length, found.width) == pytest.approx((40, 35, 40, 8), abs=0.4)
    assert abs(math.sin(found.heading - heading)) < 0.02
    assert share > 0.9
    disc, poor = fitted_disc(np.argwhere(grid)[:, ::-1] + 0.5)
    assert (disc.radius, poor < 0.5) == (pytest.approx(math.sqrt(320 / math.pi), rel=0.03), True)
    y, x = np.mgrid[:40, :40] + 0.5
    round_ = np.hypot(x - 20, y - 18) <= 9.0
    disc, share = fitted_disc(np.argwhere(round_)[:, ::-1] + 0.5)
    assert (disc.x, disc.y, disc.radius) == pytest.approx((20, 18, 9), abs=0.1)
    assert share > 0.95
    again = bar_between(*bar.ends, bar.width)
    assert (again.x, again.y, again.length) == pytest.approx((40, 35, 40))
    assert abs(math.sin(again.heading - heading)) < 1e-9


@pytest.mark.parametrize("heading", [0.0, 0.5, 1.3, -0.8])
def test_fragments_of_a_broken_bar_are_one_bar_and_a_thing_beside_it_is_another(heading):
    across = np.array([-math.sin(heading), math.cos(heading)])
    whole = Bar(60.0, 55.0, heading, 80.0, 4.0)
    # Five pieces, 12 long, with gaps of 5.
    pieces = [Bar(*(whole.along * 17 * k + [60.0, 55.0]), heading, 12.0, 4.0) for k in range(-2, 3)]
    beside = Bar(*(across * 30 + [60.0, 55.0]), heading, 12.0, 4.0)
    grids = []
    for bar in (*pieces, beside):
        grids.append(np.zeros((130, 130), bool))
        window, cells = cells_in(bar.outline(), (130, 130))
        grids[-1][window] = cells
    (found,), others = gathered([np.argwhere(grid)[:, ::-1] + 0.5 for grid in grids], gap=8.0)
    assert (found.x, found.y, found.length) == pytest.approx((60, 55, 80), abs=1.0)
    assert found.width == pytest.approx(4.0, abs=1.0)
    assert abs(math.sin(found.heading - heading)) < 0.02
    assert [len(part) for part in others] == [np.count_nonzero(grids[-1])]
    assert len(gathered([np.argwhere(grid)[:, ::-1] + 0.5 for grid in grids], gap=4.0)[1]) == 6


def test_four_corners_are_a_rectangle_or_not():
    bar = Bar(1.0, 2.0, 0.3, 4.0, 0.5)
    found = fitted_rectangle(bar.outline())
    assert (found.x, found.y, found.length, found.width) == pytest.approx((1.0, 2.0, 4.0, 0.5))
    assert abs(math.sin(found.heading - 0.3)) < 1e-9
    grown = fitted_rectangle(bar.outline(grown=0.25))
    assert (grown.length, grown.width) == pytest.approx((4.5, 1.0))
    for other in ([[0, 0], [2, 0], [3, 1], [1, 1]], [[0, 0], [2, 0], [2, 1], [0, 1.1]], [[0, 0], [1, 0], [1, 1]]):
        assert fitted_rectangle(np.array(other, dtype=float)) is None


def test_gaps_in_walls_are_closed_and_hollow_things_are_solid():
    occupied, free = np.zeros((60, 60), bool), np.zeros((60, 60), bool)
    free[2:58, 2:58] = True
    occupied[9:12, 5:50] = True
    occupied[9:12, 20] = False  # a crack of one cell
    occupied[9:12, 30:34] = False  # a doorway of 0.2 m stays
    for low, high in ((30, 34), (41, 56)):  # a pillar of faces alone, and a room
        occupied[low, low : high + 1] = occupied[high, low : high + 1] = True
        occupied[low : high + 1, low] = occupied[low : high + 1, high] = True
    free[31:34, 31:34] = False
    free &= ~occupied
    found = tidied(occupied, Grid(occupied, free, 0.05, Pose(0.0, 0.0, 0.0)))
    assert found[10, 20]
    assert not found[9:12, 30:34].any()
    assert found[30:35, 30:35].all()
    assert not found[45:52, 45:52].any()
    # The pillar, and a cell in each inner corner of the room.
    assert (found & ~occupied)[13:].sum() == 9 + 4


def test_a_cell_with_six_occupied_neighbours_is_a_pinhole():
    cells = np.random.default_rng(0).random((40, 50)) < 0.65
    around = convolve2d(cells, [[1, 1, 1], [1, 0, 1], [1, 1, 1]], mode="same")
    assert {5, 6} <= set(around[~cells].tolist())
    np.testing.assert_array_equal(_without_pinholes(cells), cells | (around >= 6))
