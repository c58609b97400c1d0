"""Walls from lines: faces side by side, corners where they meet, patterns that are none; and the sky of an SDF file."""

import math
import struct
from xml.etree import ElementTree

import numpy as np
import pytest

from mjsim.exchange import write_sdf
from mjsim.exchange.drawings.strokes import Pieces, arc_through, is_door_arc, patterned, runs, split
from mjsim.exchange.drawings.wall_faces import merged, paired
from mjsim.exchange.maps.cell_shapes import Bar, bar_between
from mjsim.exchange.maps.joined_walls import runs_of
from mjsim.models import any_picture_size
from mjsim.models.picture_sizes import orientation
from mjsim.world import parse_world


def pieces(*ends: tuple[float, float, float, float]) -> Pieces:
    return Pieces(np.array(ends, dtype=float).reshape(-1, 2, 2), np.arange(len(ends)))


@pytest.mark.parametrize(
    ("lines", "ends"),
    [
        ([(0, 0, 2, 0), (2, 0, 5, 0)], [(0, 5)]),
        ([(0, 0, 2, 0), (5, 0, 1.5, 0)], [(0, 5)]),  # they overlap
        ([(0, 0, 2, 0), (2.015, 0, 5, 0)], [(0, 5)]),
        ([(0, 0, 2, 0), (2.03, 0, 5, 0)], [(0, 2), (2.03, 5)]),
        ([(0, 0, 2, 0), (2, 0.01, 5, 0.01)], [(0, 2), (2, 5)]),  # beside one another
        ([(0, 0, 2, 0), (2, 0, 5, 0.1)], [(0, 2), (2, 5)]),  # another direction
        ([], []),
    ],
)
def test_lines_that_continue_each_other_are_one(lines, ends):
    found = merged(pieces(*lines))
    assert sorted(tuple(sorted(end[:, 0].tolist())) for end in found.ends) == [pytest.approx(each) for each in ends]


@pytest.mark.parametrize(
    ("lines", "walls", "faces"),
    [
        ([(0, 0, 4, 0), (0, 0.2, 4, 0.2)], [(0.2, 4.0)], 2),
        ([(0, 0, 4, 0), (4, 0.2, 0, 0.2)], [(0.2, 4.0)], 2),  # the other way round
        ([(0, 0, 4, 0), (0, 0.1, 4, 0.1), (0, 0.2, 4, 0.2)], [(0.2, 4.0)], 3),  # the outer two
        ([(0, 0, 4, 0), (0, 0.03, 4, 0.03)], [], 0),  # too near
        ([(0, 0, 4, 0), (0, 0.55, 4, 0.55)], [], 0),  # too far
        ([(0, 0, 4, 0), (0, 0.2, 4, 0.4)], [], 0),  # a wedge
        ([(0, 0, 4, 0), (3.9, 0.2, 8, 0.2)], [], 0),  # hardly side by side
    ],
)
def test_two_parallel_lines_are_the_faces_of_a_wall(lines, walls, faces):
    found = paired(pieces(*lines))
    assert [(bar.width, bar.length) for bar in found.bars] == [pytest.approx(each, abs=1e-6) for each in walls]
    assert np.count_nonzero(found.faces) == faces
    if walls:
        assert (found.bars[0].x, found.bars[0].y) == pytest.approx((2.0, 0.1))
        assert math.sin(found.bars[0].heading) == pytest.approx(0.0, abs=1e-9)


def bar(x0: float, y0: float, x1: float, y1: float, width: float = 2.0) -> Bar:
    return bar_between(np.array([x0, y0], dtype=float), np.array([x1, y1], dtype=float), width)


@pytest.mark.parametrize(
    ("bars", "found"),
    [
        ([bar(0, 0, 20, 0), bar(20.5, 0.5, 20.5, 15)], [([[0, 0], [20.5, 0], [20.5, 15]], False)]),
        ([bar(0, 0, 20, 0), bar(20.5, -4, 20.5, 15, 3.0)],
         [([[0, 0], [20.5, 0]], False), ([[20.5, -4], [20.5, 15]], False)]),
        ([bar(0, 0, 20, 0), bar(10, 1, 10, 15)], [([[0, 0], [20, 0]], False), ([[10, 0], [10, 15]], False)]),  # a T
        ([bar(0, 0, 20, 0), bar(10, 5, 10, 15)], [([[0, 0], [20, 0]], False), ([[10, 5], [10, 15]], False)]),  # apart
        ([bar(0, 0, 20, 0), bar(20, 0, 40, 2)], [([[20, 0], [40, 2]], False), ([[0, 0], [20, 0]], False)]),  # too level
        (
            [bar(0, 0, 20, 0), bar(20, 0, 20, 10), bar(20, 10, 0, 10), bar(0, 10, 0, 0)],
            [([[0, 0], [20, 0], [20, 10], [0, 10]], True)],
        ),
        ([], []),
    ],
)  # fmt: skip
def test_walls_are_joined_where_they_meet(bars, found):
    made = runs_of(bars)
    assert [run.closed for run in made] == [closed for _, closed in found]
    for run, (corners, closed) in zip(made, found, strict=True):
        points = run.points
        if closed:
            assert {tuple(np.round(each, 6)) for each in points} == {tuple(map(float, each)) for each in corners}
        else:
            ways = [points, points[::-1]]
            assert any(way.shape == np.shape(corners) and np.allclose(way, corners) for way in ways)
    assert all(run.thickness in (2.0, 3.0) for run in made)


def swing(radius: float, sweep: float) -> np.ndarray:
    turns = np.radians(np.linspace(10.0, 10.0 + sweep, max(8, round(abs(sweep) / 3))))
    return np.array([3.0, 4.0]) + radius * np.stack([np.cos(turns), np.sin(turns)], axis=-1)


@pytest.mark.parametrize(
    ("radius", "sweep", "door"),
    [(0.9, 90, True), (0.9, -90, True), (0.44, 90, False), (1.71, 90, False), (0.9, 38, False), (0.9, 128, False)],
)
def test_arcs_as_of_doors_are_told_apart(radius, sweep, door):
    arc = arc_through(swing(radius, sweep), 7)
    assert (arc.middle.tolist(), arc.radius, arc.owner) == (pytest.approx([3.0, 4.0]), pytest.approx(radius), 7)
    assert math.degrees(arc.sweep) == pytest.approx(abs(sweep))
    assert math.degrees(arc.first) == pytest.approx(min(10.0, 10.0 + sweep))
    assert is_door_arc(arc) == door
    found, arcs = split([swing(radius, sweep)], [False])
    assert (len(arcs), len(found.ends) > 0) == (int(door), not door)


def test_polylines_are_cut_at_sharp_corners():
    curve = swing(0.9, 90)
    end, start = curve[-1], curve[0]
    line = np.concatenate([[np.subtract(start, [2.0, 0.0])], curve, [np.add(end, [0.0, 3.0])]])
    assert [curved for _, curved in runs(line)].count(True) == 1
    assert [curved for _, curved in runs(np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0.0]]))] == [False] * 4
    zigzag = np.array([[0, 0], [1, 0.2], [2, 0], [3, 0.2], [4, 0.0]])
    assert not any(curved for _, curved in runs(zigzag))
    ellipse = np.array([[3 * math.cos(t), math.sin(t)] for t in np.linspace(0.0, 6.0, 60)])
    assert arc_through(ellipse, 0) is None
    square, _ = split([np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])], [True])
    assert square.lengths.tolist() == [1.0] * 4
    assert square.where(np.arange(4) < 2).owner.tolist() == [0, 0]


@pytest.mark.parametrize(
    ("lines", "count"),
    [
        ([(0, 0.3 * k, 1, 0.3 * k) for k in range(4)], 1),  # stairs
        ([(0, 0.3 * k, 1, 0.3 * k) for k in range(3)], 0),
        ([(0, 0.05 * k, 1, 0.05 * k) for k in range(5)], 1),  # a hatch
        ([(0, 0.05 * k, 1, 0.05 * k) for k in range(4)], 0),
        ([(0, 0.5 * k, 1, 0.5 * k) for k in range(6)], 0),  # too far apart
        ([(0, y, 1, y) for y in (0.0, 0.3, 0.7, 1.0, 1.6)], 0),  # uneven
        ([(0, 0.3 * k, 1 + 0.5 * k, 0.3 * k) for k in range(5)], 0),  # of unlike lengths
    ],
)
def test_stairs_and_hatches_are_patterns(lines, count):
    found, patterns = patterned(pieces(*lines))
    assert (patterns, np.count_nonzero(found)) == (count, len(lines) if count else 0)


def exif(value: int, *, order: str = "<", kind: int = 3) -> bytes:
    head = (b"II*\0" if order == "<" else b"MM\0*") + (8).to_bytes(4, "little" if order == "<" else "big")
    value_text = struct.pack(f"{order}{'H2x' if kind == 3 else 'I'}", value)
    return head + struct.pack(f"{order}HHHI", 1, 274, kind, 1) + value_text


def jpeg(exif_data: bytes) -> bytes:
    part = b"Exif\0\0" + exif_data
    frame = b"\x08" + (48).to_bytes(2, "big") + (64).to_bytes(2, "big") + b"\x01\x01\x11\0"
    segments = [(0xE0, b"JFIF\0"), (0xE1, part), (0xC0, frame)]
    body = b"".join(bytes([0xFF, kind]) + (len(each) + 2).to_bytes(2, "big") + each for kind, each in segments)
    return b"\xff\xd8" + body.replace(b"\xff\xe1", b"\xff\xff\xe1", 1) + b"\xff\xda\0\x02\xff\xd9"


@pytest.mark.parametrize(("value", "found"), [(1, 1), (6, 6), (8, 8), (9, 1), (0, 1)])
def test_the_orientation_a_photo_is_read_from_its_exif_data(value, found):
    for order in "<>":
        for kind in (3, 4):
            assert orientation(jpeg(exif(value, order=order, kind=kind))) == found
    assert orientation(jpeg(b"XX")) == 1
    assert any_picture_size(jpeg(exif(1))) == (64, 48)
    with pytest.raises(ValueError, match="truncated JPEG"):
        any_picture_size(jpeg(exif(1))[:-2])


WORLD = """mjsim: 1
light: 0.5
walls: [{points: [[0, 0], [6, 0]], thickness: 0.2, height: 2.4, color: "#ff0000"}]
lamps: [{at: [1, 2], height: 2.2, color: "#ff8000", brightness: 0.5}]
ceiling: {}
"""


def test_an_sdf_file_has_sky_ground_walls_and_lamps(tmp_path):
    path = write_sdf(parse_world(WORLD), tmp_path / "a.sdf")
    assert path.read_text().startswith("<?xml version='1.0' encoding='utf-8'?>")
    world = ElementTree.parse(path).getroot().find("world")

    def floats(place: str) -> list[float]:
        return [float(word) for word in world.findtext(place).split()]

    assert floats("scene/ambient") == pytest.approx([0.3, 0.3, 0.3, 1.0])
    assert floats("light[@name='general_light']/diffuse") == pytest.approx([0.3, 0.3, 0.3, 1.0])
    (lamp,) = [each for each in world.findall("light") if each.get("type") == "point"]
    assert [float(word) for word in lamp.findtext("pose").split()] == [1.0, 2.0, 2.2, 0.0, 0.0, 0.0]
    color = [float(word) for word in lamp.findtext("diffuse").split()]
    assert color == pytest.approx([0.5, 0.5 * 128 / 255, 0.0, 1.0], abs=1e-3)
    assert float(lamp.findtext("attenuation/quadratic")) == 0.25
    assert float(lamp.findtext("attenuation/range")) > 0.0
    assert (world.findtext("physics/max_step_size"), world.findtext("physics/real_time_factor")) == ("0.004", "1")
    links = {link.get("name"): link for link in world.iter("link")} | {m.get("name"): m for m in world.iter("model")}
    sizes = {
        name: [float(w) for w in each.findtext(".//box/size").split()]
        for name, each in links.items()
        if each.find(".//box/size") is not None
    }
    (wall,) = [size for name, size in sizes.items() if "wall_" in name][:1]
    assert sorted(wall) == pytest.approx([0.2, 2.4, 6.0])
    (ceiling,) = [size for name, size in sizes.items() if "ceiling" in name][:1]
    assert ceiling == pytest.approx([6.0, 0.0, 0.05])
    plane = [float(word) for word in world.findtext(".//plane/size").split()]
    assert plane == pytest.approx([26.0, 20.0])
    heights = [
        float(each.findtext("pose").split()[2])
        for name, each in links.items()
        if "ceiling" in name and each.find("pose") is not None
    ]
    assert heights == [pytest.approx(2.425)]
