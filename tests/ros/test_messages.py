"""Each message of ROS, held to what its standard says of units, order, frames and what is unknown."""

import math

import numpy as np
import pytest

from mjsim.geometry import Pose, Pose3
from mjsim.interface import CameraFrame, CompassReading, ImuReading, JointState, PointCloud, Scan, SensorInfo
from mjsim.ros import messages
from mjsim.ros.ros_robot import RosTick
from mjsim.sim import Simulation
from mjsim.world import parse_world

pytest.importorskip("rosbags")


def sheet(**noise: float) -> SensorInfo:
    return SensorInfo(kind="any", robot_from_sensor=np.eye(4), rate_hz=12.5, noise=noise)


def seconds(header) -> float:
    return header.stamp.sec + 1e-9 * header.stamp.nanosec


def test_a_scan_has_its_first_beam_at_the_stamp_and_its_ends_and_rate():
    scan = Scan(
        stamp=2.0,
        ranges=np.array([1.0, np.inf, -np.inf, 4.0]),
        angle_min=-0.3,
        angle_increment=0.2,
        range_min=0.1,
        range_max=9.0,
        intensities=np.array([0.1, 0.0, 0.0, 0.4]),
        time_increment=0.01,
    )
    told = messages.laser_scan(scan, "lidar", sheet())
    # Its own stamp is that of the last beam.
    assert seconds(told.header) == pytest.approx(2.0 - 3 * 0.01)
    assert (told.angle_min, told.angle_max, told.angle_increment) == pytest.approx((-0.3, 0.3, 0.2))
    assert (told.time_increment, told.scan_time) == pytest.approx((0.01, 0.08))
    assert (told.range_min, told.range_max) == (0.1, 9.0)
    np.testing.assert_array_equal(told.ranges, scan.ranges.astype(np.float32))
    np.testing.assert_array_equal(told.intensities, scan.intensities.astype(np.float32))
    assert told.header.frame_id == "lidar"


def test_an_inertial_reading_has_variances_of_its_data_sheet_and_says_what_it_does_not_measure():
    reading = ImuReading(1.5, np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]), "imu")
    told = messages.imu(reading, "imu", sheet(acceleration=0.2, turn=0.05))
    vectors = told.linear_acceleration, told.angular_velocity
    assert [(each.x, each.y, each.z) for each in vectors] == [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)]
    np.testing.assert_allclose(told.linear_acceleration_covariance, np.diag([0.04] * 3).ravel())
    np.testing.assert_allclose(told.angular_velocity_covariance, np.diag([0.0025] * 3).ravel())
    assert told.orientation_covariance[0] == -1.0
    gyroscope = messages.imu(ImuReading(1.5, np.full(3, np.nan), reading.turn, "imu"), "imu", sheet(turn=0.05))
    assert gyroscope.linear_acceleration_covariance[0] == -1.0
    assert gyroscope.linear_acceleration.x == 0.0
    assert gyroscope.angular_velocity.z == 6.0


def test_a_heading_is_a_turn_about_z_and_nothing_else():
    told = messages.heading(CompassReading(1.0, 0.8, 0.01), "compass", sheet())
    turned = told.orientation
    planar = Pose3(0.0, 0.0, 0.0, turned.x, turned.y, turned.z, turned.w).planar()
    assert planar.heading == pytest.approx(0.8)
    covariance = np.reshape(told.orientation_covariance, (3, 3))
    assert covariance[2, 2] == 0.01
    assert min(covariance[0, 0], covariance[1, 1]) > 1.0
    assert told.angular_velocity_covariance[0] == told.linear_acceleration_covariance[0] == -1.0


def test_planar_covariances_stand_at_x_y_and_yaw_of_space():
    root = np.random.default_rng(1).normal(size=(3, 3))
    P, Q = root @ root.T, root.T @ root
    told = messages.odometry(2.0, ("odom", "base"), Pose(1.0, 2.0, 0.3), P, np.array([0.5, 0.1, -0.2]), Q)
    rows = np.ix_([0, 1, 5], [0, 1, 5])
    for part, expected in ((told.pose, P), (told.twist, Q)):
        whole = np.reshape(part.covariance, (6, 6))
        np.testing.assert_allclose(whole[rows], expected, atol=1e-8)
        assert np.linalg.eigvalsh(whole).min() > 0.0
    assert (told.twist.twist.linear.x, told.twist.twist.linear.y, told.twist.twist.angular.z) == (0.5, 0.1, -0.2)
    assert (told.header.frame_id, told.child_frame_id) == ("odom", "base")
    uncertain = messages.uncertain_pose(2.0, "map", Pose(1.0, 2.0, 0.3), P)
    np.testing.assert_allclose(np.reshape(uncertain.pose.covariance, (6, 6))[rows], P, atol=1e-8)


def test_states_of_entities_and_joints_keep_the_order_of_their_numbers():
    told = messages.entity_state(1.0, "map", Pose3.from_planar(Pose(1.0, 2.0, 0.5)), np.array([0.1, 0.2, 0.3]))
    assert (told.twist.linear.x, told.twist.linear.y, told.twist.angular.z) == (0.1, 0.2, 0.3)
    assert (told.pose.position.x, told.pose.position.y) == (1.0, 2.0)
    joints = messages.joint_state(["a", "b"], JointState(2.0, np.array([1, 2]), np.array([3, 4]), np.array([5, 6])))
    assert (joints.name, seconds(joints.header)) == (["a", "b"], 2.0)
    assert [each.tolist() for each in (joints.position, joints.velocity, joints.effort)] == [[1, 2], [3, 4], [5, 6]]


def test_pictures_are_rows_of_bytes_and_depth_is_metres_or_millimetres():
    image = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    told = messages.picture(1.0, "eye", image)
    assert (told.height, told.width, told.step, told.encoding, told.is_bigendian) == (2, 4, 12, "rgb8", 0)
    assert told.data.tobytes() == image.tobytes()
    for depth, encoding in ((image[..., 0] * np.uint16(300), "16UC1"), (image[..., 0] * 0.1, "32FC1")):
        told = messages.depth_picture(1.0, "eye", depth)
        kind = "<u2" if encoding == "16UC1" else "<f4"
        assert (told.height, told.width, told.step, told.encoding) == (2, 4, 4 * np.dtype(kind).itemsize, encoding)
        np.testing.assert_allclose(np.frombuffer(told.data, kind).reshape(2, 4), depth, rtol=1e-6)


def test_a_map_is_100_where_it_is_occupied_0_where_it_is_free_and_minus_1_elsewhere_row_by_row():
    occupied, free = np.array([[1, 0, 0], [0, 0, 1]], dtype=bool), np.array([[1, 1, 0], [0, 0, 0]], dtype=bool)
    told = messages.grid_map(occupied, free, resolution=0.05, map_from_grid=Pose(-1.0, 2.0, 0.0))
    assert told.data.tolist() == [100, 0, -1, -1, -1, 100]
    assert (told.info.width, told.info.height, told.info.resolution) == (3, 2, pytest.approx(0.05))
    assert (told.info.origin.position.x, told.info.origin.position.y) == (-1.0, 2.0)


ROBOT = """mjsim: 1
robots:
  - name: r
    at: [0, 0]
    body: {radius: 0.3, height: 0.4}
    sensors: [{lidar: scan}, {lidar: second}, {imu: imu}]
"""


@pytest.fixture(scope="module")
def robot():
    from mjsim.ros import RosWorld

    world = parse_world(ROBOT)
    with Simulation(world) as sim:
        for _ in range(2):
            sim.step()
        yield RosWorld(world, dict(sim.robots)).robots["r"], sim.sense("r"), world


def test_rays_of_proximity_begin_at_the_rim_and_point_away(robot):
    frames = robot[0].fixed()
    for number in range(16):
        pose, angle = frames["base_link", f"proximity_{number}"], number * math.tau / 16
        np.testing.assert_allclose((pose.x, pose.y), 0.3 * np.array([math.cos(angle), math.sin(angle)]), atol=1e-9)
        assert math.remainder(pose.planar().heading - angle, math.tau) == pytest.approx(0.0, abs=1e-9)
        assert 0.0 < pose.z < 0.4


def test_a_tick_gives_the_twist_of_its_motion_and_the_first_sensor_of_a_kind_the_short_topic(robot):
    ros, seen, world = robot
    P = np.diag([0.1, 0.2, 0.3])
    tick = RosTick(time=seen.time, truth=None, seen=seen, odometry=Pose(1.0, 2.0, 0.5), odometry_covariance=P)
    sent = [*ros.messages(tick)]
    topics = [each.topic.name for each in sent]
    assert {"/r/odom", "/r/scan", "/r/second/scan", "/r/imu", "/r/proximity"} == set(topics)
    odometry = sent[topics.index("/r/odom")].message
    moved, dt = seen.odometry, seen.dt
    twist = odometry.twist.twist
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == pytest.approx(
        (moved.forward / dt, moved.left / dt, moved.turn / dt)
    )
    rows = np.ix_([0, 1, 5], [0, 1, 5])
    np.testing.assert_allclose(np.reshape(odometry.twist.covariance, (6, 6))[rows], moved.covariance / dt**2, atol=2e-9)
    rings = [each.message for each in sent if each.topic.name == "/r/proximity"]
    assert [each.header.frame_id for each in rings] == [f"proximity_{number}" for number in range(16)]
    assert [each.range for each in rings] == pytest.approx(seen.proximity.tolist())
    assert {each.max_range for each in rings} == {world.robots[0].proximity_range}
    assert not [*ros.messages(RosTick(time=0.0, truth=None))]
    bare = [*ros.messages(RosTick(time=1.0, truth=Pose3.from_planar(Pose(1.0, 2.0, 0.5))))]
    assert [(each.topic.name, each.message.header.frame_id) for each in bare] == [("/r/truth", "map")]


CAMERA = """mjsim: 1
robots:
  - name: r
    at: [0, 0]
    sensors:
      - {camera: eye, width: 20, height: 16, depth: true, lens: {brown: [0.1, 0.02, 0, 0]}}
      - {lidar3d: top, rings: 2}
"""


def test_a_picture_its_depth_and_its_calibration_come_together_at_their_own_times():
    from mjsim.ros import RosWorld

    world = parse_world(CAMERA)
    with Simulation(world) as sim:
        robot, info = RosWorld(world, dict(sim.robots)).robots["r"], sim.robots["r"]
    camera = info.sensors["eye"].intrinsics
    image, depth = np.zeros((16, 20, 3), np.uint8), np.arange(320.0).reshape(16, 20)
    for taken, when in ((None, 2.0), (1.5, 1.5)):
        frame = CameraFrame(2.0, image, camera, depth, depth_stamp=taken)
        sent = {each.topic.name: each.message for each in robot.pictures("eye", frame)}
        assert set(sent) == {"/r/eye/image_raw", "/r/eye/depth/image_raw", "/r/eye/camera_info"}
        assert [seconds(each.header) for each in sent.values()] == [2.0, when, 2.0]
        assert {each.header.frame_id for each in sent.values()} == {"eye_optical_frame"}
    about = sent["/r/eye/camera_info"]
    assert (about.width, about.height, about.distortion_model) == (20, 16, "plumb_bob")
    np.testing.assert_array_equal(np.reshape(about.k, (3, 3)), camera.matrix())
    np.testing.assert_array_equal(np.reshape(about.p, (3, 4)), np.hstack([camera.matrix(), np.zeros((3, 1))]))
    np.testing.assert_array_equal(np.reshape(about.r, (3, 3)), np.eye(3))
    assert about.d.tolist() == [0.1, 0.02, 0.0, 0.0, 0.0]
    packed = {each.topic.name: each.message for each in robot.compressed("eye", 3.0, b"abc", "png", depth=(2.9, depth))}
    picture = packed["/r/eye/image_raw/compressed"]
    assert (picture.format, picture.data.tobytes(), seconds(picture.header)) == ("png", b"abc", 3.0)
    assert [seconds(packed[f"/r/eye/{word}"].header) for word in ("depth/image_raw", "camera_info")] == [2.9, 3.0]


def test_a_cloud_is_one_row_of_points_with_its_fields_where_it_says():
    points = np.arange(6, dtype=np.float32).reshape(2, 3)
    two = np.array([0.25, 0.5], dtype=np.float32)
    told = messages.point_cloud(PointCloud(1.5, points, -two, two, np.array([3, 9], dtype=np.uint16)), "top", sheet())
    assert (told.height, told.width, told.row_step, told.is_dense, told.is_bigendian) == (1, 2, 44, True, False)
    kinds = {7: "<f4", 4: "<u2"}
    for field, values in zip(told.fields, [*points.T, two, -two, [3, 9]], strict=True):
        read = [np.frombuffer(told.data, kinds[field.datatype], 1, told.point_step * k + field.offset) for k in (0, 1)]
        np.testing.assert_array_equal(np.ravel(read), values, err_msg=field.name)
    assert [field.name for field in told.fields] == ["x", "y", "z", "intensity", "time", "ring"]
    assert (seconds(told.header), told.header.frame_id) == (1.5, "top")
