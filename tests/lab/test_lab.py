"""The laboratory's figures are those of python-control, its controllers do what they promise, its page says so."""

import contextlib
import csv
import io
import json

import control
import numpy as np
import pytest

import mjsim
from mjsim.cli.program import main
from mjsim.errors import UsageError
from mjsim.lab import LinearPlant, experiment, fit, lead_design, lqr_design, pid_design, placed_design, write_lab
from mjsim.lab.identify import Samples, identified
from mjsim.lab.plant_plots import poles_plot

WORLD = """
mjsim: 1
name: lab
plants:
  - {name: third, tf: {num: [6], den: [1, 6, 11, 6]}}
  - {name: double, ss: {a: [[0, 1], [0, 0]], b: [[0], [1]], c: [[1, 0], [0, 1]]}}
"""


def linear(name: str = "third") -> LinearPlant:
    world = mjsim.parse_world(WORLD)
    return experiment(world, next(plant for plant in world.plants if plant.name == name)).study.plant


def column(folder, name: str) -> np.ndarray:
    rows = list(csv.reader((folder / name).read_text().splitlines()))[1:]
    return np.array(rows, dtype=float).T


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The folder of a plant's page with an LQR, and what the command printed."""
    folder, printed = tmp_path_factory.mktemp("lab"), io.StringIO()
    (folder / "lab.yaml").write_text(WORLD)
    with contextlib.redirect_stdout(printed), pytest.raises(SystemExit) as end:
        main(
            [
                "lab",
                str(folder / "lab.yaml"),
                "third",
                "-o",
                str(folder / "out"),
                "--lqr",
                "1,0,0:1",
                "--formats",
                "svg",
            ]
        )
    assert end.value.code == 0
    return folder / "out", printed.getvalue()


@pytest.mark.slow
def test_the_command_writes_a_page_and_prints_poles(written):
    folder, printed = written
    assert "third: u -> y; states x1, x2, x3\n  poles -3, -2, -1; zeros none" in printed
    assert "LQR, Q = diag(1, 0, 0), R = 1: closed-loop poles" in printed
    page = (folder / "third.html").read_text()
    for word in ("<h3>A</h3>", "gain margin", "feedback K", "data:image/png"):
        assert word in page
    for plot in ("step", "impulse", "bode", "nyquist", "poles", "design_1"):
        assert (folder / f"third_{plot}.png").stat().st_size > 5000
        assert (folder / f"third_{plot}.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.slow
def test_several_tuning_rules_are_compared_on_one_page(tmp_path, capsys):
    (tmp_path / "lab.yaml").write_text("mjsim: 1\nplants: [{name: late, tf: {num: [1], den: [1, 1], delay: 2}}]\n")
    with pytest.raises(SystemExit):
        main(["lab", str(tmp_path / "lab.yaml"), "-o", str(tmp_path), "--pid", "cohen-coon", "--pid", "simc"])
    printed = capsys.readouterr().out
    # Cohen and Coon's table and Skogestad's formulas by hand, for T = 1 and theta = 2.
    assert "PID by cohen-coon: gain 0.9167, Ti 3.034 s, Td 0.5333 s" in printed
    assert "PID by simc: gain 0.25, Ti 1 s, Td 0 s" in printed


@pytest.mark.slow
def test_the_files_of_a_plant_hold_the_numbers_of_python_control(written):
    folder, _ = written
    figures, system = json.loads((folder / "third.json").read_text()), control.tf([6], [1, 6, 11, 6])
    np.testing.assert_allclose(np.array(figures["poles"])[:, 0], [-3, -2, -1], atol=1e-9)
    gain, _, at_gain, _ = control.margin(system)
    assert figures["margins"]["gain_margin"] == pytest.approx(gain) == pytest.approx(10.0)
    assert figures["margins"]["phase_crossover"] == pytest.approx(at_gain) == pytest.approx(np.sqrt(11))
    time, step = column(folder, "third_step.csv")
    np.testing.assert_allclose(step, control.step_response(system, time).outputs, atol=1e-9)
    # By partial fractions.
    np.testing.assert_allclose(step, 1 - 3 * np.exp(-time) + 3 * np.exp(-2 * time) - np.exp(-3 * time), atol=1e-9)
    time, impulse = column(folder, "third_impulse.csv")
    np.testing.assert_allclose(impulse, control.impulse_response(system, time).outputs, atol=1e-9)
    omega, magnitude, phases = column(folder, "third_bode.csv")
    value = system(1j * omega)
    np.testing.assert_allclose(magnitude, np.abs(value), rtol=1e-9)
    np.testing.assert_allclose(phases, np.unwrap(np.angle(value)), atol=1e-9)


def test_a_page_is_not_replaced_unless_one_says_so(tmp_path):
    (tmp_path / "third.html").write_text("mine")
    with pytest.raises(UsageError, match=r"third\.html"):
        write_lab(mjsim.parse_world(WORLD), tmp_path, plant="third")


def test_poles_are_placed_where_they_shall_be():
    design = placed_design(linear(), [-4, -3 + 2j, -3 - 2j])
    np.testing.assert_allclose(design.poles, [-4, -3 - 2j, -3 + 2j], atol=1e-6)
    plant = linear()
    closed = np.linalg.eigvals(plant.A - plant.B @ np.array([design.gain]))
    np.testing.assert_allclose(np.sort_complex(closed), design.poles, atol=1e-6)


def test_lqr_of_a_double_integrator_is_that_of_the_books():
    # Of x'' = u with Q = diag(1, 0) and R = 1: K = [1, sqrt(2)], a damping of 1 / sqrt(2).
    design = lqr_design(linear("double"), [1.0, 0.0], 1.0)
    assert design.gain == pytest.approx([1.0, np.sqrt(2.0)])
    # At its input LQR has a phase margin of 60 degrees or more.
    assert design.margins["phase_margin_deg"] >= 60.0


def test_ziegler_and_nichols_go_by_the_gain_that_just_oscillates():
    design = pid_design(linear(), "ziegler-nichols")
    # Ultimate gain 10, ultimate period 2 pi / sqrt(11).
    assert "gain 6, Ti 0.9472 s, Td 0.2368 s" in design.name
    assert design.is_stable
    assert design.step[0, -1] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("rule", ["tyreus-luyben", "simc"])
def test_other_rules_make_a_loop_that_settles_without_an_error(rule):
    design = pid_design(linear(), rule)
    assert design.is_stable
    law = control.tf(list(design.num), list(design.den))
    closed = control.feedback(control.tf([6], [1, 6, 11, 6]) * law)
    assert float(np.real(closed.dcgain())) == pytest.approx(1.0)


@pytest.mark.parametrize("lag", [1.0, 4.0])
def test_a_lead_gives_the_phase_margin_at_the_crossover(lag):
    design = lead_design(linear(), margin_deg=50.0, crossover=2.5, lag=lag)
    assert design.margins["phase_margin_deg"] == pytest.approx(50.0, abs=1e-6)
    assert design.margins["gain_crossover"] == pytest.approx(2.5, rel=1e-6)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (
            lambda: pid_design(linear(), "ziegler-nichol"),
            "no tuning rule 'ziegler-nichol'; did you mean",
        ),
        (
            lambda: pid_design(linear("double"), "simc"),
            "the plant is not stable; take another rule of --pid, or --place",
        ),
        (lambda: pid_design(linear("double"), "ziegler-nichols"), "no gain makes this plant oscillate; take"),
        (lambda: placed_design(linear(), [-1, -2]), "2 poles are given; the plant has 3, one for each of x1, x2, x3"),
        (
            lambda: placed_design(linear("double"), [-1 + 1j, -2]),
            "complex poles come in pairs, such as -2+1j and -2-1j",
        ),
        (
            lambda: lqr_design(linear("double"), [1.0], 1.0),
            "LQR needs 2 weights of 0 or more, of x1, x2, and an",
        ),
        (lambda: lqr_design(linear("double"), [1.0, 1.0], 0.0), "LQR needs 2 weights of 0 or more, of x1, x2, and an"),
        (lambda: lead_design(linear(), margin_deg=170.0, crossover=20.0), "one lead cannot give a margin of 170 deg"),
    ],
)
def test_what_cannot_be_designed_is_said_in_one_line(ask, message):
    with pytest.raises(UsageError) as caught:
        ask()
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_plant_is_identified_from_what_went_in_and_came_out():
    plant, rng, dt = linear(), np.random.default_rng(3), 0.05
    time = np.arange(800) * dt
    inputs = np.repeat(rng.choice([-1.0, 1.0], 80), 10)
    exact = control.forced_response(control.c2d(control.ss(plant.A, plant.B, plant.C, plant.D), dt), time, inputs)
    measured = exact.outputs + 1e-6 * rng.standard_normal(800)
    found = identified(plant, Samples(time=time, inputs=inputs, outputs=measured[None], source="a test"))
    np.testing.assert_allclose(found.poles.real, [-3, -2, -1], rtol=0.05)
    assert found.model_fit[0] > 99.9
    assert found.linear_fit[0] == pytest.approx(fit(measured, exact.outputs)[()], abs=1.0)


def test_fit_is_100_for_the_same_and_0_for_the_mean():
    y = np.array([[1.0, 2.0, 4.0]])
    assert fit(y, y).tolist() == [100.0]
    assert fit(y, np.full((1, 3), y.mean())).tolist() == [pytest.approx(0.0)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["dubble"], "no plant 'dubble' in this world; did you mean 'double'?"),
        (["double", "--lqr", "1,x"], "--lqr is '1,x'; give numbers separated by commas"),
        (["double", "--lead", "50"], "--lead is '50'; write a margin and a crossover, such as 50@6"),
        (["double", "--place", "-1,inf"], "--place is '-1,inf'; its numbers must be finite"),
    ],
)
def test_a_slip_of_the_keys_is_one_line(arguments, message, tmp_path, capsys):
    (tmp_path / "lab.yaml").write_text(WORLD)
    with pytest.raises(SystemExit) as end:
        main(["lab", str(tmp_path / "lab.yaml"), *arguments, "-o", str(tmp_path / "out")])
    assert end.value.code == 2
    assert capsys.readouterr().err.splitlines() == [message]


FORMULAS = """
mjsim: 1
plants:
  - {name: late, tf: {num: [2], den: [3, 1], delay: 0.5}}
  - {name: position, tf: {num: [10], den: [1, 10, 0]}}
  - {name: washout, tf: {num: [1, 0], den: [1, 1]}}
  - {name: gain, tf: {num: [3], den: [2]}}
  - {name: tuned, tf: {num: [1], den: [1, 0, 4]}}
  - {name: fast, tf: {num: [1.e12], den: [1, 1.e6, 1.e12]}}
  - name: two
    ss: {a: [[-1, 0.5], [0, -2]], b: [[1, 0], [0, 1]], c: [[1, 0], [0, 1], [1, 1]]}
    input: u2
    outputs: [y3, y1]
  - {name: deaf, ss: {a: [[-1]], b: [[0]], c: [[1]]}}
"""


def formula(name: str):
    world = mjsim.parse_world(FORMULAS)
    return experiment(world, next(plant for plant in world.plants if plant.name == name)).study


def test_a_delay_is_that_of_pade():
    study = formula("late")
    omega = np.array([0.1, 1.0, 3.0])
    exact = 2 / (3j * omega + 1) * np.exp(-0.5j * omega)
    np.testing.assert_allclose(study.loop(1j * omega), exact, rtol=1e-6)
    assert study.margins["gain_margin"] == pytest.approx(5.0356, abs=1e-3)


def test_one_input_of_several_is_looked_at():
    plant = formula("two").plant
    assert (plant.input, plant.outputs) == ("u2", ("y3", "y1"))
    np.testing.assert_array_equal(plant.B, [[0], [1]])
    np.testing.assert_array_equal(plant.C, [[1, 1], [1, 0]])


def test_what_swings_for_ever_is_shown_for_five_periods():
    study = formula("tuned")
    assert study.time[-1] == pytest.approx(5 * np.pi)
    assert formula("fast").time[-1] == pytest.approx(1.2e-5)


@pytest.mark.slow
def test_a_rule_sees_past_a_delay_and_a_response_that_goes_the_wrong_way_first():
    text = "mjsim: 1\nplants: [{name: p, tf: {num: [1, -1], den: [1, 2, 1], delay: 0.3}}]\n"
    world = mjsim.parse_world(text)
    assert pid_design(experiment(world, world.plants[0]).study.plant, "simc").is_stable


def test_simc_tunes_a_plant_that_integrates():
    # 1 / s with a lag of 0.1 s, which counts as dead time: gain 1 / (2 0.1), integral time 8 0.1.
    design = pid_design(formula("position").plant, "simc")
    assert design.num[0] / design.den[0] == pytest.approx(5.0, rel=1e-3)
    assert "Ti 0.8 s" in design.name
    assert design.is_stable


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: formula("deaf"), "plant 'deaf': u affects none of y; name another input"),
        (lambda: pid_design(formula("washout").plant, "simc"), "returns to 0 after a step"),
        (lambda: lqr_design(formula("gain").plant, [], 1.0), "has no states to feed back"),
        (lambda: lead_design(formula("tuned").plant, margin_deg=45.0, crossover=2.0), "has a pole at 2 rad/s"),
    ],
)
def test_plants_that_a_rule_does_not_suit_are_said_in_one_line(ask, message):
    with pytest.raises(UsageError, match=message):
        ask()


def test_a_root_locus_is_drawn_for_any_plant():
    for name in ("gain", "washout", "tuned"):
        assert poles_plot(formula(name)).axes
