"""The robots that come with mjsim: each drives as its data sheet says, and in the world that shows it."""

import math
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.interface import Command
from mjsim.run import drivers_of
from mjsim.sim import Simulation
from mjsim.world import Camera, load_checked, parse_world, preset_names, with_settings

FOLDER = Path(__file__).parents[2] / "worlds" / "robots"


def test_every_robot_has_a_world_of_its_own_and_every_such_world_its_robot():
    assert sorted(path.stem for path in FOLDER.glob("*.yaml")) == sorted(preset_names())
    for name in preset_names():
        world = load_checked(FOLDER / f"{name}.yaml")
        assert world.name == name
        assert [robot.preset for robot in world.robots] == [name]


@pytest.mark.slow
def test_every_robot_reaches_its_largest_speed_and_stands_level():
    lines = [f"  - {{name: {name}, preset: {name}, at: [0, {4 * k}]}}\n" for k, name in enumerate(preset_names())]
    with Simulation(parse_world("mjsim: 1\nrobots:\n" + "".join(lines))) as sim:
        for name, robot in sim.robots.items():
            sim.apply(name, Command(robot.max_speed))
        for _ in range(100):
            sim.step()
        before = sim.truths()
        for _ in range(25):
            sim.step()
        for name, robot in sim.robots.items():
            assert (before[name].inverse() @ sim.truth(name)).x == pytest.approx(robot.max_speed, rel=0.02), name
            w, x, y, z = sim.data.joint(f"{name}/free").qpos[3:]
            assert math.hypot(x, y) < 0.002 * math.hypot(w, z), name


@pytest.mark.slow
def test_tyres_roll_at_the_radius_that_odometry_goes_by():
    # One that balances sways about its axle; test_balancing looks at its tyres.
    names = [name for name in preset_names() if name not in ("robotino", "youbot", "balancer")]
    keys = "odometry: {ticks: null, noise: {distance: 0, turn: 0}}"  # as fine as can be
    lines = [f"  - {{name: {name}, preset: {name}, at: [0, {4 * k}], {keys}}}\n" for k, name in enumerate(names)]
    with Simulation(parse_world("mjsim: 1\nrobots:\n" + "".join(lines))) as sim:
        for name in names:
            sim.apply(name, Command(0.2))
        for _ in range(40):
            sim.step()
        before, told = sim.truths(), dict.fromkeys(names, 0.0)
        for _ in range(50):
            sim.step()
            told = {name: way + sim.sense(name).odometry.forward for name, way in told.items()}
        for name in names:
            # 0.15 mm of a wheel of 50 mm, which contact lets into the floor, would be 0.3 %. Wheels that skid creep.
            rel = 1e-3 if name in ("husky", "jackal") else 5e-4
            assert told[name] == pytest.approx((before[name].inverse() @ sim.truth(name)).x, rel=rel), name


@pytest.mark.slow
@pytest.mark.parametrize("name", preset_names())
def test_in_its_world_it_goes_all_the_way_and_touches_nothing(name):
    world = load_checked(FOLDER / f"{name}.yaml")
    (robot,) = world.robots
    navigator = world.run.drivers[robot.name].navigator
    assert navigator is not None
    told = navigator.arguments()
    if "goals" in told:  # round the first corner; BARN worlds have longer ways
        told["goals"] = told["goals"][:2]
        world = with_settings(world, {f"run.drivers.{robot.name}.navigator.goals": told["goals"]})
    blind = robot.model_copy(update={"sensors": tuple(s for s in robot.sensors if not isinstance(s, Camera))})
    with Simulation(world.model_copy(update={"robots": (blind,)})) as sim:
        drivers = drivers_of(world)
        goal = np.array((told.get("points") or told["goals"])[-1])
        # A skid-steered robot knows only about how far it has turned: 3 degrees a corner make 1.5 m in the end.
        near = 2.0 if world.robots[0].drive.type == "skid_steer" else 0.1
        way, still = math.inf, 0
        for tick in mjsim.ticks(sim, drivers):
            assert not tick.seen[robot.name].bump, tick.time
            way = math.dist(tick.truth[robot.name].as_array()[:2], goal)
            command = tick.orders[robot.name].command
            still = still + 1 if command.forward == command.left == command.turn == 0.0 else 0
            # Who was told to stand for two seconds where it is to be has arrived.
            if tick.time >= world.run.seconds or (way < near and still > 2.0 / sim.dt):
                break
        assert way < near
