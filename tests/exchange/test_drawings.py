"""Drawings of walls come in as walls."""

import math
import time
from pathlib import Path
from xml.etree import ElementTree as ET

import ezdxf
import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange import with_robot, world_from_dxf, world_from_svg
from mjsim.exchange.drawings.dxf_in import read_dxf
from mjsim.exchange.drawings.plan_in import read_plan
from mjsim.exchange.drawings.svg_in import read_svg
from mjsim.exchange.drawings.svg_tree import made_plain
from mjsim.inventory import inventory
from mjsim.world import check_world, segments

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="210mm" viewBox="0 0 800 600">'


def svg(folder: Path, shapes: str, head: str = HEAD) -> Path:
    path = folder / "plan.svg"
    path.write_text(f"{head}{shapes}</svg>")
    return path


def test_lines_of_an_svg_become_walls_with_y_up(tmp_path):
    path = svg(
        tmp_path, '<g transform="translate(100 100)"><path stroke="#000" stroke-width="20" d="M0 0H600V400"/></g>'
    )
    (wall,) = world_from_svg(path, scale=0.01).walls
    assert set(wall.points) == {(0, 4), (6, 4), (6, 0)}
    assert wall.thickness == 0.2


def test_lines_that_meet_end_to_end_are_one_wall(tmp_path):
    sides = '<line x1="0" y1="0" x2="600" y2="0"/><line x1="600" y1="400" x2="600" y2="1"/>'
    sides += '<polyline points="600 400 0 400 0 0"/><line x2="0" y2="0" x1="600" y1="0"/>'
    (wall,) = world_from_svg(svg(tmp_path, f'<g stroke="black">{sides}</g>'), scale=0.01).walls
    assert wall.closed
    assert wall.thickness == 0.1
    assert sorted((round(x), round(y)) for x, y in wall.points) == [(0, 0), (0, 4), (6, 0), (6, 4)]


def test_a_filled_rectangle_is_a_wall_of_its_size(tmp_path):
    box = '<rect x="0" y="0" width="15" height="400" transform="rotate(-30)"/>'
    wall = world_from_svg(svg(tmp_path, box), scale=0.01).walls[0]
    assert wall.thickness == 0.15
    assert math.dist(*wall.points) == pytest.approx(4.0, abs=0.002)


def test_a_circle_bows_less_than_two_thousandths_of_its_size(tmp_path):
    path = svg(tmp_path, '<circle r="300" stroke="red" stroke-width="10"/>')
    faces = segments(world_from_svg(path, scale=0.01))
    corners = np.concatenate([faces[:, 0], faces.mean(axis=1)])
    ring = np.hypot(*(corners - 3.0).T)
    assert np.minimum(abs(ring - 3.05), abs(ring - 2.95)).max() < 0.015


def test_lengths_in_millimetres_are_read_and_those_in_percent_left_out_and_said(tmp_path):
    # A millimetre is 96 / 25.4 pixels.
    path = svg(tmp_path, '<rect width="100%" height="100%"/><line x2="105.8333333mm" y2="0"/>')
    assert [wall.points for wall in world_from_svg(path, scale=0.01).walls] == [((0, 0), (4, 0))]
    assert inventory(read_svg(path).items) == ["left out: 1 shape in percent"]


def test_shapes_far_from_the_page_are_left_out_and_those_beside_it_are_not(tmp_path):
    path = tmp_path / "stray.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 8"><path d="M-30 1h20"/><path d="M5e6-4e7l2-1"/></svg>'
    )
    drawing = read_svg(path)
    assert [line.points.tolist() for line in drawing.lines] == [[[-30.0, -1.0], [-10.0, -1.0]]]
    assert inventory(drawing.items) == ["left out: 1 shape far from the page"]


def test_only_the_named_layer_of_an_svg_is_walls_and_nothing_hidden(tmp_path):
    groups = '<g id="desks"><path d="M0 0H900"/></g>'
    groups += '<g id="walls"><path d="M0 0H400"/><path d="M0 9H300" display="none"/></g>'
    path = svg(tmp_path, groups)
    assert [wall.points for wall in world_from_svg(path, scale=0.01).walls] == [((0, 0), (4, 0))]
    assert [wall.points for wall in world_from_svg(path, scale=0.01, layers=["Desks"]).walls] == [((0, 0), (9, 0))]
    with pytest.raises(UsageError, match="no layer 'wall'; layers are desks, walls"):
        world_from_svg(path, scale=0.01, layers=["wall"])


@pytest.mark.parametrize(
    ("sheet", "style"),
    [
        ("#a{r:1} path{r:2} .b{r:3} /* .b{r:4} */ x, path.b {r:5}", "r:2;r:3;r:5;r:1;q:0"),
        ("path{r:1} .b{{r:2} {r:3} .b{r:4", "r:1;q:0"),
        (".b{r:1} /* .b{r:2}", "r:1;q:0"),
        ("/*" * 100_000, "q:0"),
        ("a" * 200_000, "q:0"),
        ("a" * 100_000 + "{" * 100_000, "q:0"),
    ],
    ids=["order", "braces", "comment", "comments", "letters", "open"],
)
def test_a_style_sheet_of_any_text_is_applied_in_one_pass(sheet, style):
    root = ET.fromstring(f'{HEAD}<style>{sheet}</style><path id="a" class="b" style="q:0"/></svg>')
    before = time.process_time()
    made_plain(root, "plan.svg")
    assert time.process_time() - before < 1
    assert root[1].get("style") == style


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("no xml", "is not XML, and so not an SVG drawing"),
        ("<html/>", "is XML but not an SVG drawing; its first element is 'html'"),
        (
            f"{HEAD}<text>wall</text></svg>",
            "no lines to make walls of (left out: 1 <text>); draw each wall as a line",
        ),
        (
            f'{HEAD}<path d="M0 0H400"/></svg>',
            "its unit, and measures 400 x 0 units; give --scale",
        ),
        (f'{HEAD}<path d="M0 0 L nonsense"/></svg>', "plan.svg"),
        (f'<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>{HEAD}&b;</svg>', "declares the XML entity 'a'"),
        (f'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/group">]>{HEAD}&a;</svg>', "declares the XML entity 'a'"),
        ("<g>" * 2000, "is not XML, and so not an SVG drawing: no element found"),
        (
            f'{HEAD}<image href="http://a.example/x.svg"/><use href="other.svg#w"/></svg>',
            "has no lines to make walls of",
        ),
    ],
)
def test_what_is_no_drawing_of_walls_is_refused_in_one_line(text, message, tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(text)
    with pytest.raises(UsageError) as caught:
        world_from_svg(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def drawn(folder: Path, *, units: int = 4) -> Path:
    """Draw a room of 6 m x 4 m in millimetres, far from the origin, with a block that is placed twice."""
    document = ezdxf.new(units=units)
    space = document.modelspace()
    corners = [(0, 0), (6000, 0), (6000, 4000), (0, 4000)]
    space.add_lwpolyline([(x + 5e6, y + 2e6) for x, y in corners], close=True, dxfattribs={"layer": "WALLS"})
    block = document.blocks.new("stub")
    block.add_lwpolyline([(0, 0), (0, 1000)], dxfattribs={"const_width": 200})
    for x in (2000, 4000):
        space.add_blockref("stub", (5e6 + x, 2e6), dxfattribs={"layer": "walls"})
    space.add_line((0, 0), (9, 9), dxfattribs={"layer": "furniture"})
    space.add_text("Room", dxfattribs={"layer": "WALLS"})
    document.saveas(folder / "plan.dxf")
    return folder / "plan.dxf"


def test_a_dxf_in_millimetres_comes_in_with_its_blocks(tmp_path):
    stub, other, room = world_from_dxf(drawn(tmp_path)).walls
    assert room.closed
    assert set(room.points) == {(0, 0), (6, 0), (6, 4), (0, 4)}
    assert sorted([stub.points, other.points]) == [((2, 0), (2, 1)), ((4, 0), (4, 1))]
    assert (stub.thickness, room.thickness) == (0.2, 0.1)


def test_a_robot_can_stand_in_what_was_drawn(tmp_path):
    assert not check_world(with_robot(world_from_dxf(drawn(tmp_path))))


def test_an_arc_of_a_dxf_follows_its_circle(tmp_path):
    document = ezdxf.new(units=6)
    document.modelspace().add_arc((0, 0), 3, 0, 90)
    document.saveas(tmp_path / "arc.dxf")
    (wall,) = world_from_dxf(tmp_path / "arc.dxf").walls
    radii = [math.hypot(x, y) for x, y in wall.points]
    assert np.allclose(radii, 3.0, atol=0.01)
    assert len(radii) > 6


def test_what_is_no_dxf_of_walls_is_refused_in_one_line(tmp_path):
    path = tmp_path / "plan.dxf"
    ezdxf.new().saveas(path)
    with pytest.raises(UsageError, match="has no lines to make walls of"):
        world_from_dxf(path)
    with pytest.raises(UsageError, match="has no layer 'b'; layers are 0, Defpoints"):
        world_from_dxf(path, layers=["b"])
    with pytest.raises(UsageError, match="does not state its unit, and measures 6000 x 4000 units"):
        world_from_dxf(drawn(tmp_path, units=0))
    with pytest.raises(UsageError, match=r"is 6000 x 4000 m at 1m per unit; a floor measures 0\.5 to 2000 m"):
        world_from_dxf(drawn(tmp_path), scale=1.0)
    for data in (b"", b"\x00\xff" * 100, b"0\nSECTION\n2\nENTITIES\n0\nLINE\n", b"hello\n" * 9):
        path.write_bytes(data)
        with pytest.raises(UsageError) as caught:
            world_from_dxf(path)
        assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_blocks_that_multiply_or_contain_themselves_are_refused(tmp_path):
    document = ezdxf.new(units=6)
    for depth in range(12):
        block = document.blocks.new(f"b{depth}")
        for x in range(10):
            block.add_blockref(f"b{depth + 1}", (x, 0))
    document.blocks.new("b12").add_line((0, 0), (1, 0))
    document.modelspace().add_blockref("b0", (0, 0))
    document.saveas(tmp_path / "bomb.dxf")
    with pytest.raises(UsageError, match="has too many lines to be walls"):
        world_from_dxf(tmp_path / "bomb.dxf")
    document = ezdxf.new(units=6)
    document.blocks.new("a").add_blockref("a", (1, 0))
    document.modelspace().add_blockref("a", (0, 0))
    document.saveas(tmp_path / "loop.dxf")
    with pytest.raises(UsageError):
        world_from_dxf(tmp_path / "loop.dxf")


def test_lines_that_are_neither_walls_nor_doors_are_told(tmp_path):
    document = ezdxf.new(units=6)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (8, 0), (8, 5), (0, 5)], close=True, dxfattribs={"layer": "A-WALL"})
    space.add_arc((3, 3), 0.9, 0, 90, dxfattribs={"layer": "A-DOOR"})
    space.add_line((1, 1), (4, 2))
    space.add_line((1, 2), (4, 3))
    document.saveas(tmp_path / "plan.dxf")
    told = inventory(read_plan(read_dxf(tmp_path / "plan.dxf")).items)
    assert told[1].startswith(
        "guessed: 2 lines on layers without a known role: doors or furniture, never walls; --layer"
    )
    assert "left out: 1 door swing beside no gap of a wall" in told


ILLUSTRATED = """<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
<!ENTITY ns_ai "http://ns.adobe.com/AdobeIllustrator/10.0/">{more}
]><svg xmlns="http://www.w3.org/2000/svg" xmlns:i="&ns_ai;"><path d="M0 0H5V4H0Z" fill="none" stroke="black"/></svg>"""


def test_namespaces_that_illustrator_declares_as_entities_are_read_and_other_entities_are_not(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(ILLUSTRATED.format(more=""))
    assert [wall.closed for wall in world_from_svg(path, scale=1.0).walls] == [True]
    for more in ('<!ENTITY a "b">', '<!ENTITY a SYSTEM "http://x/y">', '<!ENTITY a "http://x/&ns_ai;">'):
        path.write_text(ILLUSTRATED.format(more=more))
        with pytest.raises(UsageError, match="declares the XML entity 'a'; save it as plain SVG"):
            world_from_svg(path, scale=1.0)
