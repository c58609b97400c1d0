"""Wheel slip, estimated from simulated drives at changing speeds and turns.

Wheels with rollers slip until their rollers spin, so they slip less while the robot moves in all directions at once
than on the spot. Their sideways and turning slip is therefore the mean over drives of all kinds.

A skid-steered robot turns by letting all its tyres slip; how much depends on its centre of mass, wheelbase and track.
Three things are estimated: its centre of rotation, its true turn per radian of wheel odometry on arcs of all kinds, and
the covariance of its odometry.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mjsim.exchange.robots.likely import likely_slip
from mjsim.geometry import Array, wrap_angles
from mjsim.guarded import still_working
from mjsim.interface import Command, Odometry, RobotInfo
from mjsim.sim import Simulation, arc_end
from mjsim.world import OdometryNoise, Robot, Slip, Source, WheelOdometry, World, parse_world

DRIVE_COUNT, ROBOTS_AT_ONCE = 80, 5
"""Number of drives, and number of robots simulated at a time."""
ON_ROLLERS = 5
"""Number of drives of robots on rollers, whose slip hardly varies."""
MANY_JOINTS, FEWER = 30, 24
"""Robots with at least this many joints are slow to simulate: they make fewer drives, one at a time."""
TICKS_PER_DRIVE, TICKS_PER_COMMAND = 500, 50
"""Ticks per drive, and ticks for which a command is held."""
COMPARED_TICKS = 125
"""Ticks over which distances are compared, long enough for the lag after a change of command to be negligible."""
SETTLING_TICKS = 15
"""Ticks until a robot follows a command steadily."""
ROBOT_SPACING = 50.0
"""Distance between robots [m]."""
SEED = 4711


@dataclass(frozen=True, slots=True, eq=False)
class Drives:
    """Odometry and ground truth of the drives of some robots."""

    odometry: Array
    """Measured distances along the arc and to the left [m] and turns [rad] of all ticks, shape (robots, ticks, 3)."""
    poses: Array
    """True poses at all ticks including the start, world frame, shape (robots, ticks + 1, 3) [m, m, rad]."""
    dt: float
    """Period of a tick [s]."""

    def about(self, x: float) -> "Drives":
        """Return the drives of the point `x` ahead of each robot's origin [m]."""
        headings = self.poses[..., 2]
        offset = np.stack([np.cos(headings), np.sin(headings), np.zeros_like(headings)], axis=-1)
        return replace(self, poses=self.poses + x * offset)

    def scaled(self, turn: float) -> "Drives":
        """Return the drives with measured turns multiplied by `turn`."""
        return replace(self, odometry=self.odometry * [1.0, 1.0, turn])


@dataclass(frozen=True, slots=True)
class Learned:
    """Slip estimated from the drives of a robot."""

    drives: int
    center: float
    """Distance of the centre of rotation ahead of its origin [m]."""
    turn: float
    """True turn per radian of wheel odometry."""
    slip: Slip


def learned(text: str, files: Mapping[str, bytes], *, file: str) -> Learned:
    """Return what drives of a robot with noise-free odometry show.

    Args:
        text: Text of a world with only this robot.
        files: Files that the world refers to, by name.
        file: Name of the manufacturer's file, for messages.
    """
    world = parse_world(text, source=Source(file=file, attached=files))
    with Simulation(world) as sim:
        slow = sim.model.njnt > MANY_JOINTS
    together = 1 if slow else ROBOTS_AT_ONCE
    lots = [_driven(_lot(world, together), first) for first in range(0, FEWER if slow else DRIVE_COUNT, together)]
    odometry, poses = (
        np.concatenate(parts) for parts in zip(*((lot.odometry, lot.poses) for lot in lots), strict=True)
    )
    drives = Drives(odometry, poses, lots[0].dt)
    turn, center = _turn(drives), _center(drives)
    drives = drives.about(center).scaled(turn)
    return Learned(len(odometry), center, turn, likely_slip(drives.odometry, drives.poses, dt=drives.dt))


def rolled(text: str, files: Mapping[str, bytes], *, file: str) -> tuple[float, float]:
    """Return the true sideways distance and the true turn of a robot on rollers, per unit of wheel odometry.

    Args:
        text: Text of a world with only this robot.
        files: Files that the world refers to, by name.
        file: Name of the manufacturer's file, for messages.
    """
    world = _lot(parse_world(text, source=Source(file=file, attached=files)), ROBOTS_AT_ONCE)
    lots = [_driven(world, first) for first in range(0, ON_ROLLERS, ROBOTS_AT_ONCE)]
    odometry, driven = (
        np.concatenate(parts) for parts in zip(*((lot.odometry, _displacements(lot)) for lot in lots), strict=True)
    )
    odometry, driven = (
        displacements.reshape(-1, COMPARED_TICKS, 3).sum(axis=1) for displacements in (odometry, driven)
    )
    _, strafe, spin = (np.sum(odometry * driven, axis=0) / np.sum(odometry * odometry, axis=0)).tolist()
    return strafe, spin


def _lot(world: World, together: int) -> World:
    """Return a world of several robots far from each other, with noise-free encoders.

    Their motors are noisy, as the preset states: tyres slip most while speeds change.
    """
    (robot,) = world.robots
    odometry = {"sensors": (), "odometry": WheelOdometry(noise=OdometryNoise())}
    robots: list[Robot] = [
        robot.model_copy(update={**odometry, "name": f"robot{k}", "at": (ROBOT_SPACING * k, 0.0)})
        for k in range(together)
    ]
    run = world.run.model_copy(update={"drivers": {}})
    return world.model_copy(update={"robots": tuple(robots), "run": run})


def _driven(world: World, first: int) -> Drives:
    """Return drives of several robots with changing commands; `first` is the number of the first robot."""
    still_working()
    with Simulation(world, seed=SEED + first) as sim:
        chances = {name: np.random.default_rng([SEED, first + k]) for k, name in enumerate(sim.robots)}
        odometry, poses = [], [[pose.as_array() for pose in sim.truths().values()]]
        for tick in range(TICKS_PER_DRIVE):
            if tick % TICKS_PER_COMMAND == 0:
                for name, rng in chances.items():
                    sim.apply(name, _some_command(sim.robots[name], rng))
            sim.step()
            odometry.append([_along_the_arc(sim.odometry(name)) for name in chances])
            poses.append([pose.as_array() for pose in sim.truths().values()])
        return Drives(np.swapaxes(np.array(odometry), 0, 1), np.swapaxes(np.array(poses), 0, 1), sim.dt)


def _some_command(robot: RobotInfo, rng: np.random.Generator) -> Command:
    speed, turn = min(0.7 * robot.max_speed, 1.0), min(0.6 * robot.max_turn, 1.0)
    command = Command(rng.uniform(0.0, speed), turn=rng.uniform(-turn, turn))
    lateral = 0.5 * robot.max_left
    return replace(command, left=rng.uniform(-lateral, lateral)) if lateral else command


def _along_the_arc(odometry: Odometry) -> tuple[float, float, float]:
    """Return distances along the arc and to the left [m] and the turn [rad] of a noise-free increment."""
    arc = complex(odometry.forward, odometry.left) / complex(*arc_end(1.0, odometry.turn))
    return arc.real, arc.imag, odometry.turn


def _turn(drives: Drives) -> float:
    """Return the true turn per radian of wheel odometry, by least squares over all commands."""
    odometry = drives.odometry[..., 2].reshape(len(drives.odometry), -1, TICKS_PER_COMMAND).sum(axis=-1)
    was = drives.poses[:, TICKS_PER_COMMAND::TICKS_PER_COMMAND, 2] - drives.poses[:, :-1:TICKS_PER_COMMAND, 2]
    # Wheel odometry is wrong by far less than half a turn of the robot.
    driven = odometry + wrap_angles(was - odometry)
    return float(np.sum(odometry * driven) / np.sum(odometry * odometry))


def _center(drives: Drives) -> float:
    """Return the distance ahead of the origin of the point that does not move sideways in turns on the spot [m].

    A point at x moves sideways by -x times the turn rate, and outward in proportion to speed times turn rate (creep of
    tyres); both are fitted to the motion at steady commands.

    References:
        Mandow et al., Experimental Kinematics for Wheeled Skid-Steer Mobile Robots, IROS 2007: the centre of rotation.
    """
    _, lateral, turn = np.moveaxis(_displacements(drives), -1, 0)
    steady = np.arange(lateral.shape[1]) % TICKS_PER_COMMAND >= SETTLING_TICKS

    def sums(values: Array) -> Array:
        return np.asarray(
            values[:, steady].reshape(len(values), -1, TICKS_PER_COMMAND - SETTLING_TICKS).sum(axis=-1).ravel()
        )

    accelerations = (
        sums(drives.odometry[..., 0])
        * sums(drives.odometry[..., 2])
        / ((TICKS_PER_COMMAND - SETTLING_TICKS) * drives.dt)
    )
    found = np.linalg.lstsq(np.column_stack([sums(turn), accelerations]), sums(lateral), rcond=None)[0]
    return float(-found[0])


def _displacements(drives: Drives) -> Array:
    """Return true distances forward and to the left [m] and turns [rad] of each tick, shape (robots, ticks, 3)."""
    step = np.diff(drives.poses, axis=1)
    turn = wrap_angles(step[..., 2])
    half = drives.poses[:, :-1, 2] + turn / 2
    c, s = np.cos(half), np.sin(half)
    return np.stack([c * step[..., 0] + s * step[..., 1], c * step[..., 1] - s * step[..., 0], turn], axis=-1)
