"""Charts, texels, cells, windows, doors and probes of a world against searches that find the same another way."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mjsim.compile import compile_world, compiled
from mjsim.light.charts import charts_of
from mjsim.light.emitters import behind, inside_of, window_rectangles
from mjsim.light.light_geometry import OPEN_ANGLE, atlas_of, moved_doors
from mjsim.light.light_rays import WINDOW_CELL, Room, hemisphere
from mjsim.light.probes import ProbeGrid, grid_of
from mjsim.light.spread import filled, finer
from mjsim.light.texel_links import links_of
from mjsim.light.texels import cells_of, texels_of
from mjsim.light.work import Surroundings, gathered
from mjsim.world import parse_world
from tests.light.test_rays import UP, points_at, square


@pytest.fixture(scope="module")
def plates():
    """An upright plate of 1 m x 0.6 m, turned, and a level one of 0.5 m x 0.4 m: triangles with normals."""
    turned = np.array([math.cos(0.5), math.sin(0.5), 0.0])
    corners = np.concatenate(
        [square([1, 2, 0.3], 0.5 * turned, [0, 0, 0.3]), square([0, 0, 1], [0.25, 0, 0], [0, 0.2, 0])]
    )
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.repeat(normals / np.linalg.norm(normals, axis=1)[:, None], 3, axis=0).reshape(-1, 3, 3)
    charts = charts_of(corners, normals, texel=0.1)
    return corners, normals, charts, texels_of(corners, normals, charts)


def test_a_texel_lies_on_its_surface_at_the_middle_of_its_place_on_the_atlas(plates):
    corners, normals, charts, texels = plates
    assert [len(set(charts.of[pair].tolist())) for pair in ([0, 1], [2, 3], [0, 2])] == [1, 1, 2]
    assert sorted(charts.count.tolist()) == [[5, 4], [10, 6]]
    assert len(texels.at) == 10 * 6 + 5 * 4
    of = charts.of[texels.triangles]
    place = np.stack([texels.at % charts.shape[1], texels.at // charts.shape[1]], axis=1)
    np.testing.assert_allclose(charts.on_atlas(texels.points, of), place + 0.5, atol=1e-6)
    np.testing.assert_array_equal(charts.texel(texels.points, of), texels.at)
    np.testing.assert_allclose(texels.normals, normals[texels.triangles, 0], atol=1e-9)
    a = corners[texels.triangles, 0]
    np.testing.assert_allclose(np.einsum("ij,ij->i", texels.points - a, texels.normals), 0.0, atol=1e-9)
    # Columns are level, rows go down or up, and neighbours are a texel apart.
    first = charts.of[0]
    assert charts.across[first][2] == pytest.approx(0.0)
    assert abs(charts.down[first][2]) == pytest.approx(1.0)
    near, _ = cKDTree(texels.points).query(texels.points, k=2)
    np.testing.assert_allclose(near[:, 1], 0.1, rtol=1e-6)
    for chart in range(2):
        (x, y), (columns, rows) = charts.place[chart], charts.count[chart]
        others = np.delete(np.arange(2), chart)
        assert 0 < x < charts.shape[1] - columns
        assert 0 < y < charts.shape[0] - rows
        for (left, top), (wide, high) in zip(charts.place[others], charts.count[others], strict=True):
            assert left >= x + columns + 2 or left + wide + 2 <= x or top >= y + rows + 2 or top + high + 2 <= y


def test_small_triangles_have_a_texel_each_and_those_without_area_none():
    speck = np.array([[[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0]], [[5, 5, 5], [5, 5, 5], [6, 6, 6]]], float)
    normals = np.tile(UP, (2, 3, 1))
    charts = charts_of(speck, normals, texel=1.0)
    texels = texels_of(speck, normals, charts)
    assert charts.of.tolist() == [0, -1]
    np.testing.assert_allclose(texels.points, [[0.005, 0.005, 0.0]])


def test_cells_hold_neighbours_that_see_each_other_and_are_led_by_the_middle_one(plates):
    corners, _, charts, texels = plates
    # A board across the level plate parts it.
    board = square([0.05, 0, 1.0], [0, 1, 0], [0, 0, 1])
    room = Room(np.concatenate([corners, board]).astype(np.float32))
    valid = np.ones(len(texels.at), dtype=bool)
    valid[:3] = False
    links = links_of(room, texels, charts.shape, valid)
    on_board_side = texels.points[:, 0] > 0.05
    level = texels.normals[:, 2] ** 2 > 0.5
    expected = set()
    for one, other in cKDTree(texels.points).query_pairs(0.11):
        parted = level[one] and on_board_side[one] != on_board_side[other]
        if valid[one] and valid[other] and not parted:
            expected.add(frozenset((one, other)))
    assert {frozenset(pair) for pair in links.pairs.tolist()} == expected
    assert len(links.pairs) == len(expected)
    cells = cells_of(texels, valid, charts, 2, links.pairs)
    assert (cells.of[:3] == -1).all()
    place = np.stack([texels.at % charts.shape[1], texels.at // charts.shape[1]], axis=1)
    for cell in range(len(cells.lead)):
        members = np.flatnonzero(cells.of == cell)
        assert np.ptp(place[members], axis=0).max() <= 1
        assert len({bool(level[each] and on_board_side[each]) for each in members}) == 1
        assert cells.lead[cell] in members
        np.testing.assert_array_equal(cells.middles[cell], place[cells.lead[cell]])
    values = np.random.default_rng(0).normal(size=(len(texels.at), 2)).astype(np.float32)
    means = [values[cells.of == cell].mean(axis=0) for cell in range(len(cells.lead))]
    np.testing.assert_allclose(cells.mean(values), means, rtol=1e-5)
    # One round of smoothing: the mean over a texel and what is linked to it.
    near = {each: [each] for each in range(len(values))}
    for one, other in links.pairs.tolist():
        near[one].append(other)
        near[other].append(one)
    smooth = [values[near[each]].mean(axis=0) for each in range(len(values))]
    np.testing.assert_allclose(links.smoothed(values, 1), smooth, atol=1e-6)
    np.testing.assert_allclose(links.smoothed(values, 2), links.smoothed(links.smoothed(values, 1), 1))
    # Straight ways along rows and columns are clear where all their links are.
    for one, other in np.random.default_rng(1).integers(0, len(place), (60, 2)).tolist():
        step = place[other] - place[one]
        if np.abs(step).max() <= 3 and not step.all() and np.ptp(charts.of[texels.triangles[[one, other]]]) == 0:
            way = [place[one] + k * np.sign(step) for k in range(int(np.abs(step).max()) + 1)]
            whole = [int(np.flatnonzero((place == at).all(axis=1))[0]) for at in way]
            clear = all(frozenset(pair) in expected for pair in itertools.pairwise(whole))
            assert links.reach(place[[one]], place[[other]], 3)[0] == clear
    # What is even remains so between cells, on either side of the board.
    side = np.where(level & on_board_side, 2.0, 1.0).astype(np.float32)[:, None]
    np.testing.assert_allclose(finer(cells.mean(side), cells, texels, links, 2)[valid], side[valid], rtol=1e-5)
    assert not finer(cells.mean(side), cells, texels, links, 2)[~valid].any()


def test_light_between_cells_is_linear():
    corners = square([0, 0, 0], [0.8, 0, 0], [0, 0.8, 0])
    normals = np.tile(UP, (2, 3, 1))
    charts = charts_of(corners, normals, texel=0.1)
    texels, valid = texels_of(corners, normals, charts), np.ones(256, dtype=bool)
    links = links_of(Room(corners.astype(np.float32)), texels, charts.shape, valid)
    cells = cells_of(texels, valid, charts, 2, links.pairs)
    values = (texels.points[cells.lead] @ [1.0, 2.0, 0.0])[:, None].astype(np.float32)
    inner = np.abs(texels.points[:, :2]).max(axis=1) < 0.5
    fine = finer(values, cells, texels, links, 2)[inner, 0]
    # The lead of a cell is half a texel beside its middle.
    np.testing.assert_allclose(fine, texels.points[inner] @ [1.0, 2.0, 0.0], atol=0.16)


def test_unknown_texels_take_the_value_of_the_nearest_known_one():
    rng = np.random.default_rng(2)
    image, known = rng.permutation(300).reshape(15, 20), rng.random((15, 20)) < 0.1
    whole = filled(image, known)
    places = np.argwhere(known)
    nearest, _ = cKDTree(places).query(np.argwhere(np.ones_like(known)))
    where = np.argsort(image.ravel())[whole.ravel()]
    assert known.ravel()[where].all()
    own = np.linalg.norm(np.stack(np.divmod(where, 20), axis=1) - np.argwhere(np.ones_like(known)), axis=1)
    np.testing.assert_allclose(own, nearest)
    assert filled(image, np.zeros_like(known)) is image


def test_rays_bring_the_cell_that_they_hit_and_the_sky(plates):
    corners, _, charts, texels = plates
    cells = np.full(charts.shape[0] * charts.shape[1], -7, np.int32)
    cells[texels.at] = np.arange(len(texels.at))
    # Below the level plate, whose back faces down, and above it.
    facing = Room(corners[:, ::-1].astype(np.float32)), Room(corners.astype(np.float32))
    at = points_at([[0, 0, 0.9]], [UP])
    seen, unseen = (gathered(Surroundings(room, np.arange(4), charts, cells), at, 8, 999) for room in facing)
    directions = np.array([each[0] for each in hemisphere(at, 8)])
    reached = np.array([0, 0, 0.902]) + directions * (0.098 / directions[:, 2:])
    inside = (np.abs(reached[:, :2]) < (0.25, 0.2)).all(axis=1)
    assert 0.3 < inside.mean() < 1.0
    nearest = cKDTree(texels.points).query(reached[inside])[1]
    assert (seen.hits[inside, 0] == nearest).mean() > 0.97
    assert (seen.hits[~inside, 0] == 999).all()
    assert (unseen.hits == 999).all()
    assert (seen.behind[0], unseen.behind[0]) == (0.0, pytest.approx(inside.mean()))
    upright = sum(direction[2] > 0 for direction in directions[~inside])
    assert seen.sky[0] == pytest.approx(upright / 64, abs=0.05)


WINDOWS = """mjsim: 1
ceiling: {height: 2.5}
walls:
  - {points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true, height: 2.4,
     openings: [{segment: 0, at: 3.5, width: 1.0, sill: 0.8, head: 2.6},
                {segment: 1, at: 1.0, width: 0.8, sill: 1, head: 2}]}
  - {points: [[2, 0], [2, 3]], openings: [{at: 1, width: 0.9}]}
"""


@pytest.fixture(scope="module")
def windowed():
    world = parse_world(WINDOWS)
    return world, atlas_of(world, compiled(compile_world(world)), texel=0.5)


def test_windows_shine_inwards_as_large_as_their_openings_and_doors_between_rooms_do_not(windowed):
    world, atlas = windowed
    room, _ = atlas.room()
    first, second = window_rectangles(world, room)
    for window, middle, size, inwards in (
        (first, (3.75, 0, 1.6), (0.25, 0.8), (0, 1, 0)),
        (second, (4, 1.4, 1.5), (0.4, 0.5), (-1, 0, 0)),
    ):
        np.testing.assert_allclose(window.middle, middle)
        assert tuple(np.linalg.norm(side) for side in (window.across, window.along)) == pytest.approx(size)
        np.testing.assert_allclose(window.outward, inwards, atol=1e-9)
        assert window.radiance == pytest.approx(2 / math.pi)
    assert window_rectangles(world.model_copy(update={"ceiling": None}), room) == []
    x, y, z = np.array([[3.75] * 3 + [3.45] + [3.75] * 2, [-0.1, 0.1, -0.6] + [-0.1] * 3, [1.6] * 4 + [0.7, 1.6]])
    at = points_at(np.stack([x, y, z], axis=1), [*[[0.0, 1.0, 0.0]] * 5, UP])
    assert behind(first, at).tolist() == [True] + [False] * 5
    room, names = atlas.room([first, second])
    u, v = np.array([[-0.5, 0.5, -0.5, 0.5], [-0.5, -0.5, 0.5, 0.5]])[:, :, None]
    starts = first.middle + u * first.across + v * first.along + 0.3 * first.outward
    hit, distance, _ = room.first(starts.astype(np.float32), np.tile(-first.outward, (4, 1)).astype(np.float32))
    assert set(names[hit].tolist()) == {WINDOW_CELL}
    np.testing.assert_allclose(distance, 0.3, atol=1e-5)
    inside = inside_of(world)(np.array([[1.0, 1.0], [3.0, 1.0], [5.0, 1.0], [1.0, -1.0]]))
    assert inside.tolist() == [True, True, False, False]
    assert inside_of(parse_world("walls: [{points: [[0, 0], [1, 0]]}]"))(np.array([[9.0, 9.0]])).all()


def test_probes_fill_rooms_and_those_in_solids_take_the_value_of_the_nearest_outside(windowed):
    grid = grid_of(*windowed)
    at = grid.points.points[::6]
    low, high = at.min(axis=0), at.max(axis=0)
    assert (low[2], high[2]) == pytest.approx((0.15, 1.65))
    assert ((low[:2] < (0.4, 0.4)) & (high[:2] > (3.6, 2.6))).all()
    assert ((low > -0.6) & (high < (4.6, 3.6, 2))).all()
    assert len(at) == math.prod(grid.count)
    assert len(set(grid.points.numbers.tolist())) == 6 * len(at) > len(at)
    np.testing.assert_allclose(grid.points.normals[:6].sum(axis=0), 0)
    rng, small = np.random.default_rng(0), ProbeGrid(np.zeros(3), np.array([0.5, 0.5, 0.2]), (4, 5, 3), grid.points)
    values, hidden = rng.permutation(60).astype(np.float32), np.where(rng.random(60) < 0.4, 0.26, 0.24)
    places = np.stack(np.unravel_index(np.arange(60), small.count), axis=1) * small.spacing
    chosen = small.outside_solids(values, hidden)
    free = np.flatnonzero(hidden < 0.25)
    nearest, _ = cKDTree(places[free]).query(places)
    where = [int(np.flatnonzero(values == value)[0]) for value in chosen]
    np.testing.assert_allclose(np.linalg.norm(places[where] - places, axis=1), nearest)
    np.testing.assert_array_equal(small.outside_solids(values, np.ones(60)), values)
    light = rng.random((60, 2, 3)).astype(np.float32)
    np.testing.assert_allclose(small.probes(light).light[1, 2, 3, 1], light[2 * 15 + 3 * 3 + 1, 1], atol=1e-3)


def test_doors_with_a_map_are_those_that_events_move_to_where_events_open_them():
    text = """mjsim: 1
walls: [{points: [[0, 0], [9, 0]], openings: [
  {name: a, at: 0, width: 1, door: {}}, {name: b, at: 2, width: 1, door: {angle_deg: -40}},
  {name: c, at: 4, width: 1, door: {}}, {name: d, at: 6, width: 1, door: {}}]}]
run: {events: [{time: 1, open: a, angle_deg: -60}, {time: 2, close: b}, {time: 3, close: c}, {time: 4, open: d}]}
"""
    doors = moved_doors(parse_world(text))
    assert doors == {"a": -OPEN_ANGLE, "b": -OPEN_ANGLE, "d": OPEN_ANGLE}
    world = parse_world(text)
    atlas = atlas_of(world, compiled(compile_world(world)), texel=1.0)
    closed, opened = atlas.ajar["door/a"]
    # The leaf is 1 m wide; open it stands to the right of the wall, at negative y.
    ends = [np.concatenate([atlas.solids[solid].points for solid in state]) for state in (closed, opened)]
    sizes = [np.ptp(points, axis=0)[:2].tolist() for points in ends]
    assert sizes[0][0] > 0.8 > 0.2 > sizes[0][1]
    assert sizes[1][1] > 0.8 > 0.2 > sizes[1][0]
    assert ends[1][:, 1].mean() < -0.3
    shut, _ = atlas.room()
    ajar, _ = atlas.room(opened="door/a")
    through = np.array([[0.3, -1, 1]], np.float32), np.array([[0, 1, 0]], np.float32)
    assert shut.first(*through)[0][0] >= 0
    assert ajar.first(*through)[0][0] < 0
