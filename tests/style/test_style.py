"""A style furnishes the look of a world: for cameras alone, in true proportions, and never before a beacon."""

from collections.abc import Iterator
from itertools import pairwise

import mujoco
import numpy as np
import pytest
import shapely

from mjsim.compile import compile_world
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.style import Quad, ceiling_lamps, leaf_faces, read_atlas, thing_faces, wall_faces
from mjsim.style.recipes import STYLES
from mjsim.world import World, format_world, hung, leaves, load_world, parse_world, wall_polygons

STYLED = ("office", "home", "museum", "warehouse")
ROOMS = """
mjsim: 1
style: office
walls:
  - points: [[0, 0], [7, 0], [7, 5], [0, 5]]
    closed: true
    openings: [{at: 1, width: 1.4, sill: 0.9, head: 2.1}, {segment: 2, at: 1, width: 1, sill: 0.4, head: 2.2}]
  - {points: [[4, 0], [4, 5]], openings: [{at: 1, width: 1}, {name: d, at: 3, width: 0.9, door: {angle_deg: 30}}]}
ceiling: {}
obstacles:
  - {model: furniture/table.xml, at: [1.5, 4.5]}
  - {model: furniture/shelf.urdf, at: [3.7, 0.6], heading_deg: 90}
  - {name: crate, box: [0.4, 0.3, 0.5], at: [2.9, 2.2], heading_deg: 20, color: "#b08d5c"}
beacons: [{name: owl, image: posters/owl.jpg, at: [2, 0.06], heading_deg: 90, width: 0.6}]
robots:
  - {name: scout, at: [0.8, 2.5], sensors: [{lidar: scan, at: [0.1, 0, 0.3], beams: 90, fov_deg: 270, intensity: true}]}
"""


def world(style: str = "office", text: str = ROOMS) -> World:
    return parse_world(text.replace("style: office", f"style: {style}"))


@pytest.mark.slow
@pytest.mark.parametrize("walls", ["[]", "[{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]"])
def test_a_world_without_furniture_can_have_a_style(walls):
    assert compile_world(parse_world(f"mjsim: 1\nstyle: home\nwalls: {walls}\n")).compile().ngeom > 0


@pytest.fixture(scope="module")
def atlas():
    return read_atlas()


@pytest.fixture(scope="module", params=STYLED)
def styled(request: pytest.FixtureRequest, atlas) -> tuple[World, list[Quad]]:
    """A world in each style, with all that is on its walls."""
    here = world(request.param)
    return here, [face for faces in wall_faces(here, request.param, atlas).values() for face in faces]


def test_nothing_on_a_wall_stands_out_by_more_than_six_centimetres(styled: tuple[World, list[Quad]]):
    here, faces = styled
    closed = [wall.model_copy(update={"openings": ()}) for wall in here.walls]
    walls = shapely.union_all(shapely.polygons(wall_polygons(here.model_copy(update={"walls": tuple(closed)}))))
    points = np.concatenate([face.corners for face in faces])
    assert shapely.distance(walls, shapely.points(points[:, :2])).max() <= 0.06 + 1e-6
    assert points[:, 2].min() >= 0.0
    assert points[:, 2].max() <= 2.5


def test_doorways_stay_free(styled: tuple[World, list[Quad]]):
    _, faces = styled
    for begin in (1.0, 3.0):
        passage = shapely.box(3.0, begin + 0.02, 5.0, begin + 0.88)
        low = [face for face in faces if face.corners[:, 2].min() < 2.08]
        assert not any(passage.contains(shapely.Point(face.corners.mean(axis=0))) for face in low)


@pytest.mark.parametrize("style", STYLED)
def test_proportions_are_those_of_buildings(styled: tuple[World, list[Quad]], style: str):
    _, faces = styled
    heights = {"skirting": (0.0, 0.08), "switch": (1.05, 1.13), "radiator": (0.14, 0.69)}
    for face in faces:
        kind = face.part.partition("/")[0].partition("_")[0]
        low, high = heights.get(kind, (0.0, 3.0))
        assert low - 1e-9 <= face.corners[:, 2].min()
        assert face.corners[:, 2].max() <= high + 1e-9
    sockets = [face.corners[:, 2].mean() for face in faces if face.part == "socket/1"]
    assert not sockets or style == "warehouse" or set(np.round(sockets, 3)) == {0.3}


def test_faces_look_into_the_room(styled: tuple[World, list[Quad]]):
    _, faces = styled
    for face in faces:
        if face.part == "painting/1" or face.part.startswith("noted"):
            a, b, _, d = face.corners
            normal = np.cross(b - a, d - a)
            ahead = face.corners.mean(axis=0) + normal / np.linalg.norm(normal) * 0.3
            assert 0.05 < ahead[0] < 6.95
            assert 0.05 < ahead[1] < 4.95
            assert abs(ahead[0] - 4.0) > 0.05


def test_every_part_of_a_style_is_in_the_atlas(atlas):
    kinds = {name.partition("/")[0] for name in atlas.parts}
    for style in STYLES.values():
        assert {thing.kind for thing in style.hung} | {style.skirting, style.leaf, style.view, *style.shelf} <= kinds
        assert {thing.side for thing in style.hung} | {style.frame} <= kinds


def test_parts_of_the_atlas_lie_within_it_and_apart(atlas):
    height, width = atlas.picture.shape[:2]
    boxes = np.array([shapely.box(x, y, x + w, y + h) for x, y, w, h in atlas.parts.values()])
    assert shapely.within(boxes, shapely.box(0, 0, width, height)).all()
    one, other = shapely.STRtree(boxes).query(boxes, predicate="dwithin", distance=2.0)
    assert (one == other).all()


def test_a_face_shows_its_part_upright_and_unmirrored(atlas):
    (left, lower), _, (right, upper), _ = _corners_of(atlas, Quad(np.zeros((4, 3)), "exit/1"))
    x, y, width, height = atlas.parts["exit/1"]
    np.testing.assert_allclose([left, upper], [x, y], atol=1.0)
    np.testing.assert_allclose([right, lower], [x + width, y + height], atol=1.0)


def _corners_of(atlas, face: Quad) -> np.ndarray:
    """Return where the lower left, lower right, upper right and upper left corners are in the atlas [px]."""
    return atlas.texcoords([face])[0] * [atlas.picture.shape[1], atlas.picture.shape[0]]


@pytest.mark.slow
def test_a_robot_drives_and_senses_alike_in_every_style():
    def drive(style: str) -> list[np.ndarray]:
        with Simulation(world(style), seed=3) as sim:
            found = []
            for _ in range(8):
                seen = sim.sense("scout")
                if seen.scans:
                    found += [seen.scans["scan"].ranges, seen.scans["scan"].intensities]
                sim.apply("scout", Command(forward=0.5, turn=0.4))
                sim.step()
            return [*found, sim.data.qpos.copy()]

    for one, other in zip(drive("plain"), drive("office"), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_the_same_world_gives_the_same_bytes_twice():
    one, two = (compile_world(world()) for _ in range(2))
    for spec in (one, two):
        spec.compile()
    assert one.to_xml() == two.to_xml()
    assert one.assets == two.assets
    assert [bytes(texture.data) for texture in one.textures] == [bytes(texture.data) for texture in two.textures]
    assert not any("style" in geom.name for geom in compile_world(world("plain")).geoms)


def test_a_room_keeps_its_look_when_another_one_is_added(atlas):
    further = ROOMS.replace(
        "ceiling: {}", "  - {points: [[20, 0], [24, 0], [24, 4], [20, 4]], closed: true}\nceiling: {}"
    )
    before, after = wall_faces(world(), "office", atlas), wall_faces(world(text=further), "office", atlas)
    assert len(after) == len(before) + 1
    for number, faces in before.items():
        assert [face.part for face in faces] == [face.part for face in after[number]]


def test_lamps_hang_in_the_ceiling_of_rooms():
    lamps = [face for faces in ceiling_lamps(world(), "office", 2.5).values() for face in faces]
    shown = [face for face in lamps if face.part == "lamp/1"]
    assert len(shown) >= 2
    for face in shown:
        a, b, _, d = face.corners
        assert np.cross(b - a, d - a)[2] < 0.0
        assert face.corners[:, 2] == pytest.approx(2.49)


def test_books_stand_between_the_boards_of_a_shelf(atlas):
    _, shelf, _ = thing_faces(world(), "office", atlas)
    assert {face.part.partition("/")[0] for face in shelf} & set(STYLES["office"].shelf)
    for low, high in pairwise((0.07, 0.49, 0.91, 1.33, 1.75)):
        row = [face.corners for face in shelf if low - 1e-6 <= face.corners[:, 2].min() < high]
        assert row
        assert max(corners[:, 2].max() for corners in row) <= high - 0.02 + 1e-6
        points = np.concatenate(row)
        assert np.abs(points[:, 0]).max() < 0.45
        assert np.abs(points[:, 1]).max() < 0.15


def test_a_style_survives_the_file():
    assert parse_world(format_world(world("museum"))).style == "museum"


def views(here: World, beacons: int) -> Iterator[tuple[mujoco.MjModel, np.ndarray, np.ndarray, str]]:
    """Yield, for some beacons, rays from points of their pictures to all sides up to 70 degrees."""
    model = compile_world(here).compile()
    turns = np.radians(np.arange(-70, 71, 20))
    for item in [each for each in hung(here) if each.fixed][:beacons]:
        heading = item.place.heading
        for across in (-0.45, 0.45):
            for up in (-0.3, 0.3):
                right = np.array([-np.sin(heading), np.cos(heading), 0.0]) * across * item.beacon.width
                start = np.array([item.place.x, item.place.y, item.center + up * item.beacon.width]) + right
                for turn in turns:
                    direction = np.array([np.cos(heading + turn), np.sin(heading + turn), 0.0])
                    yield model, start + 0.02 * direction, direction, item.beacon.name


def assert_beacons_are_seen(here: World, *, beacons: int = 6) -> None:
    """Check that nothing of the style is between a beacon and where a robot can be.

    What a ray meets is on a wall or in it, behind something solid, or less than 0.3 m before it.
    """
    closed = tuple(wall.model_copy(update={"openings": ()}) for wall in here.walls)
    walls = shapely.union_all(shapely.polygons(wall_polygons(here.model_copy(update={"walls": closed})))).buffer(0.07)
    data, geom = None, np.zeros(1, np.int32)
    solid, visible = np.array([1, 0, 0, 1, 0, 0], np.uint8), np.array([0, 1, 0, 0, 0, 0], np.uint8)
    for model, start, direction, name in views(here, beacons):
        if data is None:
            data = mujoco.MjData(model)
            mujoco.mj_forward(model, data)
        near = mujoco.mj_ray(model, data, start, direction, visible, True, -1, geom)
        if near < 0.0 or not model.material(model.geom_matid[geom[0]]).name.startswith("style/"):
            continue
        wall = mujoco.mj_ray(model, data, start, direction, solid, True, -1, geom)
        at = shapely.Point((start + near * direction)[:2])
        assert walls.contains(at) or 0.0 < wall < near + 0.3, (name, at)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_before_a_beacon_in_rooms_drawn_by_lot(seed: int):
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0.6, 3.4), rng.uniform(0.6, 4.4)
    beacons = (
        f"beacons:\n  - {{name: a, image: posters/owl.jpg, at: [{x:.3f}, 0.06], heading_deg: 90, width: 0.5}}\n"
        f"  - {{name: b, marker: {{id: 3}}, at: [0.06, {y:.3f}], width: 0.3, center: {0.5 + x / 3:.3f}}}\n"
    )
    lines = [line for line in ROOMS.splitlines() if not line.startswith("beacons")]
    text = "\n".join(lines).replace("robots:", beacons + "robots:")
    table = f"at: [{rng.uniform(1, 3):.2f}, {rng.uniform(1, 4):.2f}], heading_deg: {rng.uniform(0, 360):.0f}"
    text = text.replace("table.xml, at: [1.5, 4.5]", f"table.xml, {table}")
    assert_beacons_are_seen(world(STYLED[seed], text))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gallery", "corridor"])
def test_nothing_is_before_a_beacon_of_a_shipped_world(name: str):
    here = load_world(name, settings={"style": "home" if name == "gallery" else "office"})
    assert_beacons_are_seen(here, beacons=3)


def test_what_a_style_adds_is_bounded_in_worlds_of_any_size(atlas):
    vast = world(
        "warehouse",
        """
mjsim: 1
style: office
walls: [{points: [[0, 0], [9000, 0], [9000, 9000], [0, 9000]], closed: true}]
obstacles: [{box: [9000, 3, 900], at: [4500, 100], color: "#b08d5c"}]
""",
    )
    assert len(ceiling_lamps(vast, "warehouse", 3.0)[0]) < 10_000
    assert sum(map(len, thing_faces(vast, "warehouse", atlas))) < 10_000


def test_a_table_below_a_beacon_has_no_screen(atlas):
    text = "mjsim: 1\nstyle: office\nobstacles: [{model: furniture/table.xml, at: [1, 1]}]\n"
    beacon = "beacons: [{name: b, marker: {dictionary: 4x4_50, id: 7}, at: [1, 1], width: 0.3, center: 1.5}]\n"
    shown, bare = (
        [face.part for face in next(thing_faces(world(text=each), "office", atlas))] for each in (text, text + beacon)
    )
    assert any(part.startswith("screen/") for part in shown)
    assert not any(part.startswith("screen/") for part in bare)


def test_nothing_of_a_low_wall_is_above_it(atlas):
    text = "mjsim: 1\nstyle: warehouse\nwalls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true, height: 0.15,"
    low = parse_world(f"{text} openings: [{{at: 1, width: 1, sill: 0.5, head: 1.0}}]}}]\n")
    faces = [face for each in wall_faces(low, "warehouse", atlas).values() for face in each]
    assert faces
    assert max(face.corners[:, 2].max() for face in faces) <= 0.15 + 1e-9


def test_the_faces_of_a_door_leaf_lie_within_the_leaf():
    (leaf,) = leaves(world())
    faces = leaf_faces(leaf, 0.04, "office")
    for face in faces:
        x, y, z = face.corners.T
        assert -leaf.width < x.min() < x.max() < 0.0 or 0.0 < x.min() < x.max() < leaf.width
        assert leaf.low < z.min() < z.max() < leaf.high
        assert np.abs(y) == pytest.approx(0.02, abs=0.002)
        assert len(set(np.sign(y))) == 1
    assert np.sign(faces[0].corners[0, 1]) != np.sign(faces[1].corners[0, 1])


@pytest.mark.slow
def test_clothes_are_woven_in_a_world_with_a_style_in_the_colour_that_they_have_without():
    person = "\npeople: [{name: ann, at: [2, 2], sex: female, colors: {top: '#203040'}}]\n"
    plain, styled = (compile_world(world(style, ROOMS + person)).compile() for style in ("plain", "office"))
    for name, woven in {"ann/thorax": True, "ann/head": False}.items():
        before, after = plain.geom(name), styled.geom(name)
        texture = styled.mat_texid[after.matid[0], mujoco.mjtTextureRole.mjTEXROLE_RGB]
        assert (texture >= 0) == woven, name
        assert (styled.mesh_texcoordadr[after.dataid[0]] >= 0) == woven, name
        mean = texels(styled, texture).mean(axis=(0, 1)) / 255 if woven else 1.0
        np.testing.assert_allclose(after.rgba[:3] * mean, before.rgba[:3], atol=0.002)


def texels(model: mujoco.MjModel, texture: int) -> np.ndarray:
    """Return the picture of a texture, shape (height, width, 3)."""
    start, height, width = (int(each[texture]) for each in (model.tex_adr, model.tex_height, model.tex_width))
    return model.tex_data[start : start + height * width * 3].reshape(height, width, 3)
