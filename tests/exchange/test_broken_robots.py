"""Broken files of robots: one line each, exit code 2, nothing written; or mended, and said how."""

import re
from pathlib import Path

import pytest

from mjsim.exchange import RobotOptions, bring_robot
from tests.exchange.odd_robots import box, four_steered, joint, on_three, robot, rover, tyre
from tests.exchange.test_robots import typed

TWO = rover([0.0])
SPHERE = '<link name="l0"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
LINKS = {"base": box("0.4 0.3 0.1"), "l": tyre(0.08, 0.03), "r": tyre(0.08, 0.03)}
ROLLED = robot(
    {**LINKS, **{f"roller{k}": tyre(0.01, 0.02) for k in range(6)}},
    [
        joint("left", "base", "l", 'xyz="0 0.2 0"'),
        joint("right", "base", "r", 'xyz="0 -0.2 0"'),
        *(joint(f"roll{k}", "l", f"roller{k}", f'xyz="0 0 {0.01 * k}"', axis="0.7 0.7 0") for k in range(6)),
    ],
)
MECANUM = robot(
    {"base": LINKS["base"], "mecanum_l": LINKS["l"], "mecanum_r": LINKS["r"]},
    [
        joint("left", "base", "mecanum_l", 'xyz="0 0.2 0"'),
        joint("right", "base", "mecanum_r", 'xyz="0 -0.2 0"'),
    ],
)
THREE = robot(
    {**LINKS, "m": tyre(0.08, 0.03)},
    [
        joint("left", "base", "l", 'xyz="0 0.2 0"'),
        joint("right", "base", "r", 'xyz="0 -0.2 0"'),
        joint("third", "base", "m", 'xyz="0 0.1 0"'),
    ],
)
ALONG_Y = robot(
    {"base": box("0.3 0.4 0.1"), "l": tyre(0.08, 0.03, rpy="0 1.57 0"), "r": tyre(0.08, 0.03, rpy="0 1.57 0")},
    [
        joint("left", "base", "l", 'xyz="-0.2 0 0"', axis="1 0 0"),
        joint("right", "base", "r", 'xyz="0.2 0 0"', axis="1 0 0"),
    ],
)
BICYCLE = robot(LINKS, [joint("rear", "base", "l", 'xyz="-0.2 0 0"'), joint("front", "base", "r", 'xyz="0.2 0.001 0"')])
IN_MILLIMETRES = robot(
    {"base": box("400 300 100"), "l": tyre(80, 30), "r": tyre(80, 30)},
    [joint("left", "base", "l", 'xyz="0 200 0"'), joint("right", "base", "r", 'xyz="0 -200 0"')],
)
SLIDING = """<mujoco><worldbody><body name="b"><joint name="go" type="slide" axis="1 0 0"/><geom size="0.1"/></body>
</worldbody></mujoco>"""
XACRO = '<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:arg name="a" default="1"/>{}</robot>'


@pytest.mark.parametrize(
    ("text", "options", "what"),
    [
        ("", (), r"robot\.urdf:1:1: this is not XML \(no element found\)"),
        ("<robot><link name='a'></robot>", (), r"robot\.urdf:1:25: this is not XML \(mismatched tag\)"),
        ("not xml at all", (), r"robot\.urdf:1:1: this is not XML"),
        ("<scene/>", (), r"begins with <scene>; a model begins with <mujoco> \(MJCF\) or <robot> \(URDF\)"),
        ('<!DOCTYPE a [<!ENTITY x "y">]><robot name="a">&x;</robot>', (), "declares a document type"),
        ('<robot name="a"/>', (), "MuJoCo cannot read|no wheels"),
        (robot({"base": box("1 1 1")}, []), (), "no wheels can be found: it has no level hinge at all"),
        (
            TWO.replace('link="r0"', 'link="gone"'),
            (),
            r"urdf:5:63: joint 'r0_hinge' names link 'gone', which does not exist",
        ),
        (TWO.replace("continuous", "fixed"), (), "no wheels can be found: it has no level hinge at all"),
        (
            TWO.replace('"continuous">', '"revolute"><limit lower="-1" upper="1" effort="1" velocity="1"/>'),
            (),
            r"its level hinges 'l0_hinge', 'r0_hinge' have limits; if it is an arm, a world has it as arms: ",
        ),
        (
            TWO.replace('xyz="0.0 0.2 -0.05"', 'xyz="zero 0.2"'),
            (),
            r"urdf:5:7: MuJoCo cannot read <origin>: bad format in attribute 'xyz'$",
        ),
        (
            TWO.replace("r0_hinge", "l0_hinge"),
            (),
            r"urdf:4:125: two joints are called 'l0_hinge'; give each its own name",
        ),
        (TWO.replace("</robot>", '<link name="l0"/></robot>'), (), r"urdf:2:105: two links are called 'l0'"),
        (
            TWO.replace("</robot>", '<link name="alone"/></robot>'),
            (),
            r"urdf:\d+:\d+: no joint carries link 'alone', nor 'chassis'; a robot has one such link, its root$",
        ),
        (
            TWO.replace('child link="r0"', 'child link="chassis"'),
            (),
            r"urdf:5:63: joint 'r0_hinge' closes a loop of links",
        ),
        (
            TWO.replace('child link="r0"', 'child link="l0"'),
            (),
            "joints 'l0_hinge' and 'r0_hinge' both carry link 'l0'",
        ),
        (TWO.replace("0.0 0.2 -0.05", "inf 0.2 0"), (), r"urdf:2:105: the position of 'l0' is not finite; correct it"),
        (TWO.replace('radius="0.1"', 'radius="0"'), (), "size 0 must be positive"),
        ('<svg xmlns="http://www.w3.org/2000/svg"/>', (), "begins with <svg>; a model begins with <mujoco>"),
        (
            XACRO.format('<xacro:macro name="wheel"><link name="l"/></xacro:macro><wheel/>'),
            (),
            r"urdf:1:\d+: <wheel> is a macro; to call it, write <xacro:wheel>",
        ),
        (
            XACRO.format('<xacro:include filename="gone.xacro"/>'),
            (),
            r"urdf:1:\d+: no file '.*gone.xacro': No such file",
        ),
        (THREE, (), "the driven wheels are ambiguous; candidates are 'left', 'right', 'third'; give --left-wheel"),
        (
            ROLLED,
            (),
            r"urdf:\d+:\d+: 'left', 'right' have rollers; for these mjsim has mecanum, four on parallel axles",
        ),
        (MECANUM, (), r"'left', 'right' have rollers; for these mjsim has mecanum"),
        (
            four_steered(),
            (),
            r"steers all four wheels, a drive that mjsim does not have; --steering front_left_steer --st",
        ),
        (on_three(), ("--drive", "mecanum"), "its wheels are arranged as those of omni3; leave out --drive mecanum"),
        (TWO, ("--drive", "mecanum"), "'l0_hinge', 'r0_hinge' have rollers; for these mjsim has mecanum"),
        (
            TWO,
            ("--drive", "tricycle"),
            "has no single steered wheel in front of or behind an axle",
        ),
        (SLIDING, (), r"no wheels can be found: it moves by slides \('go'\)"),
        (ALONG_Y, (), r"does not define its front; give --forward \+y or --forward -y"),
        (ALONG_Y, ("--forward", "+x"), r"--forward \+x is along the axles"),
        (TWO, ("--forward", "up"), r"--forward is 'up'; it must be \+x, -x, \+y or -y"),
        (TWO, ("--left-wheel", "l0_hing"), "no hinge 'l0_hing' in .*; did you mean 'l0_hinge'"),
        (TWO, ("--drive", "skid_steer"), "has one driven axle; skid steering needs two or more"),
        (
            TWO,
            ("--drive", "hover"),
            "--drive is 'hover'; it must be one of differential, skid_steer, ackermann, tri",
        ),
        (TWO, ("--package", "a=/nowhere"), "no folder '/nowhere' for package 'a'"),
        (TWO, ("--arg", "a"), "write --arg NAME=VALUE"),
        (TWO.replace('name="odd"', 'name="$(arg x)"'), (), "xacro:arg 'x' has no value; give --arg x=VALUE"),
        (
            XACRO.format('<link name="$(arg b)"/><xacro:arg name="b"/>'),
            (),
            "xacro:arg 'b' has no value; give --arg b=VALUE",
        ),
        (
            TWO.replace('name="odd"', 'name="${who}"'),
            (),
            "no xacro:property 'who'; declare it, or give --arg who=VALUE",
        ),
        (TWO.replace("0.0 0.2 -0.05", "0.0 nan -0.05"), (), r"urdf:5:18: a value is not a number \(nan\); correct it"),
        (
            "<mujoco><include file='gone.xml'/></mujoco>",
            (),
            r"'(/.*)/robot\.urdf' includes 'gone\.xml': no file '\1/gone\.xml': No such file",
        ),
        (TWO.replace("0.6 0.3 0.15", "-0.6 0.3 0.15"), (), "MuJoCo cannot read|size"),
        (
            TWO.replace("0.6 0.3 0.15", "0.6"),
            (),
            r"urdf:2:49: MuJoCo cannot read <box>: attribute 'size' does not have",
        ),
        (TWO.replace("0.6 0.3 0.15", "1e400 1 1"), (), "size|no wheels|large|number"),
        (
            "<mujoco><worldbody><attach model='m' prefix='p'/></worldbody></mujoco>",
            (),
            r"has another model \(<attach>\); write both as one file",
        ),
        ("<mujoco><worldbody><body name='b'><plugin/></body></worldbody></mujoco>", (), r"has plugins \(<plugin>\)"),
        (BICYCLE, (), "its wheels 'rear', 'front' are one behind the other, as on a bicycle"),
        (IN_MILLIMETRES, (), r"the robot is 500 m across; it must be 0\.02 to 20 m"),
    ],
)
def test_a_broken_file_is_a_one_line_error(tmp_path, text, options, what):
    place = tmp_path / "robot.urdf"
    place.write_text(text)
    code, said = typed("new", "--robot-from", str(place), "-o", str(tmp_path / "out.yaml"), *options)
    assert code == 2, said
    assert len(said.splitlines()) == 1, said
    assert re.search(what, said), said
    assert str(tmp_path) in said or "--" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["robot.urdf"]


@pytest.mark.parametrize(
    ("line", "what"),
    [
        (["new", "--robot-from", "nowhere.urdf", "-o", "x.yaml"], "no file 'nowhere.urdf'"),
        (["new", "--robot-from", "x.urdf"], "name it with -o ROBOT.yaml"),
        (["new", "--robot-from", "x.urdf", "--maze", "3x3"], "create the world with a separate command"),
        (["new", "--clutter", "6x6", "--robot", "pioneer3dy"], "no preset 'pioneer3dy'; did you mean 'pioneer3dx'?"),
        (
            ["new", "--clutter", "6x6", "--robot", "a/b.yaml"],
            "no file 'a/b.yaml'; name a file written by mjsim new --robot-from",
        ),
        (["new", "--clutter", "6x6", "--robot", "bad.yaml"], "'bad.yaml' does not describe a robot"),
        (
            ["new", "--clutter", "6x6", "--robot", "bad.yaml", "-o", "w/x.yaml"],
            "must be in the folder of the new world",
        ),
    ],
)
def test_an_implausible_command_is_a_one_line_error(tmp_path, monkeypatch, line, what):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.yaml").write_text("walls: []\npreset: burger\n")
    (tmp_path / "w").mkdir()
    code, said = typed(*line)
    assert (code, len(said.splitlines())) == (2, 1)
    assert what in said


def report_of(tmp_path: Path, text: str) -> str:
    """Return what is said of a robot."""
    (tmp_path / "robot.urdf").write_text(text)
    brought = bring_robot(tmp_path / "robot.urdf", name="r", options=RobotOptions(), packages={}, arguments={})
    return "\n".join(brought.report)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("has", "what"),
    [
        (
            box("0.4 0.3 0.1", mass=0.0),
            "link 'base' has a mass of 0 kg; its shapes get a density of 1000 kg/m^3 instead",
        ),
        (box("0.4 0.3 0.1", mass=-2.0), "link 'base' has a mass of -2 kg"),
        (box("0.4 0.3 0.1", mass=float("nan")), "link 'base' has a mass of nothing kg"),
        (
            box("0.4 0.3 0.1", inertia='ixx="0.1" iyy="0.2" izz="0.9" ixy="0" ixz="0" iyz="0"'),
            "the inertia of link 'base' breaks the triangle inequality (0.1 + 0.2 < 0.9 kg m^2); made 0.3, 0.4, 0.7",
        ),
        (
            box("0.4 0.3 0.1", inertia='ixx="0.1" iyy="-0.2" izz="0.2" ixy="0" ixz="0" iyz="0"'),
            "the inertia of link 'base' has a principal moment of -0.2 kg m^2; made 0.1, 0.1, 0.2",
        ),
        (
            box("0.4 0.3 0.1", inertia='ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"'),
            "link 'base' has no inertia; made 0.0417, 0.0708, 0.104 kg m^2, that of its shapes",
        ),
        (
            box("0.4 0.3 0.1", inertia='ixx="-1" iyy="-2" izz="-3" ixy="0" ixz="0" iyz="0"'),
            "robot.urdf: link 'base' has no inertia (its file says -1, -2, -3); made 0.0417, 0.0708, 0.104 kg m^2",
        ),
    ],
)
def test_an_inertia_that_physics_refuses_is_mended_and_said(tmp_path, has, what):
    wheels = [joint("left", "base", "l", 'xyz="0 0.2 0"'), joint("right", "base", "r", 'xyz="0 -0.2 0"')]
    said = report_of(tmp_path, robot({**LINKS, "base": has}, wheels))
    assert what in said
    assert f"mended: {tmp_path / 'robot.urdf'}: " in said
    assert "measured: +" in said


@pytest.mark.slow
def test_wheels_that_weigh_nothing_and_touch_nothing_are_driven_on(tmp_path):
    look = tyre(0.08, 0.03).partition("</inertial>")[2].replace("collision", "visual")
    wheels = [joint("left", "base", "l", 'xyz="0 0.2 0"'), joint("right", "base", "r", 'xyz="0 -0.2 0"')]
    said = report_of(tmp_path, robot({**LINKS, "l": look, "r": look}, wheels))
    assert "wheels 'left' and 'right', of radius 0.0800 m" in said
    assert "measured: +" in said


@pytest.mark.slow
def test_files_outside_of_the_robots_folders_are_not_opened(tmp_path):
    deep = tmp_path / "a" / "b" / "c" / "d" / "e"
    deep.mkdir(parents=True)
    (tmp_path / "secret.stl").write_bytes(b"solid secret")
    (deep / "link.stl").symlink_to(tmp_path / "secret.stl")
    mesh = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    names = ("link.stl", "../../../../../secret.stl", f"file://{tmp_path}/secret.stl", "package://etc/passwd.stl")
    links = {**LINKS, "base": LINKS["base"] + "".join(mesh.format(name) for name in names)}
    wheels = [joint("left", "base", "l", 'xyz="0 0.2 0"'), joint("right", "base", "r", 'xyz="0 -0.2 0"')]
    (deep / "robot.urdf").write_text(robot(links, wheels))
    brought = bring_robot(deep / "robot.urdf", name="r", options=RobotOptions(), packages={}, arguments={})
    assert list(brought.files) == ["r/robot.urdf"]
    lines = [line for line in brought.report if line.startswith("left out: ") and "missing mesh" in line]
    for name in ("link.stl", "secret.stl", "passwd.stl"):
        assert any(name in line for line in lines), lines
    assert any("lies outside of the robot's folder and its packages; copy it to them" in line for line in lines)
