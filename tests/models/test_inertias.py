"""Inertias that are mended are such as MuJoCo takes."""

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest

from mjsim.models import gather_robot
from mjsim.models.inertia_repair import mend_inertias

LINK = """<robot name="r"><link name="base"/><link name="part"><inertial><mass value="0.003"/>
<inertia ixx="{}" iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="continuous"><parent link="base"/><child link="part"/><axis xyz="0 1 0"/></joint></robot>"""


@pytest.mark.parametrize(
    "moments",
    [(1e-7, 1.1e-15, 1e-7), (1e-7, 0.0, 1e-7), (1e-16, 1e-16, 1e-16), (1e-7, 1e-7, 3e-7), (-1e-7, 1e-7, 1e-7)],
)
def test_inertias_that_mujoco_refuses_are_repaired_and_reported(moments):
    text = LINK.format(*moments)
    with pytest.raises(ValueError, match="inertia"):
        mujoco.MjModel.from_xml_string(text)
    root = ET.fromstring(text)
    (said,) = mend_inertias(root, "r.urdf")
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    *small, large = np.sort(model.body_inertia[-1])
    assert "link 'part'" in said
    assert 0.0 < large <= sum(small) * (1.0 + 1e-9)


def test_an_inertia_far_beyond_the_size_of_a_body_is_made_that_of_its_size():
    text = b"""<robot name="r"><link name="b"><inertial><mass value="2"/>
    <inertia ixx="8" iyy="8" izz="8" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.2"/></geometry></collision></link></robot>"""
    files = gather_robot("r.urdf", lambda _: text)
    # Half of the reach of 0.2 m is the radius of gyration.
    assert files.model.body_inertia[1] == pytest.approx([2.0 * 0.1**2] * 3)
    note = "the inertia of link 'b' is as if all its mass were 2.00 m away, but it reaches 0.20 m; scaled to its size"
    assert f"r.urdf: {note}" in files.notes


def test_so_is_that_of_a_feather_without_shapes_that_outweighs_the_robot():
    text = b"""<robot name="r"><link name="b"><inertial><mass value="2"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.2"/></geometry></collision></link>
    <link name="cliff"><inertial><mass value="0.01"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="j" type="fixed"><parent link="b"/><child link="cliff"/></joint></robot>"""
    files = gather_robot("r.urdf", lambda _: text)
    assert files.model.body_inertia[2] == pytest.approx([0.01 * 0.1**2] * 3)
    assert any("link 'cliff' is as if all its mass were 10.00 m away" in note for note in files.notes)


@pytest.mark.parametrize("inertia", ["", '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>'])
def test_a_link_with_a_mass_and_shapes_but_no_inertia_has_that_of_its_shapes(inertia):
    text = f"""<robot name="r"><link name="b"><inertial><origin xyz="0 0 0.1" rpy="0 0 1"/><mass value="30"/>{inertia}
    </inertial><collision><origin xyz="0 0 0.1" rpy="0 0 1.5707963267948966"/><geometry>
    <box size="0.6 0.4 0.2"/></geometry></collision></link></robot>""".encode()
    files = gather_robot("r.urdf", lambda _: text)
    # m / 12 (a^2 + b^2), of the box turned by a quarter.
    x, y, z = (30 / 12 * (a**2 + b**2) for a, b in ((0.6, 0.2), (0.4, 0.2), (0.6, 0.4)))
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, files.model.body_iquat[1])
    axes = turned.reshape(3, 3)
    np.testing.assert_allclose(axes @ np.diag(files.model.body_inertia[1]) @ axes.T, np.diag([x, y, z]), atol=1e-6)
    assert (files.model.body_mass[1], files.model.body_ipos[1].tolist()) == (30.0, [0.0, 0.0, 0.1])
    (note,) = files.notes
    assert "link 'b' has no inertia" in note
    assert note.endswith("made 0.5, 1, 1.3 kg m^2, that of its shapes with its mass")


def test_a_link_without_inertia_whose_mesh_is_missing_keeps_that_of_a_ball():
    text = b"""<robot name="r"><link name="a"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <link name="b"><inertial><mass value="2"/></inertial><collision><geometry><mesh filename="gone.stl"/></geometry>
    </collision></link><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>"""

    def read(path: str) -> bytes:
        if path != "r.urdf":
            raise ValueError(f"no file {path}")
        return text

    files = gather_robot("r.urdf", read)
    assert files.model.body_inertia[2] == pytest.approx([0.4 * 2.0 * 0.05**2] * 3)
    assert any("link 'b' has no inertia; made 0.002 kg m^2, that of a ball" in note for note in files.notes)
