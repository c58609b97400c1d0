"""The same flat in the units, the languages and the manners of many drawing programs comes in as the same walls."""

import itertools
import math

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf.render.mesh import MeshBuilder

from mjsim.errors import UsageError
from mjsim.exchange import Reading
from mjsim.exchange.import_world import plan_of
from mjsim.inventory import inventory
from mjsim.world import solid
from tests.exchange.odd_plans import DOORS, dxf, faces, leaves, outlines, panes, thickness_at, walls

pytestmark = pytest.mark.slow  # Each draws and reads a plan.


def counted(plan):
    """Return the doorways and windows of a plan."""
    sills = [opening.sill for wall in plan.world.walls for opening in wall.openings]
    return sum(not sill for sill in sills), sum(bool(sill) for sill in sills)


def assert_is_the_flat(plan):
    """Check walls, doors and windows."""
    assert counted(plan) == (3, 2)
    assert len(plan.world.walls) <= 5
    closed = [wall.model_copy(update={"openings": ()}) for wall in plan.world.walls]
    shape = solid(plan.world.model_copy(update={"walls": tuple(closed), "obstacles": ()}))
    # The holes are closed here and open there.
    assert walls().difference(shape.buffer(0.01)).area < 0.01
    assert shape.difference(shapely.box(0, 0, 8, 6).buffer(0.01)).area < 1e-6


def whole(walls="WALLS", doors="DOORS", windows="WINDOWS"):
    def draw(document, space, place):
        faces(space, place, walls)
        leaves(space, place, doors)
        panes(space, place, windows)

    return draw


@pytest.mark.parametrize(("units", "metre"), [(1, 1 / 0.0254), (2, 1 / 0.3048), (4, 1000.0), (5, 100.0), (6, 1.0)])
def test_units_are_read(units, metre, tmp_path):
    plan, _ = plan_of(dxf(tmp_path / "flat.dxf", whole(), units=units, metre=metre), Reading())
    assert_is_the_flat(plan)


@pytest.mark.parametrize(
    "names",
    [
        ("WÄNDE", "TÜREN", "FENSTER"),
        ("Murs porteurs", "Portes", "Fenêtres"),
        ("MURI", "PORTE", "FINESTRE"),
        ("Muros", "Puertas", "Ventanas"),
        ("PAREDES", "PORTAS", "JANELAS"),
        ("MUREN", "DEUREN", "RAMEN"),
        ("ŚCIANY", "DRZWI", "OKNA"),
        # Cyrillic looks like Latin; that is the point.
        ("СТЕНЫ", "ДВЕРИ", "ОКНА"),  # noqa: RUF001
        ("墙体", "门", "窗"),
        ("0", "0", "0"),
        ("A-WALL-FULL", "A-DOOR+GLAZ", "A-DOOR+GLAZ"),
        ("Innenwand24", "OPENINGS", "OPENINGS"),
    ],
)
def test_layers_of_many_languages_are_told_apart(names, tmp_path):
    plan, _ = plan_of(dxf(tmp_path / "flat.dxf", whole(*names)), Reading())
    assert_is_the_flat(plan)


@pytest.mark.parametrize("layer", ["WALLS", "0"])
@pytest.mark.parametrize("outlined", [True, False])
def test_walls_of_solid_hatches_are_read_once(layer, outlined, tmp_path):
    def draw(document, space, place):
        if outlined:
            faces(space, place, layer)
        hatch = space.add_hatch(dxfattribs={"layer": layer})
        for ring in outlines():
            hatch.paths.add_polyline_path([place(point) for point in ring], is_closed=True)
        leaves(space, place, "DOORS" if layer == "WALLS" else "0")
        panes(space, place, "WINDOWS" if layer == "WALLS" else "0")

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


@pytest.mark.parametrize("layer", ["WALLS", "0"])
def test_walls_of_pattern_hatches_alone_are_walls(layer, tmp_path):
    def draw(document, space, place):
        hatch = space.add_hatch(dxfattribs={"layer": layer})
        hatch.set_pattern_fill("ANSI31", scale=20)
        for ring in outlines():
            hatch.paths.add_polyline_path([place(point) for point in ring], is_closed=True)
        leaves(space, place, "DOORS" if layer == "WALLS" else "0")
        panes(space, place, "WINDOWS" if layer == "WALLS" else "0")

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


def test_furniture_in_the_block_of_a_whole_floor_are_things_of_their_own(tmp_path):
    def draw(document, space, place):
        floor, chair = document.blocks.new("FLOOR"), document.blocks.new("CHAIR")
        whole("0", "0", "0")(document, floor, place)
        chair.add_lwpolyline([place(point) for point in ((0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5))], close=True)
        for at in ((1, 1), (2, 4), (6, 4)):
            floor.add_blockref("CHAIR", place(at), dxfattribs={"layer": "0", "xscale": -1})
        document.blocks.new("HOUSE").add_blockref("FLOOR", (0, 0))
        space.add_blockref("HOUSE", (70, 30), dxfattribs={"rotation": 30})

    plan, _ = plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())
    assert counted(plan) == (3, 2)
    assert [item.box[:2] for item in plan.world.obstacles] == [(0.5, 0.5)] * 3


def test_doors_in_blocks_without_a_name_scaled_and_mirrored_are_doors(tmp_path):
    def draw(document, space, place):
        faces(space, place)
        panes(space, place)
        block = document.blocks.new("B17")
        block.add_line((0, 0), (0, 1))
        block.add_arc((0, 0), 1, 0, 90)
        document.blocks.new("OUTER").add_blockref("B17", (0, 0))
        for index, (at, to, wide, swing) in enumerate(DOORS):
            left = float(np.dot([-to[1], to[0]], swing)) > 0
            size = {"xscale": wide * 1000, "yscale": wide * 1000 * (1 if left else -1)}
            hinge = np.array(at) + np.array(swing) * thickness_at(at) / 2
            keys = {**size, "rotation": math.degrees(math.atan2(to[1], to[0])), "layer": ("WALLS", "0")[index % 2]}
            space.add_blockref("OUTER" if index else "B17", place(hinge), dxfattribs=keys)

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


def test_lines_twice_and_thresholds_make_no_other_walls(tmp_path):
    def draw(document, space, place):
        whole("0", "0", "0")(document, space, place)
        for line in list(space.query("LINE")):
            space.add_line(line.dxf.end, line.dxf.start)
        for at, to, wide, _ in DOORS:
            for off in (-0.5, 0.5):
                start = np.array(at) + np.array([-to[1], to[0]]) * off * thickness_at(at)
                space.add_line(place(start), place(start + np.array(to) * wide))

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


def test_polylines_as_broad_as_walls_are_walls(tmp_path):
    def draw(document, space, place):
        for layer, width in (("WALLS", 200.0), ("WALLS", 120.0)):
            points = [(0, 0), (8, 0), (8, 6), (0, 6)] if width > 150.0 else [(4, 0), (4, 6)]
            rows = [(*place(point), width, width) for point in points]
            space.add_lwpolyline(rows, format="xyse", close=width > 150.0, dxfattribs={"layer": layer})

    plan, _ = plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())
    assert sorted(wall.thickness for wall in plan.world.walls) == [0.12, 0.2]


@pytest.mark.parametrize("layer", ["WALLS", "0"])
def test_two_arcs_about_one_middle_are_one_curved_wall(layer, tmp_path):
    def draw(document, space, place):
        for inset in (0.0, 0.25):
            low, high = inset, 6 - inset
            corners = [(low, 4), (low, low), (high, low), (high, 4)]
            for start, end in itertools.pairwise(corners):
                space.add_line(start, end, dxfattribs={"layer": layer})
            space.add_arc((3, 4), 3 - inset, 0, 180, dxfattribs={"layer": layer})

    plan, _ = plan_of(dxf(tmp_path / "apse.dxf", draw, units=6, metre=1.0), Reading())
    straight = 6 * 4 - 5.5 * 3.75
    assert solid(plan.world).area == pytest.approx(straight + math.pi / 2 * (9 - 2.75**2), rel=0.01)
    assert len(plan.world.walls) == 2
    assert shapely.get_parts(solid(plan.world).buffer(0.005)).size == 1


@pytest.mark.parametrize("layer", ["WALLS", "0"])
def test_two_ellipses_side_by_side_are_one_wall(layer, tmp_path):
    def draw(document, space, place):
        for inset in (0.0, 0.2):
            space.add_ellipse((6, 4), (6 - inset, 0), ratio=(4 - inset) / (6 - inset), dxfattribs={"layer": layer})

    plan, _ = plan_of(dxf(tmp_path / "oval.dxf", draw, units=6, metre=1.0), Reading())
    (wall,) = plan.world.walls
    assert wall.closed
    assert solid(plan.world).area == pytest.approx(math.pi * (6 * 4 - 5.8 * 3.8), rel=0.03)


def test_rooms_side_by_side_share_a_wall(tmp_path):
    rooms = [(0, 0, 4, 8), (4, 0, 3, 4), (7, 0, 3, 4), (4, 4, 6, 4)]
    boxes = "".join(f'<rect x="{x}" y="{y}" width="{w}" height="{h}"/>' for x, y, w, h in rooms)
    path = tmp_path / "rooms.svg"
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg"><g fill="#eef" stroke="#000" stroke-width="0.1">{boxes}</g></svg>'
    )
    plan, _ = plan_of(path, Reading(scale=1.0))
    segments = [segment for wall in plan.world.walls for segment in wall.segments()]
    assert sum(math.dist(*segment) for segment in segments) == pytest.approx(2 * 10 + 2 * 8 + 8 + 6 + 4, abs=0.1)


def test_what_is_left_out_is_counted(tmp_path):
    def draw(document, space, place):
        whole()(document, space, place)
        block = document.blocks.new("SITE")
        block.block.dxf.flags, block.block.dxf.xref_path = 4, "site.dwg"
        space.add_blockref("SITE", (0, 0))
        hatch = space.add_hatch(dxfattribs={"layer": "HATCH"})
        hatch.set_pattern_fill("ANSI31")
        hatch.paths.add_polyline_path([(0, 0), (1000, 0), (1000, 1000)], is_closed=True)
        space.add_text("Kitchen")

    plan, _ = plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())
    assert_is_the_flat(plan)
    assert "left out: 1 HATCH, 1 TEXT, 1 external references" in inventory(plan.items)


def test_a_plan_in_a_block_shows_on_layers_that_no_table_has(tmp_path):
    def draw(document, space, place):
        whole()(document, document.blocks.new("PLAN"), place)
        document.blocks.new("OUTER").add_blockref("PLAN", (0, 0), dxfattribs={"layer": "PLACED"})
        space.add_blockref("OUTER", (0, 0))

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


def test_triangles_of_a_body_in_space_are_its_walls_from_above(tmp_path):
    def draw(document, space, place):
        for triangle in shapely.constrained_delaunay_triangles(walls()).geoms:
            corners = [place(corner) for corner in shapely.get_coordinates(triangle)[[0, 1, 2, 2]]]
            space.add_3dface([(x, y, 2700.0) for x, y in corners], dxfattribs={"layer": "WALLS"})
        leaves(space, place)
        panes(space, place)

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


def test_upright_faces_of_a_body_in_space_are_the_faces_of_walls(tmp_path):
    def draw(document, space, place):
        for ring in outlines():
            for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                upright = [(*place(point), z) for point, z in ((start, 0), (end, 0), (end, 2700), (start, 2700))]
                space.add_3dface(upright, dxfattribs={"layer": "WALLS"})
        leaves(space, place)
        panes(space, place)

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


@pytest.mark.parametrize("kind", ["mesh", "polyface"])
def test_meshes_of_bodies_are_their_walls_from_above(kind, tmp_path):
    def draw(document, space, place):
        body = MeshBuilder()
        for triangle in shapely.constrained_delaunay_triangles(walls()).geoms:
            corners = [place(corner) for corner in shapely.get_coordinates(triangle)[:3]]
            body.add_face([(x, y, 2700.0) for x, y in corners])
        (body.render_mesh if kind == "mesh" else body.render_polyface)(space, dxfattribs={"layer": "WALLS"})
        leaves(space, place)
        panes(space, place)
        space.add_polymesh((3, 3), dxfattribs={"layer": "TERRAIN"})

    assert_is_the_flat(plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())[0])


def test_a_door_in_the_gap_of_a_wall_of_one_line_is_an_opening(tmp_path):
    def draw(document, space, place):
        for ends in ([(3, 0), (0, 0), (0, 4), (6, 4), (6, 0), (4, 0)], [(3, 4), (3, 2)], [(3, 1), (3, 0)]):
            space.add_lwpolyline([place(point) for point in ends], dxfattribs={"layer": "WALLS"})
        for hinge, begin in (((3, 0), 0), ((3, 2), 180)):
            space.add_arc(place(hinge), 1000.0, begin, begin + 90, dxfattribs={"layer": "DOORS"})

    plan, _ = plan_of(dxf(tmp_path / "flat.dxf", draw), Reading())
    assert counted(plan) == (2, 0)
    assert sum(math.dist(*segment) for wall in plan.world.walls for segment in wall.segments()) == pytest.approx(24)


def test_an_absurd_unit_is_refused_with_the_likely_scale(tmp_path):
    path = dxf(tmp_path / "flat.dxf", whole(), units=6, metre=1000.0)
    with pytest.raises(UsageError, match=r"give another --scale, 0.001 for millimetres$"):
        plan_of(path, Reading())
    assert_is_the_flat(plan_of(path, Reading(scale=0.001))[0])
    assert ezdxf.readfile(path).units == 6
