"""Plans as people draw them for the web: rooms as boxes, doors painted over in the colour of the paper, poché."""

import math
import warnings
from itertools import pairwise
from pathlib import Path

import pytest
import shapely
from shapely import box

from mjsim.exchange.drawings.plan_in import FloorPlan, read_plan
from mjsim.exchange.drawings.svg_in import read_svg
from mjsim.inventory import inventory
from mjsim.world import World, solid


def bar(x: float, y: float, width: float, height: float, fill: str) -> str:
    """Return a filled rectangle."""
    return f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="{fill}"/>'


def drawn(tmp_path: Path, shapes: str, *, more: str = "", unit: float = 0.01) -> FloorPlan:
    """Return the plan of shapes in an SVG, one unit a centimetre unless given."""
    path = tmp_path / "plan.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1000 800" {more}>{shapes}</svg>')
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return read_plan(read_svg(path), scale=unit)


def test_doors_painted_white_over_the_walls_of_rooms_side_by_side_are_doorways(tmp_path):
    rooms = "".join(
        f'<rect x="{x}" y="{y}" width="400" height="300" style="fill:#fff;stroke:#000;stroke-width:20"/>'
        for x, y in ((0, 0), (400, 0), (0, 300), (400, 300))
    )
    doors = bar(380, 100, 40, 90, "#ffffff")
    doors += '<rect x="100" y="285" width="120" height="30" fill="white" stroke="none"/>'
    plan = drawn(tmp_path, f'<rect width="1000" height="800" fill="#fff"/>{rooms}{doors}')
    openings = [opening for wall in plan.world.walls for opening in wall.openings]
    assert sorted(opening.width for opening in openings) == pytest.approx([0.9, 1.2])
    gaps = shapely.union_all([box(3.8, 4.1, 4.2, 5.0), box(1.0, 2.85, 2.2, 3.15)])
    assert solid(plan.world).intersection(gaps).area == pytest.approx(0.0, abs=1e-6)
    assert not plan.world.obstacles


def test_rooms_with_gaps_between_them_are_walls_and_the_outer_sides_are_too(tmp_path):
    style = "<style>.fp-room { fill: rgba(197, 185, 168, 0.08); stroke: #c5b9a8; stroke-width: 1 }</style>"
    rooms = "".join(
        f'<rect class="fp-room" id="fp-{name}" x="{x}" y="{y}" width="380" height="280" rx="0"/>'
        for name, x, y in (("living", 0, 0), ("kitchen", 400, 0), ("bath", 0, 300), ("hall", 400, 300))
    )
    door = '<line x1="400" y1="100" x2="400" y2="180" stroke="#FAFAF8" stroke-width="3"/>'
    plan = drawn(tmp_path, style + rooms + door)
    shape = solid(plan.world)
    assert plan.world.obstacles == ()
    # Both walls between the rooms, 20 cm thick, meet in the middle; one has a doorway of 80 cm.
    assert shape.intersection(box(3.8, 0, 4.0, 5.8)).area == pytest.approx(0.2 * 5.8 - 0.2 * 0.8, rel=0.02)
    for side in (box(-0.2, 0, 0.2, 5.8), box(7.6, 0, 8.0, 5.8), box(0, -0.2, 7.8, 0.2), box(0, 5.6, 7.8, 6.0)):
        assert shape.intersection(side).area > 0.09 * max(
            side.bounds[2] - side.bounds[0], side.bounds[3] - side.bounds[1]
        )


THICK = "M0 0H800V600H0Z M30 30V570H330V450H480V570H770V30H500V200H380V30Z"
"""Outer walls of 30 cm, a shaft of 1.2 m x 2 m, a pier of 1.5 m x 1.5 m."""


def test_all_that_is_filled_stands_in_the_world_however_thick(tmp_path):
    plan = drawn(tmp_path, f'<path fill="#555" fill-rule="evenodd" d="{THICK}"/>')
    outer = box(0, 0, 8, 6)
    rooms = shapely.Polygon([(0.3, 5.7), (0.3, 0.3), (3.3, 0.3), (3.3, 1.5), (4.8, 1.5), (4.8, 0.3), (7.7, 0.3),
                             (7.7, 5.7), (5.0, 5.7), (5.0, 4.0), (3.8, 4.0), (3.8, 5.7)])  # fmt: skip
    shape = solid(plan.world)
    assert shape.symmetric_difference(outer - rooms).area < 0.01 * (outer - rooms).area
    assert len(plan.world.obstacles) <= 6


def test_a_translucent_way_of_a_leaf_is_no_column_and_its_leaf_no_wall(tmp_path):
    sides = ((0, 0, 300, 12), (390, 0, 300, 12), (0, 0, 12, 400), (678, 0, 12, 400), (0, 388, 690, 12))
    walls = "".join(bar(*side, "#444") for side in sides)
    leaf = '<path d="M300 12 L300 102 A90 90 0 0 0 390 12 Z" fill="#444" fill-opacity="0.3"/>'
    leaf += bar(300, 12, 4, 90, "#444")
    plan = drawn(tmp_path, walls + leaf)
    assert plan.world.obstacles == ()
    assert [opening.width for wall in plan.world.walls for opening in wall.openings] == pytest.approx([0.9], abs=0.01)
    assert solid(plan.world).intersection(box(2.9, 3.0, 4.0, 3.8)).area == 0.0


def test_a_recess_painted_into_a_filled_wall_is_no_doorway(tmp_path):
    sides = ((0, 0, 600, 40), (0, 360, 600, 40), (0, 0, 40, 400), (560, 0, 40, 400))
    walls = "".join(bar(*side, "#222") for side in sides)
    recess, door = bar(200, 20, 80, 20, "#fff"), bar(300, 355, 90, 50, "#fff")
    plan = drawn(tmp_path, walls + recess + door)
    assert [opening.width for wall in plan.world.walls for opening in wall.openings] == pytest.approx([0.9])


def test_white_walls_on_black_paper_are_walls(tmp_path):
    lines = '<path d="M50 50H650V450H50Z M350 50V450" fill="none" stroke="#fff" stroke-width="15"/>'
    plan = drawn(tmp_path, f'<rect width="1000" height="800" fill="#101418"/>{lines}')
    assert {wall.thickness for wall in plan.world.walls} == {0.15}
    assert solid(World(walls=plan.world.walls)).area == pytest.approx(0.15 * (2 * 6 + 3 * 4 - 0.15), rel=0.01)


def test_halves_that_two_rooms_have_of_a_wall_are_one_wall(tmp_path):
    # Four mitred walls of 20 cm, a wall of 12 cm with a doorway; of each, every room beside it draws 10 cm or 6 cm.
    rings = [shapely.get_coordinates(box(100 - r, 100 - r, 600 + r, 400 + r))[:-1].tolist() for r in (0, 10, 20)]
    halves = [[near[k], near[k - 1], far[k - 1], far[k]] for near, far in pairwise(rings) for k in range(4)]
    halves += [[(x, y), (x + 6, y), (x + 6, y + 100), (x, y + 100)] for x in (300, 306) for y in (100, 300)]
    halves.append([(500, 200), (530, 200), (530, 230), (500, 230)])
    shapes = [f'<polygon fill="#333" points="{" ".join(f"{x},{y}" for x, y in half)}"/>' for half in halves]
    plan = drawn(tmp_path, "".join(shapes))
    assert sorted(wall.thickness for wall in plan.world.walls) == [0.12, 0.12, 0.2]
    assert [item.name for item in plan.world.obstacles] == ["column-1"]
    expected = 5.4 * 3.4 - 5 * 3 + 2 * 0.12 + 0.09
    assert solid(plan.world).area == pytest.approx(expected, abs=0.01)


def pen(points: str, width: float, *, closed: bool = False) -> str:
    """Return a black line drawn with a pen of a width."""
    return f'<poly{"gon" if closed else "line"} points="{points}" fill="none" stroke="#000" stroke-width="{width}"/>'


def test_of_several_broad_pens_the_broadest_draws_the_walls(tmp_path):
    walls = pen("0,0 900,0 900,600 0,600", 9, closed=True) + pen("400,0 400,350", 9) + pen("400,450 400,600", 9)
    counter = pen("760,0 760,60 900,60", 3) + pen("500,600 500,540 900,540", 3) + pen("0,200 60,200 60,500 0,500", 3)
    table = pen("600,200 720,200 720,280 600,280", 3, closed=True)
    plan = drawn(tmp_path, walls + counter + table)
    lines = [[(0, 0), (9, 0), (9, 6), (0, 6), (0, 0)], [(4, 0), (4, 1.5)], [(4, 2.5), (4, 6)]]
    strips = shapely.union_all([shapely.LineString(line).buffer(0.045, cap_style="square") for line in lines])
    shape = solid(World(walls=plan.world.walls))
    assert shape.symmetric_difference(strips).area < 0.02 * strips.area
    assert [(thing.box[0], thing.box[1]) for thing in plan.world.obstacles] == [pytest.approx((1.2, 0.8))]
    assert "3 lines of a finer pen than walls" in " ".join(inventory(plan.items))


@pytest.mark.parametrize(("opened", "leaf"), [(20, 20), (24, 17), (35, 35)])
def test_a_leaf_barely_open_is_a_doorway_if_it_ends_near_its_arc(tmp_path, opened, leaf):
    # People draw leaves a little longer than the radius of the arc, which ends beyond them.
    tip = [400 + 84 * math.sin(math.radians(leaf)), 300 - 84 * math.cos(math.radians(leaf))]
    end = [400 + 80 * math.sin(math.radians(opened)), 300 - 80 * math.cos(math.radians(opened))]
    door = pen(f"400,300 {tip[0]},{tip[1]}", 1)
    door += f'<path d="M400,220 A80,80 0 0 1 {end[0]},{end[1]}" fill="none" stroke="#000" stroke-width="1"/>'
    walls = pen("0,0 900,0 900,600 0,600", 1, closed=True) + pen("400,0 400,600", 1)
    plan = drawn(tmp_path, walls + door)
    ((hole,),) = [wall.openings for wall in plan.world.walls if wall.openings]
    assert hole.width == pytest.approx(0.8, abs=0.02)
    assert not hole.sill
