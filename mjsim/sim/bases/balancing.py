"""Balancing bases: set-points for the controller that drives the motors of the two wheels."""

import math
from collections.abc import Sequence

import mujoco
from numpy.random import Generator

from mjsim.interface import BalancingInfo, Command, WheelCommand
from mjsim.sim.bases.differential import DifferentialKinematics
from mjsim.sim.bases.gear import Kinematics, RunningGear, motion_of, running_gear
from mjsim.sim.bases.profile import scaled, within
from mjsim.sim.streams import stream
from mjsim.world import BalancingDrive, DriveNoise, Robot


class SetPointProfile:
    """The set-points of a controller: a command within the limits of speed and acceleration of the drive.

    The noise is added to the set-points and constant over a tick, with standard deviation sigma / sqrt(dt), so that the
    motion drifts as on bases with servos.
    """

    def __init__(self, drive: BalancingDrive, *, kinematics: Kinematics, dt: float, stream: Generator) -> None:
        """Initialise, standing still.

        Args:
            drive: Limits and noise.
            kinematics: Kinematics of its wheels, for commands in wheel speeds.
            dt: Period of the loop [s].
            stream: Random stream; two numbers are drawn per tick.
        """
        self._kinematics, self._stream, self._root = kinematics, stream, math.sqrt(dt)
        self._limits = drive.max_speed, 0.0, math.radians(drive.max_turn_deg)
        self._rates = drive.max_acceleration, math.radians(drive.max_turn_acceleration_deg)
        self._target = self._now = self._noise_twist = 0.0, 0.0
        self._turned = [0.0] * len(kinematics.wheels_from_twist(0.0, 0.0, 0.0))
        self.retune(drive.noise)

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next."""
        if isinstance(command, WheelCommand):
            twist = self._kinematics.twist_from_wheels(command.speeds)
        else:
            twist = command.forward, 0.0, command.turn
        forward, _, turn = scaled((twist[0], 0.0, twist[2]), self._limits)
        self._target = forward, turn

    def retune(self, noise: DriveNoise) -> None:
        """Use this noise from now on."""
        self._noise = noise.speed / self._root, noise.turn / self._root

    def advance(self) -> Sequence[float]:
        """Draw the noise of the next tick; there are no servos."""
        speed, turn = self._stream.standard_normal(2).tolist()
        self._noise_twist = self._noise[0] * speed, self._noise[1] * turn
        return ()

    def wanted(self, dt: float) -> Command:
        """Return the set-points for the next time dt [s]."""
        forward, turn = self._now
        now = (
            forward + within(self._target[0] - forward, self._rates[0] * dt),
            turn + within(self._target[1] - turn, self._rates[1] * dt),
        )
        self._now = now
        speeds = self._kinematics.wheels_from_twist(forward, 0.0, turn)
        self._turned = [angle + speed * dt for angle, speed in zip(self._turned, speeds, strict=True)]
        return Command(forward + self._noise_twist[0], 0.0, turn + self._noise_twist[1])

    def goal(self) -> Sequence[float]:
        """Return the wheel rotations from all set-points so far, without noise [rad]."""
        return self._turned


def balancing_gear(robot: Robot, drive: BalancingDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a balancing base."""
    kinematics = DifferentialKinematics(drive.wheel_radius, drive.track)
    source = stream(seed, robot.name, "drive/twist")
    profile = SetPointProfile(drive, kinematics=kinematics, dt=dt, stream=source)
    motion, wanted, goal = motion_of(kinematics), profile.wanted, profile.goal
    return running_gear(robot, profile=profile, motion=motion, dt=dt, seed=seed, wanted=wanted, goal=goal)


def balancing_info(model: mujoco.MjModel, robot: Robot) -> BalancingInfo:
    """Return the compiled masses of a balancing base."""
    drive, base, wheel = robot.drive, model.body(f"{robot.name}/base"), model.body(f"{robot.name}/wheel_left")
    assert isinstance(drive, BalancingDrive)
    return BalancingInfo(
        wheel_mass=float(wheel.mass[0]),
        wheel_inertia=float(wheel.inertia[1]),
        wheel_across=float(wheel.inertia[2]),
        body_mass=float(base.mass[0]),
        center=float(base.ipos[2] - wheel.pos[2]),
        pitch_inertia=float(base.inertia[1]),
        yaw_inertia=float(base.inertia[2]),
        max_torque=drive.max_torque,
    )
