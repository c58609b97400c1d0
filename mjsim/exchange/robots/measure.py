"""Measures a robot in simulation: one metre straight, one sideways, and a turn on the spot, each in both directions."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from mjsim.errors import UsageError
from mjsim.geometry import Pose
from mjsim.guarded import still_working
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.world import OdometryNoise, Source, WheelOdometry, parse_world

SETTLING_SECONDS = 1.0
"""Pause before and after a drive [s]."""
TILT = math.radians(12.0)
"""A robot that leans more has fallen over [rad]."""
DRIVE_LENGTH = 1.0
"""Length of a drive [m]."""
SPEED_RATIO, CURVATURE_RATIO = 0.5, 0.7
"""Fractions of the maximum speed and of the maximum curvature."""
MAX_TIME = 120.0
"""Time limit of a drive [s]."""


@dataclass(frozen=True, slots=True)
class MeasuredDrive:
    """Odometry and ground truth of one drive."""

    odometry: float
    driven: float

    @property
    def ratio(self) -> float:
        """Ratio of the true to the measured distance or turn."""
        return self.driven / self.odometry if abs(self.odometry) > 1e-9 else 0.0


@dataclass(frozen=True, slots=True)
class Measured:
    """Four drives of one robot, and two sideways if it can move sideways."""

    ahead: MeasuredDrive
    back: MeasuredDrive
    left: MeasuredDrive
    right: MeasuredDrive
    on_spot: bool
    """Whether it turned on the spot; otherwise it drove circles."""
    sideways: tuple[MeasuredDrive, ...] = ()
    """Drives to the left and to the right."""

    @property
    def distance(self) -> float:
        """True distance per metre of odometry."""
        return (self.ahead.ratio + self.back.ratio) / 2

    @property
    def turn(self) -> float:
        """True turn per radian of odometry."""
        return (self.left.ratio + self.right.ratio) / 2

    @property
    def strafe(self) -> float:
        """True sideways distance per metre of odometry; 1 for a robot that cannot move sideways."""
        return sum(drive.ratio for drive in self.sideways) / len(self.sideways) if self.sideways else 1.0


def measure(text: str, files: Mapping[str, bytes], *, file: str) -> Measured:
    """Drive a robot on an empty floor, without noise.

    Args:
        text: Text of a world with only this robot.
        files: Files that the world refers to, by name.
        file: Name of the manufacturer's file, for messages.

    Raises:
        UsageError: The robot falls over, or does not drive.
        PhysicsFault: The simulation became unstable.
    """
    still_working()
    world = parse_world(text, source=Source(file=file, attached=files))
    (robot,) = world.robots
    quiet = robot.model_copy(
        update={
            "sensors": (),
            "drive": robot.drive.model_copy(update={"noise": type(robot.drive.noise)()}),
            "odometry": WheelOdometry(noise=OdometryNoise()),
        }
    )
    world = world.model_copy(update={"robots": (quiet,)})
    with Simulation(world, seed=1) as sim:
        pilot = _Pilot(sim, robot.name, file)
        pilot.settle()
        info = sim.robots[robot.name]
        speed, rate = SPEED_RATIO * info.max_speed, SPEED_RATIO * min(info.max_turn, 2.0)
        car = math.isfinite(info.max_curvature)
        ahead, back = (pilot.straight(sign * speed) for sign in (1.0, -1.0))
        if car:
            rate = CURVATURE_RATIO * info.max_curvature * speed
        left, right = (pilot.turning(speed if car else 0.0, sign * rate) for sign in (1.0, -1.0))
        sideways = [pilot.sideways(sign * SPEED_RATIO * info.max_left) for sign in (1.0, -1.0) if info.max_left]
    return Measured(ahead, back, left, right, not car, tuple(sideways))


class _Pilot:
    """Drives one robot and compares odometry with ground truth."""

    def __init__(self, sim: Simulation, robot: str, file: str) -> None:
        self._sim, self._robot, self._file = sim, robot, file
        self._odometry_pose = Pose(0.0, 0.0, 0.0)
        self._turned = self._odometry_turn = 0.0

    def settle(self) -> None:
        """Stand still, and check that the robot has not fallen over."""
        start = self._sim.truth(self._robot)
        self._go(Command(), SETTLING_SECONDS)
        pose = self._sim.pose(self._robot)
        lean = math.acos(max(-1.0, min(1.0, float(pose[2, 2]))))
        if lean > TILT:
            raise UsageError(
                f"{self._file}: the robot leans by {math.degrees(lean):.0f} degrees when it is put on its wheels; check"
                " the wheels that were found, or name them with --left-wheel and --right-wheel"
            )
        end = self._sim.truth(self._robot)
        if math.dist((start.x, start.y), (end.x, end.y)) > 0.05:
            raise UsageError(f"{self._file}: the robot does not stand still; a part of it pushes against the floor")

    def straight(self, speed: float) -> MeasuredDrive:
        """Drive one metre, and stop."""
        moved, odometry = self._moved(Command(speed), DRIVE_LENGTH / abs(speed))
        self._check("drives", moved.x, odometry.x, "m")
        return MeasuredDrive(odometry.x, moved.x)

    def sideways(self, speed: float) -> MeasuredDrive:
        """Drive one metre to the left or to the right, and stop."""
        moved, odometry = self._moved(Command(left=speed), DRIVE_LENGTH / abs(speed))
        self._check("drives sideways", moved.y, odometry.y, "m")
        return MeasuredDrive(odometry.y, moved.y)

    def _moved(self, command: Command, seconds: float) -> tuple[Pose, Pose]:
        """Return the true and the odometry displacement under a command, both relative to the start."""
        start, odometry = self._sim.truth(self._robot), self._odometry_pose
        self._go(command, seconds)
        self._go(Command(), SETTLING_SECONDS)
        return start.inverse() @ self._sim.truth(self._robot), odometry.inverse() @ self._odometry_pose

    def turning(self, speed: float, rate: float) -> MeasuredDrive:
        """Turn once around, and stop."""
        turned, odometry = self._turned, self._odometry_turn
        self._go(Command(speed, turn=rate), 2.0 * math.pi / abs(rate))
        self._go(Command(), SETTLING_SECONDS)
        self._check("turns", self._turned - turned, self._odometry_turn - odometry, "rad")
        return MeasuredDrive(self._odometry_turn - odometry, self._turned - turned)

    def _check(self, verb: str, moved: float, odometry: float, unit: str) -> None:
        if abs(odometry) < 0.05 or not 0.4 < moved / odometry < 2.0:
            raise UsageError(
                f"{self._file}: the robot {verb} {moved:.2f} {unit} while its wheels turn for {odometry:.2f} {unit};"
                " a part of it drags on the floor, or the wrong wheels were found"
            )

    def _go(self, command: Command, seconds: float) -> None:
        sim, robot = self._sim, self._robot
        sim.apply(robot, command)
        for _ in range(round(min(seconds, MAX_TIME) / sim.dt)):
            before = sim.truth(robot)
            sim.step()
            seen = sim.odometry(robot)
            self._odometry_pose = self._odometry_pose @ Pose(seen.forward, seen.left, seen.turn)
            self._odometry_turn += seen.turn
            self._turned += (before.inverse() @ sim.truth(robot)).heading
