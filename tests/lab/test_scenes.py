"""Modules that designs are written as, inputs that were recorded, and parts of scenes as plants."""

import math
from types import SimpleNamespace

import control
import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.lab import LinearPlant, ScenePlant, experiment, lqr_design, module_text
from mjsim.lab.closed import closed_loop
from mjsim.lab.design import Design
from mjsim.lab.effects import ForceEffect, LedJoint
from mjsim.lab.experiment import plants_of
from mjsim.lab.plant_parts import part_of, working_point
from mjsim.lab.recorded_plant import recorded
from mjsim.record import JointTrack
from mjsim.world import Plant
from tests.lab.test_parts import DOUBLE, THIRD, WORLD

GAIN = Design(
    name="k", poles=np.zeros(0), margins={}, time=np.zeros(1), step=np.zeros((1, 1)), gain=(1.5, -2.0, 3.0, 4.0)
)
SERIES = Design(
    name="s", poles=np.zeros(0), margins={}, time=np.zeros(1), step=np.zeros((1, 1)), num=(1.0, 2.0), den=(3.0, 1.0)
)


def plain(states, of_input, unit, outputs=("y",)):
    n = len(states)
    return LinearPlant(
        A=np.zeros((n, n)), B=np.zeros((n, 1)), C=np.zeros((len(outputs), n)), D=np.zeros((len(outputs), 1)),
        states=states, input=of_input, outputs=outputs, units=(unit, *("",) * len(outputs)),
    )  # fmt: skip


def given(of, of_input, **around):
    return Plant.model_construct(name="p", of=of, input=of_input, outputs=("y",), around=around)


LAW, FED_BACK = "num: [1, 2], den: [3, 1]", "gain: [1.5, -2, 3, 4]"
USE = '{use: "mjsim.algorithms.linear_control:'
DRIVERS = "run:\n  drivers:\n    r:\n      "


@pytest.mark.parametrize(
    ("plant", "states", "outputs", "unit", "design", "text"),
    [
        (
            given("r/arm", "q"),
            ["q"],
            ["q"],
            "N m",
            SERIES,
            f'controllers: {{arm: {USE}JointLoop", joint: q, {LAW}}}}}\n',
        ),
        (
            given("r", "torque"),
            ["way", "lean"],
            ["y"],
            "N m",
            GAIN,
            f'{DRIVERS}controllers: {{drive: {USE}StateFeedback", {FED_BACK}}}}}\n',
        ),
        (
            given("r", "forward"),
            ["v"],
            ["y"],
            "m/s",
            SERIES,
            f'{DRIVERS}navigator: {USE}SpeedLoop", of: forward, {LAW}, reference: {{step: {{to: 0.3}}}}}}\n',
        ),
        (
            given("r", "turn"),
            ["v"],
            ["y"],
            "rad/s",
            SERIES,
            f"of: turn, {LAW}, reference: {{step: {{to_deg: 30}}}}}}\n",
        ),
        (given("r", "forward"), ["v"], ["y"], "m/s", GAIN, f"# a controller: {FED_BACK}\n"),
        (
            given("m", "x", x=0.5, q_deg=90.0),
            ["x", "q"],
            ["y"],
            "N",
            GAIN,
            f'actuators:\n  - force: x\n    controller: {USE}MechanismLoop",'
            " gain: {x: [1.5, 3], q: [-2, 4]}, about: {x: 0.5}, about_deg: {q: 90}}\n",
        ),
        (
            given("m", "q"),
            ["q"],
            ["q"],
            "N m",
            SERIES,
            f'  - torque: q\n    controller: {USE}MechanismLoop", {LAW}}}\n',
        ),
        (given("m", "q"), ["q"], ["other"], "N m", SERIES, f"# a controller: {LAW}\n"),
        (given(None, "u"), ["x1"], ["y"], "", SERIES, f"# a controller: {LAW}\n"),
    ],
)
def test_a_design_is_written_as_the_module_that_runs_it(plant, states, outputs, unit, design, text):
    states = (*states, *(f"{name}.rate" for name in states))
    assert module_text(plant, plain(states, plant.input, unit, tuple(outputs)), design).endswith(text)


def test_a_joint_that_is_led_needs_the_second_difference_of_its_values():
    force = ForceEffect(unit="N m", ctrl=np.zeros(0), applied=np.ones(1))
    inputs = np.array([0.0, 0.1, 0.3, 0.3])
    by_value, by_speed = (LedJoint(unit="", force=force, dof=0, is_speed=speed) for speed in (False, True))
    np.testing.assert_allclose(by_value.accelerations(inputs, 0.5), [0.0, 0.4, 0.4, -0.8])
    np.testing.assert_allclose(by_speed.accelerations(inputs, 0.5), [0.0, 0.2, 0.4, 0.0])


MECHANISM = """
mjsim: 1
mechanisms:
  - name: m
    elevation: 4
    bodies: [{name: arm, rod: [1.0, 0.03]}, {name: slider, box: [0.1, 0.1, 0.1], mass: 1}]
    joints:
      - {revolute: a, of: [ground, arm], axis: [0, 1, 0], damping: 0.5, start_deg: 90}
      - {prismatic: s, of: [{ground: [2, 0, 0]}, slider], axis: [1, 0, 0], damping: 2}
run: {step_ms: 2, rate_hz: 500}
plants: [PLANT]
"""


def scene(keys):
    world = mjsim.parse_world(MECHANISM.replace("PLANT", f"{{name: p, of: m, {keys}}}"))
    return world, ScenePlant(world, world.plants[0])


def made_up(world, lab, *, joints=None):
    n = 6
    time = 0.002 * np.arange(n)
    qpos = np.tile(lab.setting.qpos, (n, 1)) + 0.01 * np.arange(n)[:, None]
    rows = np.column_stack([np.arange(n) + 1.0, 10.0 * np.arange(n) + 5.0])
    track = JointTrack(
        names=("a", "s"), positions=rows, velocities=2 * rows, accelerations=rows, torques=3 * rows, goal=rows,
        tool=np.zeros((n, 7)),
    )  # fmt: skip
    joints = {"m": track} if joints is None else joints
    return SimpleNamespace(
        world=world, joints=joints, robots={}, time=time, qpos=qpos, qvel=np.zeros((n, lab.model.nv)), seed=1
    )


@pytest.mark.parametrize(
    ("keys", "values", "held"),
    [
        ("input: s.force, outputs: [s]", 3 * (10.0 * np.arange(6) + 5.0), False),
        ("input: a.torque, outputs: [a]", 3 * (np.arange(6) + 1.0), False),
        ("input: s.velocity, outputs: [a, s]", 20.0 * np.arange(6) * 1.0, False),
        ("input: a.angle, outputs: [a]", np.arange(6.0), False),
    ],
)
def test_the_input_of_a_mechanism_is_the_torque_or_motion_that_was_recorded(keys, values, held):
    world, lab = scene(keys)
    recording = made_up(world, lab)
    found = recorded(recording, lab)
    np.testing.assert_allclose(found.inputs, values)
    assert (found.held, found.source) == (held, "the recording")
    np.testing.assert_allclose(found.time, recording.time)
    place = int(lab.model.joint(f"m/{lab.plant.outputs[0]}").qposadr[0])
    np.testing.assert_allclose(found.outputs[0], recording.qpos[:, place])


def test_a_recording_of_something_else_is_refused():
    world, lab = scene("input: s.force, outputs: [s]")
    with pytest.raises(UsageError, match="the recording has no 'm'"):
        recorded(made_up(world, lab, joints={}), lab)
    other = made_up(world, lab)
    other.qpos = other.qpos[:, :1]
    with pytest.raises(UsageError, match="a scene with other joints"):
        recorded(other, lab)
    unknown = made_up(world, lab)
    unknown.joints["m"].torques[2] = np.nan
    assert len(recorded(unknown, lab).time) == 5


def test_a_scene_is_stepped_as_its_linear_plant_predicts():
    world, lab = scene("input: s.force, outputs: [s, s.rate]")
    assert lab.held.endswith(" N")
    assert not lab.leads_value
    assert lab.dry_friction == 0.0
    time = 0.002 * np.arange(200)
    found = lab.simulated(np.full(200, 3.0))
    np.testing.assert_allclose(found[1], 1.5 * (1 - np.exp(-2 * time)), atol=0.01)
    np.testing.assert_allclose(found[0], 1.5 * time - 0.75 * (1 - np.exp(-2 * time)), atol=0.01)
    poles = lab.step_poles()
    assert np.abs(poles + 2.0).min() < 0.01
    assert lab.simulated(np.full(200, 3.0), bound=0.1).shape[1] < 200
    assert world.plants[0].name == "p"
    assert scene("input: s.position, outputs: [s]")[1].leads_value


def test_robots_have_motors_a_pitch_a_heading_and_a_way():
    world = mjsim.parse_world("mjsim: 1\nrobots: [{name: r, at: [1, 2]}]\n")
    from mjsim.compile import compile_world

    model = compile_world(world).compile()
    qpos = np.array(model.qpos0)
    free = int(model.joint("r/free").qposadr[0])
    yaw, pitch = 0.7, -0.2
    quaternion = np.zeros(4)
    turn, lean = (
        np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]),
        np.array([math.cos(pitch / 2), 0, math.sin(pitch / 2), 0]),
    )
    mujoco.mju_mulQuat(quaternion, turn, lean)
    qpos[free : free + 7] = [1.5, 2.0, 0.1, *quaternion]
    part = part_of(model, world, "r", qpos)
    told = {name: (unit, measure(qpos)) for name, (unit, measure) in part.measures.items()}
    assert told["lean"] == ("rad", pytest.approx(pitch))
    assert told["heading"] == ("rad", pytest.approx(yaw))
    assert told["way"] == ("m", pytest.approx(1.5))
    drive = world.robots[0].drive
    r, half = drive.wheel_radius, drive.track / 2
    left, right = (model.actuator(f"r/wheel_{side}").id for side in ("left", "right"))
    forward, spin = part.effects["forward"], part.effects["turn"]
    assert (forward.ctrl[left], forward.ctrl[right]) == pytest.approx((1 / r, 1 / r))
    assert (spin.ctrl[left], spin.ctrl[right]) == pytest.approx((-half / r, half / r))
    assert (forward.unit, spin.unit, part.effects["wheel_left"].unit) == ("m/s", "rad/s", "rad/s")
    assert part.effects["wheel_left"].ctrl[left] == 1.0
    dof = int(model.joint("r/free").dofadr[0])
    assert part.prefer == (dof, dof + 5, dof + 4)
    with pytest.raises(UsageError, match="no robot, arm or mechanism 'q'"):
        part_of(model, world, "q", qpos)
    plant = Plant.model_construct(name="p", of="r", around={"wheel_left": 1.0})
    with pytest.raises(UsageError, match="joint wheel_left turns; write wheel_left_deg"):
        working_point(model, part, plant)
    right_one = Plant.model_construct(name="p", of="r", around={"wheel_left_deg": 90.0})
    assert list(working_point(model, part, right_one).values()) == [pytest.approx(math.pi / 2)]
    wrong = Plant.model_construct(name="p", of="r", around={"wheel_lft_deg": 1.0})
    with pytest.raises(UsageError, match="around has 'wheel_lft_deg'"):
        working_point(model, part, wrong)


def test_plants_are_found_by_name():
    assert plants_of(WORLD, None) == [THIRD, DOUBLE]
    assert plants_of(WORLD, "double") == [DOUBLE]
    with pytest.raises(UsageError, match="has no plants"):
        plants_of(mjsim.parse_world("mjsim: 1\n"), None)
    with pytest.raises(UsageError, match="plant 'third' is a formula"):
        experiment(WORLD, THIRD, recording=SimpleNamespace())
    found = experiment(WORLD, DOUBLE)
    assert (found.labels, found.name, found.amplitude, found.study.is_stable) == (["y1", "y2"], "double", 1.0, False)
    assert experiment(WORLD, THIRD).study.is_stable
    assert float(np.real(control.ss(*(getattr(found.study.plant, key) for key in "ABCD")).poles()).max()) == 0.0


def test_a_scene_is_linearised_simulated_and_identified():
    keys = "input: s.force, outputs: [s.rate], amplitude: 2, seconds: 1.5"
    world = mjsim.parse_world(MECHANISM.replace("PLANT", f"{{name: p, of: m, {keys}}}"))
    found = experiment(world, world.plants[0])
    assert found.labels == ["s.rate [m/s]"]
    assert found.about.startswith("m, from s.force to s.rate; ")
    time, step = found.nonlinear
    np.testing.assert_allclose(step[0], 1.0 - np.exp(-2.0 * time), atol=0.01)
    assert time[-1] == pytest.approx(found.study.time[-1], abs=0.004)
    assert found.nonlinear_fit[0] > 98.0
    time, impulse = found.nonlinear_impulse
    np.testing.assert_allclose(impulse[0][2:], 2.0 * np.exp(-2.0 * time[2:]), atol=0.02)
    assert (found.rough, found.dry_friction) == (None, 0.0)
    assert np.abs(found.step_poles - found.study.poles).max() < 0.01
    assert found.study.poles.real.max() == pytest.approx(-2.0, abs=1e-6) or found.study.poles.real.max() > -1e-6


def test_a_turned_base_is_identified_as_one_that_heads_along_x():
    from mjsim.lab.recorded_plant import _turn_back

    half = 0.35
    poses = np.array([[1.0, 2.0, 0.1, math.cos(half), 0.0, 0.0, math.sin(half)]] * 2)
    poses[1, :2] += 0.5 * np.array([math.cos(0.7), math.sin(0.7)])
    speeds = np.array([[math.cos(0.7), math.sin(0.7), 0.2]] * 2)
    _turn_back(poses, speeds)
    np.testing.assert_allclose(poses[:, :3], [[0.0, 0.0, 0.1], [0.5, 0.0, 0.1]], atol=1e-12)
    np.testing.assert_allclose(poses[:, 3:], [[1.0, 0.0, 0.0, 0.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(speeds, [[1.0, 0.0, 0.2]] * 2, atol=1e-12)


def test_a_design_is_tried_on_the_scene_with_the_amplitude_of_the_plant():
    _, lab = scene("input: s.force, outputs: [s], amplitude: 3")
    design = lqr_design(lab.linear, [4.0, 1.0, 1.0, 1.0][: len(lab.linear.states)], 1.0)
    told = closed_loop(lab, design)
    assert told.fit is not None
    assert told.fit[0] > 97.0
    assert told.step[0, -1] == pytest.approx(3.0 * np.interp(told.time[-1], design.time, design.step[0]), rel=0.03)
