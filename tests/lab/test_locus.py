"""Root loci, margins and responses are those of closed forms, from the numbers that the files of a plant hold."""

import control
import numpy as np
import pytest

import mjsim
from mjsim.lab import Study, experiment
from mjsim.lab.locus import RootLocus, root_locus
from mjsim.lab.margins import margins_of
from mjsim.lab.plant_page import figures_of

LOOPS = {
    "three": ([6], [1, 6, 11, 6]),
    "resonant": ([3, 9], [1, 2.4, 14.2, 5, 0]),
    "double": ([1], [1, 0, 0]),
    "quadruple": ([1], [1, 4, 6, 4, 1]),
    "inverse": ([-1, 1], [1, 2, 1]),
    "circle": ([1, 3], [1, 1, 0]),
    "biproper": ([1, 4, 5], [1, 1, 2]),
    "jumps": ([-1, 4, 5], [1, 1, 2]),
    "fast": ([1e12], [1, 1e6, 1e12]),
    "cancelled": ([1, 1], [1, 3, 2]),
    "balancing": ([1, 0, -9], [1, 0, -16, 0, 0]),
    "gain": ([3], [2]),
}


def locus(name: str) -> RootLocus:
    return root_locus(control.ss(control.tf(*LOOPS[name])))


@pytest.mark.parametrize("name", LOOPS)
def test_every_point_of_a_root_locus_is_a_closed_loop_pole_at_its_gain(name):
    found, (num, den) = locus(name), LOOPS[name]
    k, s = found.gains, found.branches
    terms = np.abs(np.polyval(np.abs(den), np.abs(s))) + k * np.polyval(np.abs(num), np.abs(s))
    assert (np.abs(np.polyval(den, s) + k * np.polyval(num, s)) <= 1e-8 * terms + 1e-15).all()
    np.testing.assert_allclose(np.sort_complex(found.branches[:, 0]), np.sort_complex(np.roots(den)), atol=1e-3)


@pytest.mark.parametrize("name", LOOPS)
def test_no_segment_of_a_root_locus_is_long_or_turns_far_except_where_branches_meet(name):
    found = locus(name)
    steps = np.diff(found.branches, axis=1)
    assert np.abs(steps).max(initial=0.0) <= 0.02 * 2 * found.extent
    turns = np.degrees(np.abs(np.angle(steps[:, 1:] * np.conj(steps[:, :-1]))))
    moving = np.minimum(np.abs(steps[:, 1:]), np.abs(steps[:, :-1])) > 1e-6 * found.extent
    met = np.isin(found.gains[1:-1], [mark.gain for mark in found.breakaways])
    assert turns[moving & ~met].max(initial=0.0) <= 5.0
    assert len(found.gains) < 1500


@pytest.mark.parametrize("scale", [2.0**-12, 2.0**12])
@pytest.mark.parametrize("name", ["three", "resonant", "circle", "inverse", "jumps"])
def test_a_locus_in_other_units_of_time_is_the_same(name, scale):
    plain = control.ss(control.tf(*LOOPS[name]))
    one, other = root_locus(plain), root_locus(control.ss(scale * plain.A, scale * plain.B, plain.C, plain.D))
    np.testing.assert_allclose(other.gains, one.gains, rtol=1e-6)
    # Which branch goes on as which after they have met is rounding.
    for part in (np.real, np.imag):
        expected = np.sort(part(scale * one.branches), axis=0)
        np.testing.assert_allclose(np.sort(part(other.branches), axis=0), expected, atol=1e-6 * other.extent)
    assert other.extent == pytest.approx(scale * one.extent)
    for marks in ("crossings", "breakaways"):
        for left, right in zip(getattr(one, marks), getattr(other, marks), strict=True):
            assert (right.gain, right.point) == (pytest.approx(left.gain), pytest.approx(scale * left.point, rel=1e-4))
    assert other.asymptotes == one.asymptotes
    assert other.centroid == (None if one.centroid is None else pytest.approx(scale * one.centroid))


def test_three_lags_cross_at_the_square_root_of_11_and_meet_where_the_derivative_is_0():
    found = locus("three")
    assert [(mark.gain, mark.point) for mark in found.crossings] == [
        (pytest.approx(10.0), pytest.approx(side * 1j * np.sqrt(11.0))) for side in (-1, 1)
    ]
    # Of (s + 1)(s + 2)(s + 3) the derivative 3 s^2 + 12 s + 11 is 0 at -2 +- 1 / sqrt(3).
    (meeting,) = found.breakaways
    assert meeting.point == pytest.approx(-2.0 + 1.0 / np.sqrt(3.0))
    assert meeting.gain == pytest.approx(2.0 / (3.0 * np.sqrt(3.0)) / 6.0)
    assert found.centroid == pytest.approx(-2.0)
    assert np.degrees(found.asymptotes) == pytest.approx([60.0, 180.0, 300.0])
    np.testing.assert_allclose(found.unity, np.sort_complex(np.roots([1, 6, 11, 12])), atol=1e-9)


def test_the_locus_of_two_poles_and_a_zero_is_the_circle_of_the_books():
    # About the zero, with the geometric mean of its distances to the poles as radius: sqrt(3 * 2).
    found = locus("circle")
    off_axis = found.branches[np.abs(found.branches.imag) > 1e-6]
    np.testing.assert_allclose(np.abs(off_axis + 3.0), np.sqrt(6.0), rtol=1e-6)
    assert [mark.point.real for mark in found.breakaways] == pytest.approx([-3 + np.sqrt(6), -3 - np.sqrt(6)])


def test_a_locus_along_the_imaginary_axis_stays_there_and_crosses_nothing():
    found = locus("balancing")
    assert found.crossings == ()
    swinging = found.branches[np.abs(found.branches.imag) > 1e-6]
    np.testing.assert_allclose(swinging.real, 0.0, atol=1e-7)


@pytest.mark.parametrize(
    ("num", "den", "delay", "margins"),
    [
        ([6], [1, 6, 11, 6], 0.0, (10.0, None, np.sqrt(11.0), None)),
        ([1, 0, -9], [1, 0, -16, 0, 0], 0.0, (None, None, None, None)),
        ([1], [1, 0, 4], 0.0, (None, 0.0, None, np.sqrt(5.0))),
        ([1], [1, 1], 0.0, (None, None, None, None)),
        ([-0.5], [1, 1], 0.0, (2.0, None, 0.0, None)),
        ([1], [1, 1, 0], 0.0, (None, 51.827292373, None, 0.786151378)),
        # Of 2 exp(-s / 2) / (3 s + 1): the gain is 1 at 1 / sqrt(3), where the lag turns by 60 degrees.
        ([2], [3, 1], 0.5, (5.0356418, 120.0 - np.degrees(0.5 / np.sqrt(3.0)), 3.3405048, 1.0 / np.sqrt(3.0))),
        # Of exp(-s) / s: phase -180 at pi / 2.
        ([1], [1, 0], 1.0, (np.pi / 2, 90.0 - np.degrees(1.0), np.pi / 2, 1.0)),
    ],
)
def test_margins_are_those_of_closed_forms_and_none_where_there_is_none(num, den, delay, margins):
    found = margins_of(control.ss(control.tf(num, den)), delay)
    expected = [None if value is None else pytest.approx(value, rel=1e-7, abs=1e-6) for value in margins]
    assert list(found.values()) == expected


def studied(keys: str) -> Study:
    world = mjsim.parse_world(f"mjsim: 1\nplants: [{{name: p, {keys}}}]\n")
    return experiment(world, world.plants[0]).study


def test_a_delay_is_exact_in_frequency_and_in_time():
    study = studied("tf: {num: [2], den: [3, 1], delay: 0.5}")
    exact = 2 / (3j * study.omega + 1) * np.exp(-0.5j * study.omega)
    np.testing.assert_allclose(study.magnitude * np.exp(1j * study.phase), exact, rtol=1e-9)
    later = np.maximum(study.time - 0.5, 0.0)
    np.testing.assert_allclose(study.step[0], 2 * (1 - np.exp(-later / 3)), atol=1e-9)
    np.testing.assert_allclose(study.impulse[0], np.where(study.time >= 0.5, 2 / 3 * np.exp(-later / 3), 0), atol=1e-9)


def test_the_file_of_a_plant_holds_its_root_locus_as_it_is_drawn():
    world = mjsim.parse_world("mjsim: 1\nplants: [{name: p, tf: {num: [6], den: [1, 6, 11, 6]}}]\n")
    figures = figures_of(experiment(world, world.plants[0]))["root_locus"]
    branches = np.array(figures["branches"])
    assert branches.shape == (3, len(figures["gains"]), 2)
    np.testing.assert_allclose(branches[..., 0] + 1j * branches[..., 1], locus("three").branches, atol=1e-9)
    assert figures["crossings"][1]["point"] == pytest.approx([0.0, np.sqrt(11.0)])


def test_the_locus_of_a_delay_is_marked_where_the_delay_itself_has_closed_loop_poles():
    found = studied("tf: {num: [1], den: [1, 1], delay: 2}").locus
    # Of exp(-2 s) / (s + 1): 2 w + atan(w) = pi, 3 pi, ..., and one meeting, where the derivative 2 (s + 1) + 1 is 0.
    for mark in found.crossings:
        w = abs(mark.point.imag)
        assert (2 * w + np.arctan(w)) / np.pi % 2.0 == pytest.approx(1.0, abs=1e-9)
        assert mark.gain == pytest.approx(np.hypot(w, 1.0))
    assert len(found.crossings) == 4
    (meeting,) = found.breakaways
    assert (meeting.point, meeting.gain) == (pytest.approx(-1.5, rel=1e-3), pytest.approx(0.5 * np.exp(-3.0), rel=2e-3))


def test_plots_of_a_delay_show_some_turns_of_its_phase():
    from mjsim.lab.plant_plots import bode_plot, nyquist_plot

    study = studied("tf: {num: [1], den: [1, 1], delay: 2}")
    assert bode_plot(study).axes[1].get_ylim()[0] == pytest.approx(-1080.0, abs=2.0)
    assert nyquist_plot(study).axes[1].get_xlim()[0] >= -1440.0  # whole turns of the grid
