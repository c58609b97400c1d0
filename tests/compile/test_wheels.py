"""Wheels of each drive as MuJoCo has them: masses, sizes, rollers that run true, and servos."""

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.compile import LAG, RESPONSE, compile_world
from mjsim.compile.robots.robot_bodies import leaning_start
from mjsim.compile.robots.wheels import MAX_STEP, SAGS, STIFFNESS
from mjsim.world import parse_world

DRIVES = ("differential", "skid_steer", "ackermann", "tricycle", "omni3", "mecanum")


@pytest.fixture(scope="module")
def compiled():
    """Return robot and model by the kind of the drive; each robot weighs 20 kg."""
    found = {}
    for kind in DRIVES:
        body = "body: {box: [0.6, 0.5, 0.3], mass: 20}"
        world = parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], drive: {{type: {kind}}}, {body}}}]\n")
        model = compile_world(world).compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        found[kind] = world.robots[0], model, data
    return found


@pytest.mark.parametrize("kind", DRIVES)
def test_a_robot_weighs_what_its_world_says_with_all_its_wheels(compiled, kind):
    _, model, _ = compiled[kind]
    assert model.body("r/base").subtreemass[0] == pytest.approx(20.0)
    assert (model.body_inertia[1:] > 0.0).all()


@pytest.mark.parametrize("kind", ["differential", "skid_steer", "ackermann", "tricycle"])
def test_plain_wheels_stand_into_the_floor_by_their_sag_where_the_drive_has_them(compiled, kind):
    robot, model, data = compiled[kind]
    for wheel in robot.drive.wheels:
        body = model.body(f"r/wheel_{wheel.name}")
        (tread,) = (
            number
            for number in range(body.geomadr[0], body.geomadr[0] + body.geomnum[0])
            if model.geom_type[number] == mujoco.mjtGeom.mjGEOM_ELLIPSOID
        )
        centre, size = data.geom_xpos[tread], model.geom_size[tread]
        np.testing.assert_allclose(centre[:2], wheel.at, atol=1e-9)
        assert centre[2] - size[2] == pytest.approx(-SAGS[wheel.load], abs=1e-9)
        # It rolls on the circle of its radius.
        assert (size[2] + centre[2]) / 2 == pytest.approx(wheel.radius)
        assert size[1] == pytest.approx(wheel.half_width)
        assert model.geom_friction[tread, 0] < 0.01, "the friction is that of the floor"
        axis = data.xaxis[model.joint(f"r/wheel_{wheel.name}").id]
        np.testing.assert_allclose(axis, [0.0, 1.0, 0.0], atol=1e-9)


def lowest(model, data, wheel: str) -> float:
    """Return the height of the lowest point of all rollers of a wheel [m]."""
    heights = []
    for number in range(model.ngeom):
        name = model.body(model.geom_bodyid[number]).name
        if name.startswith(f"r/{wheel}/roller") and model.geom_conaffinity[number]:
            # An ellipsoid reaches as far down as its half axes, seen along the vertical.
            down = data.geom_xmat[number].reshape(3, 3)[2]
            heights.append(
                data.geom_xpos[number][2]
                - math.sqrt(float((model.geom_size[number] * down) @ (model.geom_size[number] * down)))
            )
    return min(heights)


@pytest.mark.parametrize("kind", ["omni3", "mecanum"])
def test_wheels_with_rollers_run_true_and_their_rollers_stand_at_their_angle(compiled, kind):
    robot, model, data = compiled[kind]
    for wheel in robot.drive.wheels:
        hinge = model.joint(f"r/wheel_{wheel.name}")
        for angle in np.linspace(0.0, math.pi / wheel.rollers.count, 5):
            data.qpos[hinge.qposadr[0]] = angle
            mujoco.mj_forward(model, data)
            assert lowest(model, data, f"wheel_{wheel.name}") == pytest.approx(0.0, abs=0.02 * wheel.radius)
        data.qpos[hinge.qposadr[0]] = 0.0
        mujoco.mj_forward(model, data)
        axis = data.xaxis[model.joint(f"r/wheel_{wheel.name}/roller1").id]
        expected = wheel.heading + math.pi / 2 + wheel.rollers.angle
        assert abs(axis[2]) < 1e-9
        assert math.remainder(math.atan2(axis[1], axis[0]) - expected, math.pi) == pytest.approx(0.0, abs=1e-9)
        place = data.xpos[model.body(f"r/wheel_{wheel.name}").id]
        np.testing.assert_allclose(place, [*wheel.at, wheel.radius], atol=1e-9)


@pytest.mark.parametrize("kind", DRIVES)
def test_servos_of_wheels_follow_with_their_lag_and_stay_stable_in_the_longest_step(compiled, kind):
    robot, model, _ = compiled[kind]
    for name in robot.drive.driven_wheels:
        servo, hinge = model.actuator(f"r/{name}"), model.joint(f"r/{name}")
        gain, armature = servo.gainprm[0], model.dof_armature[hinge.dofadr[0]]
        assert servo.biasprm[2] == -gain
        if kind == "differential":
            # Each of both wheels moves half of the mass at its rim, and its own inertia.
            assert servo.dyntype[0] == mujoco.mjtDyn.mjDYN_NONE
            load = gain * RESPONSE - armature
            assert load == pytest.approx(10.0 * robot.drive.wheel_radius**2, rel=0.2)
        else:
            assert (servo.dyntype[0], servo.dynprm[0]) == (mujoco.mjtDyn.mjDYN_FILTEREXACT, LAG)
            assert gain * MAX_STEP / armature == pytest.approx(STIFFNESS)


@pytest.mark.parametrize("kind", ["ackermann", "tricycle"])
def test_servos_of_steering_are_critically_damped(compiled, kind):
    robot, model, _ = compiled[kind]
    for name in robot.drive.steering:
        servo, hinge = model.actuator(f"r/{name}"), model.joint(f"r/{name}")
        inertia = 1.5 * model.dof_armature[hinge.dofadr[0]]
        stiffness, damping = -servo.biasprm[1], -servo.biasprm[2]
        assert servo.gainprm[0] == stiffness
        assert damping == pytest.approx(2.0 * math.sqrt(stiffness * inertia))
        assert servo.dynprm[0] == LAG


def test_casters_slide_and_the_touched_body_gives_way_a_little(compiled):
    _, model, data = compiled["differential"]
    casters = [
        number
        for number in range(model.ngeom)
        if model.geom_type[number] == mujoco.mjtGeom.mjGEOM_SPHERE and model.geom_contype[number]
    ]
    assert len(casters) == 2
    ahead, behind = sorted((data.geom_xpos[number] for number in casters), key=lambda place: -place[0])
    np.testing.assert_allclose(ahead, behind * [-1.0, 1.0, 1.0], atol=1e-9)
    for number in casters:
        assert (model.geom_priority[number], model.geom_condim[number]) == (1, 1)
        np.testing.assert_array_equal(model.geom_friction[number], 0.0)
        assert data.geom_xpos[number][2] - model.geom_size[number][0] < 0.0, "it carries a part of the weight"


def test_a_robot_that_leans_at_the_start_turns_about_its_axle():
    text = "mjsim: 1\nrobots: [{name: joe, preset: balancer, at: [1, 2], heading_deg: 50, lean_deg: 12}]\n"
    (joe,) = parse_world(text).robots
    x, y, z, w, *axis = leaning_start(joe)
    turned = Rotation.from_quat([*axis, w])
    expected = Rotation.from_euler("ZY", [50, 12], degrees=True)
    assert (turned * expected.inv()).magnitude() == pytest.approx(0.0, abs=1e-12)
    radius = joe.drive.driven_radius
    np.testing.assert_allclose(np.array([x, y, z]) + turned.apply([0, 0, radius]), [1, 2, radius], atol=1e-12)
