"""Scenes of robots and things from files: masses, places and joints are those of the file, computed another way."""

import functools
import math
import re

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.compile.model_looks import LookOf
from mjsim.compile.mujoco_model import compiled
from mjsim.compile.robots.stability import drives, likely_cause
from mjsim.compile.scene_lamps import dim_light, general_light, lamp_lights, lamps_drawn
from mjsim.compile.textures import add_matte
from mjsim.compile.usd import _plainly_named
from mjsim.exchange import RobotOptions
from mjsim.exchange.robots.driven_wheels import find_gear
from mjsim.exchange.robots.preset import first_plan, preset_text, wheels_by_name
from mjsim.exchange.robots.robot_frame import find_stand
from mjsim.models import anatomy_of, gather_robot
from mjsim.world import Source, parse_world
from tests.exchange.odd_robots import on_casters, on_mecanum, on_three, rover, tricycle


@functools.cache
def scene(kind: str, more: str = ""):
    """Return model and data of a scene with a robot from a file, its wheels there by name, its stand, and the file."""
    text = {
        "differential": on_casters(),
        "six": rover([0.25, 0.0, -0.25]),
        "mecanum": on_mecanum(rollers=4),
        "omni3": on_three(),
        "tricycle": tricycle(),
    }[kind]
    files = gather_robot("r.urdf", lambda _: text.encode())
    anatomy = anatomy_of(files)
    gear = find_gear(anatomy, RobotOptions(), file="r.urdf", urdf=True)
    stand = find_stand(anatomy, gear, acceleration=1.0)
    preset = preset_text(first_plan("r", "r.urdf", gear, stand, ()), ())
    preset = preset.replace("at: [0, 0]", "at: [3, 2]\n    heading_deg: 90").replace(
        "    body:\n", f"    body:\n{more}"
    )
    world = parse_world(preset, source=Source(file="r.yaml", attached={"r.urdf": text.encode()}))
    model = compiled(compile_world(world))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data, wheels_by_name(gear), stand, files.model


def in_robot(data: mujoco.MjData, place: np.ndarray) -> np.ndarray:
    """Return a point of the world in the frame of the robot, which stands at (3, 2) and looks along y."""
    x, y, z = place
    return np.array([y - 2.0, 3.0 - x, z])


KINDS = ("differential", "six", "mecanum", "omni3", "tricycle")


@pytest.mark.parametrize("kind", KINDS)
def test_wheels_stand_where_the_file_has_them_and_on_the_floor(kind):
    _, data, wheels, stand, _ = scene(kind)
    for name, (first, *others) in wheels.items():
        for number, wheel in enumerate((first, *others)):
            body = f"r/wheel_{name}" + (f"-{number + 1}" if number else "")
            place, expected = in_robot(data, data.body(body).xpos), stand.point(wheel.middle)
            assert place[:2] == pytest.approx(expected[:2], abs=2e-3)
            assert place[2] == pytest.approx(wheel.radius, abs=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_a_robot_weighs_what_its_file_does(kind):
    model, data, _, stand, file = scene(kind)
    root = int(model.body_rootid[model.body("r/wheel_" + next(iter(scene(kind)[2]))).id])
    total = float(file.body_mass.sum())
    assert data.subtree_com[root].shape == (3,)
    assert model.body_subtreemass[root] == pytest.approx(total, rel=0.01)
    center = in_robot(data, data.subtree_com[root])
    assert center[:2] == pytest.approx(stand.center[:2], abs=0.02)
    heavy, *_ = scene(kind, "      mass: 60\n")
    assert heavy.body_subtreemass[root] == pytest.approx(60.0, rel=0.01)


def test_joints_of_the_file_are_held_at_their_limits_and_keep_them():
    model, data, _, _, file = scene("differential")
    for name, kind in (("shoulder", mujoco.mjtJoint.mjJNT_HINGE), ("slide", mujoco.mjtJoint.mjJNT_SLIDE)):
        joint = model.joint(f"r/{name}")
        assert joint.type[0] == kind
        assert joint.range == pytest.approx(file.joint(name).range)
        assert model.qpos0[joint.qposadr[0]] == pytest.approx(0.1)
        lock = model.equality(f"r/{name}")
        assert (lock.type[0], lock.active0[0], lock.obj1id[0]) == (mujoco.mjtEq.mjEQ_JOINT, 1, joint.id)
        least = 1e-4 * file.body_mass.sum()
        radius = float(re.search(r"radius: ([\d.]+)\n      height", preset_of("differential"))[1])
        expected = least if name == "slide" else least * radius**2
        assert model.dof_armature[joint.dofadr[0]] == pytest.approx(expected, rel=1e-6)
    # The arm leans by 0.1 rad about the x axis of the file.
    arm = data.body("r/arm").xmat.reshape(3, 3)
    assert math.acos(arm[2, 2]) == pytest.approx(0.1, abs=1e-6)


def preset_of(kind: str) -> str:
    text = on_casters()
    anatomy = anatomy_of(gather_robot("r.urdf", lambda _: text.encode()))
    gear = find_gear(anatomy, RobotOptions(), file="r.urdf", urdf=True)
    stand = find_stand(anatomy, gear, acceleration=1.0)
    return preset_text(first_plan("r", "r.urdf", gear, stand, ()), ())


def test_wheels_between_the_axles_are_coupled_and_have_no_motor():
    model, _, wheels, _, _ = scene("six")
    for leader, (_, *others) in wheels.items():
        for number, _ in enumerate(others, start=2):
            name = f"r/wheel_{leader}-{number}"
            chain = model.equality(name)
            joints = [model.joint(int(each)).name for each in (chain.obj1id[0], chain.obj2id[0])]
            assert joints == [name, f"r/wheel_{leader}"]
            assert chain.data[:5].tolist() == [0.0, 1.0, 0.0, 0.0, 0.0]
    driven = {model.joint(int(model.actuator_trnid[k][0])).name for k in range(model.nu)}
    assert driven == {f"r/wheel_{name}" for name in wheels}


def test_the_wheel_of_a_tricycle_turns_about_its_kingpin():
    model, data, wheels, stand, _ = scene("tricycle")
    (drive,) = wheels["drive"]
    knuckle = model.body("r/steer")
    assert model.body(int(model.body("r/wheel_drive").parentid[0])).name == knuckle.name
    assert in_robot(data, data.body("r/steer").xpos)[:2] == pytest.approx(stand.point(drive.steer.at)[:2], abs=1e-6)
    joint = model.joint("r/steer")
    assert data.xaxis[joint.id] == pytest.approx([0.0, 0.0, 1.0])


def test_rollers_of_the_file_are_replaced_by_ours():
    model, _, wheels, _, _ = scene("mecanum")
    for name in wheels:
        body = model.body(f"r/wheel_{name}").id
        below = [k for k in range(model.nbody) if model.body_parentid[k] == body]
        assert len(below) > 4
        assert all(model.body_jntnum[k] == 1 for k in below)
    assert not [k for k in range(model.njnt) if re.search(r"_l_\d_joint|_r_\d_joint", model.joint(k).name)]


THING = """<mujoco><compiler angle="radian"/><worldbody><body name="foot"><geom type="box" size=".2 .1 .05" mass="3"/>
<body name="lid" pos=".1 0 .1" quat="0 1 0 0"><joint name="hinge" type="{0}" axis="0 1 0" range="-.5 {1}" limited="true"
damping="2" stiffness="3" springref=".2" ref=".1" armature=".4" frictionloss=".05" pos=".01 0 0"/>
<geom type="box" size=".1 .05 .02" pos="0 0 .03" mass="1"/></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("kind", ["hinge", "slide"])
def test_a_scaled_thing_keeps_its_proportions(kind):
    text = THING.format(kind, ".7").encode()
    plain = mujoco.MjModel.from_xml_string(text.decode())
    more = "scale: 2, mass: 20, movable: true"
    world = parse_world(
        f"mjsim: 1\nobstacles: [{{name: t, model: t.xml, at: [0, 0], {more}}}]\n",
        source=Source(file="w.yaml", attached={"t.xml": text}),
    )
    model = compiled(compile_world(world))
    lid, file = model.body("obstacle/t/lid"), plain.body("lid")
    heavier = 20.0 / 4.0
    assert lid.mass[0] == pytest.approx(heavier * 1.0)
    assert np.sort(lid.inertia) == pytest.approx(np.sort(file.inertia) * heavier * 4.0)
    assert lid.ipos == pytest.approx(2.0 * file.ipos)
    assert lid.pos == pytest.approx(2.0 * file.pos)
    assert lid.quat == pytest.approx(file.quat)
    joint, own = model.joint("obstacle/t/hinge"), plain.joint("hinge")
    unit = 2.0 if kind == "slide" else 1.0
    assert joint.range == pytest.approx(own.range * unit)
    assert joint.pos == pytest.approx(own.pos * 2.0)
    assert joint.axis == pytest.approx(own.axis)
    address = int(joint.qposadr[0])
    assert (model.qpos0[address], model.qpos_spring[address]) == pytest.approx((0.1 * unit, 0.2 * unit))
    dof = int(joint.dofadr[0])
    found = [float(values[dof]) for values in (model.dof_damping, model.dof_armature, model.dof_frictionloss)]
    assert found == pytest.approx([2.0, 0.4, 0.05])
    assert model.jnt_stiffness[joint.id] == pytest.approx(3.0)
    assert model.body_subtreemass[lid.rootid[0]] == pytest.approx(20.0)


LOOKS = """<mujoco><asset><texture name="flat" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1"
width="4" height="2"/>
<texture name="cube" type="cube" builtin="gradient" rgb1="1 0 0" rgb2="0 1 0" width="4" height="4"/>
<material name="plain" rgba="1 0 0 .5" specular=".3" shininess=".7" emission=".2" reflectance=".9"/>
<material name="flat" texture="flat" texrepeat="2 3" texuniform="true"/><material name="cube" texture="cube"/></asset>
<worldbody><geom size="1"/><geom size="1" rgba="0 1 0 1"/><geom size="1" material="plain"/>
<geom size="1" material="flat"/><geom size="1" material="cube"/><geom size="1" material="flat"/></worldbody></mujoco>"""


def test_looks_of_a_file_are_rebuilt_once_each_in_the_scene():
    file, spec = mujoco.MjModel.from_xml_string(LOOKS), mujoco.MjSpec()
    add_matte(spec, "matte")
    looks = LookOf(spec, file, "k")
    keys = [looks.of_geom(number, plain=None) for number in range(file.ngeom)]
    names = [key["material"] for key in keys]
    assert names == ["matte", "matte", "k/look1", "k/look2", "k/look3", "k/look2"]
    assert keys[0]["rgba"] == pytest.approx([128 / 255] * 3 + [1.0])
    assert keys[1]["rgba"] == [0.0, 1.0, 0.0, 1.0]
    assert looks.of_geom(3, plain="#ff0000") == {"material": "matte", "rgba": [1.0, 0.0, 0.0, 1.0]}
    for number, name in enumerate(names):
        spec.worldbody.add_geom(size=[1, 0, 0], material=name, rgba=keys[number]["rgba"])
    model = spec.compile()
    for own, name in enumerate(("k/look1", "k/look2", "k/look3")):
        made = model.material(name)
        assert made.rgba == pytest.approx(file.mat_rgba[own])
        for key in ("emission", "specular", "shininess", "texuniform"):
            assert getattr(made, key)[0] == pytest.approx(float(getattr(file, f"mat_{key}")[own]))
        assert made.texrepeat == pytest.approx(file.mat_texrepeat[own])
        assert made.reflectance[0] == 0.0
    flat, cube = (int(model.material(name).texid[1]) for name in ("k/look2", "k/look3"))
    assert (model.tex_type[flat], model.tex_type[cube]) == (file.tex_type[0], file.tex_type[1])
    for texture, own in ((flat, 0), (cube, 1)):
        size = int(file.tex_height[own]) * int(file.tex_width[own]) * 3
        pixels = [m.tex_data[m.tex_adr[k] : m.tex_adr[k] + size] for m, k in ((model, texture), (file, own))]
        assert np.array_equal(*pixels)


SERVO = """<mujoco><option timestep=".01"/><worldbody><body><joint name="j" axis="0 1 0" armature="{0}"/>
<geom type="box" size=".1 .1 .1" mass="{1}"/></body></worldbody><actuator>{2}</actuator></mujoco>"""


@pytest.mark.parametrize(
    ("armature", "mass", "servo", "said"),
    [
        (1.0, 1.0, '<velocity name="s" joint="j" kv="190"/>', ""),
        (0.0, 60.0, '<velocity name="s" joint="j" kv="70"/>', ""),
        (
            0.0,
            60.0,
            '<velocity name="s" joint="j" kv="90"/>',
            "servo 's' with kv=90 is too stiff for joint 'j'",
        ),
        (0.0, 60.0, '<position joint="j" kp="15000"/>', ""),
        (0.0, 60.0, '<position joint="j" kp="17000"/>', "servo 'j' with kp=17000 is too stiff for joint 'j'"),
        (0.0, 60.0, '<motor joint="j"/>', ""),
        (0.0, 1e-4, '<motor joint="j"/>', "joint 'j' has no armature and moves an inertia of"),
        (1e-3, 1e-4, '<motor joint="j"/>', ""),
    ],
)
def test_servos_that_one_step_overshoots_are_named(armature, mass, servo, said):
    model = mujoco.MjModel.from_xml_string(SERVO.format(armature, mass, servo))
    mujoco.mj_forward(model, mujoco.MjData(model))
    found = likely_cause(model)
    assert found.startswith(said) if said else found == ""
    inertia = mass * (0.2**2 + 0.2**2) / 12 + armature
    if "kv=90" in found:
        assert f"an inertia of {inertia:.2g} kg m^2 and no armature; reduce kv to {2 * inertia / 0.01:.2g} or" in found
    if "kp=" in found:
        assert f"{4 * inertia / 0.01**2:.2g} or add an armature" in found


CAR = """<mujoco><worldbody><body pos="0 0 1"><freejoint/><geom size=".1" contype="0"/>
<body pos="0 .2 0"><joint name="l" axis="0 1 0"/><geom size=".1"/></body>
<body pos="0 -.2 0"><joint name="r" axis="0 1 0"/><geom size=".1"/></body></body></worldbody>
<actuator><velocity joint="l" kv="{0}"/><velocity joint="r" kv="1" ctrlrange="-2 1" ctrllimited="true"/>
<position joint="l" kp="0.1"/></actuator></mujoco>"""


def test_a_robot_is_tried_with_speeds_of_both_sides(monkeypatch):
    from mjsim.compile.robots import stability

    model, orders = mujoco.MjModel.from_xml_string(CAR.format(1)), []

    def step(_: object, data: mujoco.MjData) -> None:
        orders.append(tuple(data.ctrl.tolist()))

    monkeypatch.setattr(stability.mujoco, "mj_step", step)
    assert drives(model, speed=0.5)
    assert len(orders) == 5 * 125
    # Left and right; limited to -2 and 1; a position servo is left in the middle.
    assert list(dict.fromkeys(orders)) == [
        (0, 0, 0), (0.5, 0.5, 0), (-0.5, -0.5, 0), (-0.5, 0.5, 0), (0.5, -0.5, 0),
    ]  # fmt: skip
    orders.clear()
    assert drives(model, speed=3.0)
    assert (-3.0, 1.0, 0.0) in orders


@pytest.mark.filterwarnings("ignore")
def test_a_robot_that_flies_apart_does_not_drive():
    assert not drives(mujoco.MjModel.from_xml_string(CAR.format(-1e9)), speed=3.0)


def test_light_is_counted_and_dimmed():
    text = "mjsim: 1\nlight: 0.5\nlamps: [{at: [1, 1], height: 2.5}, {at: [2, 2], height: 2.5}]\n"
    model = compiled(compile_world(parse_world(text)))
    assert general_light(model) == pytest.approx(0.5)
    assert len(lamp_lights(model)) == 2
    directed = sum(int(kind) == int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL) for kind in model.light_type)
    assert lamps_drawn(model) == 7 - directed
    model.light_active[:] = 0
    assert lamps_drawn(model) == 7
    dim_light(model, 0.25)
    other = mujoco.MjModel.from_xml_string("<mujoco/>")
    assert (general_light(other), lamps_drawn(other)) == (1.0, 7)


def test_names_for_usd_have_letters_digits_and_underscores_and_stay_apart():
    spec = mujoco.MjSpec()
    for name in ("a/b-c", "a_b_c", "a b c", "plain", ""):
        spec.worldbody.add_geom(name=name, size=[1, 0, 0])
    assert [geom.name for geom in _plainly_named(spec).geoms] == ["a_b_c_", "a_b_c", "a_b_c__", "plain", ""]


OWN = """mjsim: 1
light: {0}
walls: [{{points: [[-4, -3], [4, -3], [4, 3], [-4, 3]], closed: true, height: 2.4}}]
robots: [{{name: r, preset: pioneer3dx, at: [1, 2], heading_deg: 90}}]
beacons: [{{name: lion, image: posters/lion.jpg, at: [3.94, 0], heading_deg: 180, width: 1.0}}]
"""


@functools.cache
def own(light: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = compiled(compile_world(parse_world(OWN.format(light))))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def lit(model: mujoco.MjModel, normal: list[float]) -> float:
    """Return the light of the scene's ambient light on a face, without what comes from the viewer."""
    light = float(np.mean(model.vis.headlight.ambient))
    for number in range(model.nlight):
        if model.light_type[number] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL and model.light_active[number]:
            light += float(model.light_diffuse[number].mean()) * max(0.0, -float(model.light_dir[number] @ normal))
    return light


def test_faces_of_all_directions_have_the_light_that_is_stated():
    model, _ = own(1.0)
    faces = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]]
    levels = [lit(model, face) for face in faces]
    assert levels == pytest.approx([0.86, 0.92, 0.83, 0.71, 0.93], abs=0.01)
    assert float(np.mean(model.vis.headlight.diffuse)) == pytest.approx(0.08)
    half, _ = own(0.5)
    assert [lit(half, face) for face in faces] == pytest.approx(0.5 * np.array(levels), rel=1e-6)
    # A picture glows and reflects; in half the light both together are half, on average over these faces.
    (picture,) = [k for k in range(half.nmat) if half.mat(k).name.startswith("beacon/")]
    share = float(half.mat_rgba[picture, 0])
    assert share == 0.25
    reflected = share * (np.mean(levels) + 0.08) * 0.5
    assert half.mat_emission[picture] * share + reflected == pytest.approx(0.5, abs=0.005)
    assert model.mat_emission[picture] * share == pytest.approx(1.0)
    dimmed = compiled(compile_world(parse_world(OWN.format(1.0))))
    dim_light(dimmed, 0.5)
    assert general_light(dimmed) == 0.5
    assert dimmed.mat_emission[picture] == pytest.approx(half.mat_emission[picture])
    assert [lit(dimmed, face) for face in faces] == pytest.approx(0.5 * np.array(levels), rel=1e-6)
    dim_light(dimmed, 0.0)
    assert not dimmed.light_active.any()


def seen_at(model: mujoco.MjModel, data: mujoco.MjData, camera: str, point: list[float]) -> tuple[float, float]:
    """Return where a camera sees a point: right and up, as shares of half its height."""
    place = data.camera(camera)
    right, up, back = place.xmat.reshape(3, 3).T @ (np.array(point) - place.xpos)
    assert back < 0.0, "it is behind the camera"
    scale = math.tan(math.radians(model.camera(camera).fovy[0]) / 2) * -back
    return right / scale, up / scale


def test_the_chase_camera_looks_ahead_over_the_robot_and_the_overview_sees_all_corners():
    model, data = own(1.0)
    behind = in_robot_of(data.camera("r/chase").xpos)
    assert behind[0] < -1.0
    assert behind[1] == pytest.approx(0.0, abs=1e-9)
    across, height = seen_at(model, data, "r/chase", [1.0, 2.0, 0.2])
    assert across == pytest.approx(0.0, abs=1e-6)
    assert -1.0 < height < 0.0
    # Two metres ahead and one to the left (of y: to -x) is above and to the left.
    left, ahead = seen_at(model, data, "r/chase", [0.0, 4.0, 0.0])
    assert left < -0.2
    assert ahead > height + 0.3
    for corner in ((x, y, z) for x in (-4, 4) for y in (-3, 3) for z in (0.0, 2.4)):
        across, height = seen_at(model, data, "overview", list(corner))
        assert abs(height) < 1.0
        assert abs(across) < 16 / 9


def in_robot_of(place: np.ndarray) -> np.ndarray:
    """Return a point in the frame of the robot at (1, 2) that looks along y."""
    return np.array([place[1] - 2.0, 1.0 - place[0], place[2]])


def test_an_own_robot_weighs_what_its_world_says_with_its_wheels_under_it():
    model, data = own(1.0)
    world = parse_world(OWN.format(1.0))
    (robot,) = world.robots
    root = int(model.body("r/base").id)
    assert model.body_subtreemass[root] == pytest.approx(robot.body.mass, rel=0.01)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        place = in_robot_of(data.body(f"r/wheel_{side}").xpos)
        assert place[1] == pytest.approx(sign * robot.drive.track / 2, abs=1e-6)
        assert place[2] == pytest.approx(robot.drive.wheel_radius, abs=2e-3)
        wheel = model.body(f"r/wheel_{side}")
        # Its inertia is given, not that of the shapes: about its axle most.
        assert np.argmax(wheel.inertia) == 0 or wheel.inertia.max() > 1.2 * wheel.inertia.min()
        assert wheel.ipos == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
