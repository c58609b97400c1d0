"""Dead reckoning: its pose and covariance against derivatives that are taken numerically."""

import numpy as np
import pytest

from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Odometry
from mjsim.run.pilot import DeadReckoning
from mjsim.world import parse_world

STEP = 1e-6


@pytest.fixture(scope="module")
def robot():
    from mjsim import Simulation

    with Simulation(parse_world("mjsim: 1\nrobots: [{name: r, at: [1, 2], heading_deg: 35}]")) as sim:
        return sim.robots["r"]


def moved(state, increment):
    """Return the pose after an increment, written out: forward along the heading, left across it."""
    x, y, heading = state
    forward, left, turn = increment
    return np.array(
        [
            x + forward * np.cos(heading) + left * np.cos(heading + np.pi / 2),
            y + forward * np.sin(heading) + left * np.sin(heading + np.pi / 2),
            heading + turn,
        ]
    )


def slope(function, at):
    columns = [(function(at + step) - function(at - step)) / (2 * STEP) for step in np.eye(3) * STEP]
    return np.stack(columns, axis=-1)


def test_the_covariance_of_dead_reckoning_follows_from_numerical_derivatives(robot):
    rng = np.random.default_rng(2)
    reckoning = DeadReckoning(robot)
    state, P = robot.prior.as_array(), np.array(robot.prior_covariance, dtype=float)
    for _ in range(20):
        increment, root = rng.uniform(-0.5, 0.5, 3), rng.uniform(-0.1, 0.1, (3, 3))
        Q = root @ root.T
        F = slope(lambda at, by=increment: moved(at, by), state)
        G = slope(lambda by, at=state: moved(at, by), increment)
        P, state = F @ P @ F.T + G @ Q @ G.T, moved(state, increment)
        reckoning.add(Odometry(*increment, Q))
        np.testing.assert_allclose(reckoning.pose.as_array()[:2], state[:2], atol=1e-12)
        assert wrap_angle(reckoning.pose.heading - state[2]) == pytest.approx(0.0, abs=1e-12)
        np.testing.assert_allclose(reckoning.covariance, P, atol=1e-8)


def test_dead_reckoning_begins_at_the_prior_and_leaves_it_as_it_is(robot):
    reckoning = DeadReckoning(robot)
    assert reckoning.pose == robot.prior
    before = np.array(robot.prior_covariance, dtype=float)
    reckoning.covariance += 1.0
    np.testing.assert_array_equal(robot.prior_covariance, before)


def test_a_heading_that_is_uncertain_moves_the_position_across_the_way(robot):
    reckoning = DeadReckoning(robot)
    reckoning.pose, reckoning.covariance = Pose(0.0, 0.0, 0.0), np.diag([0.0, 0.0, 0.01])
    reckoning.add(Odometry(2.0, 0.0, 0.0, np.zeros((3, 3))))
    # 0.1 rad over 2 m is 0.2 m to the left for a turn to the left.
    np.testing.assert_allclose(reckoning.covariance, [[0, 0, 0], [0, 0.04, 0.02], [0, 0.02, 0.01]], atol=1e-15)
