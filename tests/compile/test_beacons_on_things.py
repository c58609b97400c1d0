"""Beacons on obstacles and on robots: they hang in the frame of what carries them, and go where it goes."""

import math

import cv2
import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.compile import compile_world, export_scene
from mjsim.world import check_world, hung, parse_world

BEACONS = """
beacons:
  - {name: shelf, marker: {id: 1}, on: box, at: [0.25, 0.1], center: 0.3, width: 0.2, tilt_deg: 30}
  - {name: crate, marker: {id: 2}, on: cart, at: [0, -0.2], heading_deg: -90, center: 0.2, width: 0.2}
  - {name: mate, image: posters/lion.jpg, on: other, at: [-0.3, 0], heading_deg: 180, center: 0.5, width: 0.3}
  - {name: wall, marker: {id: 3}, at: [3, 3]}
"""
ROOM = f"""
mjsim: 1
obstacles:
  - {{name: box, box: [0.5, 0.6, 1.0], at: [2, 1], heading_deg: 90, elevation: 0.2}}
  - {{name: cart, box: [0.4, 0.4, 0.4], at: [1, -1], movable: true, mass: 2}}
{BEACONS}
robots:
  - {{name: scout, at: [0, 0], sensors: [{{beacons: ring, fov_deg: 360, range: [0.1, 8]}}]}}
  - {{name: other, at: [2, -2], heading_deg: 90, sensors: [{{beacons: ring, fov_deg: 360, range: [0.01, 8]}}]}}
"""


@pytest.fixture(scope="module")
def simulation():
    with mjsim.Simulation(parse_world(ROOM)) as simulation:
        yield simulation


def plane(simulation, name):
    """Middle, shape (3,) [m], and axes as columns: right, up, out."""
    geom = simulation.data.geom(f"beacon/{name}")
    return geom.xpos, geom.xmat.reshape(3, 3)


def test_a_beacon_on_a_fixed_thing_hangs_in_its_frame_and_looks_up_by_its_tilt(simulation):
    place, axes = plane(simulation, "shelf")
    # The box stands turned by 90 degrees, so its x is the world's y; half a millimetre keeps the picture off its face.
    np.testing.assert_allclose(place, [1.9, 1.25, 0.5], atol=6e-4)
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    np.testing.assert_allclose(axes.T, [[-1, 0, 0], [0, -s, c], [0, c, s]], atol=1e-9)


def test_a_beacon_on_a_robot_goes_where_the_robot_goes(simulation):
    model, data = simulation.model, mujoco.MjData(simulation.model)
    start = model.joint("other/free").qposadr[0]
    data.qpos[start : start + 7] = [5, 5, 0, 1, 0, 0, 0]
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.geom("beacon/mate").xpos, [4.7, 5, 0.5], atol=6e-4)
    np.testing.assert_allclose(data.geom("beacon/mate").xmat.reshape(3, 3)[:, 2], [-1, 0, 0], atol=1e-9)


def test_a_beacon_on_a_movable_thing_adds_no_weight_and_touches_nothing(simulation):
    geom = simulation.model.geom("beacon/crate")
    assert simulation.model.body("obstacle/cart").mass == pytest.approx(2.0)
    assert (geom.contype, geom.conaffinity) == (0, 0)


def test_sensors_see_beacons_where_they_are_now_and_robots_do_not_see_their_own(simulation):
    sightings = {sighting.name: sighting for sighting in simulation.sense("other").sightings}
    assert "mate" not in sightings
    # The marker on the cart faces south at (1, -1.2); the robot at (2, -2) looks north.
    assert sightings["crate"].range == pytest.approx(math.hypot(1.0, 0.8), abs=1e-3)
    assert sightings["crate"].bearing == pytest.approx(math.atan2(1.0, 0.8), abs=1e-3)


def test_only_beacons_that_stay_are_on_the_map_and_have_a_place_in_the_catalogue():
    world = parse_world(ROOM + "run: {map: known}")
    with mjsim.Simulation(world) as simulation:
        assert set(simulation.map.beacons) == {"shelf", "wall"}
        poses = {name: info.pose for name, info in simulation.catalogue.items()}
        assert poses["crate"] is None
        assert poses["mate"] is None
        np.testing.assert_allclose(poses["shelf"].as_array(), [1.9, 1.25, math.pi / 2])
        assert simulation.catalogue["shelf"].center == pytest.approx(0.5)
        # The box that can be pushed away is no part of the map either: the other has four faces.
        assert len(simulation.map.segments) == 4


@pytest.mark.slow
def test_a_camera_reads_the_marker_on_a_box_after_the_box_was_pushed_away():
    text = """
    mjsim: 1
    obstacles: [{name: cart, box: [0.4, 0.4, 0.4], at: [1, 0], movable: true, mass: 1, friction: 0.3}]
    beacons: [{name: crate, marker: {id: 2}, on: cart, at: [-0.2, 0], heading_deg: 180, center: 0.25, width: 0.2}]
    robots: [{name: scout, at: [0, 0], sensors: [{camera: front, at: [0, 0, 0.3], rate_hz: 25}]}]
    """
    with mjsim.Simulation(parse_world(text)) as simulation:
        for _ in range(75):
            simulation.apply("scout", mjsim.Command(forward=0.5))
            simulation.step()
        moved = simulation.data.body("obstacle/cart").xpos[0]
        for _ in range(75):
            simulation.apply("scout", mjsim.Command(forward=-0.4))
            simulation.step()
        frame = simulation.sense("scout").cameras["front"]
        truth, place = simulation.truth("scout"), simulation.data.geom("beacon/crate").xpos
    assert moved > 1.2
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
    (corners,), ids, _ = detector.detectMarkers(cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY))
    assert np.ravel(ids).tolist() == [2]
    K = frame.intrinsics.matrix()
    expected = K @ [0.0, 0.3 - place[2], place[0] - truth.x]
    np.testing.assert_allclose(corners.reshape(4, 2).mean(axis=0)[1], expected[1] / expected[2], atol=1.5)
    side = np.linalg.norm(np.diff(corners.reshape(4, 2), axis=0), axis=1).mean()
    assert side == pytest.approx(0.2 * K[0, 0] / (place[0] - truth.x), rel=0.05)


def test_beacons_on_things_hang_in_the_exported_scene_too(tmp_path):
    world = parse_world(ROOM)
    model = mujoco.MjModel.from_xml_path(str(export_scene(world, tmp_path)))
    ours = compile_world(world).compile()
    for name in ("shelf", "crate", "mate"):
        np.testing.assert_allclose(model.geom(f"beacon/{name}").pos, ours.geom(f"beacon/{name}").pos, atol=1e-9)


def test_a_world_tells_where_its_beacons_hang_at_the_start():
    places = {item.beacon.name: (item.place.x, item.place.y, item.center) for item in hung(parse_world(ROOM))}
    np.testing.assert_allclose(places["crate"], [1.0, -1.2, 0.2])
    np.testing.assert_allclose(places["mate"], [2.0, -2.3, 0.5])


@pytest.mark.parametrize(
    ("at", "message"),
    [
        ("[0.1, 0]", "beacon 'b' at [0.1, 0] on 'box' hangs inside obstacle 'box', where it cannot be seen; "),
        ("[0.25, 0]", None),
        ("[0.55, 0]", "beacon 'b' at [0.55, 0] on 'box' hangs inside obstacle 'pillar', where it cannot be seen; "),
    ],
)
def test_a_beacon_hidden_in_its_carrier_or_behind_another_thing_is_reported(at, message):
    text = f"""mjsim: 1
obstacles:
  - {{name: box, box: [0.5, 0.6, 1.0], at: [2, 1]}}
  - {{name: pillar, cylinder: [0.1, 2], at: [2.55, 1]}}
beacons: [{{name: b, marker: {{id: 1}}, on: box, at: {at}, center: 0.5, width: 0.2}}]
"""
    told = [str(problem) for problem in check_world(parse_world(text))]
    assert (not told) if message is None else told[0].startswith(f"world.yaml:5:51: {message}")
