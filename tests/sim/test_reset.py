"""A simulation that is reset is as new."""

import pickle

import numpy as np
import pytest

from mjsim.errors import PhysicsFault, UsageError
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.world import parse_world

BUSY = """
mjsim: 1
light: 0.7
lamps: [{name: spot, at: [2, 2], height: 2.4, brightness: 0.5}]
ceiling: {}
walls:
  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}
  - {points: [[3, 0], [3, 4]], openings: [{name: gate, segment: 0, at: 1, width: 0.9, door: {locked: true}}]}
obstacles:
  - {name: crate, box: [0.3, 0.3, 0.3], at: [1.9, 1], movable: true, mass: 2}
  - {name: ball, sphere: 0.1, at: [1, 3], movable: true, mass: 0.3}
  - {name: cart, box: [0.3, 0.3, 0.5], at: [4, 3], path: {points: [[5, 3]], speed: 0.5}}
beacons: [{name: a, image: posters/lion.jpg, at: [5.94, 2], heading_deg: 180}, {name: b, at: [2, 3]}]
robots:
  - name: r
    at: [1, 1]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.02, turn: 0.02}, ticks: 500}
    sensors:
      - {camera: eye, at: [0.1, 0, 0.3], width: 32, height: 24, noise: 5, latency: 1}
      - {lidar: scan, beams: 20, noise: {range: 0.02}, latency: 2}
      - {beacons: ring, noise: {range: 0.1}, false_rate: 3}
      - {imu: imu, noise: {acceleration: 0.1}, walk: {turn: 0.1}, rate_hz: 83.3333333333333333}
  - {name: s, at: [4, 1]}
radio: {loss: 0.3}
run:
  events:
    - {time: 0, light: 0.4}
    - {time: 0.2, lamp: spot, brightness: 0.1}
    - {time: 0.3, open: gate}
    - {time: 0.4, remove: ball}
    - {time: 0.4, remove: b}
    - {time: 0.6, move: s, to: [5, 1]}
"""


def episode(sim: Simulation) -> list[bytes]:
    """Return the bytes of all that is sensed and true in the next ticks of a busy drive."""
    rows = []
    for tick in range(18):
        seen = {name: sim.sense(name) for name in sim.robots}
        rows.append(pickle.dumps((sim.time, seen, sim.truths(), sim.state(), sim.things(), sim.looks, sim.happened())))
        sim.apply("r", Command(0.5, turn=0.1, messages=(tick,)))
        sim.apply("s", Command(-0.2, messages=("here",)))
        sim.step()
    return rows


def arrays(owner: object) -> dict[str, bytes]:
    """Return the bytes of every array of a model or its state."""
    values = ((name, getattr(owner, name)) for name in dir(owner) if not name.startswith("_"))
    return {name: value.tobytes() for name, value in values if isinstance(value, np.ndarray)}


@pytest.mark.slow
def test_a_reset_simulation_is_byte_for_byte_a_new_one_of_that_seed():
    world = parse_world(BUSY)
    with Simulation(world, seed=9) as new, Simulation(world, seed=4) as used:
        first = episode(used)
        model, data = used.model, used.data
        used.reset(9)
        assert arrays(used.model) == arrays(new.model)
        assert used.seed == 9
        assert episode(used) == episode(new)
        used.reset(4)
        assert episode(used) == first
        assert (used.model, used.data) == (model, data)


@pytest.mark.slow
def test_without_a_seed_the_same_run_comes_again_whatever_happened_before():
    with Simulation(parse_world(BUSY), seed=4) as sim:
        first = episode(sim)
        sim.remove("crate")
        sim.set_light(0.0)
        sim.data.qvel[:] = 1e12
        with pytest.raises(PhysicsFault):
            sim.step()
        sim.reset()
        assert not sim.data.warning.number.any()
        assert episode(sim) == first
        with pytest.raises(UsageError, match="seed is -1; it must be a whole number from 0 to"):
            sim.reset(-1)
        assert sim.seed == 4
