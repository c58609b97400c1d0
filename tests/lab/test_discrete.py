"""Plants in discrete time, as zeros, poles and a gain, and with limited inputs, against closed forms and scipy."""

import math

import control
import numpy as np
import pytest
from scipy import signal
from scipy.optimize import brentq

from mjsim.errors import UsageError, WorldError
from mjsim.lab.closed import closed_loop, limited
from mjsim.lab.design import lead_design, lqr_design, pid_design, placed_design
from mjsim.lab.experiment import experiment
from mjsim.lab.formula import formula_plant
from mjsim.lab.formula_loop import FormulaLoop, is_simulated
from mjsim.lab.plant_page import _facts, figures_of
from mjsim.lab.plant_plots import tables
from mjsim.lab.plant_study import study
from mjsim.world import format_world, parse_world


def plant_of(text):
    (plant,) = parse_world(f"mjsim: 1\nplants: [{{name: p, {text}}}]\n").plants
    return plant


def linear_of(text):
    return formula_plant(plant_of(text))


LAG = "tf: {num: [0.2], den: [1, -0.8], dt: 0.5}"
"""0.2 / (z - 0.8) has the step response 1 - 0.8^k."""


def test_the_step_of_a_sampled_lag_is_a_geometric_series():
    found = study(linear_of(LAG), seconds=10.0)
    k = np.arange(21)
    np.testing.assert_allclose(found.time, 0.5 * k)
    np.testing.assert_allclose(found.step[0], 1.0 - 0.8**k, atol=1e-12)
    # To an impulse of area 1, 1 / dt high in the first period.
    np.testing.assert_allclose(found.impulse[0], np.where(k, 0.2 * 0.8 ** (k - 1.0), 0.0) / 0.5, atol=1e-12)
    assert found.is_stable


def test_a_sampled_response_reaches_nyquists_frequency():
    found = study(linear_of("tf: {num: [1, 0.5], den: [1, -1.2, 0.72], dt: 0.1, delay: 0.2}"))
    assert found.omega[-1] == pytest.approx(math.pi / 0.1)
    z = np.exp(0.1j * found.omega)
    value = (z + 0.5) / (z**2 - 1.2 * z + 0.72) / z**2
    np.testing.assert_allclose(found.magnitude * np.exp(1j * found.phase), value, rtol=1e-9)


def test_margins_of_a_sampled_lag_are_those_of_its_formula():
    # -K 0.2 / (z - 0.8) first reaches -1 at z = -1: K = 1.8 / 0.2.
    found = study(linear_of(LAG)).margins
    assert found["gain_margin"] == pytest.approx(9.0)
    assert found["phase_crossover"] == pytest.approx(math.pi / 0.5)
    assert found["phase_margin_deg"] is None
    # |2 / (z - 0.8)| = 1: 1.64 - 1.6 cos = 4.
    found = study(linear_of("tf: {num: [2], den: [1, -0.8], dt: 0.5}")).margins
    assert found["gain_margin"] == pytest.approx(0.9)
    assert found["phase_margin_deg"] is None


@pytest.mark.parametrize("delay", [0.0, 0.3])
@pytest.mark.parametrize("gain", [0.4, 3.0])
def test_margins_of_sampled_loops_are_those_of_a_search(gain, delay):
    found = study(linear_of(f"zpk: {{zeros: [-0.6], poles: [1, 0.7], gain: {gain}, dt: 0.1, delay: {delay}}}")).margins

    def value(omega):
        z = np.exp(0.1j * omega)
        return gain * (z + 0.6) / ((z - 1) * (z - 0.7)) * z ** -round(delay / 0.1)

    def root(function):
        grid = np.linspace(1e-3, 10 * math.pi * 0.9999, 3000)
        signs = np.flatnonzero(np.diff(np.sign(function(grid))))
        return [brentq(function, grid[k], grid[k + 1], xtol=1e-12) for k in signs]

    turned = [at for at in root(lambda at: value(at).imag) if value(at).real < 0.0]
    # At Nyquist's frequency the response is real.
    turned += [10 * math.pi] if value(10 * math.pi).real < 0.0 else []
    gains = {1 / abs(value(at)): at for at in turned}
    best = min(gains, key=lambda each: abs(math.log(each)), default=None)
    assert found["gain_margin"] == (None if best is None else pytest.approx(best, rel=1e-6))
    phases = [math.degrees(np.angle(-value(at))) for at in root(lambda at: np.abs(value(at)) - 1.0)]
    assert found["phase_margin_deg"] == pytest.approx(min(phases, key=abs), abs=1e-5)


def test_a_sampled_locus_leaves_the_unit_circle_where_its_formula_says():
    # z^2 - 1.7 z + 0.7 + K: the product of a conjugate pair is 0.7 + K, so it is on the circle at K = 0.3.
    locus = study(linear_of("zpk: {poles: [1, 0.7], gain: 1, dt: 0.1}")).locus
    pair = [mark for mark in locus.crossings if mark.point.imag]
    assert [mark.gain for mark in pair] == pytest.approx([0.3, 0.3])
    np.testing.assert_allclose([abs(mark.point) for mark in pair], 1.0, rtol=1e-12)
    assert abs(pair[0].point.real) == pytest.approx(0.85)
    (meeting,) = locus.breakaways
    assert (meeting.gain, meeting.point) == (pytest.approx(0.0225), pytest.approx(0.85))
    assert locus.extent >= 1.35


def test_zeros_poles_and_gain_are_the_transfer_function():
    linear = linear_of("zpk: {zeros: [-3], poles: [0, -1+2i, -1-2j, -8], gain: 12}")
    system = control.ss(*linear.parts)
    np.testing.assert_allclose(np.sort_complex(system.poles()), [-8, -1 - 2j, -1 + 2j, 0], atol=1e-9)
    for s in (0.3j, 2.0 + 1j, 40j):
        assert complex(system(s)) == pytest.approx(12 * (s + 3) / (s * (s + 8) * ((s + 1) ** 2 + 4)))


@pytest.mark.slow
def test_twenty_equal_poles_stay_where_they_are():
    poles = study(linear_of(f"zpk: {{poles: [{', '.join(['-1'] * 20)}], gain: 1}}")).poles
    np.testing.assert_allclose(poles, -1.0, atol=1e-7)


@pytest.mark.slow
def test_a_design_of_discrete_time_has_its_closed_loop():
    linear = linear_of("ss: {a: [[1, 0.1], [0, 1]], b: [[0.005], [0.1]], c: [[1, 0]], dt: 0.1}")
    placed = placed_design(linear, [0.8 + 0.1j, 0.8 - 0.1j])
    np.testing.assert_allclose(placed.poles, [0.8 - 0.1j, 0.8 + 0.1j], atol=1e-9)
    assert placed.is_stable
    found = lqr_design(linear, [1.0, 1.0], 1.0)
    P = np.asarray(control.dare(linear.A, linear.B, np.eye(2), np.eye(1))[0])
    K = np.linalg.solve(1.0 + linear.B.T @ P @ linear.B, linear.B.T @ P @ linear.A)
    np.testing.assert_allclose(found.gain, K[0], rtol=1e-9)
    lead = lead_design(linear, margin_deg=45.0, crossover=2.0)
    assert lead.margins["phase_margin_deg"] == pytest.approx(45.0, abs=1e-6)
    assert lead.margins["gain_crossover"] == pytest.approx(2.0)
    assert max(abs(lead.poles)) < 1.0
    with pytest.raises(UsageError, match="more than two samples"):
        lead_design(linear, margin_deg=45.0, crossover=40.0)
    with pytest.raises(UsageError, match="continuous time"):
        pid_design(linear, "simc")


@pytest.mark.slow
def test_a_sampled_pid_closes_the_loop_as_its_difference_equation():
    linear = linear_of("zpk: {poles: [0.9, 0.6], gain: 0.04, dt: 0.1}")
    found = pid_design(linear, "ziegler-nichols")
    y, u, e = np.zeros(200), np.zeros(200), np.zeros(200)
    plant, law = ([0.04], [1, -1.5, 0.54]), (found.num, found.den)
    for k in range(200):
        y[k] = -plant[1][1] * y[k - 1] - plant[1][2] * y[k - 2] + plant[0][0] * u[k - 2] if k > 1 else 0.0
        e[k] = 1.0 - y[k]
        past = range(1, len(law[1]))
        u[k] = law[0][0] * e[k] + sum(law[0][n] * e[k - n] - law[1][n] * u[k - n] for n in past if n <= k)
    shown = min(len(found.time), 200)
    np.testing.assert_allclose(found.step[0][:shown], y[:shown], atol=1e-9)


def loop_of(text, designer):
    plant = plant_of(text)
    linear = formula_plant(plant)
    design = designer(linear)
    assert is_simulated(plant, linear, design)
    return closed_loop(FormulaLoop(plant, linear, design), design), design


def test_a_saturated_integrator_rises_at_its_limit_and_then_settles():
    # 1 / s under u = 4 (r - y), limited to 0.5: a ramp to y = 0.875, then an exponential.
    text = "ss: {a: [[0]], b: [[1]], c: [[1]]}, saturation: 0.5, amplitude: 4"
    found, _ = loop_of(text, lambda linear: placed_design(linear, [-4.0]))
    late = found.time - 1.75
    y = np.where(late < 0, 0.5 * found.time, 1.0 - 0.125 * np.exp(-4.0 * np.maximum(late, 0.0)))
    np.testing.assert_allclose(found.step[0], y, atol=2e-4)


def test_a_saturated_double_integrator_under_state_feedback_follows_its_parabolas():
    text = "ss: {a: [[0, 1], [0, 0]], b: [[0], [1]], c: [[1, 0]]}, saturation: 0.4, amplitude: 2"
    found, design = loop_of(text, lambda linear: placed_design(linear, [-1.0, -2.0]))
    dt, place, speed, places = found.time[1], 0.0, 0.0, []
    assert design.gain == pytest.approx((2.0, 3.0))
    for _ in found.time:
        places.append(place)
        push = min(max(2.0 - 2.0 * place - 3.0 * speed, -0.4), 0.4)
        place, speed = place + speed * dt + push * dt**2 / 2, speed + push * dt
    np.testing.assert_allclose(found.step[0], places, atol=1e-9)


def test_a_dead_zone_leaves_an_error_behind():
    text = "tf: {num: [1], den: [1, 0]}, dead_zone: 0.2, seconds: 3"
    found, design = loop_of(text, lambda linear: placed_design(linear, [-1.0]))
    np.testing.assert_allclose(found.step[0], 0.8 * (1.0 - np.exp(-found.time)), atol=1e-3)
    assert design.step[0][-1] > 0.99


def test_limits_act_on_both_sides():
    plant = plant_of("tf: {num: [1], den: [1, 1]}, saturation: 2, dead_zone: 0.5")
    assert [limited(plant, value) for value in (-9, -1, -0.4, 0.0, 0.6, 2.5, 3)] == pytest.approx(
        [-2, -0.5, 0, 0, 0.1, 2, 2]
    )


@pytest.mark.slow
def test_the_delay_of_a_simulated_loop_is_exact():
    # e^-s / s under u = r - y: a ramp, then a parabola.
    found, _ = loop_of("tf: {num: [1], den: [1, 0], delay: 1}", lambda linear: pid_design(linear, "ziegler-nichols"))
    assert not found.step[0][found.time < 1.0].any()
    assert found.step[0][found.time > 1.05].any()
    text = "tf: {num: [1], den: [1, 1], delay: 1}"
    found, design = loop_of(text, lambda linear: pid_design(linear, "simc"))
    # The law cancels the lag: a loop e^-s / (2 s), whose response is piecewise a polynomial.
    t = found.time
    first, second, third = (np.maximum(t - n, 0.0) / 2 for n in (1.0, 2.0, 3.0))
    y = first - second**2 / 2 + third**3 / 6
    np.testing.assert_allclose(found.step[0][t < 4.0], y[t < 4.0], atol=1e-3)
    assert design.num == pytest.approx((0.5, 0.5))


def test_what_answers_at_once_has_no_limited_loop():
    plant = plant_of("tf: {num: [1, 2], den: [1, 1]}, saturation: 1")
    linear = formula_plant(plant)
    with pytest.raises(UsageError, match="direct feedthrough"):
        is_simulated(plant, linear, placed_design(linear, [-3.0]))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("zpk: {poles: [-1+2j], gain: 1}", r"poles contain -1\+2j without -1-2j; give both"),
        ("zpk: {poles: [-1], zeros: [1, 2], gain: 1}", "there are 2 zeros; at most 1 are possible"),
        ("zpk: {poles: [1e+j], gain: 1}", "poles contain '1e[+]j'; write a complex number"),
        ("zpk: {poles: [-1], gain: 0}", "gain is 0"),
        ("tf: {num: [1], den: [1, 1], dt: 0.1, delay: 0.25}", "it must be a multiple of dt, 0.1 s"),
        ("tf: {num: [1], den: [1, 1], dt: 0.1, delay: 25}", "delay is 250 periods"),
    ],
)
def test_a_wrong_formula_is_named(text, said):
    with pytest.raises(WorldError, match=said):
        plant_of(text)


def test_formulas_read_back_equal_and_their_figures_are_scipys():
    text = "zpk: {zeros: [-0.5], poles: [0.9, 0.5+0.3j, 0.5-0.3j], gain: 0.1, dt: 0.1}, saturation: 2"
    world = parse_world(f"mjsim: 1\nplants: [{{name: p, {text}}}]\n")
    assert parse_world(format_world(world)) == world
    found = experiment(world, world.plants[0])
    assert figures_of(found)["dt"] == 0.1
    _, drawn = tables(found)["step"]
    _, (exact,) = signal.dstep(([-0.5], [0.9, 0.5 + 0.3j, 0.5 - 0.3j], 0.1, 0.1), n=len(drawn))
    np.testing.assert_allclose(drawn[:, 1], exact[:, 0], atol=1e-12)
    assert ("poles", "0.5-0.3j, 0.5+0.3j, 0.9") in _facts(found).rows


@pytest.mark.slow
def test_a_notebook_shows_a_plant_with_its_figures():
    world = parse_world("mjsim: 1\nplants: [{name: p, tf: {num: [6], den: [1, 6, 11, 6]}}]\n")
    shown = experiment(world, world.plants[0])._repr_html_()
    assert "<td>gain margin</td><td>10 at 3.31662 rad/s</td>" in shown
    assert shown.count('src="data:image/png;base64,') == 2
