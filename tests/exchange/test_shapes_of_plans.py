"""Curved walls, walls along curves, landmark maps and originals, each compared with a drawing of known figures."""

import math

import numpy as np
import pytest
import shapely
from scipy.io import savemat

from mjsim.errors import UsageError
from mjsim.exchange import Reading, read_original
from mjsim.exchange.drawings.curved_walls import curves_of, walls_of, without_curves
from mjsim.exchange.drawings.drawing import Drawing, Line, corner_and_scale
from mjsim.exchange.drawings.dxf_tags import with_subclasses
from mjsim.exchange.drawings.ribbons import ribbons_of, without_ribbons
from mjsim.exchange.drawings.strokes import arc_through, is_door_arc, split
from mjsim.exchange.drawings.united import is_compact, united
from mjsim.exchange.maps.cell_shapes import Bar
from mjsim.exchange.matlab.landmarks import LandmarkMap, read_landmarks, world_from_landmarks
from mjsim.exchange.original_file import read_original as read_here


def arc(radius: float, first: float, sweep: float, *, middle: tuple[float, float] = (1.0, 2.0)) -> np.ndarray:
    """Return points on an arc, shape (n, 2) [m]; angles in degrees."""
    turns = np.radians(first + np.linspace(0.0, sweep, max(4, round(abs(sweep)))))
    return np.array(middle) + radius * np.stack([np.cos(turns), np.sin(turns)], axis=-1)


def test_two_concentric_arcs_are_one_curved_wall_over_what_they_share():
    (curve,) = curves_of([arc(3.0, 10.0, 80.0), arc(3.2, 30.0, 90.0)], [False, False])
    assert (curve.inner, curve.outer) == pytest.approx((3.0, 3.2), abs=1e-6)
    assert curve.middle == pytest.approx([1.0, 2.0], abs=1e-6)
    assert np.degrees([curve.first, curve.sweep]) == pytest.approx([30.0, 60.0], abs=0.1)


@pytest.mark.parametrize(
    ("other", "found"),
    [
        (arc(3.2, 0.0, 90.0), 1),
        (arc(3.2, 0.0, 90.0, middle=(1.0, 2.1)), 0),  # another centre
        (arc(4.0, 0.0, 90.0), 0),  # too thick
        (arc(3.2, 180.0, 90.0), 0),  # beside one another
        (arc(3.2, 87.0, 60.0), 0),  # share 0.16 m
        (arc(3.2, 350.0, 90.0), 1),  # across 0 degrees
    ],
)
def test_arcs_form_a_wall_only_face_to_face(other, found):
    assert len(curves_of([arc(3.0, 0.0, 90.0), other], [False, False])) == found


def test_a_ring_shares_all_of_an_arc_whichever_comes_first():
    ring, part = arc(3.0, 0.0, 360.0)[:-1], arc(3.2, 20.0, 50.0)
    for strokes, closed in (([ring, part], [True, False]), ([part, ring], [False, True])):
        (curve,) = curves_of(strokes, closed)
        assert np.degrees([curve.first, curve.sweep]) == pytest.approx([20.0, 50.0], abs=0.1)


def test_of_three_arcs_the_outer_two_are_the_faces():
    (curve,) = curves_of([arc(radius, 0.0, 90.0) for radius in (3.0, 3.1, 3.2)], [False] * 3)
    assert (curve.inner, curve.outer) == pytest.approx((3.0, 3.2), abs=1e-6)


def test_a_curved_wall_holds_points_between_its_faces_and_ends():
    (curve,) = curves_of([arc(3.0, 10.0, 80.0), arc(3.2, 10.0, 80.0)], [False, False])
    angles, radii = np.radians([50.0, 50.0, 50.0, 0.0, 100.0, 11.0]), np.array([3.1, 2.9, 3.3, 3.1, 3.1, 3.0])
    points = curve.middle + (radii * np.array([np.cos(angles), np.sin(angles)])).T
    assert curve.holds(points).tolist() == [True, False, False, False, False, True]


def test_a_curved_wall_is_a_chain_on_its_middle_line_within_5_mm():
    (curve,) = curves_of([arc(3.0, 0.0, 90.0), arc(3.2, 0.0, 90.0)], [False, False])
    (wall,) = walls_of([curve], [], None)
    away = np.hypot(*(np.array(wall.points) - [1.0, 2.0]).T)
    assert away == pytest.approx(np.full(len(away), 3.1), abs=2e-3)
    chords = np.hypot(*np.diff(wall.points, axis=0).T)
    assert (3.1 - np.sqrt(3.1**2 - (chords.max() / 2) ** 2)) == pytest.approx(0.005, abs=0.0015)
    assert (wall.thickness, wall.closed) == (0.2, False)
    assert walls_of([curve], [], 0.15)[0].thickness == 0.15
    (ring,) = curves_of([arc(3.0, 0.0, 360.0)[:-1], arc(3.2, 0.0, 360.0)[:-1]], [True, True])
    assert walls_of([ring], [], None)[0].closed


@pytest.mark.parametrize(
    ("bar", "more"),
    [
        (Bar(4.1, 1.9, 0.0, 4.0, 0.2), 1),  # across the start at (4.1, 2), lengthwise to the right
        (Bar(9.0, 1.9, 0.0, 4.0, 0.2), 0),  # far away
        (Bar(4.1, 1.9, math.pi / 2, 4.0, 0.2), 0),  # it goes on straight
    ],
)
def test_a_curved_wall_is_led_on_into_a_straight_one_that_it_meets(bar, more):
    (curve,) = curves_of([arc(3.0, 0.0, 60.0), arc(3.2, 0.0, 60.0)], [False, False])
    alone, met = (walls_of([curve], bars, None)[0].points for bars in ([], [bar]))
    assert len(met) == len(alone) + more
    if more:
        # Half the thickness on, along its first chord.
        step = np.subtract(met[0], met[1])
        assert np.hypot(*step) == pytest.approx(0.1, abs=2e-3)
        assert step[1] < -0.09


def test_lines_of_a_curved_wall_are_taken_from_the_others():
    strokes = [arc(3.0, 0.0, 90.0), arc(3.2, 0.0, 90.0), np.array([[5.0, 5.0], [8.0, 5.0]])]
    pieces, arcs = split(strokes, [False] * 3)
    curves = curves_of(strokes, [False] * 3)
    left, others = without_curves(pieces, arcs, curves)
    assert left.ends.tolist() == [[[5.0, 5.0], [8.0, 5.0]]]
    assert others == []
    same, _ = without_curves(pieces, arcs, [])
    assert same is pieces


def bow(offset: float, end: float = math.pi) -> np.ndarray:
    """Return a line parallel to half an ellipse of 4 m and 2.5 m, `offset` outside of it, shape (n, 2) [m]."""
    turns = np.linspace(0.0, end, 120)
    normal = np.stack([2.5 * np.cos(turns), 4.0 * np.sin(turns)], axis=-1)
    ellipse = np.stack([4.0 * np.cos(turns), 2.5 * np.sin(turns)], axis=-1)
    return ellipse + offset * normal / np.hypot(*normal.T)[:, None]


def test_two_parallel_curves_are_a_wall_along_their_middle():
    (ribbon,) = ribbons_of([bow(0.1), bow(-0.1)], [False, False], [], named=True)
    assert ribbon.width == pytest.approx(0.2, abs=2e-3)
    assert np.hypot(*(ribbon.points / [4.0, 2.5]).T) == pytest.approx(np.ones(len(ribbon.points)), abs=5e-3)
    wall = ribbon.wall(None)
    assert (wall.thickness, wall.closed, ribbon.wall(0.3).thickness) == (pytest.approx(0.2, abs=2e-3), False, 0.3)
    points = np.array([[0.0, 2.5], [0.0, 2.8]])
    assert ribbon.holds(points).tolist() == [True, False]
    pieces, _ = split([np.array([[4.0, 3.0], [6.0, 3.0]]), np.array([[-0.1, 2.5], [0.1, 2.5]])], [False, False])
    assert without_ribbons(pieces, [ribbon]).ends.tolist() == [[[4.0, 3.0], [6.0, 3.0]]]
    assert without_ribbons(pieces, []) is pieces


@pytest.mark.parametrize(
    ("faces", "named", "found"),
    [
        ((bow(0.1), bow(-0.1)), False, 1),
        ((bow(0.1, 1.0), bow(-0.1, 1.0)), False, 0),  # shorter than 6 m
        ((bow(0.1, 1.0), bow(-0.1, 1.0)), True, 1),
        ((bow(0.1), bow(-0.1) - [0.0, 2.0]), True, 0),  # far apart
        ((bow(0.1), bow(0.1) - np.linspace([0.0, 0.05], [0.0, 0.4], 120)), True, 0),  # a wedge
    ],
)
def test_curves_are_a_wall_if_they_are_long_and_parallel(faces, named, found):
    assert len(ribbons_of(faces, [False, False], [], named=named)) == found


def test_a_ring_of_two_ellipses_is_a_closed_wall():
    turns = np.linspace(0.0, 2 * math.pi, 200, endpoint=False)
    inner, outer = (np.stack([a * np.cos(turns), b * np.sin(turns)], axis=-1) for a, b in ((3.0, 2.0), (3.2, 2.2)))
    (ribbon,) = ribbons_of([inner, outer], [True, True], [], named=False)
    assert ribbon.wall(None).closed


def box(x: float, y: float, length: float, width: float) -> Line:
    points = np.array([[x, y], [x + length, y], [x + length, y + width], [x, y + width]])
    return Line(points, closed=True, dark=1.0)


@pytest.mark.parametrize(
    ("lines", "count"),
    [
        ([box(0, 0, 4, 0.1), box(0, 0.1, 4, 0.1)], 1),  # two halves
        ([box(0, 0, 1, 1), box(1, 0, 1, 1)], 1),  # tiles that are a rectangle
        ([box(0, 0, 1, 1), box(1, 0.4, 1, 1)], 2),  # an offset: no rectangle, not slender
        ([box(0, 0, 4, 0.1), box(0, 0.2, 4, 0.1)], 2),  # a gap
        ([box(0, 0, 4, 0.1), box(4, 0, 4, 0.1)], 2),  # slender ones touch end to end alone
        ([box(0, 0, 4, 0.1)], 1),
    ],
)
def test_filled_shapes_of_one_wall_are_merged(lines, count):
    made = united(lines)
    assert len(made) == count
    area = sum(shapely.Polygon(line.points).area for line in made)
    assert area == pytest.approx(sum(np.prod(np.ptp(line.points, axis=0)) for line in lines), abs=1e-6)


def test_a_column_is_neither_slender_nor_concave():
    assert is_compact(box(0, 0, 1.9, 1).points)
    assert not is_compact(box(0, 0, 2.1, 1).points)
    assert not is_compact(np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float))


def test_a_drawing_says_its_scale_or_it_is_asked_for():
    line = Line(np.array([[2.0, 3.0], [12.0, 8.0]]), False)

    def drawing(unit: float | None) -> Drawing:
        return Drawing("a.svg", [line], unit)

    low, scale = corner_and_scale(drawing(0.5), [line], None)
    assert (low.tolist(), scale) == ([2.0, 3.0], 0.5)
    assert corner_and_scale(drawing(0.5), [line], 2.0)[1] == 2.0
    with pytest.raises(UsageError, match=r"10 x 5 units; give --scale METRES, the metres per unit, 1 for metres$"):
        corner_and_scale(drawing(None), [line], None)
    for size, hint in (
        (5.0, ", 1 for metres"),
        (4.9, ""),
        (61.0, ""),
        (3000.0, ", 0.001 for millimetres"),
        (2999.0, ""),
    ):
        with pytest.raises(UsageError, match=f"the metres per unit{hint}$"):
            corner_and_scale(drawing(None), [Line(np.array([[0.0, 0.0], [size, 1.0]]), False)], None)
    large = Line(line.points * 500, False)
    with pytest.raises(UsageError, match=r"5000 x 2500 units; .*, 0.001 for millimetres$"):
        corner_and_scale(drawing(None), [large], None)
    with pytest.raises(UsageError, match=r"is 5000 x 2500 m at 1m per unit; .* another --scale, 0.001 for millimetres"):
        corner_and_scale(drawing(1.0), [large], None)


LM, WP = np.array([[10.0, 50.0], [0.0, -10.0]]), np.array([[0.0, 0.0, 100.0, 100.0], [30.0, 30.0, 10.0, 50.0]])


def test_a_landmark_map_in_centimetres_is_read_in_metres(tmp_path):
    path = tmp_path / "map.mat"
    savemat(path, {"lm": LM, "wp": WP})
    found = read_landmarks(path, scale=0.01)
    assert found.landmarks.tolist() == [[0.1, 0.0], [0.5, -0.1]]
    assert found.waypoints.tolist() == (0.01 * WP.T).round(3).tolist()
    assert found.length() == pytest.approx(math.hypot(1.0, 0.2) + 0.4)
    savemat(path, {"lm": LM})
    assert read_landmarks(path, scale=1.0).length() == 0.0


@pytest.mark.parametrize(
    ("content", "scale", "said"),
    [
        ({"wp": WP}, 1.0, "holds no landmarks: lm, 2 x n; it holds wp"),
        ({"lm": np.zeros((2, 0))}, 1.0, "an empty lm; a map has at least one"),
        ({"lm": LM}, 101.0, "extends to 5050 m; the limit is 5000 m"),
        ({"lm": np.ones((1, 5))}, 1.0, r"lm of 1 x 5; it must be 2 x n numbers"),
        ({"lm": np.full((2, 1), np.nan)}, 1.0, "lm that is not finite"),
        ({"lm": "words"}, 1.0, "it must be 2 x n numbers"),
        ({"lm": np.zeros((2, 2001))}, 1.0, "has 2001 columns in lm; at most 2000 can be read"),
        ({"lm": LM, "wp": np.zeros((2, 1001))}, 1.0, "has 1001 columns in wp; at most 1000 can be read"),
    ],
)
def test_what_is_no_landmark_map_is_refused_in_words(tmp_path, content, scale, said):
    savemat(tmp_path / "map.mat", content)
    with pytest.raises(UsageError, match=said):
        read_landmarks(tmp_path / "map.mat", scale=scale)


def test_the_robot_of_a_landmark_map_starts_at_the_first_waypoint_and_looks_to_the_next():
    world = world_from_landmarks(LandmarkMap(LM.T / 10, WP.T / 10), name="a", preset="pioneer3dx")
    assert [(each.name, each.at) for each in world.beacons] == [("lm1", (1.0, 0.0)), ("lm2", (5.0, -1.0))]
    (robot,) = world.robots
    assert (robot.at, robot.heading_deg) == ((0.0, 3.0), round(math.degrees(math.atan2(-2.0, 10.0)), 1))
    navigator = world.run.drivers["scout"].navigator.arguments()
    assert navigator["points"] == (WP.T[1:] / 10).tolist()
    assert world.run.seconds == max(60.0, math.ceil(1.4 * (math.hypot(10.0, 2.0) + 4.0) / 0.6))
    far = world_from_landmarks(LandmarkMap(LM.T / 10, WP.T), name="a", preset="pioneer3dx")
    assert far.run.seconds == math.ceil(1.4 * (math.hypot(100.0, 20.0) + 40.0) / 0.6)


def test_without_waypoints_the_robot_stands_amid_the_landmarks():
    none = np.zeros((0, 2))
    world = world_from_landmarks(LandmarkMap(LM.T / 10, none), name="a", preset="pioneer3dx")
    assert (world.robots[0].at, world.robots[0].heading_deg) == ((3.0, -0.5), 0.0)
    assert world.run.drivers["scout"].navigator is None
    assert world_from_landmarks(LandmarkMap(LM.T, none), name="a", preset=None).robots == ()


SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="10m" height="8m" viewBox="0 0 10 8">{}</svg>'


def test_the_lines_of_a_drawing_are_where_its_world_says(tmp_path):
    path, world = tmp_path / "a.svg", tmp_path / "a.yaml"
    path.write_text(SVG.format('<path d="M1 1H9V7H1Z" fill="none" stroke="#000" stroke-width="0.1"/>'))
    world.write_text("# From the drawing a.svg: 0.5 m to its unit, its place [2, 3] is [0, 0] here\nmjsim: 1\n")
    plain = read_here(path, reading=Reading(scale=1.0))
    placed = read_here(path, world=world)
    assert np.ptp(plain.bounds, axis=0) == pytest.approx([8.0, 6.0], abs=0.2)
    raw, there = (np.concatenate([line.points for line in each.strokes]) for each in (plain, placed))
    # The lower left corner of the drawing is [1, -7], as y goes up; that is 1 and 10 from [2, 3].
    assert there == pytest.approx(0.5 * (raw - [1.0, 10.0]), abs=0.06)
    assert placed.name == "a.svg"
    assert placed.bounds == pytest.approx(np.array([there.min(axis=0), there.max(axis=0)]))


@pytest.mark.parametrize("head", ["", "# From the map m.pgm: 20 x 30 cells of 0.1 m.\nmjsim: 1\n"])
def test_the_picture_of_a_map_has_a_margin_and_lies_at_its_cells(tmp_path, head):
    from mjsim.models import encode_png

    gray = np.full((40, 60, 3), 205, np.uint8)
    gray[10:20, 15:45] = 254
    gray[10, 15:45] = 0
    (tmp_path / "m.png").write_bytes(encode_png(gray))
    (tmp_path / "w.yaml").write_text(head)
    if head:
        found = read_here(tmp_path / "m.png", world=tmp_path / "w.yaml")
        assert found.cell == 0.1
    else:
        found = read_here(tmp_path / "m.png", reading=Reading(scale=0.2))
        assert found.cell == 0.2
    # Ten cells around rows 10 to 19 (from above) and columns 15 to 44.
    assert found.picture.shape[:2] == (30, 50)
    assert np.ptp(found.bounds, axis=0) == pytest.approx([50 * found.cell, 30 * found.cell])
    values, counts = np.unique(found.picture[..., 0], return_counts=True)
    assert dict(zip(values.tolist(), counts.tolist(), strict=True)) == {20: 30, 205: 30 * 50 - 300, 255: 270}
    assert found.picture[19, 10:40, 0].tolist() == [20] * 30  # the top row of the walls; rows go up
    at = found.world_from_picture
    assert found.bounds[0] == pytest.approx([at.x, at.y])


def test_what_is_neither_map_nor_drawing_is_refused(tmp_path):
    (tmp_path / "a.txt").write_text("a")
    with pytest.raises(UsageError, match=r"is not a supported file; name a map's .yaml, an .svg or a .dxf file"):
        read_original(tmp_path / "a.txt")


@pytest.mark.parametrize(("gap", "found"), [(0.06, 1), (0.1, 1)])
def test_an_arc_beside_the_swing_of_a_leaf_is_the_face_of_a_thin_wall(gap, found):
    assert is_door_arc(arc_through(arc(0.9, 0.0, 90.0), 0))
    assert not is_door_arc(arc_through(arc(0.9 + gap, 0.0, 180.0), 0))
    assert len(curves_of([arc(0.9, 0.0, 90.0), arc(0.9 + gap, 0.0, 180.0)], [False, False])) == found
    assert len(curves_of([arc(0.9, 0.0, 90.0), arc(0.9 + gap, 0.0, 90.0)], [False, False])) == (gap > 0.08)


def test_subclass_markers_stand_between_the_groups_of_all_entities_and_its_own():
    bare = b"0\nLWPOLYLINE\n5\n2F\n8\nWalls\n90\n2\n10\n5\n20\n0\n"
    text = with_subclasses(b"0\nSECTION\n2\nENTITIES\n" + bare + b"0\nENDSEC\n0\nEOF\n")
    marked = b"0\nLWPOLYLINE\n5\n2F\n100\nAcDbEntity\n8\nWalls\n100\nAcDbPolyline\n90\n2\n10\n5\n20\n0\n"
    assert marked in text
    assert with_subclasses(text).count(b"AcDbPolyline") == 1
