"""Input and outputs of a plant in a recording, tick by tick."""

import math

import mujoco
import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array, headings
from mjsim.interface import Command
from mjsim.lab.effects import BodyPush, ForceEffect, LedJoint, PointsPush
from mjsim.lab.identify import Samples
from mjsim.lab.plant_scene import ScenePlant
from mjsim.record import JointTrack, Recording
from mjsim.sim import gear_of
from mjsim.world import Robot

CONTROL_RATE = 250.0
"""Rate of the controllers shipped with mjsim [Hz]."""


def recorded(recording: Recording, scene: ScenePlant) -> Samples:
    """Return the input during each tick, and the outputs at its start.

    Outputs are measured in the recorded states. The input of a base with servos is the servo command, which its
    velocity profile derives from the commands; the input of joints is the recorded torque or motion.

    Raises:
        UsageError: The recording is of another world, or does not contain the input.
    """
    of = str(scene.plant.of)
    robot = next((each for each in recording.world.robots if each.name == of.partition("/")[0]), None)
    if robot is None and of not in recording.joints:
        raise UsageError(f"the recording has no '{of}'")
    if recording.qpos.shape[1:] != (scene.model.nq,) or recording.qvel.shape[1:] != (scene.model.nv,):
        raise UsageError("the recording is of a scene with other joints; record this world, then identify the plant")
    inputs, held = _inputs(recording, scene, robot)
    outputs = _outputs(recording, scene, robot)
    known = np.isfinite(inputs) & np.isfinite(outputs).all(axis=0)
    return Samples(
        time=recording.time[known],
        inputs=inputs[known],
        outputs=outputs[:, known],
        source="the recording",
        held=held,
    )


def _inputs(recording: Recording, scene: ScenePlant, robot: Robot | None) -> tuple[Array, bool]:
    """Return the input of each tick, shape (N,), and whether it is held until the next."""
    effect, of = scene.effect, str(scene.plant.of)
    if isinstance(effect, BodyPush | PointsPush):
        raise UsageError(f"recordings do not contain {scene.plant.input} of {of}; use a joint's force as input")
    if robot is not None and "/" not in of:
        assert isinstance(effect, ForceEffect)
        controls = _motors(recording, scene.model, robot)
        return controls @ effect.ctrl / float(effect.ctrl @ effect.ctrl), True
    track = recording.joints[of]
    column = _column(track, scene)
    if isinstance(effect, LedJoint):
        values = (track.velocities if effect.is_speed else track.positions)[:, column]
        return values - values[0], False
    if robot is not None:
        _check_rate(recording, robot.name, of.partition("/")[2])
        return _next(track.torques[:, column]), True
    return track.torques[:, column], False


def _column(track: JointTrack, scene: ScenePlant) -> int:
    """Return the index of the recorded joint on which the input acts."""
    force = scene.effect.force if isinstance(scene.effect, LedJoint) else scene.effect
    assert isinstance(force, ForceEffect)
    dof = int(np.argmax(force.applied))
    name = scene.model.joint(int(scene.model.dof_jntid[dof])).name.removeprefix(f"{scene.plant.of}/")
    return track.names.index(name)


def _motors(recording: Recording, model: mujoco.MjModel, robot: Robot) -> Array:
    """Return the commands of all motors of a base during each tick, shape (N, nu)."""
    controls = np.zeros((len(recording.time), model.nu))
    world, dt = recording.world, 1.0 / recording.world.run.rate_hz
    gear = gear_of(robot, dt=dt, seed=recording.seed, source=world.source, clock=lambda: 0.0)
    names = [model.actuator(f"{robot.name}/{part}").id for part in (*gear.wheels, *gear.steering)]
    if gear.wanted is not None:
        _check_rate(recording, robot.name, "drive")
        controls[:, names] = _next(recording.joints[f"{robot.name}/drive"].torques)
        return controls
    commands = recording.robots[robot.name].command
    if not np.isfinite(commands).all():
        controls[:] = np.nan
        return controls
    for row, (forward, left, turn) in zip(controls, commands.tolist(), strict=True):
        gear.profile.command(Command(forward, left, turn))
        row[names] = gear.profile.advance()
    return controls


def _next(torques: Array) -> Array:
    """Return torques recorded at the end of their tick moved to its start, NaN for the last."""
    return np.concatenate([torques[1:], np.full_like(torques[:1], np.nan)])


def _check_rate(recording: Recording, robot: str, part: str) -> None:
    """Check that a controller updates its torque once per tick, as often as it is recorded.

    Raises:
        UsageError: It updates more often.
    """
    run = recording.world.run
    loop = run.drivers[robot].controllers.get(part) if robot in run.drivers else None
    rate = CONTROL_RATE if loop is None else loop.rate_hz
    if rate > run.rate_hz:
        raise UsageError(
            f"the recording has the torque of {robot}/{part} at {run.rate_hz:g} Hz, but its controller"
            f" runs at {rate:g} Hz; record with --set run.rate_hz={rate:g}"
        )


def _outputs(recording: Recording, scene: ScenePlant, robot: Robot | None) -> Array:
    """Return the measured values in each recorded state, shape (outputs, N)."""
    qpos, qvel = recording.qpos.copy(), recording.qvel.copy()
    if robot is not None and robot.base != "fixed":
        free = scene.model.joint(f"{robot.name}/free")
        _turn_back(qpos[:, int(free.qposadr[0]) :][:, :7], qvel[:, int(free.dofadr[0]) :][:, :3])
    found = np.array([scene.outputs(*state) for state in zip(qpos, qvel, strict=True)]).T
    turns = [name == "heading" for name in scene.plant.outputs or ()]
    found[turns] = np.unwrap(found[turns], axis=1)
    return found


def _turn_back(poses: Array, speeds: Array) -> None:
    """Transform the poses of a base in place, so that it starts at the origin and heads along x.

    Args:
        poses: Position and quaternion (w, x, y, z), world frame, shape (N, 7) [m].
        speeds: Velocities, world frame, shape (N, 3) [m/s].
    """
    heading = float(headings(np.roll(poses[0, 3:], -1)))
    c, s = math.cos(heading), math.sin(heading)
    back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    poses[:, :2] -= poses[0, :2].copy()
    poses[:, :3], speeds[:] = poses[:, :3] @ back.T, speeds @ back.T
    turn, found = np.array([math.cos(heading / 2), 0.0, 0.0, -math.sin(heading / 2)]), np.zeros(4)
    for row in poses:
        mujoco.mju_mulQuat(found, turn, row[3:])
        row[3:] = found
