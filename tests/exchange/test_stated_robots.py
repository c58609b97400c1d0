"""Robots as exporters and simulators write them: sensors, placeholders, plug-ins; what becomes of each is listed."""

import math

import pytest

from mjsim import UsageError
from mjsim.exchange import RobotOptions
from mjsim.exchange.robots.driven_wheels import Gear, find_gear
from mjsim.exchange.robots.listing import efforts, kept, sluggish
from mjsim.exchange.robots.mounts import find_mounts
from mjsim.exchange.robots.preset import Plan, first_plan, max_speed, preset_turn
from mjsim.exchange.robots.robot_frame import find_stand
from mjsim.exchange.robots.robot_source import RobotSource
from mjsim.exchange.robots.steering import steering_limit
from mjsim.inventory import FileItem, inventory
from mjsim.models import RobotFiles, anatomy_of, drives_in_parameters, gather_robot
from mjsim.models.xacro import Given
from tests.exchange.odd_robots import box, joint, robot, rover, tyre

BASE = box("0.5 0.4 0.2", mass=40.0, at="0 0 0.16")
FAN = """<gazebo reference="{link}"><sensor name="{name}" type="ray"><pose>{pose}</pose><update_rate>5</update_rate>
  <ray><scan><horizontal><samples>{beams}</samples><min_angle>-{half}</min_angle><max_angle>{half}</max_angle>
  </horizontal>{more}</scan><range><min>0.02</min><max>{far}</max></range></ray></sensor></gazebo>"""
RINGS = "<vertical><samples>16</samples><min_angle>-0.2618</min_angle><max_angle>0.2618</max_angle></vertical>"


def fan(
    name: str, *, beams: int = 360, half: float = 3.14159, far: float = 12.0, pose: str = "", more: str = ""
) -> str:
    """Return a fan of beams on the base as Gazebo has it."""
    return FAN.format(link="base", name=name, beams=beams, half=half, far=far, pose=pose, more=more)


def cart(more: str = "", limit: str = "") -> RobotFiles:
    """Return the file of a robot on two wheels."""
    places = [("left", "l", 0.25), ("right", "r", -0.25)]
    held = [joint(name, "base", wheel, f'xyz="0 {y} 0.1"', more=limit) for name, wheel, y in places]
    text = robot({"base": BASE, "l": tyre(0.1, 0.03), "r": tyre(0.1, 0.03)}, [*held, more]).encode()
    return gather_robot("r.urdf", lambda _: text)


def planned(files: RobotFiles, said=()) -> tuple[Plan, list[FileItem]]:
    """Return the preset of a robot, and what was left out."""
    found = anatomy_of(files)
    gear = find_gear(found, RobotOptions(), file="r.urdf", urdf=True, said=[*said, *files.drives])
    stand = find_stand(found, gear, acceleration=1.0)
    mounts, items = find_mounts(found, stand, files.sensors)
    return first_plan("r", "r.urdf", gear, stand, mounts), items


def test_all_scanners_come_in_the_widest_first_and_fans_of_short_beams_are_told():
    # Infrared rays of 0.2 m, and a cone of rays as far as sonars of robots reach.
    reach = [(0.2, ""), (0.2, ""), (4.0, RINGS), (5.0, RINGS)]
    near = [
        fan(f"near_{n}", beams=5, half=0.09, far=far, pose=f"0.2 0 0.1 0 0 {n}", more=more)
        for n, (far, more) in enumerate(reach)
    ]
    scanners = [fan(f"scan_{n}", half=1.0, pose=f"{n} 0 0.3 0 0 0") for n in range(3)]
    plan, items = planned(cart("".join([*near, *scanners, fan("main", pose="0 0 0.5 0 0 0")])))
    assert [(mount.kind, mount.name) for mount in plan.mounts] == [
        ("lidar", "main"),
        *(("lidar", f"scan_{n}") for n in range(3)),
    ]
    (line,) = inventory(items)
    assert line.startswith("left out: 4 proximity sensors 'near_0', 'near_1', 'near_2', 'near_3': a fan of few short")


@pytest.mark.parametrize(
    ("sensor", "line"),
    [
        ('<gazebo reference="base"><sensor name="s" type="gps"/></gazebo>', "left out: gps sensor 's': mjsim has no"),
        (
            '<gazebo reference="mast"><sensor name="s" type="imu"/></gazebo>',
            "left out: imu sensor 's': its link 'mast' is not in the file",
        ),
        (fan("s", pose="0 0 0.3 0 1.5707 0"), "left out: lidar 's': looks down, by 90 degrees"),
        (fan("s", pose="0 0 -1 0 0 0"), "left out: lidar 's': -1.000 m above the floor; the minimum is 0.02"),
        (fan("s", pose="0 0 0.3 0 0 0") + fan("t", pose="0 0 0.31 0 0 0"), "left out: lidar 't': at the place of 's'"),
        (fan("s", pose="0 0 0.3 0 0 0").replace(">5<", ">40<"), "guessed: lidar 's': 25 Hz for 40 Hz"),
    ],
)
def test_a_sensor_that_is_left_out_or_changed_is_told_with_the_reason(sensor, line):
    _, items = planned(cart(sensor))
    assert [text[: len(line)] for text in inventory(items)] == [line]


def test_a_lidar_with_rings_is_a_3d_lidar():
    plan, _ = planned(cart(fan("top", beams=900, far=100.0, pose="0 0 0.6 0 0 0", more=RINGS)))
    (mount,) = plan.mounts
    assert mount.kind == "lidar3d"
    assert mount.keys == {
        **{"rings": 16, "columns": 900, "fov_deg": 360.0, "elevation_deg": [-15.0, 15.0]},
        **{"range": [0.02, 100.0], "rate_hz": 5.0},
    }


def car(limit: str, *, trail: float = 0.0, steer: str = "steer", kind: str = "revolute", more: str = "") -> RobotFiles:
    """Return the file of a car whose front wheels hang on vertical hinges, `trail` behind them."""
    links, joints = {"base": BASE}, []
    for side, y in (("l", 0.25), ("r", -0.25)):
        links |= {f"fork_{side}": "", f"front_{side}": tyre(0.1, 0.03), f"rear_{side}": tyre(0.1, 0.03)}
        turning = joint(f"{steer}_{side}", "base", f"fork_{side}", f'xyz="0.3 {y} 0.1"', kind=kind, more=limit)
        joints.append(turning.replace('"0 1 0"', '"0 0 1"'))
        joints.append(joint(f"roll_{side}", f"fork_{side}", f"front_{side}", f'xyz="{-trail} 0 0"'))
        joints.append(joint(f"drive_{side}", "base", f"rear_{side}", f'xyz="-0.3 {y} 0.1"'))
    text = robot(links, [*joints, more]).encode()
    return gather_robot("r.urdf", lambda _: text)


def geared(files: RobotFiles, **options) -> Gear:
    return find_gear(anatomy_of(files), RobotOptions(**options), file="r.urdf", urdf=True)


ZERO = '<limit lower="0" upper="0" effort="1" velocity="1"/>'


@pytest.mark.parametrize(
    "options",
    [{}, {"left": ["drive_l"], "right": ["drive_r"], "steering": ["steer_l", "steer_r"]}],
)
def test_limits_of_0_to_0_are_a_placeholder_and_what_is_guessed_instead_is_told(options):
    gear = geared(car(ZERO), **options)
    assert gear.drive == "ackermann"
    steers = [wheel.steer for side in gear.rows[0] for wheel in side]
    assert steering_limit(steers) == pytest.approx(math.radians(35.0))
    assert "it steers 35 degrees to both sides, as its limits are 0 to 0" in gear.notes[-1]
    assert geared(car('<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>')).notes == ()


def test_a_wheel_that_trails_behind_such_a_joint_is_a_caster():
    gear = geared(car(ZERO, trail=0.05))
    assert gear.drive == "differential"
    assert {wheel.name for wheel in gear.bearing} == {"roll_l", "roll_r"}


@pytest.mark.parametrize(("interface", "drive"), [("command", "ackermann"), ("state", "differential")])
def test_an_endless_vertical_hinge_steers_if_ros2_control_commands_it(interface: str, drive: str):
    hinges = "".join(f'<joint name="steer_{s}"><{interface}_interface name="position"/></joint>' for s in "lr")
    wheels = "".join(f'<joint name="drive_{s}"><command_interface name="velocity"/></joint>' for s in "lr")
    files = car("", kind="continuous", more=f'<ros2_control name="c" type="system">{hinges}{wheels}</ros2_control>')
    assert geared(files).drive == drive


def test_joints_that_the_user_names_for_steering_steer_or_are_refused():
    # As casters they would be passive.
    gear = geared(car(ZERO, trail=0.05), steering=["steer_l", "steer_r"])
    assert gear.drive == "ackermann"
    with pytest.raises(UsageError, match=r"--steering 'left' of r\.urdf turns no wheel about a vertical axis; leave"):
        find_gear(anatomy_of(cart()), RobotOptions(steering=["left"]), file="r.urdf", urdf=True)


PLUGIN = """<gazebo><plugin name="drive" filename="libdrive.so"><left_joint>left</left_joint>
  <right_joint>right</right_joint>
  <wheel_separation>0.5</wheel_separation><wheel_diameter>0.24</wheel_diameter>{}</plugin></gazebo>"""


SKID = """<gazebo><plugin name="skid" filename="libskid.so"><leftFrontJoint>l0_hinge</leftFrontJoint>
  <rightFrontJoint>r0_hinge</rightFrontJoint><leftRearJoint>l1_hinge</leftRearJoint>
  <rightRearJoint>r1_hinge</rightRearJoint><wheelSeparation>4</wheelSeparation></plugin></gazebo>"""


def test_speeds_come_from_plugins_and_sizes_that_differ_are_told():
    plan, _ = planned(cart(PLUGIN.format("<max_linear_velocity>0.9</max_linear_velocity>")))
    assert (max_speed(plan), plan.wheel_radius) == (0.9, pytest.approx(0.1))
    lines = inventory(kept(anatomy_of(cart()), plan))
    assert "kept: max_speed 0.9 m/s: by plug-in 'libdrive.so'" in lines
    assert "kept: wheel radius of 0.1000 m, from the shapes: plug-in 'libdrive.so' has 0.1200 m" in lines
    assert not any("track of" in line and "from the shapes" in line for line in lines)


def test_the_track_of_a_skid_steered_robot_is_told_as_its_file_and_its_plugin_have_it():
    files = gather_robot("r.urdf", lambda _: rover([0.25, -0.25]).replace("</robot>", f"{SKID}</robot>").encode())
    plan, _ = planned(files)
    assert plan.track == pytest.approx((0.4**2 + 0.5**2) / 0.4)
    lines = inventory(kept(anatomy_of(files), plan))
    assert any(line.endswith("of radius 0.1000 m, a track of 0.4000 m") for line in lines)
    assert "kept: track of 0.4000 m, from the shapes: plug-in 'libskid.so' has 4.0000 m" in lines


def test_wheels_without_a_shape_have_the_radius_of_the_plugin():
    held = [joint(name, "base", name, f'xyz="0 {y} 0.2"') for name, y in (("left", 0.25), ("right", -0.25))]
    text = robot({"base": BASE, "left": "", "right": ""}, [*held, PLUGIN.format("")]).encode()
    plan, _ = planned(gather_robot("r.urdf", lambda _: text))
    assert plan.wheel_radius == pytest.approx(0.12)
    assert plan.gear.floor == pytest.approx(0.08)


CONTROLLERS = {
    "/**": {
        "mobile_base": {
            "ros__parameters": {
                "left_wheel_names": ["left"],
                "right_wheel_names": ["right"],
                "wheel_radius": 0.1,
                "wheel_separation": 0.5,
                "linear.x.max_velocity": 0.8,
                "angular": {"z": {"has_velocity_limits": True, "max_velocity": 2.0}},
            }
        }
    }
}


def test_parameters_of_controllers_give_speeds_to_the_robot_whose_joints_they_name():
    said = list(drives_in_parameters(CONTROLLERS, "controllers of c.yaml"))
    plan, _ = planned(cart(), said)
    assert (max_speed(plan), preset_turn(plan)) == (0.8, round(math.degrees(2.0)))
    other = [each for each in drives_in_parameters({"a": {"left_wheel": "x", "right_wheel": "y"}}, "c") if each.joints]
    plan, _ = planned(cart(), other)
    assert plan.gear.said.max_speed is None


@pytest.mark.parametrize(
    "named",
    [
        {"front_left_wheel_joint": "left", "front_right_wheel_joint": "right"},  # mecanum in ROS
        {"front_left_wheel_command_joint_name": "left", "kinematics": {"wheels_radius": 0.1}},  # and in ROS 2
        {"wheel_names": ["left", "right"]},  # wheels in a ring
        {"traction_joints_names": ["left", "right"], "steering_joints_names": ["x"]},
    ],
)
def test_so_do_those_of_other_drives(named):
    limits = {"linear": {"x": {"max_velocity": 0.8}}}
    said = list(drives_in_parameters({"base": {"ros__parameters": named | limits}}, "controllers of c.yaml"))
    plan, _ = planned(cart(), said)
    assert max_speed(plan) == 0.8
    assert said[0].wheel_radius == (0.1 if "kinematics" in named else None)


def test_a_limit_of_a_template_is_no_speed():
    plan, _ = planned(cart(limit='<limit effort="100" velocity="1"/>'))
    assert max_speed(plan) == 1.25
    (line,) = (line for line in inventory(kept(anatomy_of(cart()), plan)) if "max_speed" in line)
    assert line.startswith("guessed: max_speed 1.25 m/s: wheels that turn at 12.5 rad/s, as the limit of 1 rad/s")


def test_controllers_of_a_package_beside_the_description_are_read_and_options_that_do_nothing_are_told(tmp_path):
    for package in ("bot_description", "bot_control"):
        (tmp_path / package / "config").mkdir(parents=True)
        (tmp_path / package / "package.xml").write_text("<package/>")
    (tmp_path / "bot_control" / "config" / "control.yaml").write_text(
        "base: {left_wheel: left, right_wheel: right, linear: {x: {max_velocity: 1.5}}}"
    )
    (tmp_path / "bot_control" / "config" / "broken.yaml").write_text("base: [")
    (tmp_path / "bot_control" / "config" / "gone.yaml").symlink_to(tmp_path / "nowhere.yaml")
    place = tmp_path / "bot_description" / "bot.urdf"
    place.write_text(robot({"base": BASE}, []))
    source = RobotSource(place, packages={"spare": tmp_path}, given=Given({"prefix": "a_"}, {"B": "1"}), model="x")
    source.read(source.name)
    assert [(said.max_speed, said.source) for said in source.drives()] == [(1.5, "controllers of control.yaml")]
    (tmp_path / "bot_control" / "config" / "other.yaml").write_text(
        "base: {left_wheel: left, right_wheel: right, linear: {x: {max_velocity: 9.5}}}"
    )
    named = (
        '<gazebo><plugin name="p"><parameters>$(find bot_control)/config/control.yaml</parameters></plugin></gazebo>'
    )
    for text, speeds in (([], [1.5, 9.5]), ([named], [1.5])):
        place.write_text(robot({"base": BASE}, text))
        again = RobotSource(place, packages={}, given=Given({}, {}))
        again.read(again.name)
        assert [said.max_speed for said in again.drives()] == speeds
    assert [line.partition(":")[2].partition("'")[0].strip() for line in inventory(source.unused())] == [
        "--arg",
        "--env",
        "--model",
        "--package",
    ]


def test_a_frame_with_the_mass_of_rounding_weighs_nothing():
    speck = '<inertial><mass value="4e-15"/><inertia ixx="1e-27" iyy="1e-27" izz="1e-27"/></inertial>'
    held = [joint(name, "base", wheel, f'xyz="0 {y} 0.1"') for name, wheel, y in (("a", "l", 0.2), ("b", "r", -0.2))]
    links = {"base": BASE, "l": tyre(0.1, 0.03), "r": tyre(0.1, 0.03), "mark": speck}
    text = robot(links, [*held, joint("mark", "base", "mark", 'xyz="0 0 0.2"', kind="fixed")]).encode()
    files = gather_robot("r.urdf", lambda _: text)
    assert "r.urdf: link 'mark' has a mass of 4e-15 kg; it gets a negligible mass instead" in files.notes


@pytest.mark.parametrize(("moment", "told"), [(0.5, 0), (40.0, 1)])
def test_an_inertia_that_the_shapes_of_a_body_cannot_have_is_told(moment, told):
    # Its mass of 40 kg would be 1 m away from its centre; the corners of its box are 0.34 m away.
    stranger = cart()
    stranger.model.body_mass[1], stranger.model.body_inertia[1] = 40.0, moment
    lines = inventory(sluggish(stranger))
    assert len(lines) == told
    assert all("as if all its mass were 1.00 m away, but it reaches 0.34 m" in line for line in lines)


def test_an_element_that_urdf_does_not_have_is_left_out_and_told(tmp_path):
    place = tmp_path / "bot.urdf.xacro"
    for text, unknown in (
        (robot({"base": BASE}, ["<bot_on_gazebo/>", '<gazebo/><transmission name="t"/>']), ["bot_on_gazebo"]),
        (
            robot({"base": BASE}, ["<rig/>"]).replace("<robot", '<robot xmlns:xacro="http://ros.org/wiki/xacro"'),
            ["rig"],
        ),
    ):
        place.write_text(text)
        source = RobotSource(place, packages={}, given=Given({}, {}))
        source.read(source.name)
        assert [item.name for item in source.changed] == unknown


def test_a_frame_called_like_a_lidar_has_usual_keys_and_a_line_says_so():
    held = '<origin xyz="0 0 0.4"/><parent link="base"/><child link="laser"/>'
    more = f'<link name="laser"/><joint name="j" type="fixed">{held}</joint>'
    plan, items = planned(cart(more))
    assert [mount.name for mount in plan.mounts] == ["laser"]
    (line,) = inventory(items)
    assert (
        line
        == "guessed: lidar 'laser': range, field of view, rate and noise as usual: the file gives only its position"
    )
    assert inventory(planned(cart(fan("main", pose="0 0 0.5 0 0 0")))[1]) == []


def test_a_camera_of_depth_measures_depth():
    seen = "".join(
        f'<gazebo reference="base"><sensor name="{kind}" type="{kind}"><pose>0 {y} 0.3 0 0 0</pose><camera>'
        "<horizontal_fov>1.2</horizontal_fov></camera></sensor></gazebo>"
        for y, kind in enumerate(("camera", "depth", "rgbd_camera"))
    )
    plan, _ = planned(cart(seen))
    assert [mount.keys.get("depth", False) for mount in plan.mounts] == [False, True, True]


def test_limits_of_torque_and_acceleration_that_no_drive_has_are_told():
    plugin = """<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so"><left_joint>left</left_joint>
    <right_joint>right</right_joint><wheel_separation>0.5</wheel_separation><max_wheel_torque>20</max_wheel_torque>
    <max_wheel_acceleration>1.5</max_wheel_acceleration><torque>0</torque></plugin></gazebo>"""
    files = cart(plugin)
    plan, _ = planned(files)
    told = "left out: max_wheel_torque 20, max_wheel_acceleration 1.5: wheels follow their speeds with any torque"
    assert told in inventory([*kept(anatomy_of(files), plan)])
    parameters = {
        "left_wheel_names": ["left"],
        "linear.x.max_acceleration": 2.0,
        "linear.x.has_acceleration_limits": True,
    }
    (said,) = drives_in_parameters(parameters, "c.yaml")
    assert said.unused == ("linear.x.max_acceleration 2",)


def test_torques_of_wheels_are_told_as_left_out():
    files = cart(limit='<limit effort="7.5" velocity="9"/>')
    plan, _ = planned(files)
    told = "left out: effort of wheels, 7.5 N m: wheels follow their speeds with any torque"
    assert inventory(efforts(files, plan.gear)) == [told]
    assert inventory(efforts(cart(), plan.gear)) == []


def test_frames_called_like_sensors_that_mjsim_has_not_are_told_in_one_line():
    more = [*(f"sonar_{n}" for n in range(3)), "gps_link", "bumper_plate"]
    links = {"base": BASE, "l": tyre(0.1, 0.03), "r": tyre(0.1, 0.03)} | dict.fromkeys(more, "")
    wheels = [("left", "l", 0.25), ("right", "r", -0.25)]
    joints = [joint(name, "base", wheel, f'xyz="0 {y} 0.1"') for name, wheel, y in wheels]
    joints += [joint(f"j_{name}", "base", name, 'xyz="0 0 0.3"', kind="fixed") for name in more]
    text = robot(links, joints).encode()
    _, items = planned(gather_robot("r.urdf", lambda _: text))
    (line,) = inventory(items)
    assert line.startswith("left out: 4 frames called like a sensor 'sonar_0', 'sonar_1', 'sonar_2', 'gps_link': each")


def test_a_radius_that_is_the_height_above_the_footprint_is_told():
    mass = '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = {"base_footprint": "", "base": BASE, "l": mass, "r": mass}
    wheels = [("left_wheel", "l", 0.25), ("right_wheel", "r", -0.25)]
    joints = [joint(name, "base", wheel, f'xyz="0 {y} 0.1"') for name, wheel, y in wheels]
    joints.append(joint("root", "base_footprint", "base", 'xyz="0 0 -0.02"', kind="fixed"))
    text = robot(links, joints).encode()
    files = gather_robot("r.urdf", lambda _: text)
    plan, _ = planned(files)
    assert plan.wheel_radius == pytest.approx(0.08)
    told = "guessed: radius of the wheels: their height above 'base_footprint', as no shape gives it"
    assert told in inventory([*kept(anatomy_of(files), plan)])
