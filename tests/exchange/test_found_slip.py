"""The slip of a robot that is brought in is found from drives of it."""

import math

import numpy as np
import pytest

from mjsim.exchange.robots import likely, slip
from mjsim.geometry import wrap_angle
from mjsim.interface import Command, Odometry
from mjsim.sim import arc_end, slip_shares
from mjsim.world import Slip


def arcs(count: int, ticks: int, dt: float = 0.04) -> np.ndarray:
    """Return ways and turns of drives that change every 50 ticks, shape (count, ticks, 3)."""
    rng = np.random.default_rng(5)
    holds = rng.uniform([0.1, 0.0, -1.0], [0.8, 0.0, 1.0], (count, -(-ticks // 50), 3)) * dt
    return np.repeat(holds, 50, axis=1)[:, :ticks]


def driven(odometry: np.ndarray, first: float = 0.0) -> np.ndarray:
    """Return the poses after each tick, each an exact arc with a step to the left, headings wrapped."""
    poses = [[[0.0, 0.0, first]] for _ in odometry]
    for robot, drive in zip(poses, odometry.tolist(), strict=True):
        for distance, left, turn in drive:
            x, y, heading = robot[-1]
            at = complex(x, y) + (complex(*arc_end(distance, turn)) + 1j * left) * np.exp(1j * heading)
            robot.append([at.real, at.imag, wrap_angle(heading + turn)])
    return np.array(poses)


def test_the_turn_per_radian_of_odometry_is_found_across_half_turns():
    odometry = arcs(3, 500)
    true = odometry * [1.0, 1.0, 1.2]
    drives = slip.Drives(odometry, driven(true, first=3.0), 0.04)
    assert slip._turn(drives) == pytest.approx(1.2, rel=1e-9)
    assert drives.scaled(1.2).odometry == pytest.approx(true)


def test_the_centre_of_rotation_is_the_point_that_does_not_move_sideways():
    odometry = arcs(4, 500)
    creep = 0.03 * odometry[..., 0] * odometry[..., 2] / 0.04
    middle = driven(np.stack([odometry[..., 0], creep, odometry[..., 2]], axis=-1))
    drives = slip.Drives(odometry, middle, 0.04)
    assert slip._center(drives) == pytest.approx(0.0, abs=1e-3)
    # The origin lies 0.15 m behind that point.
    assert slip._center(drives.about(-0.15)) == pytest.approx(0.15, abs=1e-3)
    ahead = drives.about(0.5).poses - middle
    assert ahead[..., 0] == pytest.approx(0.5 * np.cos(middle[..., 2]))
    assert ahead[..., 1] == pytest.approx(0.5 * np.sin(middle[..., 2]))


def test_displacements_are_those_of_each_tick_in_the_frame_of_the_robot():
    odometry = arcs(2, 100)
    moved = slip._displacements(slip.Drives(odometry, driven(odometry, first=3.1), 0.04))
    chords = odometry[..., 0] * np.sinc(odometry[..., 2] / 2 / np.pi)
    assert moved == pytest.approx(np.stack([chords, np.zeros_like(chords), odometry[..., 2]], axis=-1), abs=1e-12)


def test_an_increment_is_split_along_its_arc():
    for distance, left, turn in ((0.1, 0.0, 0.3), (0.1, 0.02, -0.5), (0.2, -0.01, 0.0)):
        way = complex(*arc_end(1.0, turn)) * complex(distance, left)
        increment = Odometry(way.real, way.imag, turn, np.zeros((3, 3)))
        assert slip._along_the_arc(increment) == pytest.approx((distance, left, turn))


def test_commands_stay_below_what_a_robot_can():
    class Info:
        max_speed, max_turn, max_left = 1.0, 2.0, 0.0

    rng = np.random.default_rng(1)
    orders = [slip._some_command(Info, rng) for _ in range(300)]
    assert all(isinstance(each, Command) and each.left == 0.0 for each in orders)
    forward, turn = np.transpose([(each.forward, each.turn) for each in orders])
    assert (forward.min() >= 0.0, 0.65 < forward.max() <= 0.7) == (True, True)
    assert -1.0 <= turn.min() < -0.95 < 0.95 < turn.max() <= 1.0
    Info.max_left = 0.4
    left = [slip._some_command(Info, rng).left for _ in range(300)]
    assert -0.2 <= min(left) < -0.19 < 0.19 < max(left) <= 0.2


def test_jacobians_of_dead_reckoning_are_finite_differences():
    pose, step = np.array([[1.0, 2.0, 2.5]]), np.array([[0.3, 0.0, 0.4]])
    moved, by_pose, by_step = likely._stepped(pose, step)
    assert moved[0] == pytest.approx([*(driven(step[:, None], first=2.5)[0, 1, :2] + [1.0, 2.0]), 2.9])
    for axis in range(3):
        more = np.eye(3)[axis] * 1e-6
        ahead, behind = (likely._stepped(pose + sign * more, step)[0] for sign in (1, -1))
        assert by_pose[0, :, axis] == pytest.approx((ahead - behind)[0] / 2e-6, abs=1e-6)
    c, s = math.cos(2.5), math.sin(2.5)
    assert by_step[0] == pytest.approx(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))


def test_the_likelihood_of_a_slip_has_the_gradient_of_finite_differences():
    odometry = arcs(6, 40)
    poses = driven(odometry * [1.02, 1.0, 1.05])
    errors, shares = likely._reckoned(odometry, poses, dt=0.04)
    assert errors.shape == (24, 3)
    # All drives after 10 ticks, then after 20.
    ends = driven(odometry)[:, 10::10]
    assert errors == pytest.approx(np.concatenate(np.swapaxes(ends - poses[:, 10::10], 0, 1)), abs=1e-9)
    logs = np.log([0.02, 0.03, 0.04, 0.05, 0.03, 0.02])
    value, slope = likely._unlikely(logs, errors, shares, 6)
    steps = [
        (likely._unlikely(logs + more, errors, shares, 6)[0] - likely._unlikely(logs - more, errors, shares, 6)[0])
        / 2e-5
        for more in np.eye(6) * 1e-5
    ]
    assert slope == pytest.approx(steps, rel=1e-4, abs=1e-6)
    covariances = np.einsum("k,nkij->nij", np.exp(2 * logs), shares) + 1e-10 * np.eye(3)
    nees = [e @ np.linalg.solve(P, e) for e, P in zip(errors, covariances, strict=True)]
    uneven = np.log(np.reshape(nees, (4, 6)).mean(axis=1) / 3) ** 2
    assert value == pytest.approx(np.mean(np.log(np.linalg.det(covariances)) + nees) + 10 * uneven.mean())


def test_shares_of_a_pose_are_those_of_its_ticks_moved_along():
    odometry = arcs(1, 10)
    _, shares = likely._reckoned(odometry, driven(odometry), dt=0.04)
    ticks = slip_shares(odometry, dt=0.04)[0]
    ends = driven(odometry)[0]
    total = np.zeros((6, 3, 3))
    for tick in range(10):
        x, y = (ends[-1] - ends[tick + 1])[:2]
        c, s = math.cos(ends[tick, 2]), math.sin(ends[tick, 2])
        # A slip of a tick turns all that follows about where it ended.
        J = np.array([[1, 0, -y], [0, 1, x], [0, 0, 1]]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        total += np.array([J @ np.diag(part) @ J.T for part in ticks[tick]])
    assert shares[0] == pytest.approx(total, rel=1e-6, abs=1e-12)


def test_a_slip_is_found_again_from_drives_that_slip_so():
    true = Slip(forward=0.05, left=0.04, turn=0.1, outward=0.0001, surge=0.0001, swing=0.0001)
    odometry = arcs(30, 20)
    spread = np.sqrt(
        np.einsum("k,rtkj->rtj", np.array(list(true.model_dump().values())) ** 2, slip_shares(odometry, dt=0.04))
    )
    slipped = odometry + np.random.default_rng(2).normal(0.0, spread)
    again = likely.likely_slip(odometry, driven(slipped), dt=0.04)
    assert (again.forward, again.turn) == pytest.approx((0.05, 0.1), rel=0.35)
    assert all(value == float(f"{value:.3g}") for value in again.model_dump().values())
