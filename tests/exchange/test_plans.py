"""Plans as drawing programs save them: two faces are one wall, symbols are openings, furniture stands in rooms."""

import math
import time
from functools import cache
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from shapely import affinity, box

from mjsim.errors import UsageError
from mjsim.exchange import Reading, read_original, world_from_dxf, world_from_svg
from mjsim.exchange.drawings.plan_in import FloorPlan
from mjsim.exchange.import_world import plan_of
from mjsim.inventory import inventory
from mjsim.video import draw_beside
from mjsim.world import World, check_world, solid

PLANS = Path(__file__).parents[1] / "data" / "plans"
SCALES = {"flat.svg": 0.02, "illustrator.svg": 0.01, "plain.dxf": 1.0}


@cache
def plan(name: str) -> FloorPlan:
    return plan_of(PLANS / name, Reading(scale=SCALES.get(name)))[0]


def walls_alone(world: World) -> shapely.Geometry:
    """Return what walls cover, openings closed."""
    walls = tuple(wall.model_copy(update={"openings": ()}) for wall in world.walls)
    return solid(World(walls=walls))


def holes(world: World, *, window: bool) -> list[tuple[float, float, float]]:
    """Return the middle and the width of each doorway or window, sorted."""
    found = []
    for wall in world.walls:
        for opening in wall.openings:
            if (opening.sill > 0) == window:
                start, end = np.array(wall.segments()[opening.segment])
                along = (end - start) / math.dist(start, end)
                x, y = start + along * (opening.at + opening.width / 2)
                found.append((round(float(x), 2) + 0.0, round(float(y), 2) + 0.0, round(opening.width, 2)))
    return sorted(found)


def assert_holes(found: list[tuple[float, float, float]], expected: list[tuple[float, float, float]]) -> None:
    """Check that openings agree to a centimetre."""
    np.testing.assert_allclose(found, expected, atol=0.011)


def assert_same(one: shapely.Geometry, other: shapely.Geometry) -> None:
    """Check that outlines agree to a centimetre along all of them."""
    assert one.symmetric_difference(other).area < 0.01 * (one.length + other.length) / 2


def test_an_office_of_layers_blocks_and_two_faces_is_what_was_drawn():
    world = plan("office.dxf").world
    rooms = [
        (0.3, 0.3, 4.74, 4.94), (4.86, 0.3, 9.54, 4.94), (9.66, 0.3, 14.7, 4.94),
        (0.3, 5.06, 14.7, 6.74), (0.3, 6.86, 7.24, 9.3), (7.36, 6.86, 14.7, 9.3),
    ]  # fmt: skip
    assert_same(walls_alone(world), box(0, 0, 15, 9.6) - shapely.union_all([box(*room) for room in rooms]))
    expected = [(2.25, 5.0, 0.9), (3.45, 6.8, 0.9), (6.65, 5.0, 0.9), (9.45, 6.8, 0.9), (11.45, 5.0, 0.9)]
    assert holes(world, window=False) == expected
    assert holes(world, window=True) == [(2.4, 0.15, 1.8), (5.9, 0.15, 1.8), (9.9, 0.15, 1.8)]
    assert {wall.thickness for wall in world.walls} == {0.3, 0.12}
    boxes = [item for item in world.obstacles if item.name.startswith("desk")]
    assert len(boxes) == 4
    turned = next(item for item in boxes if abs(item.heading_deg - 30) < 0.1)
    assert turned.box[:2] == pytest.approx((1.6, 1.35), abs=2e-3)
    assert plan("office.dxf").scale == 0.001
    assert "left out: 1 DIMENSION, 1 MTEXT" in inventory(plan("office.dxf").items)


def test_a_house_of_closed_outlines_has_insulated_walls_and_doors_of_bulges():
    world = plan("house.dxf").world
    rooms = shapely.union_all([box(0.39, 0.39, 4.0, 7.11), box(4.115, 0.39, 8.61, 4.3), box(4.115, 4.415, 8.61, 7.11)])
    assert_same(walls_alone(world), box(0, 0, 9, 7.5) - rooms)
    assert {wall.thickness for wall in world.walls} == {0.39, 0.115}
    assert_holes(holes(world, window=False), [(2.0, 0.2, 1.01), (4.06, 3.44, 0.88), (6.04, 4.36, 0.88)])
    assert_holes(holes(world, window=True), [(6.1, 0.2, 1.2), (7.6, 0.2, 1.2)])
    (column,) = (item for item in world.obstacles if item.name.startswith("column"))
    assert column.box == (0.3, 0.3, 2.5)


def test_a_plan_without_layers_is_told_by_its_geometry():
    world = plan("plain.dxf").world
    assert_same(
        walls_alone(world), box(0, 0, 8, 6) - shapely.union_all([box(0.2, 0.2, 4.95, 5.8), box(5.05, 0.2, 7.8, 5.8)])
    )
    assert holes(world, window=False) == [(1.45, 0.1, 0.9), (5.0, 2.4, 0.8)]
    assert not world.obstacles
    lines = inventory(plan("plain.dxf").items)
    assert any("lines of a frame" in line and "hatches or stairs" in line for line in lines)


def test_a_flat_that_another_program_wrote_as_svg_and_as_dxf_is_the_same():
    drawn, cad = plan("flat.svg").world, plan("flat.dxf").world
    assert_same(walls_alone(drawn), walls_alone(cad))
    doors = [(2.92, 4.32, 0.85), (5.12, 7.12, 1.0), (5.62, 3.48, 0.85), (6.52, 4.32, 0.85), (7.92, 5.16, 0.75)]
    assert_holes(holes(drawn, window=False), doors)
    assert len(holes(drawn, window=True)) == 4
    assert len(holes(cad, window=False)) == 9  # its layer for openings does not tell doors from windows
    assert len(drawn.obstacles) == len(cad.obstacles) == 6


def test_layers_clones_and_the_scale_of_an_inkscape_drawing_are_read():
    result = plan("inkscape.svg")
    assert result.scale == pytest.approx(0.05)  # a millimetre on paper at 1 : 50
    world = result.world
    rooms = shapely.union_all([box(0.25, 0.25, 4.625, 4.75), box(4.775, 0.25, 7.75, 4.75)])
    assert_same(walls_alone(world), box(0, 0, 8, 5) - rooms)
    stools = sorted((item.at, item.cylinder[0]) for item in world.obstacles if hasattr(item, "cylinder"))
    assert stools == [((1.25, 1.5), 0.2), ((2.25, 1.5), 0.2), ((6.5, 3.5), 0.3)]
    assert holes(world, window=False) == [(2.0, 4.88, 1.0), (4.7, 2.3, 0.9)]


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("Scale 1/4&quot; = 1'-0&quot;", 48 * 0.0254),
        ("1 in = 8 ft 4 in", 100 * 0.0254),
        ("1" * 50_000 + ' 1" = 8\' 4"', 100 * 0.0254),
    ],
)
def test_the_scale_of_a_drawing_in_inches_is_read(text, metres, tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="17in" height="11in" viewBox="0 0 17 11">'
        f'<path d="M2 2h9v6h-9z" fill="none" stroke="#000" stroke-width="0.1"/><text>{text}</text></svg>'
    )
    assert plan_of(path, Reading())[0].scale == pytest.approx(metres)


def test_filled_paths_of_an_illustrator_drawing_are_walls_and_light_shapes_furniture():
    world = plan("illustrator.svg").world
    assert {wall.thickness for wall in world.walls} == {0.25, 0.12}
    inner = shapely.union_all([box(5.0, 4.0, 5.12, 6.75), box(5.0, 1.88, 5.12, 3.1), box(5.12, 1.88, 9.75, 2.0)])
    ring = box(0, 0, 10, 7) - box(0.25, 0.25, 9.75, 6.75)
    parts = shapely.union_all([ring, inner, box(0.25, 3.38, 2.25, 3.5), box(3.15, 3.38, 5.0, 3.5)])
    assert_same(solid(World(walls=world.walls)), parts - box(2.5, 0, 3.4, 0.25))
    assert sorted(item.name.split("-")[0] for item in world.obstacles) == ["column", "thing", "thing"]


@pytest.mark.parametrize("name", ["office.dxf", "house.dxf", "plain.dxf", "flat.dxf", "flat.svg", "inkscape.svg"])
def test_a_plan_becomes_a_world_that_is_well(name):
    assert not check_world(plan(name).world)


def test_a_plan_that_lies_turned_and_far_away_comes_in_turned(tmp_path):
    document = ezdxf.readfile(PLANS / "house.dxf")
    for entity in document.modelspace():
        entity.rotate_z(math.radians(17))
        entity.translate(3e6, -2e6, 0)
    document.saveas(tmp_path / "turned.dxf")
    world = world_from_dxf(tmp_path / "turned.dxf")
    level = walls_alone(plan("house.dxf").world)
    turned = affinity.rotate(level, 17, origin=(0, 0))
    low = np.array(turned.bounds[:2])
    assert_same(walls_alone(world), affinity.translate(turned, *-low))
    assert len(holes(world, window=False)) == 3
    assert len(holes(world, window=True)) == 2


def test_furniture_is_left_out_when_asked():
    kept = plan("office.dxf").world
    bare = plan_of(PLANS / "office.dxf", Reading(furniture=False))[0]
    assert bare.world.walls == kept.walls
    assert not bare.world.obstacles
    assert any("5 unwanted pieces of furniture" in note for note in inventory(bare.items))


def test_a_layer_that_is_named_is_walls_whatever_others_are_called():
    world = world_from_dxf(PLANS / "house.dxf", layers=["AR_Moebel"], thickness=0.05)
    assert {wall.thickness for wall in world.walls} == {0.05}
    assert len(world.walls) == 2


@pytest.mark.slow
def test_the_drawing_and_the_world_stand_beside_each_other_at_one_scale(tmp_path):
    world = plan("plain.dxf").world
    original = read_original(PLANS / "plain.dxf", reading=Reading(scale=1.0))
    page = draw_beside(world, original, tmp_path / "both.png")
    assert (tmp_path / "both.png").stat().st_size > 10_000
    width = page.shape[1] // 2
    dark = (page.min(axis=-1) < 120).astype(np.uint8)
    # The thick outer wall of the world covers both lines of the drawing.
    rows, columns = np.nonzero(dark[:, width:])
    left = dark[:, :width]
    building = (slice(rows.min(), rows.max()), slice(columns.min(), columns.max()))
    assert left[building].sum() > 0
    assert dark[:, width:][building].sum() > left[building].sum()


def test_what_is_filled_with_a_hole_is_drawn_with_its_hole(tmp_path):
    frame = '<path d="M0 0H4V4H0Z M.3 .3V3.7H3.7V.3Z" fill="black" fill-rule="evenodd"/>'
    (tmp_path / "frame.svg").write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 4">{frame}</svg>')
    reading = Reading(scale=1.0)
    original = read_original(tmp_path / "frame.svg", reading=reading)
    page = draw_beside(plan_of(tmp_path / "frame.svg", reading)[0].world, original)
    drawn = page[:, : page.shape[1] // 2].min(axis=-1) < 120
    rows, columns = np.nonzero(drawn)
    across = drawn[int(np.median(rows)), columns.min() : columns.max()]
    assert 0.05 < across.mean() < 0.3  # two sides of 0.3 m of 4 m


@pytest.mark.parametrize(
    ("shapes", "message"),
    [
        ('<g id="a"><use href="#a"/></g><path d="M0 0H4" stroke="red"/>', None),
        ("<g id='a'>" + "<path d='M0 0H4'/>" * 300 + "</g>" + "<use href='#a'/>" * 300, "elements with its clones"),
        ('<g id="furniture"><path d="M0 0H4V4Z"/></g>', "has no lines to make walls of"),
        ('<path d="M0 0H1e999" stroke="red"/>', "without finite coordinates"),
        ('<line x2="4em" y2="1"/>', "has no lines to make walls of"),
    ],
)
def test_unusual_drawings_are_refused_in_one_line(shapes, message, tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg">{shapes}</svg>')
    if message is None:
        assert len(world_from_svg(path, scale=1.0).walls) == 1
        return
    with pytest.raises(UsageError, match=message) as caught:
        world_from_svg(path, scale=1.0)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_plan_of_two_hundred_rooms_comes_in_within_a_quarter_of_a_minute(tmp_path):
    document = ezdxf.new(units=6)
    space = document.modelspace()
    for x, y in ((5.0 * i, 4.0 * j) for i in range(20) for j in range(10)):
        for inset in (0.0, 0.1):
            space.add_lwpolyline(
                [
                    (x + u, y + v)
                    for u, v in ((inset, inset), (5 - inset, inset), (5 - inset, 4 - inset), (inset, 4 - inset))
                ],
                close=True,
            )
    document.saveas(tmp_path / "rooms.dxf")
    began = time.process_time()
    world = world_from_dxf(tmp_path / "rooms.dxf")
    assert time.process_time() - began < 15.0  # 4 s on a core of 2026; quadratic code took minutes
    assert_same(
        walls_alone(world),
        box(0, 0, 100, 40)
        - shapely.union_all(
            [box(5 * i + 0.1, 4 * j + 0.1, 5 * i + 4.9, 4 * j + 3.9) for i in range(20) for j in range(10)]
        ),
    )
