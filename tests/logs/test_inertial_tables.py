"""Inertial readings of a bag, held in one array."""

import tracemalloc

import numpy as np
import pytest

from mjsim.logs.bags.bag_contents import Contents
from mjsim.logs.bags.bag_file import Bag
from mjsim.logs.bags.bag_topics import robots_of
from mjsim.logs.resampling.timed_readings import InertialTable, sensors_of, stamps_of
from tests.bags import START, new_bag
from tests.real_logs import imported

COUNT = 2000


def test_readings_of_several_sensors_are_in_order_of_time():
    rng = np.random.default_rng(0)
    tables = {name: rng.normal(size=(count, 7)) for name, count in (("a", 5), ("none", 0), ("b", 7))}
    table = InertialTable(tables)
    expected = sorted(
        ((row[0], name, row[1:4], row[4:]) for name, rows in tables.items() for row in rows), key=lambda each: each[0]
    )
    assert len(table) == len(expected) == len(table[:])
    for reading, (stamp, name, acceleration, turn) in zip(table, expected, strict=True):
        assert (reading.stamp, reading.name) == (stamp, name)
        np.testing.assert_array_equal(reading.acceleration, acceleration)
        np.testing.assert_array_equal(reading.turn, turn)
    np.testing.assert_array_equal(stamps_of(table), stamps_of(table[:]))
    assert sensors_of(table) == sensors_of(table[:]) == ["a", "b"]
    assert [each.stamp for each in table[-3:]] == [row[0] for row in expected[-3:]]
    with pytest.raises(IndexError):
        table[len(table)]


@pytest.mark.slow
def test_an_hour_of_inertial_readings_takes_few_bytes_each(tmp_path):
    with new_bag(tmp_path / "bag") as bag:
        for k in range(COUNT):
            told = bag.imu(
                bag.header(START + 0.0025 * k, "imu"), np.array([0.0, 0.1, 9.8]), np.array([0.0, 0.0, 0.01 * k])
            )
            bag.put("/imu", START + 0.0025 * k, told)
    with Bag(tmp_path / "bag") as opened:
        robots = robots_of(opened.types, topics_by_kind={}, names=())
        Contents(opened, robots)  # imports its libraries
        tracemalloc.start()
        contents = Contents(opened, robots)
        kept, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert len(contents.imus["/imu"]) == 7 * COUNT
    # Seven numbers, and two of its clock; a reading as a value of its own takes 500.
    assert kept / COUNT < 150.0
    run = imported(tmp_path / "bag")
    turns = [reading.turn[2] for seen in run.observations("robot") for reading in seen.imu]
    np.testing.assert_array_equal(turns, 0.01 * np.arange(COUNT))
