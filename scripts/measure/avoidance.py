#!/usr/bin/env python3
"""Let a robot that is told only to go ahead loose in cluttered rooms: bumps, and how much of the floor it comes over.

`.venv/bin/python scripts/measure/avoidance.py --seeds 20` prints a row a seed and the average. The project asks for
no bump, and on average for 75 % of the floor after 15 simulated minutes and 95 % after 45; with the avoidance off the
robot bumps and stays, and passes no wall. Seeds that stand in the file of results already are not run again.

`--robots 4`, `--movers 3` and `--people 4` let so many go about or stand in a room of 8 x 6 m, with fair starts, and
print the bumps a robot and minute; and of these how often the robot itself drove into what it met, and was not run into
standing.
"""

import argparse
import itertools
import json
import time
from pathlib import Path

import numpy as np
import shapely

import mjsim
from mjsim.algorithms.constant import ConstantCommand
from mjsim.exchange import clutter_world
from mjsim.geometry import Array
from mjsim.report.coverage import coverage
from mjsim.run import drivers_of
from mjsim.world import parse_world, solid

SIZE = (12.0, 10.0)
"""Of the room [m]."""
WITHOUT = 60.0
"""How long a run without the avoidance lasts [s]."""


def run_world(world: mjsim.World, *, seed: int, seconds: float, avoidance: bool) -> tuple[Array, int, float]:
    """Return where the robots were at every tick, shape (robots, n, 2) [m], the bumps, and CPU seconds."""
    places, bumps, began = [], 0, time.process_time()
    with mjsim.Simulation(world, seed=seed) as sim:
        drivers = {
            name: mjsim.Driver(navigator=driver.navigator, avoidance=avoidance)
            for name, driver in drivers_of(world).items()
        }
        for tick in itertools.islice(mjsim.ticks(sim, drivers), round(seconds / sim.dt)):
            places.append([(pose.x, pose.y) for pose in tick.truth.values()])
            bumps += sum(event.kind == "bump" for order in tick.orders.values() for event in order.events)
    return np.array(places).transpose(1, 0, 2), bumps, time.process_time() - began


def measure(seed: int, seconds: float) -> dict[str, float]:
    """Return the figures of one room."""
    world = clutter_world(SIZE, seed=seed)
    ((body),) = (robot.body for robot in world.robots)
    radius = float(np.hypot(*body.outline().T).max())
    (places,), bumps, spent = run_world(world, seed=seed, seconds=seconds, avoidance=True)
    third = len(places) // 3
    still = np.hypot(*(places[50:] - places[:-50]).T) < 0.05
    (blind,), touched, _ = run_world(world, seed=seed, seconds=WITHOUT, avoidance=False)
    free = shapely.box(0.0, 0.0, *SIZE).difference(solid(world))
    inside = shapely.contains_xy(free, *blind.T).all() and shapely.contains_xy(free, *places.T).all()
    return {
        "seed": seed,
        "bumps": bumps,
        "third": 100.0 * (coverage(world, places[:third], radius=radius) or 0.0),
        "whole": 100.0 * (coverage(world, places, radius=radius) or 0.0),
        "way": float(np.hypot(*np.diff(places, axis=0).T).sum()),
        "still": 100.0 * float(still.mean()),
        "nearest": float(shapely.distance(solid(world), shapely.points(places)).min()) - radius,
        "speed": seconds / spent,
        "blind_bumps": touched,
        "blind_way": float(np.hypot(*(blind[-1] - blind[len(blind) // 5]))),
        "through": float(not inside),
    }


CROWDED = (8.0, 6.0)
"""The room for several robots and movers [m]."""
APART = 1.6
"""At least so far from a robot begins all else [m]."""
MOST = 8
"""Robots, movers and people that surely find room to begin so."""


def crowd(robots: int, movers: int, people: int, *, seed: int) -> mjsim.World:
    """Return a room with robots, movers, which leave a robot room to pass along the walls, and people who stand."""
    rng = np.random.default_rng([seed, robots, movers, *([people] if people else [])])
    ways = [rng.uniform((1.0, 1.0), np.array(CROWDED) - 1.0, (3, 2)).round(2) for _ in range(movers)]
    taken = [way[0] for way in ways]
    while len(taken) < movers + robots + people:
        place = rng.uniform((0.8, 0.8), np.array(CROWDED) - 0.8).round(2)
        if all(np.hypot(*(place - other)) > APART for other in taken):
            taken.append(place)
    room = [[0.0, 0.0], [CROWDED[0], 0.0], [*CROWDED], [0.0, CROWDED[1]]]
    lines = [f"mjsim: 1\nwalls: [{{points: {room}, closed: true}}]", *(["obstacles:"] if movers else [])]
    for first, *on in (way.tolist() for way in ways):
        path = f"{{points: {on}, speed: {rng.uniform(0.3, 0.5):.2f}, closed: true}}"
        lines.append(f"  - {{cylinder: [0.25, 1.5], at: {first}, path: {path}}}")
    lines += ["people:"] if people else []
    for number, place in enumerate(taken[movers + robots :]):
        body = f"sex: {rng.choice(['female', 'male'])}, percentile: {rng.integers(1, 100)}"
        lines.append(f"  - {{name: p{number}, {body}, at: {place.tolist()}, heading_deg: {rng.integers(0, 360)}}}")
    lines.append("robots:")
    for number, place in enumerate(taken[movers : movers + robots]):
        heading = rng.integers(0, 360)
        lines.append(f"  - {{name: r{number}, preset: pioneer3dx, at: {place.tolist()}, heading_deg: {heading}}}")
    return parse_world("\n".join(lines))


def run_crowd(world: mjsim.World, *, seed: int, seconds: float) -> tuple[Array, list[float]]:
    """Return how fast all robots drove at every tick [m/s], and for each bump how fast toward what it met [m/s]."""
    places: list[Array] = []
    met: list[float] = []
    with mjsim.Simulation(world, seed=seed) as sim:
        drivers = {name: mjsim.Driver(navigator=ConstantCommand(forward=0.7), avoidance=True) for name in sim.robots}
        for tick in itertools.islice(mjsim.ticks(sim, drivers), round(seconds / sim.dt)):
            places.append(np.array([pose.as_array()[:2] for pose in tick.truth.values()]))
            before = places[max(len(places) - 4, 0)]
            for number, (name, order) in enumerate(tick.orders.items()):
                if any(event.kind == "bump" for event in order.events):
                    bearing = tick.truth[name].heading + tick.seen[name].bump[0]
                    moved = (places[-1][number] - before[number]) / (3.0 * sim.dt)
                    met.append(float(moved @ (np.cos(bearing), np.sin(bearing))))
        return np.hypot(*np.diff(places, axis=0).T) / sim.dt, met


def measure_crowd(robots: int, movers: int, people: int, *, seeds: int, seconds: float) -> None:
    """Print a row a seed, and the bumps a robot and minute."""
    minutes, bumps, drove, pace = robots * seconds / 60.0, 0, 0, 0.0
    print(f"robots {robots}, movers {movers}, people {people}\nseed  bumps  drove into  speed")
    for seed in range(1, seeds + 1):
        speeds, met = run_crowd(crowd(robots, movers, people, seed=seed), seed=seed, seconds=seconds)
        own = sum(speed > 0.05 for speed in met)
        bumps, drove, pace = bumps + len(met), drove + own, pace + float(speeds.mean()) / seeds
        print(f"{seed:4d}  {len(met):5d}  {own:10d}  {speeds.mean():.2f} m/s", flush=True)
    minutes *= seeds
    print(f"a robot and minute: {bumps / minutes:.2f} bumps, drove into {drove / minutes:.2f}, {pace:.2f} m/s")


HEAD = "seed  bumps  15 min  45 min     way  waits  nearest  speed | off: bumps  moves  passed"


def row(found: dict[str, float]) -> str:
    """Return a line of the table."""
    return (
        f"{found['seed']:4.0f}  {found['bumps']:5.1f}  {found['third']:5.1f}%  {found['whole']:5.1f}%"
        f"  {found['way']:5.0f}m  {found['still']:4.1f}%  {found['nearest']:6.3f}m  {found['speed']:4.0f}x"
        f" | {found['blind_bumps']:10.1f}  {found['blind_way']:4.2f}m  {found['through']:6.0f}"
    )


def main() -> None:
    """Print a row a seed, and the average."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, help="how many, from 1 on")
    parser.add_argument("--minutes", type=float, default=45.0, help="simulated; the first figure is after a third")
    parser.add_argument("-o", type=Path, default=Path("out/avoidance.jsonl"), help="the file of results")
    parser.add_argument("--robots", type=int, default=1, help="in a room without clutter")
    parser.add_argument("--movers", type=int, default=0, help="in a room without clutter")
    parser.add_argument("--people", type=int, default=0, help="in a room without clutter")
    given = parser.parse_args()
    if (count := given.robots + given.movers + given.people) > MOST:
        parser.error(f"there are {count} robots, movers and people; at most {MOST} have room")
    if given.robots > 1 or given.movers or given.people:
        seconds = 60.0 * given.minutes
        measure_crowd(given.robots, given.movers, given.people, seeds=given.seeds, seconds=seconds)
        return
    given.o.parent.mkdir(parents=True, exist_ok=True)
    there = [json.loads(line) for line in given.o.read_text().splitlines()] if given.o.exists() else []
    known = {found["seed"]: found for found in there if found["minutes"] == given.minutes}
    rows = []
    print(HEAD)
    for seed in range(1, given.seeds + 1):
        if seed not in known:
            known[seed] = {**measure(seed, 60.0 * given.minutes), "minutes": given.minutes}
            with given.o.open("a") as file:
                file.write(json.dumps(known[seed]) + "\n")
        rows.append(known[seed])
        print(row(known[seed]), flush=True)
    print("average\n" + row({key: float(np.mean([found[key] for found in rows])) for key in rows[0]}))
    print(f"nearest ever {min(found['nearest'] for found in rows):.3f} m, bumps {sum(f['bumps'] for f in rows):.0f}")


if __name__ == "__main__":
    main()
