"""Arms from files of MJCF and URDF, against MuJoCo's own reading of the same files."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize

import mjsim
from mjsim.cli import main
from mjsim.errors import UsageError, WorldError
from mjsim.world import world_notes

DATA = Path(__file__).parents[1] / "data" / "arms"
GRIPPER, LAMP = DATA / "gripper.xml", DATA / "lamp.urdf"


class Plain:
    """A file as MuJoCo has it, no mjsim involved."""

    def __init__(self, text, joints, base=None):
        self.model = mujoco.MjModel.from_xml_string(text) if base is None else mujoco.MjModel.from_xml_path(str(base))
        self.data = mujoco.MjData(self.model)
        found = [self.model.joint(name) for name in joints]
        self.q, self.v = [joint.qposadr[0] for joint in found], [joint.dofadr[0] for joint in found]
        self.model.dof_damping[:], self.model.dof_frictionloss[:] = 0.0, 0.0
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT

    def pose(self, q, kind, name):
        self.data.qpos[self.q] = q
        mujoco.mj_kinematics(self.model, self.data)
        pose, found = np.eye(4), getattr(self.data, kind)(name)
        pose[:3, :3], pose[:3, 3] = found.xmat.reshape(3, 3), found.xpos
        return pose

    def torques(self, q, qd, qdd):
        self.data.qpos[self.q], self.data.qvel[self.v], self.data.qacc[self.v] = q, qd, qdd
        mujoco.mj_inverse(self.model, self.data)
        return self.data.qfrc_inverse[self.v].copy()


def gripper():
    return Plain("", ["pan", "lift", "reach", "left", "right"], base=GRIPPER)


@pytest.mark.parametrize(
    ("end", "kind", "name"), [(None, "body", "sleeve"), ("hand", "body", "hand"), ("grip", "site", "grip")]
)
def test_the_flange_is_where_mujoco_has_that_part_of_the_file(end, kind, name):
    arm, plain = mjsim.arm(GRIPPER, end=end), gripper()
    for q in np.random.default_rng(1).uniform(-2.0, 2.0, (200, 5)):
        np.testing.assert_allclose(arm.fkine(q), plain.pose(q, kind, name), atol=1e-12)


@pytest.mark.slow
def test_torques_are_mujocos_with_rotors_and_fingers():
    arm, plain = mjsim.arm(GRIPPER), gripper()
    for q, qd, qdd in np.random.default_rng(2).uniform(-1.0, 1.0, (50, 3, 5)):
        np.testing.assert_allclose(arm.rne_nofriction(q, qd, qdd), plain.torques(q, qd, qdd), atol=1e-12)
        np.testing.assert_allclose(arm.gravload(q), plain.torques(q, 0.0, 0.0), atol=1e-12)
        mass = arm.inertia(q)
        np.testing.assert_allclose(mass @ qdd + arm.gravload(q), plain.torques(q, 0.0, qdd), atol=1e-12)
        rigid = arm.coriolis(q, qd) @ qd + mass @ qdd + arm.gravload(q)
        np.testing.assert_allclose(rigid, plain.torques(q, qd, qdd), atol=1e-12)
        known = arm.regressor(q, qd, qd, qdd) @ arm.parameters() + arm.armature() * qdd
        np.testing.assert_allclose(known, plain.torques(q, qd, qdd), atol=1e-12)


def test_fingers_are_the_last_joints_and_do_not_move_the_tool():
    arm = mjsim.arm(GRIPPER, end="grip")
    assert [link.label for link in arm.links] == ["pan", "lift", "reach", "left", "right"]
    assert arm.parents == (-1, 0, 1, 2, 2)
    q = np.array([0.4, -0.5, 0.1, 0.01, 0.02])
    np.testing.assert_array_equal(arm.jacob0(q)[:, 3:], 0.0)
    found = arm.ikine(arm.fkine(q), q0=[0.0, 0.0, 0.0, 0.03, 0.005], mask=(1, 1, 1, 0, 0, 0))
    assert found.converged
    np.testing.assert_array_equal(found.q[3:], [0.03, 0.005])


def test_limits_are_those_of_joints_and_actuators():
    links = mjsim.arm(GRIPPER).links
    # Gear times control range, force range, actuatorfrcrange, and half of what pulls the tendon.
    np.testing.assert_allclose([link.max_torque for link in links], [60, 45, 60, 20, 20])
    np.testing.assert_allclose(np.degrees([links[1].lower, links[1].upper]), [-120, 60])
    assert (links[0].rotor_inertia, links[0].viscous, links[0].coulomb) == (0.02, 0.4, (0.1, -0.1))


def test_a_urdf_has_the_limits_of_its_text_and_the_frame_that_is_named():
    arm = mjsim.arm(LAMP, end="tip")
    assert [link.label for link in arm.links] == ["tilt", "bend", "slide"]
    np.testing.assert_array_equal([link.max_torque for link in arm.links], [20, 10, 30])
    np.testing.assert_array_equal([link.max_velocity for link in arm.links], [2, np.inf, 0.5])
    assert arm.limits[1].tolist() == [1.5, np.inf, 0.2]

    def turned(axis, angle):
        quaternion, matrix = np.zeros(4), np.zeros(9)
        mujoco.mju_axisAngle2Quat(quaternion, np.array(axis), angle)
        mujoco.mju_quat2Mat(matrix, quaternion)
        pose = np.eye(4)
        pose[:3, :3] = matrix.reshape(3, 3)
        return pose

    def at(*place):
        pose = np.eye(4)
        pose[:3, 3] = place
        return pose

    q = [0.3, -0.7, 0.15]
    tilt = at(0, 0, 0.05) @ turned([0.0, 0, 1], 0.3) @ turned([0.0, 1, 0], q[0])
    bend = tilt @ at(0, 0, 0.4) @ turned([1.0, 0, 0], 0.2) @ turned([0.0, 0.6, 0.8], q[1])
    tip = bend @ at(0.3 + q[2], 0, 0) @ at(0.05, 0, 0) @ turned([0.0, 1, 0], 1.57)
    np.testing.assert_allclose(arm.fkine(q), tip, atol=1e-12)


def test_what_is_beside_the_chain_is_rigid_at_the_limit_next_to_zero():
    heavy = mjsim.arm(LAMP, end="tip").links[1]
    assert heavy.mass == pytest.approx(0.6 + 0.2)
    # The shade weighs 0.2 kg at (0.1, 0, -0.05), the link 0.6 kg at (0.1, 0, 0).
    np.testing.assert_allclose(heavy.center, [0.1, 0, -0.05 / 4], atol=1e-12)


def test_a_link_without_mass_is_a_capsule():
    rod = mjsim.arm(LAMP, end="tip").links[2]
    length, radius = 0.05, rod.radius
    assert rod.mass == pytest.approx(1000 * np.pi * radius**2 * (length + 4 / 3 * radius), rel=1e-9)


CHAIN = (
    '<mujoco><worldbody>{}<body name="a"><joint name="j"{}/><geom name="g" size="0.1"/>{}</body></worldbody></mujoco>'
)
TWO = "".join(
    f'<body name="{name}" pos="1 0 0"><joint name="{name}"/><joint axis="1 0 0"/><geom size="0.1"/></body>'
    for name in "bc"
)
WRONG = {
    "'a.xml' has a free joint; an arm stands on its base, remove the joint": CHAIN.format(
        "", "", '<body><freejoint/><geom size="1"/></body>'
    ),
    "'a.xml' has a free joint 'j'; an arm stands on its base, remove the joint": CHAIN.format("", ' type="free"', ""),
    "'a.xml' has a ball joint 'j'; an arm has hinges and slides": CHAIN.format("", ' type="ball"', ""),
    "'a.xml' branches, to 'b', 'c'; name the body that carries the tool by end, or --end": CHAIN.format("", "", TWO),
    "'a.xml' has no joint that turns or slides; an arm has at least one": (
        "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>"
    ),
    "body: the inertia of body 'b' breaks the triangle inequality (0.1 + 0.1 < 0.3 kg m^2); correct it": (
        CHAIN.format("", "", '<body name="b"><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.3"/></body>')
    ),
    "'a.xml' is not XML: mismatched tag: line 1, column 13; correct it": "<mujoco><a></b></mujoco>",
    "'a.xml' begins with <sdf>; a model begins with <mujoco> (MJCF) or <robot> (URDF)": "<sdf/>",
    "'a.xml' has an impossible body: mass of 'b' is -1; give finite numbers, the mass not below 0": (
        CHAIN.format("", "", '<body name="b"><inertial pos="0 0 0" mass="-1" diaginertia="1 1 1"/></body>')
    ),
    "'a.xml' has an impossible body: diaginertia of 'b' is 1 nan 1; give finite numbers, the mass not below 0": (
        CHAIN.format("", "", '<body name="b"><inertial pos="0 0 0" mass="1" diaginertia="1 nan 1"/></body>')
    ),
    "no file 'no.stl' beside the world file or in assets": (
        '<mujoco><asset><mesh name="m" file="no.stl"/></asset><worldbody><body><joint/>'
        '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>'
    ),
}


@pytest.mark.parametrize(("sentence", "text"), WRONG.items())
def test_what_is_no_arm_is_refused_in_a_line(sentence, text, tmp_path):
    (tmp_path / "a.xml").write_text(text)
    with pytest.raises(WorldError) as caught:
        mjsim.load_world(_world(tmp_path, "arms: [{model: a.xml}]"))
    line = str(caught.value)
    assert line.startswith(f"{tmp_path / 'w.yaml'}:2:60: "), line
    assert line.endswith(sentence), line


def _world(folder, arms):
    path = folder / "w.yaml"
    path.write_text(f"mjsim: 1\nrobots: [{{name: r, base: fixed, at: [0, 0], {arms}}}]\n")
    return path


def test_a_wrong_model_is_reported_alone_with_its_place(tmp_path):
    path = tmp_path / "a.urdf"
    path.write_text(
        '<robot name="r">\n  <link name="a"/>\n  <link name="b"/>\n'
        '  <joint name="float" type="floating"><parent link="a"/><child link="b"/></joint>\n</robot>'
    )
    with pytest.raises(WorldError) as caught:
        mjsim.arm(path)
    assert (
        str(caught.value)
        == f"{path}:4:3: 'a.urdf' has a free joint 'float'; an arm stands on its base, remove the joint"
    )


def test_an_end_that_is_not_there_is_told_with_a_near_name(tmp_path):
    with pytest.raises(WorldError, match=r"has no body or site 'gripp'; did you mean 'grip'\?$"):
        mjsim.arm(GRIPPER, end="gripp")
    with pytest.raises(WorldError, match=r"'stand' of 'gripper.xml' does not move with any joint"):
        mjsim.arm(GRIPPER, end="stand")
    with pytest.raises(UsageError, match="end is 'x'; it is for models"):
        mjsim.arm("puma560", end="x")
    with pytest.raises(UsageError, match=r"no file '.*none.xml'; name an MJCF"):
        mjsim.arm(tmp_path / "none.xml")


def test_what_is_for_other_programs_is_passed_over_with_or_without_a_declared_prefix(tmp_path):
    plain = LAMP.read_text()
    told = plain.replace("<limit ", '<limit drake:acceleration="2" ').replace(
        "</robot>", '<drake:proximity a="1"><drake:b/></drake:proximity></robot>'
    )
    assert told.count("drake:") >= 4
    for number, text in enumerate((told, told.replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" ', 1))):
        (tmp_path / f"{number}.urdf").write_text(text)
        arm, same = mjsim.arm(tmp_path / f"{number}.urdf"), mjsim.arm(LAMP)
        q = 0.3 * np.ones(same.n)
        np.testing.assert_array_equal(arm.fkine(q), same.fkine(q))


def test_an_inertia_that_slightly_misses_the_triangle_inequality_becomes_the_nearest_valid_one(tmp_path, capsys):
    given = np.array([0.1, 0.12, 0.25])
    body = f'<inertial pos="0 0 0" mass="1" diaginertia="{" ".join(map(str, given))}"/>'
    (tmp_path / "a.xml").write_text(f"<mujoco><worldbody><body><joint/>{body}</body></worldbody></mujoco>")
    valid = {"type": "ineq", "fun": lambda moments: moments[0] + moments[1] - moments[2]}
    nearest = minimize(lambda moments: ((moments - given) ** 2).sum(), given, constraints=[valid], tol=1e-12).x
    np.testing.assert_allclose(np.sort(mjsim.arm(tmp_path / "a.xml").links[0].inertia[:3]), nearest, rtol=1e-6)
    with pytest.raises(SystemExit, match=r"^0$"):
        main(["arm", str(tmp_path / "a.xml")])
    said = f"made {', '.join(f'{moment:.3g}' for moment in nearest)} kg m^2"
    assert f"slightly misses the triangle inequality (0.1 + 0.12 < 0.25 kg m^2); {said}" in capsys.readouterr().out


def test_an_inertia_far_beyond_the_size_of_a_link_is_reduced_and_told(tmp_path, capsys):
    (tmp_path / "a.urdf").write_text(
        """<robot name="r"><link name="base"/><link name="arm"><inertial><mass value="0.005"/><origin xyz="0.1 0 0"/>
        <inertia ixx="2" iyy="2" izz="2" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>"""
    )
    with pytest.raises(SystemExit, match=r"^0$"):
        main(["arm", str(tmp_path / "a.urdf")])
    said = "the inertia of link 'arm' is as if all its mass were 20.00 m away, but it reaches 0.10 m; scaled to its"
    assert said in capsys.readouterr().out
    inertia = mjsim.arm(tmp_path / "a.urdf").links[0].inertia
    np.testing.assert_allclose(inertia, 0.005 * 0.05**2 * np.array([1, 1, 1, 0, 0, 0]), rtol=1e-6)


@pytest.mark.slow  # trimesh is imported
def test_colours_and_pictures_beside_the_mesh_of_an_arm_are_told(tmp_path, capsys):
    corners = "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\nvt 0 0\nvt 1 0\nvt 0 1\n"
    (tmp_path / "m.obj").write_text(
        f"mtllib m.mtl\n{corners}usemtl a\nf 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 3/1 1/2 4/3\n"
    )
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 1 1\nmap_Kd red.png\n")
    (tmp_path / "a.urdf").write_text(
        """<robot name="r"><link name="base"/><link name="arm"><inertial><mass value="1"/>
        <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
        <visual><geometry><mesh filename="m.obj"/></geometry></visual></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>"""
    )
    with pytest.raises(SystemExit, match=r"^0$"):
        main(["arm", str(tmp_path / "a.urdf")])
    assert "left out: look of mesh 'm.obj': an arm shows no pictures of meshes" in capsys.readouterr().out


def test_a_mesh_with_texture_coordinates_at_some_faces_only_is_taken(tmp_path):
    corners = "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\nvt 0 0\nvt 1 0\nvt 0 1\n"
    (tmp_path / "m.obj").write_text(corners + "f 1/1 3/3 2/2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    (tmp_path / "a.xml").write_text(
        '<mujoco><asset><mesh name="m" file="m.obj"/></asset><worldbody><body><joint/>'
        '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>'
    )
    # A tetrahedron of 0.2 m of MuJoCo's density of water.
    assert mjsim.arm(tmp_path / "a.xml").links[0].mass == pytest.approx(1000 * 0.2**3 / 6, rel=1e-6)


def test_an_arm_of_urdf_moves_without_its_meshes_and_pictures_and_they_are_told(tmp_path, capsys):
    (tmp_path / "a.urdf").write_text(
        """<robot name="r"><material name="m"><texture filename="package://gone/skin.png"/></material>
        <link name="base"/><link name="arm"><inertial><mass value="1"/><origin xyz="0.1 0 0"/>
        <inertia ixx="-1e-20" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
        <visual><geometry><mesh filename="package://gone/arm.stl"/></geometry><material name="m"/></visual></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>"""
    )
    with pytest.raises(SystemExit) as left:
        main(["arm", str(tmp_path / "a.urdf")])
    said = capsys.readouterr()
    assert left.value.code == 0
    assert "1 turns" in said.out
    gone = [
        "left out: missing mesh 'arm.stl': collision shapes are used instead",
        "left out: missing picture 'skin.png': plain colours are used instead",
    ]
    assert all(line in said.out for line in gone)
    assert "the inertia of link 'arm' is that of a rod without thickness" in said.out
    place = _world(tmp_path, "arms: [{model: a.urdf}]")
    *left_out, inertia = (str(problem) for problem in world_notes(mjsim.load_world(place)))
    assert f"{place}:2:60: arm 'r/arm': the inertia of link 'arm' is that of a rod" in inertia
    assert left_out == [f"{place}:2:60: arm 'r/arm': {line}" for line in gone]


def test_what_xacro_should_have_expanded_is_refused(tmp_path):
    told = LAMP.read_text().replace("</robot>", "<xacro:more/></robot>")
    (tmp_path / "lamp.urdf").write_text(told)
    with pytest.raises((UsageError, WorldError, ValueError), match="unbound prefix"):
        mjsim.arm(tmp_path / "lamp.urdf")


def test_an_expression_of_xacro_in_place_of_a_number_is_named_with_its_line(tmp_path):
    told = LAMP.read_text().replace("<axis", '<origin rpy="0 ${pi/2} 0"/><axis', 1)
    (tmp_path / "lamp.urdf").write_text(told)
    with pytest.raises((UsageError, WorldError)) as caught:
        mjsim.arm(tmp_path / "lamp.urdf")
    assert "has '0 ${pi/2} 0' in 'rpy', an expression of xacro; write the number, or expand" in str(caught.value)


LINK = """<link name="{name}"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>"""


@pytest.mark.parametrize("end", ["tool0", "end_effector_link", "x_eef"])
def test_a_frame_without_mass_at_the_end_is_the_flange_and_adds_nothing_to_the_torques(end, tmp_path):
    # Arms of URDF end in such frames: tool0, or the flange.
    links = [LINK.format(name="base"), LINK.format(name="arm"), f'<link name="{end}"/>']
    joints = [
        '<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>'
        '<limit lower="-2" upper="2" effort="9" velocity="2"/></joint>',
        f'<joint name="end" type="fixed"><parent link="arm"/><child link="{end}"/><origin xyz="0.8 0 0"/></joint>',
    ]
    (tmp_path / "a.urdf").write_text(f'<robot name="a">{"".join(links)}{"".join(joints)}</robot>')
    found = mjsim.arm(tmp_path / "a.urdf")
    assert found.fkine([0.0])[:3, 3] == pytest.approx([0.8, 0.0, 0.0])
    assert found.links[0].mass == pytest.approx(2.0, abs=1e-11)
    assert float(found.gravload(np.zeros(1))[0]) == pytest.approx(-2.0 * 9.81 * 0.3, abs=1e-10)
