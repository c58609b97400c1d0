"""Eleven kinds of plants: Bode, margins and the marks of the locus by another way, from numerators and denominators."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.lab.test_locus import studied

PLANTS = {
    "lag, short delay": ([2.0], [5, 1], 0.3, 0.0),
    "lag, long delay": ([2.0], [1, 1], 4.0, 0.0),
    "integrator, delay": ([0.7], [1, 0], 0.8, 0.0),
    "integrator, lags": ([1.0], [0.5, 1.5, 1, 0], 0.0, 0.0),
    "zero on the right": ([-1.0, 2], [1, 3, 3, 1], 0.0, 0.0),
    "zeros on the left": ([0.3, 1.3, 1], [2, 7, 7, 2, 0.2], 0.5, 0.0),
    "three lags": ([3.0], [2, 7, 7, 2], 0.0, 0.0),
    "four lags": ([1.0], [1, 4, 6, 4, 1], 0.0, 0.0),
    "swings": ([5.0], [1, 0.4, 4], 0.2, 0.0),
    "unstable": ([2.0, 4], [1, 2, -3], 0.0, 0.0),
    "sampled": ([0.4, 0.3], [1, -1.3, 0.4], 0.0, 0.1),
}
"""Numerator, denominator, delay [s] and sampling period, 0 for continuous time [s]."""


def response(name, omega):
    """Return the response of a plant, by its polynomials and its exact delay."""
    num, den, delay, dt = PLANTS[name]
    s = np.exp(1j * np.asarray(omega) * dt) if dt else 1j * np.asarray(omega)
    return np.polyval(num, s) / np.polyval(den, s) * np.exp(-1j * np.asarray(omega) * delay)


def searched(name):
    """Return gains and frequencies of all crossings of the negative axis, and phase margins of those of 1."""
    omega = np.geomspace(1e-4, 0.9999 * math.pi / PLANTS[name][3] if PLANTS[name][3] else 200.0, 60_001)
    value = response(name, omega)
    axis = np.flatnonzero((np.diff(np.sign(value.imag)) != 0) & (value.real[1:] < 0))
    unit = np.flatnonzero(np.diff(np.sign(np.abs(value) - 1.0)) != 0)
    turned = [brentq(lambda w: response(name, w).imag, omega[k], omega[k + 1], xtol=1e-14) for k in axis]
    crossed = [brentq(lambda w: abs(response(name, w)) - 1.0, omega[k], omega[k + 1], xtol=1e-14) for k in unit]
    phases = [math.degrees(math.remainder(float(np.angle(-response(name, w))), 2 * math.pi)) for w in crossed]
    return [1.0 / abs(response(name, w)) for w in turned], turned, phases, crossed


@pytest.fixture(scope="module", params=list(PLANTS))
def plant(request):
    num, den, delay, dt = PLANTS[request.param]
    extra = (f", delay: {delay}" if delay else "") + (f", dt: {dt}" if dt else "")
    return request.param, studied(f"tf: {{num: {num}, den: {den}{extra}}}")


def test_bode_is_that_of_the_polynomials(plant):
    name, study = plant
    expected = response(name, study.omega)
    np.testing.assert_allclose(study.magnitude, np.abs(expected), rtol=1e-6)
    np.testing.assert_allclose(np.exp(1j * study.phase), expected / np.abs(expected), atol=1e-6)


def test_margins_are_those_of_a_search(plant):
    name, study = plant
    gains, turned, phases, crossed = searched(name)
    found = study.margins
    if gains:
        best = min(range(len(gains)), key=lambda k: abs(math.log(gains[k])))
        assert (found["gain_margin"], found["phase_crossover"]) == pytest.approx((gains[best], turned[best]), rel=1e-5)
    else:
        assert found["gain_margin"] is None or name == "unstable"
    if phases:
        best = min(range(len(phases)), key=lambda k: abs(phases[k]))
        expected = pytest.approx((phases[best], crossed[best]), rel=1e-5, abs=1e-4)
        assert (found["phase_margin_deg"], found["gain_crossover"]) == expected
    else:
        assert found["phase_margin_deg"] is None


def test_crossings_of_the_locus_are_those_of_the_negative_axis(plant):
    name, study = plant
    gains, turned, _, _ = searched(name)
    dt = PLANTS[name][3]
    for mark in study.locus.crossings:
        at = abs(np.angle(mark.point)) / dt if dt else abs(mark.point.imag)
        if at < 1e-6 or (dt and at > 0.9999 * math.pi / dt):  # on the real axis: 1 + k G = 0 itself
            assert 1.0 + mark.gain * response(name, at).real == pytest.approx(0.0, abs=1e-6)
            continue
        nearest = int(np.argmin(np.abs(np.array(turned) - at)))
        assert (at, mark.gain) == pytest.approx((turned[nearest], gains[nearest]), rel=1e-5)
    inside = [w for w in turned if w < 0.9 * study.locus.extent]
    shown = {round(abs(mark.point.imag), 4) for mark in study.locus.crossings}
    assert dt or all(any(abs(w - other) < 1e-3 for other in shown) for w in inside)


def unstable_poles(name):
    """Return the number of poles of the loop of gain 1 that grow: roots, or by the argument along a half circle."""
    num, den, delay, dt = PLANTS[name]
    if not delay:
        roots = np.roots(np.polyadd(num, den))
        return int((np.abs(roots) > 1.0).sum() if dt else (roots.real > 0.0).sum())
    w = np.linspace(-300.0, 300.0, 400_001)
    s = np.concatenate([1e-4 + 1j * w, 1e-4 + 300.0 * np.exp(1j * np.linspace(np.pi / 2, -np.pi / 2, 1001))])
    value = 1.0 + np.polyval(num, s) / np.polyval(den, s) * np.exp(-s * delay)
    turns = np.angle(value[1:] / value[:-1]).sum() / (2.0 * np.pi)
    return round(-turns) + int((np.roots(den).real > 1e-4).sum())


def test_whether_the_loop_of_gain_1_is_stable_is_told(plant):
    name, study = plant
    assert study.is_stable_closed == (unstable_poles(name) == 0)


@pytest.mark.parametrize(
    ("formula", "begins"),
    [
        ("{num: [1], den: [1, 0, 0]}", -180.0),
        ("{num: [1], den: [1, 3, 3, 1, 0, 0, 0]}", -270.0),
        ("{num: [-1], den: [1, 1]}", 180.0),
        ("{num: [1, 0], den: [1, 1]}", 90.0),
    ],
)
def test_a_phase_begins_at_90_degrees_below_0_for_each_integrator(formula, begins):
    assert math.degrees(studied(f"tf: {formula}").phase[0]) == pytest.approx(begins, abs=2.0)
