"""What a robot from a file stands on, casters of the file and those that it lacks, and where its lidar looks."""

import re

import pytest

from mjsim import UsageError
from mjsim.exchange import RobotOptions, bring_robot
from mjsim.exchange.robots.driven_wheels import find_gear
from mjsim.exchange.robots.import_robot import moved_sideways
from mjsim.exchange.robots.mounts import find_mounts
from mjsim.exchange.robots.preset import Plan, first_plan, speed_source
from mjsim.exchange.robots.robot_frame import find_stand
from mjsim.models import anatomy_of, drives_in_parameters, gather_robot
from tests.exchange.odd_robots import box, joint, robot, tyre

BASE = box("0.5 0.4 0.2", mass=40.0, at="0 0 0.16")
SPECK = '<collision><origin xyz="0 0 -0.1"/><geometry><box size="0.001 0.001 0.001"/></geometry></collision>'


SCANNER = """<gazebo reference="scanner"><sensor name="scan" type="gpu_lidar"><lidar><scan><horizontal>
  <samples>{}</samples><min_angle>{}</min_angle><max_angle>{}</max_angle></horizontal></scan></lidar></sensor></gazebo>"""


def plan_of(links: dict[str, str], joints: list[str], limit: str = "", more: str = "") -> Plan:
    """Return the preset of a robot on two wheels with other parts."""
    wheels = {"l": tyre(0.1, 0.03), "r": tyre(0.1, 0.03)}
    places = [("left", "l", 0.25), ("right", "r", -0.25)]
    held = [joint(name, "base", wheel, f'xyz="0 {y} 0.1"', more=limit) for name, wheel, y in places]
    text = robot({"base": BASE, **wheels, **links}, [*held, *joints, more]).encode()
    files = gather_robot("r.urdf", lambda _: text)
    found = anatomy_of(files)
    gear = find_gear(found, RobotOptions(), file="r.urdf", urdf=True)
    stand = find_stand(found, gear, acceleration=1.0)
    return first_plan("r", "r.urdf", gear, stand, find_mounts(found, stand, files.sensors)[0])


def test_a_box_of_a_millimetre_marks_a_frame_and_carries_nothing():
    mark = joint("mark", "base", "footprint", 'xyz="0 0 0.1"', kind="fixed")
    assert [caster[:2] for caster in plan_of({"footprint": SPECK}, [mark]).stand.casters] == [(0.2, 0.0), (-0.2, 0.0)]


def test_a_caster_that_a_file_lacks_stands_below_the_base_not_below_an_arm():
    hold = joint("shoulder", "base", "arm", 'xyz="0.2 0 0.8"', kind="fixed")
    stand = plan_of({"arm": box("1.6 0.1 0.1", mass=1.0, at="0.8 0 0")}, [hold]).stand
    assert stand.radius == pytest.approx(1.8, abs=0.01)
    assert [caster[:2] for caster in stand.casters] == [(0.2, 0.0)]


def test_the_limit_of_the_wheels_is_told_as_the_file_has_it():
    plan = plan_of({}, [], limit='<limit effort="9" velocity="7.46"/>')
    assert speed_source(plan) == "by the limits of its wheels, 7.46 rad/s"


@pytest.mark.parametrize(
    ("samples", "low", "high", "rpy", "yaw", "keys"),
    [
        (100, -0.5, 2.0, "0 0 0", 42.97, {"beams": 100, "fov_deg": 143.24}),
        (100, -0.5, 2.0, "3.1415926 0 0", -42.97, {"beams": 100, "fov_deg": 143.24}),  # upside down
        (360, 0.0, 6.2832, "0 0 0", 0.0, {"beams": 360, "fov_deg": 360.0}),
        (1, 0.0, 0.0, "0 0 1.5707963", 90.0, {"beams": 2, "fov_deg": 0.1}),
    ],
)
def test_a_lidar_looks_where_the_middle_of_its_fan_is(samples, low, high, rpy, yaw, keys):
    hold = joint("hold", "base", "scanner", f'xyz="0.1 0 0.4" rpy="{rpy}"', kind="fixed")
    (mount,) = plan_of({"scanner": ""}, [hold], more=SCANNER.format(samples, low, high)).mounts
    assert mount.yaw_deg == pytest.approx(yaw, abs=0.01)
    assert {key: mount.keys[key] for key in keys} == keys


def test_missing_meshes_are_named_where_wheels_have_no_shape(tmp_path):
    for place, says in [
        (
            "package://my_bot/wheel.stl",
            "; package 'my_bot', which may show them, was not found: give --package my_bot=",
        ),
        ("wheel.stl", "; meshes that may show them are missing"),
    ]:
        mesh = f'<visual><geometry><mesh filename="{place}"/></geometry></visual>'
        wheels = [joint(name, "base", name, f'xyz="0 {y} 0.1"') for name, y in (("l", 0.25), ("r", -0.25))]
        (tmp_path / "r.urdf").write_text(robot({"base": BASE, "l": mesh, "r": mesh}, wheels))
        with pytest.raises(UsageError, match=re.escape(says)):
            bring_robot(tmp_path / "r.urdf", name="r", options=RobotOptions(), packages={}, arguments={})


def test_a_missing_include_is_named_where_no_wheels_are_found(tmp_path):
    text = '<robot xmlns:xacro="https://github.com/ros/xacro" name="r"><xacro:include filename="wheels.xacro"/>'
    (tmp_path / "r.xacro").write_text(text + '<link name="base"/></robot>')
    with pytest.raises(UsageError, match=r"; an include that may declare them is missing: no file '.*wheels.xacro'"):
        bring_robot(tmp_path / "r.xacro", name="r", options=RobotOptions(), packages={}, arguments={})


def test_a_package_that_a_xacro_file_includes_and_is_missing_is_named_without_more(tmp_path):
    include = '<xacro:include filename="$(find my_bot)/a.xacro"/>'
    text = f'<robot xmlns:xacro="https://github.com/ros/xacro" name="r">{include}</robot>'
    (tmp_path / "r.xacro").write_text(text)
    place = f"{tmp_path / 'r.xacro'}:1:{text.index('<xacro:inc') + 1}"
    said = f"{place}: it names the package 'my_bot', which was not found; give --package my_bot=DIR"
    with pytest.raises(UsageError, match=f"^{re.escape(said)}$"):
        bring_robot(tmp_path / "r.xacro", name="r", options=RobotOptions(), packages={}, arguments={})


PROJECTION = "sum_of_robot_center_projection_on_X_Y_axis"


@pytest.mark.parametrize(
    ("plugin", "drive", "found"),
    [
        ("", None, "skid_steer"),
        ("libgazebo_ros_skid_steer_drive.so", None, "skid_steer"),
        ("gz::sim::systems::MecanumDrive", None, "mecanum"),
        ("libgazebo_ros_planar_move.so", None, "mecanum"),
        ("libgazebo_ros_planar_move.so", "skid_steer", "skid_steer"),
    ],
)
def test_four_wheels_are_mecanum_if_a_plugin_moves_the_robot_sideways(plugin, drive, found):
    speed = "<maxVelocity>0.7</maxVelocity>"
    gear = four_wheels(f'<gazebo><plugin name="base_controller" filename="{plugin}">{speed}</plugin></gazebo>', drive)
    assert (gear.drive, gear.said.max_speed) == (found, 0.7)
    assert any(plugin in note for note in gear.notes) == (found == "mecanum")


@pytest.mark.parametrize(
    ("controllers", "found"),
    [
        ({"mecanum_controller": {"front_left_wheel_joint": "a_wheel"}}, "mecanum"),
        ({"base": {"type": "mecanum_drive_controller/X", "front_left_wheel_joint": "a_wheel"}}, "mecanum"),
        ({"base": {"a_wheel_joint_name": "a_wheel", "kinematics": {PROJECTION: 0.4}}}, "mecanum"),
        ({"base": {"front_left_wheel_joint": "a_wheel"}}, "skid_steer"),
        ({"base": {"front_left_wheel_joint": "of another", "kinematics": {PROJECTION: 0.4}}}, "skid_steer"),
    ],
)
def test_or_if_their_controller_does(controllers, found):
    gear = four_wheels("", None, drives_in_parameters(controllers, "controllers of c.yaml"))
    assert gear.drive == found
    assert any("as controllers of c.yaml move it" in note for note in gear.notes) == (found == "mecanum")


def four_wheels(plugin, drive, said=()):
    links, joints = {"base": BASE}, []
    for name, x, y in (("a", 0.2, 0.25), ("b", 0.2, -0.25), ("c", -0.2, 0.25), ("d", -0.2, -0.25)):
        links[name] = tyre(0.1, 0.03)
        joints.append(joint(f"{name}_wheel", "base", name, f'xyz="{x} {y} 0.1"'))
    text = robot(links, [*joints, plugin]).encode()
    files = gather_robot("r.urdf", lambda _: text)
    anatomy, options = anatomy_of(files), RobotOptions(drive=drive)
    gear = find_gear(anatomy, options, file="r.urdf", urdf=True, said=[*files.drives, *said])
    return moved_sideways(gear, anatomy, files, options, file="r.urdf")
