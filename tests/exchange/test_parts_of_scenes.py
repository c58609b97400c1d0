"""Parts of scenes of other simulators, each compared with what it was made from."""

import itertools
import math

import mujoco
import numpy as np
import pytest
import shapely
from scipy.spatial import ConvexHull

from mjsim.exchange.scenes.build import build_world
from mjsim.exchange.scenes.model_text import model_files
from mjsim.exchange.scenes.scene_meshes import boxed, parts_of
from mjsim.exchange.scenes.scene_solids import Light, Scene, SceneSolid, SceneThing
from mjsim.exchange.scenes.scene_walls import walls_of
from mjsim.exchange.scenes.shells import traced
from mjsim.mechanics import rotation_of
from mjsim.world import BoxObstacle, CylinderObstacle, SphereObstacle


def posed(x, y, z, *, yaw=0.0, tilt=0.0):
    pose = np.eye(4)
    pose[:3, :3] = rotation_of(np.array([0.0, 0.0, yaw])) @ rotation_of(np.array([tilt, 0.0, 0.0]))
    pose[:3, 3] = x, y, z
    return pose


def box(size, x, y, z, *, kind="box", **turned):
    return SceneSolid(kind, tuple(size), posed(x, y, z, **turned), "#102030")


def wall_boxes(stretches, *, start, yaw, thick, across=False):
    """Return boxes of a wall: stretches (from, to, low, high) along it [m]."""
    found = []
    for begin, end, low, high in stretches:
        along = np.array([math.cos(yaw), math.sin(yaw)]) * (begin + end) / 2 + start
        size = (thick, end - begin, high - low) if across else (end - begin, thick, high - low)
        turn = yaw - math.pi / 2 if across else yaw
        found.append(box(size, *along, (low + high) / 2, yaw=turn))
    return found


@pytest.mark.parametrize("across", [False, True])
@pytest.mark.parametrize("yaw_deg", [0, 30, 90, 135, 179.95])
def test_boxes_on_a_line_are_the_wall_that_was_cut_into_them(yaw_deg, across):
    yaw, start = math.radians(yaw_deg), np.array([1.0, -2.003])
    pieces = [(0, 1, 0, 2.5), (1, 1.9, 2.1, 2.5), (1.9, 3, 0, 2.5)]
    pieces += [(3, 4.2, 0, 0.8), (3, 4.2, 2, 2.5), (4.2, 5, 0.05, 2.5)]
    boxes = wall_boxes(pieces, start=start, yaw=yaw, thick=0.15, across=across)
    post = box((0.2, 0.2, 1.0), 9, 9, 0.5)
    (wall,), used = walls_of([post, *boxes])
    assert sorted(used) == [1, 2, 3, 4, 5, 6]
    end = start + 5 * np.array([math.cos(yaw), math.sin(yaw)])
    found = wall.points if math.dist(wall.points[0], start) < 0.1 else wall.points[::-1]
    np.testing.assert_allclose(found, [start, end], atol=0.01)
    assert (wall.thickness, wall.height, wall.color) == (pytest.approx(0.15), 2.5, "#102030")
    holes = [(each.at, each.width, each.sill, each.head) for each in wall.openings]
    doors = [(1.0, 0.9, 0.0, 2.1), (3.0, 1.2, 0.8, 2.0)]
    if wall.points is not found:
        doors = [(5.0 - at - width, width, sill, head) for at, width, sill, head in reversed(doors)]
    np.testing.assert_allclose(holes, doors, atol=0.003)


@pytest.mark.parametrize(
    ("stretches", "thick", "count"),
    [
        ([(0, 0.39, 0, 2)], 0.1, 0),
        ([(0, 0.41, 0, 2)], 0.1, 1),
        ([(0, 2, 0, 2)], 0.36, 0),
        ([(0, 2, 0, 2)], 0.34, 1),
        ([(0, 0.5, 0, 2)], 0.34, 0),
        ([(0, 0.52, 0, 2)], 0.34, 1),
        ([(0, 1.1, 0, 1.1)], 0.2, 0),
        ([(0, 1.3, 0, 1.1)], 0.2, 1),
        ([(0, 3, 0, 0.29)], 0.1, 0),
        ([(0, 3, 0, 0.31)], 0.1, 1),
        ([(0, 3, 0.2, 2)], 0.1, 0),
        ([(0, 1, 0, 2), (1, 1.29, 1.5, 2), (1.29, 3, 0, 2)], 0.1, 0),
        ([(0, 1, 0, 2), (1, 1.31, 1.5, 2), (1.31, 3, 0, 2)], 0.1, 1),
        ([(0, 1, 0, 2), (1, 2, 0, 1.5), (2, 3, 0, 2)], 0.1, 3),
        ([(0, 1, 0, 2), (1.5, 2.5, 0, 2)], 0.1, 2),
        ([(0, 1, 0, 1), (0, 1, 1.005, 2)], 0.1, 1),
        ([(0, 1, 0, 0.5), (0, 1, 0.8, 1.2), (0, 1, 1.5, 2)], 0.1, 0),
        ([(0, 1, 0, 0.6), (0, 1, 0.1, 0.3), (0, 1, 0.3, 1.3), (0, 1, 1.1, 1.2)], 0.1, 1),
    ],
)
def test_walls_have_least_sizes(stretches, thick, count):
    walls, used = walls_of(wall_boxes(stretches, start=np.zeros(2), yaw=0.4, thick=thick))
    assert len(walls) == count
    assert all(wall.height == max(high for *_, high in stretches) for wall in walls[:1])
    assert bool(used) == bool(count)


def test_boxes_beside_each_other_or_of_other_thickness_are_no_one_wall():
    one, other = wall_boxes([(0, 1, 0, 2), (1, 2, 0, 2)], start=np.zeros(2), yaw=0.0, thick=0.1)
    assert len(walls_of([one, other])[0]) == 1
    for moved in (posed(1.5, 0.03, 1), posed(1.5, 0, 1, yaw=0.02)):
        assert len(walls_of([one, SceneSolid("box", other.size, moved)])[0]) == 2
    assert len(walls_of([one, SceneSolid("box", (1, 0.13, 2), other.pose)])[0]) == 2
    tilted, round_one = (
        SceneSolid("box", (1, 0.1, 2), posed(0, 0, 1, tilt=0.01)),
        box((0.2, 0.1), 0, 0, 0, kind="cylinder"),
    )
    assert walls_of([tilted, round_one]) == ([], [])


CUBE = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T


def mesh_of(points, pose, *, without=0):
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - points.mean(axis=0)) < 0
    faces[inward] = faces[inward][:, ::-1]
    return SceneSolid("mesh", (), pose, "#102030", points, faces[without:])


@pytest.mark.parametrize("yaw", [0.0, 0.5, 2.0])
def test_a_mesh_that_is_a_box_is_the_box(yaw):
    points = CUBE * (2.0, 1.0, 0.5) + (0.3, 0.1, 0.2)
    found = boxed(mesh_of(points, posed(1, 2, 3, yaw=yaw)))
    assert (found.kind, found.color) == ("box", "#102030")
    np.testing.assert_allclose(sorted(found.size), [0.5, 1.0, 2.0])
    assert found.size[2] == pytest.approx(0.5)
    np.testing.assert_allclose(found.pose[:3, 3], (posed(1, 2, 3, yaw=yaw) @ [0.3, 0.1, 0.2, 1])[:3])
    corners = found.corners()
    expected = points @ posed(0, 0, 0, yaw=yaw)[:3, :3].T + (1, 2, 3)
    assert np.linalg.norm(corners[:, None] - expected, axis=2).min(axis=1).max() < 1e-9
    np.testing.assert_allclose(np.linalg.det(found.pose[:3, :3]), 1.0)


def test_meshes_that_are_no_boxes_stay_and_flat_ones_are_thin_boxes():
    assert boxed(mesh_of(CUBE, posed(0, 0, 0, tilt=0.3))).kind == "mesh"
    assert boxed(mesh_of(CUBE, np.eye(4), without=2)).kind == "mesh"
    wedge = CUBE[CUBE[:, 2] + CUBE[:, 0] < 0.9]
    assert boxed(mesh_of(wedge, np.eye(4))).kind == "mesh"
    flat = SceneSolid("mesh", (), posed(0, 0, 1), None, CUBE[:4] * (2, 3, 0), np.array([[0, 1, 2], [1, 2, 3]]))
    assert boxed(flat).size[2] == pytest.approx(1e-3)
    # Long strips, bent upwards by a part of their length: only what is flatter than a thousandth is flat.
    for rise, kind in ((5e-3, "box"), (5e-2, "mesh")):
        along = np.linspace(-5, 5, 11)
        bent = [np.stack([along, np.full(11, y), rise * (along / 5) ** 2], axis=1) for y in (-0.05, 0.05)]
        assert boxed(mesh_of(np.concatenate(bent), posed(0, 0, 1))).kind == kind


def test_a_mesh_is_divided_into_its_connected_parts():
    one, other = mesh_of(CUBE, np.eye(4)), mesh_of(CUBE + np.array([3, 0, 0]), np.eye(4))
    triangles = np.concatenate([part.vertices[part.faces] for part in (one, other)])
    found = parts_of(triangles + 1e-7 * np.random.default_rng(0).normal(size=triangles.shape))
    assert [len(vertices) for vertices, _ in found] == [8, 8]
    lows = sorted(float(vertices[:, 0].min()) for vertices, _ in found)
    assert lows == pytest.approx([-0.5, 2.5], abs=1e-5)
    for vertices, faces in found:
        near = np.linalg.norm(vertices[faces][:, None] - triangles, axis=(2, 3)).min(axis=1)
        assert near.max() < 1e-5
    many = np.concatenate([one.vertices[one.faces] + (2 * k, 0, 0) for k in range(201)])
    assert len(parts_of(many[: 200 * 12])) == 200
    assert len(parts_of(many)) == 1


def built(*things, lights=()):
    scene = Scene(lights=list(lights))
    for name, solids, mass in things:
        scene.add(SceneThing(name, solids, solids[0].pose, mass))
    world, files = build_world(scene, name="w", folder="f")
    return world, files, [(item.fate.name, item.kind, item.name) for item in scene.items]


def test_simple_shapes_stand_where_they_did_and_end_at_the_floor():
    things = [
        ("a", [box((0.5, 0.4, 0.6), 1, 2, 0.5, yaw=2.0)], None),
        ("b", [box((0.3, 0.8), -1, 0, 0.3, kind="cylinder")], None),
        ("c d/e", [box((0.25,), 3, 3, 1.0, kind="sphere", tilt=1.0)], 2.00001),
        ("a", [box((0.5, 0.5, 0.5), 5, 5, 0.25)], 1e9),
    ]
    world, files, _ = built(*things)
    one, two, ball, last = world.obstacles
    assert files == {}
    assert isinstance(one, BoxObstacle)
    assert (one.box, one.at, one.elevation, one.color) == ((0.5, 0.4, 0.6), (1.0, 2.0), pytest.approx(0.2), "#102030")
    assert one.heading_deg == pytest.approx(math.degrees(2.0) - 180.0, abs=0.01)
    assert isinstance(two, CylinderObstacle)
    assert two.cylinder == pytest.approx((0.3, 0.7))
    assert isinstance(ball, SphereObstacle)
    assert (ball.sphere, ball.elevation, ball.mass, ball.movable) == (0.25, 0.75, 2.0, True)
    assert [each.name for each in world.obstacles] == ["a", "b", "c-d-e", "a-2"]
    assert last.mass == 1e5


@pytest.mark.parametrize(
    ("size", "z", "what"),
    [
        ((1, 1, 0.02), 0.01, "floor"),
        ((3, 1.3, 0.02), 0.1, None),
        ((3, 1.4, 0.02), 0.1, "floor"),
        ((3, 3, 0.02), 0.12, None),
        ((1, 1, 0.2), 2.29, None),
        ((1, 1, 0.2), 2.31, "overhead part"),
    ],
)
def test_floors_and_what_is_overhead_meet_no_robot(size, z, what):
    world, _, told = built(("a", [box(size, 0, 0, z)], None))
    assert (len(world.obstacles) == 0) == (what is not None)
    assert [kind for _, kind, _ in told] == [what or "static model"]
    assert [fate for fate, *_ in told] == [{None: "KEPT", "floor": "GUESSED"}.get(what, "LEFT_OUT")]


@pytest.mark.parametrize(("mass", "top", "lower"), [(None, 0.19, 0.19), (2.0, 0.19, 0.19), (None, 0.31, 0.0)])
def test_what_stands_on_a_slab_that_carries_the_scene_stands_on_the_floor(mass, top, lower):
    slab = ("slab", [box((6, 5, top), 0, 0, top / 2)], None)
    lamps = [Light("l", np.array([0.0, 0.0, 2.0]), "#ffffff", 5.0)]
    world, _, told = built(slab, ("crate", [box((0.5, 0.4, 0.6), 1, 1, top + 0.3)], mass), lights=lamps)
    crate = next(each for each in world.obstacles if each.name == "crate")
    assert crate.elevation == pytest.approx(top - lower)
    assert world.lamps[0].height == pytest.approx(2.0 - lower)
    assert (("slab" not in {each.name for each in world.obstacles}), "floor" in {kind for _, kind, _ in told}) == (
        lower > 0,
        lower > 0,
    )


def test_tilted_things_become_models_of_the_same_shape_and_equal_ones_share_a_file():
    parts = [box((0.5, 0.4, 0.6), 1, 2, 1, yaw=0.6, tilt=0.4), mesh_of(CUBE, posed(1.2, 2, 1, yaw=0.6, tilt=0.2))]
    again = [part.moved(posed(5, 1, 0, yaw=0.3)) for part in parts]
    world, files, _ = built(("a", parts, None), ("a", again, 3.0))
    assert [each.name for each in world.obstacles] == ["a", "a-2"]
    assert {name.split("/")[0] for name in files} == {"f"}
    still, moving = world.obstacles
    assert (moving.mass, moving.movable) == (3.0, True)
    for obstacle, solids in ((still, parts), (moving, again)):
        text = files[obstacle.model].decode()
        beside = {name.rpartition("/")[2]: data for name, data in files.items() if name.startswith(obstacle.model[:-9])}
        model = mujoco.MjModel.from_xml_string(text, beside)
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        base = posed(*obstacle.at, 0.0, yaw=math.radians(obstacle.heading_deg))
        world_low = min(solid.corners()[:, 2].min() for solid in solids)
        assert obstacle.elevation == pytest.approx(world_low, abs=1e-3)
        for geom, solid in enumerate(solids):
            place = base @ [*data.geom_xpos[geom], 1.0]
            middle = solid.corners().mean(axis=0)
            np.testing.assert_allclose(place[:3], middle, atol=2e-3)
            np.testing.assert_allclose(model.geom_rgba[geom], [16 / 255, 32 / 255, 48 / 255, 1], atol=1e-4)
        np.testing.assert_allclose(model.geom_size[0], [0.25, 0.2, 0.3])


def test_a_large_mesh_is_written_as_its_hull_with_faces_outwards():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(120, 3))
    solid = SceneSolid("mesh", (), np.eye(4), None, points, rng.integers(0, 120, (20_001, 3)))
    _, files = model_files(SceneThing("m", [solid], np.eye(4)), moves=True)
    rows = [line.split() for line in files["part0.obj"].decode().splitlines()]
    vertices = np.array([row[1:] for row in rows if row[0] == "v"], float)
    faces = np.array([row[1:] for row in rows if row[0] == "f"], int) - 1
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6 == pytest.approx(ConvexHull(points).volume, rel=1e-4)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a - vertices.mean(axis=0)) > 0).all()


def test_lamps_shine_where_the_scene_has_them_up_to_a_hundred():
    lights = [Light("l", np.array([k, -1.0, 2.0]), "#ff0000", 500.0 if k else 0.01) for k in range(101)]
    lights[1] = Light("low", np.array([1.0, -1.0, -3.0]), "#ff0000", 7.0)
    world, _, told = built(("a", [box((1, 1, 1), 0, 0, 0.5)], None), lights=lights)
    assert len(world.lamps) == 100
    assert [(lamp.at[0], lamp.height, lamp.range) for lamp in world.lamps[:3]] == [
        (0.0, 2.0, 0.1), (1.0, 0.05, 7.0), (2.0, 2.0, 100.0)
    ]  # fmt: skip
    assert any("lamps beyond" in kind for _, kind, _ in told)


def test_a_hollow_mesh_is_walls_as_thick_as_between_its_faces():
    def ring(half, *, inside):
        part = mesh_of(CUBE * (2 * half, 1.5 * half, 2.0), posed(0, 0, 1.0))
        sides = part.faces[[np.ptp(part.vertices[face][:, 2]) > 0 for face in part.faces]]
        return SceneSolid("mesh", (), part.pose, "#102030", part.vertices, sides[:, ::-1] if inside else sides)

    outer, inner = ring(2.0, inside=False), ring(1.9, inside=True)
    found = traced([outer, inner])
    assert len(found.used) == 2
    assert found.walls
    xs, ys = np.array([point for wall in found.walls for point in wall.points]).T
    assert (xs.min(), xs.max(), ys.min(), ys.max()) == pytest.approx((-1.95, 1.95, -1.46, 1.46), abs=0.06)
    assert {wall.height for wall in found.walls} == {2.0}
    assert {wall.color for wall in found.walls} == {"#102030"}
    assert not traced([mesh_of(CUBE * 4, posed(0, 0, 2))]).used
    assert not traced([mesh_of(CUBE * (2.4, 2.4, 2), posed(0, 0, 1), without=1)]).used
    faces = np.concatenate([outer.faces, inner.faces + 8])
    rail = SceneSolid("mesh", (), posed(0, 0, 1.5), None, np.concatenate([outer.vertices, inner.vertices]) * 0.7, faces)
    assert traced([rail]).dropped == [rail]


def test_the_frame_of_a_doorway_in_a_hollow_mesh_does_not_fill_it():
    def side(half, *, inside):
        part = mesh_of(CUBE * (2 * half, 1.5 * half, 2.5), posed(0, 0, 1.25))
        return SceneSolid("mesh", (), part.pose, None, part.vertices, part.faces[:, ::-1] if inside else part.faces)

    legs = [mesh_of(CUBE * (0.1, 0.2, 2.1), posed(x, 0.5, 1.05)) for x in (-0.5, 0.5)]
    lintel = mesh_of(CUBE * (1.1, 0.2, 0.1), posed(0, 0.5, 2.15))
    corners = np.concatenate([each.corners() for each in (*legs, lintel)])
    faces = np.concatenate([each.faces + 8 * k for k, each in enumerate((*legs, lintel))])
    frame = SceneSolid("mesh", (), posed(0, 0, 0), None, corners, faces)
    table = SceneSolid("mesh", (), posed(1.2, -0.5, 0), None, corners * (1, 1, 0.35), faces)
    found = traced([side(3.0, inside=False), side(2.9, inside=True), frame, table])
    assert frame in found.used
    assert table not in found.used
    assert not traced([frame]).used


@pytest.mark.parametrize("turned", [False, True])
def test_a_doorway_without_jambs_in_a_hollow_mesh_stays_open(turned):
    # Faces of the walls of a room, solid to the left; nothing ends the wall at its doorway.
    outer = [((0, 0), (2, 0)), ((2.9, 0), (6, 0)), ((6, 0), (6, 4)), ((6, 4), (0, 4)), ((0, 4), (0, 0))]
    inner = [((2, 0.1), (0.1, 0.1)), ((5.9, 0.1), (2.9, 0.1)), ((5.9, 3.9), (5.9, 0.1)), ((0.1, 3.9), (5.9, 3.9))]
    lines = [*outer, *inner, ((0.1, 0.1), (0.1, 3.9))]
    corners = [(*end, z) for line in lines for end, z in zip((*line, *line[::-1]), (0, 0, 2, 2), strict=True)]
    faces = [(4 * k + a, 4 * k + b, 4 * k + c) for k in range(len(lines)) for a, b, c in ((0, 1, 2), (0, 2, 3))]
    pose = posed(0, 0, 0, yaw=math.pi / 2 if turned else 0.0)
    found = traced([SceneSolid("mesh", (), pose, None, np.array(corners, dtype=float), np.array(faces))])
    solid_walls = shapely.unary_union([rectangle for wall in found.walls for rectangle in _rectangles(wall)])
    doorway = shapely.box(2.1, -0.1, 2.8, 0.2)
    turn = shapely.affinity.rotate(doorway, 90 if turned else 0, origin=(0, 0))
    assert solid_walls.intersection(turn).area < 0.01
    assert solid_walls.area == pytest.approx(0.1 * 18.7, rel=0.25)
    assert not found.things


def _rectangles(wall):
    lines = [shapely.LineString(line) for line in itertools.pairwise([*wall.points, *wall.points[: int(wall.closed)]])]
    return [line.buffer(wall.thickness / 2, cap_style="flat") for line in lines]
