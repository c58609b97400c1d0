"""Noise that is changed while a world runs: chance and state go on, only how far things err is another."""

import re

import numpy as np
import pytest

import mjsim
from mjsim.world import noise_figures, with_values
from mjsim.world.ground import Slider, description_of
from mjsim.world.items import SENSOR_KINDS, Camera, Robot
from mjsim.world.items.drives import KINDS
from mjsim.world.items.noise import NOISE

ROOM = """
mjsim: 1
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
beacons: [{name: a, at: [1.5, 1]}, {name: b, at: [-1.5, 1]}]
robots:
  - name: scout
    at: [0, 0]
    odometry: {noise: {distance: 0.01, turn: 0.01}}
    sensors:
      - {beacons: ring, noise: {range: 0.02, bearing_deg: 1}, rate_hz: 25}
      - {lidar: scan, beams: 20, noise: {range: 0.01}, rate_hz: 25}
      - {imu: imu, noise: {turn: 0.01}, bias: {turn: 0.1}, rate_hz: 25}
      - {camera: front, width: 64, height: 48, noise: 5, rate_hz: 25, depth: {noise: 0.001}}
"""
WORLD = mjsim.parse_world(ROOM)
QUIET = with_values(
    WORLD,
    {
        "robots.scout.odometry.noise": {},
        "robots.scout.sensors.ring.noise": {},
        "robots.scout.sensors.scan.noise": {},
        "robots.scout.sensors.imu.noise": {},
        "robots.scout.sensors.front.noise": 0.0,
        "robots.scout.sensors.front.depth": {"noise": 0.0},
    },
)
TWICE = with_values(
    WORLD,
    {
        "robots.scout.odometry.noise.distance": 0.02,
        "robots.scout.sensors.ring.noise.range": 0.04,
        "robots.scout.sensors.scan.noise.range": 0.02,
        "robots.scout.sensors.imu.noise.turn": 0.02,
        "robots.scout.sensors.front.noise": 10.0,
        "robots.scout.sensors.front.depth.noise": 0.002,
    },
)
CHANGED_AT = 5


def readings(world, changed=None):
    """Return what is sensed at each tick of a short drive, with noise that may change on the way."""
    seen = []
    with mjsim.Simulation(world, seed=2) as sim:
        for tick in range(12):
            if tick == CHANGED_AT and changed is not None:
                sim.retune(changed)
            seen.append(sim.sense("scout"))
            sim.apply("scout", mjsim.Command(0.3))
            sim.step()
    return seen


def without_camera(world):
    (robot,) = world.robots
    sensors = tuple(sensor for sensor in robot.sensors if not isinstance(sensor, Camera))
    return world.model_copy(update={"robots": (robot.model_copy(update={"sensors": sensors}),)})


def assert_errs_twice_as_far(reading, *, after=CHANGED_AT, worlds=(QUIET, WORLD, TWICE)):
    """Compare rows, one a tick, of a run without noise, of one with noise, and of one whose noise doubles."""
    still, known, changed = worlds
    quiet, once, twice = (
        np.array([reading(seen) for seen in run])
        for run in (readings(still), readings(known), readings(known, changed))
    )
    np.testing.assert_array_equal(twice[:CHANGED_AT], once[:CHANGED_AT])
    np.testing.assert_allclose((twice - quiet)[after:], 2 * (once - quiet)[after:], atol=1e-9)
    assert np.abs(once - quiet)[after:].max() > 1e-4


@pytest.mark.parametrize(
    ("reading", "after"),
    [
        (lambda seen: seen.scans["scan"].ranges, CHANGED_AT),
        (lambda seen: [sighting.range for sighting in seen.sightings], CHANGED_AT),
        (lambda seen: [sum(reading.turn[2] for reading in seen.imu)], CHANGED_AT),
        (lambda seen: [seen.odometry.forward], CHANGED_AT + 1),  # made by the step before
    ],
    ids=["lidar", "beacons", "imu", "odometry"],
)
def test_from_the_change_on_the_same_chance_errs_twice_as_far(reading, after):
    assert_errs_twice_as_far(reading, after=after, worlds=tuple(map(without_camera, (QUIET, WORLD, TWICE))))


@pytest.mark.slow
def test_from_the_change_on_depth_errs_twice_as_far():
    assert_errs_twice_as_far(lambda seen: seen.cameras["front"].depth)


@pytest.mark.slow
def test_pixels_err_as_far_as_said_from_the_change_on():
    quiet, changed = readings(QUIET), readings(WORLD, TWICE)
    spread = [
        np.std(one.cameras["front"].image.astype(float) - exact.cameras["front"].image)
        for one, exact in zip(changed, quiet, strict=True)
    ]
    # Rounding adds little; some values are clipped at white.
    np.testing.assert_allclose(spread[:CHANGED_AT], 5.0, rtol=0.1)
    np.testing.assert_allclose(spread[CHANGED_AT:], 10.0, rtol=0.1)


@pytest.mark.parametrize("drive", ["differential", "ackermann", "tricycle"])
def test_the_noise_of_a_drive_acts_from_the_change_on_and_a_reset_keeps_it(drive):
    world = mjsim.parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], drive: {{type: {drive}}}}}]")
    noisy = with_values(world, {"robots.r.drive.noise.speed": 0.2})
    ways = []
    for change_at in (None, 0, 30):
        with mjsim.Simulation(world, seed=1) as sim:
            ways.append([])
            for tick in range(40):
                if tick == change_at:
                    sim.retune(noisy)
                sim.apply("r", mjsim.Command(0.3))
                sim.step()
                ways[-1].append(sim.truth("r").x)
            sim.reset()
            sim.apply("r", mjsim.Command(0.3))
            sim.step()
            assert (sim.truth("r").x == ways[0][0]) == (change_at is None)
    assert ways[2][:30] == ways[0][:30]
    steps = np.std(np.diff(ways, axis=1)[:, 31:], axis=1)
    assert steps[2] > 5 * steps[0]
    assert steps[1] > 5 * steps[0]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("robots.scout.sensors.scan.beams", 30),
        ("robots.scout.sensors.imu.bias.turn", 0.2),
        ("robots.scout.sensors.front.depth.range", [0.1, 5.0]),
        ("robots.scout.at", [1.0, 1.0]),
        ("run.seed", 7),
        ("beacons.a.at", [1.0, 1.0]),
    ],
)
def test_what_is_no_noise_is_refused_and_named(key, value):
    with (
        mjsim.Simulation(WORLD) as sim,
        pytest.raises(mjsim.UsageError, match="cannot change during a run, only noise can") as refused,
    ):
        sim.retune(with_values(WORLD, {key: value}))
    # Of a place or a range it is the first number that differs.
    assert str(refused.value).split()[0].removesuffix(".0") == key


def test_the_figures_that_may_change_are_listed_with_their_units():
    figures = {figure.key: figure for figure in noise_figures(WORLD)}
    turn = figures["robots.scout.odometry.noise.turn"]
    assert (turn.value, turn.unit) == (0.01, "rad/sqrt(rad)")
    assert figures["robots.scout.sensors.ring.noise.bearing_deg"].unit == "deg"
    assert figures["robots.scout.odometry.scale"].unit is None
    assert "robots.scout.sensors.front.depth.noise" in figures
    assert figures["robots.scout.odometry.scale"].slider == Slider(0.8, 1.2)
    assert figures["robots.scout.sensors.front.noise"].slider == Slider(0.0, 40.0)
    assert turn.slider is None
    assert all(figure.about for figure in figures.values())
    dotted = mjsim.parse_world("mjsim: 1\nrobots: [{name: r.2, at: [0, 0], sensors: [{lidar: l.1}]}]")
    for world in (WORLD, dotted):
        for figure in noise_figures(world):
            assert with_values(world, {figure.key: figure.value}) == world


CHANCE = re.compile(r"deviation|probab|density|random|error|noise|drift|chance|wrong|lost|loss", re.IGNORECASE)
"""Words by which the schema speaks of what errs."""
SET_FOR_A_RUN = {("imu", "bias"), ("uwb", "bias"), ("camera", "blur")}
"""Errors that are drawn once a run, and a lens, which errs by no chance."""


def test_all_that_errs_of_sensors_drives_and_odometry_can_be_changed_while_it_runs():
    models = [(kind, model, model.noise_keys) for kind, model in SENSOR_KINDS.items()]
    models += [(kind, model, NOISE["drive"]) for kind, model in KINDS.items()]
    models += [("odometry", Robot.model_fields["odometry"].annotation, NOISE["odometry"])]
    fixed = {
        (kind, field)
        for kind, model, keys in models
        for field in model.model_fields
        if CHANCE.search(f"{field} {description_of(model, field)}") and field not in keys
    }
    assert fixed == SET_FOR_A_RUN
