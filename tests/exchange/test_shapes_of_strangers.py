"""What strangers draw comes in as it stands there: half-open doors, angled furniture, named layers, deep groups."""

import math
from pathlib import Path

import pytest
import shapely

from mjsim.exchange.drawings.dxf_in import read_dxf
from mjsim.exchange.drawings.plan_in import FloorPlan, read_plan
from mjsim.exchange.drawings.svg_in import read_svg
from mjsim.inventory import inventory
from mjsim.world import World, solid

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="8000" height="4000">'
ROOM = [[(0, 0), (8, 0)], [(8, 0), (8, 4)], [(8, 4), (0, 4)], [(0, 4), (0, 0)], [(4, 0), (4, 1.5)], [(4, 2.4), (4, 4)]]
"""Two rooms, and a gap of 0.9 m between them, whose walls are single lines [m]."""
BARE = [(code, value) for code, value in ((0, "SECTION"), (2, "ENTITIES"))]
END = [(0, "ENDSEC"), (0, "EOF")]


def dxf(folder: Path, *tags: tuple[int, object]) -> Path:
    """Write a DXF file without header, tables, handles and markers, as small programs do."""
    path = folder / "plan.dxf"
    path.write_text("".join(f"{code}\n{value}\n" for code, value in [*BARE, *tags, *END]))
    return path


def polyline(points: list[tuple[float, float]], layer: str = "0", kind: str = "LWPOLYLINE") -> list[tuple[int, object]]:
    """Return the tags of a closed polyline."""
    places = [tag for x, y in points for tag in ((10, x), (20, y))]
    return [(0, kind), (8, layer), (90, len(points)), (70, 1), *places]


def line(start: tuple[float, float], end: tuple[float, float]) -> list[tuple[int, object]]:
    return [(0, "LINE"), (8, "0"), (10, start[0]), (20, start[1]), (11, end[0]), (21, end[1])]


def plan(path: Path, *layers: str, scale: float = 1.0) -> FloorPlan:
    """Return the plan of a drawing, read in this process."""
    read = read_dxf if path.suffix == ".dxf" else read_svg
    return read_plan(read(path, layers=layers), scale=scale)


def openings(world: World) -> list[tuple[float, float]]:
    return [(opening.at, opening.width) for wall in world.walls for opening in wall.openings]


@pytest.mark.parametrize(("arc", "leaf"), [(12, 12), (30, 30), (60, 60), (90, 90), (135, 135), (170, 170), (90, 40)])
def test_a_door_that_stands_open_at_any_angle_is_a_doorway_and_its_leaf_no_wall(arc, leaf, tmp_path):
    swing = [(0, "ARC"), (8, "0"), (10, 4), (20, 1.5), (40, 0.9), (50, 90), (51, 90 + arc)]
    tip = (4 - 0.9 * math.sin(math.radians(leaf)), 1.5 + 0.9 * math.cos(math.radians(leaf)))
    jambs = [tag for y in (1.5, 2.4) for tag in line((3.94, y), (4.06, y))]
    tags = [tag for start, end in ROOM for tag in line(start, end)]
    world = plan(dxf(tmp_path, *tags, *swing, *line((4, 1.5), tip), *jambs)).world
    assert openings(world) == [(pytest.approx(1.5, abs=0.02), pytest.approx(0.9, abs=0.02))]
    assert solid(world).area == pytest.approx(0.1 * (24 + 4 - 0.9), rel=0.02)


def test_an_arc_without_a_leaf_that_is_no_quarter_circle_is_no_door(tmp_path):
    swing = [(0, "ARC"), (8, "0"), (10, 4), (20, 1.5), (40, 0.9), (50, 90), (51, 110)]
    tags = [tag for start, end in ROOM for tag in line(start, end)]
    assert not openings(plan(dxf(tmp_path, *tags, *swing)).world)


@pytest.mark.parametrize("kind", ["LWPOLYLINE", "lwpolyline of a file with a header"])
def test_polylines_without_subclass_markers_are_read(kind, tmp_path):
    path = dxf(tmp_path, *polyline([(0, 0), (6, 0), (6, 4), (0, 4)]))
    if "header" in kind:
        path.write_text("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n0\nENDSEC\n" + path.read_text())
    assert solid(plan(path).world).bounds == pytest.approx((-0.05, -0.05, 6.05, 4.05))


COUCH = [(0.5, 2.6), (2.1, 2.6), (2.1, 0.6), (3.0, 0.6), (3.0, 3.5), (0.5, 3.5)]
"""A corner couch: 0.9 x 2.5 m and 0.9 x 2.9 m overlap in the corner; 4.05 m2."""


@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_angled_furniture_is_divided_and_a_table_in_its_corner_stays(turn, tmp_path):
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    table = [(1.0, 1.2), (1.6, 1.2), (1.6, 2.0), (1.0, 2.0)]
    both = [[(3 + c * x - s * y, 2 + s * x + c * y) for x, y in shape] for shape in (COUCH, table)]
    tags = polyline([(0, 0), (8, 0), (8, 8), (0, 8)], "WALLS") + polyline(
        [(0.2, 0.2), (7.8, 0.2), (7.8, 7.8), (0.2, 7.8)], "WALLS"
    )
    world = plan(dxf(tmp_path, *tags, *(tag for shape in both for tag in polyline(shape, "FURNITURE")))).world
    assert len(world.obstacles) == 3
    found = solid(World(obstacles=world.obstacles))
    x, y = world.walls[0].points[0]
    wanted = shapely.union_all([shapely.Polygon(shape) for shape in both])
    assert found.area == pytest.approx(4.05 + 0.48, rel=0.01)
    assert found.symmetric_difference(wanted).area < 0.05
    assert (x, y) == pytest.approx((0.1, 0.1))


def test_a_layer_that_the_user_names_counts_though_it_is_frozen_and_others_are_told(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new("R2000", units=6)
    for name, frozen in (("WALLS", False), ("OLD WALLS", True)):
        if frozen:
            document.layers.add(name).freeze()
    document.modelspace().add_line((3, 0), (3, 2), dxfattribs={"layer": "WALLS"})
    document.modelspace().add_line((0, 0), (6, 0), dxfattribs={"layer": "OLD WALLS"})
    document.saveas(tmp_path / "plan.dxf")
    both = plan(tmp_path / "plan.dxf", "WALLS", "OLD WALLS")
    assert solid(both.world).bounds[2] - solid(both.world).bounds[0] == pytest.approx(6.0, abs=0.2)
    alone = plan(tmp_path / "plan.dxf")
    assert "left out: 1 on layer old walls, which is off or frozen" in inventory(alone.items)


def test_groups_may_be_nested_as_deeply_as_a_program_writes_them(tmp_path):
    walls = "".join(
        f'<rect x="{x}" y="{y}" width="{wide}" height="{high}"/>'
        for x, y, wide, high in ((0, 0, 6000, 100), (0, 3900, 6000, 100), (0, 0, 100, 4000), (5900, 0, 100, 4000))
    )
    deep = 1200
    groups = '<g transform="translate(1 0)">' * deep
    text = f"{HEAD}{groups}{walls}{'</g>' * deep}</svg>"
    (tmp_path / "plan.svg").write_text(text)
    found = plan(tmp_path / "plan.svg", scale=0.001)
    assert solid(found.world).bounds == pytest.approx((0.0, 0.0, 6.0, 4.0), abs=0.11)
    assert found.corner[0] == pytest.approx(deep, abs=60)
