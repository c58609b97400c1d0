"""The page of the figures names each of them, and its examples run."""

import re
from pathlib import Path

import pytest

import mjsim
from mjsim.report import statistics_file
from mjsim.report.statistics import robot_statistics

PAGE = Path(__file__).parents[2] / "docs" / "statistics.md"
WORLD = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: a, at: [5.9, 1]}]
robots: [{name: scout, at: [1, 1], sensors: [{beacons: ring, range: [0.3, 8], fov_deg: 240, rate_hz: 5}]}]
run: {seconds: 1, rate_hz: 10, drivers: {scout: {estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}}}}
"""


def keys_of(figures):
    for key, value in figures.items():
        yield key
        if isinstance(value, dict) and key not in ("each", "aligned_each", "milliseconds"):
            yield from keys_of(value)


@pytest.mark.slow
def test_every_key_stands_in_the_page_and_its_examples_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("run.mcap", "other.mcap"):
        with mjsim.Simulation(mjsim.parse_world(WORLD)) as sim:
            recording = mjsim.run(sim, record=name)
    figures = statistics_file(recording)
    assert figures["robots"]["scout"] == robot_statistics(recording.world, "scout", recording.robots["scout"])
    page = PAGE.read_text(encoding="utf-8")
    text = re.sub(r"```.*?```", "", page, flags=re.DOTALL)
    named = {part for name in re.findall(r"`([\w.]+)`", text) for part in name.split(".")}
    assert not {*keys_of(figures["run"]), *keys_of(figures["robots"]["scout"])} - named
    for code in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(code, {"mjsim": mjsim})
    assert "one pair is too few" in capsys.readouterr().out
