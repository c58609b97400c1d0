"""Motion between the ticks of a log: its covariance by closed forms and numerical derivatives, gaps and restarts."""

import numpy as np
import pytest

from mjsim.logs.resampling.resample import (
    MAX_TRUTH_GAP,
    MAX_TRUTH_STEPS,
    PIVOT_DEVIATION,
    UNKNOWN,
    MotionNoise,
    continuous,
    joined,
    longest_gap,
    motions,
    restarts_of,
    track_motions,
    track_of,
    unknown_motion,
)

NOISE = MotionNoise(distance=0.03, turn=0.05, veer=0.02, aside=0.007)
EDGES = np.array([0.0, 0.5])


def one(forward, turn, left=0.0, noise=NOISE):
    """Return the motion of half a second under one twist."""
    return motions(np.array([[0.0, forward, turn, left]]), EDGES, noise)[0]


def test_straight_ahead_each_variance_is_its_constant_squared_times_the_metres():
    P = one(0.8, 0.0).covariance
    d = 0.4
    assert P[0, 0] == pytest.approx(0.03**2 * d)
    assert P[2, 2] == pytest.approx(0.02**2 * d)
    # The heading grows along the way: half of its error times the way is the error to the side.
    assert P[1, 1] == pytest.approx(0.007**2 * d + 0.02**2 * d * (d / 2) ** 2)
    assert P[1, 2] == pytest.approx(0.02**2 * d * d / 2)
    assert P[0, 1] == P[0, 2] == 0.0


@pytest.mark.parametrize("turn", [1.2, -1.2])
def test_on_the_spot_the_heading_errs_with_the_radians_and_the_place_by_the_pivot(turn):
    P = one(0.0, turn).covariance
    np.testing.assert_allclose(
        P, np.diag([PIVOT_DEVIATION**2 * 0.6, PIVOT_DEVIATION**2 * 0.6, 0.05**2 * 0.6]), atol=1e-15
    )


def test_on_an_arc_the_covariance_is_that_of_its_numerical_derivatives():
    step, way, turn = 1e-6, 0.4, 0.45

    def end(length, angle):
        point = length * (np.exp(1j * angle) - 1.0) / (1j * angle)
        return np.array([point.real, point.imag, angle])

    J = np.stack(
        [
            (end(way + step, turn) - end(way - step, turn)) / (2 * step),
            (end(way, turn + step) - end(way, turn - step)) / (2 * step),
        ],
        axis=-1,
    )
    Q = np.diag([0.03**2 * way, 0.05**2 * turn + 0.02**2 * way])
    added = np.diag([PIVOT_DEVIATION**2 * turn, 0.007**2 * way + PIVOT_DEVIATION**2 * turn, 0.0])
    np.testing.assert_allclose(one(0.8, 0.9).covariance, J @ Q @ J.T + added, atol=1e-10)


def test_a_way_to_the_side_is_the_same_arc_turned_to_the_left():
    ahead, aside = one(0.8, 0.9), one(0.0, 0.9, left=0.8)
    np.testing.assert_allclose([aside.forward, aside.left], [-ahead.left, ahead.forward], atol=1e-12)
    assert one(0.3, 0.0, left=0.4).covariance[0, 0] == pytest.approx(0.03**2 * 0.25)


def test_turns_to_both_sides_add_up_in_the_variance_and_not_in_the_heading():
    both = motions(np.array([[0.0, 0.0, 1.0], [0.25, 0.0, -1.0]]), EDGES, NOISE)[0]
    assert both.turn == pytest.approx(0.0, abs=1e-12)
    assert both.covariance[2, 2] == pytest.approx(0.05**2 * 0.5)


def test_before_the_first_twist_a_robot_stands_still():
    first, second = motions(np.array([[0.75, 1.0, 0.0]]), np.array([0.0, 0.5, 1.0]), NOISE)
    assert (first.forward, first.covariance[0, 0]) == (0.0, 0.0)
    assert second.forward == pytest.approx(0.25)


def test_poses_of_odometry_give_each_step_in_the_frame_of_its_beginning_with_the_noise_of_its_length():
    track = np.array([[0.0, 1.0, 2.0, np.pi / 2], [1.0, 1.0, 2.6, np.pi / 2], [2.0, 0.8, 2.6, np.pi / 2 - 0.3]])
    first, second = track_motions(track, np.array([0.0, 1.0, 2.0]), NOISE)
    np.testing.assert_allclose([first.forward, first.left, first.turn], [0.6, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose([second.forward, second.left, second.turn], [0.0, 0.2, -0.3], atol=1e-12)
    assert first.covariance[0, 0] == pytest.approx(0.03**2 * 0.6)
    assert second.covariance[2, 2] == pytest.approx(0.05**2 * 0.3 + 0.02**2 * 0.2)
    still = track_motions(track[:1], np.array([0.0, 1.0]), NOISE)[0]
    np.testing.assert_array_equal([still.forward, still.left, still.turn, *still.covariance.ravel()], 0.0)


def test_a_log_without_odometry_walks_at_random_in_proportion_to_time():
    for dt in (0.04, 0.2):
        step = unknown_motion(dt)
        np.testing.assert_allclose(step.covariance, np.diag(np.square(UNKNOWN) * dt))
        assert (step.forward, step.left, step.turn) == (0.0, 0.0, 0.0)


def test_twists_are_integrated_from_the_origin():
    track = track_of(np.array([[1.0, 1.0, np.pi / 2], [2.0, 0.5, 0.0], [4.0, 0.0, 0.0]]))
    radius = 2.0 / np.pi
    np.testing.assert_allclose(track[0], [1.0, 0.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(track[1], [2.0, radius, radius, np.pi / 2], atol=1e-12)
    np.testing.assert_allclose(track[2], [4.0, radius, radius + 1.0, np.pi / 2], atol=1e-12)


def walk():
    """Return odometry at 0.1 m a tenth of a second, which begins again at the origin after 20 rows."""
    rows = np.array([[0.1 * k, 0.1 * (k % 20), 0.0, 0.1 if k < 20 else 0.0] for k in range(40)])
    rows[:20, 1] += 3.0
    return rows


def test_odometry_that_begins_again_goes_on_where_it_was():
    track = walk()
    np.testing.assert_array_equal(restarts_of(track), [20])
    whole, said = continuous(track)
    assert said == "1; it begins again at 2.000 s"
    np.testing.assert_allclose(whole[20, 1:], track[19, 1:], atol=1e-12)
    # The second part lies along the heading at the end of the first.
    np.testing.assert_allclose(whole[39, 1:3] - whole[20, 1:3], 1.9 * np.array([np.cos(0.1), np.sin(0.1)]), atol=1e-12)
    np.testing.assert_allclose(whole[20:, 3], 0.1)
    np.testing.assert_array_equal(joined(track, restarts_of(track)), whole)
    assert track[20, 1] == 0.0, "the given rows stay"


def test_jumps_that_are_no_restart_and_steady_motion_stay():
    track = walk()
    track[20:, 1:3] += 50.0
    assert continuous(track)[1] == ""
    np.testing.assert_array_equal(continuous(track)[0], track)
    assert len(restarts_of(walk()[:20])) == 0
    assert len(restarts_of(walk()[19:21])) == 0
    slow = walk()
    slow[:, 0] *= 10.0  # the jump of 4.9 m lasts a second: no faster than 5 m/s
    assert len(restarts_of(slow)) == 0


def test_truth_is_interpolated_over_so_many_of_its_usual_steps():
    assert longest_gap(None) == MAX_TRUTH_GAP
    assert longest_gap(np.zeros((1, 8))) == MAX_TRUTH_GAP
    assert longest_gap(np.arange(5.0)[:, None]) == MAX_TRUTH_STEPS
    assert longest_gap(np.arange(5.0)[:, None] * 1e-3) == MAX_TRUTH_GAP
