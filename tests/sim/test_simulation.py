import gc
import math
import weakref

import mujoco
import numpy as np
import pytest

from mjsim.errors import PhysicsFault, UsageError
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.world import parse_world

NOISE = "drive: {noise: {speed: 0.02, turn: 0.02}}, odometry: {noise: {distance: 0.01, turn: 0.02}}"
BOX = """
mjsim: 1
walls:
  - {points: [[-1.5, -2], [2, -2], [2, 1], [-1.5, 1]], closed: true, thickness: 0.1}
beacons:
  - {name: plate, at: [1.0, 0.0], heading_deg: 180, center: 0.3}
robots:
  - {name: r, at: [0.2, -0.3], heading_deg: %g, proximity_range: 1.7}
"""


def room(robots: str, *, run: str = "{}") -> Simulation:
    return Simulation(parse_world(f"mjsim: 1\nrobots:\n  - {{{robots}}}\nrun: {run}\n"))


@pytest.mark.parametrize("heading", [0.0, 30.0, -135.0, 179.9])
def test_a_robot_starts_where_the_world_says_and_stays_there_without_a_drop(heading):
    sim = room(f"name: r, at: [1.5, -2.5], heading_deg: {heading}")
    for _ in range(25):
        x, y, z = sim.data.body("r/base").xpos
        assert sim.truth("r").as_array() == pytest.approx([1.5, -2.5, math.radians(heading)], abs=1e-4)
        assert (x, y, z) == pytest.approx((1.5, -2.5, 0.0), abs=1e-5)
        sim.step()


def test_wheels_carry_more_of_a_robot_than_casters_and_together_they_carry_it_all():
    sim = room("name: r, at: [0, 0], body: {mass: 12}")
    for _ in range(25):
        sim.step()
    mujoco.mj_forward(sim.model, sim.data)
    wheels = [sim.model.body(f"r/wheel_{side}").id for side in ("left", "right")]
    force, load = np.zeros(6), {True: 0.0, False: 0.0}
    for k, pair in enumerate(sim.data.contact.geom):
        mujoco.mj_contactForce(sim.model, sim.data, k, force)
        load[bool(np.isin(sim.model.geom_bodyid[pair], wheels).any())] += force[0]
    assert load[True] + load[False] == pytest.approx(12 * 9.81, rel=0.01)
    assert load[True] > 2 * load[False]


def test_a_camera_looks_along_its_yaw_and_pitch_with_its_head_up():
    camera = "{camera: eye, at: [0.1, 0.05, 0.4], yaw_deg: 40, pitch_deg: 20, width: 640, height: 480, fov_deg: 60}"
    sim = room(f"name: r, at: [1, 2], heading_deg: 90, sensors: [{camera}]")
    view = sim.data.camera("r/eye")
    yaw, pitch = math.radians(90 + 40), math.radians(20)
    towards = [math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch)]
    np.testing.assert_allclose(-view.xmat.reshape(3, 3)[:, 2], towards, atol=1e-6)
    np.testing.assert_allclose(view.xpos, [1 - 0.05, 2 + 0.1, 0.4], atol=1e-5)
    assert view.xmat.reshape(3, 3)[2, 0] == pytest.approx(0.0, abs=1e-6)
    assert view.xmat.reshape(3, 3)[2, 1] > 0
    # Square pixels: heights are to widths as the tangents of half their angles.
    fovy = math.radians(float(sim.model.camera("r/eye").fovy[0]))
    assert math.tan(fovy / 2) / math.tan(math.radians(30)) == pytest.approx(480 / 640)


def test_time_goes_on_by_one_period_a_tick():
    sim = room("name: r, at: [0, 0]", run="{rate_hz: 12.5}")
    assert sim.dt == pytest.approx(0.08)
    for tick in range(4):
        assert sim.time == pytest.approx(tick * 0.08)
        assert sim.sense("r").time == sim.time
        assert sim.data.time == pytest.approx(sim.time)
        sim.step()


def test_what_is_sensed_is_computed_once_a_tick():
    sim = room("name: r, at: [0, 0]")
    assert sim.sense("r") is sim.sense("r")
    before = sim.sense("r")
    sim.step()
    assert sim.sense("r") is not before


def test_odometry_does_not_depend_on_who_looked_before():
    eager, lazy = room(f"name: r, at: [0, 0], {NOISE}"), room(f"name: r, at: [0, 0], {NOISE}")
    for _ in range(20):
        eager.sense("r")
        eager.step()
        lazy.step()
    assert eager.sense("r").odometry.forward == lazy.sense("r").odometry.forward


@pytest.mark.parametrize("heading", [0.0, 33.0, -100.0])
def test_the_ring_measures_the_free_distance_to_the_walls_of_a_box(heading):
    sim = Simulation(parse_world(BOX % heading))
    x, y = 0.2, -0.3
    expected = []
    for k in range(16):
        angle = math.radians(heading) + k * 2 * math.pi / 16
        c, s = math.cos(angle), math.sin(angle)
        # Inner faces of the walls lie half a thickness inside the centrelines.
        to_x = ((1.95 if c > 0 else -1.45) - x) / c if abs(c) > 1e-12 else math.inf
        to_y = ((0.95 if s > 0 else -1.95) - y) / s if abs(s) > 1e-12 else math.inf
        free = min(to_x, to_y) - 0.22
        expected.append(free if free <= 1.7 else math.inf)
    assert any(map(math.isinf, expected))
    np.testing.assert_allclose(sim.sense("r").proximity, expected, atol=1e-4)


def test_the_ring_sees_another_robot_between_both_rims():
    sim = Simulation(parse_world("mjsim: 1\nrobots:\n  - {name: a, at: [0, 0]}\n  - {name: b, at: [1, 0]}\n"))
    assert sim.sense("a").proximity[0] == pytest.approx(1 - 0.44, abs=1e-4)
    assert sim.sense("b").proximity[8] == pytest.approx(1 - 0.44, abs=1e-4)
    assert np.isinf(np.delete(sim.sense("a").proximity, 0)).all()


def bytes_of_a_run(seed: int) -> bytes:
    sim = Simulation(parse_world((BOX % 10).replace("proximity_range: 1.7", NOISE)), seed=seed)
    parts = []
    for tick in range(200):
        seen = sim.sense("r")
        parts += [
            seen.odometry.covariance,
            seen.proximity,
            np.array(seen.bump),
            sim.truth("r").as_array(),
            *sim.state(),
        ]
        parts.append(np.array([seen.odometry.forward, seen.odometry.left, seen.odometry.turn]))
        sim.apply("r", Command(0.5, turn=math.sin(tick / 20)))
        sim.step()
    return b"".join(part.tobytes() for part in parts)


@pytest.mark.slow
def test_one_seed_gives_the_same_bytes_and_another_gives_others():
    assert bytes_of_a_run(4) == bytes_of_a_run(4)
    assert bytes_of_a_run(4) != bytes_of_a_run(5)


@pytest.mark.parametrize("speed", [math.nan, 1e12, 1e5])
def test_an_explosion_is_noticed_at_its_time(speed, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    sim = room("name: r, at: [0, 0]")
    for _ in range(10):
        sim.step()
    sim.data.qvel[1] = speed
    with pytest.raises(PhysicsFault, match=r"^physics failed at 0.44 s: [^\n]+$"):
        sim.step()
    # MuJoCo would print the warning and leave a log beside the user's files.
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


def test_a_robot_or_seed_that_cannot_be_is_named():
    sim = room("name: scout, at: [0, 0]")
    for use in (sim.sense, sim.truth, lambda name: sim.apply(name, Command())):
        with pytest.raises(UsageError, match="no robot 'skout' in this world; did you mean 'scout'"):
            use("skout")
    for seed in (-1, 2**63, 1.5, "1"):
        with pytest.raises(UsageError, match=f"seed is {seed!r}; it must be a whole number from 0 to {2**63 - 1}"):
            Simulation(sim.world, seed=seed)


def test_modules_are_told_where_beacons_hang_only_when_the_map_is_known():
    text = """
mjsim: 1
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
beacons: [{name: lion, image: posters/lion.jpg, at: [3.9, 1], heading_deg: 180, width: 0.8, center: 1.3}]
robots: [{name: r, at: [1, 1], heading_deg: 90}]
run: {map: %s}
"""
    unknown, known = (Simulation(parse_world(text % word)) for word in ("unknown", "known"))
    assert unknown.map is None
    assert unknown.catalogue["lion"].pose is None
    lion = known.catalogue["lion"]
    assert (lion.pose.x, lion.pose.y, lion.pose.heading, lion.center) == pytest.approx((3.9, 1.0, math.pi, 1.3))
    assert lion.height == pytest.approx(0.8 * lion.picture.shape[0] / lion.picture.shape[1])
    # Four inner and four outer faces.
    assert known.map.segments.shape == (8, 2, 2)
    assert known.map.beacons["lion"] == lion.pose
    assert known.robots["r"].prior.as_array() == pytest.approx([1.0, 1.0, math.pi / 2])


def test_pictures_come_only_on_ticks_when_they_are_due():
    camera = "{camera: eye, at: [0.1, 0, 0.4], width: 64, height: 48, rate_hz: 5}"
    with room(f"name: r, at: [0, 0], sensors: [{camera}]") as sim:
        due = []
        for tick in range(11):
            if "eye" in sim.sense("r").cameras:
                due.append(tick)
                assert sim.sense("r").cameras["eye"].image.shape == (48, 64, 3)
            sim.step()
    assert due == [0, 5, 10]


def test_a_simulation_is_freed_with_its_last_reference():
    """Its model and pictures are megabytes: hundreds of runs in one process cannot wait for the garbage collector."""
    simulation = Simulation(parse_world(BOX % 0.0))
    simulation.step()
    simulation.sense("r")
    simulation.close()
    known = weakref.ref(simulation)
    gc.disable()
    try:
        del simulation
        assert known() is None
    finally:
        gc.enable()
