"""Sensors that arms carry, and what other robots see of arms."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.errors import WorldError
from mjsim.geometry import Pose
from mjsim.world import parse_world
from tests.sim.devices import device_of

POSTURE = np.radians([30.0, 50.0, -130.0, 20.0, -60.0, 40.0])


def world(sensor, more="", tool="tool: {at: [0, 0, 0.1], rpy_deg: [0, 0, 90]}"):
    return parse_world(
        "mjsim: 1\nwalls: [{points: [[-4, -4], [4, -4], [4, 4], [-4, 4]], closed: true, height: 3}]\n"
        f"robots:\n  - {{name: r, base: fixed, at: [1, -1], heading_deg: 90, sensors: [{sensor}],"
        f" arms: [{{preset: puma560, {tool}}}]}}\n{more}",
        file="w.yaml",
    )


def moved(sim):
    """Put the arm into a posture; return world_from_robot and the arm."""
    sim.data.qpos[:6] = POSTURE
    mujoco.mj_forward(sim.model, sim.data)
    return np.array([[0, -1, 0, 1], [1, 0, 0, -1], [0, 0, 1, 0], [0, 0, 0, 1.0]]), sim.world.robots[0].arms[0].arm


def test_a_camera_on_the_tool_looks_from_where_the_chain_has_it():
    with mjsim.Simulation(world("{camera: hand, on: arm/tool, at: [0.06, 0, 0.02], yaw_deg: 90}")) as sim:
        world_from_robot, arm = moved(sim)
        pose = world_from_robot @ arm.fkine(POSTURE)
        camera = sim.data.camera("r/hand")
        np.testing.assert_allclose(camera.xpos, (pose @ [0.06, 0, 0.02, 1])[:3], atol=1e-12)
        # It looks to the left of the tool, y, with its upper side along z.
        axes = camera.xmat.reshape(3, 3)
        np.testing.assert_allclose(-axes[:, 2], pose[:3, 1], atol=1e-12)
        np.testing.assert_allclose(axes[:, 1], pose[:3, 2], atol=1e-12)
        told = sim.robots["r"].sensors["hand"].robot_from_sensor
        np.testing.assert_allclose(told[:3, 3], (arm.fkine(np.zeros(6)) @ [0.06, 0, 0.02, 1])[:3], atol=1e-12)


@pytest.mark.parametrize("part", ["link1", "link3", "tool"])
def test_a_lidar_on_an_arm_measures_from_there(part):
    keys = "at: [0.3, 0, 0.1], yaw_deg: 20, pitch_deg: 10, beams: 30, fov_deg: 300"
    tool = "tool: {at: [0, 0.05, 0.1], rpy_deg: [20, 30, 90]}"

    def placed(q: np.ndarray) -> np.ndarray:
        posture = arm.posture(q)
        return posture.tool if part == "tool" else posture.links[int(part[-1]) - 1]

    with mjsim.Simulation(world(f"{{lidar: scan, on: arm/{part}, {keys}}}", tool=tool)) as sim:
        world_from_robot, arm = moved(sim)
        pose, mount = world_from_robot @ placed(POSTURE), np.eye(4)
        mount[:3, :3], mount[:3, 3] = Rotation.from_euler("ZY", [20, -10], degrees=True).as_matrix(), [0.3, 0, 0.1]
        scan = sim.sense("r").scans["scan"]
        told = sim.robots["r"].sensors["scan"].robot_from_sensor
    np.testing.assert_allclose(told, placed(np.zeros(6)) @ mount, atol=1e-12)
    start, turned = (pose @ mount)[:3, 3], (pose @ mount)[:3, :3]
    rays = np.stack([np.cos(scan.angles()), np.sin(scan.angles()), 0 * scan.angles()], axis=1) @ turned.T
    # The inner faces of the walls, and the floor.
    faces = np.array([[-3.95, -3.95, 0.0], [3.95, 3.95, np.inf]])
    ways = np.where(rays < 0.0, (faces[0] - start) / rays, (faces[1] - start) / rays)
    distances = ways.min(axis=1)
    heights = start[2] + distances * rays[:, 2]
    expected = np.where((heights < 3.0) & (distances < scan.range_max), distances, np.inf)
    assert 5 < np.isfinite(expected).sum() < 30
    np.testing.assert_allclose(scan.ranges, expected, atol=1e-6)


SPINNER = "arms: [{dh: {rows: [{a: 0.5}, {a: 0.2, alpha_deg: 90}]}, at: [0, 0, 1]}]"


def spun(sensor):
    """Return the readings of an inertial sensor on an upright axis that turns at 2 rad/s."""
    here = parse_world(f"mjsim: 1\nrobots: [{{name: r, base: fixed, at: [0, 0], sensors: [{sensor}], {SPINNER}}}]")
    with mjsim.Simulation(here) as sim:
        resting = sim.sense("r").imu
        for tick in range(60):
            goal = mjsim.JointGoal(positions=(0.08 * tick, 0.0), velocities=(2.0, 0.0))
            sim.apply("r", mjsim.Command(joints={"arm": goal}))
            sim.step()
        return sim.robots["r"].sensors["feel"], resting, sim.sense("r").imu


@pytest.mark.slow
def test_an_inertial_sensor_on_a_tool_feels_gravity_and_the_circle_it_goes():
    info, _, moving = spun("{imu: feel, on: arm/tool, at: [0.1, 0, 0]}")
    # The tool's y axis is up. 0.8 m from the axis at 2 rad/s: 3.2 m/s^2 inwards.
    np.testing.assert_allclose(moving[-1].acceleration, [-0.8 * 4, 9.81, 0.0], atol=0.02)
    np.testing.assert_allclose(moving[-1].turn, [0.0, 2.0, 0.0], atol=0.005)
    np.testing.assert_allclose(info.robot_from_sensor[:3, 3], [0.8, 0, 1.0], atol=1e-12)


@pytest.mark.parametrize(
    ("mount", "turn", "force"),
    [
        # The tool's y axis is up. 0.8 m from the axis at 2 rad/s: 3.2 m/s^2 inwards.
        ("on: arm/tool, at: [0.1, 0, 0]", [0.0, 2.0, 0.0], [-0.8 * 4, 9.81, 0.0]),
        # Its x axis is the link's y axis; the circle of 0.5 m pulls along the link, to its left.
        ("on: arm/link1, at: [0, 0, 0], yaw_deg: 90", [0.0, 0.0, 2.0], [0.0, 0.5 * 4, 9.81]),
    ],
)
def test_an_inertial_sensor_on_an_arm_that_turns_evenly_feels_gravity_and_its_circle(mount, turn, force):
    robot = f"{{name: r, base: fixed, at: [0, 0], sensors: [{{imu: feel, {mount}, rate_hz: 250}}], {SPINNER}}}"
    with mjsim.Simulation(parse_world(f"mjsim: 1\nrobots: [{robot}]")) as sim:
        device = device_of(sim)
        for step in range(21):
            sim.data.qpos[0], sim.data.qvel[0] = 0.3 + 2.0 * 0.004 * step, 2.0
            device.after_step()
        readings = device.take(0.084)[1:]
    np.testing.assert_allclose([reading.turn for reading in readings], [turn] * 20, atol=1e-9)
    # Over the 8 mrad of a step, the mean direction of a force is short by 1e-5 of it.
    np.testing.assert_allclose([reading.acceleration for reading in readings], [force] * 20, atol=2e-4)


def test_another_robots_lidar_meets_an_arm_that_hangs_before_it():
    more = (
        "  - {name: s, preset: pioneer3dx, at: [1, 1], heading_deg: -90, sensors: [{lidar: scan, at: [0, 0, 0.5]}]}\n"
    )
    here = world("", more, tool="at: [0, 0, 0]")
    with mjsim.Simulation(here) as sim:
        ahead = sim.sense("s").scans["scan"].ranges[89:91]
        # The column of the Puma, 2 m ahead, has a radius of 4 % of all a and d.
        radius = here.robots[0].arms[0].arm.links[0].radius
        np.testing.assert_allclose(ahead, 2.0 - radius, atol=0.01)


@pytest.mark.parametrize(
    ("sentence", "sensor"),
    [
        ("no part 'arm/link7' of an arm of this robot; did you mean 'arm/link6'?", "{camera: c, on: arm/link7}"),
        ("no part 'arm/tol' of an arm of this robot; did you mean 'arm/tool'?", "{imu: i, on: arm/tol}"),
        ("a sensor 'beacons' is on the body of a robot, not on its arms; leave out 'on'", "{beacons: b, on: arm/tool}"),
        ("a sensor 'uwb' is on the body of a robot, not on its arms; leave out 'on'", "{uwb: u, on: arm/tool}"),
        (
            "a sensor 'encoders' is on the body of a robot, not on its arms; leave out 'on'",
            "{encoders: e, on: arm/tool}",
        ),
        ("on is 'arm'; it must be ARM/link1 and so on, or ARM/tool", "{camera: c, on: arm}"),
    ],
)
def test_a_sensor_on_what_is_not_there_is_refused(sentence, sensor):
    with pytest.raises(WorldError) as caught:
        world(sensor)
    assert str(caught.value).endswith(sentence)
    assert str(caught.value).startswith("w.yaml:4:")


def test_a_fixed_robot_has_a_footprint_that_others_keep_clear_of():
    with mjsim.Simulation(world("")) as sim:
        assert sim.truth("r") == Pose(1.0, -1.0, pytest.approx(np.pi / 2))
        assert sim.robots["r"].radius == 0.05
