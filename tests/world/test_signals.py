"""Signals in world files: what they mean, and one line for each mistake."""

import numpy as np
import pytest

import mjsim
from mjsim.errors import WorldError
from mjsim.world import Signal, Source, signal_of

HEAD = (
    "obstacles: [{name: ball, sphere: 0.2, at: [0, 0], movable: true, mass: 2}]\nrun: {events: [{time: 0.2, push: ball,"
)
WRONG = {
    "no kind": ("{}", "a signal is one of constant, step, ramp, sine, square, sawtooth, pulse, chirp, random, table;"),
    "two kinds": ("{step: {to: 1}, ramp: {slope: 1}}", "a signal is of one kind; this one has step and ramp"),
    "a misspelt kind": ("{sinus: {amplitude: 1, frequency_hz: 1}}", "unknown key 'sinus'; did you mean 'sine'?"),
    "a misspelt key": ("{step: {to: 1, att: 2}}", "unknown key 'att'; did you mean 'at'?"),
    "a key missing": ("{ramp: {from: 1}}", "slope is missing; add slope, or slope_deg for an angle"),
    "no frequency": ("{sine: {amplitude: 1}}", "key 'frequency_hz' is missing; add it: frequency [Hz]"),
    "an angle as a force": (
        "{sine: {amplitude_deg: 1, frequency_hz: 1}}",
        "this is not an angle; write amplitude for ampl",
    ),
    "two units": ("{step: {from_deg: 1, to: 2}}", "to is not an angle, but from_deg is; give all values with _deg, or"),
    "a number": ("3", "signal is 3 N; it must be keys with values"),
    "not a number": ("{constant: {value: .nan}}", "value is nan; it must be a finite number"),
    "a text": ("{constant: {value: much}}", "value is 'much'; it must be a number"),
    "a frequency of 0": ("{square: {amplitude: 1, frequency_hz: 0}}", "frequency_hz is 0 Hz; it must be above 0"),
    "a long pulse": ("{pulse: {amplitude: 1, width: 3, every: 2}}", "width is 3 s; a pulse every 2 s is at most that"),
    "a table of nothing": ("{table: {}}", "a table has a file or points; this one has neither"),
    "a table of two": ("{table: {file: a.csv, points: [[0, 1]]}}", "a table has a file or points; this one has both"),
    "a file that is not there": (
        "{table: {file: force.cvs}}",
        "no file 'force.cvs' beside the world file or in assets; did",
    ),
    "a file elsewhere": (
        "{table: {file: ../force.csv}}",
        "path '../force.csv' is outside its folder; name a file beside",
    ),
    "a column too far": ("{table: {file: force.csv, column: 9}}", "'force.csv' has no column 9; it has 3"),
    "a misspelt column": (
        "{table: {file: force.csv, column: fource}}",
        "'force.csv' has no column 'fource'; did you mean",
    ),
    "a word among numbers": ("{table: {file: words.csv}}", "words.csv:3: 'many' is not a finite number"),
    "a short line": ("{table: {file: short.csv}}", "short.csv:2: the line has 1 columns; it must have 2 or more"),
    "a picture": ("{table: {file: picture.csv}}", "'picture.csv' is not UTF-8 text; write a table of numbers (CSV)"),
    "an empty file": ("{table: {file: empty.csv}}", "'empty.csv' is empty; write lines such as '0.0, 1.5'"),
    "only names": ("{table: {file: names.csv}}", "'names.csv' has no line of numbers; write lines such as"),
    "times that go back": ("{table: {points: [[0, 1], [2, 1], [1, 0]]}}", "time 1 follows 2; times must increase"),
    "times that stand": ("{table: {file: stands.csv}}", "time 1 follows 1; times must increase"),
    "a column of points": (
        "{table: {points: [[0, 1]], column: 2}}",
        "columns are those of a file; leave them out beside",
    ),
    "one point that repeats": ("{table: {points: [[0, 1]], repeat: true}}", "a table of one time cannot repeat; give"),
    "a point of three": ("{table: {points: [[0, 1, 2]]}}", "points[0] is [0, 1, 2]; it must "),
    "a column 0": ("{table: {file: force.csv, column: 0}}", "column is 0; "),
}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "force.csv").write_text("\ufeff# measured\ntime; force ;other\n0;1.5;0\n\n2;3.5;0\n", encoding="utf-8")
    (tmp_path / "words.csv").write_text("0,1\n1,2\n2,many\n")
    (tmp_path / "short.csv").write_text("0,1\n1\n")
    (tmp_path / "stands.csv").write_text("0 \t1\n1\t2\n1\t3\n")
    (tmp_path / "names.csv").write_text("time,force\n")
    (tmp_path / "empty.csv").write_text("\n# nothing\n")
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe")
    return tmp_path


def pushed(signal: str, folder) -> mjsim.World:
    text = f"{HEAD} signal: {signal}}}]}}\n"
    return mjsim.parse_world(text, source=Source(file="room.yaml", folder=folder))


@pytest.mark.parametrize("name", WRONG)
def test_a_mistake_is_one_line_with_its_place(name, folder):
    text, message = WRONG[name]
    with pytest.raises(WorldError) as caught:
        pushed(text, folder)
    (line,) = str(caught.value).splitlines()
    assert line.startswith("room.yaml:2:")
    assert message in line


def test_a_table_is_read_from_a_file_beside_the_world(folder):
    world = pushed("{table: {file: force.csv, time: time, column: force}}", folder)
    (event,) = world.run.events
    assert event.signal.made(world.read_asset).value([0.0, 1.0, 2.0]).tolist() == [1.5, 2.5, 3.5]


def test_an_angle_is_in_degrees_and_becomes_radians():
    made = signal_of({"ramp": {"from_deg": 90, "slope_deg": 180}}, angle=True)
    np.testing.assert_allclose([made.value(1.0), made.rate(1.0)], [1.5 * np.pi, np.pi])
    with pytest.raises(ValueError, match="this is an angle, in degrees; write slope_deg for slope"):
        signal_of({"ramp": {"slope": 1}}, angle=True)


def test_a_signal_that_is_no_mapping_is_named_as_such():
    with pytest.raises(ValueError, match=r"^a signal is 3; it must be a mapping, such as \{'constant': 0.3\}$"):
        signal_of(3)


def test_a_file_of_an_angle_is_in_degrees_unless_it_says_otherwise(folder):
    signal = Signal.model_validate({"table": {"file": "force.csv"}})
    read = (folder / "force.csv").read_bytes()
    assert float(signal.made(lambda name: read, angle=True).value(0.0)) == pytest.approx(np.radians(1.5))
    assert float(signal.made(lambda name: read).value(0.0)) == 1.5


@pytest.mark.parametrize("keys", [{"step": {"from": 1, "to": 2}}, {"random": {"deviation_deg": 1, "hold": 0.1}}])
def test_a_signal_reads_back_equal(keys):
    signal = Signal.model_validate(keys)
    assert Signal.model_validate(signal.model_dump(exclude_defaults=True)) == signal


def test_a_world_with_signals_is_written_and_read_back(folder):
    world = pushed("{step: {from: 1, to: 2}}", folder)
    assert mjsim.parse_world(mjsim.format_world(world)) == world
