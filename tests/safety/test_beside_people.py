"""Robots and people who stand in their way: legs stand between two rays of the ring, feet below all of them."""

import itertools

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.constant import ConstantCommand
from mjsim.safety import RingAvoidance
from mjsim.world import parse_world

WORLD = """
mjsim: 1
robots:
  - name: scout
    preset: pioneer3dx
    at: [2.6, 3]
    sensors: [{lidar: scan, at: [0.1, 0, 0.3], beams: 180, fov_deg: 180, range: [0.05, 10]}]
people: [{name: bob, sex: male, percentile: 95, at: [4, 3], heading_deg: HEADING}]
"""


def drive(heading, seconds, avoidance):
    """Return the last place of a robot told to go ahead toward somebody, and how many bumps there were."""
    bumps = 0
    with mjsim.Simulation(parse_world(WORLD.replace("HEADING", str(heading))), seed=1) as sim:
        driver = mjsim.Driver(navigator=ConstantCommand(forward=0.7), avoidance=avoidance)
        for tick in itertools.islice(mjsim.ticks(sim, {"scout": driver}), round(seconds / sim.dt)):
            bumps += sum(event.kind == "bump" for event in tick.orders["scout"].events)
    return tick.truth["scout"], bumps


@pytest.mark.slow
@pytest.mark.parametrize(
    ("heading", "avoidance"), [(180, True), (90, True), (0, RingAvoidance(lidar="scan", clearance=0.22))]
)
def test_it_goes_round_a_person(heading, avoidance):
    end, bumps = drive(heading, 7.0, avoidance)
    assert bumps == 0
    # Well past, or well away to one side.
    assert end.x > 4.5 or abs(end.y - 3.0) > 0.6


@pytest.mark.parametrize("heading", [180, 150])
def test_the_ring_meets_the_nearest_foot_of_a_person_who_stands_between_its_rays(heading):
    world = parse_world(WORLD.replace("HEADING", str(heading)))
    (person,) = world.people
    points = np.concatenate([outline for name, (outline, _, _) in person.prisms.items() if name.endswith("foot")])
    gap = np.hypot(*(points - (2.6, 3.0)).T).min() - world.robots[0].body.radius
    with mjsim.Simulation(world) as sim:
        nearest = sim.sense("scout").proximity.min()
    # The lowest row passes 15 mm above the floor, and its rays are 8 cm apart there.
    assert gap - 0.005 < nearest < gap + 0.03


@pytest.mark.slow
def test_the_ring_does_not_meet_people_through_a_wall_or_beyond_its_reach():
    wall = "walls: [{points: [[3.2, 0], [3.2, 6]], height: 0.5}]\n"
    for more, far in ((wall, 4), ("", 6)):
        world = parse_world(WORLD.replace("HEADING", "180").replace("at: [4, 3]", f"at: [{far}, 3]") + more)
        with mjsim.Simulation(world) as sim:
            ahead = sim.sense("scout").proximity[0]
        assert ahead == (np.inf if far > 4 else pytest.approx(0.6 - 0.05 - world.robots[0].body.radius, abs=0.01))


@pytest.mark.slow
def test_without_avoidance_a_person_stops_it():
    end, bumps = drive(180, 4.0, False)
    assert bumps >= 1
    assert end.x < 3.75


@pytest.mark.parametrize(("given", "words"), [(0.0, "clearance is 0.0 m"), (float("nan"), "clearance is nan m")])
def test_room_that_it_cannot_keep_is_refused(given, words):
    with pytest.raises(ValueError, match=words):
        RingAvoidance(clearance=given)


def test_a_lidar_that_the_robot_does_not_have_is_named():
    world = parse_world(WORLD.replace("HEADING", "0"))
    with mjsim.Simulation(world) as sim, pytest.raises(mjsim.MjsimError, match=r"no lidar 'scam'.*scan"):
        next(mjsim.ticks(sim, {"scout": mjsim.Driver(avoidance=RingAvoidance(lidar="scam"))}))
