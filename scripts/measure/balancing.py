"""Measure how a balancing robot bears slow and late control, and whether it stands for ten minutes.

    python scripts/measure/balancing.py rates            a table of rate and delay: where it falls
    python scripts/measure/balancing.py stand 0:5        ten minutes of driving and shoves for each of these seeds

The robot of the table has no noise, and is let go at a lean of 2 degrees; the linear model of docs/balancing.md says
beside it what must happen. The others have the noise of a cheap inertial sensor with a bias that wanders, noise of the
drive, a floor as slippery as wet tiles, new commands every three seconds, and a shove every twenty.
"""

import math
import sys
from collections.abc import Iterator

import numpy as np
from scipy.linalg import expm

from mjsim.algorithms.balance import Lqr, plant
from mjsim.interface import BalancingInfo, Command, ControlLoop
from mjsim.sim import Simulation
from mjsim.world import World, parse_world

RATES = (250.0, 125.0, 62.5, 50.0, 25.0)
DELAYS = (0, 4, 8, 16, 24, 32, 40, 48, 64)
"""[ms]"""
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


def becomes(world: World, *, rate_hz: float, delay_ms: float, seconds: float = 15.0) -> str:
    """Return what becomes of a robot under control of this rate and delay: it stands, rocks on and on, or falls."""
    loop = ControlLoop(controller=Lqr(), rate_hz=rate_hz, latency=round(delay_ms / 1000 / STEP))
    leans = []
    with Simulation(world) as sim:
        sim.control("joe", {"drive": loop})
        for _ in range(round(seconds / sim.dt)):
            sim.step()
            leans.append(abs(sim.poses()["joe"].pitch()))
            if leans[-1] > FALLEN:
                return "falls"
    return "stands" if max(leans[-round(3.0 / sim.dt) :]) < STILL else "rocks"


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


def rates() -> Iterator[str]:
    """Yield the lines of the table."""
    world = parse_world(QUIET)
    with Simulation(world) as sim:
        masses, radius = sim.robots["joe"].balancing, sim.robots["joe"].wheel_radius
    assert masses is not None
    yield f"| rate [Hz] | {' | '.join(f'{delay} ms' for delay in DELAYS)} |"
    yield "|---|" + "---|" * len(DELAYS)
    for rate in RATES:
        cells = []
        for delay in DELAYS:
            what = becomes(world, rate_hz=rate, delay_ms=delay)
            stable = is_stable(masses, wheel_radius=radius, rate_hz=rate, delay_ms=delay)
            cells.append(what + ("" if stable == (what == "stands") else " (the model differs)"))
        yield f"| {rate:g} | {' | '.join(cells)} |"


def stand(seed: int, seconds: float = 600.0) -> tuple[float, float, float]:
    """Return the largest lean [degrees], its mean square root, and the way driven [m], of ten rough minutes."""
    rng = np.random.default_rng([seed, *b"measure/balancing"])
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
    return math.degrees(max(leans)), math.degrees(float(np.sqrt(np.mean(np.square(leans))))), way


def main() -> None:
    """Do what the command line asks for."""
    if sys.argv[1:2] == ["rates"]:
        for line in rates():
            print(line, flush=True)
    elif sys.argv[1:2] == ["stand"] and len(sys.argv) == 3:
        first, last = map(int, sys.argv[2].split(":"))
        for seed in range(first, last):
            most, usual, way = stand(seed)
            said = "fell" if most > math.degrees(FALLEN) else "stands"
            print(f"seed {seed}: {said}, lean {usual:.1f} deg rms, {most:.1f} at most, {way:.0f} m", flush=True)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
