"""Steps of the laboratory against transfer functions, searches on fine grids and scipy."""

import math
from dataclasses import replace

import control
import numpy as np
import pytest
from scipy import signal
from scipy.interpolate import pade

from mjsim.errors import UsageError
from mjsim.lab.effects import ForceEffect, LedJoint, led
from mjsim.lab.formula import formula_plant, pade_limit
from mjsim.lab.identify import Samples, identified
from mjsim.lab.linear import LinearPlant, minimal_states, slope
from mjsim.lab.margins import margins_of
from mjsim.lab.plant_study import frequencies, shown_seconds, shown_times, study
from mjsim.world import parse_world

FORCE = ForceEffect(unit="N", ctrl=np.zeros(0), applied=np.zeros(3))


def mechanism(rng):
    """Return A and B of three coupled coordinates, with a force at the second."""
    A, B = np.zeros((6, 6)), np.zeros((6, 1))
    A[:3, 3:], A[3:] = np.eye(3), rng.normal(size=(3, 6))
    B[3:, 0] = rng.normal(np.array([0.0, 3.0, 0.0]))
    return A, B


@pytest.mark.parametrize("is_speed", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_a_plant_that_is_led_passes_on_motion_as_forces_make_it(is_speed, seed):
    rng = np.random.default_rng(seed)
    A, B = mechanism(rng)
    Y, m, rates = rng.normal(size=(3, 3)), 1, np.array([False, is_speed, False])
    found = control.ss(*led(LedJoint(unit="", force=FORCE, dof=m, is_speed=is_speed), A, B, Y, m, rates))
    for s in (0.3j, 1j, 2.0 + 5j, 40j):
        motion = np.linalg.solve(s * np.eye(6) - A, B)[:3, 0]
        outputs = (Y @ motion) * np.where(rates, s, 1.0) / motion[m]
        np.testing.assert_allclose(found(s).ravel(), outputs / (s if is_speed else 1.0), rtol=1e-7)


def test_a_rate_has_no_bound_when_a_value_jumps():
    rng = np.random.default_rng(0)
    A, B = mechanism(rng)
    effect = LedJoint(unit="", force=FORCE, dof=1, is_speed=False)
    with pytest.raises(UsageError, match="is unbounded"):
        led(effect, A, B, rng.normal(size=(1, 3)), 1, np.array([True]))
    # Where the input does not act at once, a rate has one.
    r = B[[3, 5], 0] / B[4, 0]
    Y = np.array([[r[1], 0.0, -r[0]]])
    found = control.ss(*led(effect, A, B, Y, 1, np.array([True])))
    motion = np.linalg.solve(2j * np.eye(6) - A, B)[:3, 0]
    assert complex(found(2j)) == pytest.approx(complex((Y @ motion)[0] * 2j / motion[1]))


@pytest.mark.parametrize("is_speed", [False, True])
def test_a_led_joint_reaches_each_input_at_the_end_of_its_step(is_speed):
    effect, inputs = LedJoint(unit="", force=FORCE, dof=0, is_speed=is_speed), np.random.default_rng(0).normal(size=9)
    speed, value, dt, reached = 0.0, 0.0, 0.02, []
    for acceleration in effect.accelerations(inputs, dt):
        speed += dt * acceleration
        value += dt * speed
        reached.append(speed if is_speed else value)
    np.testing.assert_allclose(reached, inputs, atol=1e-12)


def test_a_slope_is_exact_to_the_fourth_order():
    for power in range(1, 5):
        found = slope(lambda x, power=power: np.array([(1.0 + x) ** power, math.exp(x)]), step=0.1)
        assert found[0] == pytest.approx(power, abs=1e-12)
        assert found[1] == pytest.approx(1.0, abs=0.1**4 / 25)


def test_states_count_that_an_input_reaches_and_an_output_shows():
    A = np.zeros((5, 5))
    A[1, 0] = A[2, 1] = A[3, 4] = A[2, 3] = A[4, 4] = 1.0
    B, C = np.eye(5)[:, [0]], np.eye(5)[[2]]
    assert minimal_states(A, B, C) == [0, 1, 2]
    assert minimal_states(A, np.eye(5)[:, [4]], C) == [2, 3, 4]
    assert minimal_states(A, B, np.eye(5)[[1]]) == [0, 1]
    A[1, 0] = 0.9e-8
    assert minimal_states(A, B, C) == []
    assert minimal_states(A, B, C, coupled=0.0) == [0, 1, 2]


def searched(loop, delay):
    """Return margins by a search on a fine grid of frequencies."""
    omega = np.geomspace(1e-2, 100.0, 40_001)
    value = loop(1j * omega) * np.exp(-1j * omega * delay)
    turned = np.flatnonzero((np.diff(np.sign(value.imag)) != 0) & (value.real[1:] < 0))
    crossed = np.flatnonzero(np.diff(np.sign(np.abs(value) - 1.0)) != 0)
    gains = [(1.0 / abs(value[k]), omega[k]) for k in turned]
    phases = [(math.degrees(math.remainder(np.angle(-value[k]), 2 * math.pi)), omega[k]) for k in crossed]
    gain = min(gains, key=lambda pair: abs(math.log(pair[0])), default=(None, None))
    phase = min(phases, key=lambda pair: abs(pair[0]), default=(None, None))
    return {
        "gain_margin": gain[0],
        "phase_crossover": gain[1],
        "phase_margin_deg": phase[0],
        "gain_crossover": phase[1],
    }


@pytest.mark.parametrize("delay", [0.0, 0.4])
@pytest.mark.parametrize(
    ("num", "den"),
    [([2.0], [1, 3, 3, 1]), ([12.0], [1, 3, 3, 1]), ([3.0, 1.0], [1, 0.4, 4, 0]), ([-1.0, 4.0], [1, 3, 3, 1])],
)
def test_margins_are_those_of_a_search(num, den, delay):
    loop = control.tf(num, den)
    found, exact = margins_of(loop, delay), searched(loop, delay)
    for name, value in exact.items():
        if value is None:
            assert found[name] is None
        else:
            assert found[name] == pytest.approx(value, rel=2e-3, abs=0.02)


@pytest.mark.parametrize(
    ("num", "den", "delay", "expected"),
    [
        ([1.0], [1, 0, 0], 0.0, (None, None, 0.0, 1.0)),
        ([4.0], [1, 0, 1], 0.0, (None, None, 0.0, math.sqrt(5.0))),
        ([-4.0], [1, 0, 1], 0.0, (0.25, 0.0, None, None)),
        ([-0.5], [1, 0, 1], 0.0, (2.0, 0.0, 0.0, math.sqrt(0.5))),
        ([1.0], [1, 0, 0, 0], 0.0, (None, None, -90.0, 1.0)),
        ([-1.0, 1.0], [1, 1, 0], 0.0, (1.0, 1.0, 0.0, 1.0)),
        ([2.0], [1, -1], 0.0, (0.5, 0.0, 60.0, math.sqrt(3.0))),
        ([-1.0], [1, 0], 0.0, (None, None, -90.0, 1.0)),
        ([-2.0], [1], 0.0, (0.5, 0.0, None, None)),
        ([-1.0, 1.0], [1, 1], 0.0, (None, None, None, None)),
        ([1e12], [1, 2e6, 1e12], 0.0, (None, None, None, None)),
        ([1e-6], [1, 1e-6], 0.0, (None, None, None, None)),
        ([1.0], [1], 1.0, (1.0, math.pi, None, None)),
        ([1.0, 0.0], [1, 1, 0], 0.0, (None, None, None, None)),
        ([1.0], [1, 0], 0.5, (math.pi, math.pi, 90.0 - math.degrees(0.5), 1.0)),
        ([1.0], [1, 0, 1], 0.1, (100 * math.pi**2 * 4 - 1, 20 * math.pi, -math.degrees(0.1 * 2**0.5), 2**0.5)),
    ],
)
def test_margins_of_edge_plants_are_those_of_their_formulas(num, den, delay, expected):
    found = margins_of(control.ss(control.tf(num, den)), delay)
    names = ("gain_margin", "phase_crossover", "phase_margin_deg", "gain_crossover")
    assert [found[name] for name in names] == [
        None if value is None else pytest.approx(value, rel=1e-6, abs=1e-5) for value in expected
    ]


def world_plant(text):
    return formula_plant(parse_world(f"plants: [{{name: p, {text}}}]").plants[0])


@pytest.mark.parametrize("delay", [0.0, 0.37])
def test_responses_and_phases_of_a_study_are_those_of_scipy_after_the_delay(delay):
    # Without Pade's approximation of the delay the root locus is simple.
    plant = replace(world_plant("tf: {num: [2, 3], den: [1, 1.2, 4]}"), delay=delay)
    found, system = study(plant, seconds=6.0), signal.TransferFunction([2, 3], [1, 1.2, 4])
    moves, fine = found.time >= delay, np.linspace(0.0, 6.0, 4001)
    for response, exact in ((found.step[0], signal.step), (found.impulse[0], signal.impulse)):
        expected = np.interp(found.time[moves] - delay, fine, exact(system, T=fine)[1])
        np.testing.assert_allclose(response[moves], expected, atol=2e-3)
        assert not response[~moves].any()
    _, value = signal.freqresp(system, found.omega)
    np.testing.assert_allclose(found.magnitude, np.abs(value), rtol=1e-9)
    np.testing.assert_allclose(found.phase, np.unwrap(np.angle(value)) - delay * found.omega, atol=1e-9)
    np.testing.assert_allclose(found.zeros, [-1.5])
    assert found.is_stable


@pytest.mark.parametrize("delay", [0.5, 4.0])
def test_the_approximation_of_a_delay_is_as_good_as_the_page_says(delay):
    series = [(-1.0) ** k / math.factorial(k) for k in range(11)]
    num, den = pade(series, 5)
    omega = pade_limit(delay) * np.array([0.5, 0.99, 1.01])
    errors = np.angle(num(1j * omega * delay) / den(1j * omega * delay) * np.exp(1j * omega * delay), deg=True)
    assert np.abs(errors[:2]).max() < 1.0 < abs(errors[2])


def test_one_input_and_some_outputs_of_a_state_space_are_looked_at():
    text = "ss: {a: [[-1, 0], [0, -2]], b: [[1, 0], [0, 3]], c: [[1, 0], [1, 1]], d: [[0, 5], [0, 7]]"
    text += "}"
    plant = world_plant(f"{text}, input: u2, outputs: [y2]")
    system = control.ss(plant.A, plant.B, plant.C, plant.D)
    assert complex(system(1j)) == pytest.approx(3 / (1j + 2) + 7)
    assert (plant.input, plant.outputs, plant.units) == ("u2", ("y2",), ("", ""))
    with pytest.raises(UsageError, match="u2 affects none of y1"):
        world_plant(f"{text.replace('[0, 5]', '[0, 0]')}, input: u2, outputs: [y1]")


@pytest.mark.parametrize(
    ("poles", "seconds"),
    [
        ([-2.0, -0.5], 12.0),
        ([-1.0 + 3j, -1.0 - 3j], 6.0),
        ([0.5, -7.0], math.log(20.0) / 0.5),
        ([4j, -4j, 2j, -2j], 5 * math.pi),
        ([0.0, -3.0], 2.0),
        ([0.0, 0.0], 10.0),
        ([], 10.0),
    ],
)
def test_responses_are_shown_until_they_settle_grow_or_have_swung_five_times(poles, seconds):
    assert shown_seconds(np.array(poles, complex)) == pytest.approx(seconds)


@pytest.mark.parametrize(("den", "seconds"), [("[1, 0]", 5.5), ("[1]", 5.5), ("[1, 1]", 6.5), ("[1, 0.1, 4]", 120.5)])
def test_a_delay_lengthens_what_is_shown_and_its_approximation_shortens_nothing(den, seconds):
    found = study(world_plant(f"tf: {{num: [1], den: {den}, delay: 0.5}}"))
    assert found.time[-1] == pytest.approx(seconds)


def test_curves_have_points_enough_for_each_swing_and_two_decades_about_all_corners():
    times = shown_times(np.array([-1 + 40j, -1 - 40j]), 10.0)
    assert (times[0], times[-1]) == (0.0, 10.0)
    assert len(times) == math.ceil(20 * 10 * 40 / (2 * math.pi))
    assert len(shown_times(np.array([-1.0]), 3.0)) == 400
    assert len(shown_times(np.array([1e4j]), 10.0)) == 4000
    omega = frequencies(np.array([0.0, -2.0, -5.0]), np.array([-30.0]))
    assert (omega[0], omega[-1], len(omega)) == (pytest.approx(0.02), pytest.approx(3000.0), 400)
    np.testing.assert_allclose(frequencies(np.zeros(1), np.zeros(0))[[0, -1]], [0.01, 100.0])


@pytest.mark.parametrize("held", [True, False])
def test_what_is_identified_has_the_poles_of_the_plant_that_was_driven(held):
    rng, dt = np.random.default_rng(0), 0.05
    A, B, C = np.array([[0.0, 1.0], [-9.0, -1.2]]), np.array([[0.0], [2.0]]), np.array([[1.0, 0.0], [0.0, 1.0]])
    plant = LinearPlant(
        A=A, B=B, C=C, D=np.zeros((2, 1)), states=("a", "b"), input="u", outputs=("y", "z"), units=("",) * 3
    )
    inputs, time = np.repeat(rng.normal(size=40), 5), dt * np.arange(200)
    inputs[0] = 0.0
    exact = signal.StateSpace(A, B, C, np.zeros((2, 1)))
    if held:
        _, outputs, _ = signal.dlsim(exact.to_discrete(dt), inputs, time)
    else:
        _, outputs, _ = signal.lsim(exact, inputs, time)
    found = identified(plant, Samples(time=time, inputs=inputs, outputs=outputs.T + 7.0, source="s", held=held))
    np.testing.assert_allclose(found.linear, outputs.T, atol=1e-8)
    np.testing.assert_allclose(found.linear_fit, 100.0, atol=1e-4)
    np.testing.assert_allclose(found.poles, np.sort_complex(np.linalg.eigvals(A)), atol=0.02)
    assert found.model_fit.min() > 99.0
    few = Samples(time=time[:49], inputs=inputs[:49], outputs=outputs.T[:, :49], source="s")
    still = Samples(time=time, inputs=np.ones(200), outputs=outputs.T, source="s")
    for samples in (few, still):
        with pytest.raises(UsageError, match="too little for identification"):
            identified(plant, samples)
