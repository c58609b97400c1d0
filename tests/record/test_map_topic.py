"""The map that Foxglove draws: what moves has a frame of its own, what events change is drawn anew."""

from pathlib import Path

import numpy as np
import pytest

from mjsim.record import Recording, read_recording
from mjsim.run import run
from mjsim.sim import Simulation
from mjsim.world import parse_world

TEXT = """
mjsim: 1
walls: [{points: [[0, 0], [4, 0]], openings: [{name: gate, segment: 0, at: 1, width: 1, door: {angle_deg: 90}}]}]
obstacles:
  - {box: [0.5, 0.25, 1.125], at: [1, 3], name: rack}
  - {cylinder: [0.2, 1.5], at: [2, 1.5], name: cart, path: {points: [[3, 1.5]]}}
beacons: [{name: plate, at: [0.2, 0], on: cart, center: 1}, {name: owl, at: [3, 3]}]
lamps: [{name: spot, at: [2, 3], color: "#ffffff"}]
robots: [{name: r, at: [3, 2]}]
run:
  seconds: 0.4
  events: [{time: 0.2, remove: rack}, {time: 0.2, remove: cart}, {time: 0.3, lamp: spot, brightness: 0.25}]
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path: Path = tmp_path_factory.mktemp("map") / "run.mcap"
    with Simulation(parse_world(TEXT)) as sim:
        run(sim, record=path)
    return read_recording(path)


def number(value: float) -> bytes:
    return np.float64(value).tobytes()


def test_what_moves_is_drawn_in_a_frame_that_moves(recording: Recording):
    first, *_ = recording.messages("/map")
    for entity in (b"obstacle/cart", b"door/gate", b"beacon/plate", b"lamps"):
        assert entity in first
    frames = list(recording.messages("/tf"))
    assert all(b"door/gate" in message for message in frames)
    # The cart goes at half a metre a second.
    assert number(2.0 + 0.5 * recording.time[4]) in frames[4]
    # The leaf points north: half of a right angle is in its quaternion.
    assert number(np.sin(np.pi / 4)) in frames[0] or number(np.cos(np.pi / 4)) in frames[0]


def test_what_is_taken_away_is_drawn_no_more_and_a_dimmed_lamp_is_darker(recording: Recording):
    first, without, dimmed = recording.messages("/map")
    assert number(1.125) in first, "the height of the rack"
    assert number(1.125) not in without
    # Deletions name what is gone, with what it carried.
    assert b"obstacle/cart" in without
    assert b"beacon/plate" in without
    assert b"owl" in without
    assert number(0.25) not in without
    assert number(0.25) in dimmed
    assert b"obstacle/cart" not in list(recording.messages("/tf"))[-1]
