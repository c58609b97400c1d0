"""Hands of people that were led, in films of the recording: on the plan and in the scene."""

import av
import numpy as np
import pytest

import mjsim
from mjsim.cli import main

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
people: [{name: anna, sex: female, at: [2, 2], heading_deg: 90}]
robots: [{name: scout, at: [0.5, 0.5]}]
run:
  seconds: 3.4
  rate_hz: 12.5
  events: [{time: 0.16, reach: anna, hand: right, to: [2.4, 2.4, 1.3]}, {time: 1.6, release: anna, hand: right}]
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        return mjsim.run(sim, record=tmp_path_factory.mktemp("run") / "run.mcap").path


@pytest.mark.slow
@pytest.mark.parametrize("view", ["plan", "overview"])
def test_a_film_shows_a_hand_on_its_way_there_and_back(recording, tmp_path, view):
    with pytest.raises(SystemExit) as ended:
        main(["video", str(recording), "--view", view, "-o", str(tmp_path / "film.mp4")])
    assert ended.value.code in (0, None)
    with av.open(tmp_path / "film.mp4") as film:
        # The clock stands in a corner of the plan.
        frames = [frame.to_ndarray(format="gray")[:-60].astype(int) for frame in film.decode(video=0)]
    changed = [int((abs(frame - frames[2]) > 40).sum()) for frame in frames]
    times = np.arange(len(frames)) * (3.4 / len(frames))
    there = max(changed)
    assert there > 200
    assert max(each for each, time in zip(changed, times, strict=True) if time < 0.2) < 0.05 * there
    # It is on its way for about a second, and does not jump.
    assert sum(0.1 * there < each < 0.9 * there for each in changed) >= 30
    assert changed[-1] < 0.05 * there
