"""Each robot that can be bought, told to do too much or to follow circles: limits are kept, and arcs are arcs."""

import itertools
import math

import numpy as np
import pytest

from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Command, RobotInfo
from mjsim.sim import Simulation
from mjsim.world import parse_world, preset_names

ROBOTS = tuple(preset_names())
SKIDDING = {"husky", "jackal"}
BUT_SKID = tuple(name for name in ROBOTS if name not in SKIDDING)
ON_THE_SPOT = tuple(name for name in BUT_SKID if name != "f1tenth")


def meadow(names: tuple[str, ...]) -> Simulation:
    """Return robots of the presets of these names, 60 m from each other on an empty floor, heading 30 degrees."""
    lines = [f"  - {{name: {n}, preset: {n}, at: [0, {60 * k}], heading_deg: 30}}\n" for k, n in enumerate(names)]
    return Simulation(parse_world("mjsim: 1\nrobots:\n" + "".join(lines)))


def paths(sim: Simulation, seconds: float) -> dict[str, list[Pose]]:
    """Return where robots are at each tick from now on."""
    poses = [sim.truths()]
    for _ in range(round(seconds / sim.dt)):
        sim.step()
        poses.append(sim.truths())
    return {name: [each[name] for each in poses] for name in poses[0]}


def steps(path: list[Pose], dt: float) -> np.ndarray:
    """Return speed ahead [m/s] and turn [rad/s] in each tick, shape (ticks, 2)."""
    moves = [before.inverse() @ after for before, after in itertools.pairwise(path)]
    return np.array([(move.x, wrap_angle(move.heading)) for move in moves]) / dt


def radius(path: list[Pose]) -> float:
    """Return the radius of the circle that fits best [m]."""
    points = np.array([pose.as_array()[:2] for pose in path])
    # x^2 + y^2 = 2 a x + 2 b y + c is linear in (a, b, c).
    a, b, c = np.linalg.lstsq(np.column_stack([2 * points, np.ones(len(points))]), (points**2).sum(axis=1))[0]
    return math.sqrt(c + a**2 + b**2)


@pytest.mark.slow
def test_none_goes_faster_or_gathers_speed_faster_than_its_limits_and_each_comes_up_to_them():
    # One that balances leans to gather speed, and goes faster for a while to come upright again.
    rolling = [name for name in ROBOTS if name != "balancer"]
    with meadow(rolling) as sim:
        for name in rolling:
            sim.apply(name, Command(100.0))
        # The slowest to gather speed, the pallet truck, takes 3.2 s.
        for name, path in paths(sim, 4.0).items():
            robot, speeds = sim.robots[name], steps(path, sim.dt)[:, 0]
            assert speeds.max() == pytest.approx(robot.max_speed, rel=0.02), name
            # Two ticks: the servo of a wheel comes after what it is told, and makes up for it.
            assert ((speeds[2:] - speeds[:-2]) / (2 * sim.dt)).max() < 1.1 * robot.max_acceleration, name
            # The ramp costs half the square of the speed over the acceleration.
            ideal = 4.0 * robot.max_speed - robot.max_speed**2 / (2 * robot.max_acceleration)
            assert speeds.sum() * sim.dt == pytest.approx(ideal, rel=0.02), name


@pytest.mark.slow
def test_none_turns_faster_than_its_limit_and_each_that_can_comes_up_to_it_on_the_spot():
    with meadow(ON_THE_SPOT) as sim:
        for name in ON_THE_SPOT:
            sim.apply(name, Command(turn=-100.0))
        # The pallet truck first steers across, then gathers speed for 2.6 s.
        for name, path in paths(sim, 4.5).items():
            robot, turns = sim.robots[name], -steps(path, sim.dt)[:, 1]
            assert turns[-25:].mean() == pytest.approx(robot.max_turn, rel=0.02), name
            assert turns.max() < 1.05 * robot.max_turn, name
            # Over eight ticks: the make-up for lag throws the lightest ahead of its ramp in the first ones.
            # That of the pallet truck holds once its wheel stands across, after 0.75 s.
            turns = turns[25:] if robot.drive == "tricycle" else turns
            assert ((turns[8:] - turns[:-8]) / (8 * sim.dt)).max() < 1.1 * robot.max_turn_acceleration, name


def arc(robot: RobotInfo, share: float, bend: float) -> tuple[float, float]:
    """Return speed [m/s] and turn [rad/s] of an arc at a share of the largest speed, bent as far as both limits let it.

    The acceleration across the way stays below a tenth of gravity, where tyres begin to slip aside.
    """
    speed = share * min(robot.max_speed, 1.0)
    most = min(0.8 * robot.max_turn, 0.8 * abs(speed) * min(robot.max_curvature, 1e3), 1.0 / abs(speed))
    return speed, bend * most


@pytest.mark.slow
@pytest.mark.parametrize(("share", "bend"), [(0.9, -0.6), (-0.5, 0.4)])
def test_at_every_speed_arcs_are_those_of_speed_over_turn(share, bend):
    with meadow(ROBOTS) as sim:
        told = {name: arc(robot, share, bend) for name, robot in sim.robots.items()}
        for name, (speed, turn) in told.items():
            sim.apply(name, Command(speed, turn=turn))
        paths(sim, 2.5)
        for name, path in paths(sim, 4.0).items():
            speed, turn = told[name]
            # Four fixed wheels slip by nature: what they turn is told to a tenth.
            rel = 0.1 if name in SKIDDING else 0.02
            assert steps(path, sim.dt)[:, 1].mean() == pytest.approx(turn, rel=rel), name
            assert radius(path) == pytest.approx(abs(speed / turn), rel=rel), name


@pytest.mark.slow
def test_each_closes_a_full_circle():
    with meadow(BUT_SKID) as sim:
        told = {name: arc(robot, 0.6, 0.9) for name, robot in sim.robots.items()}
        for name, (speed, turn) in told.items():
            sim.apply(name, Command(speed, turn=turn))
        paths(sim, 4.0)  # until one that balances leans no more
        for name, path in paths(sim, 2.0 * math.pi / min(turn for _, turn in told.values())).items():
            speed, turn = told[name]
            once = path[: round(2.0 * math.pi / turn / sim.dt) + 1]
            gap = math.dist(once[0].as_array()[:2], once[-1].as_array()[:2])
            # 2 % of the way round.
            assert gap < 0.02 * 2.0 * math.pi * speed / turn, name
            assert radius(once) == pytest.approx(speed / turn, rel=0.02), name
