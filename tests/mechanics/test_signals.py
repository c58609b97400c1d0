"""Signals have the values of their formulas, and derivatives that central differences confirm."""

import numpy as np
import pytest
from scipy import signal as scipy_signal

from mjsim.mechanics import Chirp, Constant, Pulse, Ramp, Random, Sawtooth, Sine, Square, StepChange, Table

T = np.linspace(0.0, 7.0, 2001) + 0.00037
SMOOTH = {
    "constant": Constant(level=3.0),
    "sine": Sine(amplitude=2.0, frequency=0.7, phase=0.3, offset=1.0),
    "chirp": Chirp(amplitude=1.5, first=0.2, last=2.0, seconds=10.0, offset=0.5),
    "falling chirp": Chirp(amplitude=1.5, first=2.0, last=0.2, seconds=10.0),
    "exponential chirp": Chirp(amplitude=1.5, first=0.1, last=2.0, seconds=10.0, sweep="exponential"),
    "level exponential chirp": Chirp(amplitude=1.5, first=1.0, last=1.0, seconds=10.0, sweep="exponential"),
    "cubic table": Table(times=np.arange(9.0), values=np.sin(np.arange(9.0)), between="cubic"),
    "periodic table": Table(times=np.arange(4.0), values=np.array([0, 1, -1, 0.0]), between="cubic", repeat=True),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_derivatives_of_smooth_signals_match_central_differences(name):
    made, h = SMOOTH[name], 1e-4
    values = [made.value(T + k * h) for k in (-1, 0, 1)]
    np.testing.assert_allclose(made.rate(T), (values[2] - values[0]) / (2 * h), atol=2e-5)
    # A cubic spline's third derivative jumps at its knots: differences across one are that much off.
    kinks = 2e-3 if "table" in name else 1e-4
    np.testing.assert_allclose(made.second(T), (values[2] - 2 * values[1] + values[0]) / h**2, atol=kinks)
    assert not made.jumps


def test_waves_are_those_of_scipy():
    phase = 2 * np.pi * 0.4 * T
    np.testing.assert_allclose(
        Square(amplitude=2.0, frequency=0.4, duty=0.3).value(T), 2 * scipy_signal.square(phase, duty=0.3)
    )
    for rise in (1.0, 0.5, 0.2):
        np.testing.assert_allclose(
            Sawtooth(amplitude=2.0, frequency=0.4, rise=rise).value(T),
            2 * scipy_signal.sawtooth(phase, rise),
            atol=1e-7,
        )
    for sweep, method in (("linear", "linear"), ("exponential", "logarithmic")):
        made = Chirp(amplitude=1.0, first=0.3, last=3.0, seconds=7.5, sweep=sweep)
        # scipy's is a cosine, ours begins at 0.
        np.testing.assert_allclose(made.value(T), scipy_signal.chirp(T, 0.3, 7.5, 3.0, method, phi=-90), atol=1e-9)


def test_a_chirp_goes_on_at_its_last_frequency_without_a_jump():
    made = Chirp(amplitude=1.0, first=1.0, last=2.0, seconds=2.0)
    after = 2.0 + np.linspace(0.0, 3.0, 50)
    np.testing.assert_allclose(made.value(after), np.sin(2 * np.pi * (3.0 + 2.0 * (after - 2.0))), atol=1e-9)
    assert made.second(2.5) == pytest.approx(-((4 * np.pi) ** 2) * made.value(2.5))


def test_steps_ramps_and_pulses_change_when_they_say():
    assert StepChange(before=1.0, after=3.0, when=2.0).value([1.999, 2.0, 5.0]).tolist() == [1.0, 3.0, 3.0]
    ramp = Ramp(before=1.0, slope=2.0, start=1.0, seconds=3.0)
    assert ramp.value([0.0, 1.0, 2.0, 9.0]).tolist() == [1.0, 1.0, 3.0, 7.0]
    assert ramp.rate([0.5, 1.0, 3.9, 4.0]).tolist() == [0.0, 2.0, 2.0, 0.0]
    train = Pulse(amplitude=2.0, when=1.0, width=0.5, every=2.0, offset=-1.0)
    assert train.value([0.9, 1.0, 1.49, 1.5, 3.0, 3.6]).tolist() == [-1.0, 1.0, 1.0, -1.0, 1.0, -1.0]


def test_a_step_at_a_sum_of_physics_steps_is_not_one_step_late():
    time = sum([0.001] * 300)  # 0.3 and a rounding error
    assert StepChange(after=1.0, when=0.3).value(time - 1e-15) == 1.0
    assert Square(amplitude=1.0, frequency=1 / 0.3).value(time) == 1.0


def test_a_table_holds_its_ends_and_repeats():
    times, values = np.array([1.0, 2.0, 4.0]), np.array([0.0, 3.0, -1.0])
    line = Table(times=times, values=values)
    assert line.value([0.0, 1.5, 3.0, 9.0]).tolist() == [0.0, 1.5, 1.0, -1.0]
    assert line.rate([0.0, 1.0, 2.0, 3.0, 4.0]).tolist() == [0.0, 3.0, -2.0, -2.0, 0.0]
    held = Table(times=times, values=values, between="hold")
    assert held.value([0.0, 1.9, 2.0, 5.0]).tolist() == [0.0, 0.0, 3.0, -1.0]
    again = Table(times=times, values=values, repeat=True)
    np.testing.assert_allclose(again.value([4.5, 6.0]), [1.5, 1.0], atol=1e-8)
    assert again.jumps
    assert held.jumps
    assert not line.jumps


@pytest.mark.parametrize("shape", ["normal", "uniform", "binary"])
def test_chance_has_its_deviation_and_does_not_depend_on_who_asks_when(shape):
    def made() -> Random:
        return Random(deviation=0.5, hold=0.01, offset=2.0, shape=shape, rng=np.random.default_rng(7))

    times = np.arange(0.0, 400.0, 0.01)
    whole = made().value(times)
    assert whole.mean() == pytest.approx(2.0, abs=0.01)
    assert whole.std() == pytest.approx(0.5, abs=0.01)
    one = made()
    assert [float(one.value(t)) for t in times[::-997]] == whole[::-997].tolist()
    assert np.unique(np.round(whole, 9)).size == 2 or shape != "binary"


def test_times_of_a_table_must_increase():
    with pytest.raises(ValueError, match="time 1 follows 2; times must increase"):
        Table(times=np.array([0.0, 2.0, 1.0]), values=np.zeros(3))


def test_a_cubic_table_ends_without_a_bend_and_one_that_closes_goes_on_smoothly():
    times, values = np.array([0.0, 1.0, 2.5, 3.0]), np.array([0.0, 2.0, -1.0, 0.0])
    open_ended = Table(times=times, values=values, between="cubic")
    np.testing.assert_allclose(open_ended.second([1e-9, 3.0 - 1e-6]), 0.0, atol=1e-4)
    closed = Table(times=times, values=values, between="cubic", repeat=True)
    for ask in (closed.value, closed.rate, closed.second):
        np.testing.assert_allclose(ask(1e-7), ask(3.0 - 1e-7), atol=1e-4)
        np.testing.assert_allclose(ask(1.3), ask(1.3 + 9.0), atol=1e-6)
    assert abs(closed.second(1e-7)) > 1.0
    jumping = Table(times=times, values=np.array([0.0, 2.0, -1.0, 1.0]), between="cubic", repeat=True)
    np.testing.assert_allclose(jumping.second(1e-7), 0.0, atol=1e-4)
    alone = Table(times=np.array([2.0]), values=np.array([5.0]))
    assert (alone.value([0.0, 9.0]).tolist(), alone.rate([0.0, 9.0]).tolist()) == ([5.0, 5.0], [0.0, 0.0])


@pytest.mark.parametrize(
    ("times", "values", "keys", "said"),
    [
        ([0.0, 1.0], [0.0], {}, r"shapes \(2,\) and \(1,\); give \(n,\) each"),
        ([], [], {}, "shapes"),
        ([[0.0, 1.0]], [[0.0, 1.0]], {}, "shapes"),
        ([0.0, np.inf], [0.0, 1.0], {}, "must be finite"),
        ([0.0, 1.0], [0.0, np.nan], {}, "must be finite"),
        ([0.0, 0.0], [0.0, 1.0], {}, "time 0 follows 0; times must increase"),
        ([0.0], [0.0], {"repeat": True}, "a table of one time cannot repeat"),
    ],
)
def test_a_table_that_is_none_is_refused(times, values, keys, said):
    with pytest.raises(ValueError, match=said):
        Table(times=np.array(times), values=np.array(values), **keys)
