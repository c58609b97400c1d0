"""Arms in xacro, with arguments, includes and Collada: as from URDF, in the command and in a world."""

import numpy as np
import pytest

import mjsim
from mjsim.errors import MjsimError
from mjsim.interface import JointGoal
from mjsim.world import Source, arm_item, load_world
from tests.models.test_mesh_files import collada

LINK = """<link name="{0}">{1}<inertial><mass value="1"/><origin xyz="${{l / 2}} 0 0"/>
  <inertia ixx="0.001" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{0}_joint" type="revolute"><parent link="{2}"/><child link="{0}"/><origin xyz="{3} 0 0"/>
  <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="10" velocity="3"/></joint>"""
MESH = '<visual><geometry><mesh filename="package://two/meshes/a.dae"/></geometry></visual>'
TWO = f"""<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="length" default="0.4"/>
  <xacro:include filename="$(find two)/urdf/parts.xacro"/><xacro:include filename="$(find gone)/unused.xacro"/>
  <xacro:property name="l" value="$(arg length)"/><link name="base"/>{LINK.format("upper", MESH, "base", "0")}
  {LINK.format("lower", "", "upper", "${l}")}<xacro:tip of="lower"/></robot>"""
PARTS = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="tip" params="of"><link name="tool0"/>
  <joint name="tip" type="fixed"><parent link="${of}"/><child link="tool0"/><origin xyz="${l} 0 0"/></joint>
  </xacro:macro></robot>"""


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Return the file of an arm of two links in a ROS package."""
    package = tmp_path_factory.mktemp("ws") / "two"
    files = {"package.xml": b"<package/>", "urdf/two.xacro": TWO.encode(), "urdf/parts.xacro": PARTS.encode()}
    for name, data in {**files, "meshes/a.dae": collada("", "")}.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_bytes(data)
    return package / "urdf" / "two.xacro"


@pytest.mark.parametrize(("arguments", "reach"), [({}, 0.8), ({"length": "0.3"}, 0.6)])
def test_an_arm_of_xacro_reaches_as_far_as_its_arguments_say_to_the_frame_called_tool0(two, arguments, reach):
    arm = mjsim.arm(two, arguments=arguments)
    assert arm.fkine(np.zeros(2))[:3, 3] == pytest.approx((reach, 0, 0))
    item = arm_item(two, arguments=arguments)
    (flange,), (place,) = item.file_arm.notes, item.file_arm.changed
    assert place.startswith("left out: include '")
    assert "'package://gone/unused.xacro', which was not found" in place
    assert flange == "flange: at 'tool0', chosen by its name; name another frame with end"
    assert item.file_arm.model.nmesh == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"lenght": "1"}, ":1:1: .*has no xacro:arg 'lenght'; those that it uses are length"),
        ({"length": "x"}, "cannot be computed"),
    ],
)
def test_an_argument_that_is_wrong_is_one_line(two, arguments, says):
    with pytest.raises(MjsimError, match=says) as caught:
        mjsim.arm(two, arguments=arguments)
    assert "\n" not in str(caught.value)


def test_a_world_has_an_arm_of_xacro(two):
    place = two.parents[2] / "w.yaml"
    place.write_text(
        "mjsim: 1\nrobots:\n  - {name: r, base: fixed, at: [0, 0],"
        " arms: [{model: two/urdf/two.xacro, arguments: {length: '0.5'}}]}\n"
    )
    (arm,) = load_world(place).robots[0].arms
    assert arm.arm.fkine(np.zeros(2))[:3, 3] == pytest.approx((1.0, 0, 0))
    with pytest.raises(MjsimError, match="arguments are for a model in xacro; leave them out"):
        mjsim.parse_world(
            "mjsim: 1\nrobots: [{name: r, base: fixed, at: [0, 0], arms: [{preset: puma560, arguments: {a: b}}]}]"
        )


FINGER = """<link name="{0}"><inertial><mass value="0.1"/>
  <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{0}_joint" type="prismatic"><parent link="lower"/><child link="{0}"/><origin xyz="0.4 0 0"/>
  <axis xyz="0 {1} 0"/><limit lower="-0.1" upper="0.1" effort="10" velocity="1"/>{2}</joint>"""
MIMIC = '<mimic joint="left_joint" multiplier="0.5" offset="0.02"/>'


def test_a_mimic_joint_follows_its_leader(tmp_path):
    arm = LINK.format("upper", "", "base", "0") + LINK.format("lower", "", "upper", "0.4")
    fingers = FINGER.format("left", 1, "") + FINGER.format("right", -1, MIMIC)
    text = f'<robot name="g"><link name="base"/>{arm}{fingers}</robot>'.replace("${l / 2}", "0.2")
    (tmp_path / "g.urdf").write_text(text)
    world = mjsim.parse_world(
        "mjsim: 1\nrobots:\n  - {name: r, base: fixed, at: [0, 0], arms: [{model: g.urdf}]}\n",
        source=Source(file="w.yaml", folder=tmp_path),
    )
    (item,) = world.robots[0].arms
    assert "coupled: 'right_joint' is 0.5 times 'left_joint' + 0.02" in item.file_arm.notes
    goal = JointGoal(positions=(0.0, 0.0, 0.06, 0.0))
    with mjsim.Simulation(world, seed=1) as sim:
        for _ in range(50):
            sim.apply("r", mjsim.Command(joints={"arm": goal}))
            sim.step()
        left, right = sim.sense("r").joints["arm"].positions[2:]
    assert left == pytest.approx(0.06, abs=2e-3)
    assert right == pytest.approx(0.5 * left + 0.02, abs=1e-3)
