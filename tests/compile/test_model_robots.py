"""Robots from files: what check says of them is what run would say."""

import contextlib
import io
import re
from pathlib import Path

import pytest

from mjsim.cli import main
from mjsim.errors import PhysicsFault
from mjsim.interface import WheelCommand
from mjsim.sim import Simulation
from mjsim.world import load_world
from tests.rover import ROVER, TANK

WORLD = (
    "mjsim: 1\nrobots: [{{name: r, at: [0, 0], body: {{model: {model}}}, drive: {{{drive}}},"
    " odometry: {{noise: {{distance: 0, turn: 0}}}}}}]\n"
)
OWN = 'use: "tank.py:Tank", radius: 0.08, track: 0.3'
DATA = Path(__file__).parents[1] / "data" / "robots"


def typed(*line: str) -> tuple[int, str]:
    """Return the exit code of a command, and what it says to people."""
    said = io.StringIO()
    with pytest.raises(SystemExit) as caught, contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        main(line)
    return int(caught.value.code or 0), said.getvalue()


def world_with(folder: Path, text: str | bytes, *, name: str = "robot.xml", drive: str = OWN) -> Path:
    """Return the file of a world with a robot of a description."""
    (folder / "tank.py").write_text(TANK)
    (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    world = folder / "world.yaml"
    world.write_text(WORLD.format(model=name, drive=drive))
    return world


def rover(*, looks: str = "", assets: str = "", armature: float = 0.05, kv: float = 4.0) -> str:
    """Return the file of the rover with more of a look, other servos, and one caster that grips: it rocks."""
    text = re.sub(r'\n *<geom type="sphere" [^>]* pos="0\.15 [^>]*>', "", ROVER)
    text = text.replace(' condim="1" friction="0 0 0" priority="1"', "")
    text = text.replace('armature="0.05"', f'armature="{armature:g}"').replace('kv="4"', f'kv="{kv:g}"')
    text = text.replace("<freejoint/>", f"<freejoint/>{looks}")
    return text.replace("<actuator>", f"<asset>{assets}</asset><actuator>")


def stepped(sim: Simulation, ticks: int) -> None:
    for _ in range(ticks):
        sim.step()


URDF = (DATA / "turtlebot3_description" / "urdf" / "turtlebot3_burger.urdf").read_bytes()
MJCF = (DATA / "safety_gymnasium" / "xmls" / "car.xml").read_bytes()


@pytest.mark.parametrize(
    ("name", "text", "drive", "what"),
    [
        ("burger.urdf", URDF, OWN, "no library|expand it|is URDF"),
        ("burger.urdf", URDF, "type: differential", "mjsim new --robot-from burger.urdf"),
        ("plain.urdf", b'<robot name="r"><link name="base"/></robot>', OWN, "is URDF, which has no servos"),
        ("car.xml", MJCF, OWN, "no body named 'base'"),
        ("car.xml", MJCF, "type: differential", "mjsim new --robot-from car.xml"),
        ("car.xml", MJCF, "type: mecanum", "does not name the joints of .car.xml. that are its wheels"),
        ("robot.xml", rover(assets='<mesh name="m" file="gone.stl"/>'), OWN, "no file 'gone.stl'"),
        ("robot.xml", rover(looks='<geom type="mesh" mesh="m"/>'), OWN, "mesh"),
        ("robot.xml", rover(assets='<mesh name="m" file="../../x.stl"/>'), OWN, "names the file '../../x.stl'"),
        ("robot.xml", rover().replace("</mujoco>", ""), OWN, "is not XML"),
        ("robot.xml", rover(armature=0.0, kv=400), OWN, "servo '.*' with kv=400 is too stiff"),
        ("robot.xml", "<mujoco><worldbody/></mujoco>", OWN, "no body named 'base'"),
    ],
)
def test_check_says_of_a_robots_file_what_run_says(tmp_path, name, text, drive, what):
    world = world_with(tmp_path, text, name=name, drive=drive)
    code, said = typed("check", str(world))
    assert code == 2
    assert len(said.splitlines()) == 1
    assert said.startswith(f"{world}:2:")
    assert re.search(what, said), said
    code, run = typed("run", str(world), "--seconds", "0.2", "-o", str(tmp_path / "r.mcap"))
    assert code != 0
    assert "Traceback" not in run


@pytest.mark.parametrize(("armature", "kv"), [(0.0, 8.0), (0.001, 4.0), (0.002, 10.0)])
def test_check_tries_a_robot_as_it_drives_too(tmp_path, armature, kv):
    world = world_with(tmp_path, rover(armature=armature, kv=kv))
    code, said = typed("check", str(world))
    assert (code, len(said.splitlines())) == (2, 1)
    assert f"with kv={kv:g} is too stiff for joint 'r/" in said
    with Simulation(load_world(world)) as sim:
        stepped(sim, 10)
        sim.apply("r", WheelCommand((5.0, 5.0)))
        with pytest.raises(PhysicsFault, match="too stiff"):
            stepped(sim, 100)


def test_a_robot_of_the_users_own_drive_has_meshes(tmp_path):
    (tmp_path / "tyre.obj").write_text("v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    text = rover(looks='<geom type="mesh" mesh="m" mass="0.1"/>', assets='<mesh name="m" file="tyre.obj"/>')
    world = world_with(tmp_path, text)
    assert typed("check", str(world)) == (0, "")
    with Simulation(load_world(world)) as sim:
        sim.apply("r", WheelCommand((5.0, 5.0)))
        for _ in range(50):
            sim.step()
        # The mesh drags on the floor to one side.
        assert sim.truth("r").x > 0.1


def test_a_fault_of_physics_names_the_servo_that_is_too_stiff(tmp_path):
    world = load_world(world_with(tmp_path, rover(armature=0.0, kv=400.0)))
    with Simulation(world) as sim:
        sim.apply("r", WheelCommand((5.0, 5.0)))
        with pytest.raises(PhysicsFault, match=r"likely cause: servo 'r/\w+' with kv=400 is too stiff.*no armature"):
            stepped(sim, 100)
