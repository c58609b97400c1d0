"""Print how honest the covariance of odometry is: the normalised error of dead reckoning over 50 robots of each preset.

python scripts/measure/odometry.py [--seed N] [PRESET]...   (all of them unless some are named; a file is one, too)

Each robot drives for 20 s at speeds, turns and ways sideways that change every two seconds, on a level floor of
friction 1 and with constant errors off; once with the noise of a good robot, once with none: slip alone is left then.
The lot of 50 is told of its drive several times, each time by odometers with chance of their own. The errors of a
drive hang together over time, so that shares scatter: the last line says how much, of a covariance that is exact.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import Command, Odometry, RobotInfo
from mjsim.run.pilot import DeadReckoning
from mjsim.sim import Simulation, arc_end
from mjsim.sim.odometry import WheelOdometer
from mjsim.world import Source, WheelOdometry, World, parse_world, preset_names
from mjsim.world.items.drives.odometry import OdometryNoise

ROBOTS, TICKS, HELD, LOTS, SEED = 50, 500, 50, 8, 2323
"""The allowances for slip were fitted to drives of seed 11, those of four fixed wheels to seeds 11 to 22."""
TOGETHER = 5
"""Robots in one simulation: fifty with rollers would be one large system of contacts."""
JUDGED = 5
"""Every so many ticks errors are compared with what was told of them."""
KEYS = "drive: {noise: {speed: 0.02, turn: 0.02}}, odometry: {noise: {distance: 0, turn: 0}}"
NOISE = OdometryNoise(distance=0.01, turn=0.02)
SILENCE = OdometryNoise(distance=0.0, turn=0.0)
EXACT_LOTS = 2000
"""Lots of drives of which the covariance is exact."""
ENOUGH = 0.9
"""Share of times in the band that is asked for."""
SINGULAR = 1e-30
"""Of a determinant: encoders that have not yet counted a step tell nothing, not even a covariance."""


def some_command(robot: RobotInfo, rng: np.random.Generator) -> Command:
    """Return a command within the limits of a robot."""
    speed, aside, turn = min(0.7 * robot.max_speed, 1.0), 0.5 * robot.max_left, min(0.6 * robot.max_turn, 1.0)
    return Command(rng.uniform(0.0, speed), rng.uniform(-aside, aside), rng.uniform(-turn, turn))


def driven(preset: str, numbers: Sequence[int], *, seed: int) -> tuple[Array, Array]:
    """Return how some robots drove.

    Returns:
        What wheels tell of each tick: ways ahead and to the left [m], turn [rad], shape (robots, ticks, 3).
        Poses at all ticks, the start among them, shape (robots, ticks + 1, 3).
    """
    name = Path(preset).stem
    lines = [f"  - {{name: {name}{k}, preset: {Path(preset).name}, at: [{50 * k}, 0], {KEYS}}}\n" for k in numbers]
    with Simulation(world_of(preset, "".join(lines)), seed=seed) as sim:
        chances = {name: np.random.default_rng([seed, *name.encode()]) for name in sim.robots}
        told, poses = [], [[pose.as_array() for pose in sim.truths().values()]]
        for tick in range(TICKS):
            if tick % HELD == 0:
                for name, rng in chances.items():
                    sim.apply(name, some_command(sim.robots[name], rng))
            sim.step()
            told.append([along_the_arc(sim.odometry(name)) for name in chances])
            poses.append([pose.as_array() for pose in sim.truths().values()])
    return np.swapaxes(np.array(told), 0, 1), np.swapaxes(np.array(poses), 0, 1)


def world_of(preset: str, lines: str) -> World:
    """Return the world of some robots; files of presets are looked for where they are."""
    return parse_world("mjsim: 1\nrobots:\n" + lines, source=Source(folder=Path(preset).parent))


def along_the_arc(told: Odometry) -> tuple[float, float, float]:
    """Return the ways ahead and to the left [m] and the turn [rad] of an increment without noise."""
    way = complex(told.forward, told.left) / complex(*arc_end(1.0, told.turn))
    return way.real, way.imag, told.turn


def judged(told: Array, poses: Array, robot: RobotInfo, odometer: WheelOdometer) -> tuple[Array, float]:
    """Return the NEES of one robot's dead reckoning at the times judged, and how far off it is in the end [m]."""
    belief, nees = DeadReckoning(robot), []
    for tick, motion in enumerate(told.tolist(), start=1):
        belief.add(odometer.increment(motion))
        if tick % JUDGED == 0:
            error = belief.pose.as_array() - poses[tick]
            error[2] = wrap_angle(error[2])
            known = np.linalg.det(belief.covariance) > SINGULAR
            nees.append(error @ np.linalg.solve(belief.covariance, error) if known else np.nan)
    return np.array(nees, dtype=float), float(np.hypot(error[0], error[1]))


def cells(preset: str, told: Array, poses: Array, noise: OdometryNoise, *, lots: int, seed: int) -> str:
    """Return mean NEES, share of times in the 95 % band, and error in the end, as cells of a table."""
    world = world_of(preset, f"  - {{name: it, preset: {Path(preset).name}, at: [0, 0]}}\n")
    (plain,) = world.robots
    slip = (plain.odometry.tyres or plain.drive.slip).times(plain.odometry.slip)
    with Simulation(world) as sim:
        robot = sim.robots["it"]
    low, high = chi2.ppf([0.025, 0.975], 3 * len(told))
    means, shares, offs = [], [], []
    for lot in range(lots):
        runs = []
        for number, (motions, path) in enumerate(zip(told, poses, strict=True)):
            odometer = WheelOdometer(
                WheelOdometry(noise=noise),
                motion=lambda motion, _: (motion[0], motion[1], motion[2]),
                wheels=3,
                slip=slip,
                sideways=robot.max_left > 0.0,
                dt=robot.dt,
                stream=np.random.default_rng([seed, lot, number, *preset.encode()]),
            )
            start = replace(robot, prior=Pose(*path[0]))
            runs.append(judged(motions, path, start, odometer))
        nees = np.array([run[0] for run in runs])
        sums = nees[:, np.isfinite(nees).all(axis=0)].sum(axis=0)
        means.append(sums.mean() / len(told))
        shares.append(np.mean((low < sums) & (sums < high)))
        offs.append(np.mean([run[1] ** 2 for run in runs]))
    off = 1000 * np.sqrt(np.mean(offs))
    return f"{np.mean(means):.2f} | {np.mean(shares):.0%} | {off:.0f} mm"


def exact_shares(rng: np.random.Generator) -> Array:
    """Return the shares of times in the band of lots whose errors walk at random with known covariance."""
    times = np.arange(1, TICKS // JUDGED + 1)[:, None, None]
    low, high = chi2.ppf([0.025, 0.975], 3 * ROBOTS)
    shares = []
    for _ in range(EXACT_LOTS):
        walks = np.cumsum(rng.normal(size=(len(times), ROBOTS, 3)), axis=0)
        sums = (walks**2 / times).sum(axis=(1, 2))
        shares.append(np.mean((low < sums) & (sums < high)))
    return np.array(shares)


def main() -> None:
    """Print the table, line by line."""
    parser = argparse.ArgumentParser(description="Print how honest the covariance of odometry is.")
    parser.add_argument("presets", nargs="*", metavar="PRESET", help="all of them unless some are named")
    parser.add_argument("--seed", type=int, default=SEED, help="of commands, slip and noise")
    options = parser.parse_args()
    seed = options.seed
    print("| preset | NEES | in the band | off after 20 s | NEES, no noise | in the band | off after 20 s |")
    print("|---|---|---|---|---|---|---|")
    for preset in options.presets or preset_names():
        parts = [driven(preset, range(first, first + TOGETHER), seed=seed) for first in range(0, ROBOTS, TOGETHER)]
        told, poses = (np.concatenate(part) for part in zip(*parts, strict=True))
        noisy = cells(preset, told, poses, NOISE, lots=LOTS, seed=seed)
        silent = cells(preset, told, poses, SILENCE, lots=1, seed=seed)
        print(f"| `{preset}` | {noisy} | {silent} |", flush=True)
    shares = exact_shares(np.random.default_rng(seed))
    few = np.mean(shares < ENOUGH)
    print(
        f"\nA covariance that is exact: {shares.mean():.0%} in the mean, less than {ENOUGH:.0%} in {few:.0%} of lots."
    )


if __name__ == "__main__":
    main()
