"""Robots from their makers' files: found, measured, written, driven."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from mjsim.exchange import RobotOptions, bring_robot
from mjsim.exchange.robots.folders import Folders
from mjsim.geometry import Pose
from mjsim.interface import Command
from mjsim.models import XacroError
from mjsim.sim import Simulation
from mjsim.world import OdometryNoise, WheelOdometry, load_world, parse_world
from tests.exchange.bringing import brought, few_drives, typed
from tests.exchange.odd_robots import (
    STRETCHED,
    on_casters,
    rover,
)

DATA = Path(__file__).parents[1] / "data" / "robots"
BURGER = DATA / "turtlebot3_description" / "urdf" / "turtlebot3_burger.urdf"
WAFFLE = BURGER.with_name("turtlebot3_waffle.urdf")
CAR = DATA / "safety_gymnasium" / "xmls" / "car.xml"
RACECAR = CAR.with_name("racecar.xml")
DEPOT = DATA.parent / "maps" / "depot.yaml"


class Presets(dict):
    """Robots by their names, each brought in when it is asked for the first time."""

    def __init__(self, folder):
        super().__init__()
        self.folder = folder

    def __missing__(self, name):
        file = next(path for path in (BURGER, WAFFLE, CAR, RACECAR) if path.stem == name)
        with few_drives():  # its slip is measured in test_odometry_of_robots.py
            self[name] = brought(file, self.folder)
        return self[name]


@pytest.fixture(scope="module")
def presets(tmp_path_factory):
    return Presets(tmp_path_factory.mktemp("presets"))


@pytest.mark.slow
@pytest.mark.parametrize(
    # Sizes and sums of masses as they stand in the files.
    ("name", "drive", "radius", "track", "mass"),
    [
        ("turtlebot3_burger", "differential", 0.033, 0.160, 1.0017),
        ("turtlebot3_waffle", "differential", 0.033, 0.288, 1.5539),
        ("car", "differential", 0.05, 0.26, 0.0304),
        ("racecar", "ackermann", 0.05, 0.245, None),
    ],
)
def test_wheels_and_sizes_are_those_of_the_file(presets, name, drive, radius, track, mass):
    world = load_world(presets[name][0])
    (robot,) = world.robots
    assert robot.drive.type == drive
    # Calibrated: tyres sink into the floor by some hundredths of a millimetre.
    assert robot.drive.wheel_radius == pytest.approx(radius, rel=0.002)
    assert robot.drive.track == pytest.approx(track, rel=0.003)
    if mass is not None:
        with Simulation(world) as sim:
            assert sim.model.body_subtreemass[sim.model.body(f"{robot.name}/base").id] == pytest.approx(mass, rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["turtlebot3_burger", "turtlebot3_waffle", "car", "racecar"])
def test_it_drives_as_far_as_odometry_tells_and_stays_level(presets, name):
    world = load_world(presets[name][0])
    (robot,) = world.robots
    quiet = robot.model_copy(update={"sensors": (), "odometry": WheelOdometry(noise=OdometryNoise())})
    with Simulation(world.model_copy(update={"robots": (quiet,)})) as sim:
        sim.apply(robot.name, Command(0.2, turn=0.4))
        start, told = sim.truth(robot.name), Pose(0.0, 0.0, 0.0)
        for _ in range(200):
            sim.step()
            seen = sim.sense(robot.name).odometry
            told = told @ Pose(seen.forward, seen.left, seen.turn)
        was = start.inverse() @ sim.truth(robot.name)
        # 1.6 m on an arc; tyres creep outward by some millimetres for a metre.
        np.testing.assert_allclose(told.as_array()[:2], was.as_array()[:2], atol=0.03)
        assert abs(math.remainder(told.heading - was.heading, 2 * math.pi)) < 0.03
        assert math.hypot(was.x, was.y) > 0.8
        assert sim.pose(robot.name)[2, 2] > math.cos(math.radians(1.0))
        assert abs(sim.poses()[robot.name].z) < 0.002


@pytest.mark.slow
def test_sensors_stand_where_the_file_has_them(presets):
    (waffle,) = load_world(presets["turtlebot3_waffle"][0]).robots
    sensors = {sensor.kind: sensor for sensor in waffle.sensors}
    # base_footprint -> base_link [0, 0, 0.01] -> base_scan [-0.064, 0, 0.122], camera_link [0.064, -0.065, 0.094].
    assert sensors["lidar"].at == pytest.approx((-0.064, 0.0, 0.132), abs=1e-3)
    assert sensors["camera"].at == pytest.approx((0.064, -0.065, 0.104), abs=1e-3)
    assert sensors["imu"].at == pytest.approx((0.0, 0.0, 0.078), abs=1e-3)


@pytest.mark.slow
def test_a_lidar_does_not_see_the_robot_that_carries_it(presets, tmp_path):
    for name in ("turtlebot3_burger", "turtlebot3_waffle"):
        world = load_world(presets[name][0])
        with Simulation(world) as sim:
            (scan,) = sim.sense(world.robots[0].name).scans.values()
            assert not np.isfinite(scan.ranges).any()


@pytest.mark.slow
def test_what_is_missing_is_counted(presets):
    _, said = presets["turtlebot3_waffle"]
    assert "left out: 3 missing meshes 'r200.dae', 'waffle_base.stl', 'lds.stl': collision shapes are used" in said
    _, said = presets["racecar"]
    assert "left out: 8 missing meshes" in said


@pytest.mark.slow
def test_the_front_is_found_from_names_if_it_is_not_x(presets):
    _, said = presets["car"]
    # Its front_bumper lies at -y, its back_bumper at +y.
    assert "its front is [0, -1] in its file" in said
    assert load_world(presets["car"][0]).robots[0].body.forward_deg == pytest.approx(-90.0)


def test_a_preset_file_serves_other_worlds_and_several_robots(presets):
    preset, _ = presets["turtlebot3_burger"]
    text = """
mjsim: 1
robots:
  - {name: one, preset: turtlebot3_burger.yaml, at: [0, 0]}
  - {name: two, preset: turtlebot3_burger.yaml, at: [2, 0], drive: {max_speed: 0.1}}
"""
    (preset.parent / "room.yaml").write_text(text)
    world = load_world(preset.parent / "room.yaml")
    assert [robot.drive.max_speed for robot in world.robots] == [0.41, 0.1]
    with Simulation(world) as sim:
        for name in ("one", "two"):
            sim.apply(name, Command(0.2))
        for _ in range(100):
            sim.step()
        assert sim.truth("one").x > 0.6
        assert sim.truth("two").x == pytest.approx(2.4, abs=0.03)
        assert {"one/wheel_left", "two/wheel_right"} <= {sim.model.joint(n).name for n in range(sim.model.njnt)}


@pytest.mark.slow
@pytest.mark.parametrize("made_from", [("--from", str(DEPOT), "--lidar", "lds-02"), ("--clutter", "6x6")])
def test_a_new_world_has_a_robot_from_a_file(presets, made_from, monkeypatch):
    folder = presets["turtlebot3_burger"][0].parent
    monkeypatch.chdir(folder)
    code, said = typed("new", *made_from, "--robot", "turtlebot3_burger.yaml", "-o", "made.yaml", "--overwrite")
    assert code == 0, said
    world = load_world(folder / "made.yaml")
    assert world.robots[0].body.wheels["left"].joint == "wheel_left_joint"
    with Simulation(world) as sim:
        sim.apply("scout", Command(0.2))
        for _ in range(25):
            sim.step()
        assert math.dist(sim.truth("scout").as_array()[:2], world.robots[0].at) > 0.1


def test_a_recording_holds_the_files_of_a_robot(presets, tmp_path):
    from mjsim.record import read_recording
    from mjsim.run import Driver, run

    preset, _ = presets["turtlebot3_burger"]
    (preset.parent / "room.yaml").write_text(
        "mjsim: 1\nrobots: [{name: r, preset: turtlebot3_burger.yaml, at: [0, 0]}]\n"
    )
    world = load_world(preset.parent / "room.yaml")
    with Simulation(world) as sim:
        run(sim, drivers={"r": Driver()}, seconds=0.4, record=tmp_path / "r.mcap")
    again = read_recording(tmp_path / "r.mcap").world
    assert again == world
    with Simulation(again) as sim:
        sim.step()


@pytest.mark.slow
def test_ros_packages_are_found_by_path_and_by_option(tmp_path, monkeypatch):
    moved = tmp_path / "elsewhere" / "burger.urdf"
    moved.parent.mkdir()
    moved.write_bytes(BURGER.read_bytes())
    package = BURGER.parents[1]
    plain = bring_robot(moved, name="b", options=RobotOptions(), packages={}, arguments={})
    assert any("package 'turtlebot3_description': not found" in line for line in plain.report)
    assert len(plain.files) == 1
    named = bring_robot(moved, name="b", options=RobotOptions(), packages={package.name: package}, arguments={})
    assert len(named.files) == 3
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere{os.pathsep}{package.parent}")
    by_path = bring_robot(moved, name="b", options=RobotOptions(), packages={}, arguments={})
    assert by_path.files == named.files


@pytest.mark.parametrize("folder", ["robot_description-main", "src"])
def test_a_package_in_a_folder_of_another_name_is_found_by_its_manifest(folder, tmp_path):
    package, other = tmp_path / folder, tmp_path / "parts-1.2"
    for place, name in ((package, "robot_description"), (other, "parts")):
        (place / "urdf").mkdir(parents=True)
        (place / "package.xml").write_text(f"<package>\n  <name>{name}</name>\n</package>")
    here = Folders(package / "urdf" / "r.urdf", {})
    assert (here.package("robot_description"), here.package("parts")) == (package, other)
    assert here.package("wheels") is None
    assert here.missing == {"wheels"}


@pytest.mark.slow
def test_arguments_of_xacro_become_names(tmp_path):
    text = bring_robot(BURGER, name="b", options=RobotOptions(), packages={}, arguments={"namespace": "left_"}).text
    assert 'joint: "left_wheel_left_joint"' in text


@pytest.mark.slow
def test_a_text_written_by_the_command_is_a_world(presets):
    for name in ("turtlebot3_burger", "turtlebot3_waffle", "car", "racecar"):
        preset, _ = presets[name]
        world = parse_world(preset.read_text(), source=load_world(preset).source)
        assert world == load_world(preset)


@pytest.mark.slow
def test_joints_that_are_no_wheels_hold_still_with_their_limits(tmp_path):
    (tmp_path / "tall.xml").write_text(STRETCHED)
    preset, said = brought(tmp_path / "tall.xml", tmp_path)
    assert "kept: 5 locked joints 'joint_lift'" in said
    with Simulation(load_world(preset)) as sim:
        sim.apply("tall", Command(0.3, turn=0.3))
        joints = [sim.data.joint(f"tall/{name}") for name in ("joint_lift", "joint_arm", "rubber_x", "joint_head")]
        for _ in range(150):
            sim.step()
            # Slides sag by a tenth of a millimetre under their load.
            assert max(abs(float(joint.qpos[0])) for joint in joints) < 2e-3
        assert sim.model.joint("tall/joint_lift").range == pytest.approx((-0.5, 0.6))
        assert sim.model.joint("tall/joint_head").range == pytest.approx((-3.9, 1.5))


@pytest.mark.slow
def test_a_joint_whose_zero_is_beyond_its_limits_rests_at_the_nearer_one(tmp_path):
    (tmp_path / "odd.urdf").write_text(on_casters())
    preset, _ = brought(tmp_path / "odd.urdf", tmp_path)
    with Simulation(load_world(preset)) as sim:
        for _ in range(25):
            sim.step()
        assert sim.data.joint("odd/shoulder").qpos[0] == pytest.approx(0.1, abs=2e-3)
        # The laser hangs on the mast, which slides 0.1 m up from 0.1 m on the base, at 0.42 m above.
    (robot,) = load_world(preset).robots
    assert robot.sensors[0].at == pytest.approx((-0.1, 0.0, 0.7), abs=1e-3)


def sphere_stl(count: int, *, text: bool) -> bytes:
    """Return a ball of radius 40 mm as an STL file in mm, of about so many triangles."""
    turns = np.linspace(0.0, 2 * np.pi, round(math.sqrt(count)) + 1)
    rises = np.linspace(-np.pi / 2, np.pi / 2, round(math.sqrt(count) / 2) + 1)
    turn, rise = np.meshgrid(turns, rises)
    points = 40.0 * np.stack([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)], axis=-1)
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    triangles = np.concatenate([np.stack(t, axis=-2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    if text:
        corners = ["".join(f"vertex {x:.6e} {y:.6e} {z:.6e}\n" for x, y, z in triangle) for triangle in triangles]
        facets = "".join(f"facet normal 0 0 0\nouter loop\n{c}endloop\nendfacet\n" for c in corners)
        return f"solid ball\n{facets}endsolid ball\n".encode()
    records = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    records["v"] = triangles
    return bytes(80) + len(triangles).to_bytes(4, "little") + records.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("count", "text", "said"), [(2000, True, False), pytest.param(64_000, False, True, marks=pytest.mark.slow)]
)
def test_meshes_in_text_and_of_too_many_triangles_are_read(tmp_path, count, text, said):
    mesh = '<visual><geometry><mesh filename="ball.stl" scale="0.001 0.001 0.001"/></geometry></visual></link>'
    (tmp_path / "robot.urdf").write_text(rover([0.0]).replace("</link>", mesh, 1))
    (tmp_path / "ball.stl").write_bytes(sphere_stl(count, text=text))
    brought = bring_robot(tmp_path / "robot.urdf", name="r", options=RobotOptions(), packages={}, arguments={})
    assert (any("simplified, as it has too many corners" in line for line in brought.report)) == said
    (data,) = (data for name, data in brought.files.items() if name.endswith(".stl"))
    corners = np.frombuffer(data[84:], dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])["v"]
    assert len(corners) <= 60_000
    # Corners that are merged lie on the ball, but for the bulge of a cell of 1/225 of its width.
    np.testing.assert_allclose(np.linalg.norm(corners.reshape(-1, 3), axis=1), 40.0, atol=0.1)


def test_files_that_a_build_moves_within_a_package_are_found_where_its_source_has_them(tmp_path):
    for name in ("description/urdf/r.urdf", "description/ros2_control/r.xacro", "bringup/config/c.yaml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "package.xml").write_text("<package><name>robot_demo</name></package>")
    folders = Folders(tmp_path / "description" / "urdf" / "r.urdf", {})
    named = "package://robot_demo/ros2_control/{}.xacro"
    assert folders.locate(named.format("r"), tmp_path) == [tmp_path / "description" / "ros2_control" / "r.xacro"]
    assert folders.installed == {"ros2_control/r.xacro": "description/ros2_control/r.xacro"}
    assert list(folders.parameters()) == [tmp_path / "bringup" / "config" / "c.yaml"]
    # Of two neither is more likely, and nothing outside is looked at.
    (tmp_path / "other" / "ros2_control").mkdir(parents=True)
    (tmp_path / "other" / "ros2_control" / "r.xacro").touch()
    assert folders.locate(named.format("r"), tmp_path) == [tmp_path / "ros2_control" / "r.xacro"]
    with pytest.raises(XacroError, match="outside"):
        folders.locate(named.format("../../r"), tmp_path)


def test_a_file_whose_name_differs_by_capitals_alone_is_found_if_it_is_the_only_one(tmp_path):
    inside = tmp_path / "robot"
    (inside / "meshes").mkdir(parents=True)
    (inside / "meshes" / "Ball.STL").touch()
    (tmp_path / "secret.stl").touch()
    folders = Folders(inside / "robot.urdf", {})
    assert folders.in_other_case(inside, "Meshes/ball.stl") == inside / "meshes" / "Ball.STL"
    assert folders.in_other_case(inside, "meshes/bell.stl") is None
    with pytest.raises(XacroError, match="outside of the robot's folder"):
        folders.in_other_case(inside, "../Secret.stl")
    (inside / "meshes" / "ball.STL").touch()
    assert folders.in_other_case(inside, "meshes/BALL.stl") is None


@pytest.mark.parametrize(
    ("keys", "what"),
    [
        ("preset: gone.yaml", "no file 'gone.yaml' beside the world file or in assets"),
        ("preset: ../x.yaml", "path '../x.yaml' is outside its folder"),
        ("preset: two.yaml", "'two.yaml' is a world without exactly one robot"),
        ("preset: bad.yaml", "bad.yaml:2:1: this is not YAML"),
        (
            "preset: turtlebot3_burger.yaml, body: {wheels: {left: {joint: wheel_left_join}}}",
            "no hinge 'wheel_left_join' in 'turtlebot3_burger/robot.urdf'; did you mean 'wheel_left_joint'?",
        ),
        ("preset: turtlebot3_burger.yaml, body: {wheels: {rear: {joint: a, radius: 1, width: 1}}}", "no hinge 'a'"),
        ("preset: turtlebot3_burger.yaml, drive: {type: skid_steer}", "has the drive differential, not skid_steer"),
    ],
)
def test_an_error_in_a_preset_file_is_reported_with_its_place(presets, keys, what):
    folder = presets["turtlebot3_burger"][0].parent
    (folder / "two.yaml").write_text("mjsim: 1\nrobots: [{name: a, at: [0, 0]}, {name: b, at: [5, 0]}]\n")
    (folder / "bad.yaml").write_text("drive: {type: [\n")
    (folder / "wrong.yaml").write_text(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], {keys}}}]\n")
    code, said = typed("check", str(folder / "wrong.yaml"))
    assert code == 2
    assert len(said.splitlines()) == 1
    assert what in said
    assert said.startswith(f"{folder / 'wrong.yaml'}:2:")
