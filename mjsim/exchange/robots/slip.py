"""Wheel slip, estimated from simulated drives at changing speeds and turns.

Wheels with rollers slip until their rollers spin: less while the robot moves every way at once than on the spot. So
what they slip sideways and in turn is the mean over drives of all kinds.

A skid-steered robot turns by letting all its tyres slip, by how much depends on where its weight lies and on how long
and wide it stands. So three things are learned: about which point it turns, how far it turns of what its wheels tell on
arcs of all kinds, and what the covariance of its odometry must allow for.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mjsim.exchange.robots.likely import likely_slip
from mjsim.geometry import Array, wrap_angles
from mjsim.interface import Command, Odometry, RobotInfo
from mjsim.sim import Simulation, arc_end
from mjsim.world import OdometryNoise, Robot, Slip, Source, WheelOdometry, World, parse_world

ROBOTS, TOGETHER = 80, 5
"""Drives, and how many robots are simulated at a time."""
ON_ROLLERS = 5
"""Drives of robots on rollers, whose slip is the same every time."""
MANY_JOINTS, FEWER = 30, 24
"""Robots of so many joints take long to simulate: fewer drives of them, one at a time."""
TICKS, HELD = 500, 50
"""Of a drive; ticks for which a command holds."""
LONG = 125
"""Ticks over which ways are compared: so many that what lags behind a change of the command is little of it."""
STEADY = 15
"""Ticks after which a robot keeps to a command."""
APART = 50.0
"""[m]"""
SEED = 4711


@dataclass(frozen=True, slots=True, eq=False)
class Drives:
    """What some robots told of their drives, and where they were."""

    told: Array
    """Ways along the arc and to the left [m], and turns [rad] of all ticks, shape (robots, ticks, 3)."""
    poses: Array
    """World frame, at all ticks with the start, shape (robots, ticks + 1, 3)."""
    dt: float
    """[s]"""

    def about(self, x: float) -> "Drives":
        """Return the drives of the point of a robot that lies x ahead of its origin [m]."""
        headings = self.poses[..., 2]
        offset = np.stack([np.cos(headings), np.sin(headings), np.zeros_like(headings)], axis=-1)
        return replace(self, poses=self.poses + x * offset)

    def scaled(self, turn: float) -> "Drives":
        """Return drives whose turns are told as so many times as large."""
        return replace(self, told=self.told * [1.0, 1.0, turn])


@dataclass(frozen=True, slots=True)
class Learned:
    """What drives tell of a robot."""

    drives: int
    center: float
    """Where the point is about which it turns, ahead of its origin [m]."""
    turn: float
    """What it turns of a radian that its wheels tell."""
    slip: Slip


def learned(text: str, files: Mapping[str, bytes], *, file: str) -> Learned:
    """Return what drives of a robot tell, its odometry without noise.

    Args:
        text: Of a world with this robot alone.
        files: What it names.
        file: The maker's file, as errors name it.
    """
    world = parse_world(text, source=Source(file=file, attached=files))
    with Simulation(world) as sim:
        slow = sim.model.njnt > MANY_JOINTS
    together = 1 if slow else TOGETHER
    lots = [_driven(_lot(world, together), first) for first in range(0, FEWER if slow else ROBOTS, together)]
    told, poses = (np.concatenate(parts) for parts in zip(*((lot.told, lot.poses) for lot in lots), strict=True))
    drives = Drives(told, poses, lots[0].dt)
    turn, center = _turn(drives), _center(drives)
    drives = drives.about(center).scaled(turn)
    return Learned(len(told), center, turn, likely_slip(drives.told, drives.poses, dt=drives.dt))


def rolled(text: str, files: Mapping[str, bytes], *, file: str) -> tuple[float, float]:
    """Return what a robot on rollers drives sideways, and what it turns, of what its wheels tell.

    Args:
        text: Of a world with this robot alone.
        files: What it names.
        file: The maker's file, as errors name it.
    """
    world = _lot(parse_world(text, source=Source(file=file, attached=files)), TOGETHER)
    lots = [_driven(world, first) for first in range(0, ON_ROLLERS, TOGETHER)]
    told, driven = (np.concatenate(parts) for parts in zip(*((lot.told, _ways(lot)) for lot in lots), strict=True))
    told, driven = (ways.reshape(-1, LONG, 3).sum(axis=1) for ways in (told, driven))
    _, strafe, spin = (np.sum(told * driven, axis=0) / np.sum(told * told, axis=0)).tolist()
    return strafe, spin


def _lot(world: World, together: int) -> World:
    """Return a world of some robots far from each other, whose encoders do not err.

    Their motors do, as the preset says: tyres slip most while speeds change.
    """
    (robot,) = world.robots
    told = {"sensors": (), "odometry": WheelOdometry(noise=OdometryNoise())}
    robots: list[Robot] = [
        robot.model_copy(update={**told, "name": f"robot{k}", "at": (APART * k, 0.0)}) for k in range(together)
    ]
    run = world.run.model_copy(update={"drivers": {}})
    return world.model_copy(update={"robots": tuple(robots), "run": run})


def _driven(world: World, first: int) -> Drives:
    """Return the drives of some robots at commands that change, the first robot having a number."""
    with Simulation(world, seed=SEED + first) as sim:
        chances = {name: np.random.default_rng([SEED, first + k]) for k, name in enumerate(sim.robots)}
        told, poses = [], [[pose.as_array() for pose in sim.truths().values()]]
        for tick in range(TICKS):
            if tick % HELD == 0:
                for name, rng in chances.items():
                    sim.apply(name, _some_command(sim.robots[name], rng))
            sim.step()
            told.append([_along_the_arc(sim.odometry(name)) for name in chances])
            poses.append([pose.as_array() for pose in sim.truths().values()])
        return Drives(np.swapaxes(np.array(told), 0, 1), np.swapaxes(np.array(poses), 0, 1), sim.dt)


def _some_command(robot: RobotInfo, rng: np.random.Generator) -> Command:
    speed, turn = min(0.7 * robot.max_speed, 1.0), min(0.6 * robot.max_turn, 1.0)
    command = Command(rng.uniform(0.0, speed), turn=rng.uniform(-turn, turn))
    aside = 0.5 * robot.max_left
    return replace(command, left=rng.uniform(-aside, aside)) if aside else command


def _along_the_arc(told: Odometry) -> tuple[float, float, float]:
    """Return the ways along the arc and to the left [m] and the turn [rad] of an increment without noise."""
    way = complex(told.forward, told.left) / complex(*arc_end(1.0, told.turn))
    return way.real, way.imag, told.turn


def _turn(drives: Drives) -> float:
    """Return how far robots turned of what their wheels told, by least squares over all commands."""
    told = drives.told[..., 2].reshape(len(drives.told), -1, HELD).sum(axis=-1)
    was = drives.poses[:, HELD::HELD, 2] - drives.poses[:, :-1:HELD, 2]
    # Wheels are right to far less than half a turn of the robot.
    driven = told + wrap_angles(was - told)
    return float(np.sum(told * driven) / np.sum(told * told))


def _center(drives: Drives) -> float:
    """Return where the point lies that does not move aside when robots turn on the spot, ahead of the origin [m].

    Aside they move by -x times the turn rate, and outward by something times speed and turn rate (creep of tyres);
    both are fitted to what they drove at steady commands.

    References:
        Mandow et al., Experimental Kinematics for Wheeled Skid-Steer Mobile Robots, IROS 2007: the centre of rotation.
    """
    _, aside, turn = np.moveaxis(_ways(drives), -1, 0)
    steady = np.arange(aside.shape[1]) % HELD >= STEADY

    def sums(values: Array) -> Array:
        return np.asarray(values[:, steady].reshape(len(values), -1, HELD - STEADY).sum(axis=-1).ravel())

    ways = sums(drives.told[..., 0]) * sums(drives.told[..., 2]) / ((HELD - STEADY) * drives.dt)
    found = np.linalg.lstsq(np.column_stack([sums(turn), ways]), sums(aside), rcond=None)[0]
    return float(-found[0])


def _ways(drives: Drives) -> Array:
    """Return ways ahead and to the left [m] and turns [rad] that were driven each tick, shape (robots, ticks, 3)."""
    step = np.diff(drives.poses, axis=1)
    turn = wrap_angles(step[..., 2])
    half = drives.poses[:, :-1, 2] + turn / 2
    c, s = np.cos(half), np.sin(half)
    return np.stack([c * step[..., 0] + s * step[..., 1], c * step[..., 1] - s * step[..., 0], turn], axis=-1)
