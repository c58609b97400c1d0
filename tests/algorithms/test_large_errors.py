"""A robot whose odometry or sensor errs by far more than stated is not sure of a wrong pose."""

import numpy as np
import pytest

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.bench import disturbed
from mjsim.bench.disturbed import CASES


class WithoutLarge(EkfSlam):
    """As if data sheets were right."""

    def start(self, *given):
        super().start(*given)
        self._rivals._wide = None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "share"),
    [
        ("turns by 0.5 degrees per second", 0.35),
        ("bearings off by 2 degrees", 0.35),
        ("ranges 4 % long", 0.35),
        ("turns 10 % short", 0.8),
    ],
)
def test_a_robot_whose_sensors_err_by_more_than_stated_is_surely_wrong_for_less_long(case, share):
    room, _ = CASES[case]
    runs = [disturbed.drive({"slam": EkfSlam(), "sure": WithoutLarge()}, seed, room=room) for seed in (1, 10)]
    wrong = {name: np.sum([run[name].surely_wrong() for run in runs]) for name in ("slam", "sure")}
    error = {name: np.mean([run[name].position.mean() for run in runs]) for name in ("slam", "sure")}
    assert wrong["slam"] < share * wrong["sure"]
    assert error["slam"] < 1.02 * error["sure"]


@pytest.mark.slow
def test_large_errors_are_never_believed_and_change_no_pose_where_there_are_none():
    for seed in range(2):
        run = disturbed.drive({"slam": EkfSlam(), "sure": WithoutLarge()}, seed)
        np.testing.assert_array_equal(run["slam"].position, run["sure"].position)
