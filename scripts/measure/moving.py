"""Drive a Jackal across rooms full of things that move, in the manner of DynaBARN.

python scripts/measure/moving.py [FIRST] [LAST]   (seeds; default: 0 to 19)

In a room of 10 x 14 m ten cylinders of 0.15 to 0.35 m radius move to and fro at 0.3 to 0.9 m/s, without regard for the
robot. It crosses the room by `GoToGoal`, without a map.
"""

import sys

import numpy as np

from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal
from mjsim.run import Driver, ticks
from mjsim.sim import Simulation
from mjsim.world import parse_world

ROOM = """mjsim: 1
walls: [{points: [[0, 0], [10, 0], [10, 14], [0, 14]], closed: true}]
robots: [{name: scout, preset: jackal, at: [5, 1], heading_deg: 90}]
obstacles:
"""
NEAR = 1.5
"""Distance at which it has arrived; dead reckoning drifts [m]."""
LIMIT = 60.0
"""Time within which the robot has to arrive [s]."""


def room(seed: int) -> str:
    """Return the text of a room."""
    rng, text = np.random.default_rng(seed), ROOM
    for number in range(10):
        ends = rng.uniform((0.5, 2.5), (9.5, 11.5), (2, 2))
        while np.hypot(*(ends[1] - ends[0])) <= 3.0:
            ends = rng.uniform((0.5, 2.5), (9.5, 11.5), (2, 2))
        (x, y), (far_x, far_y) = np.round(ends, 2).tolist()
        radius, speed = rng.uniform(0.15, 0.35), rng.uniform(0.3, 0.9)
        text += (
            f"  - {{name: m{number}, cylinder: [{radius:.2f}, 1.0], at: [{x}, {y}],"
            f" path: {{points: [[{far_x}, {far_y}]], speed: {speed:.2f}}}}}\n"
        )
    return text


def drive(seed: int) -> tuple[float, bool]:
    """Return the time until the robot arrives, is touched or gives up [s], and whether it is touched."""
    navigator = GoToGoal([5.0, 13.0])
    with Simulation(parse_world(room(seed)), seed=seed) as sim:
        for tick in ticks(sim, {"scout": Driver(navigator=navigator)}):
            touched = any(event.kind == "bump" for event in tick.orders["scout"].events)
            pose = tick.truth["scout"]
            if touched or tick.time > LIMIT or np.hypot(pose.x - 5.0, pose.y - 13.0) < NEAR:
                return tick.time, touched
    raise AssertionError("ticks never end")


def main() -> None:
    """Drive through all rooms."""
    first, last = (*map(int, sys.argv[1:]), 0, 19)[:2] if len(sys.argv) == 3 else (0, 19)
    found = []
    for seed in range(first, last + 1):
        found.append(drive(seed))
        print(f"{seed}: {found[-1][0]:.1f} s{', touched' * found[-1][1]}", flush=True)
    times, touched = np.array(found).T
    print(f"{len(found)} rooms: {np.mean(touched == 0):.0%} without a touch, {np.mean(times < LIMIT):.0%} in time")


if __name__ == "__main__":
    main()
