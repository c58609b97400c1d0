"""How much the tyres of a robot slip, by drives of its own: what the covariance of its odometry allows for."""

import math
from collections.abc import Mapping

import numpy as np

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import Command, Odometry, RobotInfo
from mjsim.sim import Simulation
from mjsim.world import OdometryNoise, Robot, Source, WheelOdometry, World, parse_world

ROBOTS, TOGETHER = 50, 5
"""Drives, and how many robots are simulated at a time."""
TICKS, HELD, JUDGED = 500, 50, 25
"""Of a drive; ticks for which a command holds; ticks between two looks at the error."""
APART = 50.0
"""[m]"""
SEED = 4711
STATES = 3
"""Of a planar pose: the mean of its normalised error squared."""
LEAST, MOST = 0.05, 10.0


def slip_factor(text: str, files: Mapping[str, bytes], *, file: str) -> float:
    """Return by how much a robot slips more than is usual for its kind of drive.

    The normalised error of dead reckoning, squared, goes with one over the square of what is allowed; its mean over
    drives at changing speeds and turns is made that of a pose.

    Args:
        text: Of a world with this robot alone.
        files: What it names.
        file: The maker's file, as errors name it.
    """
    world = parse_world(text, source=Source(file=file, attached=files))
    errors = [_judged(_lot(world), first) for first in range(0, ROBOTS, TOGETHER)]
    return float(np.clip(math.sqrt(np.mean(errors) / STATES), LEAST, MOST))


def _lot(world: World) -> World:
    """Return a world of some robots far from each other, whose encoders do not err.

    Their motors do, as the preset says: tyres slip most while speeds change.
    """
    (robot,) = world.robots
    told = {
        "sensors": (),
        "odometry": WheelOdometry(noise=OdometryNoise()),
    }
    robots: list[Robot] = [
        robot.model_copy(update={**told, "name": f"robot{k}", "at": (APART * k, 0.0)}) for k in range(TOGETHER)
    ]
    run = world.run.model_copy(update={"drivers": {}})
    return world.model_copy(update={"robots": tuple(robots), "run": run})


def _judged(world: World, first: int) -> float:
    """Return the mean NEES of robots that dead reckon, the first one having a number."""
    found = []
    with Simulation(world, seed=SEED + first) as sim:
        chances = {name: np.random.default_rng([SEED, first + k]) for k, name in enumerate(sim.robots)}
        beliefs = {name: (pose, np.zeros((3, 3))) for name, pose in sim.truths().items()}
        for tick in range(TICKS):
            if tick % HELD == 0:
                for name, rng in chances.items():
                    sim.apply(name, _some_command(sim.robots[name], rng))
            sim.step()
            for name, belief in beliefs.items():
                beliefs[name] = _moved(*belief, sim.sense(name).odometry)
                if tick % JUDGED == JUDGED - 1:
                    found.append(_nees(*beliefs[name], sim.truth(name)))
    return float(np.mean(found))


def _some_command(robot: RobotInfo, rng: np.random.Generator) -> Command:
    speed, turn = min(0.7 * robot.max_speed, 1.0), min(0.6 * robot.max_turn, 1.0)
    return Command(rng.uniform(0.0, speed), turn=rng.uniform(-turn, turn))


def _moved(pose: Pose, covariance: Array, told: Odometry) -> tuple[Pose, Array]:
    """Return a belief after one tick, to first order (Thrun, Burgard, Fox, section 7.4)."""
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    F, G = np.eye(3), np.eye(3)
    F[:2, 2] = -s * told.forward - c * told.left, c * told.forward - s * told.left
    G[:2, :2] = [[c, -s], [s, c]]
    moved = pose @ Pose(told.forward, told.left, told.turn)
    return moved, F @ covariance @ F.T + G @ told.covariance @ G.T


def _nees(pose: Pose, covariance: Array, truth: Pose) -> float:
    error = pose.as_array() - truth.as_array()
    error[2] = wrap_angle(error[2])
    return float(error @ np.linalg.solve(covariance + np.eye(3) * 1e-12, error))
