"""Parts of drawings by themselves: openings, symbols, pens, each of known figures."""

from collections import Counter

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange.drawings.drawing import Drawing, Line
from mjsim.exchange.drawings.drawn_openings import Hole, doors_and_windows, lines_through, with_openings
from mjsim.exchange.drawings.plan_in import read_plan
from mjsim.exchange.drawings.sorting import (
    by_pen,
    cleared,
    length_of_lines,
    sorted_lines,
    with_large_rooms,
    with_rooms,
)
from mjsim.exchange.drawings.strokes import Pieces, split
from mjsim.exchange.drawings.symbols import with_symbols, without_leaves
from mjsim.exchange.maps.cell_shapes import Bar
from mjsim.exchange.world_comment import world_text
from mjsim.inventory import inventory
from mjsim.world import Beacon, Wall, World, parse_world


def pieces(*ends: tuple[float, float, float, float]) -> Pieces:
    return Pieces(np.array(ends, dtype=float).reshape(-1, 2, 2), np.arange(len(ends)))


def swing(x: float, y: float, radius: float = 0.9, first: float = 0.0) -> np.ndarray:
    turns = np.radians(np.linspace(first, first + 90.0, 30))
    return np.array([x, y]) + radius * np.stack([np.cos(turns), np.sin(turns)], axis=-1)


LEFT, RIGHT = Bar(1.0, 0.0, 0.0, 2.0, 0.2), Bar(4.0, 0.0, 0.0, 2.0, 0.2)
"""Walls along x from 0 to 2 and from 3 to 5 m."""


@pytest.mark.parametrize(
    ("symbols", "ends", "window"),
    [
        ({"arcs": [swing(2.0, 0.0, 1.0)]}, (2.0, 3.0), False),
        ({"arcs": [swing(3.0, 0.0, 1.0, 90.0)]}, (2.0, 3.0), False),
        ({"arcs": [swing(2.0, 0.0, 0.49), swing(3.0, 0.0, 0.49, 90.0)]}, (2.0, 3.0), False),  # two leaves
        ({"doors": [np.array([[2.1, -0.1], [2.9, 0.1]])]}, (2.0, 3.0), False),
        ({"doors": [np.array([[2.1, 0.5], [2.9, 0.6]])]}, None, None),  # beside the wall
        ({"doors": [np.array([[2.1, 0.0], [2.4, 0.0]])]}, None, None),  # too short
        ({"windows": [np.array([[2.0, -0.1], [3.0, 0.1], [2.0, 0.1]])]}, (2.0, 3.0), True),
        ({"pieces": pieces((2.0, 0.05, 3.0, 0.05), (2.05, -0.05, 2.95, -0.05))}, (2.0, 3.0), True),
        ({"pieces": pieces((2.0, 0.05, 3.0, 0.05))}, None, None),
        ({"pieces": pieces((2.0, 0.05, 3.0, 0.05), (2.2, -0.05, 3.0, -0.05))}, None, None),
        ({"pieces": pieces((2.0, 0.05, 3.0, 0.05), (2.0, -0.2, 3.0, -0.2))}, None, None),
        ({"pieces": pieces((2.0, 0.05, 3.0, 0.05), (2.0, -0.05, 3.0, 0.05))}, None, None),
        ({}, None, None),
    ],
)
def test_a_gap_between_walls_is_an_opening_if_a_symbol_fills_it(symbols, ends, window):
    _, arcs = split(symbols.get("arcs", []), [False] * len(symbols.get("arcs", [])))
    more = symbols.get("doors", []), symbols.get("windows", [])
    bars, holes = doors_and_windows([LEFT, RIGHT], symbols.get("pieces", pieces()), arcs, *more)
    if ends is None:
        assert (len(bars), len(holes)) == (2, 0)
        return
    (bar,), (hole,) = bars, holes
    assert (bar.x, bar.length, bar.width) == pytest.approx((2.5, 5.0, 0.2))
    assert sorted(hole.ends[:, 0].tolist()) == pytest.approx(ends)
    assert hole.ends[:, 1] == pytest.approx([0.0, 0.0])
    assert hole.window == window


WALL = Bar(2.5, 0.0, 0.0, 5.0, 0.2)


@pytest.mark.parametrize(
    ("corners", "ends"),
    [
        ([[1.0, 0.1], [1.9, 0.1]], (1.0, 1.9)),
        ([[1.0, 0.1], [1.9, 0.1], [1.5, 0.9]], (1.0, 1.9)),
        ([[1.0, 0.0], [1.9, 0.9]], None),  # it leads away
        ([[-0.5, 0.0], [0.4, 0.0]], None),  # beyond the end
        ([[4.5, 0.0], [5.4, 0.0]], None),
        ([[1.0, 0.0], [1.2, 0.0]], None),  # too narrow
        ([[0.2, 0.0], [4.9, 0.0]], None),  # too wide
        ([[1.0, 1.0], [1.9, 1.0]], None),  # too far
    ],
)
def test_a_door_symbol_on_a_wall_is_an_opening_there(corners, ends):
    _, holes = doors_and_windows([WALL], pieces(), [], [np.array(corners)], [])
    assert [tuple(hole.ends[:, 0]) for hole in holes] == ([pytest.approx(ends)] if ends else [])


def test_two_leaves_in_one_place_are_one_doorway():
    doors = [np.array([[x, 0.0], [x + 0.9, 0.0]]) for x in (1.0, 1.9, 4.0)]
    _, holes = doors_and_windows([WALL], pieces(), [], doors, [])
    assert [tuple(np.round(hole.ends[:, 0], 6)) for hole in holes] == [(1.0, 2.8), (4.0, 4.9)]
    _, holes = doors_and_windows([WALL], pieces(), [], doors[:1], [np.array([[1.2, 0.0], [2.0, 0.0]])])
    assert [hole.window for hole in holes] == [False]


def test_panes_between_posts_are_windows():
    posts = (1.0, -0.1, 1.0, 0.1), (2.2, -0.1, 2.2, 0.1)
    for pane, count in (((1.0, 0.0, 2.2, 0.0), 1), ((1.3, 0.0, 2.2, 0.0), 0), ((1.0, 0.095, 2.2, 0.095), 0)):
        _, holes = doors_and_windows([WALL], pieces(*posts, pane), [], [], [])
        assert [tuple(hole.ends[:, 0]) for hole in holes if hole.window] == [pytest.approx((1.0, 2.2))] * count
    assert (
        lines_through(np.array([[0.0, 0.0], [0.0, 2.0]]), 0.2, pieces((0.05, 0.1, 0.05, 1.9), (0.05, 0.5, 0.05, 2.0)))
        == 1
    )


def test_openings_stand_along_their_segment():
    wall = Wall(points=((0.0, 0.0), (4.0, 0.0), (4.0, 3.0)), thickness=0.2)
    holes = [
        Hole(np.array([[4.0, 1.9], [4.0, 1.0]]), window=True),
        Hole(np.array([[1.0, 0.05], [2.0, 0.05]]), window=False),
        Hole(np.array([[1.5, 0.0], [2.5, 0.0]]), window=False),  # it overlaps
        Hole(np.array([[0.0, 0.0], [0.8, 0.0]]), window=False),  # it keeps away from the end
        Hole(np.array([[2.0, 1.0], [3.0, 1.0]]), window=False),  # in no wall
        Hole(np.array([[2.6, 0.0], [3.4, 0.3]]), window=False),  # askew
    ]
    (made,) = with_openings([wall], holes)
    found = [(each.segment, each.at, each.width, each.sill, each.head) for each in made.openings]
    plain = wall.model_copy().openings
    assert plain == ()
    assert [each[:3] for each in found] == [(0, 0.02, 0.78), (0, 1.0, 1.0), (1, 1.0, 0.9)]
    assert found[2][3:] == (0.9, 2.0)
    assert found[0][3] == 0.0


def line(points: list[list[float]], **keys: object) -> Line:
    return Line(np.array(points, dtype=float), **keys)


SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


def test_lines_are_measured_and_sorted_by_role():
    assert length_of_lines([line(SQUARE, closed=True), line([[0, 0], [3, 4]])]) == pytest.approx(9.0)
    room, wall, other = line(SQUARE, closed=True, role="room"), line(SQUARE, role="wall"), line(SQUARE)
    assert [each.role for each in with_rooms([room, wall])] == ["note", "wall"]
    assert [each.role for each in with_rooms([room, line(SQUARE, role="room"), other])] == [None, "note", None]
    wide = line([[x * 2.4, y * 2.4] for x, y in SQUARE], closed=True, role="furniture")
    narrow = line([[x * 2.2, y * 2.4] for x, y in SQUARE], closed=True, role="furniture")
    assert [each.role for each in with_large_rooms([wide, narrow])] == [None, "furniture"]
    assert [each.role for each in with_large_rooms([wide, wall])] == ["furniture", "wall"]
    roles = ("wall", None, "door", "window", "furniture", "column")
    named = sorted_lines([*(line(SQUARE, role=role) for role in roles), line(SQUARE, blank=True)])
    assert [len(each) for each in (named.walls, named.others, named.patches)] == [1, 1, 1]
    assert named.named
    plain = sorted_lines([other, line(SQUARE, role="door")])
    assert (len(plain.walls), len(plain.doors), plain.others, plain.named) == (1, 1, [], False)
    moved = named.moved(np.array([1.0, 2.0]))
    groups = (moved.walls, moved.doors, moved.windows, moved.furniture, moved.columns, moved.others, moved.patches)
    assert all(group[0].points[0].tolist() == [-1.0, -2.0] for group in groups)


def test_pens_tell_how_walls_are_drawn():
    hair, broad = line([[0, 0], [5, 0]], width=0.01), line([[0, 0], [5, 0]], width=0.2)
    dark, pale = line(SQUARE, closed=True, dark=1.0), line(SQUARE, closed=True, dark=0.1)
    pens = by_pen([hair, broad, dark, pale])
    assert [list(map(id, each)) for each in (pens.hair, pens.broad, pens.filled, pens.light)] == [
        [id(hair)], [id(broad)], [id(dark)], [id(pale)],
    ]  # fmt: skip
    # A pale strip from one dark shape to another is a window.
    ends = [[-1, 0], [0, 0], [0, 1], [-1, 1]], [[3, 0], [4, 0], [4, 1], [3, 1]]
    strip = line([[0, 0.4], [3, 0.4], [3, 0.6], [0, 0.6]], closed=True, dark=0.1)
    shapes = [line(each, closed=True, dark=1.0) for each in ends]
    assert (len(by_pen([*shapes, strip]).filled), len(by_pen([*shapes[:1], strip]).filled)) == (3, 1)
    # Alone it exists for its fill.
    assert [each.dark for each in by_pen([strip]).filled] == [0.5]
    assert len(by_pen([pale]).hair) == 1


def test_lines_outside_of_the_building_are_counted():
    rooms = [line([[x, y], [x + 4, y], [x + 4, y + 3], [x, y + 3]], closed=True) for x in (0, 4) for y in (0, 3)]
    counts = Counter()
    found = cleared(sorted_lines([*rooms, line([[300, 300], [301, 300]])]), counts)
    assert (len(found.walls), counts["line outside the building"]) == (4, 1)


def test_door_symbols_are_known_by_their_swing_and_windows_by_their_panes():
    door = [Line(swing(0, 0), part=1), line([[0, 0], [0, 0.9]], part=1)]
    large = [Line(swing(5, 0), part=2), line([[5, 0], [9, 0]], part=2)]
    assert [each.role for each in with_symbols([*door, *large])] == ["door", "door", None, None]
    # Two leaves and a frame are at most 2.6 times as wide as the arc, whose radius is 0.9 m.
    for width, role in ((2.3, "door"), (2.4, None)):
        wide = [Line(swing(0, 0), part=1), line([[0, 0], [width, 0]], part=1)]
        assert {each.role for each in with_symbols(wide)} == {role}
    panes = [line([[0, y], [1.2, y]], role="opening") for y in (0.0, 0.05, 0.1)]
    plain = [line([[9, y], [10.2, y]], role="opening") for y in (0.0, 0.05)]
    assert [each.role for each in with_symbols([*panes, *plain])] == ["window"] * 3 + ["door"] * 2
    assert {each.role for each in with_symbols([Line(each.points, role="opening") for each in door])} == {"door"}
    _, arcs = split([swing(1.0, 2.0)], [False])
    left = without_leaves(
        pieces((1, 2, 1, 2.9), (1, 2, 1.9, 2), (1, 2, 2.9, 2), (1, 2, 1.6, 2.6), (1.2, 2, 1.8, 2)), arcs
    )
    assert left.ends.tolist() == [[[1, 2], [2.9, 2]], [[1, 2], [1.6, 2.6]]]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ([], "has no lines to make walls of"),
        ([line(SQUARE, blank=True, closed=True, dark=0.0)], "except white ones; draw walls in another colour"),
        ([line(np.zeros((40_001, 2)).tolist())], "has 40001 corners"),
    ],
)
def test_drawings_without_walls_are_refused(lines, said):
    from mjsim.exchange.drawings import plan_in

    limit = 2 * plan_in.MAX_CORNERS
    said = said.replace("40001", str(limit + 1))
    lines = [line(np.zeros((limit + 1, 2)).tolist())] if "corners" in said else lines
    with pytest.raises(UsageError, match=said):
        read_plan(Drawing("a.svg", lines, 1.0))


def test_a_world_is_written_with_its_notes_and_a_line_before_each_list():
    wall = Wall(points=((0.0, 0.0), (1.0, 0.0)))
    world = World(name="a", walls=(wall,), beacons=(Beacon(name="b", at=(1.0, 1.0)),))
    text = world_text(world, notes=["one\ntwo ", "three"])
    assert text.startswith("# one\n# two\n# three\nmjsim: 1\nname: a\n")
    assert "\n\nwalls:\n" in text
    assert "\n\nbeacons:\n" in text
    assert text.count("\n\n") == 2
    assert parse_world(text) == world


def test_single_lines_named_as_walls_are_walls_beside_those_of_two_faces():
    faces = [line([[0, y], [6, y]], role="wall") for y in (0.0, 0.2, 4.0, 4.2)]
    alone = [line([[x, 0.1], [x, 4.1]], role="wall") for x in (0.1, 3.0, 5.9)]
    plan = read_plan(Drawing("a.svg", [*faces, *alone], 1.0))
    assert inventory(plan.items) == [
        "kept: 3 walls drawn by one line",
        "guessed: heights: a drawing has none",
    ]
    lengths = sorted(round(float(np.ptp(wall.points, axis=0).max()), 3) for wall in plan.world.walls)
    assert lengths == pytest.approx([4.0, 4.0, 4.0, 6.0, 6.0], abs=0.31)
    assert sorted({round(wall.thickness, 3) for wall in plan.world.walls}) == [0.1, 0.2]


def test_what_fills_a_room_is_its_floor_and_an_oval_table_is_a_box_that_is_told():
    def box(wide: float, deep: float) -> np.ndarray:
        return np.array([[-wide, -deep], [wide, -deep], [wide, deep], [-wide, deep]]) / 2

    turns = np.linspace(0.0, 2 * np.pi, 40, endpoint=False)
    oval = np.stack([0.5 * np.cos(turns), 0.25 * np.sin(turns)], axis=-1) + np.array([0.7, 0.5])
    lines = [
        Line(box(3.0, 2.0), closed=True, width=0.1, role="wall"),
        Line(box(2.88, 1.88), closed=True, dark=0.05),
        Line(box(0.8, 0.5) - (0.7, 0.5), closed=True),
        Line(oval, closed=True, role="furniture"),
    ]
    plan = read_plan(Drawing("plan", lines, 1.0))
    sizes = sorted(thing.box[:2] for thing in plan.world.obstacles)
    assert sizes == [(0.8, 0.5), (1.0, 0.5)]
    told = inventory(plan.items)
    assert "guessed: the shape of 1 piece of furniture, not rectangular: a box around it" in told
    assert "left out: 1 floor of a room" in told


@pytest.mark.parametrize("reaching", [True, False])
def test_the_outline_of_a_room_is_no_frame_of_a_sheet_around_its_furniture(reaching):
    def box(x: float, y: float, wide: float, deep: float) -> np.ndarray:
        return np.array([[x, y], [x + wide, y], [x + wide, y + deep], [x, y + deep]])

    things = [
        Line(box(x, y, 1.2, 0.5), closed=True, dark=0.7) for x, y in ((1.5, 1.5), (5.0, 1.5), (5.0, 4.0), (1.5, 4.0))
    ]
    wall = [Line(np.array([[3.5, 0.0], [3.5, 3.0]]), width=0.12)] if reaching else []
    plan = read_plan(Drawing("plan", [Line(box(0, 0, 8, 6), closed=True, width=0.12), *wall, *things], 1.0))
    points = np.concatenate([wall.points for wall in plan.world.walls])
    assert [points.min(axis=0).tolist(), points.max(axis=0).tolist()] == [[0.0, 0.0], [8.0, 6.0]]


def test_a_dark_shape_that_stands_alone_is_told():
    ends = np.array([[1.0, 0.0], [1.0, 3.0], [5.0, 3.0], [5.0, 0.0]])
    slab = np.array([[2.0, 1.0], [3.6, 1.0], [3.6, 1.5], [2.0, 1.5]])
    lines = [Line(ends, closed=True, width=0.12), Line(slab, closed=True, dark=0.8)]
    told = inventory(read_plan(Drawing("plan", lines, 1.0)).items)
    assert "guessed: 1 lone thick wall: dark shapes are walls unless a name says 'furniture'" in told
