"""Robots as Gazebo has them, in SDF: their links, joints, sensors and plug-ins are those of the file."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from mjsim import UsageError, load_world
from mjsim.exchange.robots import sdf_robot
from mjsim.inventory import inventory
from mjsim.models import anatomy_of, gather_robot
from tests.exchange.bringing import brought, few_drives
from tests.models.test_mesh_files import collada

RADIUS, TRACK, LIFT = 0.08, 0.36, 0.05
"""Of the wheels, and height of the chassis' frame above the model's [m]."""
LINK = """<link name="{name}"><pose>{pose}</pose><inertial><mass>{mass}</mass>
  <inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz></inertia></inertial>{parts}</link>"""
ROUND = (
    "<{kind} name='c'><geometry><cylinder><radius>{radius}</radius><length>.03</length></cylinder></geometry></{kind}>"
)
TYRE = ROUND.format(kind="collision", radius=RADIUS) + ROUND.format(kind="visual", radius=RADIUS)
BOX = """<collision name="c"><geometry><box><size>.4 .3 .1</size></box></geometry></collision>
  <visual name="v"><geometry><box><size>.4 .3 .1</size></box></geometry>
  <material><diffuse>1 0 0 1</diffuse></material></visual>"""
LIDAR = """<sensor name="scan" type="gpu_lidar"><pose>.1 0 .2 0 0 0</pose><update_rate>5</update_rate><lidar><scan>
  <horizontal><samples>181</samples><min_angle>-1.5707963</min_angle><max_angle>1.5707963</max_angle></horizontal></scan>
  <range><min>.1</min><max>8</max></range></lidar></sensor>"""
CAMERA = """<sensor name="eye" type="depth_camera"><pose>.2 0 .1 0 .1 0</pose>
  <camera><horizontal_fov>1.0</horizontal_fov>
  <image><width>320</width><height>240</height></image></camera></sensor>"""
PLUGIN = """<plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
  <left_joint>left</left_joint><right_joint>right</right_joint><wheel_separation>.36</wheel_separation>
  <wheel_radius>.08</wheel_radius><max_linear_velocity>0.7</max_linear_velocity></plugin>"""


def hinge(name: str, child: str, axis: str, *, kind: str = "revolute", more: str = "", parent: str = "chassis") -> str:
    """Return a joint of the chassis with an axis."""
    return f"""<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{more}
      <axis>{axis}</axis></joint>"""


def wheel(name: str, y: float) -> str:
    """Return a wheel whose own z axis is its axle, to the left."""
    at = f"0 {y} {RADIUS} {-math.pi / 2} 0 0"
    return LINK.format(name=name, pose=at, mass=0.5, parts=TYRE)


OWN = "<xyz>0 0 1</xyz>"
CHASSIS = LINK.format(name="chassis", pose=f"0 0 {2 * LIFT} 0 0 0", mass=5, parts=BOX + LIDAR + CAMERA)
WHEELS = wheel("l", TRACK / 2) + wheel("r", -TRACK / 2)
HINGES = hinge("left", "l", OWN) + hinge("right", "r", OWN)


def sdf(inner: str, version: str = "1.9") -> str:
    return f'<sdf version="{version}"><model name="cart">{inner}</model></sdf>'


def read(text: str, opened=lambda uri: None):
    """Return the contents of a robot in SDF, its file, and what was lost."""
    urdf, items = sdf_robot.urdf_of_sdf(ElementTree.fromstring(text), "r.sdf", opened)
    robot = gather_robot("r.urdf", lambda _: urdf.encode())
    return anatomy_of(robot), robot, inventory(items)


def joints_of(text: str) -> dict[str, list[float]]:
    """Return the place and the axis of each joint in the frame of the model."""
    anatomy, *_ = read(text)
    return {joint.name: np.round([*joint.at, *joint.axis], 6).tolist() for joint in anatomy.joints}


AT_L, AT_R = [0, TRACK / 2, RADIUS, 0, 1, 0], [0, -TRACK / 2, RADIUS, 0, 1, 0]


@pytest.mark.parametrize(
    ("version", "axis"),
    [
        ("1.9", OWN),
        ("1.9", "<xyz expressed_in='__model__'>0 1 0</xyz>"),
        ("1.9", "<xyz expressed_in='chassis'>0 1 0</xyz>"),
        ("1.6", "<xyz>0 1 0</xyz><use_parent_model_frame>true</use_parent_model_frame>"),
        ("1.6", OWN),
        ("1.4", "<xyz>0 1 0</xyz>"),
    ],
)
def test_an_axis_is_in_the_frame_that_its_version_of_sdf_means(version, axis):
    inner = CHASSIS + WHEELS + hinge("left", "l", axis) + hinge("right", "r", axis)
    found = joints_of(sdf(inner, version))
    assert found == {"left": pytest.approx(AT_L), "right": pytest.approx(AT_R)}


@pytest.mark.parametrize(
    ("inner", "pose"),
    [
        # All links at the model's frame and the joint at its place, as SolidWorks exports; a joint at its own frame.
        (hinge("left", "l", "<xyz>0 1 0</xyz>", more="<pose>0 .18 .08 0 0 0</pose>"), "0 0 0 0 0 0"),
        (hinge("left", "l", "<xyz>0 1 0</xyz>", more="<pose relative_to='chassis'>0 .18 -.02 0 0 0</pose>"), ""),
        (
            "<frame name='hub'><pose>0 .18 .08 0 0 0</pose></frame>"
            + hinge("left", "l", OWN.replace("0 0 1", "0 1 0")),
            None,
        ),
        # A name that link and joint share, as before SDF 1.7.
        (hinge("l", "l", "<xyz>0 1 0</xyz>"), "0 .18 .08 0 0 0"),
    ],
)
def test_a_hinge_is_where_its_joint_is(inner, pose):
    placed = "<pose relative_to='hub'/>" if pose is None else f"<pose>{pose}</pose>"
    found = joints_of(sdf(CHASSIS + f"<link name='l'>{placed}<inertial><mass>1</mass></inertial></link>" + inner))
    assert list(found.values()) == [pytest.approx(AT_L)]


def test_wheels_that_carry_their_chassis_are_turned_round():
    axis = "<xyz expressed_in='__model__'>0 -1 0</xyz>"
    held = [
        hinge(name, "chassis", axis, parent=side, more=f"<pose relative_to='{side}'/>")
        for name, side in (("left", "l"), ("right", "r"))
    ]
    found = joints_of(sdf(CHASSIS + WHEELS + "".join(held)))
    assert found == {"left": pytest.approx(AT_L), "right": pytest.approx(AT_R)}


def test_wheels_sensors_masses_and_plug_ins_of_an_sdf_are_those_of_the_file():
    anatomy, robot, lost = read(sdf(CHASSIS + WHEELS + HINGES + PLUGIN))
    assert lost == []
    assert anatomy.mass == pytest.approx(6.0)
    tyre = next(shape for shape in anatomy.shapes if "l" in shape.names and shape.touched)
    assert np.ptp(tyre.points, axis=0) == pytest.approx([2 * RADIUS, 0.03, 2 * RADIUS], abs=1e-3)
    scan, eye = robot.sensors
    assert (scan.kind, scan.link, scan.keys["beams"], scan.keys["farthest"]) == ("lidar", "chassis", 181, 8.0)
    # The chassis is the root, whose frame is that of the model.
    assert scan.at == pytest.approx((0.1, 0.0, 0.2 + 2 * LIFT))
    assert (eye.kind, eye.keys["width"], eye.rpy) == ("camera", 320, pytest.approx((0.0, 0.1, 0.0)))
    (said,) = robot.drives
    assert (said.wheel_radius, said.separation, said.max_speed) == (RADIUS, TRACK, 0.7)
    assert said.joints == {"left", "right"}
    red = [robot.model.geom_rgba[k].tolist() for k in range(robot.model.ngeom)]
    assert [1.0, 0.0, 0.0, 1.0] in red


def test_models_in_a_model_are_parts_of_the_robot():
    mast = "<model name='mast'><link name='top'><pose>0 0 .1 0 0 0</pose>" + LIDAR + "</link></model>"
    held = "<joint name='hold' type='fixed'><parent>chassis</parent><child>mast::top</child></joint>"
    include = "<include><uri>model://mast</uri><pose>0 0 .5 0 0 0</pose></include>"
    bare = CHASSIS.replace(LIDAR, "").replace(CAMERA, "")
    root = ElementTree.fromstring(f"<sdf>{mast}</sdf>")
    for nested in (include, mast.replace("'mast'>", "'mast'><pose>0 0 .5 0 0 0</pose>")):
        anatomy, robot, lost = read(sdf(bare + WHEELS + HINGES + nested + held), lambda uri: (root, f"{uri}/"))
        (scan,) = robot.sensors
        top = next(place for place in anatomy.places if place.name == scan.link)
        assert (scan.link, lost) == ("mast_top", [])
        assert top.at + top.axes @ scan.at == pytest.approx((0.1, 0.0, 0.8))


@pytest.mark.parametrize(
    ("inner", "line"),
    [
        (
            "<joint name='j' type='fixed'><parent>world</parent><child>chassis</child></joint>",
            "joint 'j': it holds the",
        ),
        (hinge("j", "l", "", kind="ball"), "joint 'j': it closes a loop"),
        (LINK.format(name="x", pose="", mass=1, parts=""), "link 'x': no joint connects it"),
        (
            LINK.format(name="x", pose="", mass=1, parts="") + hinge("j", "x", "", kind="ball"),
            "ball joint 'j': treated as",
        ),
        ("<include><uri>model://gone</uri></include>", "included model 'model://gone': not found"),
        ("<gripper name='g'/>", "<gripper> 'g': no such part"),
        (
            "<link name='x'><collision name='c'><geometry><plane/></geometry></collision></link>"
            + hinge("j", "x", "", kind="fixed"),
            "shape <plane> 'c': a robot has",
        ),
        (
            "<link name='x'><visual name='v'><geometry><mesh><uri>a.dae</uri><submesh><name>s</name></submesh></mesh>"
            "</geometry></visual></link>" + hinge("j", "x", "", kind="fixed"),
            "mesh part 's': mjsim uses only whole meshes",
        ),
    ],
)
def test_what_an_sdf_robot_loses_has_a_line(inner, line):
    *_, lost = read(sdf(CHASSIS + WHEELS + HINGES + inner))
    assert [text.startswith(f"left out: {line}") for text in lost if text.startswith("left out: ")] == [True]


def test_a_joint_with_two_axes_becomes_two():
    steered = LINK.format(name="front", pose=f".3 0 {RADIUS} 0 0 0", mass=0.5, parts="")
    axes = (
        "<xyz>0 0 1</xyz><limit><lower>-.6</lower><upper>.6</upper></limit></axis><axis2><xyz>0 1 0</xyz></axis2><axis>"
    )
    inner = hinge("fork", "front", axes, kind="revolute2").replace("<axis></axis>", "")
    anatomy, *_ = read(sdf(CHASSIS + WHEELS + HINGES + steered + inner))
    found = {joint.name: (joint.range, joint.axis.round(6).tolist()) for joint in anatomy.joints}
    assert found["fork"] == (pytest.approx((-0.6, 0.6)), [0, 0, 1])
    assert found["fork_2"] == (None, [0, 1, 0])


def test_gazebo_does_not_turn_collada_by_its_up_axis():
    shape = "<geometry><mesh><uri>a.dae</uri></mesh></geometry>"
    mast = f"<link name='m'><visual name='v'>{shape}</visual></link>" + hinge("hold", "m", "", kind="fixed")
    urdf, _ = sdf_robot.urdf_of_sdf(ElementTree.fromstring(sdf(CHASSIS + mast)), "r.sdf", lambda uri: None)
    files = {"r.urdf": urdf.encode(), "a.dae": collada("", "<up_axis>Y_UP</up_axis>")}  # 4 x 2 x 1 m in its own axes
    for up_axis, size in ((False, (4, 2, 1)), (True, (4, 1, 2))):
        shapes = anatomy_of(gather_robot("r.urdf", files.__getitem__, up_axis=up_axis)).shapes
        assert max(np.ptp(shape.points, axis=0).round(4).tolist() for shape in shapes) == pytest.approx(size)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "<sdf><world name='w'/></sdf>",
            "r.sdf: robots in it: none; name another file",
        ),
        (
            "<sdf><world name='w'><model name='a'/><model name='b'/></world></sdf>",
            "r.sdf: no robot is in it, but models: a, b; choose one with --model NAME",
        ),
        (
            sdf(CHASSIS + WHEELS + HINGES).replace("<xyz>0 0 1</xyz>", "<xyz>0 zero 1</xyz>"),
            "r.sdf: joint 'left': axis: '0 zero 1' is not 3 finite numbers",
        ),
        (sdf(CHASSIS + "<link name='l'><pose relative_to='x'/></link>" + hinge("j", "l", OWN)), "r.sdf: no frame 'x'"),
        *(
            (
                sdf(CHASSIS + WHEELS + HINGES + f"<link name='l'><collision name='c'>{geometry}</collision></link>"),
                f"r.sdf: collision 'c': {says}",
            )
            for geometry, says in (
                ("<geometry><capsule><radius>1</radius></capsule></geometry>", "its <capsule> has no <length>;"),
                ("<geometry><sphere><radius>-1</radius></sphere></geometry>", "radius of a sphere: '-1' must be above"),
                ("<geometry><sphere><radius>1e30</radius></sphere></geometry>", "radius of a sphere: '1e30' must be"),
            )
        ),
    ],
)
def test_a_broken_sdf_robot_is_one_line(text, line):
    with pytest.raises(UsageError) as caught:
        read(text)
    assert str(caught.value).startswith(line)


@pytest.mark.slow
def test_a_robot_in_sdf_drives_by_the_command(tmp_path):
    caster = LINK.format(
        name="ball",
        pose="-.15 0 .02 0 0 0",
        mass=0.05,
        parts="<collision name='c'><geometry><sphere><radius>.02</radius></sphere></geometry></collision>",
    ) + hinge("swivel", "ball", "", kind="ball").replace("<axis></axis>", "")
    world = sdf(CHASSIS + WHEELS + HINGES + PLUGIN + caster).replace("<model", "<world name='w'><model", 1)
    path = tmp_path / "cart.sdf"
    path.write_text(world.replace("</sdf>", "</world></sdf>"))
    with few_drives():
        _, said = brought(path, tmp_path)
    assert "SDF of 6.05 kg" in said
    assert "wheels 'left' and 'right', of radius 0.0800 m, a track of 0.3600 m" in said
    assert "kept: casters at [-0.150, 0.000]" in said
    assert "kept: lidar 'scan': at [0.100, 0.000, 0.300], described on 'chassis'" in said
    assert "kept: camera 'eye': at [0.200, 0.000, 0.200], described on 'chassis'" in said
    assert "kept: max_speed 0.7 m/s: by plug-in 'gz-sim-diff-drive-system'" in said
    assert "left out: ball joint 'swivel': treated as rigid" in said
    assert len(load_world(tmp_path / "cart.yaml").robots[0].sensors) >= 2


def test_of_several_robots_in_a_world_the_one_that_is_named_comes_in():
    cart = f"<model name='{{}}'>{CHASSIS + WHEELS + HINGES}</model>"
    root = ElementTree.fromstring(
        f"<sdf version='1.9'><world name='w'>{cart.format('a')}{cart.format('b')}</world></sdf>"
    )
    # No plug-in moves the last, but it is asked for.
    root.find("world").append(ElementTree.fromstring(f"<model name='plain'>{CHASSIS + WHEELS}</model>"))
    for name in ("b", "plain"):
        text, _ = sdf_robot.urdf_of_sdf(root, "r.sdf", lambda uri: None, model=name)
        assert f'name="{name}"' in text.partition(">")[0]
    for asked in ("", "c"):
        with pytest.raises(UsageError, match=r"r\.sdf: robots in it: a, b; choose one with --model NAME"):
            sdf_robot.urdf_of_sdf(root, "r.sdf", lambda uri: None, model=asked)
