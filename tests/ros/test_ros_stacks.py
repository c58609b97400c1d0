"""What Nav2 and slam_toolbox subscribe to, ask of frames and send, against what the bridge publishes and receives.

Facts of the default parameters and the sources of Nav2 (main, August 2026: nav2_bringup/params/nav2_params.yaml,
nav2_ros_common/qos_profiles.hpp) and slam_toolbox (ros2, March 2024: config/mapper_params_online_async.yaml,
src/laser_utils.cpp, lib/karto_sdk Karto.h `LaserRangeFinder::Update`); of TurtleBot 3, its burger.yaml of Nav2.
"""

import math
import re
from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

import mjsim
import mjsim.assets
from mjsim.bridge.bridge import TWIST_TYPES
from mjsim.errors import UsageError
from mjsim.interface import Observation
from mjsim.ros import COMMANDS, LATCHED, RELIABLE, SENSOR_DATA, Outgoing, RosTick, RosWorld
from mjsim.sim import Simulation
from tests.cli.shell import typed

pytest.importorskip("rosbags")

SENSOR, STANDARD, LATCHED_READER = (False, False), (True, False), (True, True)
"""Whether a subscription is reliable, and transient local."""
SUBSCRIPTIONS = {
    "/scan": ("sensor_msgs/msg/LaserScan", SENSOR),  # amcl, costmaps, collision_monitor, slam_toolbox
    "/odom": ("nav_msgs/msg/Odometry", STANDARD),  # bt_navigator, controller_server, velocity_smoother
    "/tf": ("tf2_msgs/msg/TFMessage", STANDARD),
    "/tf_static": ("tf2_msgs/msg/TFMessage", LATCHED_READER),
    "/clock": ("rosgraph_msgs/msg/Clock", SENSOR),
    "/map": ("nav_msgs/msg/OccupancyGrid", LATCHED_READER),  # amcl, the static layer of costmaps
}
ROBOT_FRAMES = {"odom", "base_link", "base_footprint"}
"""base_footprint: amcl, collision_monitor and slam_toolbox; base_link: costmaps, behaviors and bt_navigator."""
LAUNCH_FILE = Path(mjsim.assets.__file__).parent / "ros" / "nav2.launch.xml"
OFFERED = {"/map": ("nav_msgs/msg/OccupancyGrid", LATCHED)}


def sent(*, lidar: str = "beams: 36", namespaces: bool = False) -> list[Outgoing]:
    """Return what a robot with a lidar sends at its start."""
    world = mjsim.parse_world(
        f"mjsim: 1\nrobots: [{{name: scout, at: [0, 0], sensors: [{{lidar: laser, {lidar}}}]}}]\n"
    )
    with Simulation(world) as sim:
        ros, seen = RosWorld(world, dict(sim.robots), namespaces=namespaces), sim.sense("scout")
        assert isinstance(seen, Observation)
        tick = RosTick(time=0.0, truth=None, seen=seen, odometry=mjsim.Pose(0.0, 0.0, 0.0))
        return [ros.fixed(), *ros.messages(0.0, {"scout": tick}, {})]


@pytest.fixture(scope="module")
def messages() -> list[Outgoing]:
    return sent()


def test_topics_are_those_of_their_default_parameters_with_matching_quality(messages: list[Outgoing]):
    offered = OFFERED | {each.topic.name: (each.topic.type, each.topic.qos) for each in messages}
    for topic, (kind, (reliable, transient)) in SUBSCRIPTIONS.items():
        found, qos = offered[topic]
        assert found == kind
        # A reader gets nothing from a writer that promises less than it asks for.
        assert (qos.reliable >= reliable, qos.transient_local >= transient) == (True, True), topic
    assert SENSOR_DATA.reliable < RELIABLE.reliable


def test_the_tree_has_every_frame_that_they_ask_for_and_leaves_the_map_to_them(messages: list[Outgoing]):
    stamped = [each for sent in messages if "tf" in sent.topic.name for each in sent.message.transforms]
    parents = {each.child_frame_id: each.header.frame_id for each in stamped}
    assert len(parents) == len(stamped)  # each frame has one parent
    assert {*parents, *parents.values()} >= ROBOT_FRAMES
    assert "map" not in {*parents, *parents.values()}
    (scan,) = (each.message for each in messages if each.topic.name == "/scan")
    (odometry,) = (each.message for each in messages if each.topic.name == "/odom")
    assert parents[scan.header.frame_id] == odometry.child_frame_id == "base_link"
    assert parents["base_link"] == odometry.header.frame_id == "odom"


def test_base_footprint_is_below_the_robot_on_the_floor(messages: list[Outgoing]):
    (place,) = (each.transform for each in messages[0].message.transforms if each.child_frame_id == "base_footprint")
    assert (place.translation.x, place.translation.y, place.translation.z, place.rotation.w) == (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("lidar", ["beams: 36", "beams: 360", "beams: 1440, rotating: true", "beams: 9, fov_deg: 180"])
def test_slam_toolbox_expects_as_many_ranges_as_a_scan_has(lidar: str):
    (scan,) = (each.message for each in sent(lidar=lidar) if each.topic.name == "/scan")
    low, high, step = map(np.float32, (scan.angle_min, scan.angle_max, scan.angle_increment))
    apart = math.fabs(high - low)
    circle = abs(apart - 2 * math.pi) < step - np.finfo(np.float32).eps * 2 * math.pi
    if apart > 6.10865 and round(apart / float(step)) + 1 == len(scan.ranges):
        circle = False
    assert round((float(high) - float(low)) / float(step)) + (0 if circle else 1) == len(scan.ranges)


def test_commands_are_read_as_nav2_sends_them():
    assert not COMMANDS.reliable  # a reliable writer, as Nav2's, reaches it too
    assert set(TWIST_TYPES) == {"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"}


def test_with_namespaces_topics_begin_with_the_name_and_several_robots_need_them():
    assert {"/scout/scan", "/scout/odom"} <= {each.topic.name for each in sent(namespaces=True)}
    world = mjsim.parse_world("mjsim: 1\nrobots: [{name: a, at: [0, 0]}, {name: b, at: [2, 0]}]\n")
    with Simulation(world) as sim, pytest.raises(UsageError, match="has 2 robots; without namespaces it must have one"):
        RosWorld(world, dict(sim.robots), namespaces=False)


DECLARED = {
    "nav2_bringup": {"namespace", "slam", "map", "keepout_mask", "speed_mask", "graph", "use_sim_time", "params_file"}
    | {"autostart", "use_composition", "use_respawn", "log_level", "use_localization"}
    | {"use_keepout_zones", "use_speed_zones"},
    "slam_toolbox": {"use_sim_time", "slam_params_file", "autostart", "use_lifecycle_manager"},
}
"""Arguments of nav2_bringup/launch/bringup_launch.py and of slam_toolbox/launch/online_async_launch.py."""
ELEMENTS = {"launch": set(), "arg": {"name", "default", "value", "description"}, "group": {"if", "unless"}} | {
    "include": {"file"},
    "executable": {"name", "cmd", "output"},
}
"""Elements of ROS 2 launch files in XML, and their attributes."""


def test_the_launch_file_has_documented_elements_and_arguments_of_nav2_and_slam_toolbox():
    root = fromstring(LAUNCH_FILE.read_bytes())
    for element in root.iter():
        assert {*element.attrib} <= ELEMENTS[element.tag]
    own = {arg.get("name") for arg in root.findall("arg")}
    for include in root.iter("include"):
        package = re.search(r"find-pkg-share (\w+)", include.get("file"))[1]
        given = {arg.get("name"): arg.get("value") for arg in include}
        assert {*given} <= DECLARED[package]
        assert given["use_sim_time"] == "True"  # as Python has it: bringup_launch.py evaluates `slam`
    used = {name for element in root.iter() for value in element.attrib.values() for name in _used(value)}
    assert used == own


def test_the_launch_file_calls_the_bridge_as_it_is(capsys):
    (executable,) = fromstring(LAUNCH_FILE.read_bytes()).iter("executable")
    start = "$(var mjsim) bridge $(var world) "
    assert executable.get("cmd").startswith(start)
    code, _, said = typed("bridge", "none.yaml", *executable.get("cmd").removeprefix(start).split(), capsys=capsys)
    assert (code, "no file 'none.yaml'" in said, "option" in said.lower()) == (2, True, False)


def _used(text):
    return re.findall(r"\$\(var (\w+)\)", text)
