import re

import numpy as np
import pytest

import mjsim
from mjsim.bridge import Bridge, Bus, domain_id
from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.interface import JointState
from mjsim.ros import RosWorld, messages, plain_names

ARM = """mjsim: 1
robots:
  - name: up6
    base: fixed
    at: [2, 1]
    arms: [{name: arm, preset: puma560}]
    sensors: [{camera: hand, on: arm/tool}, {camera: elbow, on: arm/link2}]
"""


def world_of(text: str) -> RosWorld:
    world = mjsim.parse_world(text)
    with mjsim.Simulation(world) as sim:
        return RosWorld(world, dict(sim.robots))


def test_names_become_those_that_ros_allows():
    names = ["scout", "7.tip-top", "left-eye", "_x"]
    assert list(plain_names(names, of="robots").values()) == ["scout", "x7_tip_top", "left_eye", "_x"]


def test_letters_of_other_scripts_are_spelled_by_their_numbers_and_that_is_said(capsys):
    plain = plain_names(["机器人", "Küche", "scout"], of="robots")
    assert list(plain.values()) == ["u673A_u5668_u4EBA_", "Ku00FC_che", "scout"]
    read_back = [re.sub("u([0-9A-F]{4,6})_", lambda found: chr(int(found[1], 16)), word) for word in plain.values()]
    assert read_back == list(plain)
    assert capsys.readouterr().err == (
        "mjsim: names in ROS are ASCII; of robots, '机器人' is 'u673A_u5668_u4EBA_', 'Küche' is 'Ku00FC_che'\n"
    )


def test_names_that_become_the_same_are_refused():
    with pytest.raises(UsageError, match="robots 'a-b' and 'a_b' are both 'a_b' in ROS; rename one of them"):
        plain_names(["a-b", "a_b"], of="robots")


def test_a_sensor_that_is_called_as_a_frame_of_the_robot_is_refused():
    text = "mjsim: 1\nrobots: [{name: a, at: [0, 0], sensors: [{lidar: odom}]}]\n"
    with pytest.raises(UsageError, match="robot 'a' has a sensor whose frame in ROS is 'odom'; rename it"):
        world_of(text)


def test_frames_of_a_single_robot_have_no_prefix_those_of_several_do():
    one = "mjsim: 1\nrobots: [{name: a, at: [0, 0], sensors: [{lidar: scan}]}]\n"
    two = one.replace("]}]", "]}, {name: b, at: [2, 2]}]")
    for text, base in ((one, "base_link"), (two, "a/base_link")):
        first = world_of(text).fixed().message.transforms[0]
        assert (first.header.frame_id, first.child_frame_id) == (base, base.replace("base_link", "scan"))


def test_a_sensor_on_an_arm_moves_with_its_joints():
    world = mjsim.parse_world(ARM)
    with mjsim.Simulation(world) as sim:
        ros, seen, arm = RosWorld(world, dict(sim.robots)), sim.sense("up6"), sim.robots["up6"].arms["arm"].model
        frames = ros.robots["up6"]._frames
        start = frames.moving(Pose(0, 0, 0), None, seen.joints)
        for name in ("hand", "elbow"):
            mounted = sim.robots["up6"].sensors[name].robot_from_sensor
            np.testing.assert_allclose(start["base_link", f"{name}_optical_frame"].matrix(), mounted, atol=1e-9)
        q = seen.joints["arm"].positions + np.array([0.3, -0.2, 0.4, 0.1, 0.2, -0.3])
        moved = frames.moving(Pose(0, 0, 0), None, {"arm": JointState(0.0, q, q * 0, q * 0)})
        hand = sim.robots["up6"].sensors["hand"].robot_from_sensor
        expected = arm.fkine(q) @ np.linalg.inv(arm.fkine(seen.joints["arm"].positions)) @ hand
        np.testing.assert_allclose(moved["base_link", "hand_optical_frame"].matrix(), expected, atol=1e-9)
        assert ("base_link", "hand_optical_frame") not in frames.fixed()


def test_map_odom_and_base_link_chain_to_the_estimate():
    text = "mjsim: 1\nrobots: [{name: a, at: [0, 0]}]\n"
    odometry, estimate = Pose(1.0, 2.0, 0.5), Pose(1.2, 1.9, 0.4)
    poses = world_of(text).robots["a"]._frames.moving(odometry, estimate, {})
    chained = poses["map", "odom"].matrix() @ poses["odom", "base_link"].matrix()
    np.testing.assert_allclose(chained, Pose3.from_planar(estimate).matrix(), atol=1e-12)


@pytest.mark.parametrize("word", ["x", "-1", "233", "1.5"])
def test_an_invalid_domain_is_a_one_line_error(monkeypatch: pytest.MonkeyPatch, word: str):
    monkeypatch.setenv("ROS_DOMAIN_ID", word)
    with pytest.raises(UsageError, match=f"ROS_DOMAIN_ID is '{word}'; it must be a whole number from 0 to 232"):
        domain_id()


def test_the_domain_is_0_unless_it_is_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    assert domain_id() == 0
    monkeypatch.setenv("ROS_DOMAIN_ID", " 42 ")
    assert domain_id() == 42


def test_an_interface_that_is_not_there_is_one_line():
    with pytest.raises(UsageError, match="no network interface or IPv4 address 'loo'; did you mean 'lo'"):
        Bus(domain=0, interface="loo")


def test_a_watchdog_that_never_lets_go_is_refused():
    with pytest.raises(UsageError, match="watchdog is 0 s; it must be above 0"):
        Bridge(mjsim.parse_world("mjsim: 1\nrobots: [{name: a, at: [0, 0]}]\n"), watchdog=0.0)


def test_times_are_whole_nanoseconds_and_divided_at_a_second():
    stamp = messages.clock(3.25).clock
    assert (stamp.sec, stamp.nanosec) == (3, 250_000_000)
    stamp = messages.clock(2.9999999999).clock
    assert (stamp.sec, stamp.nanosec) == (3, 0)
    assert messages.nanoseconds(0.1 + 0.2) == 300_000_000
