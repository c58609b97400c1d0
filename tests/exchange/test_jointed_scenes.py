"""Doors and drawers of scenes move on their joints, whether SDF or MJCF has them."""

import math

import mujoco
import pytest

from mjsim.compile import compile_world
from tests.exchange.test_scenes import BOX, brought, link, model, scene

LEAF, DAMPING, TORQUE, SECONDS = 10.0, 1.0, 0.5, 0.5
INERTIA = LEAF * ((0.04**2 + 0.9**2) / 12 + 0.45**2)
"""Of the leaf about its hinge [kg m^2]."""
MJCF = """<mujoco><worldbody>
<body name="frame" pos="2 1 0"><geom type="box" pos="0 -.1 1" size=".02 .02 1"/>
<body name="leaf"><joint axis="0 0 1" range="-90 90" damping="1"/>
<geom type="box" pos="0 .45 1" size=".02 .45 .98" mass="10"/></body></body>
<body name="chest" pos="5 1 0"><geom type="box" pos="0 0 .1" size=".2 .3 .1"/>
<body name="drawer" pos="0 0 .3">
<joint type="slide" axis="1 0 0" range="0 .3"/><geom type="box" size=".2 .3 .1"/></body></body>
<body name="cart" pos="8 1 .2"><freejoint/><geom type="box" size=".3 .2 .1" mass="8"/>
<body name="lid">
<joint axis="1 0 0" pos="0 .2 .1"/><geom type="box" pos="0 0 .12" size=".3 .2 .02" mass="2"/></body></body>
</worldbody></mujoco>"""
DOOR = model(
    link(
        "0 0.45 1 0 0 0",
        BOX.format("0.04 0.9 1.96"),
        more=f"<inertial><mass>{LEAF}</mass></inertial>",
        name="leaf",
    )
    + link("0 -0.1 1 0 0 0", BOX.format("0.04 0.04 2"), name="frame")
    + "<joint name='f' type='fixed'><parent>world</parent><child>frame</child></joint>"
    + "<joint name='h' type='revolute'><pose>0 -0.45 0 0 0 0</pose><parent>frame</parent><child>leaf</child><axis>"
    "<xyz>0 0 1</xyz><limit><lower>-1.5708</lower><upper>1.5708</upper></limit><dynamics><damping>1</damping>"
    "</dynamics></axis></joint>",
    pose="2 1 0 0 0 0",
    static=False,
    name="door",
)
CHEST = model(
    link("0 0 0.1 0 0 0", BOX.format("0.4 0.6 0.2"), name="body")
    + link("0 0 0.3 0 0 0", BOX.format("0.4 0.6 0.2"), name="drawer")
    + "<joint name='s' type='prismatic'><parent>body</parent><child>drawer</child><axis><xyz>1 0 0</xyz><limit>"
    "<lower>0</lower><upper>0.3</upper></limit></axis></joint>",
    pose="5 1 0 0 0 0",
    name="chest",
)


def scene_of(kind: str, folder):
    if kind == "sdf":
        return scene(folder, DOOR + CHEST.replace("<static>true", "<static>false"), version="1.9")
    path = folder / "house.xml"
    path.write_text(MJCF)
    return path


@pytest.fixture(scope="module", params=["sdf", "xml"])
def room(request, tmp_path_factory):
    """Return the report and the compiled world of a scene."""
    world, found = brought(scene_of(request.param, tmp_path_factory.mktemp("room")))
    return found.report, compile_world(world).compile()


def joint_of(model: mujoco.MjModel, ending: str) -> tuple[int, int, int]:
    """Return the number, the place and the axis of a joint."""
    number = next(k for k in range(model.njnt) if model.joint(k).name.endswith(ending))
    return number, int(model.jnt_qposadr[number]), int(model.jnt_dofadr[number])


def test_a_door_turns_as_its_inertia_and_damping_say(room):
    report, model = room
    data = mujoco.MjData(model)
    number, place, axis = joint_of(model, "leaf_joint")
    assert model.jnt_range[number] == pytest.approx([-math.pi / 2, math.pi / 2], abs=1e-4)
    data.qfrc_applied[axis] = TORQUE
    while data.time < SECONDS:
        mujoco.mj_step(model, data)
    lag = INERTIA / DAMPING
    turned = TORQUE / DAMPING * (data.time - lag * (1.0 - math.exp(-data.time / lag)))
    assert data.qpos[place] == pytest.approx(turned, rel=0.01)
    (kept,) = [line for line in report if line.startswith("kept: ") and "jointed thing" in line]
    assert "'leaf'" in kept
    assert "'drawer'" in kept


def test_a_drawer_slides_as_far_as_its_limit(room):
    _, model = room
    data = mujoco.MjData(model)
    _, place, axis = joint_of(model, "drawer_joint")
    data.qfrc_applied[axis] = 300.0
    for _ in range(300):
        mujoco.mj_step(model, data)
    assert data.qpos[place] == pytest.approx(0.3, abs=0.02)


def test_a_cart_that_can_be_pushed_keeps_its_lid_and_weighs_both(tmp_path):
    world, _ = brought(scene_of("xml", tmp_path))
    cart = next(thing for thing in world.obstacles if thing.name == "cart")
    assert (cart.movable, cart.mass) == (True, 10.0)
    model = compile_world(world).compile()
    lid = next(k for k in range(model.nbody) if model.body(k).name.endswith("cart/lid"))
    assert model.body_mass[lid] == pytest.approx(2.0)


def test_static_models_of_gazebo_hold_their_joints_and_odd_ones_are_told(tmp_path):
    still = DOOR.replace("<static>false", "<static>true").replace("'door'", "'still'").replace("2 1 0", "2 5 0")
    odd = DOOR.replace("'door'", "'odd'").replace("type='revolute'", "type='ball'").replace("2 1 0", "2 9 0")
    lost = DOOR.replace("'door'", "'lost'").replace("<parent>frame", "<parent>other::frame").replace("2 1 0", "2 13 0")
    world, found = brought(scene(tmp_path, still + odd + lost, version="1.9"))
    assert not [joint for joint in compile_world(world).joints if "leaf" in joint.name]
    assert (
        "guessed: ball joint 'odd::h': held: mjsim imports only revolute, continuous, prismatic joints" in found.report
    )
    assert "guessed: joint 'lost::h': held: it joins nested models" in found.report


@pytest.mark.parametrize(
    ("limits", "count", "told"),
    [
        ("-1.5708 1.5708", 1, None),
        ("0 0", 0, None),
        ("1 -1", 1, "guessed: limits of joint 'door::h': the lower one is above the upper one; it gets no limits"),
    ],
)
def test_equal_limits_hold_a_joint_and_inverted_ones_are_told(limits, count, told, tmp_path):
    low, high = limits.split()
    door = DOOR.replace(">-1.5708<", f">{low}<").replace(">1.5708<", f">{high}<")
    world, found = brought(scene(tmp_path, door, version="1.9"))
    assert compile_world(world).compile().njnt == count
    assert [line for line in found.report if "limits" in line] == ([told] if told else [])
