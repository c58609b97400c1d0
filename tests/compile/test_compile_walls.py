"""Walls: solid without gaps, seen as they are bumped into, whatever their corners."""

import math
import time

import mujoco
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from mjsim.bench.rooms import cast, forwarded, look_from
from mjsim.compile import compile_world
from mjsim.compile.room.prisms import Faces, Prisms, visible_faces
from mjsim.compile.room.walls import WallBox, wall_boxes
from mjsim.sim import Renderer
from mjsim.world import Wall, World, parse_world

WIDTH, HEIGHT = 240, 180
CORNERS = """
mjsim: 1
walls:
  - {points: [[0, 0], [9, 0], [9, 7], [0, 7]], closed: true, thickness: 0.12,
     openings: [{segment: 0, at: 4, width: 0.9}, {segment: 1, at: 2, width: 1.5, sill: 0.9, head: 2.0}]}
  - {points: [[4.5, 0], [4.5, 3]], height: 2.0, color: "#a0b0c0"}
  - {points: [[1, 6], [3, 4], [2, 2], [2.3, 5], [1, 3]], thickness: 0.2, height: 1.4}
  - {points: [[6, 2], [7, 2], [7.8, 2.5], [7.9, 3.6], [5.9, 5], [7.5, 4.9]], height: 1.1}
  - {points: [[3, 7], [3, 5.5]], thickness: 0.3, height: 2.5}
robots: [{name: scout, at: [4, 4], sensors: [{camera: front}]}]
"""


def area(faces: Faces) -> float:
    """Return the area of faces, having checked that their triangles look outwards."""
    a, b, c = (faces.points[faces.triangles[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a) / 2
    np.testing.assert_array_less(0.0, (across * faces.normals[faces.triangles[:, 0]]).sum(axis=1))
    return float(np.linalg.norm(across, axis=1).sum())


def looks(faces: Faces, chosen: NDArray[np.bool_]) -> set[int]:
    """Return the looks that some of the triangles have."""
    return set(faces.material[chosen].tolist())


def blocks(*sides: tuple[tuple[float, float], tuple[float, float], tuple[float, float], int]) -> Prisms:
    """Return blocks from their bounds along x, y and z, and their looks."""
    outlines = [[[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]] for x, y, _, _ in sides]
    low, high = np.array([z for _, _, z, _ in sides]).T
    return Prisms(np.array(outlines, dtype=float), low, high, np.array([look for *_, look in sides]))


def test_a_block_on_the_floor_has_four_sides_and_a_top():
    faces = visible_faces(blocks(((0, 1), (0, 1), (0, 2), 0)))
    assert len(np.unique(faces.normals[faces.triangles[:, 0]], axis=0)) == 5
    assert len(faces.triangles) == 10
    assert area(faces) == pytest.approx(4 * 2 + 1)


def test_blocks_that_overlap_are_seen_as_one_solid():
    overlapping = blocks(((0, 2), (0, 1), (0, 2), 0), ((1, 3), (0, 1), (0, 2), 0), ((1, 2), (0, 1), (0, 2), 0))
    assert area(visible_faces(overlapping)) == pytest.approx(area(visible_faces(blocks(((0, 3), (0, 1), (0, 2), 0)))))


def test_a_lintel_shows_its_underside_and_a_pillar_through_a_roof_only_what_stands_out():
    faces = visible_faces(
        blocks(
            ((0, 1), (0, 1), (0, 2), 0),
            ((1, 2), (0, 1), (1, 2), 0),
            ((1.5, 3), (0, 1), (0, 1.5), 1),
            ((0.2, 0.4), (0.2, 0.4), (0, 3), 1),
        )
    )
    # Tops 3, underside 0.5, then sides: west 2, two long ones 4 + 2 + 2 each, east ones 1 + 0.5 + 1.5, the inner one
    # of the last block 1, and the pillar 4 x 0.2 x 1.
    assert area(faces) == pytest.approx(3 + 0.5 + 2 + 2 * (2 + 1 + 2) + 1 + 0.5 + 1.5 + 1 + 0.8)


def test_where_walls_of_two_colours_overlap_one_is_seen():
    faces = visible_faces(blocks(((0, 2), (0, 1), (0, 2), 1), ((1, 3), (0, 1), (0, 2), 0)))
    middle = faces.points[faces.triangles].mean(axis=1)
    assert area(faces) == pytest.approx(2 * 3 * 2 + 2 * 2 + 3)
    assert looks(faces, middle[:, 0] > 1.0) == {0}
    assert looks(faces, middle[:, 0] < 1.0) == {1}


def test_faces_meet_in_common_corners_so_that_no_crack_is_seen():
    boxes = wall_boxes(parse_world(CORNERS).walls)
    low, high = np.array([(box.center[2] - box.half[2], box.center[2] + box.half[2]) for box in boxes]).T
    faces = visible_faces(Prisms(np.array([box.outline for box in boxes]), low, high, np.zeros(len(boxes), int)))
    corners = np.unique(faces.points.round(6), axis=0)
    for triangle in faces.triangles[faces.normals[faces.triangles[:, 0], 2] == 0.0]:
        points = faces.points[triangle]
        for end in np.unique(points[:, :2], axis=0):
            heights = points[(points[:, :2] == end).all(axis=1), 2]
            on_line = corners[np.abs(corners[:, :2] - end).max(axis=1) < 2e-6, 2]
            within = on_line[(on_line > heights.min() - 1e-6) & (on_line < heights.max() + 1e-6)]
            np.testing.assert_allclose(np.unique(within), np.unique(heights.round(6)))


@pytest.mark.slow
def test_walls_are_seen_where_they_are_bumped_into():
    world = parse_world(CORNERS)
    model = compile_world(world).compile()
    data, rng, compared = forwarded(model), np.random.default_rng(1), 0
    with Renderer(model, width=WIDTH, height=HEIGHT) as renderer:
        for _ in range(25):
            eye, heading = rng.uniform([0.3, 0.3, 0.2], [8.7, 6.7, 3.0]), rng.uniform(-math.pi, math.pi)
            look_from(model, data, "scout/front", eye, [math.cos(heading), math.sin(heading), rng.uniform(-0.5, 0.2)])
            depth, measured = renderer.depth(data, "scout/front"), _measured(model, data, eye)
            if measured.min() < 0.03:
                continue  # The camera is inside a wall.
            compared += 1
            # Of a flat face, the inverse of depth is linear in the picture: it bends only at edges.
            inverse, edges = 1.0 / measured, np.zeros(measured.shape, dtype=bool)
            for axis in (0, 1):
                bend = np.abs(np.diff(inverse, 2, axis=axis)) > 1e-7
                edges |= np.pad(bend, [(1, 1) if side == axis else (0, 0) for side in (0, 1)])
            edges = np.lib.stride_tricks.sliding_window_view(np.pad(edges, 1), (3, 3)).any(axis=(2, 3))
            assert edges.mean() < 0.35
            far = np.isinf(measured)
            np.testing.assert_array_equal(far[~edges], np.isinf(depth)[~edges])
            # An edge that two faces meet almost flat may bend too little to be found: one pixel in ten thousand.
            apart = np.abs(depth[~edges & ~far] - measured[~edges & ~far]) > 1e-3
            assert apart.mean() < 1e-4
    assert compared >= 15


def _measured(model: mujoco.MjModel, data: mujoco.MjData, eye: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return depth by rays through the pixels of the front camera, shape (HEIGHT, WIDTH) [m]."""
    index = model.camera("scout/front").id
    focal = HEIGHT / 2 / math.tan(math.radians(model.cam_fovy[index]) / 2)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    x, y = (u - (WIDTH - 1) / 2) / focal, -(v - (HEIGHT - 1) / 2) / focal
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3) @ data.cam_xmat[index].reshape(3, 3).T
    return cast(model, data, eye, directions).reshape(HEIGHT, WIDTH)


def _closed(points: NDArray[np.float64], thickness: float) -> World:
    return World(walls=(Wall(points=tuple(map(tuple, points.tolist())), closed=True, thickness=thickness, height=1.0),))


@pytest.mark.parametrize("sharpest", [5, 20, 45, 70, 90, 120, 150, 175])
def test_no_ray_slips_through_a_corner(sharpest: float):
    half = math.radians(sharpest) / 2
    reach = 2.0 * np.array(
        [[0, 0], [math.cos(half), math.sin(half)], [math.cos(half) + 1.5, 0], [math.cos(half), -math.sin(half)]]
    )
    world = _closed(reach @ [[0.6, 0.8], [-0.8, 0.6]], 0.08)
    model = compile_world(world).compile()
    outline = shapely.Polygon(world.walls[0].points)
    inside = shapely.get_coordinates(outline.buffer(-0.06).representative_point())[0]
    angles = np.linspace(0, 2 * np.pi, 7200, endpoint=False)
    rays = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
    distances = cast(model, forwarded(model), np.append(inside, 0.5), rays)
    # The centreline is inside the wall: a ray may get as far as that, never farther.
    lines = shapely.linestrings(np.stack([np.broadcast_to(inside, (7200, 2)), inside + 20 * rays[:, :2]], axis=1))
    centreline = shapely.distance(shapely.Point(inside), shapely.intersection(lines, outline.exterior))
    assert (distances <= centreline + 1e-9).all()


@pytest.mark.parametrize("turn", [10, 60, 89.9, 90, 90.1, 110, 135, 160, 179, 180])
def test_boxes_are_what_shapely_gets_by_widening_the_centreline(turn: float):
    angle, thickness = math.radians(turn), 0.2
    points = ((0.0, 0.0), (3.0, 0.0), (3.0 + 2.0 * math.cos(angle), 2.0 * math.sin(angle)))
    boxes = wall_boxes([Wall(points=points, thickness=thickness)])
    solid = shapely.union_all([outline(box) for box in boxes], grid_size=1e-9)
    wide = shapely.LineString(points).buffer(0.1, cap_style="flat", join_style="mitre", mitre_limit=math.sqrt(2))
    assert solid.geom_type == "Polygon"
    if turn < 180:  # shapely leaves a wall that comes back on itself without an end
        assert solid.symmetric_difference(wide).area < 1e-6
    assert solid.covers(shapely.Point(points[1]).buffer(thickness / 2 - 1e-6))


def outline(box: WallBox) -> shapely.Polygon:
    """Return what a box stands on."""
    c, s = math.cos(box.heading), math.sin(box.heading)
    corners = box.half[:2] * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    return shapely.Polygon(corners @ [[c, s], [-s, c]] + box.center[:2])


def test_walls_of_one_colour_are_one_mesh_and_each_piece_one_box():
    spec = compile_world(parse_world(CORNERS))
    model = spec.compile()
    names = [model.geom(index).name for index in range(model.ngeom)]
    boxes = [index for index, name in enumerate(names) if name.startswith("wall/") and model.geom_group[index] == 3]
    seen = [index for index, name in enumerate(names) if name.startswith("wall/seen:")]
    assert all(model.geom_type[index] == mujoco.mjtGeom.mjGEOM_BOX for index in boxes)
    assert all(model.geom_contype[index] == 1 for index in boxes)
    assert len(seen) == 2
    assert all(model.geom_contype[index] == 0 and model.geom_group[index] == 1 for index in seen)


@pytest.mark.slow
def test_a_thousand_walls_compile_in_a_moment_and_few_meshes():
    rng = np.random.default_rng(0)
    walls = []
    for x, y in np.stack(np.meshgrid(np.arange(25), np.arange(20)), axis=-1).reshape(-1, 2) * 2.5:
        dx, dy = rng.uniform(0.8, 1.6, 2)
        walls.append(Wall(points=((x, y), (x + dx, y), (x + dx, y + dy)), thickness=0.1))
    start = time.perf_counter()
    model = compile_world(World(walls=tuple(walls))).compile()
    # 0.5 s on an idle machine; others may be at work beside the tests.
    assert time.perf_counter() - start < 5.0
    assert model.nmesh <= 30  # the floor of 62 m x 50 m has so many squares of 12 m
    assert sum(model.geom_group == 3) >= 1000
