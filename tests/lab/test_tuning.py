"""Tuning rules give the numbers of their sources."""

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.lab.formula import formula_plant
from mjsim.lab.pid_rules import RULES

FOPDT = "num: [1], den: [1, 1], delay: 2"
"""exp(-2 s) / (s + 1)."""
SLOW = "num: [1], den: [10, 1], delay: 1"
THREE = "num: [6], den: [1, 6, 11, 6]"


def lags(*constants: float, num: str = "1") -> str:
    den = np.atleast_1d(1.0)
    for constant in constants:
        den = np.polymul(den, [constant, 1.0])
    return f"num: [{num}], den: {den.tolist()}"


def tuned(rule: str, tf: str) -> tuple[float, float, float]:
    world = mjsim.parse_world(f"mjsim: 1\nplants: [{{name: p, tf: {{{tf}}}}}]\n")
    return RULES[rule](formula_plant(world.plants[0]))


PERIOD = 2 * np.pi / np.sqrt(11.0)


@pytest.mark.parametrize(
    ("rule", "plant", "expected"),
    [
        # Ultimate gain 10, ultimate period 2 pi / sqrt(11).
        ("ziegler-nichols", THREE, (6.0, PERIOD / 2, PERIOD / 8)),
        ("tyreus-luyben", THREE, (10 / 2.2, 2.2 * PERIOD, PERIOD / 6.3)),
        # Cohen and Coon, by hand with r = 2 and r = 0.1.
        ("cohen-coon", FOPDT, (11 / 12, 2 * 44 / 29, 8 / 15)),
        ("cohen-coon", SLOW, (13.583333, 32.6 / 13.8, 4 / 11.2)),
        # Skogestad 2003, section 5 and his table of examples E1, E4, E5 and E7.
        ("simc", FOPDT, (0.25, 1.0, 0.0)),
        ("simc", SLOW, (5.0, 8.0, 0.0)),
        ("simc", lags(1, 0.2), (5.5, 0.8, 0.0)),
        ("simc", lags(1, 1, 1, 1), (0.3, 1.5, 0.0)),
        ("simc", lags(1, 0.2, 0.04, 0.008), (1.1 / 0.296, 1.1, 0.0)),
        ("simc", lags(1, 1, 1, num="-2, 1"), (1.5 / 7, 1.5, 0.0)),
        # His examples E2, E3 and E13 have zeros in the left half plane: 0.08 beside 0.2, 15 beside 20, 2 beside 10.
        ("simc", lags(2, 1, 0.4, 0.2, 0.05, 0.05, 0.05, num="-0.024, -0.22, 1"), (2.5 / 2.94, 2.5, 0.0)),
        ("simc", lags(20, 1, 0.1, 0.1, num="30, 2"), (1.05 / (1.5 * 0.3), 1.05, 0.0)),
        ("simc", lags(10, 0.5, num="2, 1") + ", delay: 1", (4.5 / (0.625 * 2.5), 4.5, 0.0)),
        # Zeros larger than all lags, by T1, T1a and T1b: 3 / 2 with a lag of 1 left; 3 / theta; 1.
        ("simc", lags(2, 1, num="3, 1") + ", delay: 0.5", (1 / 1.5, 1.0, 0.0)),
        ("simc", lags(1, 0.1, num="3, 1") + ", delay: 2", (0.1 / (1.5 * 4), 0.1, 0.0)),
        ("simc", lags(1, 0.1, num="1.5, 1") + ", delay: 2", (0.1 / 4, 0.1, 0.0)),
        # 1.1 is closer to 1 than to 20 and less than 1.6 times it: T1 takes 1.
        ("simc", lags(20, 1, num="1.1, 1") + ", delay: 0.2", (20 / (1.1 * 0.4), 1.6, 0.0)),
        # Half of 1 / 2 is added to 1, half counts as dead time with 1 / 3.
        ("simc", THREE, (1.25 / (7 / 6), 1.25, 0.0)),
        # An integrator with a dead time: gain 1 / (2 theta), integral time 8 theta.
        ("simc", "num: [2], den: [1, 0], delay: 0.5", (0.5, 4.0, 0.0)),
        # His example E6, (0.17 s + 1)^2 / (s (s + 1)^2 (0.028 s + 1)): theta = 1.69, gain 0.296, integral time 13.5.
        ("simc", "num: [0.0289, 0.34, 1], den: [0.028, 1.056, 2.028, 1, 0]", (0.5 / 1.688, 8 * 1.688, 0.0)),
    ],
)
def test_a_rule_gives_the_parameters_of_its_source(rule, plant, expected):
    assert tuned(rule, plant) == pytest.approx(expected, rel=1e-4)


def test_what_oscillates_is_tuned_by_its_step_response():
    # Of 1 / (s^2 + s + 1) the steepest tangent, at t with y'' = 0, has the slope exp(-pi / (3 sqrt(3))).
    gain, ti, _ = tuned("simc", "num: [1], den: [1, 1, 1]")
    steep = 2 * np.pi / (3 * np.sqrt(3.0))
    slope = 2 / np.sqrt(3) * np.exp(-steep / 2) * np.sin(np.sqrt(3) / 2 * steep)
    constant = 1 / slope
    rise = 1 - np.exp(-steep / 2) * (np.cos(np.sqrt(3) / 2 * steep) + np.sin(np.sqrt(3) / 2 * steep) / np.sqrt(3))
    dead = steep - rise * constant
    assert (gain, ti) == pytest.approx((constant / (2 * dead), min(constant, 8 * dead)), rel=1e-3)


def test_a_gain_that_makes_a_delayed_lag_oscillate_is_found_without_an_approximation():
    # exp(-s) / s oscillates at pi / 2 with a period of 4 s.
    gain, ti, td = tuned("ziegler-nichols", "num: [1], den: [1, 0], delay: 1")
    assert (gain, ti, td) == pytest.approx((0.6 * np.pi / 2, 2.0, 0.5), rel=1e-9)


def test_the_ultimate_gain_is_the_least_of_all_crossings():
    # 4 w + atan(w) = pi at 0.6426 rad/s, gain 0.5943; the next crossing, gain 1.152, is nearer to 1.
    w = 0.6426
    for _ in range(50):
        w = (np.pi - np.arctan(w)) / 4
    gain, ti, _ = tuned("ziegler-nichols", "num: [2], den: [1, 1], delay: 4")
    assert (gain, ti) == pytest.approx((0.6 * np.hypot(w, 1.0) / 2, np.pi / w), rel=1e-6)


def test_a_rule_for_dead_time_says_that_there_is_none():
    with pytest.raises(UsageError, match="the plant has no dead time, which this rule needs; use the rule simc"):
        tuned("cohen-coon", "num: [1], den: [1, 1]")
