"""Small facts about robots and arms in files: ends, motors, wheels, meshes, sensors."""

import math
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest

from mjsim.models import anatomy_of, gather_robot
from mjsim.models.arms.arm_motors import motors_of
from mjsim.models.arms.arm_tree import carried_by, chain_to, tree_of
from mjsim.models.model_sources import gather_model
from mjsim.models.robots.mjcf_scenes import without_mjcf_rails, without_scenery
from mjsim.models.robots.robot_files import robot_text, without_shapes
from mjsim.models.robots.urdf_joints import freed_wheels, joint_speeds, without_rails
from mjsim.models.robots.xml_positions import PlacedError
from tests.models.small_files import GOOD, SHAPE, binary, link, urdf

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
    assert note == "left out: 1 body beside the robot in m.xml: 'box'"
    assert [item.get("name") for item in root.find("worldbody")] == ["robot"]
    assert [item.get("body1") for item in root.find("contact")] == ["l"]
    assert len(root.find("tendon")) == 0
    assert [item.get("name") for item in root.find("actuator")] == ["wheel"]
    many = ET.fromstring(BOT.format("".join(BOX.replace("box", f"b{k}") for k in range(5)), ""))
    (note,) = without_scenery(many, "m.xml")
    assert note.endswith("5 bodies beside the robot in m.xml: 'b0', 'b1', 'b2', 'b3' and more")
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
    assert sorted(item.kind for item in robot.items) == ["missing mesh", "missing picture"]
    assert any("plain colours are used instead" in item.why for item in robot.items)
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


def test_a_mesh_without_volume_weighs_as_its_surface_in_mjcf_and_nothing_in_urdf():
    robot = with_mesh(CROSS)
    assert robot.files.root.find("asset/mesh").get("inertia") == "shell"
    assert robot.model.nmesh == 1
    assert robot.items == ()
    visual = f"<visual>{MESH.format('f.stl')}</visual><collision>{MESH.format('f.stl')}</collision>{SHAPE}"
    text = f'<robot name="r">{link("base", None, "", visual)}</robot>'
    robot = gathered(text, **{"f.stl": binary(0.1 * np.array(CROSS))})
    assert robot.items == ()
    assert (robot.model.nmesh, robot.model.body_mass.sum()) == (1, pytest.approx(1000.0))


def test_a_flat_mesh_of_mjcf_is_left_out():
    robot = with_mesh([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 0, 0], [1, 1, 0]]])
    assert [item.why for item in robot.items] == ["MuJoCo cannot read it; collision shapes are used instead"]
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
    laser, eye, odd = robot.sensors
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
    assert odd.kind not in ("lidar", "camera", "imu")
    seen = {"fov_deg": pytest.approx(math.degrees(1.2)), "width": 320.0, "height": 240.0}
    assert eye.keys == {**seen, "depth": 1.0}
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
        with pytest.raises(ValueError, match="not found from any folder that contains the model; put it in one"):
            gather_model("bot/urdf/r.urdf", read)
    else:
        assert place in gather_model("bot/urdf/r.urdf", read).paths


def test_ball_joints_alone_are_loose():
    body = '<body name="{0}"><joint name="{0}" type="{1}"/><geom size=".1"/></body>'
    parts = "".join(body.format(name, kind) for name, kind in (("h", "hinge"), ("b", "ball"), ("s", "slide")))
    text = f'<mujoco><worldbody><body name="base"><freejoint/><geom size=".1"/>{parts}</body></worldbody></mujoco>'
    assert anatomy_of(gather_robot("r.xml", lambda _: text.encode())).loose == ("b",)
