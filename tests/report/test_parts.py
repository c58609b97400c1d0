"""The part of a recording between two times: its figures are those of a recording of that part alone."""

import json
from pathlib import Path

import av
import numpy as np
import pytest

import mjsim
from mjsim.cli import main
from tests.record_ticks import hand_made_ticks, record

TICKS = list(hand_made_ticks(40))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The whole of a run, and its ticks from 0.4 s to 1.16 s recorded alone."""
    folder = tmp_path_factory.mktemp("recordings")
    return record(folder / "whole.mcap", TICKS), record(folder / "part.mcap", TICKS[10:30])


def without_clock(figures):
    """Return figures without those of the clock on the wall."""
    run = {key: value for key, value in figures["run"].items() if key not in ("wall_seconds", "real_time_factor")}
    return {**figures, "run": run}


def test_figures_between_two_times_are_those_of_a_recording_of_that_part_alone(files):
    whole, part = (mjsim.read_recording(file) for file in files)
    figures = mjsim.statistics(whole, begin=0.4, end=1.16)
    assert without_clock(figures) == without_clock(mjsim.statistics(part)) == without_clock(mjsim.statistics(files[1]))
    assert without_clock(figures) != without_clock(mjsim.statistics(whole))
    assert figures["run"]["sim_seconds"] == pytest.approx(20 * 0.04)
    assert figures["run"]["wall_seconds"] <= whole.wall_seconds


def test_a_part_has_the_ticks_between_both_times_and_nothing_else(files):
    whole = mjsim.read_recording(files[0])
    part = whole.between(0.41, 0.5)
    np.testing.assert_allclose(part.time, [0.44, 0.48])
    track = part.robots["scout"]
    np.testing.assert_array_equal(track.truth, whole.robots["scout"].truth[11:13])
    assert track.sightings == whole.robots["scout"].sightings[11:13]
    assert len(part.qpos) == len(part.clock) == len(track.innovations) == len(track.landmarks.mean) == 2
    assert not track.events
    assert [event.time for event in whole.between(0.1, 0.2).robots["scout"].events] == [0.16]
    assert whole.between() is whole
    assert len(whole.between(end=0.0).time) == len(whole.between(1.55).time) == 1


def test_a_part_of_a_run_without_a_file_keeps_what_is_read_on_request():
    world = mjsim.parse_world("mjsim: 1\nrobots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]")
    with mjsim.Simulation(world) as sim:
        part = mjsim.run(sim, seconds=0.2).between(0.0, 0.1)  # of the whole nothing else is left
    assert len(list(part.observations("scout"))) == 5


def test_between_two_ticks_there_is_nothing(files):
    with pytest.raises(mjsim.UsageError, match=r"no tick is between 0\.41 and 0\.43 s; .* from 0 to 1\.56 s"):
        mjsim.read_recording(files[0]).between(0.41, 0.43)


@pytest.mark.slow
def test_the_command_line_reports_and_films_a_part(files, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for words in (
        ("report", str(files[0]), "-o", "report", "--from", "0.4", "--to", "1.16"),
        ("video", str(files[0]), "-o", "part.mp4", "--view", "plan", "--from", "0.4", "--to", "0.56"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 0
    figures = json.loads(Path("report/statistics.json").read_text())
    assert figures["robots"]["scout"] == mjsim.statistics(mjsim.read_recording(files[1]))["scout"]
    with av.open("part.mp4") as film:
        assert sum(1 for _ in film.decode(video=0)) == 5
