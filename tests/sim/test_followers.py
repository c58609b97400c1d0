"""The ways on which joints of mechanisms are led."""

import numpy as np

from mjsim.sim.mechanisms.followers import MAX_JOINT_SPEED, Blend


def ways_of(blend):
    """Return value, speed and acceleration at a thousand times, shape (1000, 3)."""
    return np.array([blend.at(time) for time in np.linspace(1.0, 1.0 + blend.seconds, 1000)])


def test_a_joint_comes_from_where_it_was_without_a_jump_and_rests_at_its_goal():
    rng = np.random.default_rng(0)
    for value, speed, change in rng.uniform([-3.0, -4.0, -9.0], [3.0, 4.0, 9.0], (6, 3)):
        blend = Blend.to(0.0, begin=1.0, value=value, speed=speed, change=change)
        ways = ways_of(blend)
        np.testing.assert_allclose(ways[0], [value, speed, change], atol=1e-9)
        np.testing.assert_allclose(ways[-1], 0.0, atol=1e-9)
        # Speeds are the slopes of the places, by central differences of a thousand steps.
        slopes = np.gradient(ways[:, 0], blend.seconds / 999)
        np.testing.assert_allclose(slopes[1:-1], ways[1:-1, 1], atol=2e-3)


def test_a_joint_that_moves_away_from_its_goal_turns_round_no_faster_than_it_was_or_a_radian_a_second():
    rng = np.random.default_rng(1)
    for value, speed in rng.uniform([0.01, 0.0], [3.0, 4.0], (6, 2)):
        ways = ways_of(Blend.to(0.0, begin=1.0, value=value, speed=speed, change=0.0))
        # Its speed is looked at in 101 places; between them it may be greater by less than a thousandth.
        assert np.abs(ways[:, 1]).max() < 1.001 * max(MAX_JOINT_SPEED, speed)
