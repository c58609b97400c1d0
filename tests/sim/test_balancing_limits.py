"""How slow and late control may be, and how rough a drive, until a balancing robot falls."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from mjsim.algorithms.balance import Lqr, plant
from mjsim.interface import BalancingInfo, Command, ControlLoop
from mjsim.sim import Simulation
from mjsim.world import World, parse_world

STEP, FALLEN = 0.004, 0.8
"""Of the physics [s]; a body that leans by more lies on the floor soon [rad]."""
STILL = math.radians(0.5)
"""What sways by less in the last three seconds has come to rest [rad]."""
QUIET = """
mjsim: 1
robots:
  - {name: joe, preset: balancer, at: [0, 0], lean_deg: 2, odometry: {ticks: null}, sensors: [{imu: imu, rate_hz: 250}]}
"""
ROUGH = """
mjsim: 1
floor: {friction: 0.4}
robots:
  - name: joe
    preset: balancer
    at: [0, 0]
    drive:
      noise: {speed: 0.02, turn: 0.02}
      imu:
        noise: {acceleration: 0.1, turn: 0.005}
        bias: {acceleration: 0.05, turn: 0.01}
        walk: {acceleration: 0.002, turn: 0.0002}
"""
"""The noise of a cheap inertial sensor with a bias that wanders, noise of the drive, a floor like wet tiles."""


def stands(world: World, *, rate_hz: float, delay_ms: float, seconds: float = 10.0) -> bool:
    """Return whether a robot comes to rest under control of this rate and delay."""
    loop = ControlLoop(controller=Lqr(), rate_hz=rate_hz, latency=round(delay_ms / 1000 / STEP))
    leans = []
    with Simulation(world) as sim:
        sim.control("joe", {"drive": loop})
        for _ in range(round(seconds / sim.dt)):
            sim.step()
            leans.append(abs(sim.poses()["joe"].pitch()))
            if leans[-1] > FALLEN:
                return False
    return max(leans[-round(3.0 / sim.dt) :]) < STILL


def is_stable(masses: BalancingInfo, *, wheel_radius: float, rate_hz: float, delay_ms: float) -> bool:
    """Return whether the linear model comes to rest under this control, whose torque is late by whole steps.

    The state of the plant at the physics steps of one period is joined by the torques that are on their way.
    """
    period, late = round(1 / (rate_hz * STEP)), round(delay_ms / 1000 / STEP)
    A, B = plant(masses, wheel_radius=wheel_radius)
    K = np.array(Lqr().design(masses, wheel_radius=wheel_radius, dt=1 / rate_hz))
    held = expm(np.block([[A, B], [np.zeros((1, 5))]]) * STEP)
    # Columns: the plant, then the torque of each of the last steps, newest first.
    size = 4 + late + 1
    whole = np.eye(size)
    for step in range(period):
        shift = np.zeros((size, size))
        shift[:4, :4] = np.eye(4)
        shift[5:, 4:-1] = np.eye(late)
        shift[4] = np.r_[-K, np.zeros(late + 1)] if step == 0 else np.eye(size)[4]
        move = np.eye(size)
        move[:4, :4], move[:4, -1] = held[:4, :4], held[:4, 4]
        whole = move @ shift @ whole
    return bool(np.abs(np.linalg.eigvals(whole)).max() < 1.0)


def rough_drive(seed: int, seconds: float) -> tuple[float, float]:
    """Return the largest lean [degrees] and the way driven [m]."""
    rng = np.random.default_rng([seed, *b"test/balancing"])
    leans, way = [], 0.0
    with Simulation(parse_world(ROUGH), seed=seed) as sim:
        before = sim.truth("joe")
        for tick in range(round(seconds / sim.dt)):
            if tick % round(3.0 / sim.dt) == 0:
                sim.apply("joe", Command(float(rng.uniform(-0.4, 0.7)), turn=float(rng.uniform(-1.2, 1.2))))
            if tick % round(20.0 / sim.dt) == round(10.0 / sim.dt):
                angle = float(rng.uniform(-math.pi, math.pi))
                sim.shove("joe", (4.0 * math.cos(angle), 4.0 * math.sin(angle), 0.0))
            sim.step()
            now = sim.truth("joe")
            way, before = way + math.dist((now.x, now.y), (before.x, before.y)), now
            leans.append(abs(sim.poses()["joe"].pitch()))
    return math.degrees(max(leans)), way


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate", "delay", "rests"), [(250, 32, True), (250, 48, False), (25, 0, True), (25, 40, False)]
)
def test_it_bears_the_rates_and_delays_that_the_linear_model_does(rate, delay, rests):
    world = parse_world(QUIET)
    with Simulation(world) as sim:
        joe = sim.robots["joe"]
    assert is_stable(joe.balancing, wheel_radius=joe.wheel_radius, rate_hz=rate, delay_ms=delay) == rests
    assert stands(world, rate_hz=rate, delay_ms=delay) == rests


@pytest.mark.slow
def test_it_stands_on_a_slippery_floor_with_a_noisy_sensor_and_shoves():
    most, way = rough_drive(100, 24.0)
    assert most < 20.0
    assert way > 4.0
