"""Gates are the quantiles of chi-square that they are said to be."""

import pytest
from scipy.stats import chi2

from mjsim.algorithms import fastslam
from mjsim.algorithms.beacon_vision import planar_pose
from mjsim.algorithms.estimation import look_checks, relocation
from mjsim.algorithms.scans import odometry_delay, scan_search


@pytest.mark.parametrize(
    ("gate", "freedom", "share"),
    [
        (fastslam.GATE, 2, 0.999),
        (look_checks.GATE, 2, 0.999),
        (odometry_delay.MIDDLE, 1, 0.5),
        (planar_pose.LIKELY_MISFIT, 2, 0.99),
        (relocation.AGREES, 2, 0.95),
        (relocation.STEADY_GATE, 2, 0.99),
        (scan_search.GATE, 3, 0.999),
        (scan_search.QUANTILE, 3, 0.9),
    ],
)
def test_a_gate_accepts_the_share_of_correct_values_that_it_is_said_to(gate, freedom, share):
    assert gate == pytest.approx(chi2.ppf(share, freedom), rel=0.01)
