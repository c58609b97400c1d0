"""What was removed comes back by an event, with what hangs on it, in the run and in its recording."""

import math
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError, WorldError
from mjsim.geometry import Pose
from mjsim.record import read_recording, same_run
from mjsim.run import run
from mjsim.sim import Playback, Simulation
from mjsim.world import RestoreEvent, check_world, parse_world
from tests.sim.test_events import HALL, hall, step


@pytest.mark.slow
def test_a_beacon_that_is_restored_is_seen_again_unless_what_it_hangs_on_is_away():
    events = (
        "{time: 0.1, remove: rack}, {time: 0.1, remove: lion}, {time: 0.2, restore: lion}, {time: 0.2, restore: plate}"
    )
    with hall(events) as sim:
        seen = []
        for _ in range(7):
            sim.step()
            seen.append(sorted(sighting.name for sighting in sim.sense("r").sightings))
        assert seen[0] == seen[1] == ["plate"]
        assert seen[2] == seen[3] == []
        assert seen[-1] == ["lion"]
        assert sim.looks.removed == {"rack", "plate"}


def ahead(sim: Simulation) -> float:
    """Return how far the middle beam of a robot's lidar reaches [m]."""
    return float(sim.sense("r").scans["scan"].ranges[1])


def test_an_obstacle_that_is_restored_is_solid_again_with_what_hangs_on_it_and_only_in_free_space():
    with hall() as sim:
        step(sim, 1)
        near = ahead(sim)
        assert near == pytest.approx(2.8, abs=0.01)
        sim.remove("rack")
        step(sim, 1)
        assert ahead(sim) == pytest.approx(6.95, abs=0.01)
        sim.move("r", Pose(4.0, 3.0, 0.0))
        restored = RestoreEvent(time=sim.time, restore="rack")
        with pytest.raises(UsageError, match="'rack' would come back inside 'r'; move that away first"):
            sim.schedule(restored)
        sim.move("r", Pose(1.0, 3.0, 0.0))
        sim.schedule(restored)
        step(sim, 2)
        assert ahead(sim) == near
        assert sim.looks.removed == frozenset()
        assert {each.name for each in sim.sense("r").sightings} == {"plate"}


def test_a_movable_obstacle_comes_back_where_it_is_wanted_if_there_is_space():
    with hall("{time: 0, remove: bin}") as sim:
        step(sim, 2)
        for to, wrong in (((4.0, 3.0), "inside obstacle 'rack'"), ((1.0, 3.0), "inside 'r'"), ((9.0, 3.0), "outside")):
            with pytest.raises(UsageError, match=wrong):
                sim.schedule(RestoreEvent(time=sim.time, restore="bin", to=to))
        assert "obstacle/bin" not in sim.things()
        with pytest.raises(UsageError, match="no movable obstacle 'rack'"):
            sim.schedule(RestoreEvent(time=sim.time, restore="rack", to=(2.0, 2.0)))
        sim.schedule(RestoreEvent(time=sim.time, restore="bin", to=(2.0, 3.0), heading_deg=90))
        step(sim, 25)
        bin_now = sim.things()["obstacle/bin"]
        assert (bin_now.x, bin_now.y, bin_now.heading) == pytest.approx((2.0, 3.0, math.pi / 2), abs=2e-3)
        assert ahead(sim) == pytest.approx(0.8, abs=0.01)


def test_where_a_world_restores_something_is_checked_with_the_world():
    def wrong(event: str) -> str:
        with pytest.raises(WorldError) as caught:
            parse_world(HALL.format(f"{{time: 1, {event}}}"))
        return str(caught.value)

    assert "no beacon or obstacle 'rak' in this world; did you mean 'rack'?" in wrong("restore: rak")
    assert "'rack' is not movable; leave out 'to'" in wrong("restore: rack, to: [2, 2]")
    assert "keeps its heading unless it is put elsewhere; give to: [x, y]" in wrong("restore: bin, heading_deg: 3")
    (found,) = check_world(parse_world(HALL.format("{time: 1, restore: bin, to: [4, 3]}")))
    assert "'bin' is placed at [4, 3] inside obstacle 'rack'" in str(found)


@pytest.mark.slow
def test_a_recording_shows_what_was_restored_as_the_run_did_and_a_second_run_is_the_same(tmp_path: Path):
    events = (
        "{time: 0, remove: bin}, {time: 0.1, remove: rack}, {time: 0.3, restore: rack},"
        " {time: 0.5, restore: bin, to: [2, 3], heading_deg: 30}"
    )
    pictures: list[np.ndarray] = []
    for name in ("one.mcap", "two.mcap"):
        with hall(events) as sim:
            run(
                sim,
                seconds=1.0,
                record=tmp_path / name,
                watch=lambda tick: pictures.append(tick.seen["r"].cameras["eye"].image),
            )
    assert same_run(tmp_path / "one.mcap", tmp_path / "two.mcap")
    recording = read_recording(tmp_path / "one.mcap")
    assert [type(event).__name__ for event in recording.events] == ["RemoveEvent"] * 2 + ["RestoreEvent"] * 2
    assert [sorted(recording.looks(row).removed) for row in (0, 3, 8, 13)] == [
        ["bin"],
        ["bin", "plate", "rack"],
        ["bin"],
        [],
    ]
    bins = recording.things["obstacle/bin"]
    assert np.isnan(bins[:13]).all()
    np.testing.assert_allclose(bins[13:, :2], [[2.0, 3.0]] * (len(bins) - 13), atol=2e-3)
    with Playback(recording.world, width=96, height=72, events=recording.events) as playback:
        for row in (24, 2, 9, 14, 5, 0):
            again = playback.picture(recording.qpos[row], "r/eye", time=recording.time[row])
            np.testing.assert_array_equal(again, pictures[row], err_msg=str(row))
