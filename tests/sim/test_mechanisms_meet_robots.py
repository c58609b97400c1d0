"""Robots and mechanisms meet: they bump into each other, ride on each other, and sensors see what moves."""

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.run import drivers_of

WORLDS = Path(mjsim.__file__).parent.parent / "worlds" / "mechanisms"
GATE = """
mjsim: 1
mechanisms:
  - name: gate
    at: [3, 0]
    elevation: 0.3
    mode: %s
    bodies: [{name: plate, box: [0.1, 2, 0.6], mass: 20, color: "#0000ff"}]
    joints: [{prismatic: s, of: [ground, plate], axis: [1, 0, 0]%s}]
    actuators: [%s]
robots:
  - name: scout
    preset: pioneer3dx
    at: [0, 0]
    sensors:
      - {lidar: scan, at: [0, 0, 0.3], beams: 3, fov_deg: 4, range: [0.05, 10], rate_hz: 12.5}
      - {camera: eye, at: [0, 0, 0.3], width: 64, height: 48, rate_hz: 12.5}
"""
MOVING = GATE % ("kinematics", "", "{position: s, signal: {sine: {amplitude: 0.5, frequency_hz: 0.5}}}")


def run(world, seconds, **drivers):
    """Run a world; return the recording's truth of scout (z too), joints of its mechanism, and events."""
    if isinstance(world, str):
        world = mjsim.load_world(WORLDS / f"{world}.yaml")
    driving = drivers or drivers_of(world)
    rows, bumps = [], []
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, driving):
            bumps += [tick.seen["scout"].bump] if len(tick.seen["scout"].bump) else []
            joints = tick.joints[world.mechanisms[0].name]
            rows.append([tick.time, *sim.pose("scout")[:3, 3], *joints.positions])
            if tick.time >= seconds - 1e-9:
                break
    return np.array(rows), bumps


class Ahead:
    """Drives straight on."""

    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return mjsim.Command(forward=0.4)


@pytest.mark.slow
def test_a_lidar_sees_a_mechanism_where_it_is_while_it_moves():
    with mjsim.Simulation(mjsim.parse_world(MOVING)) as sim:
        for _ in range(40):
            scans = sim.sense("scout").scans
            if "scan" in scans:
                face = 3 + 0.5 * math.sin(math.pi * sim.time) - 0.05
                assert scans["scan"].ranges[1] == pytest.approx(face, abs=0.03)
            sim.step()
    assert face < 2.6  # it came nearer


@pytest.mark.slow
def test_a_camera_sees_a_mechanism_grow_as_it_comes_nearer():
    shares = []
    with mjsim.Simulation(mjsim.parse_world(MOVING)) as sim:
        for _ in range(40):
            cameras = sim.sense("scout").cameras
            if "eye" in cameras:
                red, _, blue = np.moveaxis(cameras["eye"].image.astype(int), -1, 0)
                width = (blue > 60 + 2 * red).any(axis=0).sum()
                shares.append((width, 3 + 0.5 * math.sin(math.pi * cameras["eye"].stamp) - 0.05))
            sim.step()
    widths, faces = np.array(shares).T
    focal = 32 / math.tan(math.radians(30))
    np.testing.assert_allclose(widths, np.minimum(2 * focal / faces, 64), atol=2)
    assert np.ptp(widths) > 8


@pytest.mark.slow
def test_a_robot_bumps_into_a_mechanism_that_stands_and_is_stopped():
    world = mjsim.parse_world(GATE % ("forward", ", friction: 1000", ""))
    rows, bumps = run(world, 8, scout=mjsim.Driver(navigator=Ahead()))
    assert bumps
    assert bumps[0][0] == pytest.approx(0.0, abs=0.2)
    assert rows[-1, 1] < 3 - 0.05 - 0.2
    assert abs(rows[-1, 4]) < 1e-3


@pytest.mark.slow
def test_a_robot_turns_a_turnstile_by_about_a_third_and_passes():
    rows, _ = run("turnstile", 12)
    assert rows[-1, 1] > 6.8
    assert math.degrees(np.ptp(rows[:, 4])) == pytest.approx(120, abs=50)


@pytest.mark.slow
def test_a_seesaw_tips_where_the_moments_of_robot_and_board_are_equal():
    world = mjsim.load_world(WORLDS / "seesaw.yaml")
    rows, bumps = run("seesaw", 12)
    model = mjsim.compile_world(world).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    base = model.body("scout/base").id
    weight, ahead = model.body_subtreemass[base], data.subtree_com[base][0] - data.xpos[base][0]
    tilt = np.degrees(rows[:, 4])
    leaves = rows[np.flatnonzero(tilt > -3.55)[0], 1]
    # While the board turns by the first 0.05 degrees, 9e-4 rad, the robot goes on for a tenth of a second.
    assert 0.0 < leaves + ahead - 4.5 - 12 * 0.1 / weight < 0.1
    assert tilt.max() == pytest.approx(3.6, abs=0.05)
    assert rows[-1, 1] > 7.5
    assert rows[:, 3].max() == pytest.approx(0.132, abs=0.03)
    assert not bumps


@pytest.mark.slow
def test_a_scissor_lift_raises_a_robot_by_the_sine_of_its_angle():
    rows, bumps = run("scissor_lift", 27)
    low, high = (rows[np.searchsorted(rows[:, 0], time), 3] for time in (10.6, 23.0))
    rise = 1.2 * (math.sin(math.radians(33)) - math.sin(math.radians(3)))
    assert high - low == pytest.approx(rise, abs=0.002)
    assert rows[-1, 3] == pytest.approx(0.73, abs=0.005)  # on the gallery
    assert not bumps
