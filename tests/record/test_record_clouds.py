"""Point clouds in recordings: read back exactly, drawn by Foxglove as they are, and told in tables."""

import csv
import struct
from dataclasses import replace

import numpy as np
import pytest
from mcap.reader import make_reader

import mjsim
from mjsim.record import export_csv, read_recording
from mjsim.record.readings.clouds import CLOUDS
from mjsim.world import parse_world

WORLD = """
mjsim: 1
walls: [{points: [[0, 0], [5, 0], [5, 4], [0, 4]], closed: true}]
robots:
  - {name: scout, at: [2, 2], sensors: [{lidar3d: top, rings: 4, columns: 60, noise: {range: 0.01}}]}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    clouds, path = [], tmp_path_factory.mktemp("clouds") / "run.mcap"
    with mjsim.Simulation(parse_world(WORLD), seed=1) as sim:
        keep = lambda tick: clouds.extend(tick.seen["scout"].clouds.values())  # noqa: E731
        recording = mjsim.run(sim, seconds=0.4, record=path, watch=keep)
    return path, recording, clouds


def test_clouds_are_read_back_as_modules_got_them(run):
    _, recording, clouds = run
    back = [seen.clouds["top"] for seen in recording.observations("scout") if seen.clouds]
    assert len(back) == len(clouds) > 3
    for told, kept in zip(clouds, back, strict=True):
        assert kept.stamp == told.stamp
        for part in ("points", "times", "intensities", "rings"):
            np.testing.assert_array_equal(getattr(kept, part), getattr(told, part))
            assert getattr(kept, part).dtype == getattr(told, part).dtype


def test_foxglove_gets_every_point_of_each_cloud(run):
    path, _, clouds = run
    with path.open("rb") as file:
        messages = [message.data for _, _, message in make_reader(file).iter_messages(topics=["/scout/top/points"])]
    assert len(messages) == len(clouds)
    for message, cloud in zip(messages, clouds, strict=True):
        columns = *cloud.points.T.tolist(), cloud.intensities.tolist(), cloud.times.tolist(), cloud.rings.tolist()
        assert b"".join(struct.pack("<5fH", *row) for row in zip(*columns, strict=True)) in message
        assert b"scout/top" in message


def test_tables_have_a_row_a_point(run, tmp_path):
    path, _, clouds = run
    export_csv(read_recording(path), tmp_path / "csv")
    with (tmp_path / "csv" / "scout_cloud_top.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(cloud.points) for cloud in clouds)
    assert float(rows[0]["x"]) == pytest.approx(float(clouds[0].points[0, 0]))


@pytest.mark.parametrize("column", ["times", "intensities", "rings"])
def test_a_cloud_of_uneven_columns_is_refused(run, column):
    _, _, clouds = run
    (message,) = CLOUDS.encode({"top": clouds[0]})
    parts = ("points", "times", "intensities", "rings")
    (short,) = CLOUDS.encode({"top": replace(clouds[0], **{name: getattr(clouds[0], name)[:-1] for name in parts})})
    with pytest.raises(ValueError, match="points with unequal counts of times, intensities or rings"):
        CLOUDS.decode([{**message, column: short[column]}])
