import math
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Command
from mjsim.run.pilot import DeadReckoning
from mjsim.sim import Simulation, arc_end, arc_end_slopes, slip_shares
from mjsim.sim.bases import gear_of
from mjsim.sim.bases.differential import DifferentialKinematics
from mjsim.sim.odometry import SMOOTHING_SECONDS, WheelOdometer
from mjsim.world import Slip, WheelOdometry, parse_world
from mjsim.world.items.drives.odometry import OdometryNoise

WHEELS = DifferentialKinematics(wheel_radius=0.1, track=0.4)


def odometer(seed: int = 0, dt: float = 1.0, slip: Slip | None = None, **errors: Any) -> WheelOdometer:
    return WheelOdometer(
        WheelOdometry(**{"noise": OdometryNoise(), **errors}),
        motion=lambda rotations, _: WHEELS.twist_from_wheels(rotations),
        wheels=2,
        slip=slip or Slip(),
        sideways=False,
        dt=dt,
        stream=np.random.default_rng(seed),
    )


def noisy(seed: int = 0, **noise: float) -> WheelOdometer:
    return odometer(seed, noise=OdometryNoise(**noise))


def drive(odometry: str, command: Command, seconds: float) -> tuple[Pose, Pose]:
    """Return the motion as it was and as odometry tells it, from rest."""
    text = f"mjsim: 1\nrobots:\n  - {{name: r, at: [1, 2], heading_deg: 77, odometry: {odometry}}}\n"
    sim = Simulation(parse_world(text))
    told = Pose(0.0, 0.0, 0.0)
    start = sim.truth("r")
    sim.apply("r", command)
    for _ in range(round(seconds / sim.dt)):
        sim.step()
        seen = sim.odometry("r")
        told = told @ Pose(seen.forward, seen.left, seen.turn)
    return start.inverse() @ sim.truth("r"), told


def test_odometry_alone_is_that_of_the_whole_observation():
    sim = Simulation(parse_world("mjsim: 1\nrobots: [{name: r, at: [1, 2]}]\n"))
    sim.apply("r", Command(0.3, turn=0.5))
    for _ in range(5):
        sim.step()
        alone = sim.odometry("r")
        assert alone is sim.sense("r").odometry
    assert alone.forward > 0.001


@pytest.mark.slow
def test_the_end_of_an_arc_is_what_many_small_steps_add_up_to():
    for distance, turn in [(0.5, 1.2), (-0.3, 2.5), (1.0, -0.7), (0.2, 1e-6), (0.0, 1.0), (0.4, 0.0)]:
        pose, n = Pose(0.0, 0.0, 0.0), 4000
        for _ in range(n):
            pose = pose @ Pose(0.0, 0.0, turn / n / 2) @ Pose(distance / n, 0.0, 0.0) @ Pose(0.0, 0.0, turn / n / 2)
        # The midpoint rule errs by its step squared.
        np.testing.assert_allclose(arc_end(distance, turn), (pose.x, pose.y), atol=1e-7)


def test_slopes_of_the_arc_match_central_differences():
    step = 1e-6
    for distance, turn in [(0.5, 1.2), (-0.3, 2.5), (1.0, -0.7), (0.2, 3e-5), (0.7, 0.0)]:
        ends = [
            (np.array(arc_end(distance + d, turn + t)), np.array(arc_end(distance - d, turn - t)))
            for d, t in ((step, 0.0), (0.0, step))
        ]
        slopes = np.stack([(ahead - behind) / (2 * step) for ahead, behind in ends], axis=-1)
        np.testing.assert_allclose(arc_end_slopes(distance, turn), slopes, atol=1e-8)


@pytest.mark.parametrize("command", [Command(0.6), Command(-0.3), Command(turn=1.2), Command(0.5, turn=-0.9)])
def test_without_errors_odometry_tells_the_motion_as_it_was(command):
    was, told = drive("{noise: {distance: 0, turn: 0}}", command, 4.0)
    # On an arc the wheels slip outward, by 8 mm in these two metres; straight ahead they slip not at all.
    slip = 0.01 if command.forward and command.turn else 0.001
    np.testing.assert_allclose(told.as_array()[:2], was.as_array()[:2], atol=slip)
    assert abs(wrap_angle(told.heading - was.heading)) < 0.001


def test_constant_errors_are_those_of_the_world_file():
    was, told = drive("{noise: {}, scale: 1.05}", Command(0.5), 4.0)
    assert told.x / was.x == pytest.approx(1.05, abs=0.003)
    was, told = drive("{noise: {}, track_error: 0.1}", Command(turn=0.5), 4.0)
    assert told.heading / was.heading == pytest.approx(1 / 1.1, abs=0.003)


def test_noise_has_the_variance_of_the_distance_and_of_the_turn():
    n, distance, turn = 4000, 0.02, -0.03
    meter = noisy(distance=0.01, turn=0.02)
    told = [meter.increment(WHEELS.wheels_from_twist(distance, 0.0, turn)) for _ in range(n)]
    # In steps this small an arc is as long as its chord, to 1e-6.
    lengths, turns = np.array([(math.hypot(t.forward, t.left), t.turn) for t in told]).T
    for errors, variance in ((lengths - distance, 0.01**2 * distance), (turns - turn, 0.02**2 * abs(turn))):
        assert chi2.ppf(0.001, n) < np.sum(errors**2) / variance < chi2.ppf(0.999, n)


def test_noise_of_a_way_does_not_depend_on_the_ticks_that_it_takes():
    runs, way = 3000, 0.08
    for ticks in (1, 4):
        meter = noisy(distance=0.01, seed=ticks)
        wheels = WHEELS.wheels_from_twist(way / ticks, 0.0, 0.0)
        sums = np.array([sum(meter.increment(wheels).forward for _ in range(ticks)) for _ in range(runs)])
        assert chi2.ppf(0.001, runs) < np.sum((sums - way) ** 2) / (0.01**2 * way) < chi2.ppf(0.999, runs)


@pytest.mark.slow
def test_the_reported_covariance_is_that_of_the_increments():
    n, wheels = 20000, WHEELS.wheels_from_twist(0.3, 0.0, 0.9)
    meter = noisy(distance=0.05, turn=0.05, seed=2)
    told = [meter.increment(wheels) for _ in range(n)]
    sample = np.cov(np.array([(t.forward, t.left, t.turn) for t in told]).T)
    mean = np.mean([t.covariance for t in told], axis=0)
    # A variance of 20000 samples is within 4 % at 4 standard deviations; slip is below that here.
    deviations = np.sqrt(np.diag(mean))
    np.testing.assert_allclose(
        sample / np.outer(deviations, deviations), mean / np.outer(deviations, deviations), atol=0.05
    )


def test_the_covariance_of_a_second_on_an_arc_does_not_depend_on_the_ticks_and_holds_what_tyres_creep_outward():
    speed, rate = 0.6, 0.9
    for dt in (0.05, 0.01):
        meter = odometer(dt=dt)
        wheels = WHEELS.wheels_from_twist(speed * dt, 0.0, rate * dt)
        aside = sum(meter.increment(wheels).covariance[1, 1] for _ in range(round(1.0 / dt)))
        assert aside == pytest.approx((0.0076 * speed * rate) ** 2 + 0.001**2 * speed)


def test_what_slips_while_speeds_change_has_a_variance_that_does_not_depend_on_the_ticks():
    gain, length, end, tau = 3.0, 0.2, 3.0, SMOOTHING_SECONDS
    # A speed that grows for a while, smoothed twice: its change is a step answer less the same one later.
    times = np.linspace(0.0, end, 30001)
    begun, ended = (np.maximum(times - since, 0.0) / tau for since in (0.0, length))
    change = gain * ((1.0 + ended) * np.exp(-ended) - (1.0 + begun) * np.exp(-begun))
    square = np.mean(change**2) * end
    slip = Slip(forward=0.0, left=0.0, turn=0.0, outward=0.0, surge=0.02, swing=0.03)
    for dt in (0.05, 0.02, 0.004):
        meter, told = odometer(dt=dt, slip=slip), np.zeros((3, 3))
        for tick in range(round(end / dt)):
            speed = gain * min((tick + 0.5) * dt, length)
            told += meter.increment(WHEELS.wheels_from_twist(speed * dt, 0.0, -2.0 * speed * dt)).covariance
        assert told[0, 0] == pytest.approx(0.02**2 * square, rel=0.03)
        assert told[2, 2] == pytest.approx(0.03**2 * 4.0 * square, rel=0.03)


@pytest.mark.slow
def test_the_odometry_of_an_accelerating_skid_steered_robot_is_consistent():
    nees = normalised_errors("preset: husky", count=24, ticks=25)
    assert np.mean(nees) / 24 == pytest.approx(3.0, abs=2.0 * math.sqrt(6.0 / 24))


def test_tyres_creep_outward_by_as_much_as_the_covariance_allows_for():
    sim = Simulation(parse_world("mjsim: 1\nrobots: [{name: r, preset: pioneer3dx, at: [0, 0]}]\n"))
    sim.apply("r", Command(0.5, turn=0.8))
    creep = []
    for _ in range(100):
        before = sim.truth("r")
        sim.step()
        creep.append((before.inverse() @ sim.truth("r")).y - sim.sense("r").odometry.left)
    # A speed outward, to the right when it turns to the left, once its own speed is steady.
    assert np.mean(creep[50:]) / sim.dt == pytest.approx(-Slip().outward * 0.5 * 0.8, rel=0.05)


def test_covariance_is_symmetric_and_never_negative():
    meter = noisy(distance=0.01, turn=0.02)
    for distance, turn in np.random.default_rng(1).uniform(-0.5, 0.5, (50, 2)):
        P = meter.increment(WHEELS.wheels_from_twist(distance, 0.0, turn)).covariance
        np.testing.assert_array_equal(P, P.T)
        assert np.linalg.eigvalsh(P).min() > 0.0
    np.testing.assert_array_equal(noisy(distance=0.01).increment((0.0, 0.0)).covariance, 0.0)


def test_encoders_count_whole_steps_and_lose_none():
    step, meter = 2 * math.pi / 64, odometer(ticks=64)
    turned, told = np.zeros(2), np.zeros(2)
    for rotations in np.random.default_rng(4).uniform(-0.3, 0.5, (200, 2)):
        seen = meter.increment(rotations.tolist())
        # The way along an arc is its chord ahead over sinc of the turn.
        told += WHEELS.wheels_from_twist(seen.forward / np.sinc(seen.turn / math.pi), 0.0, seen.turn)
        turned += rotations
        np.testing.assert_allclose(told / step, np.round(told / step), atol=1e-6)
        assert ((turned - told > -1e-9) & (turned - told < step)).all()


def test_the_pitch_of_a_body_that_balances_is_added_to_what_its_wheels_turn_against_it():
    for ticks in (None, 64):
        told = odometer(ticks=ticks).increment((0.35, 0.25), pitched=-0.2)
        step = 2 * math.pi / 64
        left, right = (0.35, 0.25) if ticks is None else (math.floor(each / step) * step for each in (0.35, 0.25))
        alone = odometer().increment((left - 0.2, right - 0.2))
        assert (told.forward, told.left, told.turn) == pytest.approx((alone.forward, alone.left, alone.turn))


def test_a_wheel_that_is_thought_too_large_bends_the_way():
    # 1 % on the right wheel alone: straight ahead reads as a turn of 0.01 * 1 m / 0.4 m to the left.
    seen = odometer(wheel_errors=(0.0, 0.01)).increment((10.0, 10.0))
    assert seen.turn == pytest.approx(0.01 / 0.4)
    assert math.hypot(seen.forward, seen.left) == pytest.approx(1.005, abs=1e-4)


@pytest.mark.parametrize(
    ("keys", "slip"),
    [
        ("", Slip()),
        ("slip: 3", Slip().times(3)),
        ("tyres: {forward: 0.01, left: 0.02}", Slip(forward=0.01, left=0.02)),
        ("slip: 2, tyres: {forward: 0.01, left: 0.02}", Slip(forward=0.02, left=0.04)),
    ],
)
def test_the_slip_of_odometry_is_that_of_its_tyres_or_else_of_its_drive_times_its_factor(keys, slip):
    noise = "noise: {distance: 0, turn: 0}"
    text = f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], odometry: {{{noise}, {keys}}}}}]\n"
    world = parse_world(text)
    gear = gear_of(world.robots[0], dt=0.04, seed=0, source=world.source, clock=lambda: 0.0)
    moved = gear.odometer.increment((1.0, 1.0))
    variances = np.array([slip.forward, slip.left, 0.0]) ** 2 * moved.forward
    np.testing.assert_allclose(moved.covariance, np.diag(variances), rtol=1e-12)


def test_shares_of_a_slip_are_what_each_of_its_parts_adds_to_the_covariance():
    drives = np.random.default_rng(2).normal(0.0, 0.05, (2, 20, 3))
    shares = slip_shares(drives, dt=0.05)
    none = dict.fromkeys(Slip.model_fields, 0.0)
    for number, part in enumerate(Slip.model_fields):
        for drive, added in zip(drives, shares[:, :, number], strict=True):
            meter = odometer(dt=0.05, slip=Slip(**none | {part: 1.0}))
            told = [meter.increment(WHEELS.wheels_from_twist(d, 0.0, w)).covariance for d, _, w in drive]
            np.testing.assert_allclose(added, np.diagonal(told, axis1=1, axis2=2), atol=1e-12, err_msg=part)


def sideways(seed: int = 0, slip: Slip | None = None, dt: float = 1.0, **noise: float) -> WheelOdometer:
    """Return the odometer of a drive whose three wheels turn as it moves ahead, to the left and around."""
    return WheelOdometer(
        WheelOdometry(noise=OdometryNoise(**noise)),
        motion=lambda rotations, _: (rotations[0], rotations[1], rotations[2]),
        wheels=3,
        slip=slip or Slip(forward=0.0, left=0.0, turn=0.0, outward=0.0, surge=0.0, swing=0.0),
        sideways=True,
        dt=dt,
        stream=np.random.default_rng(seed),
    )


def spiral(distance: float, left: float, turn: float) -> np.ndarray:
    """Return the end (forward, left, turn) of a constant twist, integrated in the complex plane."""
    end = (distance + 1j * left) * ((np.exp(1j * turn) - 1.0) / (1j * turn) if turn else 1.0)
    return np.array([end.real, end.imag, turn])


def test_the_end_of_a_way_that_goes_sideways_is_that_of_its_twist():
    for twist in [(0.3, 0.2, 0.9), (-0.2, 0.4, -1.3), (0.0, -0.5, 0.7), (0.3, 0.1, 0.0)]:
        seen = sideways().increment(twist)
        np.testing.assert_allclose([seen.forward, seen.left, seen.turn], spiral(*twist), atol=1e-12)


def test_the_covariance_of_a_way_that_goes_sideways_is_that_of_its_numerical_derivatives():
    step = 1e-6
    for twist in [(0.3, 0.2, 0.9), (-0.2, 0.4, -1.3), (0.4, -0.5, 0.7), (0.1, 0.6, 1.0)]:
        P = sideways(distance=1e-7, turn=2e-7).increment(twist).covariance / 1e-14
        J = np.stack([(spiral(*(twist + d)) - spiral(*(twist - d))) / (2 * step) for d in np.eye(3) * step], axis=-1)
        np.testing.assert_allclose(P, J @ np.diag(np.abs(twist) * [1.0, 1.0, 4.0]) @ J.T, atol=1e-6)


def test_slip_of_a_drive_that_goes_sideways_counts_the_whole_way_and_creeps_across_it():
    slip = Slip(forward=0.01, left=0.02, turn=0.03, outward=0.05, surge=0.0, swing=0.0)
    ahead, left, turn, dt = 0.3, -0.4, 0.2, 0.5
    P = sideways(slip=slip, dt=dt).increment((ahead, left, turn)).covariance
    # A creep of `outward` times speed and turn rate, for a second, that points away from the centre of the arc.
    creep = (slip.outward * turn / dt) ** 2 * 1.0 / dt
    assert P[0, 0] == pytest.approx(slip.forward**2 * 0.5 + creep * left**2)
    assert P[1, 1] == pytest.approx(slip.left**2 * 0.5 + creep * ahead**2)
    assert P[2, 2] == pytest.approx(slip.turn**2 * turn)


def test_noise_of_a_drive_that_goes_sideways_has_the_variance_of_each_distance():
    n, twist = 3000, (0.02, -0.05, 0.0)
    meter = sideways(3, distance=0.01, turn=0.02)
    told = np.array([(seen.forward, seen.left) for seen in (meter.increment(twist) for _ in range(n))])
    for column in (0, 1):
        errors = told[:, column] - twist[column]
        ratio = np.sum(errors**2) / (0.01**2 * abs(twist[column]))
        assert chi2.ppf(0.001, n) < ratio < chi2.ppf(0.999, n)
    assert abs(np.corrcoef(told.T)[0, 1]) < 4.0 / math.sqrt(n)


def test_the_scale_of_a_drive_that_goes_sideways_is_that_of_both_distances():
    meter = sideways()
    meter.retune(WheelOdometry(noise=OdometryNoise(), scale=1.1, track_error=0.25))
    seen = meter.increment((0.3, 0.2, 0.9))
    np.testing.assert_allclose([seen.forward, seen.left, seen.turn], spiral(0.33, 0.22, 0.72), atol=1e-12)


NOISY = "drive: {noise: {speed: 0.02, turn: 0.02}}, odometry: {noise: {distance: 0.01, turn: 0.02}}"


def normalised_errors(keys: str, *, count: int, ticks: int, lot: int = 0) -> np.ndarray:
    """Return the NEES of dead reckoning on changing arcs at each tick, summed over the robots, shape (ticks,)."""
    lines = [f"  - {{name: r{k}, at: [{30 * (k % 8)}, {30 * (k // 8)}], {keys}}}" for k in range(count)]
    rng, nees = np.random.default_rng(lot), np.zeros(ticks)
    with Simulation(parse_world("mjsim: 1\nrobots:\n" + "\n".join(lines)), seed=7 + lot) as sim:
        beliefs = {name: DeadReckoning(robot) for name, robot in sim.robots.items()}
        for tick in range(ticks):
            if tick % 50 == 0:
                for name, robot in sim.robots.items():
                    left = rng.uniform(-0.4, 0.4) * robot.max_left if robot.max_left else 0.0
                    sim.apply(name, Command(rng.uniform(0.0, 0.5), left, rng.uniform(-1.0, 1.0)))
            sim.step()
            for name, belief in beliefs.items():
                belief.add(sim.odometry(name))
                error = belief.pose.as_array() - sim.truth(name).as_array()
                error[2] = wrap_angle(error[2])
                nees[tick] += error @ np.linalg.solve(belief.covariance, error)
    return nees


@pytest.mark.slow
def test_dead_reckoning_errs_as_its_covariance_says():
    count = 50
    nees = sum(normalised_errors(NOISY, count=count // 2, ticks=250, lot=lot) for lot in (0, 1))
    low, high = chi2.ppf([0.025, 0.975], 3 * count)
    assert np.mean((low < nees) & (nees < high)) >= 0.9


@pytest.mark.slow
@pytest.mark.parametrize(
    "keys",
    [
        f"preset: f1tenth, {NOISY}",
        f"preset: forklift, {NOISY}",
        f"preset: robotino, {NOISY}",
        "preset: husky",  # What slips by nature errs as much as is told without any noise, too.
        f"preset: youbot, {NOISY}",
    ],
)
def test_the_odometry_of_every_drive_is_consistent(keys):
    count, ticks = 12, 150
    nees = normalised_errors(keys, count=count, ticks=ticks)
    # The mean over all times wanders less than that at one time, which has the deviation sqrt(6 / count).
    assert np.mean(nees[ticks // 5 :]) / count == pytest.approx(3.0, abs=2.0 * math.sqrt(6.0 / count))
