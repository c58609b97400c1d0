"""What a robot from a file stands on, casters of the file and those that it lacks, and where its lidar looks."""

import itertools
import re
from collections.abc import Sequence

import pytest

from mjsim import UsageError
from mjsim.exchange import RobotOptions, bring_robot
from mjsim.exchange.robots.driven_wheels import find_gear
from mjsim.exchange.robots.import_robot import moved_sideways
from mjsim.exchange.robots.mounts import find_mounts
from mjsim.exchange.robots.preset import Plan, first_plan, speed_source
from mjsim.exchange.robots.robot_frame import find_stand
from mjsim.exchange.robots.steering import steering_limit
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


def along_y(names: Sequence[str], *, steered: float | None = None) -> str:
    """Return a URDF whose axles are along x, with wheels at y = 0.3 and -0.3; one axle may be steered."""
    links, joints = {"base": box("0.5 0.9 0.2", mass=30.0)}, []
    limit = '<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>'
    for name, (x, y) in zip(names, itertools.product((0.2, -0.2), (0.3, -0.3)), strict=True):
        links[name], parent, at = tyre(0.1, 0.05, rpy="0 1.5707963 0"), "base", f'xyz="{x} {y} 0"'
        if y == steered:
            links[f"held_{x}"], parent = "", f"held_{x}"
            joints.append(joint(f"turn_{x}", "base", parent, at, kind="revolute", axis="0 0 1", more=limit))
            at = ""
        joints.append(joint(f"on_{x}_{y}", parent, name, at, axis="1 0 0"))
    return robot(links, joints)


@pytest.mark.parametrize(
    ("text", "way"),
    [
        (along_y(["wheel_fr", "wheel_br", "wheel_fl", "wheel_bl"]), 1.0),
        (along_y(["rr_1", "fr_1", "rl_1", "fl_1"]), -1.0),
        (along_y(["a", "b", "c", "d"], steered=0.3), 1.0),
        (along_y(["a", "b", "c", "d"], steered=-0.3), -1.0),
    ],
)
def test_a_robot_across_its_file_has_its_front_by_short_names_and_where_it_steers(text, way):
    anatomy = anatomy_of(gather_robot("r.urdf", lambda _: text.encode()))
    gear = find_gear(anatomy, RobotOptions(), file="r.urdf", urdf=True)
    assert gear.forward == pytest.approx([0.0, way], abs=1e-6)
    assert gear.notes[0].startswith(f"its front is [0, {way:.0f}] in its file")


SEEN = '<visual><origin rpy="1.5707963 0 0"/><geometry><cylinder radius="0.1" length="0.01"/></geometry></visual>'


@pytest.mark.parametrize("lies", [True, False])
def test_front_wheels_that_only_steer_are_given_joints_to_roll_on(lies):
    links, joints = {"base": BASE, "front_wheel": SEEN}, []
    limit = '<limit lower="-0.4" upper="0.4" effort="1" velocity="1"/>'
    for side, y in (("l", 0.25), ("r", -0.25)):
        # Exporters turn the frames of wheels: here either the cylinder lies in its link, or its link is turned.
        links |= {f"wheel_f{side}": tyre(0.1, 0.03) if lies else tyre(0.1, 0.03, rpy="0 0 0")}
        links |= {f"wheel_r{side}": tyre(0.1, 0.03)}
        at = f'xyz="0.3 {y} 0.1"' + ("" if lies else ' rpy="1.5707963 0 0"')
        axis = "0 0 1" if lies else "0 1 0"
        joints.append(joint(f"turn_{side}", "base", f"wheel_f{side}", at, kind="revolute", axis=axis, more=limit))
        joints.append(joint(f"drive_{side}", "base", f"wheel_r{side}", f'xyz="-0.3 {y} 0.1"'))
    joints.append(joint("middle", "base", "front_wheel", 'xyz="0.3 0 0.1"', kind="revolute", axis="0 0 1", more=limit))
    text = robot(links, joints).encode()
    files = gather_robot("r.urdf", lambda _: text)
    gear = find_gear(anatomy_of(files), RobotOptions(), file="r.urdf", urdf=True)
    assert gear.drive == "ackermann"
    assert [wheel.name for side in gear.rows[0] for wheel in side] == ["turn_l_rolling", "turn_r_rolling"]
    assert steering_limit([wheel.steer for side in gear.rows[0] for wheel in side]) == pytest.approx(0.4)
    assert [note for note in files.notes if "only steers its wheel" in note] == [
        f"r.urdf: joint 'turn_{side}' only steers its wheel; joint 'turn_{side}_rolling' added, on which it turns"
        for side in "lr"
    ]
