"""Small facts about files of robots and arms: each formula computed another way, each repair on the smallest file."""

import math
import struct
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest

from mjsim.models import gather_robot, line_and_column, line_of, names_in
from mjsim.models.arm_motors import motors_of
from mjsim.models.arm_tree import carried_by, chain_to, tree_of
from mjsim.models.files import ModelFiles, gather_model
from mjsim.models.inertias import mend_inertias, mend_weightless, mended, number_of
from mjsim.models.mjcf_scenes import without_mjcf_rails, without_scenery
from mjsim.models.places import PlacedError, element_of, numbered, plainly, starts
from mjsim.models.robot_files import robot_text, without_shapes
from mjsim.models.stl import tidy_stl
from mjsim.models.trials import model as model_fault
from mjsim.models.trials import picture as picture_fault
from mjsim.models.urdf_joints import freed_wheels, joint_speeds, without_rails

XML = b"<a>\n  <b name=\"left\"/>\n  <c  name='right'><b/></c>\n</a>"


def test_elements_are_told_by_line_and_column():
    assert starts(XML) == [("a", 1, 1), ("b", 2, 3), ("c", 3, 3), ("b", 3, 20)]
    assert starts(b"<a>\n<b/>\n<") == [("a", 1, 1), ("b", 2, 1)]
    assert line_of("left", XML) == ("b", 2, 3)
    assert line_of("right", XML) == ("c", 3, 3)
    assert line_of("none", XML) is None
    assert [line_and_column(XML.index(word), XML) for word in (b"<a", b"left", b"</a")] == [(1, 1), (2, 12), (4, 1)]
    assert names_in("joint 'a' of 'b c' and 'd'") == ["a", "d"]
    root = ET.fromstring(XML)
    origins = numbered(root, "f.xml")
    assert [(origins[each].path, origins[each].number) for each in root.iter()] == [("f.xml", k) for k in range(4)]
    error = PlacedError("f.xml", starts(XML)[1], "wrong")
    assert (str(error), error.path, error.what) == ("'f.xml':2:3: wrong", "f.xml", "wrong")


@pytest.mark.parametrize(
    ("error", "found"),
    [
        ("XML Error: bad\nElement 'b', line 2", 1),
        ("Element name 'right', id 1", 2),
        ("name 'left' twice", 1),
        ("line 3", None),  # two begin there
        ("Element 'b', line 3", 3),
        ("Element 'q', line 3", None),
        ("no words", None),
        ("name 'none'", None),
    ],
)
def test_errors_of_mujoco_lead_to_their_element(error, found):
    root = ET.fromstring(XML)
    assert element_of(error, root) is (None if found is None else list(root.iter())[found])


def test_errors_of_mujoco_are_told_plainly():
    element = ET.fromstring('<geom name="g"/>')
    said = "XML Error: size 0 must be positive\nElement 'geom', line 7"
    assert plainly(said, element) == "<geom> 'g': size 0 must be positive"
    assert plainly("Error: mass is 0.", ET.fromstring("<body/>")) == "<body>: mass is 0"


def sphere_of(count: int) -> np.ndarray:
    """Return `count` triangles over a bumpy square of 2 m, shape (count, 3, 3)."""
    side = math.ceil(math.sqrt(count / 2))
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    low = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    shifts = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]])
    return (low[:, None, None] + shifts).reshape(-1, 3, 3)[:count] * 2.0 / side


def binary(triangles: np.ndarray) -> bytes:
    records = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    records["c"] = triangles
    return bytes(80) + struct.pack("<I", len(triangles)) + records.tobytes()


def test_an_stl_in_words_becomes_the_same_triangles_in_bytes():
    corners = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.5e-1, 0.0]]]
    lines = "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners[0])
    written = tidy_stl(f" solid a\nfacet normal 0 0 1\nouter loop\n{lines}endloop\nendfacet\nendsolid".encode())
    (count,) = struct.unpack_from("<I", written, 80)
    assert (count, len(written)) == (1, 84 + 50)
    assert struct.unpack_from("<9f", written, 84 + 12) == pytest.approx(np.ravel(corners))
    for other in (
        b"solid a\nendsolid",
        b"solid vertex 1 2 3",
        b"no mesh",
        b"solid vertex 1 2 e vertex 1 2 3 vertex 1 2 3",
    ):
        assert tidy_stl(other) == other
    small = binary(np.array(corners))
    assert tidy_stl(small) is small


def test_a_fine_mesh_is_made_coarser_within_a_cell(monkeypatch):
    monkeypatch.setattr("mjsim.models.stl.MAX_TRIANGLES", most := 1000)
    triangles = sphere_of(2000)
    written = tidy_stl(binary(triangles))
    (count,) = struct.unpack_from("<I", written, 80)
    assert most / 3 < count <= most
    assert len(written) == 84 + 50 * count
    records = np.frombuffer(written, dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")], offset=84)
    corners = records["c"].astype(float)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(4.0, rel=0.15)
    assert (corners.min(), corners.max()) == pytest.approx((0.0, 2.0), abs=0.1)


def test_trials_say_what_is_wrong_or_nothing():
    from mjsim.models import encode_png

    assert picture_fault(encode_png(np.zeros((2, 2, 3), np.uint8))) is None
    assert picture_fault(b"no picture") is not None
    good = '<mujoco><worldbody><geom size="1"/></worldbody></mujoco>'
    for text, wrong in ((good, False), (good.replace('"1"', '"-1"'), True)):
        files = ModelFiles(ET.fromstring(text), {}, ("m.xml",))
        assert (model_fault(files) is not None) == wrong


@pytest.mark.parametrize(
    ("given", "moments", "word"),
    [
        ((1.0, 2.0, 2.5), None, None),
        ((1.0, 1.0, 2.0001), None, None),  # within the tolerance
        ((1.0, 1.0, 2.2), None, "slightly misses the triangle inequality"),
        ((0.5, 0.5, 4.0), None, "breaks the triangle inequality"),
        ((0.0, 1.0, 3.0), (1.5, 1.5, 3.0), "has a principal moment of "),
        ((-1.0, 2.0, 3.0), (1.5, 2.0, 3.0), "has a principal moment of -1 kg m^2"),
        ((1e-15, 1e-15, 1e-14), None, None),  # MuJoCo takes its own
        ((math.nan, 1.0, 1.0), (1e-6,) * 3, "is no number"),
    ],
)
def test_an_inertia_is_mended_in_its_own_axes(given, moments, word):
    turn = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, 4], [5, 6, 0]]))[0]
    found = mended(turn @ np.diag(given) @ turn.T)
    if word is None:
        assert found is None
        return
    matrix, said = found
    values = np.linalg.eigvalsh(matrix)
    assert said.startswith(word)
    assert values[2] < values[0] + values[1]
    if moments is not None:
        assert values == pytest.approx(moments)
    else:
        assert values[0] + values[1] - values[2] < 1e-6
        # The axes stay.
        assert turn.T @ matrix @ turn == pytest.approx(np.diag(np.diag(turn.T @ matrix @ turn)), abs=1e-9)


def urdf(links: str, joints: str = "") -> ET.Element:
    return ET.fromstring(f'<robot name="r">{links}{joints}</robot>')


def link(name: str, mass: str | None = None, inertia: str = "", more: str = "") -> str:
    inertial = "" if mass is None else f'<inertial><mass value="{mass}"/>{inertia}</inertial>'
    return f'<link name="{name}">{inertial}{more}</link>'


BODY = '<mujoco><worldbody><body name="b"><inertial pos="0 0 0" {}/></body></worldbody></mujoco>'
SHAPE = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
GOOD = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'


@pytest.mark.parametrize(
    ("text", "said", "left"),
    [
        (link("a", "2", GOOD), [], "2"),
        (link("a", "2"), ["link 'a' has no inertia; made 0.002 kg m^2, that of a ball of 0.05 m"], "2"),
        (link("a", "0", GOOD, SHAPE), ["has a mass of 0 kg; its shapes get a density of 1000"], None),
        (link("a", "x", GOOD), ["has a mass of nothing kg; it gets a negligible mass"], None),
        (link("a", "1", GOOD) + link("b", None, "", SHAPE), ["link 'b' has no mass; its shapes get"], "1"),
        (link("a", "1", GOOD) + link("b"), [], "1"),
        (link("a", None, "", SHAPE), [], None),
        (link("a", "2", GOOD.replace('izz="1"', 'izz="4"')), ["the inertia of link 'a' breaks the triangle"], "2"),
        (link("a", "2", GOOD.replace('"1"', '"1e-15"')), ["no inertia (its file says 1e-15, 1e-15, 1e-15); made"], "2"),
    ],
)
def test_masses_of_urdf_are_mended_link_by_link(text, said, left):
    root = urdf(text)
    notes = mend_inertias(root, "r.urdf")
    assert len(notes) == len(said)
    assert all(word in note for word, note in zip(said, notes, strict=True))
    mass = root.find("link/inertial/mass")
    assert (None if mass is None else mass.get("value")) == left
    if left == "2":
        moments = [float(root.find("link/inertial/inertia").get(key)) for key in ("ixx", "iyy", "izz")]
        assert max(moments) < sum(moments) / 2 + 1e-6
        if "no inertia" in "".join(said):
            assert moments == [pytest.approx(0.4 * 2 * 0.05**2)] * 3


def test_a_link_held_to_one_with_mass_weighs_nothing():
    held = '<joint name="j{0}" type="{1}"><parent link="{2}"/><child link="{3}"/></joint>'
    joints = (
        held.format(1, "fixed", "a", "b") + held.format(2, "fixed", "b", "c") + held.format(3, "revolute", "c", "d")
    )
    root = urdf(
        link("a", "1", GOOD) + link("b", None, "", SHAPE) + link("c", "-1", GOOD) + link("d", "0", GOOD), joints
    )
    notes = mend_inertias(root, "r.urdf", feather=1e-3)
    assert [note.split("'")[1] for note in notes] == ["c", "d"]
    assert "has a mass of -1 kg; it weighs nothing instead" in notes[0]
    for found in root.findall("link")[1:3]:
        (inertial,) = found.findall("inertial")
        assert float(inertial.find("mass").get("value")) == 1e-3
        assert float(inertial.find("inertia").get("ixx")) == pytest.approx(1e-7)
        assert float(inertial.find("inertia").get("ixy")) == 0.0


@pytest.mark.parametrize(
    ("inertial", "said", "key", "values"),
    [
        ('mass="1" diaginertia="1 1 3"', "breaks the triangle inequality", "diaginertia", (1.5, 1.5, 3.0)),
        ('mass="1" fullinertia="1 1 3 0 0 0"', "breaks the triangle inequality", "fullinertia", None),
        ('mass="0" diaginertia="1 1 1"', "has a mass of 0 kg; its mass is computed from its shapes", None, None),
        ('mass="1" diaginertia="1 1 1"', None, "diaginertia", (1.0, 1.0, 1.0)),
        ('mass="1" diaginertia="1 1"', None, "diaginertia", (1.0, 1.0)),
    ],
)
def test_inertias_of_mjcf_are_mended_where_they_stand(inertial, said, key, values):
    root = ET.fromstring(
        f'<mujoco><worldbody><body name="b"><inertial pos="0 0 0" {inertial}/></body></worldbody></mujoco>'
    )
    notes = mend_inertias(root, "m.xml")
    assert len(notes) == (said is not None)
    assert all(said in note and "body 'b'" in note for note in notes)
    found = root.find(".//inertial")
    if key is None:
        assert found is None
        return
    assert set(found.attrib) == {"pos", "mass", key}
    numbers = np.array(found.get(key).split(), dtype=float)
    if values is not None and said is None:
        assert numbers == pytest.approx(values)
    if said is not None:
        assert len(numbers) == (3 if key == "diaginertia" else 6)
        assert np.sort(numbers[:3])[2] <= np.sort(numbers[:3])[:2].sum() * 1.00001


def test_the_matrix_of_six_numbers_has_the_order_of_mjcf():
    given = "1 2 9 0.1 0.2 0.3"
    root = ET.fromstring(
        f'<mujoco><worldbody><body><inertial mass="1" fullinertia="{given}"/></body></worldbody></mujoco>'
    )
    (note,) = mend_inertias(root, "m.xml")
    a, b, c, ab, ac, bc = map(float, given.split())
    small, middle, large = np.linalg.eigvalsh(np.array([[a, ab, ac], [ab, b, bc], [ac, bc, c]]))
    assert f"({small:.3g} + {middle:.3g} < {large:.3g} kg m^2)" in note


def test_a_robot_without_mass_weighs_what_its_shapes_do():
    visual = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    root = urdf(link("a", None, "", visual) + link("b", None, "", visual + SHAPE))
    (note,) = mend_weightless(root, "r.urdf")
    assert "no link has a mass" in note
    assert [len(each.findall("collision")) for each in root] == [1, 1]
    assert [len(each.findall("visual")) for each in root] == [1, 1]
    for other in (urdf(link("a", "1", "", visual)), ET.fromstring("<mujoco/>")):
        assert list(mend_weightless(other, "r.urdf")) == []
    assert [number_of(text) for text in ("1e2", "inf", "x", "", None)] == [100.0, None, None, None, None]


ARM = """<mujoco><worldbody><body name="foot"><geom size=".1"/><body name="one"><joint name="a"/><geom size=".1"/>
<body name="plate"><geom size=".1"/><body name="two"><joint name="b" range="20 90" limited="true"/><geom size=".1"/>
{}</body></body></body></body></worldbody></mujoco>"""
FINGER = '<body name="{0}"><joint name="{0}" type="slide"/><geom size=".1"/>{1}</body>'


def chain(inner: str):
    model = mujoco.MjModel.from_xml_string(ARM.format(inner))
    tree = tree_of(model)
    end, options = chain_to(tree)
    return tree, model.body(end).name, [model.body(each).name for each in options]


@pytest.mark.parametrize(
    ("inner", "end", "options"),
    [
        ("", "two", []),
        (FINGER.format("l", "") + FINGER.format("r", ""), "two", []),  # fingers
        (FINGER.format("l", FINGER.format("m", FINGER.format("n", ""))) + FINGER.format("r", ""), "two", ["n", "r"]),
        (FINGER.format("l", FINGER.format("m", "")) + FINGER.format("r", ""), "two", []),  # as many as the arm has
        (FINGER.format("l", ""), "l", []),
    ],
)
def test_an_arm_ends_before_its_fingers(inner, end, options):
    _, found, candidates = chain(inner)
    assert (found, candidates) == (end, options)


def test_the_tree_of_an_arm_knows_parents_paths_and_frames():
    tree, *_ = chain(FINGER.format("l", ""))
    number = {tree.model.body(each).name: each for each in range(tree.model.nbody)}
    one, two, finger = number["one"], number["two"], number["l"]
    assert tree.moving == (one, two, finger)
    assert [tree.parent_of(each) for each in (one, two, finger, 0)] == [0, one, two, 0]
    assert tree.children_of(one) == [two]
    assert tree.bodies_of(one) == [one, number["plate"]]
    assert tree.path_to(finger) == [one, two, finger]
    assert [tree.depth(each) for each in (one, two, finger)] == [3, 2, 1]
    assert carried_by(tree, one) == [two, finger]
    rigid = tree.with_rigid([two])
    assert rigid.moving == (one, finger)
    # The joint of 20 to 90 degrees rests at its nearest limit.
    turned = rigid.frame(two)[:3, :3]
    assert np.degrees(np.arccos((np.trace(turned) - 1) / 2)) == pytest.approx(20.0)
    assert tree.frame(0).tolist() == np.eye(4).tolist()


def test_motors_of_an_arm_have_the_least_limit_of_file_and_actuators():
    limits = '<joint name="{}"><limit effort="{}" velocity="{}"/></joint>'
    text = (
        "<robot>" + limits.format("a", 7, 2) + limits.format("b", 0, "x") + limits.format("c", "inf", -1) + "</robot>"
    )
    motors = motors_of(ET.fromstring(text))
    assert (dict(motors.efforts), dict(motors.velocities)) == ({"a": 7.0}, {"a": 2.0})
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><body><joint name="a"/><geom size=".1"/><body>
    <joint name="b" actuatorfrcrange="-4 3" actuatorfrclimited="true"/><geom size=".1"/>
    <body><joint name="c"/><geom size=".1"/><body><joint name="d"/><geom size=".1"/></body></body></body></body>
    </worldbody>    <tendon><fixed name="t"><joint joint="c" coef="-0.5"/><joint joint="d" coef="2"/></fixed></tendon>
    <actuator><motor joint="a" gear="-3" ctrllimited="true" ctrlrange="-1 2"/>
    <general tendon="t" gear="10" forcelimited="true" forcerange="-6 1"/>
    <motor joint="d"/></actuator></mujoco>""")
    torques = [motors.torque(model, model.joint(name).id) for name in "abcd"]
    # 3 x 2 below 7; its own limit; 10 x 0.5 x 6 by the tendon; no limit.
    assert torques == [pytest.approx(6.0), 4.0, pytest.approx(30.0), math.inf]


BOT = """<mujoco><asset/><worldbody><geom name="floor" type="plane" size="1 1 1"/>{}<body name="robot">{}
<body name="l"><joint name="l"/><geom size=".1"/></body><body name="r"><joint name="r"/><geom size=".1"/></body></body>
</worldbody><contact><exclude body1="box" body2="robot"/><exclude body1="l" body2="r"/></contact>
<tendon><fixed name="t"><joint joint="lid"/></fixed></tendon>
<actuator><motor name="lid" tendon="t"/><motor name="wheel" joint="l"/></actuator></mujoco>"""
BOX = '<body name="box"><geom size=".1"/><joint name="lid" type="slide"/></body>'


def test_a_scene_of_mjcf_is_left_with_its_robot_and_what_refers_to_it():
    root = ET.fromstring(BOT.format(BOX, ""))
    (note,) = without_scenery(root, "m.xml")
    assert note == "left out: what is beside the robot in m.xml, 1 of them: 'box'"
    assert [item.get("name") for item in root.find("worldbody")] == ["robot"]
    assert [item.get("body1") for item in root.find("contact")] == ["l"]
    assert len(root.find("tendon")) == 0
    assert [item.get("name") for item in root.find("actuator")] == ["wheel"]
    many = ET.fromstring(BOT.format("".join(BOX.replace("box", f"b{k}") for k in range(5)), ""))
    (note,) = without_scenery(many, "m.xml")
    assert note.endswith("5 of them: 'b0', 'b1', 'b2', 'b3' and more")
    second = '<body name="second"><joint/><body><joint/></body></body>'
    two = ET.fromstring(BOT.format(BOX + second, ""))
    assert list(without_scenery(two, "m.xml")) == []
    assert len(two.find("worldbody")) == 4


@pytest.mark.parametrize(
    ("joints", "left"),
    [
        ('<joint name="x" type="slide"/><joint name="y" type="slide"/><joint name="turn"/>', []),
        ('<freejoint name="x"/>', ["x"]),
    ],
)
def test_rails_of_mjcf_are_locked(joints, left):
    root = ET.fromstring(BOT.format("", joints))
    notes = list(without_mjcf_rails(root, "m.xml"))
    robot = root.find("worldbody/body")
    assert [item.get("name") for item in robot if item.tag in ("joint", "freejoint")] == left
    assert bool(notes) == (not left)


ROLL = '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{0}_link"/>{3}</joint>'


def test_wheels_on_fixed_joints_are_freed_if_all_are():
    base = link("base") + "".join(link(f"{name}_link") for name in ("wheel_l", "wheel_r", "caster_wheel"))
    joints = [ROLL.format(name, "fixed", "base", "") for name in ("wheel_l", "wheel_r", "caster_wheel")]
    root = urdf(base, "".join(joints))
    assert len(list(freed_wheels(root, "r.urdf"))) == 2
    assert [joint.get("type") for joint in root.findall("joint")] == ["continuous", "continuous", "fixed"]
    assert [joint.find("axis").get("xyz") for joint in root.findall("joint")[:2]] == ["0 1 0"] * 2
    for others in (joints[:1], [joints[0], joints[1].replace("fixed", "continuous")]):
        root = urdf(base, "".join(others))
        assert list(freed_wheels(root, "r.urdf")) == []
    axis = urdf(base, "".join(each.replace("</joint>", '<axis xyz="1 0 0"/></joint>') for each in joints[:2]))
    assert len(list(freed_wheels(axis, "r.urdf"))) == 2
    assert [len(joint.findall("axis")) for joint in axis.findall("joint")] == [1, 1]


def test_rails_of_urdf_are_locked_up_to_the_first_link_with_a_shape():
    joint = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/></joint>'
    ends = [("x", "prismatic", "world", "a"), ("y", "fixed", "a", "b"), ("turn", "revolute", "b", "base")]
    joints = [*ends, ("l", "continuous", "base", "l"), ("r", "continuous", "base", "r")]
    links = "".join(map(link, ("world", "a", "b", "l", "r")))
    root = urdf(links + link("base", None, "", SHAPE), "".join(joint.format(*each) for each in joints))
    notes = list(without_rails(root, "r.urdf"))
    assert [note.split("'")[1] for note in notes] == ["x", "turn"]
    assert [each.get("type") for each in root.findall("joint")] == ["fixed"] * 3 + ["continuous"] * 2


def test_speeds_of_joints_are_those_above_0():
    joints = [
        ROLL.format(name, "continuous", "base", f'<limit velocity="{v}"/>')
        for name, v in (("a", 3), ("b", 0), ("c", "x"))
    ]
    assert dict(joint_speeds(urdf("", "".join(joints) + ROLL.format("d", "fixed", "base", "")))) == {"a": 3.0}


MESH = '<geometry><mesh filename="{}"/></geometry>'


def test_shapes_of_missing_meshes_are_replaced_by_collisions():
    visual = f'<visual>{MESH.format("gone-0")}<material name="m"/></visual>'
    root = urdf(link("a", None, "", visual + SHAPE) + link("b", None, "", visual.replace("gone-0", "kept") + SHAPE))
    without_shapes(root, {"gone-0"})
    shown = [[shape.find("geometry")[0].tag for shape in each.findall("visual")] for each in root]
    assert shown == [["box"], ["mesh"]]
    assert root[0].find("visual/material").get("name") == "m"
    assert len(root[0].findall("collision")) == 1


FILES = """<mujoco><asset><mesh name="m" file="{}.stl"/><texture name="t" type="2d" file="no.png"/>
<material name="c" texture="t"/></asset><worldbody><body name="base"><geom type="box" size=".2 .1 .05" group="3"/>
<body name="l"><joint name="l" axis="0 1 0"/><geom name="g" type="mesh" mesh="m" material="c" mass="2"/></body>
<body name="r"><joint name="r" axis="0 1 0"/><geom type="cylinder" size=".1 .02"/></body></body></worldbody>
<actuator><velocity joint="l" kv="5" ctrlrange="-8 8" ctrllimited="true" gear="2"/>
<position joint="r" kp="9"/></actuator>
<sensor><gyro site="s"/></sensor></mujoco>"""


def gathered(text: str, **files: bytes):
    def read(name: str) -> bytes:
        found = {"r.xml": text.encode(), **files}.get(name)
        if found is None:
            raise ValueError(f"no file '{name}'")
        return found

    return gather_robot("r.xml", read)


def test_meshes_and_pictures_of_mjcf_that_are_missing_are_left_out_and_the_mass_stays():
    text = FILES.replace('<body name="base">', '<body name="base"><site name="s"/>').format("no")
    robot = gathered(text)
    assert sorted(note.split(",")[0] for note in robot.notes) == [
        "left out: missing meshes",
        "left out: missing pictures",
    ]
    assert any("plain colours are used instead" in note for note in robot.notes)
    model = robot.model
    assert model.body("l").mass == pytest.approx(2.0)
    assert model.geom("g").size[0] == 0.005
    assert (model.geom("g").contype, model.geom("g").rgba[3]) == (0, 0.0)
    assert robot.driven == {"l", "r"}
    # The servo's force is kv (command - gear x speed); a command of 8 is 4 rad/s at the joint.
    assert robot.speeds == {"l": pytest.approx(4.0)}
    assert [(each.link, each.kind, each.name) for each in robot.sensors] == [("s", "imu", "imu")]
    again = ET.fromstring(robot_text(robot.files))
    assert again.find(".//geom[@name='g']").get("size") == "0.005"


def with_mesh(corners: list[list[list[float]]]):
    text = FILES.replace('<texture name="t" type="2d" file="no.png"/>', "").replace(' texture="t"', "")
    text = text.replace('<sensor><gyro site="s"/></sensor>', "").format("m")
    return gathered(text, **{"m.stl": binary(0.1 * np.array(corners))})


CROSS = [[[1.0, 0, 0], [-0.5, 1, 0], [-0.5, -1, 0]], [[1, 0, 0], [-0.5, 0, 1], [-0.5, 0, -1]]]
"""Two triangles through their middle: no volume."""


def test_a_mesh_without_volume_weighs_as_its_surface_in_mjcf_and_is_left_out_of_urdf():
    robot = with_mesh(CROSS)
    assert robot.files.root.find("asset/mesh").get("inertia") == "shell"
    assert robot.model.nmesh == 1
    assert not [note for note in robot.notes if "meshes" in note]
    visual = f"<visual>{MESH.format('f.stl')}</visual><collision>{MESH.format('f.stl')}</collision>{SHAPE}"
    text = f'<robot name="r">{link("base", None, "", visual)}</robot>'
    robot = gathered(text, **{"f.stl": binary(0.1 * np.array(CROSS))})
    assert "left out: meshes that MuJoCo cannot read, 1 of them; collision shapes are used instead" in robot.notes
    assert (robot.model.nmesh, robot.model.body_mass.sum()) == (0, pytest.approx(1000.0))
    assert robot.files.assets == {}


def test_a_flat_mesh_of_mjcf_is_left_out():
    robot = with_mesh([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 0, 0], [1, 1, 0]]])
    assert "left out: meshes that MuJoCo cannot read, 1 of them; collision shapes are used instead" in robot.notes
    assert (robot.model.nmesh, robot.model.body("l").mass) == (0, pytest.approx(2.0))


def test_an_error_of_mujoco_names_line_and_column_of_the_file():
    with pytest.raises(PlacedError) as refused:
        gathered(FILES.format("no").replace('size=".1 .02"', 'size="-.1 .02"'))
    assert str(refused.value).startswith("'r.xml':4:46: <geom>: size 0 must be positive")


GAZEBO = """<gazebo reference="base"><sensor name="laser" type="gpu_ray"><pose>0.1 0.2 0.3 0 0 1.5</pose>
<update_rate>10</update_rate><ray><scan><horizontal><samples>181</samples><min_angle>-0.5</min_angle>
<max_angle>1.5</max_angle></horizontal></scan><range><min>0.1</min><max>30</max></range><noise><stddev>0.02</stddev>
</noise></ray></sensor><sensor name="eye" type="depth"><camera><horizontal_fov>1.2</horizontal_fov>
<image><width>320</width><height>240</height></image></camera></sensor><sensor type="sonar"/></gazebo>
<gazebo><plugin filename="libgazebo_ros_planar_move.so"><left_joint> l </left_joint></plugin></gazebo>"""


def test_sensors_and_plugins_of_gazebo_are_read_in_our_units():
    cylinder = '<collision><geometry><cylinder radius="0.1" length="0.04"/></geometry></collision>'
    links = link("base", "5", GOOD, SHAPE) + link("l_link", "1", GOOD, cylinder)
    text = f'<robot name="r">{links}{ROLL.format("l", "continuous", "base", "")}{GAZEBO}</robot>'
    robot = gathered(text)
    laser, eye = robot.sensors
    assert (laser.link, laser.kind, laser.name, laser.at, laser.rpy) == (
        "base",
        "lidar",
        "laser",
        (0.1, 0.2, 0.3),
        (0, 0, 1.5),
    )
    assert laser.keys == {
        "rate_hz": 10.0,
        "beams": 181.0,
        "fov_deg": pytest.approx(math.degrees(2.0)),
        "middle_deg": pytest.approx(math.degrees(0.5)),
        "nearest": 0.1,
        "farthest": 30.0,
        "noise": 0.02,
    }
    assert eye.keys == {"fov_deg": pytest.approx(math.degrees(1.2)), "width": 320.0, "height": 240.0}
    assert (robot.sideways, robot.driven) == ("libgazebo_ros_planar_move.so", {"l"})


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("package://bot/meshes/a.obj", "bot/meshes/a.obj"),
        ("package://other/meshes/b.obj", "other/meshes/b.obj"),
        ("package://any/c.obj", "c.obj"),
        ("package://bot/none.obj", None),
        ("package://bot/../../secret.obj", None),
    ],
)
def test_names_of_packages_lead_below_the_folders_around(name, place):
    corners = b"".join(b"v %d %d %d\n" % each for each in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
    mesh = corners + b"f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    there = dict.fromkeys(("bot/meshes/a.obj", "other/meshes/b.obj", "c.obj"), mesh)
    text = f'<robot name="r"><link name="a"><visual>{MESH.format(name)}</visual></link></robot>'

    def read(path: str) -> bytes:
        if path == "bot/urdf/r.urdf":
            return text.encode()
        if path not in there:
            raise ValueError(f"no file '{path}'")
        return there[path]

    if place is None:
        with pytest.raises(ValueError, match="not below any folder around it; put it there"):
            gather_model("bot/urdf/r.urdf", read)
    else:
        assert place in gather_model("bot/urdf/r.urdf", read).paths
