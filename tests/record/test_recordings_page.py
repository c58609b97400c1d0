"""The page of recordings does what it says, and names every column, topic and attribute."""

import csv
import re
from dataclasses import fields
from pathlib import Path

import pytest
from mcap.reader import make_reader

import mjsim
from mjsim.record import export_csv

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "recordings.md").read_text(encoding="utf-8")
WORLD = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: a, at: [5.9, 1]}]
obstacles: [{name: crate, box: [0.5, 0.5, 0.5], at: [3, 3], movable: true}]
robots:
  - name: scout
    at: [1, 1]
    sensors:
      - {beacons: ring, range: [0.3, 8], fov_deg: 240, rate_hz: 5}
      - {camera: front, width: 32, height: 24}
run:
  seconds: 1.2
  drivers: {scout: {estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}}}
  events: [{time: 0.4, light: 0.5}]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("recorded")
    with mjsim.Simulation(mjsim.parse_world(WORLD)) as sim:
        mjsim.run(sim, seconds=1.2, record=place / "run.mcap")
    return place


@pytest.mark.slow
def test_the_program_of_the_page_runs(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    (code,) = re.findall("```python\n(.*?)```", PAGE, re.DOTALL)
    exec(code, {})
    first, second, third = capsys.readouterr().out.splitlines()
    assert first.startswith("30 ticks, seed 1, largest error 0.0")
    assert second.startswith("1.16 ")
    assert third == "0.0 (24, 32, 3)"


@pytest.mark.slow
def test_the_page_names_every_column_topic_and_attribute(folder, monkeypatch):
    monkeypatch.chdir(folder)
    recording = mjsim.read_recording("run.mcap")
    spoken = set(re.findall(r"\w+", " ".join(re.findall("`[^`]*`", PAGE))))
    between = {"S_0_1", "S_1_0", "v1", "v2", "u1", "u2", "u3"}  # the page says "to"
    for path in export_csv(recording, "tables"):
        with path.open() as file:
            columns = next(csv.reader(file))
        # The page has one example of covariances, and those of the truth for dead reckoning and estimate.
        plain = {re.sub("^(odometry|estimate)_", "truth_", column) for column in columns if "_cov_" not in column}
        assert not plain - spoken - between
    with Path("run.mcap").open("rb") as stream:
        topics = {channel.topic for channel in make_reader(stream).get_summary().channels.values()}
    listed = PAGE + (DOCS / "sensors.md").read_text(encoding="utf-8")
    assert not {topic for topic in topics if topic.replace("scout", "R").replace("front", "CAMERA") not in listed}
    named = {field.name for field in fields(mjsim.Recording)} - {"path"}
    assert not named - spoken
