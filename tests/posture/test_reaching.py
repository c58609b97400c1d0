"""Hands that are led: they get there, the feet stay, and what is out of reach is said."""

import mink
import numpy as np
import pytest

from mjsim.people import Figure, Measures
from mjsim.posture import LED, lead_hands

FIGURE = Figure.of(Measures.at_percentile("female", 50.0))
ROOT = FIGURE.upright
GRIP = f"left_{LED}"


def spots(values):
    return FIGURE.spots(FIGURE.poses(values, ROOT))


@pytest.mark.parametrize("at", [(0.4, 0.3, 1.1), (0.5, -0.1, 1.4), (0.1, 0.3, 1.8), (0.1, 0.5, 0.9)])
def test_a_hand_gets_where_it_is_led_within_the_ranges_of_joints_and_the_legs_stay(at):
    before = FIGURE.at_ease
    found = lead_hands(FIGURE, before, ROOT, {"left": np.array(at)})
    assert found.short == {}
    np.testing.assert_allclose(spots(found.values)[GRIP], at, atol=1e-4)
    lower, upper = FIGURE.limits.T
    assert np.all((found.values >= lower - 1e-9) & (found.values <= upper + 1e-9))
    np.testing.assert_allclose(spots(found.values)["left_heel"], spots(before)["left_heel"], atol=1e-6)


def test_a_hand_that_does_not_get_there_comes_near_and_says_how_far_it_is():
    at = np.array([3.0, 0.2, 1.2])
    found = lead_hands(FIGURE, FIGURE.at_ease, ROOT, {"left": at})
    assert found.short["left"] == pytest.approx(np.linalg.norm(spots(found.values)[GRIP] - at), abs=1e-6)
    assert found.short["left"] < np.linalg.norm(spots(FIGURE.at_ease)[GRIP] - at) - 0.5


def test_the_cost_of_a_hand_that_does_not_get_there_is_bounded(monkeypatch):
    steps, solved = [], mink.solve_ik
    monkeypatch.setattr(mink, "solve_ik", lambda *given, **more: steps.append(1) or solved(*given, **more))
    for at, most in (((3.0, 0.2, 1.2), 60), ((0.9, 0.3, 1.2), 120)):
        steps.clear()
        assert lead_hands(FIGURE, FIGURE.at_ease, ROOT, {"left": np.array(at)}).short
        assert len(steps) <= most


def test_a_hand_that_is_led_nowhere_leaves_all_joints_as_they_are():
    before = FIGURE.at_ease
    found = lead_hands(FIGURE, before, ROOT, {"left": spots(before)[GRIP]})
    np.testing.assert_allclose(found.values, before, atol=1e-5)
