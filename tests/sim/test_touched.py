"""What a program does to a world while it runs is the event of a world file with the same keys, and is reported so."""

import math

import pytest

from mjsim.geometry import Pose
from mjsim.sim import Simulation
from mjsim.world import event_from, parse_world

WORLD = """
mjsim: 1
walls: [{points: [[-3, -3], [3, -3], [3, 3]], openings: [{name: gate, segment: 0, at: 2, width: 0.9, door: {}}]}]
obstacles: [{name: crate, box: [0.3, 0.3, 0.3], at: [1.4, 1.4], movable: true, mass: 3}]
lamps: [{name: sun, at: [0, 0]}]
robots:
  - {name: r, at: [0, 0], odometry: {noise: {turn: 0.1}}}
  - name: up
    base: fixed
    at: [2, -2]
    arms: [{name: arm, dh: {rows: [{d: 0.4, alpha_deg: 90, mass: 1}, {a: 0.5, mass: 1}]}}]
"""
NOISE = "robots.r.odometry.noise.turn"
DONE = [
    (lambda sim: sim.open_door("gate", -0.5), {"open": "gate", "angle_deg": math.degrees(-0.5)}),
    (lambda sim: sim.close_door("gate"), {"close": "gate"}),
    (lambda sim: sim.set_light(0.4), {"light": 0.4}),
    (lambda sim: sim.set_lamp("sun", 0.2), {"lamp": "sun", "brightness": 0.2}),
    (lambda sim: sim.set_noise(NOISE, 0.3), {"noise": NOISE, "value": 0.3}),
    (lambda sim: sim.remove("crate"), {"remove": "crate"}),
    (lambda sim: sim.restore("crate"), {"restore": "crate"}),
    (lambda sim: sim.shove("crate", (1, 2, 0), 0.2), {"shove": "crate", "impulse": (1, 2, 0), "seconds": 0.2}),
    (lambda sim: sim.move("r", Pose(1.0, 0.5, 0.3)), {"move": "r", "to": (1.0, 0.5), "heading_deg": math.degrees(0.3)}),
    (lambda sim: sim.reach("up", {"joints_deg": (10, 20)}), {"reach": "up", "joints_deg": (10, 20)}),
    (lambda sim: sim.release("up"), {"release": "up", "arm": "arm"}),
]


@pytest.fixture(scope="module")
def sim():
    with Simulation(parse_world(WORLD)) as sim:
        yield sim


@pytest.mark.parametrize(("do", "keys"), DONE, ids=[" ".join(str(word) for word in keys) for _, keys in DONE])
def test_what_is_done_is_the_event_with_these_keys(sim, do, keys):
    do(sim)
    (event,) = sim.happened()
    assert event == event_from({"time": sim.time, **keys})
    sim.step()
