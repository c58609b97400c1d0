"""Thousands of wall segments: read, checked and compiled in seconds and little memory, each in proportion."""

import time

import pytest

from mjsim.bench.large import in_its_own_process, large_floor
from mjsim.world import load_checked, parse_world, segments
from mjsim.world.yaml.scan import exact_events


def yardstick() -> float:
    """Return how long this machine takes for a text that never changes, read by the slow parser: 0.04 s of it [s]."""
    text = large_floor(100)
    began = time.process_time()
    assert sum(1 for _ in exact_events(text)) > 1400
    return time.process_time() - began


@pytest.mark.slow
def test_thousands_of_segments_take_seconds_and_little_memory_in_proportion(tmp_path):
    found = {}
    before = yardstick()
    for count in (500, 1000, 2500):
        path = tmp_path / f"{count}.yaml"
        path.write_text(large_floor(count), encoding="utf-8")
        found[count] = in_its_own_process(path)
    # 1.25 s where the yardstick takes 0.04 s, and half as much again for what else the machine does.
    assert found[2500][0] < 1.5 * 1.25 / 0.04 * max(before, yardstick())
    # So 5000 take less than 500 MB: 500 take 125, and each 1000 more would be 80.
    assert found[2500][1] < 125.0 + 2 * 80.0
    # Five times the walls take 5 times the time, never 25 times that of each with each; processor time of so short
    # a process varies by half where others share its core.
    assert found[2500][0] < 3.0 * 2.5 * found[1000][0]
    assert found[2500][0] < 3.0 * 5 * found[500][0]
    # Memory beyond that of 500 segments: 2000 more need 4 times as much as 500 more.
    assert found[2500][1] - found[500][1] < 1.5 * 4 * (found[1000][1] - found[500][1])


@pytest.mark.slow
def test_the_plan_of_two_thousand_segments_takes_a_second():
    world = parse_world(large_floor(2000))
    before = yardstick()
    began = time.process_time()
    faces = segments(world)
    assert time.process_time() - began < 0.8 / 0.04 * max(before, yardstick())
    # Outside 5, 2 at the door, inside 13 with the wall across, 4 where what is under the window begins and ends.
    assert len(faces) == 400 * 24


def test_a_floor_of_a_few_rooms_is_sound(tmp_path):
    path = tmp_path / "floor.yaml"
    path.write_text(large_floor(60), encoding="utf-8")
    world = load_checked(path)
    assert sum(len(wall.segments()) for wall in world.walls) == 60
