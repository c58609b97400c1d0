"""Where walls meet: no gap for a robot or a beam, no two faces in one place, one solid for the scene and the plan."""

import itertools
import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from mjsim.bench.rooms import cast, forwarded
from mjsim.compile import compile_world
from mjsim.compile.room.prisms import Faces, Prisms, visible_faces
from mjsim.compile.room.walls import wall_boxes
from mjsim.geometry import Pose
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.world import Opening, Robot, Wall, World, parse_world, segments, solid, solid_pieces
from mjsim.world.plan.wall_corners import TOUCH

Points = list[tuple[float, float]]
COLORS = ("#e8e4da", "#a0b0c0", "#804020")
AHEAD = 2.1
"""Three times the top speed of the robot by its preset [m/s]."""


def pairs(points: NDArray[np.float64]) -> Points:
    return [(float(x), float(y)) for x, y in points]


def union(walls: list[Wall]) -> shapely.Geometry:
    outlines = [shapely.Polygon(piece.outline) for pieces in solid_pieces(walls) for piece in pieces]
    return shapely.union_all(outlines, grid_size=1e-9)


def room(rng: np.random.Generator, middle: tuple[float, float]) -> tuple[list[Wall], NDArray[np.float64]]:
    """Return the walls of a room of 4 to 7 random corners, each of them joined in its own way, and its corners.

    Walls go on round a corner, or end at one: up to the tolerance before it or behind it and beside it, or
    somewhere on beyond it, so that the next one ends at their side.
    """
    count = int(rng.integers(4, 8))
    angles = np.sort(rng.uniform(0, 0.6, count) + np.arange(count)) * 2 * math.pi / count
    radii = rng.uniform(1.3, 2.6, count)
    corners = np.column_stack([np.cos(angles), np.sin(angles)]) * radii[:, None] + middle
    thickness = float(rng.uniform(0.03, 0.2))
    walls: list[Wall] = []
    run = [corners[0]]
    for index in range(1, count + 1):
        here, before = corners[index % count], run[-1]
        along = (here - before) / np.linalg.norm(here - before)
        kind = rng.choice(["on", "touch", "beyond"]) if index < count else "touch"
        if kind == "on":
            run.append(here)
            continue
        missed = along * rng.uniform(-0.9, 0.9) * TOUCH / 2 if kind == "touch" else along * rng.uniform(0.0, 0.5)
        walls.append(
            Wall(
                points=tuple(pairs(np.array([*run, here + missed]))),
                thickness=thickness if rng.random() < 0.5 else float(rng.uniform(0.03, 0.2)),
                height=float(rng.choice([1.0, 1.6])),
                color=str(rng.choice(COLORS)),
            )
        )
        run = [here]
    return walls, corners


def middle_of(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the place of a room that is farthest from its walls."""
    circle = shapely.maximum_inscribed_circle(shapely.Polygon(corners))
    return shapely.get_coordinates(circle)[0]


@pytest.fixture(scope="module")
def many() -> tuple[list[Wall], list[NDArray[np.float64]]]:
    """Return 24 rooms, 8 m apart, and the corners of each."""
    rng = np.random.default_rng(5)
    rooms = [room(rng, (8.0 * (k % 6), 8.0 * (k // 6))) for k in range(24)]
    return [wall for walls, _ in rooms for wall in walls], [corners for _, corners in rooms]


@pytest.mark.parametrize("turn", [0.0, 3.0, 30.0, 60.0, 90.0, 91.0, 120.0, 150.0, 170.0])
def test_two_walls_that_end_at_one_place_are_as_one_wall_with_a_corner(turn):
    angle = math.radians(turn)
    first, corner, last = (-2.0, 0.5), (1.0, 0.5), (1.0 + 2 * math.cos(angle), 0.5 + 2 * math.sin(angle))
    one = union([Wall(points=(first, corner, last), thickness=0.2)])
    for ways in ((first, corner), (corner, first)), ((corner, last), (last, corner)):
        for a, b in itertools.product(ways, [(corner, last), (last, corner)]):
            if {*a, *b} == {first, corner, last}:
                two = union([Wall(points=a, thickness=0.2), Wall(points=b, thickness=0.2)])
                assert two.symmetric_difference(one).area < 1e-6


def test_a_wall_that_comes_back_to_its_first_corner_is_closed():
    corners = ((0.0, 0.0), (3.0, 0.0), (4.0, 2.0), (0.5, 1.5))
    closed = union([Wall(points=corners, closed=True, thickness=0.2)])
    by_hand = union([Wall(points=(*corners, corners[0]), thickness=0.2)])
    assert by_hand.symmetric_difference(closed).area < 1e-6


@pytest.mark.parametrize("before", [-0.3, 0.0, 0.05, 0.1, 0.1 + 0.9 * TOUCH])
@pytest.mark.parametrize("lean", [30.0, 60.0, 90.0, 130.0])
def test_a_wall_that_ends_at_the_side_of_another_goes_on_into_it(before, lean):
    angle = math.radians(lean)
    side = Wall(points=((-3, 0), (3, 0)), thickness=0.2)
    foot = np.array([0.2, before])
    ending = Wall(
        points=tuple(pairs(foot + np.array([[2 * math.cos(angle), 2 * math.sin(angle)], [0, 0]]))), thickness=0.12
    )
    both = union([side, ending])
    assert both.geom_type == "Polygon"
    # As wide at its foot as anywhere: nothing of it is left when half its thickness is taken off all around.
    assert both.buffer(-0.055).geom_type == "Polygon"
    # It does not come out of the other face.
    if before >= 0:
        assert shapely.box(-3, -0.1, 3, 3).buffer(1e-6).covers(both)


def test_walls_that_do_not_meet_are_left_as_they_are_written():
    side, near = (
        Wall(points=((-3, 0), (3, 0)), thickness=0.2),
        Wall(points=((0, 0.1 + 2 * TOUCH), (0, 2)), thickness=0.1),
    )
    along = Wall(points=((-2, 0.35), (1, 0.35)), thickness=0.1)
    assert [len(pieces) for pieces in solid_pieces([side, near, along])] == [1, 1, 1]
    door = Wall(points=((-3, 0), (3, 0)), thickness=0.2, openings=(Opening(at=2.5, width=1.0),))
    ending = Wall(points=((0, 0.1), (0, 2)), thickness=0.1)
    assert len(solid_pieces([door, ending])[1]) == 1


def test_walls_of_random_rooms_have_no_hole_at_any_joint(many):
    walls, rooms = many
    plan = solid(World(walls=tuple(walls)))
    thinnest = min(wall.thickness for wall in walls)
    # Taken off nearly half the thickness all around, each room is still closed.
    rings = shapely.get_parts(plan.buffer(-0.4 * thinnest))
    assert len(rings) == len(rooms)
    holes = shapely.union_all([shapely.Polygon(hole) for ring in rings for hole in ring.interiors])
    assert all(holes.contains(shapely.Point(middle_of(corners))) for corners in rooms)


def test_the_boxes_of_the_scene_are_the_solid_of_the_plan(many):
    walls, _ = many
    outlines = []
    for box in wall_boxes(walls):
        c, s = math.cos(box.heading), math.sin(box.heading)
        corners = box.half[:2] * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
        outlines.append(shapely.Polygon(corners @ [[c, s], [-s, c]] + box.center[:2]))
    scene = shapely.union_all(outlines, grid_size=1e-9)
    assert scene.symmetric_difference(solid(World(walls=tuple(walls)))).area < 1e-4 * scene.area


@pytest.mark.slow
def test_no_beam_leaves_a_random_room(many):
    walls, rooms = many
    model = compile_world(World(walls=tuple(walls))).compile()
    data = forwarded(model)
    for corners in rooms:
        outline = shapely.Polygon(corners)
        eye = middle_of(corners)
        # All around, and in a dense fan across each corner.
        fans = np.arctan2(*(corners - eye).T[::-1])[:, None] + np.linspace(-0.1, 0.1, 201)
        angles = np.concatenate([np.linspace(0, 2 * np.pi, 360, endpoint=False), fans.ravel()])
        beams = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
        distances = cast(model, data, np.append(eye, 0.5), beams)
        ends = eye + np.minimum(distances, 50.0)[:, None] * beams[:, :2]
        assert shapely.contains_xy(outline.buffer(0.15, join_style="mitre"), *ends.T).all()


def faces_of(walls: list[Wall]) -> Faces:
    boxes = wall_boxes(walls)
    low, high = np.array([(box.center[2] - box.half[2], box.center[2] + box.half[2]) for box in boxes]).T
    look = np.array([COLORS.index(box.finish[1]) for box in boxes])
    return visible_faces(Prisms(np.array([box.outline for box in boxes]), low, high, look))


@pytest.mark.slow
def test_no_two_faces_that_are_seen_lie_in_one_place(many):
    """What would flicker: two triangles in one plane, or nearly, that cover each other."""
    walls, _ = many
    faces = faces_of(walls)
    points, normals = faces.points[faces.triangles], faces.normals[faces.triangles[:, 0]]
    tree = shapely.STRtree(shapely.box(*points[..., :2].min(axis=1).T, *points[..., :2].max(axis=1).T))
    one, other = tree.query(tree.geometries, predicate="dwithin", distance=1e-4)
    one, other = one[one < other], other[one < other]
    parallel = np.abs((normals[one] * normals[other]).sum(axis=1)) > 1 - 1e-6
    apart = np.abs(((points[other] - points[one][:, :1]) * normals[one][:, None]).sum(axis=2)).max(axis=1)
    one, other = one[parallel & (apart < 1e-4)], other[parallel & (apart < 1e-4)]
    assert len(one) > 1000
    level = np.abs(normals[one, 2:]) > 0.5
    along = np.where(level, [1.0, 0.0, 0.0], np.stack([-normals[one, 1], normals[one, 0], 0.0 * one], axis=1))
    up = np.where(level, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])
    first, second = (
        shapely.polygons(np.einsum("nki,nji->nkj", points[k], np.stack([along, up], 1))) for k in (one, other)
    )
    # A micrometre wide, as the grid of the faces is, and as high as a wall.
    assert shapely.area(shapely.intersection(first, second)).max() < 4e-6


def drives(rng: np.random.Generator, *, rounds: int, rooms: int) -> int:
    """Drive robots at the corners of random rooms at top speed; return how many drives none of which got out."""
    made = [room(rng, (8.0 * (k % 4), 8.0 * (k // 4))) for k in range(rooms)]
    outlines = [shapely.Polygon(corners) for _, corners in made]
    starts = [middle_of(corners) for _, corners in made]
    keys = f"drive: {{max_speed: {AHEAD}, max_acceleration: 8}}"
    robots = "".join(f"- {{name: r{k}, at: [{x}, {y}], {keys}}}\n" for k, (x, y) in enumerate(starts))
    robots_of: tuple[Robot, ...] = parse_world(f"robots:\n{robots}").robots
    world = World(walls=tuple(wall for walls, _ in made for wall in walls), robots=robots_of)
    with Simulation(world, seed=0) as sim:
        for turn in range(rounds):
            for name, start, (_, corners) in zip(sim.robots, starts, made, strict=True):
                aim = corners[turn % len(corners)] + rng.uniform(-0.1, 0.1, 2)
                sim.move(name, Pose(*start, math.atan2(*(aim - start)[::-1])))
            for _ in range(round(1.6 / sim.dt)):
                for name in sim.robots:
                    sim.apply(name, Command(AHEAD))
                sim.step()
                for name, outline in zip(sim.robots, outlines, strict=True):
                    at = sim.truth(name)
                    assert shapely.contains_xy(outline, at.x, at.y), (name, at)
    return rounds * rooms


@pytest.mark.slow
def test_a_robot_at_top_speed_does_not_pass_a_joint():
    assert drives(np.random.default_rng(11), rounds=2, rooms=6) == 12


@pytest.mark.slow
def test_a_hundred_robots_at_top_speed_do_not_pass_a_joint():
    count = drives(np.random.default_rng(12), rounds=6, rooms=16)
    assert count == 96


def test_segments_of_a_random_room_go_round_it_inside_and_outside(many):
    walls, rooms = many
    assert len(segments(World(walls=tuple(walls)))) > 2 * sum(len(corners) for corners in rooms)
