"""Inertias that are mended are such as MuJoCo takes."""

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest

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
