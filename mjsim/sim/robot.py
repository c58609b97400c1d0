"""A robot in a simulation: its drive, wheels, sensors and contacts."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import (
    Command,
    Controller,
    ControlLoop,
    JointGoal,
    Message,
    Observation,
    Odometry,
    RobotInfo,
    WheelCommand,
)
from mjsim.mechanics import JointMotion
from mjsim.sentences import Sentence
from mjsim.sim.actuation import Actuation, ServoActuation
from mjsim.sim.bases import RunningGear, balancing_info, gear_of
from mjsim.sim.bumper import Bumper
from mjsim.sim.controls import Controls
from mjsim.sim.odometry import NO_MOTION
from mjsim.sim.rays import ProximityRing
from mjsim.sim.rendering import Canvas, Quality
from mjsim.sim.sensors import MAKERS, Mounting, Sensors
from mjsim.sim.streams import cached, streams_of
from mjsim.world import AnySensor, BalancingDrive, Robot, World, name_of

if TYPE_CHECKING:
    from mjsim.sim.arm_motion import ArmAtWork


class SimulatedRobot:
    """A robot in a running simulation: takes commands and gives observations."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        robot: Robot,
        *,
        world: World,
        seed: int,
        canvas: Callable[[Quality], Canvas],
        received: Callable[[int], tuple[Message, ...]],
    ) -> None:
        """Initialise at the start.

        Args:
            model: The compiled world.
            data: Its state, shared by all robots.
            robot: Robot of the world file.
            world: World that states the rates of the loop.
            seed: Seed of the run.
            canvas: Gives the canvas of cameras of a quality.
            received: Gives the messages received by radio until a tick.
        """
        self._robot, self._model, self._data, self._received = robot, model, data, received
        self._dt = world.run.steps_per_tick * model.opt.timestep
        self._gear = gear = gear_of(robot, dt=self._dt, seed=seed, source=world.source, clock=lambda: float(data.time))
        self._hinges, self._dofs, motors = _turned(model, robot, gear)
        servos = motors if gear.wanted is None else []
        self.actuations: list[Actuation] = [ServoActuation(data, gear, servos, every=world.run.steps_per_tick)]
        """The actuation of its motors, beside controllers."""
        self._pose = _pose_of(model, data, robot)
        self.bumper = Bumper(model, data, robot, world)
        self._ring = ProximityRing(model, data, robot, sought=_geoms_of_people(model, world))

        def mounting(sensor: AnySensor) -> Mounting:
            return Mounting(
                model=model,
                data=data,
                robot=robot,
                gear=gear,
                beacons=world.beacons,
                streams=cached(streams_of(seed, robot.name, name_of(sensor))),
                canvas=canvas,
            )

        self._sensors = Sensors(robot, makers=MAKERS, mounting=mounting, rate_hz=world.run.rate_hz)
        self.after_step = self._sensors.after_step
        """Functions to call after each step of the physics."""
        self._arms = _arms_at_work(model, data, robot, tick=self._dt)
        arms, imus = [*self._arms.values()], self._sensors.imus
        self._controls = Controls(model, data, robot, gear=gear, arms=arms, imus=imus, world=world, seed=seed)
        self._angles = data.qpos[self._hinges]
        self._pitch = self.truth().pitch() if gear.wanted is not None else 0.0
        self._odometry = gear.odometer.at_rest()
        self._seen: Observation | None = None
        self._identities: tuple[str | None, ...] = ()
        self.info = self._describe()

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next.

        Raises:
            UsageError: The command is of the wrong kind for this robot, or not finite.
        """
        try:
            numbers = (
                command.speeds if isinstance(command, WheelCommand) else (command.forward, command.left, command.turn)
            )
            finite = all(map(math.isfinite, numbers))
        except (AttributeError, TypeError):
            raise UsageError(
                Sentence(
                    "{command!r} is not a command for robot '{name}'; give a Command of numbers",
                    command,
                    self._robot.name,
                )
            ) from None
        if not finite:
            raise UsageError(
                Sentence(
                    "the command for robot '{name}' is {command}; its numbers must be finite", self._robot.name, command
                )
            )
        wheels = self._gear.wheels
        if isinstance(command, WheelCommand) and len(numbers) != len(wheels):
            raise UsageError(
                Sentence(
                    "{count} wheel speeds for robot '{name}'; its wheels are {wheels}",
                    len(numbers),
                    self._robot.name,
                    ", ".join(wheels),
                )
            )
        if isinstance(command, Command) and command.joints:
            self._move_arms(command.joints)
        self._gear.profile.command(command)

    def _move_arms(self, goals: Mapping[str, JointGoal]) -> None:
        for name, goal in goals.items():
            self.arm(name).command(goal)

    def arm(self, name: str) -> "ArmAtWork":
        """Return an arm; raises UsageError if there is none of that name."""
        if name not in self._arms:
            raise UsageError(
                Sentence(
                    "robot '{name}' has no arm '{other_name}'{did_you_mean}",
                    self._robot.name,
                    name,
                    did_you_mean(name, self._arms),
                )
            )
        return self._arms[name]

    def motions(self) -> dict[str, JointMotion]:
        """Return the motion of each arm by name, and of 'drive', the wheels of a balancing base."""
        arms = {name: arm.motion() for name, arm in self._arms.items()}
        return arms if self._gear.goal is None else {"drive": self._wheel_motion(self._gear.goal()), **arms}

    def _wheel_motion(self, goal: Sequence[float]) -> JointMotion:
        """Return the motion of the driven wheels relative to the body, with their rotations by set-points as goals."""
        data, dofs = self._data, self._dofs
        return JointMotion(
            names=self._gear.wheels,
            positions=data.qpos[self._hinges],
            velocities=data.qvel[dofs],
            accelerations=data.qacc[dofs],
            torques=data.qfrc_actuator[dofs],
            goal=np.array(goal),
        )

    def acting(self) -> list[Actuation]:
        """Return the actuation of its motors, controllers last; default controllers are created now."""
        return [*self.actuations, *self._controls.actuations(self.info)]

    def control(self, controllers: Mapping[str, Controller | ControlLoop]) -> None:
        """Set the controllers of parts of the robot from now on.

        Raises:
            UsageError: The part does not exist, or a rate is invalid.
            ModuleFault: A controller lacks a method, or raises when it starts.
        """
        self._controls.install(controllers, self.info)

    def control_times(self) -> dict[str, float]:
        """Return the wall-clock time inside each controller since the last call, by part [s]."""
        return self._controls.times()

    def retune(self, robot: Robot) -> None:
        """Use this noise from now on; `robot` must differ only in noise."""
        self._robot = robot
        self._gear.profile.retune(robot.drive.noise)
        self._gear.odometer.retune(robot.odometry)
        self._sensors.retune(robot)

    def before_step(self, tick: int) -> None:
        """Skip readings that are due at a tick and were not requested, and move arms that events control."""
        for arm in self._arms.values():
            arm.before_step()
        if self._seen is None:
            self._sensors.unasked(tick, tick * self._dt)

    def after_tick(self, tick: int) -> None:
        """Read the wheels, so that results do not depend on when they are requested; `tick` is the next one."""
        self._controls.feel(tick * self._dt)
        angles, before = self._data.qpos[self._hinges], self._angles
        turned, count = (angles - before).tolist(), len(self._gear.wheels)
        steering = (float(before[count]), float(angles[count])) if len(angles) > count else NO_MOTION
        self._angles = angles
        pitched = self._pitched() if self._gear.wanted is not None else 0.0
        self._odometry = self._gear.odometer.increment(turned[:count], steering, pitched=pitched)
        self._seen = None

    def _pitched(self) -> float:
        """Return the forward pitch of a balancing base since the last tick [rad]."""
        before, self._pitch = self._pitch, self.truth().pitch()
        return math.remainder(self._pitch - before, math.tau)

    def sense(self, tick: int) -> Observation:
        """Return the observation at a tick; the same if called again."""
        if self._seen is None:
            time = tick * self._dt
            sensed = self._sensors.at(tick, time)
            self._identities = sensed.identities
            self._seen = Observation(
                time=time,
                dt=self._dt,
                odometry=self._odometry,
                proximity=self._ring.ranges(),
                bump=self.bumper.bearings(),
                messages=self._received(tick),
                joints={name: arm.read(time) for name, arm in self._arms.items()},
                **sensed.fields(),
            )
        return self._seen

    @property
    def odometry(self) -> Odometry:
        """The increment of the last tick."""
        return self._odometry

    def identities(self, tick: int) -> tuple[str | None, ...]:
        """Return the true beacon of each sighting of the sensors at a tick, None for a false sighting."""
        self.sense(tick)
        return self._identities

    def truth(self) -> Pose3:
        """Return the true pose of the base, world frame."""
        x, y, z, qw, qx, qy, qz = self._pose.tolist()
        return Pose3(x, y, z, qx, qy, qz, qw)

    def _describe(self) -> RobotInfo:
        robot, drive = self._robot, self._robot.drive
        return RobotInfo(
            name=robot.name,
            drive=drive.type,
            max_speed=drive.max_speed,
            max_turn=math.radians(drive.max_turn_deg),
            max_acceleration=drive.max_acceleration,
            max_turn_acceleration=drive.turn_acceleration,
            max_left=drive.sideways,
            max_curvature=drive.max_curvature,
            wheels=self._gear.wheels,
            wheel_radius=drive.driven_radius,
            track=drive.turning_track,
            radius=robot.body.radius,
            twist_from_wheels=self._gear.twist_from_wheels(),
            outline=robot.body.outline(),
            dt=self._dt,
            prior=Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg)),
            prior_covariance=np.zeros((3, 3)),
            sensors=self._sensors.info,
            arms={name: arm.info for name, arm in self._arms.items()},
            balancing=balancing_info(self._model, robot) if isinstance(drive, BalancingDrive) else None,
        )


def _geoms_of_people(model: mujoco.MjModel, world: World) -> list[int]:
    """Return the geoms of all people."""
    roots = [model.body(f"{person.name}/pelvis").id for person in world.people]
    found: list[int] = np.flatnonzero(np.isin(model.body_rootid[model.geom_bodyid], roots)).tolist()
    return found


def _pose_of(model: mujoco.MjModel, data: mujoco.MjData, robot: Robot) -> Array:
    """Return a view of the position and the quaternion of a base, shape (7,)."""
    if robot.base == "fixed":
        body = model.body(f"{robot.name}/base")
        return np.concatenate([body.pos, body.quat])
    start = int(model.joint(f"{robot.name}/free").qposadr[0])
    following: Array = data.qpos[start : start + 7]
    return following


def _turned(
    model: mujoco.MjModel, robot: Robot, gear: RunningGear
) -> tuple[NDArray[np.intp], NDArray[np.intp], list[int]]:
    """Return the indices of wheels and steered joints in `qpos` and `qvel`, and their motors.

    Raises:
        UsageError: The robot's file lacks a joint that its drive names.
    """
    names = [f"{robot.name}/{part}" for part in (*gear.wheels, *gear.steering)]
    try:
        hinges = [model.joint(name) for name in names]
        motors = [int(model.actuator(name).id) for name in names]
    except KeyError as error:
        raise UsageError(
            Sentence(
                "robot '{name}' lacks a hinge or a servo for a wheel of its drive: {reason}",
                robot.name,
                str(error).split(".")[0],
            )
        ) from None
    places, speeds = ([getattr(hinge, key)[0] for hinge in hinges] for key in ("qposadr", "dofadr"))
    return np.array(places, dtype=np.intp), np.array(speeds, dtype=np.intp), motors


def _arms_at_work(model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, *, tick: float) -> dict[str, "ArmAtWork"]:
    """Return the arms of a robot by name; a robot without arms loads no module of arms."""
    if not robot.arms:
        return {}
    from mjsim.sim.arm_motion import ArmAtWork

    return {item.name: ArmAtWork(model, data, robot, item, tick=tick) for item in robot.arms}
