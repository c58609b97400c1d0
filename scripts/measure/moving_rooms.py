"""Count touches of GoToGoal in rooms full of things that move.

python scripts/measure/moving_rooms.py [FIRST] [LAST] [--drive PRESET]

In the manner of DynaBARN (Nair et al., SSRR 2022): a robot crosses a room of 12 x 8 m in which ten cylinders go back
and forth on random paths, each at its own speed of 0.3 to 1.2 m/s. They do not avoid the robot, which sees all around.
A touch is a contact that the bumper feels, in any step of the physics.
"""

import argparse

import numpy as np
from scipy.stats import beta

from mjsim.algorithms.go_to_goal import GoToGoal
from mjsim.run import Driver, ticks
from mjsim.sim import Simulation
from mjsim.world import parse_world

GOAL, LIMIT = (11.0, 4.0), 60.0
LIDAR = "{lidar: scan, at: [0, 0, 0.4], beams: 720, fov_deg: 360, range: [0.05, 10], rate_hz: 25}"


def room(number: int, preset: str) -> str:
    """Return the text of a world."""
    rng = np.random.default_rng(number)
    things = []
    for thing in range(10):
        start, *points = rng.uniform((2.5, 0.5), (9.5, 7.5), (4, 2)).round(2).tolist()
        speed = rng.uniform(0.3, 1.2)
        path = f"{{points: {points}, speed: {speed:.2f}, wait: 0}}"
        things.append(f"  - {{name: m{thing}, cylinder: [0.2, 1.0], at: {start}, path: {path}}}")
    return f"""
mjsim: 1
walls: [{{points: [[0, 0], [12, 0], [12, 8], [0, 8]], closed: true}}]
obstacles:
{chr(10).join(things)}
robots: [{{name: scout, preset: {preset}, at: [1, 4], sensors: [{LIDAR}]}}]
"""


def drive(number: int, preset: str) -> tuple[float, bool, bool]:
    """Return when a drive ends [s], at a touch, the goal or the limit; whether it touched, and whether it arrived."""
    navigator, time, touched = GoToGoal([GOAL]), 0.0, False
    with Simulation(parse_world(room(number, preset)), seed=number) as sim:
        for tick in ticks(sim, {"scout": Driver(navigator=navigator)}):
            time, touched = tick.time, bool(tick.seen["scout"].bump)
            if touched or navigator.is_done or time > LIMIT:
                break
    return time, touched, navigator.is_done


def main() -> None:
    """Run the rooms; print a line for each, then the share without a touch and its 95 % interval."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", nargs="?", type=int, default=0)
    parser.add_argument("last", nargs="?", type=int, default=19)
    parser.add_argument("--drive", default="jackal")
    options = parser.parse_args()
    touched, arrived = 0, 0
    for number in range(options.first, options.last + 1):
        time, touch, arrives = drive(number, options.drive)
        touched, arrived = touched + touch, arrived + arrives
        print(number, f"{time:.1f} s", "touches" if touch else "arrives" if arrives else "is late", flush=True)
    count = options.last - options.first + 1
    free = count - touched
    # Clopper and Pearson.
    low = beta.ppf(0.025, free, touched + 1) if free else 0.0
    high = beta.ppf(0.975, free + 1, touched) if touched else 1.0
    print(f"{free} of {count} rooms without a touch ({100 * low:.0f} to {100 * high:.0f} %), {arrived} arrive")


if __name__ == "__main__":
    main()
