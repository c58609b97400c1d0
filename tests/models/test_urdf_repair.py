"""Sizes of shapes and scales of meshes as people write them."""

from xml.etree.ElementTree import fromstring, tostring

import mujoco
import pytest

from mjsim.models.urdf_repair import firsts, mend_scales, mend_sizes


@pytest.mark.parametrize(
    ("written", "read"),
    [("1 1 1 1", "1 1 1"), ("0.001", "0.001 0.001 0.001"), ("1, 2, 3", "1 2 3"), ("1 2 3", "1 2 3"), ("1 2", "1 2")],
)
def test_a_scale_of_a_mesh_has_three_numbers_if_they_are_clear(written, read):
    root = fromstring(f'<robot><mesh scale="{written}"/><mesh/></robot>')
    said = list(mend_scales(root))
    assert root[0].get("scale") == read
    assert bool(said) == (written != read)
    assert root[1].get("scale") is None


FLAT = """<robot name="r"><link name="base"><visual><geometry><box size="0 0 0"/></geometry></visual>
<collision><geometry><box size="0.3 0.2 0"/></geometry></collision></link>
<link name="disc"><visual><geometry><cylinder radius="0.1" length="0"/></geometry></visual></link>
<joint name="j" type="fixed"><parent link="base"/><child link="disc"/></joint></robot>"""


def test_shapes_of_no_size_are_left_out_and_flat_ones_made_thin():
    root = fromstring(FLAT)
    with pytest.raises(ValueError, match="must be positive in geom"):
        mujoco.MjModel.from_xml_string(FLAT)
    assert list(mend_sizes(root, "r.urdf")) == [
        "r.urdf: a box of link 'base' has no size; left out",
        "r.urdf: a box of link 'base' is flat; made 0.001 m thin",
        "r.urdf: a cylinder of link 'disc' is flat; made 0.001 m thin",
    ]
    model = mujoco.MjModel.from_xml_string(tostring(root, encoding="unicode"))
    assert sorted(model.geom_size[:, :2].tolist()) == [[0.15, 0.1]]


TWICE = FLAT.replace('<box size="0 0 0"/>', '<box size="1 1 1"/><mesh filename="a.stl"/>').replace(
    '<child link="disc"/>', '<child link="disc"/><origin xyz="1 0 0"/><origin xyz="2 0 0"/>'
)


def test_of_what_a_robot_has_once_the_first_counts():
    with pytest.raises(ValueError, match="repeated element"):
        mujoco.MjModel.from_xml_string(TWICE)
    root = fromstring(TWICE)
    assert list(firsts(root, "r.urdf")) == [
        "left out: r.urdf: repeated <mesh> in link 'base'; the first is used, as in ROS",
        "left out: r.urdf: repeated <origin> in joint 'j'; the first is used, as in ROS",
    ]
    assert list(firsts(root, "r.urdf")) == []
    assert [shape.get("size") for shape in root.iter("box")] == ["1 1 1", "0.3 0.2 0"]
    assert [origin.get("xyz") for origin in root.iter("origin")] == ["1 0 0"]
