"""Parts of drawings and maps by themselves: openings, symbols, pens, pixels, rectangles, each of known figures."""

import math
from collections import Counter

import cv2
import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange.drawing import Drawing, Line
from mjsim.exchange.openings import Hole, doors_and_windows, lines_through, with_openings
from mjsim.exchange.pixels import claimed_pixels, gray_of
from mjsim.exchange.plan_in import read_plan
from mjsim.exchange.robots.xacro.budget import STEPS, TooLargeError, XacroBudget, XacroError, size_of, weight_of
from mjsim.exchange.robots.xacro.functions import BINARY, METHODS, SUBSTITUTED, known_names
from mjsim.exchange.robots.xacro.scope import Scope
from mjsim.exchange.shapes import Bar, bar_between, cells_in, fitted_bar, fitted_disc, fitted_rectangle
from mjsim.exchange.sorting import by_pen, cleared, length_of_lines, sorted_lines, with_large_rooms, with_rooms
from mjsim.exchange.strokes import Pieces, split
from mjsim.exchange.symbols import with_symbols, without_leaves
from mjsim.exchange.text import world_text
from mjsim.exchange.tidy import tidied
from mjsim.geometry import Pose
from mjsim.world import Beacon, Grid, Wall, World, parse_world


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
    assert (len(found.walls), counts["lines outside of the building"]) == (4, 1)


def test_door_symbols_are_known_by_their_swing_and_windows_by_their_panes():
    door = [Line(swing(0, 0), part=1), line([[0, 0], [0, 0.9]], part=1)]
    large = [Line(swing(5, 0), part=2), line([[5, 0], [9, 0]], part=2)]
    assert [each.role for each in with_symbols([*door, *large])] == ["door", "door", None, None]
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
    from mjsim.exchange import plan_in

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
        (pnm(5, "3 2\n255", bytes(5)), "is truncated; 3 x 2 pixels are 6 numbers"),
        (pnm(5, "0 2\n255", bytes(5)), "is a picture of 0 x 2 pixels up to 255"),
        (pnm(5, "3 0\n255", bytes(5)), "is a picture of 3 x 0 pixels"),
        (pnm(5, "3 2\n0", bytes(6)), "up to 0; write 8 or 16 bits each"),
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


@pytest.mark.parametrize(
    ("name", "left", "right", "value"),
    [
        ("Pow", 2, 10, 1024), ("Pow", 2.0, -1, 0.5), ("Mult", 3, 4, 12), ("Mult", "ab", 2, "abab"), ("Mod", 7, 3, 1),
        ("Mod", "%.2f m", 1.5, "1.50 m"), ("Mod", "100%%", (), "100%"), ("Div", 1, 4, 0.25), ("FloorDiv", 7, 2, 3),
        ("Pow", -8, 1 / 3, XacroError), ("Pow", 2, 200, TooLargeError), ("Mult", "x", 10**6, TooLargeError),
        ("Mult", 10**6, [0], TooLargeError), ("Mod", "%1000d", 1, XacroError), ("Pow", 1, 10**9, 1),
        ("Mod", "%s" * 1000, ("x",) * 1000, TooLargeError),
    ],
)  # fmt: skip
def test_operators_of_xacro_are_those_of_python_within_bounds(name, left, right, value):
    if isinstance(value, type):
        with pytest.raises(value):
            BINARY[name](left, right)
    else:
        assert BINARY[name](left, right) == value


@pytest.mark.parametrize(
    ("name", "arguments", "value"),
    [
        ("factorial", (5,), 120), ("factorial", (200,), math.factorial(200)), ("factorial", (201,), TooLargeError),
        ("round", (1.26, 1), 1.3), ("round", (1.26, 31), TooLargeError), ("sum", ([1, 2, 3],), 6), ("sum", ([1], 4), 5),
        ("sum", (["a"],), XacroError), ("range", (3,), [0, 1, 2]), ("range", (10_000,), list(range(10_000))),
        ("range", (10_001,), TooLargeError), ("zip", ([1], [2]), [(1, 2)]), ("enumerate", (["a"],), [(0, "a")]),
        ("reversed", ([1, 2],), [2, 1]), ("pi", None, math.pi), ("true", None, True),
    ],
)  # fmt: skip
def test_functions_of_xacro_are_those_of_python_within_bounds(name, arguments, value):
    found = SUBSTITUTED[name]
    if arguments is None:
        assert found == value
    elif isinstance(value, type):
        with pytest.raises(value):
            found.run(*arguments)
    else:
        assert found.run(*arguments) == value
    assert METHODS[dict]["items"].run({"a": 1}) == [("a", 1)]
    assert METHODS[str]["join"].run(",", ["a", "b"]) == "a,b"
    assert set(known_names({"load_yaml": len})) >= {"math", "python", "xacro", "load_yaml", "dotify", "sin"}


def test_what_a_xacro_file_costs_is_counted():
    assert [size_of(value) for value in (1, None, "abc", [1, "ab"], {"a": [1, 2]}, ())] == [1, 1, 4, 5, 6, 1]
    assert [weight_of(value) for value in ("x" * 80, [1, 2])] == [1 + 81 // 8, 3]
    for value, error in (
        ([0] * 100_000, TooLargeError),
        (2**256, TooLargeError),
        (1j, XacroError),
        ("\ud800", XacroError),
    ):
        with pytest.raises(error):
            size_of(value)
    assert size_of(2**256 - 1) == 1
    budget = XacroBudget()
    budget.spend(STEPS - 2)
    assert budget.keep([1]) == [1]
    with pytest.raises(XacroError, match="it takes more than 1000000 steps"):
        budget.spend(1)
    for _ in range(2):  # what was left counts no more
        with (
            budget.deeper(700),
            budget.deeper(50),
            pytest.raises(XacroError, match="nested too deeply"),
            budget.deeper(1),
        ):
            pass


def test_properties_of_xacro_are_looked_up_outwards_and_evaluated_once():
    asked = []

    def evaluate(text: str, scope: Scope) -> object:
        asked.append(text)
        return scope.lookup(text[1:]) if text.startswith("$") else text.upper()

    file = Scope(evaluate, known={"pi": 3.0})
    space = Scope(evaluate, parent=file, namespace=True)
    macro = Scope(evaluate, parent=space)
    file.set("a", "one", lazy=True)
    space.set("b", "two")
    assert [macro.lookup(name) for name in ("a", "a", "b", "pi")] == ["ONE", "ONE", "two", 3.0]
    assert asked == ["one"]
    assert ["a" in macro, "b" in file, "pi" in macro] == [True, False, True]
    assert (macro.outermost(), macro.caller(), space.caller()) == (file, file, file)
    with pytest.raises(XacroError, match="is for properties of macros"):
        file.caller()
    file.set("x", "$y", lazy=True)
    file.set("y", "$x", lazy=True)
    with pytest.raises(XacroError, match=r"'x' refers to itself \(x -> y -> x\)"):
        file.lookup("x")
    macro.remove("b")
    with pytest.raises(XacroError, match="no xacro:property 'b'; declare it"):
        macro.lookup("b")
