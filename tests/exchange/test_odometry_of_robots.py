"""What robots from files tell of their motion, and how sure they are: pieces by themselves, then whole drives."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from mjsim import exchange
from mjsim.exchange import RobotOptions
from mjsim.exchange.robots.likely import likely_slip
from mjsim.exchange.robots.slip import Drives
from mjsim.geometry import wrap_angle
from mjsim.interface import Command
from mjsim.run.pilot import DeadReckoning
from mjsim.sim import Simulation, arc_end, slip_shares
from mjsim.sim.odometry import WheelOdometer
from mjsim.world import OdometryNoise, Slip, Source, WheelOdometry, parse_world
from tests.exchange.bringing import few_drives
from tests.exchange.odd_robots import nose_heavy, tricycle
from tests.exchange.test_robots import BURGER

DT = 0.04


def some_drives(count: int, ticks: int) -> np.ndarray:
    """Return ways and turns of drives that change every second, shape (count, ticks, 3)."""
    rng = np.random.default_rng(7)
    holds = rng.uniform([0.0, 0.0, -1.0], [0.8, 0.0, 1.0], (count, ticks // 25, 3)) * DT
    return np.repeat(holds, 25, axis=1)


def test_shares_of_a_slip_add_up_to_what_odometry_tells():
    slip = Slip(forward=0.02, left=0.03, turn=0.04, outward=0.05, surge=0.06, swing=0.07)
    (drive,) = some_drives(1, 100)
    odometer = WheelOdometer(
        WheelOdometry(noise=OdometryNoise()),
        motion=lambda motion, _: (motion[0], motion[1], motion[2]),
        wheels=3,
        slip=slip,
        sideways=False,
        dt=DT,
        stream=np.random.default_rng(1),
    )
    told = np.array([np.diag(odometer.increment(motion).covariance) for motion in drive.tolist()])
    squares = np.array(list(slip.model_dump().values())) ** 2
    added = np.einsum("k,tkj->tj", squares, slip_shares(drive[None], dt=DT)[0])
    np.testing.assert_allclose(added, told, rtol=1e-9, atol=1e-15)


@pytest.mark.slow
def test_the_slip_of_drives_whose_slip_is_known_is_found_again():
    true = Slip(forward=0.03, left=0.02, turn=0.05, outward=0.0001, surge=0.0001, swing=0.0001)
    told = some_drives(120, 125)
    squares = np.array(list(true.model_dump().values())) ** 2
    spread = np.sqrt(np.einsum("k,rtkj->rtj", squares, slip_shares(told, dt=DT)))
    slipped = np.random.default_rng(3).normal(0.0, spread)
    poses = np.zeros((120, 126, 3))
    for tick in range(125):
        way, aside, turn = np.moveaxis(slipped[:, tick], -1, 0)
        heading, ends = poses[:, tick, 2], [arc_end(d, w) for d, _, w in told[:, tick].tolist()]
        forward, left = np.transpose(ends) + np.array([way, aside])
        c, s = np.cos(heading), np.sin(heading)
        step = np.stack([c * forward - s * left, s * forward + c * left, told[:, tick, 2] + turn], axis=-1)
        poses[:, tick + 1] = poses[:, tick] + step
    found = likely_slip(told, poses, dt=DT)
    for name in ("forward", "left", "turn"):
        # 120 drives tell a standard deviation to about 1 / sqrt(2 * 120), and parts of them stand for each other.
        assert getattr(found, name) == pytest.approx(getattr(true, name), rel=0.25)


def test_drives_of_another_point_have_the_same_turns():
    poses = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, np.pi / 2]]])
    drives = Drives(np.zeros((1, 1, 3)), poses, DT).about(0.5)
    np.testing.assert_allclose(drives.poses, [[[0.5, 0.0, 0.0], [1.0, 0.5, np.pi / 2]]], atol=1e-12)


def brought(path: Path) -> tuple[str, dict[str, bytes]]:
    """Return the text of a robot's preset and its files."""
    with few_drives(24):  # they tell a standard deviation to a seventh
        robot = exchange.bring_robot(path, name="r", options=RobotOptions(), packages={}, arguments={})
    return robot.text, dict(robot.files)


def nees_of(text: str, files: dict[str, bytes], *, seed: int) -> np.ndarray:
    """Return the NEES of eight robots that dead reckon at commands that change, every two seconds, shape (8, 6)."""
    world = parse_world(text, source=Source(attached=files))
    (robot,) = world.robots
    robots = [robot.model_copy(update={"name": f"r{k}", "at": (60.0 * k, 0.0), "sensors": ()}) for k in range(8)]
    run = world.run.model_copy(update={"drivers": {}})
    with Simulation(world.model_copy(update={"robots": tuple(robots), "run": run}), seed=seed) as sim:
        chances = {name: np.random.default_rng([seed, *name.encode()]) for name in sim.robots}
        beliefs = {name: DeadReckoning(info) for name, info in sim.robots.items()}
        rows = []
        for tick in range(200):
            if tick % 50 == 0:
                for name, rng in chances.items():
                    speed, turn = min(0.7 * sim.robots[name].max_speed, 1.0), min(0.6 * sim.robots[name].max_turn, 1.0)
                    sim.apply(name, Command(rng.uniform(0.0, speed), turn=rng.uniform(-turn, turn)))
            sim.step()
            for name, belief in beliefs.items():
                belief.add(sim.odometry(name))
            if tick % 50 == 49:
                rows.append([nees(belief, sim.truth(name).as_array()) for name, belief in beliefs.items()])
    return np.array(rows).T


def nees(belief: DeadReckoning, truth: np.ndarray) -> float:
    """Return the squared error of a pose, normalised by the covariance that is told."""
    error = belief.pose.as_array() - truth
    error[2] = wrap_angle(error[2])
    return float(error @ np.linalg.solve(belief.covariance, error))


@pytest.mark.slow
@pytest.mark.parametrize("made", [BURGER.read_text(encoding="utf-8"), tricycle()], ids=["burger", "tricycle"])
def test_the_odometry_of_an_imported_robot_is_consistent(made, tmp_path):
    (tmp_path / "robot.urdf").write_text(made)
    text, files = brought(tmp_path / "robot.urdf")
    found = nees_of(text, files, seed=5)
    # Times of one drive are not independent: each one's sum over the robots is compared with its own bounds.
    low, high = chi2.ppf([0.001, 0.999], 3 * len(found))
    assert ((low < found.sum(axis=0)) & (found.sum(axis=0) < high)).all(), found.mean(axis=0)


@pytest.mark.slow
def test_a_nose_heavy_skid_steered_robot_turns_about_its_origin_with_consistent_odometry(tmp_path):
    (tmp_path / "heavy.urdf").write_text(nose_heavy())
    text, files = brought(tmp_path / "heavy.urdf")
    (robot,) = parse_world(text, source=Source(attached=files)).robots
    # Its mass lies 0.05 m ahead of the middle of its wheels, which stand 0.3 m apart.
    assert 0.02 < robot.body.origin[0] < 0.15
    found = nees_of(text, files, seed=5)
    low, high = chi2.ppf([0.001, 0.999], 3 * len(found))
    assert ((low < found.sum(axis=0)) & (found.sum(axis=0) < high)).all(), found.mean(axis=0)
