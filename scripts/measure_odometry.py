"""Print how honest the covariance of odometry is: the normalised error of dead reckoning over 50 robots of each preset.

python scripts/measure_odometry.py [PRESET]...   (all of them unless some are named)

Each robot drives for 20 s at speeds, turns and ways sideways that change every two seconds, on a level floor of
friction 1 and with constant errors off; once with the noise of a good robot, once with none: slip alone is left then.
"""

import sys

import numpy as np
from scipy.stats import chi2

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Command, RobotInfo
from mjsim.run.pilot import DeadReckoning
from mjsim.sim import Simulation
from mjsim.world import parse_world
from mjsim.world.presets import preset_names

ROBOTS, TICKS, HELD, SEED = 50, 500, 50, 7
TOGETHER = 10
"""Robots in one simulation: fifty with rollers would be one large system of contacts."""
NOISE = "drive: {noise: {speed: 0.02, turn: 0.02}}, odometry: {noise: {distance: 0.01, turn: 0.02}}"
SLIP_ALONE = "drive: {noise: {speed: 0, turn: 0}}, odometry: {noise: {distance: 0, turn: 0}}"
SINGULAR = 1e-30
"""Of a determinant: encoders that have not yet counted a step tell nothing, not even a covariance."""


def some_command(robot: RobotInfo, rng: np.random.Generator) -> Command:
    """Return a command within the limits of a robot."""
    speed, aside, turn = min(0.7 * robot.max_speed, 1.0), 0.5 * robot.max_left, min(0.6 * robot.max_turn, 1.0)
    return Command(rng.uniform(0.0, speed), rng.uniform(-aside, aside), rng.uniform(-turn, turn))


def errors_of(preset: str, keys: str, numbers: range) -> tuple[Array, Array]:
    """Return the NEES of some robots at each tick, shape (ticks, robots), and how far off each is in the end [m]."""
    lines = [f"  - {{name: r{k}, preset: {preset}, at: [{50 * k}, 0], {keys}}}\n" for k in numbers]
    nees = np.full((TICKS, len(numbers)), np.nan)
    with Simulation(parse_world("mjsim: 1\nrobots:\n" + "".join(lines)), seed=SEED) as sim:
        beliefs = {name: DeadReckoning(robot) for name, robot in sim.robots.items()}
        chances = {name: np.random.default_rng([SEED, *name.encode()]) for name in beliefs}
        for tick in range(TICKS):
            if tick % HELD == 0:
                for name, rng in chances.items():
                    sim.apply(name, some_command(sim.robots[name], rng))
            sim.step()
            for column, (name, belief) in enumerate(beliefs.items()):
                belief.add(sim.sense(name))
                error = belief.pose.as_array() - sim.truth(name).as_array()
                error[2] = wrap_angle(error[2])
                if np.linalg.det(belief.covariance) > SINGULAR:
                    nees[tick, column] = error @ np.linalg.solve(belief.covariance, error)
        off = [np.hypot(*(beliefs[name].pose.as_array() - sim.truth(name).as_array())[:2]) for name in beliefs]
    return nees, np.array(off, dtype=float)


def row(preset: str, keys: str) -> str:
    """Return mean NEES, share of times in the 95 % band, and error in the end, as cells of a table."""
    parts = [errors_of(preset, keys, range(first, first + TOGETHER)) for first in range(0, ROBOTS, TOGETHER)]
    nees, off = np.concatenate([part[0] for part in parts], axis=1), np.concatenate([part[1] for part in parts])
    told = np.isfinite(nees).all(axis=1)
    low, high = chi2.ppf([0.025, 0.975], 3 * ROBOTS)
    sums = nees[told].sum(axis=1)
    inside = float(np.mean((low < sums) & (sums < high)))
    return f"{np.mean(nees[told]):.2f} | {inside:.0%} | {1000 * np.sqrt(np.mean(off**2)):.0f} mm"


def main() -> None:
    """Print the table, line by line."""
    print("| preset | NEES | in the band | off after 20 s | NEES, no noise | in the band | off after 20 s |")
    print("|---|---|---|---|---|---|---|")
    for preset in sys.argv[1:] or preset_names():
        print(f"| `{preset}` | {row(preset, NOISE)} | {row(preset, SLIP_ALONE)} |", flush=True)


if __name__ == "__main__":
    main()
