"""One robot at work in a simulation: its drive, its wheels and its sensors."""

import math
from collections.abc import Callable

import mujoco
import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Pose
from mjsim.interface import Command, Message, Observation, RobotInfo, WheelCommand
from mjsim.sim.canvas import Canvas, Quality
from mjsim.sim.contact import Bumper
from mjsim.sim.gear import running_gear
from mjsim.sim.odometry import STRAIGHT
from mjsim.sim.proximity import ProximityRing
from mjsim.sim.sensors import Sensors
from mjsim.world.drives import UserDrive
from mjsim.world.model import World
from mjsim.world.robots import Robot


class SimulatedRobot:
    """Commands in, observations out; the simulation moves everything in between."""

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
        """Get ready, standing at the start.

        Args:
            model: The compiled world.
            data: Its state, shared by all robots.
            robot: As the world file has it.
            world: For the rates of the loop.
            seed: Of the run.
            canvas: Gives what cameras of a quality draw on.
            received: Gives what the radio has brought until a tick.
        """
        self._robot, self._data, self._received = robot, data, received
        self._dt = world.run.steps_per_tick * model.opt.timestep
        self._gear = gear = running_gear(robot, dt=self._dt, seed=seed, source=world.source)
        turned = [f"{robot.name}/{part}" for part in (*gear.wheels, *gear.steering)]
        try:
            self._hinges = np.array([model.joint(part).qposadr[0] for part in turned])
            self._servos = np.array([model.actuator(part).id for part in turned])
        except KeyError as error:
            raise UsageError(
                f"robot '{robot.name}' lacks a hinge or a servo of a wheel its drive names: {str(error).split('.')[0]}"
            ) from None
        self._free = slice(start := int(model.joint(f"{robot.name}/free").qposadr[0]), start + 7)
        self._ring = ProximityRing(model, data, robot)
        self._bumper = Bumper(model, data, robot)
        self._sensors = Sensors(
            model, data, robot, beacons=world.beacons, rate_hz=world.run.rate_hz, seed=seed, canvas=canvas
        )
        self._angles = data.qpos[self._hinges]
        self._odometry = gear.odometer.at_rest()
        self._seen: Observation | None = None
        self._identities: tuple[str | None, ...] = ()
        self.info = self._describe()

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next.

        Raises:
            UsageError: It is not a command for this robot, or not finite.
        """
        try:
            numbers = (
                command.speeds if isinstance(command, WheelCommand) else (command.forward, command.left, command.turn)
            )
            finite = all(map(math.isfinite, numbers))
        except (AttributeError, TypeError):
            raise UsageError(
                f"{command!r} is no command for robot '{self._robot.name}'; give a Command of numbers"
            ) from None
        if not finite:
            raise UsageError(f"the command for robot '{self._robot.name}' is {command}; its numbers must be finite")
        wheels = self._gear.wheels
        if isinstance(command, WheelCommand) and len(numbers) != len(wheels):
            raise UsageError(
                f"{len(numbers)} wheel speeds for robot '{self._robot.name}'; its wheels are {', '.join(wheels)}"
            )
        self._gear.drive.command(command)

    def retune(self, robot: Robot) -> None:
        """Err as far as said from now on; `robot` differs from what it was in noise alone."""
        self._robot = robot
        self._gear.drive.retune(robot.drive.noise)
        self._gear.odometer.retune(robot.odometry)
        self._sensors.retune(robot)

    def before_step(self, tick: int) -> None:
        """Tell the servos of the wheels what to reach in the step that ends a tick."""
        if self._seen is None:
            self._sensors.unasked(tick, tick * self._dt)
        self._data.ctrl[self._servos] = self._gear.drive.advance()

    @property
    def feels(self) -> bool:
        """Whether each step of the physics is to be told to `feel_step`."""
        return self._sensors.feels

    def feel_step(self) -> None:
        """Note what inertial sensors feel, after a step of the physics."""
        self._sensors.feel_step()

    def after_step(self) -> None:
        """Read the wheels, so that nothing depends on who looks when."""
        angles, before = self._data.qpos[self._hinges], self._angles
        turned, count = (angles - before).tolist(), len(self._gear.wheels)
        steering = (float(before[count]), float(angles[count])) if len(angles) > count else STRAIGHT
        self._angles = angles
        self._odometry = self._gear.odometer.increment(turned[:count], steering)
        self._seen = None

    def sense(self, tick: int) -> Observation:
        """Return all that the robot senses at a tick; the same when asked again."""
        if self._seen is None:
            time = tick * self._dt
            sensed = self._sensors.at(tick, time)
            self._identities = sensed.identities
            self._seen = Observation(
                time=time,
                dt=self._dt,
                odometry=self._odometry,
                sightings=sensed.sightings,
                cameras=sensed.cameras,
                scans=sensed.scans,
                imu=sensed.imu,
                proximity=self._ring.ranges(),
                bump=self._bumper.bearings(),
                messages=self._received(tick),
            )
        return self._seen

    def identities(self, tick: int) -> tuple[str | None, ...]:
        """Return which beacon each sighting of the sensors at a tick is of, None for one of nothing."""
        self.sense(tick)
        return self._identities

    def truth(self) -> Pose:
        """Return where the robot is, world frame."""
        x, y, _, qw, qx, qy, qz = self._data.qpos[self._free].tolist()
        # Heading of the x axis of the base, seen from above.
        return Pose(x, y, math.atan2(2.0 * (qx * qy + qw * qz), 1.0 - 2.0 * (qy * qy + qz * qz)))

    def _describe(self) -> RobotInfo:
        robot, drive = self._robot, self._robot.drive
        return RobotInfo(
            name=robot.name,
            drive=drive.type,
            max_speed=drive.max_speed,
            max_turn=math.radians(drive.max_turn_deg),
            max_acceleration=drive.max_acceleration,
            max_turn_acceleration=math.radians(drive.max_turn_acceleration_deg),
            max_left=self._gear.max_left,
            max_curvature=self._gear.max_curvature,
            wheels=self._gear.wheels,
            wheel_radius=0.0 if isinstance(drive, UserDrive) else drive.wheel_radius,
            track=self._gear.track,
            radius=robot.body.radius,
            twist_from_wheels=self._gear.twist_from_wheels(),
            outline=robot.body.outline(),
            dt=self._dt,
            prior=Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg)),
            prior_covariance=np.zeros((3, 3)),
            sensors=self._sensors.info,
        )
