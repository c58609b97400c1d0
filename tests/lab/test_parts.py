"""Pages, plots and texts of the laboratory from plants that are given, and what is read from a recording."""

import csv
import json
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import mjsim
from mjsim.lab import experiment, lqr_design, pid_design, plant_plots
from mjsim.lab.closed import ClosedLoop
from mjsim.lab.experiment import _nearest
from mjsim.lab.identify import Samples
from mjsim.lab.plant_page import _blocks, _facts, complex_text, figures_of, page_files
from mjsim.report import html_page, picture

WORLD = mjsim.parse_world("""
mjsim: 1
name: lab
plants:
  - {name: third, tf: {num: [6], den: [1, 6, 11, 6]}}
  - {name: double, ss: {a: [[0, 1], [0, 0]], b: [[0], [1]], c: [[1, 0], [0, 1]]}}
""")
THIRD, DOUBLE = WORLD.plants


@pytest.fixture(scope="module")
def third():
    return experiment(WORLD, THIRD)


@pytest.fixture(scope="module")
def full(third):
    """An experiment with everything that a page can have."""
    study = third.study
    time = np.linspace(0.0, 2.0, 50)
    rows = np.array([1 - np.exp(-time)])
    gains = lqr_design(study.plant, [1.0, 0.0, 0.0], 1.0)
    series = pid_design(study.plant, "ziegler-nichols")
    samples = Samples(time=time, inputs=np.sin(time), outputs=rows + 3.0, source="a test", held=True)
    found = SimpleNamespace(
        samples=samples, poles=np.array([-1.5 + 2j]), linear=rows * 0.5, model=rows * 0.9,
        linear_fit=np.array([50.0]), model_fit=np.array([90.125]),
    )  # fmt: skip
    loop = ClosedLoop(time=time, step=rows, fit=None, rough=(time, rows * 0.7))
    return replace(
        third, nonlinear=(time, rows), nonlinear_impulse=(time, rows * 2), nonlinear_fit=[99.5], dry_friction=0.25,
        held=1.5,
        rough=(time, rows * 0.8), step_poles=np.array([-1.0, -2.0, -3.0 + 0j]), identified=found,
        designs=(gains, series), closed=(loop, None),
    )  # fmt: skip


def lines(axes):
    return {line.get_label(): np.column_stack(line.get_data()) for line in axes.lines}


def test_a_page_has_matrices_figures_plots_and_controllers(full):
    names = ("step", "impulse", "bode", "nyquist", "poles", "identification", "design_1", "design_2")
    page = html_page("third", "mjsim lab", *_blocks(full, {name: picture(name, b"") for name in names}))
    facts = """third: a formula|Linear plant|A x + B u|<h3>A</h3>|x1|<h3>B</h3>|<h3>C</h3>|<h3>D</h3>|Figures</h2>
-3, -2, -1 rad/s|none|stable|yes|gain margin|10 at 3.31662 rad/s|phase margin
linear step response fits the nonlinear one|y 99.50 %|dry friction|0.25 at most|nearest poles|-1, -2, -3 rad/s
Responses</h2>|alt="step"|alt="impulse"|alt="bode"|alt="nyquist"|alt="poles"|Identification</h2>|alt="identification"
LQR, Q|closed-loop poles|stable|yes|feedback K|x1 |diverges after 2 s|gain: [|alt="design_1"
gain 6, Ti 0.9472 s|numerator|denominator|num: [|den: [|alt="design_2"|3 states; numbers by python-control."""
    at = 0
    for fact in facts.replace("\n", "|").split("|"):
        found = page.find(fact, at)
        assert found >= 0, fact
        at = found + len(fact)


def test_the_page_says_how_good_the_approximation_of_a_delay_is(third):
    late = replace(third, study=replace(third.study, plant=replace(third.study.plant, delay=0.5)))
    told = figures_of(late)["delay"]
    assert (told["seconds"], told["pade_order"]) == (0.5, 5)
    said = f"order 5, whose phase errs by less than 1 deg up to {told['exact_to_1_deg_up_to']:.4g} rad/s"
    assert said in html_page("late", "mjsim lab", _facts(late))


def test_figures_of_a_plant_are_numbers(full, third):
    told = figures_of(full)
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert (told["plant"], told["input"], told["outputs"], told["states"]) == ("third", "u", ["y"], ["x1", "x2", "x3"])
    assert np.sort(np.linalg.eigvals(told["A"])) == pytest.approx([-3, -2, -1])
    assert np.array(told["poles"]) == pytest.approx(np.array([[-3, 0], [-2, 0], [-1, 0]]), abs=1e-9)
    assert (told["zeros"], told["held_input"]) == ([], 1.5)
    assert told["margins"]["gain_margin"] == pytest.approx(10.0)
    assert (told["nonlinear_fit_percent"], told["nonlinear_seconds"], told["dry_friction"]) == ([99.5], 2.0, 0.25)
    assert told["identification"] == {
        "source": "a test", "poles": [[-1.5, 2.0]], "linear_fit_percent": [50.0], "identified_fit_percent": [90.125],
    }  # fmt: skip
    gains, series = told["designs"]
    assert (gains["name"], gains["gain"], gains["num"]) == (full.designs[0].name, list(full.designs[0].gain), [])
    assert (gains["nonlinear_fit_percent"], gains["nonlinear_seconds"]) == (None, 2.0)
    assert series["num"] == list(full.designs[1].num)
    assert "nonlinear_fit_percent" not in series
    bare = figures_of(third)
    assert not {"nonlinear_fit_percent", "dry_friction", "identification"} & set(bare)


def test_responses_are_drawn_beside_those_of_the_nonlinear_plant(full):
    time, linear = np.arange(3.0), np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    figure = plant_plots.response_plot("T", time, linear, ["a [m]", "b"], ("other", (time, -linear)), ("none", None))
    above, below = figure.axes
    assert figure.get_figheight() == pytest.approx(5.8)
    for axes, row in ((above, 0), (below, 1)):
        np.testing.assert_array_equal(lines(axes)["linear"], np.column_stack([time, linear[row]]))
        np.testing.assert_array_equal(lines(axes)["other"], np.column_stack([time, -linear[row]]))
        assert "none" not in lines(axes)
    assert (above.get_title(loc="left"), above.get_ylabel(), below.get_ylabel(), below.get_xlabel()) == (
        "T",
        "a [m]",
        "b",
        "time [s]",
    )
    drawn = plant_plots.design_plot(full.designs[0], full.closed[0], ["y"], amplitude=2.0).axes[0]
    np.testing.assert_allclose(lines(drawn)["linear"][:, 1], 2.0 * full.designs[0].step[0])
    np.testing.assert_allclose(lines(drawn)["with dry friction"][:, 1], 0.7 * full.closed[0].step[0])
    assert drawn.get_title(loc="left").startswith("Closed loop, a step of 2: LQR")
    assert set(lines(plant_plots.design_plot(full.designs[1], None, ["y"], amplitude=1.0).axes[0])) == {"linear"}


def test_bode_nyquist_and_nichols_are_those_of_the_transfer_function(third):
    study = third.study
    exact = 6 / ((1j * study.omega + 1) * (1j * study.omega + 2) * (1j * study.omega + 3))
    gain, phase = plant_plots.bode_plot(study).axes
    np.testing.assert_allclose(gain.lines[0].get_ydata(), 20 * np.log10(np.abs(exact)), atol=1e-6)
    np.testing.assert_allclose(phase.lines[0].get_ydata(), np.degrees(np.unwrap(np.angle(exact))), atol=1e-5)
    assert [text.get_text() for text in gain.get_legend().get_texts()] == ["gain margin 20 dB at 3.32 rad/s"]
    assert any(list(line.get_xdata()) == pytest.approx([math.sqrt(11)] * 2) for line in phase.lines[1:])
    assert (gain.get_ylabel(), phase.get_ylabel(), phase.get_xlabel()) == (
        "gain [dB]",
        "phase [deg]",
        "frequency [rad/s]",
    )
    assert gain.get_title(loc="left") == "Bode: u to y"
    nyquist, nichols = plant_plots.nyquist_plot(study).axes
    curve, mirrored, critical = (np.column_stack(line.get_data()) for line in nyquist.lines)
    np.testing.assert_allclose(curve, np.column_stack([exact.real, exact.imag]), atol=1e-9)
    np.testing.assert_allclose(mirrored, np.column_stack([exact.real, -exact.imag]), atol=1e-9)
    assert critical.tolist() == [[-1.0, 0.0]]
    assert nyquist.get_xlim() == pytest.approx((-1.6, 1.6))
    loop = np.column_stack(nichols.lines[0].get_data())
    np.testing.assert_allclose(loop[:, 0], np.degrees(np.unwrap(np.angle(exact))), atol=1e-5)
    assert np.ravel(nichols.lines[-1].get_data()).tolist() == [-180.0, 0.0]
    assert (nichols.get_xlabel(), nichols.get_ylabel(), nyquist.get_xlabel()) == ("phase [deg]", "gain [dB]", "real")


def test_poles_are_drawn_with_the_lines_of_equal_damping(third):
    plane, locus = plant_plots.poles_plot(third.study).axes
    np.testing.assert_allclose(lines(plane)["poles"], [[-3, 0], [-2, 0], [-1, 0]], atol=1e-9)
    assert plane.get_xlim() == pytest.approx((-3.9, 3.9))
    # The locus shows its crossing at sqrt(11).
    assert locus.get_xlim()[1] == pytest.approx(1.35 * np.sqrt(11.0))
    rays = [np.column_stack(line.get_data()) for line in plane.lines if len(line.get_xdata()) == 2][2:]
    assert len(rays) == 8
    ends = [ray[1] for ray in rays]
    assert sorted({round(float(-x / np.hypot(x, y)), 6) for x, y in ends}) == [0.2, 0.4, 0.6, 0.8]
    assert sum(y > 0 for _, y in ends) == 4
    arcs = [line for line in plane.lines if len(line.get_xdata()) == 90]
    assert arcs
    assert all(np.ptp(np.hypot(*arc.get_data())) < 1e-9 and max(arc.get_xdata()) < 1e-9 for arc in arcs)
    drawn = [line.get_xdata() + 1j * line.get_ydata() for line in locus.lines[3:6]]
    np.testing.assert_array_equal(drawn, third.study.locus.branches)


def test_what_was_identified_is_drawn_beside_what_was_measured(full):
    above, below = plant_plots.identified_plot(full.identified, ["y [m]"]).axes
    samples = full.identified.samples
    np.testing.assert_allclose(above.lines[0].get_ydata(), samples.inputs)
    assert above.lines[0].get_drawstyle() == "steps-post"
    assert above.get_title(loc="left") == "Identification from a test"
    drawn = lines(below)
    np.testing.assert_allclose(drawn["measured"][:, 1], samples.outputs[0] - samples.outputs[0, 0])
    np.testing.assert_allclose(drawn["linear plant, fit 50.00 %"][:, 1], full.identified.linear[0])
    np.testing.assert_allclose(drawn["identified, fit 90.12 %"][:, 1], full.identified.model[0])
    assert (below.get_ylabel(), below.get_xlabel(), above.get_ylabel()) == ("y [m]", "time [s]", "input")


def test_files_of_a_plant_are_page_numbers_plots_and_tables(third, monkeypatch):
    monkeypatch.setattr("mjsim.lab.plant_page.png_of", lambda figure: figure.axes[0].get_title(loc="left").encode())
    files = page_files(third)
    assert set(files) == {
        *(f"third.{end}" for end in ("html", "json")),
        *(f"third_{name}.png" for name in ("step", "impulse", "bode", "nyquist", "poles")),
        *(f"third_{name}.csv" for name in ("step", "impulse", "bode")),
    }
    assert files["third_step.png"] == b"Response to a step of u by 1"
    rows = list(csv.reader(files["third_step.csv"].decode().splitlines()))
    assert rows[0] == ["time_s", "y"]
    time, step = np.array(rows[1:], dtype=float).T
    np.testing.assert_allclose(step, 1 - 3 * np.exp(-time) + 3 * np.exp(-2 * time) - np.exp(-3 * time), atol=1e-6)
    rows = list(csv.reader(files["third_impulse.csv"].decode().splitlines()))
    time, impulse = np.array(rows[1:], dtype=float).T
    np.testing.assert_allclose(impulse, 3 * np.exp(-time) - 6 * np.exp(-2 * time) + 3 * np.exp(-3 * time), atol=1e-6)
    rows = list(csv.reader(files["third_bode.csv"].decode().splitlines()))
    assert rows[0] == ["omega_rad_s", "magnitude", "phase_rad"]
    omega, magnitude, phase = np.array(rows[1:], dtype=float).T
    np.testing.assert_allclose(
        magnitude * np.exp(1j * phase), 6 / ((1j * omega + 1) * (1j * omega + 2) * (1j * omega + 3)), rtol=1e-6
    )


def test_complex_numbers_are_written_with_their_sign():
    assert [complex_text(each) for each in (-1.5 + 0j, -1 + 2j, -1 - 2j, 0.1 + 1e-13j)] == [
        "-1.5",
        "-1+2j",
        "-1-2j",
        "0.1",
    ]
    assert [complex_text(complex(*pair)) for pair in ((-0.0, 0.0), (-0.0, 2.0), (-1e-17, 0.0))] == ["0", "0+2j", "0"]
    many = np.array([-1 + 1j, -5.0, -1 - 1j])
    assert _nearest(many, np.array([-4.0, -1 - 2j])).tolist() == [-5.0, -1 - 1j]


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        # Ultimate gain 10, period 2 pi / sqrt(11).
        ("tyreus-luyben", (10 / 2.2, 2.2 * 1.894444, 1.894444 / 6.3)),
        ("ziegler-nichols", (6.0, 0.947222, 0.236806)),
    ],
)
def test_tuning_rules_are_those_of_their_tables(third, rule, expected):
    design = pid_design(third.study.plant, rule)
    kp, ti, td = (
        float(each) for each in re.search(r"gain ([\d.]+), Ti ([\d.]+) s, Td ([\d.]+) s", design.name).groups()
    )
    assert (kp, ti, td) == pytest.approx(expected, rel=1e-3)
