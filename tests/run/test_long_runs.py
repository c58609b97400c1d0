"""What a run keeps in memory does not grow with its length."""

import time
import tracemalloc

import pytest

import mjsim
from mjsim.record import numeric_topics
from mjsim.record.file import raw_messages

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: a, at: [5.9, 1]}, {name: b, at: [0.1, 3]}, {name: c, at: [3, 3.9]}]
robots:
  - name: scout
    at: [1, 1]
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors:
      - {beacons: ring, range: [0.3, 8], fov_deg: 240, rate_hz: 12.5, noise: {range: 0.05, bearing_deg: 1}}
      - {lidar: scan, beams: 20}
run: {drivers: {scout: {
    estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"},
    navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[5, 1], [5, 3], [1, 3], [1, 1]], laps: 9}}}}
"""
WARM, SETTLED, TICKS = 140, 150, 300
"""Ticks after which memory is traced, and between which it is compared: the filter has room for its state by then."""
LEAST = 2000
"""A fifth of what a tick takes that is kept whole [bytes]."""


def grown(held):
    return tracemalloc.get_traced_memory()[0] - held[0]


@pytest.mark.slow
def test_a_run_that_is_recorded_keeps_nothing_of_its_ticks(tmp_path):
    held = []

    def watch(tick):
        count = round(tick.time * 25)
        if count == WARM:
            tracemalloc.start()
        elif count in (SETTLED, TICKS):
            # On a busy machine ticks wait for the recorder's thread: it takes them while the loop rests.
            until = time.monotonic() + 30.0
            while held and grown(held) >= LEAST * (TICKS - SETTLED) and time.monotonic() < until:
                time.sleep(0.05)
            held.append(tracemalloc.get_traced_memory()[0])

    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        try:
            mjsim.run(sim, seconds=(TICKS + 1) / 25, record=tmp_path / "run.mcap", watch=watch)
        finally:
            tracemalloc.stop()
    assert held[1] - held[0] < LEAST * (TICKS - SETTLED)


@pytest.mark.slow
def test_a_recording_without_pictures_holds_all_else(tmp_path):
    text = ROOM.replace("- {lidar", "- {camera: front, width: 64, height: 48, rate_hz: 12.5}\n      - {lidar")
    files = {}
    for pictures in (True, False):
        with mjsim.Simulation(mjsim.parse_world(text)) as sim:
            files[pictures] = tmp_path / f"{pictures}.mcap"
            mjsim.run(sim, seconds=0.4, record=files[pictures], pictures=pictures)
    drawn = numeric_topics(files[True])
    assert drawn.pop("/grid")
    assert drawn == numeric_topics(files[False])
    counts = [sum(message.topic == "/scout/front/image" for message in raw_messages(files[p])) for p in (True, False)]
    assert counts == [5, 0]
