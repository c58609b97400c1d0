"""SDF files hold what the world holds, at the same places; read back with numbers alone."""

import math
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from mjsim.exchange import write_sdf, write_svg
from mjsim.world import World, load_world, parse_world, solid

WORLDS = Path(__file__).parents[2] / "worlds"
ROOM = """
mjsim: 1
walls:
  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]
    closed: true
    openings: [{at: 2, width: 0.9, name: exit, door: {hinge: right, angle_deg: 30, limit_deg: 90, spring: 2}}]
obstacles:
  - {name: ramp, ramp: [2, 1, 0.2], at: [3, 2], heading_deg: 90}
  - {name: chest, box: [0.8, 0.5, 0.4], at: [1, 3], heading_deg: 30, movable: true, mass: 4, friction: 0.3}
  - {name: bin, cylinder: [0.2, 0.5], at: [5, 1]}
beacons:
  - {name: owl, image: posters/owl.jpg, at: [0.06, 3], heading_deg: 0, width: 0.8, center: 1.0}
  - {name: tag, marker: {id: 7}, at: [3, 3.94], heading_deg: -90, tilt_deg: 10, width: 0.3}
"""


def frame(element: ElementTree.Element) -> np.ndarray:
    """Return the pose of an element in its parent's frame, shape (4, 4)."""
    matrix = np.eye(4)
    if (text := element.findtext("pose")) is not None:
        x, y, z, roll, pitch, yaw = map(float, text.split())
        matrix[:3, :3] = (
            Rotation.from_rotvec([0, 0, yaw]) * Rotation.from_rotvec([0, pitch, 0]) * Rotation.from_rotvec([roll, 0, 0])
        ).as_matrix()
        matrix[:3, 3] = x, y, z
    return matrix


def points(shape: ElementTree.Element) -> np.ndarray:
    """Return the corners of a solid, round ones as 64-sided prisms, shape (n, 3); balls are not asked for."""
    if shape.tag == "box":
        half = np.array(shape.findtext("size").split(), dtype=float) / 2
        return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    if shape.tag == "cylinder":
        radius, height = float(shape.findtext("radius")), float(shape.findtext("length"))
        turns = np.arange(64) * math.tau / 64
        ring = radius * np.column_stack([np.cos(turns), np.sin(turns)])
        return np.vstack([np.column_stack([ring, np.full(64, z)]) for z in (-height / 2, height / 2)])
    ring = np.array([point.text.split() for point in shape.findall("point")], dtype=float)
    return np.vstack([np.column_stack([ring, np.full(len(ring), z)]) for z in (0.0, float(shape.findtext("height")))])


def slices(path: Path, height: float) -> shapely.Geometry:
    """Cut all that bumps and stays, but for the floor, at a height: convex hulls of where edges pass the plane."""
    found = []
    for model in ElementTree.parse(path).findall("world/model"):
        if model.get("name") == "floor" or model.findtext("static") != "true":
            continue
        for part in model.iterfind("link/collision"):
            corners = points(part.find("geometry")[0])
            corners = (np.column_stack([corners, np.ones(len(corners))]) @ (frame(model) @ frame(part)).T)[:, :3]
            low, high = corners[corners[:, 2] <= height], corners[corners[:, 2] > height]
            if len(low) and len(high):
                share = (height - low[:, None, 2]) / (high[:, 2] - low[:, None, 2])
                cut = low[:, None, :2] + share[..., None] * (high[:, :2] - low[:, None, :2])
                found.append(shapely.MultiPoint(cut.reshape(-1, 2)).convex_hull)
    return shapely.union_all(found)


def written(world: World, folder: Path) -> Path:
    return write_sdf(world, folder / "world.sdf")


SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in ("gallery", "museum")]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ramps", "corridor", *SLOW])
def test_what_bumps_in_gazebo_is_what_bumps_here(name, tmp_path):
    world = load_world(WORLDS / f"{name}.yaml")
    path = written(world, tmp_path)
    for height in (0.07, 1.0, 2.3):
        apart = solid(world, height=height).symmetric_difference(slices(path, height))
        # Wheel things have 32 sides here and 64 there: slivers of less than 2 square centimetres.
        assert max((part.area for part in shapely.get_parts(apart)), default=0.0) < 2e-4


def test_a_ramp_is_a_wedge_that_rises_along_its_heading(tmp_path):
    path = written(parse_world(ROOM), tmp_path)
    (ramp,) = (part for part in shapely.get_parts(slices(path, 0.15)) if part.contains(shapely.Point(3, 2.9)))
    assert np.allclose(ramp.bounds, [2.5, 2.5, 3.5, 3.0])


def test_a_door_swings_on_its_hinge_within_its_limits(tmp_path):
    model = ElementTree.parse(written(parse_world(ROOM), tmp_path)).find("world/model[@name='door_exit']")
    joint = model.find("joint")
    assert (joint.get("type"), joint.findtext("parent"), joint.findtext("child")) == ("revolute", "world", "link")
    # The wall goes east, its right hinge is at x = 2.9; open by 30 degrees to the left, the leaf points north-west.
    assert np.allclose(frame(model)[:2, 3], [2.9, 0])
    assert np.allclose(frame(model)[:2, 0], [-math.cos(math.radians(30)), math.sin(math.radians(30))])
    lower, upper = (float(joint.findtext(f"axis/limit/{key}")) for key in ("lower", "upper"))
    assert np.allclose([lower, upper], np.radians([-120, 60]))
    assert joint.findtext("axis/xyz") == "0 0 -1"
    assert float(joint.findtext("axis/dynamics/spring_stiffness")) == 2.0
    assert float(model.findtext("link/inertial/mass")) == 20.0


def test_what_can_be_pushed_has_mass_and_friction(tmp_path):
    model = ElementTree.parse(written(parse_world(ROOM), tmp_path)).find("world/model[@name='obstacle_chest']")
    assert model.find("static") is None
    assert float(model.findtext("link/inertial/mass")) == 4.0
    assert float(model.findtext("link/inertial/inertia/izz")) == pytest.approx(4.0 * (0.8**2 + 0.5**2) / 12)
    assert float(model.findtext("link/collision/surface/friction/ode/mu2")) == 0.3


def test_pictures_hang_upright_face_the_room_and_lie_beside_the_file(tmp_path):
    path = written(parse_world(ROOM), tmp_path)
    tree = ElementTree.parse(path)
    owl = tree.find("world/model[@name='beacon_owl']")
    turned = frame(owl)[:3, :3]
    assert np.allclose(turned.T, [[0, 1, 0], [0, 0, 1], [1, 0, 0]], atol=1e-8)  # right, up, towards the viewer
    assert np.allclose(frame(owl)[:3, 3], [0.06, 3, 1.0])
    tag = tree.find("world/model[@name='beacon_tag']")
    assert np.allclose(frame(tag)[:3, 2], [0, -math.cos(math.radians(10)), math.sin(math.radians(10))])
    for model, width in ((owl, 0.8), (tag, 0.3 * 8 / 6)):
        wide, high = map(float, model.findtext("link/visual/geometry/plane/size").split())
        picture = cv2.imread(str(tmp_path / model.findtext(".//albedo_map")))
        assert wide == pytest.approx(width, rel=1e-6)
        assert high / wide == pytest.approx(picture.shape[0] / picture.shape[1], rel=0.01)
    assert owl.find("link/collision") is None


@pytest.mark.slow
def test_people_bump_in_gazebo_where_their_segments_are_and_are_drawn_on_plans(tmp_path):
    world = parse_world("mjsim: 1\npeople: [{name: anna, sex: female, at: [1, 2]}]\n")
    (anna,), path = world.people, written(world, tmp_path)
    for segment, height in (("left_foot", 0.02), ("thorax", 1.2), ("head", 1.55)):
        outline, low, high = anna.prisms[segment]
        assert low < height < high
        assert slices(path, height).buffer(1e-5).contains(shapely.Polygon(outline))
    plan = write_svg(world, tmp_path / "plan.svg").read_text(encoding="utf-8")
    assert "anna" in plan
    assert plan.count("<polygon") == len(anna.prisms)
