"""Arms in world files: presets, what is refused and where, and the way back to text."""

import re
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError, WorldError
from mjsim.world import World, arm_names, format_world, parse_world
from tests.mechanics.arms import PARAMETERS, arm_of

HEAD = "mjsim: 1\nrobots:\n  - name: r\n    base: fixed\n    at: [1, 1]\n    arms:\n"


def world(*lines):
    return parse_world(HEAD + "".join(f"      {line}\n" for line in lines), file="w.yaml")


def test_each_preset_is_an_arm():
    assert arm_names() == ("motoman_up6", "picker", "puma560")
    for name in arm_names():
        assert mjsim.arm(name).n == 6


def test_the_up6_is_that_of_the_table():
    q = np.random.default_rng(1).uniform(-3.0, 3.0, (20, 6))
    np.testing.assert_allclose(mjsim.arm("motoman_up6").fkine(q), arm_of("UP6").fkine(q), atol=1e-15)


def test_the_puma_has_the_published_masses_motors_and_friction():
    preset, published = mjsim.arm("puma560"), arm_of("Puma 560")
    q, qd, qdd = np.random.default_rng(2).uniform(-2.0, 2.0, (3, 20, 6))
    np.testing.assert_allclose(preset.rne(q, qd, qdd), published.rne(q, qd, qdd), rtol=1e-12)
    lower, upper = np.degrees(preset.limits)
    np.testing.assert_allclose(lower, [-160, -45, -225, -110, -100, -266])
    np.testing.assert_allclose(upper, [160, 225, 45, 170, 100, 266])
    assert [link.max_torque for link in preset.links] == [97.6, 186.4, 89.4, 24.2, 20.1, 21.3]


def test_every_number_of_a_preset_names_its_source():
    for name in arm_names():
        text = (Path(mjsim.__file__).parent.parent / "assets" / "arms" / f"{name}.yaml").read_text()
        assert re.search(r"^# .*(Source|Sources)", text, re.MULTILINE)


def test_an_arm_stands_in_the_robots_frame_with_its_tool():
    item = (
        world("- {preset: motoman_up6, at: [0.1, 0, 0.4], rpy_deg: [0, 0, 90], tool: {at: [0, 0, 0.1]}}")
        .robots[0]
        .arms[0]
    )
    bare = mjsim.arm("motoman_up6").fkine(np.zeros(6))
    pose = item.arm.fkine(np.zeros(6))
    x, y, z = bare[:3, 3] + 0.1 * bare[:3, 2]
    np.testing.assert_allclose(pose[:3, 3], [0.1 - y, x, 0.4 + z], atol=1e-12)


def test_roll_pitch_and_yaw_are_right_handed_about_fixed_axes():
    item = world("- {preset: motoman_up6, rpy_deg: [90, 90, 0]}").robots[0].arms[0]
    # Roll takes y to z, then pitch takes z to x: y of the arm is x of the robot.
    np.testing.assert_allclose(item.arm.base[:3, 1], [1, 0, 0], atol=1e-12)


def test_a_world_with_arms_reads_back_equal():
    text = HEAD + (
        "      - {name: a, preset: puma560, at: [0, 0, 0.1], start_deg: [0, 90, 0, 0, 10, 0]}\n"
        "      - name: b\n"
        "        dh:\n"
        "          convention: modified\n"
        "          unit: mm\n"
        "          rows:\n"
        "            - {d: 100, alpha_deg: 90, range_deg: [-90, 90], friction: {coulomb: 0.1}}\n"
        "            - {a: 200, slide: true, range: [0, 9], mass: 2, center: [0, 0, 9], inertia: [1, 1, 1, 0, 0, 0]}\n"
    )
    first = parse_world(text)
    assert parse_world(format_world(first)) == first
    made = World(name="made", robots=first.robots)
    assert parse_world(format_world(made)).robots == first.robots


def test_the_toolboxs_parameters_are_the_presets():
    rows = world("- {preset: puma560}").robots[0].arms[0].dh.rows
    for row, link in zip(rows, PARAMETERS["puma560"]["links"], strict=True):
        assert (row.a, row.d, row.gear, row.mass) == pytest.approx((link["a"], link["d"], link["G"], link["m"]))


BAD = {
    "w.yaml:7:18: no arm preset 'pumma560'; did you mean 'puma560'?": "- {preset: pumma560}",
    "w.yaml:7:9: an arm has joints; give dh: {rows: [...]}, a preset, or model: FILE": "- {name: arm}",
    "w.yaml:7:21: rows is []; it must have at least 1 item": "- {dh: {rows: []}}",
    "w.yaml:7:32: a is nan; it must be a finite number": "- {dh: {rows: [{d: 1, a: .nan}]}}",
    "w.yaml:7:23: unknown key 'alfa_deg'; did you mean 'alpha_deg'?": "- {dh: {rows: [{alfa_deg: 90}]}}",
    "w.yaml:7:27: convention is 'standart'; it must be 'standard' or 'modified'; did you mean 'standard'?": (
        "- {dh: {convention: standart, rows: [{}]}}"
    ),
    "w.yaml:7:21: unit is 'cm'; it must be 'm' or 'mm'; did you mean 'm'?": "- {dh: {unit: cm, rows: [{}]}}",
    "w.yaml:7:37: mass is -1 kg; it must be at least 0": "- {dh: {rows: [{a: 0.1, mass: -1}]}}",
    "w.yaml:7:49: inertia is [1, 1, 1]; it must be [ixx, iyy, izz, ixy, iyz, ixz]": (
        "- {dh: {rows: [{a: 0.1, mass: 1, inertia: [1, 1, 1]}]}}"
    ),
    "w.yaml:7:49: the smallest principal moment of the inertia is -1 kg m^2; it must not be below 0": (
        "- {dh: {rows: [{mass: 1, a: 0.1, inertia: [1, 1, -1, 0, 0, 0]}]}}"
    ),
    "w.yaml:7:37: center is given without mass; give mass too, or neither": (
        "- {dh: {rows: [{a: 1, center: [0, 0, 0]}]}}"
    ),
    "w.yaml:7:40: the range is [90, -90]; the first must be below the second": (
        "- {dh: {rows: [{a: 1, range_deg: [90, -90]}]}}"
    ),
    "w.yaml:7:36: range is not for a joint that revolves; give range_deg": "- {dh: {rows: [{a: 1, range: [0, 1]}]}}",
    "w.yaml:7:35: gear is 0; it must not be 0": "- {dh: {rows: [{a: 1, gear: 0}]}}",
    "w.yaml:7:49: coulomb is [-1, 1]; the first must be 0 or more, the second 0 or less": (
        "- {dh: {rows: [{a: 1, friction: {coulomb: [-1, 1]}}]}}"
    ),
    "w.yaml:7:37: torque is 0; it must be above 0": "- {dh: {rows: [{a: 1, torque: 0}]}}",
    "w.yaml:7:22: joint1 moves nothing that has mass; give link1 or one beyond it a mass and an inertia, or the motor a"
    " rotor_inertia": "- {dh: {rows: [{a: 1, mass: 0}]}}",
    "w.yaml:7:38: start_deg holds 2 values; the arm has 6 joints": "- {preset: puma560, start_deg: [1, 2]}",
    "w.yaml:7:39: joint1 starts at 170; its range is [-160, 160]": (
        "- {preset: puma560, start_deg: [170, 0, 0, 0, 0, 0]}"
    ),
    "w.yaml:7:16: arm name 'drive' is taken by a part of the base; give it another": "- {name: drive, preset: puma560}",
    "w.yaml:7:16: arm name 'wheel_x' is taken by a part of the base; give it another": (
        "- {name: wheel_x, preset: puma560}"
    ),
    "w.yaml:7:17: unknown key 'att'; did you mean 'at'?": "- {tool: {att: [0,0,0]}, preset: puma560}",
}


@pytest.mark.parametrize(("sentence", "line"), BAD.items())
def test_a_bad_arm_is_one_line_with_its_place(sentence, line):
    with pytest.raises(WorldError) as caught:
        world(line)
    assert str(caught.value) == sentence


def test_two_arms_of_one_name_are_refused():
    with pytest.raises(WorldError, match=r"^w.yaml:8:16: name 'a' is taken by another arm of this robot; give each"):
        world("- {name: a, preset: puma560}", "- {name: a, preset: puma560}")


FIXED = {
    "w.yaml:5:12: a fixed base has no drive; leave out the drive, or 'base: fixed'": "drive: {type: omni3}",
    "w.yaml:5:21: a fixed base has nothing that imu could measure; leave it out": "sensors: [{imu: imu}]",
    "w.yaml:5:11: base is 'fixd'; it must be 'fixed'; did you mean 'fixed'?": "base: fixd",
    "w.yaml:5:12: a fixed robot has no drive; write base: fixed instead": "drive: {type: fixed}",
}


@pytest.mark.parametrize(("sentence", "line"), FIXED.items())
def test_a_wrong_base_is_one_line_with_its_place(sentence, line):
    fixed = "" if "base" in line or "type: fixed" in line else "    base: fixed\n"
    text = f"mjsim: 1\nrobots:\n  - name: r\n    at: [0, 0]\n    {line}\n{fixed}"
    with pytest.raises(WorldError) as caught:
        parse_world(text, file="w.yaml")
    assert str(caught.value) == sentence


def test_a_file_of_an_arm_is_read_and_its_faults_have_places(tmp_path):
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    good.write_text("dh: {unit: mm, rows: [{a: 100}, {a: 50}]}\ntool: {at: [0.01, 0, 0]}\n")
    assert mjsim.arm(good).fkine([0.0, 0.0])[0, 3] == pytest.approx(0.16)
    bad.write_text("dh:\n  rows:\n    - {a: .nan}\ntol: {}\n")
    with pytest.raises(WorldError) as caught:
        mjsim.arm(bad)
    assert str(caught.value).splitlines() == [
        f"{bad}:3:11: a is nan; it must be a finite number",
        f"{bad}:4:1: unknown key 'tol'; did you mean 'tool'?",
    ]
    with pytest.raises(
        UsageError,
        match=r"^'pumma560' is neither an arm preset nor a file .*; did you mean 'puma560'\?$",
    ):
        mjsim.arm("pumma560")


def test_an_arm_is_not_called_as_a_sensor_of_its_robot():
    text = "mjsim: 1\nrobots:\n- {name: r, at: [0, 0], sensors: [{lidar: eye}], arms: [{name: eye, preset: puma560}]}\n"
    with pytest.raises(WorldError, match="name 'eye' is taken by a sensor of this robot"):
        mjsim.parse_world(text)
