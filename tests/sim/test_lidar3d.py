"""Point clouds of 3-D lidars, held to the planes of a room, to MuJoCo's own rays and to the poses between ticks."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.compile import compile_world
from mjsim.errors import WorldError
from mjsim.interface import Command, PointCloud
from mjsim.sim import Simulation
from mjsim.sim.rays import batch_rays
from mjsim.world import parse_world, with_settings

ROOM = """
mjsim: 1
walls:
  - points: [[0, 0], [8, 0], [8, 6], [0, 6]]
    closed: true
    thickness: 0.1
    height: 3
    openings: [{name: gate, segment: 1, at: 2.0, width: 1.0, door: {hinge: left, angle_deg: 50}}]
obstacles:
  - {name: crate, box: [0.8, 0.5, 1.1], at: [6, 4.5], heading_deg: 30}
  - {name: pillar, cylinder: [0.25, 2.0], at: [5, 1.2]}
  - {name: ball, sphere: 0.3, at: [2, 4.8]}
  - {name: walker, cylinder: [0.2, 1.6], at: [6.5, 2.2], path: {points: [[6.5, 3.5]], speed: 0.5}}
  - {name: cart, box: [0.5, 0.4, 0.9], at: [1.6, 3.0], movable: true, mass: 20}
robots:
  - {name: other, at: [1.2, 1.0]}
  - name: scout
    preset: pioneer3dx
    at: [3, 2]
    heading_deg: 20
"""
WALLED = "walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true, height: 30, thickness: 0.1}]"
LIDAR = "lidar3d: top, at: [0.1, 0.05, 0.8], rings: 16, columns: 360, rate_hz: 12.5"


def room(keys: str = "") -> mjsim.World:
    return parse_world(f"{ROOM}    sensors: [{{{LIDAR}{keys}}}]\n")


def cloud_of(sim: Simulation) -> PointCloud:
    return sim.sense("scout").clouds["top"]


def drive(sim: Simulation, ticks: int) -> None:
    for _ in range(ticks):
        sim.apply("scout", Command(forward=0.5, turn=1.2))
        sim.step()


def test_points_lie_on_the_walls_from_where_the_sensor_was_at_each_of_them():
    walls = "walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true, height: 9, thickness: 0.1}]"
    lidar = f"{{{LIDAR}, missed: 0.3, range: [2.5, 100]}}"
    bare = f"mjsim: 1\n{walls}\nrobots: [{{name: scout, preset: pioneer3dx, at: [3, 2], sensors: [{lidar}]}}]\n"
    world = with_settings(parse_world(bare), ["run.rate_hz=250"])
    with Simulation(world) as sim:
        mount = sim.robots["scout"].sensors["top"].robot_from_sensor
        places = [sim.pose("scout") @ mount]
        for _ in range(60):
            drive(sim, 1)
            places.append(sim.pose("scout") @ mount)
        cloud = cloud_of(sim)
    steps = np.round(cloud.times / 0.004).astype(int)
    assert {-19, 0} <= set(steps.tolist()) <= set(range(-19, 1))
    poses = np.array(places)[len(places) - 1 + steps]
    x, y, z = (np.einsum("nij,nj->ni", poses[:, :3, :3], cloud.points) + poses[:, :3, 3]).T
    off = np.abs([x - 0.05, x - 7.95, y - 0.05, y - 5.95, z])
    assert np.min(off, axis=0).max() < 1e-5
    assert np.linalg.norm(cloud.points, axis=1).min() > 2.5
    # Lambert's law: the strength of a return from a wall is as the cosine of the angle at which it is met.
    rays = np.einsum("nij,nj->ni", poses[:, :3, :3], cloud.points / np.linalg.norm(cloud.points, axis=1)[:, None])
    cosines = np.abs(rays[np.arange(len(rays)), np.array([0, 0, 1, 1, 2])[off.argmin(axis=0)]])
    for on_surface in (off.argmin(axis=0) < 4, off.argmin(axis=0) == 4):
        brightness = cloud.intensities[on_surface] / cosines[on_surface]
        assert np.ptp(brightness) < 1e-4 * brightness.mean()
    assert np.linalg.norm(places[-1][:3, 3] - places[-20][:3, 3]) > 0.01  # it moved meanwhile


@pytest.mark.parametrize("keys", ["", ", rosette: {fov_deg: 90, points: 3000}"])
def test_embree_and_mujoco_see_the_same_of_what_stands_turns_and_moves(keys, monkeypatch):
    clouds = []
    for has_embree in (True, False):
        monkeypatch.setattr(batch_rays, "has_embree", lambda has=has_embree: has)
        with Simulation(room(keys), seed=1) as sim:
            drive(sim, 10)
            clouds.append(cloud_of(sim))
    fast, slow = clouds
    assert len(fast.points) > 2000
    np.testing.assert_allclose(fast.points, slow.points, atol=1e-4)
    np.testing.assert_allclose(fast.intensities, slow.intensities, atol=1e-5)
    np.testing.assert_array_equal(fast.times, slow.times)


def test_what_rests_is_met_where_it_rests_and_afterwards_where_it_rests_then(monkeypatch):
    model = compile_world(room()).compile()
    angles = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    beams = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
    mount, edges = np.eye(4), np.arange(0, 721, 36)
    mount[2, 3] = 0.6
    cart = model.body("obstacle/cart")
    place = model.joint(cart.jntadr[0]).qposadr[0]
    states = np.tile(model.qpos0, (20, 1))
    elsewhere, moving = states.copy(), states.copy()
    elsewhere[:, place : place + 2] = [4.2, 4.6]
    moving[:, place] += np.linspace(0.0, 0.3, 20)
    found = []
    for has_embree in (True, False):
        monkeypatch.setattr(batch_rays, "has_embree", lambda has=has_embree: has)
        rays = batch_rays.BatchRays(model, "scout", carrier="base", mount=mount, edges=edges)
        turns = [rays.cast(beams, each, limit=50.0) for each in (states, elsewhere, moving, states)]
        found.append([(hits.distances, hits.geoms, hits.facing) for hits in turns])
    for fast, slow in zip(*found, strict=True):
        np.testing.assert_array_equal(fast[1], slow[1])
        np.testing.assert_allclose(fast[0], slow[0], atol=1e-6)
        np.testing.assert_allclose(fast[2], slow[2], atol=1e-6)
        assert (fast[1] == cart.geomadr[0]).sum() > 10


def test_what_is_taken_away_is_seen_no_more():
    with Simulation(room()) as sim:
        scout_from_world = np.linalg.inv(sim.pose("scout") @ sim.robots["scout"].sensors["top"].robot_from_sensor)
        crate = (scout_from_world @ [6, 4.5, 0.5, 1])[:3]

        def near() -> int:
            return int((np.linalg.norm(cloud_of(sim).points - crate, axis=1) < 0.5).sum())

        before = near()
        sim.remove("crate")
        for _ in range(2):
            sim.step()
        assert before > 20
        assert near() == 0


def test_it_never_meets_its_own_robot_and_meets_others():
    with Simulation(room()) as sim:
        points = cloud_of(sim).points
        assert np.linalg.norm(points, axis=1).min() > 0.5
        other = sim.pose("other")[:3, 3] - sim.pose("scout")[:3, 3]
        turned = math.radians(20)
        bearing = math.atan2(other[1], other[0]) - turned
        towards = np.abs(np.arctan2(points[:, 1], points[:, 0]) - bearing) < 0.05
        assert (points[towards, 2] < -0.4).any()


def test_a_turn_that_nobody_asks_for_leaves_chance_where_one_that_is_seen_does():
    keys = ", noise: {range: 0.02}, missed: 0.1"
    with Simulation(room(keys), seed=3) as watched, Simulation(room(keys), seed=3) as unwatched:
        for sim in (watched, unwatched):
            for _ in range(8):
                sim.step()
                if sim is watched:
                    sim.sense("scout")
        np.testing.assert_array_equal(cloud_of(watched).points, cloud_of(unwatched).points)


def test_noise_lies_along_the_beams_and_misses_are_left_out():
    with Simulation(room(), seed=1) as clean, Simulation(room(", noise: {range: 0.02}"), seed=1) as noisy:
        exact, told = cloud_of(clean), cloud_of(noisy)
    off = np.linalg.norm(told.points, axis=1) - np.linalg.norm(exact.points, axis=1)
    assert off.std() == pytest.approx(0.02, rel=0.05)
    along = np.einsum("ij,ij->i", told.points, exact.points)
    np.testing.assert_allclose(
        along, np.linalg.norm(told.points, axis=1) * np.linalg.norm(exact.points, axis=1), rtol=1e-5
    )
    with Simulation(room(", missed: 0.25"), seed=1) as sim:
        assert len(cloud_of(sim).points) == pytest.approx(0.75 * len(exact.points), rel=0.03)


def test_columns_are_fired_evenly_over_the_steps_of_a_revolution_and_the_last_ones_at_the_tick():
    keys = "lidar3d: top, at: [0, 0, 9], rings: 4, columns: 80, rate_hz: 12.5"
    world = parse_world(f"mjsim: 1\n{WALLED}\nrobots: [{{name: scout, at: [3, 2], sensors: [{{{keys}}}]}}]\n")
    with Simulation(world) as sim:
        cloud = cloud_of(sim)
    assert len(cloud.points) == 320
    # 20 steps of 4 ms, in each of which 4 columns of 4 beams are fired.
    times, counts = np.unique(np.round(cloud.times, 6), return_counts=True)
    np.testing.assert_allclose(times, -0.004 * np.arange(19, -1, -1), atol=1e-6)
    assert set(counts) == {16}
    angles = np.unwrap(np.arctan2(cloud.points[:, 1], cloud.points[:, 0]))[::4]
    assert (np.diff(angles) > 0.0).all(), "from right to left"


def test_rings_have_the_elevations_that_the_world_gives():
    with Simulation(room(", elevation_deg: [-20, 10], missed: 0.3")) as sim:
        cloud = cloud_of(sim)
    up = np.degrees(np.arctan2(cloud.points[:, 2], np.hypot(cloud.points[:, 0], cloud.points[:, 1])))
    np.testing.assert_allclose(up, np.linspace(-20, 10, 16)[cloud.rings], atol=1e-4)


def points_of(keys):
    """Return the first cloud of a sensor in the middle of the walls, shape (n, 3)."""
    text = f"mjsim: 1\n{WALLED}\nrobots: [{{name: scout, at: [3, 2], sensors: [{{{keys}}}]}}]"
    with Simulation(parse_world(text)) as sim:
        return cloud_of(sim).points


def test_over_less_than_a_turn_the_first_and_the_last_column_are_at_the_edges_of_the_field_of_view():
    keys = "lidar3d: top, rings: 3, columns: 10, fov_deg: 90"
    points = points_of(keys)
    azimuths = np.degrees(np.arctan2(points[:, 1], points[:, 0])).reshape(10, 3)
    np.testing.assert_allclose(azimuths, np.repeat(np.linspace(-45, 45, 10)[:, None], 3, axis=1), atol=1e-4)


def test_two_prisms_bend_the_beams_of_a_rosette_as_they_turn():
    keys = "lidar3d: top, at: [0, 0, 8], rosette: {fov_deg: 40, points: 500, rpm: [6000, -4500]}, rate_hz: 12.5"
    points = points_of(keys)
    off = np.arccos(points[:, 0] / np.linalg.norm(points, axis=1))
    left, up = off * points[:, 1:].T / np.linalg.norm(points[:, 1:], axis=1)
    # Each bends by 10 degrees towards where it points: 100 and -75 turns a second.
    time = 0.08 * np.arange(500) / 500
    bends = np.exp(1j * math.tau * 100 * time) + np.exp(-1j * math.tau * 75 * time)
    np.testing.assert_allclose(left + 1j * up, math.radians(10) * bends, atol=1e-5)


def test_a_rosette_fills_its_cone_and_draws_other_petals_each_time():
    with Simulation(room(", rosette: {fov_deg: 40, points: 4000}")) as sim:
        first = cloud_of(sim).points
        sim.step()
        sim.step()
        second = cloud_of(sim).points
    off = np.degrees(np.arccos(first[:, 0] / np.linalg.norm(first, axis=1)))
    assert off.max() == pytest.approx(20, abs=0.1)
    assert (off < 5).mean() > 0.05
    assert not np.allclose(first[:100], second[:100], atol=0.05)


@pytest.mark.parametrize(
    ("keys", "wrong"),
    [
        ("rings: 3, elevation_deg: [3, 1, 5]", "each elevation must be above"),
        ("rings: 4, elevation_deg: [1, 2, 3]", "give .lowest, highest., or 4"),
        ("rings: 256, columns: 36000", "9,216,000 beams; at most 300,000"),
        ("rings: 0", "it must be at least 1"),
        ("preset: velodyne-vlp17", "did you mean 'velodyne-vlp16'"),
        ("rate_hz: 10", "the nearest is"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(keys, wrong):
    with pytest.raises(WorldError, match=wrong) as caught:
        parse_world(f"{ROOM}    sensors: [{{lidar3d: top, {keys}}}]\n")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("preset", "rings", "lowest", "highest", "finest"),
    [
        ("velodyne-vlp16", 16, -15.0, 15.0, 2.0),
        ("velodyne-vlp32c", 32, -25.0, 15.0, 0.333),
        ("ouster-os0-128", 128, -45.0, 45.0, 90.0 / 127),
        ("ouster-os1-64", 64, -16.6, 16.6, 33.2 / 63),
        ("ouster-os1-128", 128, -22.5, 22.5, 45.0 / 127),
    ],
)
def test_a_turn_of_a_preset_looks_as_high_and_as_finely_as_its_data_sheet_says(preset, rings, lowest, highest, finest):
    text = f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], sensors: [{{lidar3d: top, preset: {preset}}}]}}]\n"
    (lidar,) = parse_world(text).robots[0].sensors
    elevations = np.sort(lidar.elevations_deg)
    assert len(elevations) == rings
    told = [elevations[0], elevations[-1], np.diff(elevations).min()]
    # A data sheet rounds to a thousandth of a degree.
    np.testing.assert_allclose(told, [lowest, highest, finest], atol=1e-3)
