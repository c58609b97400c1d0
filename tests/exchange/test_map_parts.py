"""Steps from cells of a map to walls: noise, directions, ends, each on cells made by hand."""

import math

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange.maps import cleaning
from mjsim.exchange.maps.cell_shapes import Bar
from mjsim.exchange.maps.strips import SAMPLE_SPACING, _goes_on, _main_direction, along_walls
from mjsim.geometry import Pose
from mjsim.world import Grid


def grid_of(occupied: np.ndarray, free: np.ndarray | None = None) -> Grid:
    return Grid(occupied, ~occupied if free is None else free, 0.05, Pose(0.0, 0.0, 0.0))


def noisy(share: float, shape: tuple[int, int] = (300, 400)) -> np.ndarray:
    return np.random.default_rng(2).random(shape) < share


@pytest.mark.parametrize("reach", [1, 2, 4])
@pytest.mark.parametrize("share", [0.001, 0.004])
def test_the_share_of_noise_follows_from_its_lonely_cells(share, reach):
    cells = noisy(share)
    found = cleaning._noise(cells, np.ones_like(cells), reach)
    # Poisson: the number of lonely cells has its own root as its deviation; 4 of them.
    assert found == pytest.approx(cells.mean(), rel=4 / math.sqrt(cells.sum()))


@pytest.mark.parametrize(
    ("sizes", "neighbours", "least"),
    [
        ([1] * 10, 0.05, 2),  # 0.5 pairs by chance
        ([1] * 100, 0.05, 3),  # 5 pairs, 0.25 triples
        ([1] * 100 + [2] * 17, 0.05, 3),  # as many as 3 x 5 + 2 are chance
        ([1] * 100 + [2] * 18, 0.05, 2),
        ([1] * 1000, 0.9, cleaning.MAX_SPECK),
    ],
)
def test_groups_are_things_if_chance_makes_fewer_than_one_or_they_are_too_many(sizes, neighbours, least):
    assert cleaning._least(np.array([0, *sizes]), neighbours) == least


def test_lone_cells_near_others_are_things_if_they_are_more_than_noise_makes():
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[30, 30] = True
    grid = grid_of(occupied)
    # 9 x 9 cells around it, of which one is not free: at a hundredth, 0.8 by chance.
    assert not cleaning.has_lone_things(grid, 4, noise=0.01)
    assert cleaning.has_lone_things(grid, 5, noise=0.01)


def test_walls_stay_and_specks_between_them_go():
    occupied = noisy(0.002)
    walls = np.zeros_like(occupied)
    walls[50:52, 40:360] = walls[50:250, 40:42] = True
    found = cleaning.without_specks(grid_of(occupied | walls))
    assert found.noise == pytest.approx(0.002, rel=0.3)
    assert (found.cells & walls).sum() == walls.sum()
    far = np.ones_like(walls)
    far[44:58, 34:366] = far[44:256, 34:48] = False
    assert (found.cells & far).sum() < 0.1 * (occupied & far).sum()


def test_a_map_of_more_parts_than_a_building_has_is_refused(monkeypatch):
    occupied = np.zeros((60, 60), dtype=bool)
    for row in (5, 25, 45):
        occupied[row : row + 5, 5:50] = True
    monkeypatch.setattr(cleaning, "MAX_PARTS", 3)
    assert cleaning.without_specks(grid_of(occupied)).cells.sum() == occupied.sum()
    monkeypatch.setattr(cleaning, "MAX_PARTS", 2)
    with pytest.raises(UsageError, match="the map has 3 parts"):
        cleaning.without_specks(grid_of(occupied))


def bars(*headings_and_lengths: tuple[float, float]) -> list[Bar]:
    return [Bar(0.0, 0.0, math.radians(heading), length, 2.0) for heading, length in headings_and_lengths]


@pytest.mark.parametrize(
    ("found", "main_deg"),
    [
        ([(20, 50), (110, 40), (-70, 30), (65, 20)], 20),
        ([(44, 50), (-46, 50)], 44),
        ([(46, 50), (136, 50)], -44),
        ([(0.2, 50), (90.25, 50)], 0),
        ([(20, 50), (21, 50)], 20.5),
        # What is short does not count, and the length counts by its square.
        ([(30, 5), (10, 7)], 10),
        ([(30, 10), (30, 10), (10, 15)], 10),
        ([(30, 5)], None),
    ],
)
def test_the_main_direction_is_that_of_the_longest_walls_within_an_eighth_turn(found, main_deg):
    main = _main_direction(bars(*found))
    assert (main is None) == (main_deg is None)
    if main is not None:
        assert math.degrees(main) == pytest.approx(main_deg, abs=1e-6)


@pytest.mark.parametrize(
    ("gap", "is_free", "goes_on"), [(10, True, True), (11, True, False), (40, False, True), (41, False, False)]
)
def test_a_wall_goes_on_over_a_short_gap_and_a_longer_one_that_nobody_has_seen(gap, is_free, goes_on):
    # 2.5 cells of free ground, or 10 of unknown, at four samples a cell.
    solid = np.array([True] * 20 + [False] * gap + [True] * 8 + [False] * 50)
    seen = np.zeros_like(solid)
    seen[20 : 20 + gap] = is_free
    assert _goes_on(solid, seen) == SAMPLE_SPACING * (20 + gap + 8 if goes_on else 20)
    assert _goes_on(np.zeros(9, dtype=bool), np.zeros(9, dtype=bool)) == 0.0


def test_lines_along_walls_become_bars_of_their_middle_width_and_length():
    cells = np.zeros((80, 120), dtype=bool)
    cells[20:24, 10:110] = cells[24:70, 60:63] = True
    lines = [np.array([[15.0, 21.0], [100.0, 22.5]]), np.array([[61.0, 30.0], [62.0, 60.0]])]
    found = along_walls(cells, cells, [*lines, lines[0] + 0.3], ~cells, thickest=8.0)
    assert len(found) == 2, "a wall that another explains is left out"
    for bar, (x, y, length, width, heading) in zip(
        found, [(60, 22, 100, 4, 0.0), (61.5, 45, 50, 3, math.pi / 2)], strict=True
    ):
        assert (bar.x, bar.y, bar.length, bar.width) == pytest.approx((x, y, length, width), abs=0.5)
        assert math.remainder(bar.heading - heading, math.pi) == pytest.approx(0.0, abs=0.01)
    # Where the map knows that more than a fifth of it is free, there is no wall.
    for until, count in ((50, 1), (110, 0)):
        free = np.zeros_like(cells)
        free[20, 10:until] = True
        assert len(along_walls(cells, cells, lines[:1], free, thickest=8.0)) == count
