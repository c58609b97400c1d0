"""Joints of mechanisms, of which the hinge of a door is one."""

import math

import mujoco
import pytest

from mjsim.compile.joint_motors import add_joint, add_motor
from mjsim.sim.script.scripted_joints import Joints
from mjsim.world import MotorJoint

DRAWER = MotorJoint(
    name="desk/drawer",
    kind="prismatic",
    axis=(1.0, 0.0, 0.0),
    start=0.1,
    lower=0.0,
    upper=0.5,
    damping=2.0,
    locked=True,
    inertia=4.0,
    effort=30.0,
    speed=0.25,
    lead=0.05,
    tolerance=1e-3,
)
FLAP = MotorJoint(
    name="wall/flap",
    axis=(0.0, 1.0, 0.0),
    start=math.radians(30.0),
    lower=math.radians(-90.0),
    upper=math.radians(90.0),
    inertia=4.0 * (0.4**2 + 0.1**2) / 12,
    effort=20.0,
    speed=1.0,
    lead=0.2,
    tolerance=2e-3,
)


def scene(joint):
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = 0.004, [0.0, 0.0, 0.0]
    body = spec.worldbody.add_body(name=joint.name)
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.2, 0.2, 0.05], mass=4.0)
    add_joint(body, joint)
    add_motor(spec, joint)
    model = spec.compile()
    data = mujoco.MjData(model)
    return model, data, Joints(model, data, [joint])


@pytest.mark.parametrize(("joint", "goal"), [(DRAWER, 0.45), (FLAP, math.radians(-60.0))])
def test_a_motor_moves_a_joint_to_its_goal_as_a_critically_damped_follower_of_a_ramp(joint, goal):
    model, data, joints = scene(joint)
    assert joints.value(joint.name) == pytest.approx(joint.start, abs=1e-12)
    joints.move(joint.name, goal)
    fastest = 0.0
    while joints.moving and data.time < 20.0:
        joints.drive()
        mujoco.mj_step(model, data)
        fastest = max(fastest, abs(float(data.qvel[0])))
    assert joints.value(joint.name) == pytest.approx(goal, abs=joint.tolerance)
    # Behind a ramp of speed v that begins at rest, the error is v t exp(-w t): the speed ends at v, and is
    # v (1 + exp(-2)) at most, at t = 2 / w. Damping makes it less, steps of 4 ms a little more.
    assert joint.speed < fastest < joint.speed * (1.0 + math.exp(-2.0)) * 1.002
    assert data.time > abs(goal - joint.start) / joint.speed


def test_a_locked_joint_withstands_a_push_where_it_was_moved_to():
    model, data, joints = scene(DRAWER)
    joints.move(DRAWER.name, 0.3)
    while joints.moving:
        joints.drive()
        mujoco.mj_step(model, data)
    for _ in range(250):
        data.qfrc_applied[0] = 20.0
        mujoco.mj_step(model, data)
    assert joints.value(DRAWER.name) == pytest.approx(0.3, abs=0.01)


def test_angles_come_through_radians_as_they_were_written():
    model, *_ = scene(FLAP)
    assert model.qpos0[0] == math.radians(30.0)
