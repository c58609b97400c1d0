"""Drives of robots from files: found by their wheels and joints, and driven."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange import RobotOptions
from mjsim.exchange.robots.driven_wheels import Gear, find_gear
from mjsim.exchange.robots.preset import stated_speed
from mjsim.interface import Command
from mjsim.models import anatomy_of, gather_robot
from mjsim.sim import Simulation
from mjsim.world import load_world
from tests.exchange.bringing import brought, few_drives
from tests.exchange.odd_robots import (
    STRETCHED,
    box,
    hubbed,
    joint,
    on_casters,
    on_mecanum,
    on_three,
    robot,
    rover,
    tricycle,
    tyre,
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "text", "drive", "track", "radius"),
    [
        # Four wheels turn about the middles of a wider track: track + wheelbase^2 / track, or nearly so.
        pytest.param(
            *("four.urdf", rover([0.2, -0.2]), "skid_steer", (0.8, 0.06), 0.1),
            marks=pytest.mark.slow,  # Its slip is measured over many drives.
        ),
        ("casters.urdf", on_casters(), "differential", (0.4, 0.005), 0.08),
        # Its wheels lie 2 x (0.17035 - 0.0125) m apart.
        pytest.param("tall.xml", STRETCHED, "differential", (0.3157, 0.002), 0.05, marks=pytest.mark.slow),
    ],
)
def test_odd_robots_are_found_whatever_their_axes_and_frames(tmp_path, name, text, drive, track, radius):
    (tmp_path / name).write_text(text)
    with few_drives():
        preset, _ = brought(tmp_path / name, tmp_path)
    (robot,) = load_world(preset).robots
    assert robot.drive.type == drive
    assert robot.drive.turning_track == pytest.approx(track[0], abs=track[1])
    assert robot.drive.wheel_radius == pytest.approx(radius, rel=0.005)


def gear_of(text: str, folder: Path, **options: object) -> Gear:
    """Return the running gear that is found in a robot's file."""
    (folder / "r.urdf").write_text(text)
    found = gather_robot("r.urdf", lambda name: (folder / name).read_bytes())
    return find_gear(anatomy_of(found), RobotOptions(**options), file="r.urdf", urdf=True)


@pytest.mark.parametrize(
    ("text", "drive", "wheels"),
    [
        (on_mecanum(), "mecanum", 4),
        (on_mecanum(rollers=8), "mecanum", 4),
        (on_three(), "omni3", 3),
        (on_three(first=1.0), "omni3", 3),
        (tricycle(), "tricycle", 3),
        (tricycle(ahead=-0.5), "tricycle", 3),
        # A wheel behind an upright joint without limits and without a motor is a caster.
        (tricycle(limit="").replace("revolute", "continuous"), "differential", 2),
        (tricycle().replace("steer", "castor_pivot"), "differential", 2),  # its name tells
    ],
)
def test_each_kind_of_drive_is_known_by_how_its_wheels_stand(tmp_path, text, drive, wheels):
    gear = gear_of(text, tmp_path)
    assert (gear.drive, len(gear.wheels())) == (drive, wheels)


def test_three_wheels_in_a_ring_come_in_the_order_of_the_drive(tmp_path):
    gear = gear_of(on_three(first=math.pi), tmp_path)
    np.testing.assert_allclose(gear.forward, [1.0, 0.0], atol=1e-4)
    assert [wheel.name for wheel in gear.single] == ["j2", "j0", "j1"]


def test_a_wheel_whose_motor_a_file_leaves_out_drives_like_its_neighbour(tmp_path):
    motor = '<gazebo><plugin filename="libgazebo_ros_diff_drive.so"><left_joint>l0_hinge</left_joint></plugin></gazebo>'
    gear = gear_of(rover([0.0]).replace("</robot>", f"{motor}</robot>"), tmp_path)
    assert (gear.drive, [wheel.name for wheel in gear.wheels()]) == ("differential", ["l0_hinge", "r0_hinge"])


@pytest.mark.parametrize(("seen", "apart", "name"), [(True, 0.4, "l_rolls"), (False, 0.34, "l_wheel")])
def test_wheels_that_touch_with_boxes_are_measured_by_their_pictures_or_their_sides(tmp_path, seen, apart, name):
    links = {"base": box("0.3 0.2 0.1"), "l": hubbed(0.08, 0.03, inwards=-0.06, seen=seen)}
    links |= {"r": hubbed(0.08, 0.03, inwards=0.06, seen=seen)}
    joints = [joint(name.replace("l_", f"{s}_"), "base", s, f'xyz="0 {y} 0"') for s, y in (("l", 0.2), ("r", -0.2))]
    gear = gear_of(robot(links, joints), tmp_path)
    (((left,), (right,)),) = gear.rows
    assert left.radius == right.radius == pytest.approx(0.08, abs=1e-6)
    assert np.linalg.norm(left.middle - right.middle) == pytest.approx(apart, abs=1e-6)
    assert left.width == pytest.approx(0.03 if seen else 0.09, abs=1e-6)


def test_what_turns_and_is_not_round_is_no_wheel_and_is_named(tmp_path):
    plank = '<collision><geometry><box size="0.2 0.03 0.05"/></geometry></collision>'
    joints = [joint(f"{s}_wheel", "base", s, f'xyz="0 {y} 0"') for s, y in (("l", 0.2), ("r", -0.2))]
    with pytest.raises(UsageError, match="nothing that turns on 'l_wheel', 'r_wheel' is round about its axle"):
        gear_of(robot({"base": box("0.3 0.2 0.1"), "l": plank, "r": plank}, joints), tmp_path)


def test_a_caster_with_rollers_makes_no_base_that_goes_any_way(tmp_path):
    ball = '<collision name="omni_wheel"><origin xyz="-0.2 0 -0.12"/><geometry><sphere radius="0.03"/></geometry>'
    text = rover([0.0]).replace('<link name="chassis">', f'<link name="chassis">{ball}</collision>')
    assert gear_of(text, tmp_path).drive == "differential"


def test_gears_of_a_differential_are_no_rollers(tmp_path):
    """A ring on the axle carries two spiders and, on the axle again, the two sides with the wheels."""
    lay = 'xyz="{} {} 0" rpy="0 0 0"'
    gears = {"spider_a": (0.02, 0.0, "1 0 0"), "spider_b": (-0.02, 0.0, "1 0 0")}
    sides = {"side_l": (0.0, 0.2, "0 1 0"), "side_r": (0.0, -0.2, "0 -1 0")}
    links = {"base": box("0.3 0.2 0.1"), "ring": tyre(0.03, 0.02)}
    links |= {name: tyre(0.01, 0.01) for name in gears} | {name: tyre(0.05, 0.03) for name in sides}
    joints = [joint("ring_joint", "base", "ring", lay.format(0, 0))]
    for name, (x, y, axis) in (gears | sides).items():
        joints.append(joint(f"{name}_joint", "ring", name, lay.format(x, y), axis=axis))
    gear = gear_of(robot(links, joints), tmp_path)
    assert (gear.drive, [wheel.name for wheel in gear.wheels()]) == ("differential", ["side_l_joint", "side_r_joint"])


def test_a_joint_that_is_continuous_has_no_ends_whatever_its_limit_says(tmp_path):
    (tmp_path / "r.urdf").write_text(rover([0.0]).replace("</joint>", '<limit lower="-0.1" upper="0.15"/></joint>'))
    found = gather_robot("r.urdf", lambda name: (tmp_path / name).read_bytes())
    assert not found.model.jnt_limited.any()


def test_a_robot_that_is_only_drawn_has_mass_and_can_be_touched(tmp_path):
    drawn = re.sub("<inertial>.*?</inertial>", "", rover([0.0]), flags=re.DOTALL).replace("collision>", "visual>")
    (tmp_path / "r.urdf").write_text(drawn)
    found = gather_robot("r.urdf", lambda name: (tmp_path / name).read_bytes())
    wheel = 1000.0 * math.pi * 0.1**2 * 0.06
    assert found.model.body_mass.sum() == pytest.approx(1000.0 * 0.6 * 0.3 * 0.15 + 2.0 * wheel)
    assert np.count_nonzero(found.model.geom_contype) == 3
    assert any("no link has a mass" in note for note in found.notes)


def test_wheels_that_do_not_turn_are_named_beside_those_that_do(tmp_path):
    text = rover([0.1, -0.1]).replace('name="l0_hinge" type="continuous"', 'name="l0_wheel" type="prismatic"')
    text = text.replace('name="l1_hinge" type="continuous"', 'name="l1_wheel" type="prismatic"')
    with pytest.raises(UsageError, match="bicycle, while 'l0_wheel', 'l1_wheel' have limits"):
        gear_of(text.replace("</joint>", '<limit lower="-0.1" upper="0.1" effort="1" velocity="1"/></joint>'), tmp_path)


def test_wheels_on_fixed_joints_turn_and_joints_that_move_the_whole_robot_do_not(tmp_path):
    wheels = [joint(f"{s}_wheel", "base", s, f'xyz="0 {y} 0"', kind="fixed") for s, y in (("l", 0.2), ("r", -0.2))]
    rail = joint("rail", "world", "base", 'xyz="0 0 0"', kind="prismatic", more='<limit lower="-9" upper="9"/>')
    links = {"world": "", "base": box("0.3 0.3 0.1"), "l": tyre(0.08, 0.03), "r": tyre(0.08, 0.03)}
    (tmp_path / "r.urdf").write_text(robot(links, [rail, *wheels]))
    found = gather_robot("r.urdf", lambda name: (tmp_path / name).read_bytes())
    assert [joint.name for joint in anatomy_of(found).joints] == ["l_wheel", "r_wheel"]
    assert sum("is fixed; made to turn" in note or "moves the whole robot" in note for note in found.notes) == 3


SCENE = """<mujoco><worldbody><geom type="plane" size="3 3 .1"/><geom name="wall" type="box" size=".1 3 1" pos="3 0 1"/>
<body name="base" pos="0 0 .1"><joint name="x" type="slide" axis="1 0 0"/><joint name="turn" axis="0 0 1"/>
<geom type="box" size=".2 .1 .05" pos="0 0 .05"/>
<body pos="0 .15 0"><joint name="l" axis="0 1 0"/><geom type="cylinder" size=".1 .02" euler="90 0 0"/></body>
<body pos="0 -.15 0"><joint name="r" axis="0 1 0"/><geom type="cylinder" size=".1 .02" euler="90 0 0"/></body></body>
<body name="table" pos="1 0 .4"><geom type="box" size=".3 .3 .02"/></body>
<body name="ball" pos="2 0 .1"><freejoint name="free"/><geom name="round" size=".1"/></body></worldbody>
<contact><exclude body1="base" body2="ball"/></contact>
<actuator><velocity joint="l" ctrlrange="-8 8"/><velocity joint="r" ctrlrange="-8 8"/><motor joint="x"/></actuator>
</mujoco>"""


def test_what_stands_around_a_robot_and_slides_it_in_a_scene_is_left_out(tmp_path):
    (tmp_path / "scene.xml").write_text(SCENE)
    found = gather_robot("scene.xml", lambda name: (tmp_path / name).read_bytes())
    gear = find_gear(anatomy_of(found), RobotOptions(), file="scene.xml", urdf=False)
    assert (gear.drive, [wheel.name for wheel in gear.wheels()]) == ("differential", ["l", "r"])
    assert [found.model.joint(k).name for k in range(found.model.njnt)] == ["l", "r"]
    assert found.model.ngeom == 3
    assert found.model.nu == 2
    assert "left out: 2 bodies beside the robot in scene.xml: 'table', 'ball'" in found.notes
    assert sum("moves the whole robot; locked" in note for note in found.notes) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "command", "moved"),
    [
        (on_mecanum(), Command(0.2, left=0.2), (0.4, 0.4)),
        (on_three(first=math.pi), Command(0.1, left=-0.2), (0.2, -0.4)),
        (tricycle(), Command(0.3), (0.6, 0.0)),
    ],
)
def test_each_kind_of_drive_goes_where_it_is_told(tmp_path, text, command, moved):
    (tmp_path / "kind.urdf").write_text(text)
    with few_drives():
        preset, _ = brought(tmp_path / "kind.urdf", tmp_path)
    world = load_world(preset)
    (robot,) = world.robots
    quiet = robot.model_copy(update={"drive": robot.drive.model_copy(update={"noise": type(robot.drive.noise)()})})
    with Simulation(world.model_copy(update={"robots": (quiet,)})) as sim:
        sim.apply("kind", command)
        for _ in range(50):
            sim.step()
        sim.apply("kind", Command())
        for _ in range(25):
            sim.step()
        # Two seconds at that speed; what is missing while it gathers speed comes back while it brakes.
        np.testing.assert_allclose(sim.truth("kind").as_array()[:2], moved, atol=0.03)


def test_the_largest_speed_is_that_of_the_wheels_in_the_file(tmp_path):
    gear = gear_of(on_mecanum(), tmp_path)
    assert {wheel.joint.speed for wheel in gear.wheels()} == {12.0}
    assert stated_speed(gear) == pytest.approx(12.0 * 0.06)
    assert stated_speed(gear_of(on_mecanum().replace('velocity="12"', 'velocity="100"'), tmp_path)) is None
    servo = '<velocity joint="{}" kv="3" ctrlrange="-8 8" ctrllimited="true" gear="2"/>'
    wheel = '<body pos="0 {} 0.1"><joint name="{}" axis="0 1 0"/><geom size="0.1"/></body>'
    (tmp_path / "r.xml").write_text(
        f'<mujoco><worldbody><body><geom size="0.1"/>{wheel.format(0.2, "l")}'
        f"{wheel.format(-0.2, 'r')}</body></worldbody>"
        f"<actuator>{servo.format('l')}{servo.format('r')}</actuator></mujoco>"
    )
    found = gather_robot("r.xml", lambda name: (tmp_path / name).read_bytes())
    assert found.speeds == pytest.approx({"l": 4.0, "r": 4.0})


@pytest.mark.slow
def test_six_wheels_turn_by_chains(tmp_path):
    (tmp_path / "six.urdf").write_text(rover([0.25, 0.0, -0.25]))
    with few_drives():
        preset, _ = brought(tmp_path / "six.urdf", tmp_path)
    world = load_world(preset)
    with Simulation(world) as sim:
        sim.apply("six", Command(0.3, turn=0.5))
        for _ in range(100):
            sim.step()
        left = [
            float(sim.data.joint(f"six/wheel_{name}").qvel[0]) for name in ("front_left", "front_left-2", "rear_left")
        ]
        assert left[1] == pytest.approx(left[0], rel=0.02)
        assert left[2] == pytest.approx(left[0], rel=0.05)
