"""Bodies of mechanisms from files: their masses as MuJoCo has them, their shapes, and what a file may not be."""

import math

import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.compile import check_models
from mjsim.errors import WorldError
from mjsim.record.recording_writer import named_files

LEVER = """
<mujoco><worldbody><body name="lever" pos="0.1 0.2 0.3" euler="20 30 40">
  {free}<geom type="box" size="0.3 0.05 0.02" mass="2"/>
  <body pos="0.3 0 0.1" euler="0 50 0">
    {joint}<geom type="capsule" fromto="0 0 0 0 0.2 0.1" size="0.02" mass="0.7"/>
    <geom type="sphere" size="0.04" pos="0 0.2 0.1" contype="0" conaffinity="0" mass="0.1"/>
  </body></body></worldbody></mujoco>
"""
HELD = '<joint type="hinge" axis="0 0 1" range="-10 60" ref="15"/>'
WORLD = """\
mjsim: 1
mechanisms:
  - name: m
    elevation: 3
    bodies: [{{name: b, model: lever.xml{keys}}}]
    joints: [{{revolute: q, of: [ground, b], axis: [0, 1, 0], start_deg: {start}}}]
run: {{seconds: 1}}
"""


@pytest.fixture
def world(tmp_path):
    def made(keys="", *, start=30.0, file=None):
        (tmp_path / "lever.xml").write_text(file or LEVER.format(free="", joint=HELD))
        (tmp_path / "m.yaml").write_text(WORLD.format(keys=keys, start=start))
        return mjsim.load_world(tmp_path / "m.yaml")

    return made


def weighed_by_mujoco(scale=1.0):
    """Return mass, centre of mass and inertia about it of the lever, whose hinge is stiff, frame of the file."""
    model = mujoco.MjModel.from_xml_string(LEVER.format(free="<freejoint/>", joint=""))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((6, 6))
    mujoco.mj_fullM(model, data, full)
    turn, center = data.xmat[1].reshape(3, 3), data.subtree_com[1]
    offset = center - data.xpos[1]
    about = turn @ full[3:, 3:] @ turn.T - full[0, 0] * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return full[0, 0] * scale**3, center * scale, about * scale**5


@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_a_body_weighs_what_mujoco_says_of_its_file(world, scale):
    mass, center, inertia = weighed_by_mujoco(scale)
    solid = world(f", scale: {scale}").mechanisms[0].body("b").solid()
    xx, yy, zz, xy, yz, xz = solid.inertia
    assert solid.mass == pytest.approx(mass)
    assert solid.center == pytest.approx(center, abs=1e-12)
    assert np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) == pytest.approx(inertia, abs=1e-12)


def test_it_stands_in_the_scene_as_in_its_file(world):
    made = world()
    model = mjsim.compile_world(made).compile()
    data, own = mujoco.MjData(model), made.mechanisms[0].body("b").shape.whole.rest
    mujoco.mj_kinematics(model, data)
    tilt = math.radians(30.0)
    turn = np.array([[math.cos(tilt), 0.0, math.sin(tilt)], [0.0, 1.0, 0.0], [-math.sin(tilt), 0.0, math.cos(tilt)]])
    for number, name in enumerate(("m/b", "m/b-2", "m/b-3")):
        place = turn @ own.data.geom_xpos[number] + [0.0, 0.0, 3.0]
        assert data.geom(name).xpos == pytest.approx(place, abs=1e-9)
        assert model.geom(name).contype[0] == own.model.geom_contype[number]


def test_it_swings_as_a_pendulum_of_its_inertia(world):
    """The period of small swings about the vertical, by the closed form of a physical pendulum."""
    mass, center, inertia = weighed_by_mujoco()
    arm = math.hypot(center[0], center[2])
    hanging = 180.0 - math.degrees(math.atan2(center[0], center[2]))  # the centre is below the hinge
    with mjsim.Simulation(world(start=hanging + 1.0)) as sim:
        recording = mjsim.run(sim, seconds=3.0)
    angle = recording.joints["m"].positions[:, 0]
    time = recording.time
    middle = (angle.max() + angle.min()) / 2.0
    above = angle > middle
    ups = np.flatnonzero(~above[:-1] & above[1:])
    crossed = time[ups] + (middle - angle[ups]) / (angle[ups + 1] - angle[ups]) * (time[ups + 1] - time[ups])
    moment = inertia[1, 1] + mass * arm**2
    assert np.diff(crossed) == pytest.approx(2.0 * math.pi * math.sqrt(moment / (mass * 9.81 * arm)), rel=2e-3)


def test_its_file_goes_into_recordings(world):
    assert named_files(world()) == ["lever.xml"]


BARE = '<mujoco><worldbody><geom type="box" size="0.1 0.1 0.1" mass="0"/></worldbody></mujoco>'


def test_a_file_without_a_mass_needs_one_of_the_world(world):
    with pytest.raises(WorldError, match=r"m.yaml:5:31: 'lever.xml' has no mass; give mass, center"):
        world(file=BARE)
    given = world(", mass: 2, center: [0, 0, 0.1], inertia: [1, 1, 1, 0, 0, 0]", file=BARE)
    assert given.mechanisms[0].body("b").solid().inertia == (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("<mujoco><worldbody>", r"m.yaml:5:31: .*lever.xml"),
        ("<mujoco><worldbody/></mujoco>", r"m.yaml:5:31: 'lever.xml' has no shape"),
    ],
)
def test_an_unreadable_file_is_reported_where_it_is_named(world, file, line):
    with pytest.raises(WorldError, match=line):
        check_models(world(file=file))


def test_a_missing_file_is_reported(tmp_path):
    with pytest.raises(WorldError, match=r"w.yaml:5:31: .*lever.xml"):
        mjsim.parse_world(WORLD.format(keys="", start=30), file=str(tmp_path / "w.yaml"))
