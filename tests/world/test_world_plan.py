"""Walls as solids: compared with shapely's own buffers, and with areas worked out by hand."""

import itertools
import math

import numpy as np
import pytest
import shapely

from mjsim.world import Opening, Wall, footprint, parse_world, segments, solid, wall_pieces, wall_polygons
from mjsim.world.plan.outlines import cut


def random_wall(rng, *, sharpest_deg, shortest):
    """A wall that goes on from corner to corner, turning by at most an angle each time."""
    count = rng.integers(2, 8)
    turns = np.radians(rng.uniform(-sharpest_deg, sharpest_deg, count))
    headings = np.cumsum(turns)
    steps = rng.uniform(shortest, shortest + 3.0, count)[:, None] * np.stack([np.cos(headings), np.sin(headings)], 1)
    points = np.vstack([rng.uniform(-5, 5, 2), steps]).cumsum(axis=0)
    return Wall(points=tuple(map(tuple, points.tolist())), thickness=float(rng.uniform(0.05, 0.3)))


def union_of(wall):
    return shapely.union_all([shapely.Polygon(piece.outline) for piece in wall_pieces(wall)], grid_size=1e-9)


def test_a_mitred_wall_covers_what_shapely_gets_by_widening_its_centreline():
    rng = np.random.default_rng(0)
    for _ in range(60):
        wall = random_wall(rng, sharpest_deg=178, shortest=1.5)
        line = shapely.LineString(wall.points)
        wide = line.buffer(wall.thickness / 2, cap_style="flat", join_style="mitre", mitre_limit=math.sqrt(2))
        assert union_of(wall).symmetric_difference(wide).area < 1e-6


def test_mitred_pieces_touch_without_overlapping():
    rng = np.random.default_rng(1)
    for _ in range(30):
        wall = random_wall(rng, sharpest_deg=60, shortest=1.5)
        outlines = [shapely.Polygon(piece.outline) for piece in wall_pieces(wall)]
        for first, second in itertools.pairwise(outlines):
            assert first.intersection(second).area < 1e-9


def test_no_corner_however_sharp_leaves_a_gap_beside_the_centreline():
    rng = np.random.default_rng(2)
    for _ in range(60):
        wall = random_wall(rng, sharpest_deg=180, shortest=0.05)
        line = shapely.LineString(wall.points)
        inside = line.buffer(wall.thickness / 2 - 1e-6, cap_style="flat", join_style="bevel")
        assert inside.difference(union_of(wall)).area < 1e-6


def test_outlines_are_convex_and_counter_clockwise():
    rng = np.random.default_rng(3)
    for _ in range(60):
        wall = random_wall(rng, sharpest_deg=180, shortest=0.05)
        for piece in wall_pieces(wall):
            edges = np.roll(piece.outline, -1, axis=0) - piece.outline
            following = np.roll(edges, -1, axis=0)
            cross = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
            assert (cross > -1e-12).all()


def test_openings_leave_the_area_of_the_wall_less_their_own():
    openings = (Opening(at=1, width=0.9), Opening(at=3, width=1.2, sill=0.9, head=2.0), Opening(at=5.5, width=0.5))
    wall = Wall(points=((0, 0), (6, 0)), height=2.5, openings=openings)
    face = sum(math.dist(p.start, p.end) * (p.high - p.low) for p in wall_pieces(wall))
    assert face == pytest.approx(6 * 2.5 - 0.9 * 2.1 - 1.2 * 1.1 - 0.5 * 2.1)


def test_openings_that_overlap_or_stand_over_each_other_take_away_their_union():
    openings = (
        Opening(at=1, width=2, sill=0, head=1),
        Opening(at=2, width=2, sill=0.5, head=2),
        Opening(at=1, width=1, sill=1.5, head=2.2),
    )
    wall = Wall(points=((0, 0), (0, 6)), height=2.0, openings=openings)
    holes = [shapely.box(o.at, o.sill, o.at + o.width, min(o.head, 2.0)) for o in openings]
    face = sum(math.dist(p.start, p.end) * (p.high - p.low) for p in wall_pieces(wall))
    assert face == pytest.approx(12.0 - shapely.union_all(holes).area)


def test_an_opening_inside_a_corner_still_gives_outlines_that_are_not_inside_out():
    for at, width in ((0.0, 0.5), (0.02, 0.5), (3.48, 0.5), (3.97, 0.03), (0.0, 0.03)):
        walls = Wall(
            points=((0, 0), (4, 0), (4, 4), (0, 4)), closed=True, thickness=0.2, openings=(Opening(at=at, width=width),)
        )
        for piece in wall_pieces(walls):
            assert shapely.Polygon(piece.outline).exterior.is_ccw


ROOM = """
walls:
  - points: [[0, 0], [4, 0], [4, 3], [0, 3]]
    closed: true
    thickness: 0.2
    openings: [{at: 1, width: 1}, {segment: 2, at: 1, width: 1, sill: 0.9}]
  - points: [[1, 1.5], [1, 3]]
    thickness: 0.2
obstacles: [{box: [0.4, 0.2, 1], at: [3, 1], heading_deg: 90}, {cylinder: [0.25, 0.1], at: [1, 1]}]
"""


def test_the_plan_of_a_room_has_its_doors_cut_out_and_its_windows_not():
    world = parse_world(ROOM)
    ring = 2 * 0.2 * (4 + 3) - 1 * 0.2
    wall = 0.2 * 1.4  # it ends at the face of the outer wall
    assert solid(world).area == pytest.approx(ring + wall + 0.4 * 0.2, abs=1e-6)
    assert solid(world, height=1.5).area == pytest.approx(ring + wall - 1 * 0.2, abs=1e-6)
    assert sum(shapely.Polygon(p).area for p in wall_polygons(world)) == pytest.approx(ring + wall + 0.2 * 0.1)


def test_faces_have_the_solid_to_their_left_and_leave_out_what_is_inside():
    world = parse_world(ROOM)
    faces, whole = segments(world), solid(world)
    middle, along = faces.mean(axis=1), faces[:, 1] - faces[:, 0]
    left = 1e-3 * np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
    assert shapely.contains_xy(whole, *(middle + left).T).all()
    assert not shapely.contains_xy(whole, *(middle - left).T).any()
    assert np.linalg.norm(along, axis=1).sum() == pytest.approx(whole.length)
    assert segments(parse_world("name: empty")).shape == (0, 2, 2)


def test_footprints_turn_with_their_heading():
    box, cylinder = parse_world(ROOM).obstacles
    np.testing.assert_allclose(footprint(box).min(axis=0), [2.9, 0.8])
    np.testing.assert_allclose(footprint(box).max(axis=0), [3.1, 1.2])
    np.testing.assert_allclose(np.linalg.norm(footprint(cylinder) - [1, 1], axis=1), 0.25)


def stair(x, length, rise, count):
    """Return the height of steps, the lowest first, at x along them from their middle [m]."""
    return rise * np.clip(np.ceil(count * (x / length + 0.5)), 1, count) / count


HEIGHTS = {
    "box: [1.0, 0.6, 0.4]": lambda x, y: np.where((abs(x) < 0.5) & (abs(y) < 0.3), 0.4, 0.0),
    "cylinder: [0.4, 0.5]": lambda x, y: np.where(np.hypot(x, y) < 0.4, 0.5, 0.0),
    "ramp: [1.2, 0.5, 0.4]": lambda x, y: np.where((abs(x) < 0.6) & (abs(y) < 0.25), 0.4 * (x / 1.2 + 0.5), 0.0),
    "steps: [1.2, 0.5, 0.4], count: 4": lambda x, y: np.where(
        (abs(x) < 0.6) & (abs(y) < 0.25), stair(x, 1.2, 0.4, 4), 0.0
    ),
}


@pytest.mark.parametrize("shape", HEIGHTS)
def test_the_section_of_a_thing_is_where_it_is_higher(shape):
    text = f"mjsim: 1\nobstacles: [{{{shape}, at: [2, 1], heading_deg: 30, elevation: 0.1}}]\n"
    (thing,) = parse_world(text).obstacles
    x, y = np.random.default_rng(3).uniform(-0.8, 0.8, (2, 4000))
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    places = 2 + c * x - s * y, 1 + s * x + c * y
    for height in (0.12, 0.25, 0.33, 0.44):
        outlines = cut(thing, height)
        found = np.any([shapely.contains_xy(shapely.Polygon(each), *places) for each in outlines], axis=0)
        # Circles are polygons; nothing else differs at any of the points.
        assert np.count_nonzero(found != (HEIGHTS[shape](x, y) > height - 0.1)) <= (20 if "cylinder" in shape else 0)
    assert cut(thing, 0.05) == cut(thing, 0.7) == []
