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
    note = (
        "the inertia of link 'b' is as if all its mass were 2.00 m away, but it reaches 0.20 m; made that of its size"
    )
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
