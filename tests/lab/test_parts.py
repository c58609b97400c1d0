"""Pages, plots and texts of the laboratory from plants that are given, and what is read from a recording."""

import csv
import json
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import control
import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.lab import LinearPlant, ScenePlant, experiment, lqr_design, module_text, pid_design, plots
from mjsim.lab.closed import ClosedLoop
from mjsim.lab.design import Design
from mjsim.lab.effects import ForceEffect, LedJoint
from mjsim.lab.experiment import _nearest, plants_of
from mjsim.lab.identify import Samples
from mjsim.lab.page import _blocks, complex_text, figures_of, page_files
from mjsim.lab.parts import part_of, working_point
from mjsim.lab.recorded import recorded
from mjsim.record import JointTrack
from mjsim.report import html_page, picture
from mjsim.world import Plant

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
    figure = plots.response_plot("T", time, linear, ["a [m]", "b"], ("other", (time, -linear)), ("none", None))
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
    drawn = plots.design_plot(full.designs[0], full.closed[0], ["y"], amplitude=2.0).axes[0]
    np.testing.assert_allclose(lines(drawn)["linear"][:, 1], 2.0 * full.designs[0].step[0])
    np.testing.assert_allclose(lines(drawn)["with dry friction"][:, 1], 0.7 * full.closed[0].step[0])
    assert drawn.get_title(loc="left").startswith("Closed loop, a step of 2: LQR")
    assert set(lines(plots.design_plot(full.designs[1], None, ["y"], amplitude=1.0).axes[0])) == {"linear"}


def test_bode_nyquist_and_nichols_are_those_of_the_transfer_function(third):
    study = third.study
    exact = 6 / ((1j * study.omega + 1) * (1j * study.omega + 2) * (1j * study.omega + 3))
    gain, phase = plots.bode_plot(study).axes
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
    nyquist, nichols = plots.nyquist_plot(study).axes
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
    plane, locus = plots.poles_plot(third.study).axes
    np.testing.assert_allclose(lines(plane)["poles"], [[-3, 0], [-2, 0], [-1, 0]], atol=1e-9)
    assert plane.get_xlim() == pytest.approx((-3.9, 3.9))
    assert locus.get_xlim() == pytest.approx((-11.7, 11.7))
    rays = [np.column_stack(line.get_data()) for line in plane.lines if len(line.get_xdata()) == 2][2:]
    assert len(rays) == 8
    ends = [ray[1] for ray in rays]
    assert sorted({round(float(-x / np.hypot(x, y)), 6) for x, y in ends}) == [0.2, 0.4, 0.6, 0.8]
    assert sum(y > 0 for _, y in ends) == 4
    arcs = [line for line in plane.lines if len(line.get_xdata()) == 90]
    assert arcs
    assert all(np.ptp(np.hypot(*arc.get_data())) < 1e-9 and max(arc.get_xdata()) < 1e-9 for arc in arcs)
    # Points of the locus are closed-loop poles: the open loop there is real and negative.
    for branch in (line for line in locus.lines if line.get_marker() == "."):
        s = branch.get_xdata()[5:] + 1j * branch.get_ydata()[5:]
        s = np.append(s[(np.abs(s) < 20.0) & (np.abs((s + 1) * (s + 2) * (s + 3)) > 1e-3)], -3.5)
        open_loop = 6 / ((s + 1) * (s + 2) * (s + 3))
        assert np.abs(open_loop.imag / open_loop.real).max() < 1e-3
        assert (open_loop.real < 0).all()


def test_what_was_identified_is_drawn_beside_what_was_measured(full):
    above, below = plots.identified_plot(full.identified, ["y [m]"]).axes
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
    monkeypatch.setattr("mjsim.lab.page.png_of", lambda figure: figure.axes[0].get_title(loc="left").encode())
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


def test_cohen_and_coon_go_by_gain_dead_time_and_time_constant():
    world = mjsim.parse_world("mjsim: 1\nplants: [{name: late, tf: {num: [2], den: [3, 1], delay: 0.9}}]\n")
    design = pid_design(experiment(world, world.plants[0]).study.plant, "cohen-coon")
    kp, ti, td = (
        float(each) for each in re.search(r"gain ([\d.]+), Ti ([\d.]+) s, Td ([\d.]+) s", design.name).groups()
    )
    r = 0.3
    assert kp == pytest.approx((1.35 + 0.25 * r) / (2 * r), rel=0.1)
    assert ti == pytest.approx(0.9 * (2.5 + 0.46 * r) / (1 + 0.61 * r), rel=0.1)
    assert td == pytest.approx(0.37 * 0.9 / (1 + 0.19 * r), rel=0.1)


GAIN = Design(
    name="k", poles=np.zeros(0), margins={}, time=np.zeros(1), step=np.zeros((1, 1)), gain=(1.5, -2.0, 3.0, 4.0)
)
SERIES = Design(
    name="s", poles=np.zeros(0), margins={}, time=np.zeros(1), step=np.zeros((1, 1)), num=(1.0, 2.0), den=(3.0, 1.0)
)


def plain(states, of_input, unit, outputs=("y",)):
    n = len(states)
    return LinearPlant(
        A=np.zeros((n, n)), B=np.zeros((n, 1)), C=np.zeros((len(outputs), n)), D=np.zeros((len(outputs), 1)),
        states=states, input=of_input, outputs=outputs, units=(unit, *("",) * len(outputs)),
    )  # fmt: skip


def given(of, of_input, **around):
    return Plant.model_construct(name="p", of=of, input=of_input, outputs=("y",), around=around)


LAW, FED_BACK = "num: [1, 2], den: [3, 1]", "gain: [1.5, -2, 3, 4]"
USE = '{use: "mjsim.algorithms.linear_control:'
DRIVERS = "run:\n  drivers:\n    r:\n      "


@pytest.mark.parametrize(
    ("plant", "states", "outputs", "unit", "design", "text"),
    [
        (
            given("r/arm", "q"),
            ["q"],
            ["q"],
            "N m",
            SERIES,
            f'controllers: {{arm: {USE}JointLoop", joint: q, {LAW}}}}}\n',
        ),
        (
            given("r", "torque"),
            ["way", "lean"],
            ["y"],
            "N m",
            GAIN,
            f'{DRIVERS}controllers: {{drive: {USE}StateFeedback", {FED_BACK}}}}}\n',
        ),
        (
            given("r", "forward"),
            ["v"],
            ["y"],
            "m/s",
            SERIES,
            f'{DRIVERS}navigator: {USE}SpeedLoop", of: forward, {LAW}, reference: {{step: {{to: 0.3}}}}}}\n',
        ),
        (
            given("r", "turn"),
            ["v"],
            ["y"],
            "rad/s",
            SERIES,
            f"of: turn, {LAW}, reference: {{step: {{to_deg: 30}}}}}}\n",
        ),
        (given("r", "forward"), ["v"], ["y"], "m/s", GAIN, f"# a controller: {FED_BACK}\n"),
        (
            given("m", "x", x=0.5, q_deg=90.0),
            ["x", "q"],
            ["y"],
            "N",
            GAIN,
            f'actuators:\n  - force: x\n    controller: {USE}MechanismLoop",'
            " gain: {x: [1.5, 3], q: [-2, 4]}, about: {x: 0.5}, about_deg: {q: 90}}\n",
        ),
        (
            given("m", "q"),
            ["q"],
            ["q"],
            "N m",
            SERIES,
            f'  - torque: q\n    controller: {USE}MechanismLoop", {LAW}}}\n',
        ),
        (given("m", "q"), ["q"], ["other"], "N m", SERIES, f"# a controller: {LAW}\n"),
        (given(None, "u"), ["x1"], ["y"], "", SERIES, f"# a controller: {LAW}\n"),
    ],
)
def test_a_design_is_written_as_the_module_that_runs_it(plant, states, outputs, unit, design, text):
    states = (*states, *(f"{name}.rate" for name in states))
    assert module_text(plant, plain(states, plant.input, unit, tuple(outputs)), design).endswith(text)


def test_a_joint_that_is_led_needs_the_second_difference_of_its_values():
    force = ForceEffect(unit="N m", ctrl=np.zeros(0), applied=np.ones(1))
    inputs = np.array([0.0, 0.1, 0.3, 0.3])
    by_value, by_speed = (LedJoint(unit="", force=force, dof=0, is_speed=speed) for speed in (False, True))
    np.testing.assert_allclose(by_value.accelerations(inputs, 0.5), [0.0, 0.4, 0.4, -0.8])
    np.testing.assert_allclose(by_speed.accelerations(inputs, 0.5), [0.0, 0.2, 0.4, 0.0])


MECHANISM = """
mjsim: 1
mechanisms:
  - name: m
    elevation: 4
    bodies: [{name: arm, rod: [1.0, 0.03]}, {name: slider, box: [0.1, 0.1, 0.1], mass: 1}]
    joints:
      - {revolute: a, of: [ground, arm], axis: [0, 1, 0], damping: 0.5, start_deg: 90}
      - {prismatic: s, of: [{ground: [2, 0, 0]}, slider], axis: [1, 0, 0], damping: 2}
run: {step_ms: 2, rate_hz: 500}
plants: [PLANT]
"""


def scene(keys):
    world = mjsim.parse_world(MECHANISM.replace("PLANT", f"{{name: p, of: m, {keys}}}"))
    return world, ScenePlant(world, world.plants[0])


def made_up(world, lab, *, joints=None):
    n = 6
    time = 0.002 * np.arange(n)
    qpos = np.tile(lab.setting.qpos, (n, 1)) + 0.01 * np.arange(n)[:, None]
    rows = np.column_stack([np.arange(n) + 1.0, 10.0 * np.arange(n) + 5.0])
    track = JointTrack(
        names=("a", "s"), positions=rows, velocities=2 * rows, accelerations=rows, torques=3 * rows, goal=rows,
        tool=np.zeros((n, 7)),
    )  # fmt: skip
    joints = {"m": track} if joints is None else joints
    return SimpleNamespace(
        world=world, joints=joints, robots={}, time=time, qpos=qpos, qvel=np.zeros((n, lab.model.nv)), seed=1
    )


@pytest.mark.parametrize(
    ("keys", "values", "held"),
    [
        ("input: s.force, outputs: [s]", 3 * (10.0 * np.arange(6) + 5.0), False),
        ("input: a.torque, outputs: [a]", 3 * (np.arange(6) + 1.0), False),
        ("input: s.velocity, outputs: [a, s]", 20.0 * np.arange(6) * 1.0, False),
        ("input: a.angle, outputs: [a]", np.arange(6.0), False),
    ],
)
def test_the_input_of_a_mechanism_is_the_torque_or_motion_that_was_recorded(keys, values, held):
    world, lab = scene(keys)
    recording = made_up(world, lab)
    found = recorded(recording, lab)
    np.testing.assert_allclose(found.inputs, values)
    assert (found.held, found.source) == (held, "the recording")
    np.testing.assert_allclose(found.time, recording.time)
    place = int(lab.model.joint(f"m/{lab.plant.outputs[0]}").qposadr[0])
    np.testing.assert_allclose(found.outputs[0], recording.qpos[:, place])


def test_a_recording_of_something_else_is_refused():
    world, lab = scene("input: s.force, outputs: [s]")
    with pytest.raises(UsageError, match="the recording has no 'm'"):
        recorded(made_up(world, lab, joints={}), lab)
    other = made_up(world, lab)
    other.qpos = other.qpos[:, :1]
    with pytest.raises(UsageError, match="a scene with other joints"):
        recorded(other, lab)
    unknown = made_up(world, lab)
    unknown.joints["m"].torques[2] = np.nan
    assert len(recorded(unknown, lab).time) == 5


def test_a_scene_is_stepped_as_its_linear_plant_predicts():
    world, lab = scene("input: s.force, outputs: [s, s.rate]")
    assert lab.held.endswith(" N")
    assert not lab.leads_value
    assert lab.dry_friction == 0.0
    time = 0.002 * np.arange(200)
    found = lab.simulated(np.full(200, 3.0))
    np.testing.assert_allclose(found[1], 1.5 * (1 - np.exp(-2 * time)), atol=0.01)
    np.testing.assert_allclose(found[0], 1.5 * time - 0.75 * (1 - np.exp(-2 * time)), atol=0.01)
    poles = lab.step_poles()
    assert np.abs(poles + 2.0).min() < 0.01
    assert lab.simulated(np.full(200, 3.0), bound=0.1).shape[1] < 200
    assert world.plants[0].name == "p"
    assert scene("input: s.position, outputs: [s]")[1].leads_value


def test_robots_have_motors_a_pitch_a_heading_and_a_way():
    world = mjsim.parse_world("mjsim: 1\nrobots: [{name: r, at: [1, 2]}]\n")
    from mjsim.compile import compile_world

    model = compile_world(world).compile()
    qpos = np.array(model.qpos0)
    free = int(model.joint("r/free").qposadr[0])
    yaw, pitch = 0.7, -0.2
    quaternion = np.zeros(4)
    turn, lean = (
        np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]),
        np.array([math.cos(pitch / 2), 0, math.sin(pitch / 2), 0]),
    )
    mujoco.mju_mulQuat(quaternion, turn, lean)
    qpos[free : free + 7] = [1.5, 2.0, 0.1, *quaternion]
    part = part_of(model, world, "r", qpos)
    told = {name: (unit, measure(qpos)) for name, (unit, measure) in part.measures.items()}
    assert told["lean"] == ("rad", pytest.approx(pitch))
    assert told["heading"] == ("rad", pytest.approx(yaw))
    assert told["way"] == ("m", pytest.approx(1.5))
    drive = world.robots[0].drive
    r, half = drive.wheel_radius, drive.track / 2
    left, right = (model.actuator(f"r/wheel_{side}").id for side in ("left", "right"))
    forward, spin = part.effects["forward"], part.effects["turn"]
    assert (forward.ctrl[left], forward.ctrl[right]) == pytest.approx((1 / r, 1 / r))
    assert (spin.ctrl[left], spin.ctrl[right]) == pytest.approx((-half / r, half / r))
    assert (forward.unit, spin.unit, part.effects["wheel_left"].unit) == ("m/s", "rad/s", "rad/s")
    assert part.effects["wheel_left"].ctrl[left] == 1.0
    dof = int(model.joint("r/free").dofadr[0])
    assert part.prefer == (dof, dof + 5, dof + 4)
    with pytest.raises(UsageError, match="no robot, arm or mechanism 'q'"):
        part_of(model, world, "q", qpos)
    plant = Plant.model_construct(name="p", of="r", around={"wheel_left": 1.0})
    with pytest.raises(UsageError, match="joint wheel_left turns; write wheel_left_deg"):
        working_point(model, part, plant)
    right_one = Plant.model_construct(name="p", of="r", around={"wheel_left_deg": 90.0})
    assert list(working_point(model, part, right_one).values()) == [pytest.approx(math.pi / 2)]
    wrong = Plant.model_construct(name="p", of="r", around={"wheel_lft_deg": 1.0})
    with pytest.raises(UsageError, match="around has 'wheel_lft_deg'"):
        working_point(model, part, wrong)


def test_plants_are_found_by_name():
    assert plants_of(WORLD, None) == [THIRD, DOUBLE]
    assert plants_of(WORLD, "double") == [DOUBLE]
    with pytest.raises(UsageError, match="has no plants"):
        plants_of(mjsim.parse_world("mjsim: 1\n"), None)
    with pytest.raises(UsageError, match="plant 'third' is a formula"):
        experiment(WORLD, THIRD, recording=SimpleNamespace())
    found = experiment(WORLD, DOUBLE)
    assert (found.labels, found.name, found.amplitude, found.study.is_stable) == (["y1", "y2"], "double", 1.0, False)
    assert experiment(WORLD, THIRD).study.is_stable
    assert float(np.real(control.ss(*(getattr(found.study.plant, key) for key in "ABCD")).poles()).max()) == 0.0


def test_a_scene_is_linearised_simulated_and_identified():
    keys = "input: s.force, outputs: [s.rate], amplitude: 2, seconds: 1.5"
    world = mjsim.parse_world(MECHANISM.replace("PLANT", f"{{name: p, of: m, {keys}}}"))
    found = experiment(world, world.plants[0])
    assert found.labels == ["s.rate [m/s]"]
    assert found.about.startswith("m, from s.force to s.rate; ")
    time, step = found.nonlinear
    np.testing.assert_allclose(step[0], 1.0 - np.exp(-2.0 * time), atol=0.01)
    assert time[-1] == pytest.approx(found.study.time[-1], abs=0.004)
    assert found.nonlinear_fit[0] > 98.0
    time, impulse = found.nonlinear_impulse
    np.testing.assert_allclose(impulse[0][2:], 2.0 * np.exp(-2.0 * time[2:]), atol=0.02)
    assert (found.rough, found.dry_friction) == (None, 0.0)
    assert np.abs(found.step_poles - found.study.poles).max() < 0.01
    assert found.study.poles.real.max() == pytest.approx(-2.0, abs=1e-6) or found.study.poles.real.max() > -1e-6


def test_a_turned_base_is_identified_as_one_that_heads_along_x():
    from mjsim.lab.recorded import _turn_back

    half = 0.35
    poses = np.array([[1.0, 2.0, 0.1, math.cos(half), 0.0, 0.0, math.sin(half)]] * 2)
    poses[1, :2] += 0.5 * np.array([math.cos(0.7), math.sin(0.7)])
    speeds = np.array([[math.cos(0.7), math.sin(0.7), 0.2]] * 2)
    _turn_back(poses, speeds)
    np.testing.assert_allclose(poses[:, :3], [[0.0, 0.0, 0.1], [0.5, 0.0, 0.1]], atol=1e-12)
    np.testing.assert_allclose(poses[:, 3:], [[1.0, 0.0, 0.0, 0.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(speeds, [[1.0, 0.0, 0.2]] * 2, atol=1e-12)
