"""What a film draws of a recorded run: events, things, scans and pictures at each row; and how a film ends."""

import itertools

import numpy as np
import pytest

import mjsim
from mjsim.video.film import frame_rows, write_film
from mjsim.video.moment import moments
from mjsim.web.review.reviewing import row_json
from mjsim.web.run.measured import SHOWN_FOR, SensorPast
from mjsim.world import parse_world

WORLD = parse_world(
    """
mjsim: 1
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true, height: 1}]
obstacles: [{name: box, box: [0.3, 0.3, 1], at: [1.4, 0.6]}]
robots:
  - {name: scout, at: [0, 0], sensors: [{lidar: scan, beams: 8, rate_hz: 1}]}
  - {name: other, at: [-1, 0]}
run: {seconds: 1.6, rate_hz: 10, events: [{time: 0.5, remove: box}]}
"""
)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    with mjsim.Simulation(WORLD) as sim:
        mjsim.run(sim, record=path)
    return mjsim.read_recording(path)


def test_each_row_is_drawn_with_the_events_before_it_and_the_newest_scan(recording):
    rows = list(range(0, len(recording.time), 2))
    drawn = list(moments(recording, "scout", rows))
    assert [moment.time for moment in drawn] == pytest.approx(recording.time[rows])
    assert [bool(moment.looks.removed) for moment in drawn] == [moment.time >= 0.5 - 1e-9 for moment in drawn]
    for row, moment in zip(rows, drawn, strict=True):
        np.testing.assert_array_equal(moment.truth, recording.robots["scout"].truth[row])
        np.testing.assert_array_equal(moment.estimate, recording.robots["scout"].estimate[row])
        np.testing.assert_array_equal(moment.odometry, recording.robots["scout"].odometry[row])
        assert list(moment.others) == ["other"]
        np.testing.assert_array_equal(moment.others["other"], recording.robots["other"].truth[row])
        assert moment.picture is None
    assert np.hypot(*drawn[-1].scans["scan"].T) == pytest.approx([2.0, 2.83] * 4, abs=0.25) or len(drawn[-1].scans)


def test_points_of_a_lidar_are_told_for_a_while_after_they_were_measured(recording):
    measured = SensorPast(recording)
    assert measured.whole.wait(10.0)
    times = [seen.time for seen in recording.observations("scout") if seen.scans]
    for row, time in enumerate(recording.time.tolist()):
        scans = row_json(recording, row, measured=measured)["robots"]["scout"]["scans"]
        assert ("scan" in scans) == any(0 <= time - each + 1e-9 < SHOWN_FOR for each in times)
        if scans:
            points = np.reshape(scans["scan"], (-1, 3))
            assert np.abs(points[:, :2]).max(axis=1) == pytest.approx(np.full(len(points), 1.95), abs=0.15)
    measured.close()


def test_a_film_has_a_frame_every_25th_of_a_second_of_the_last_tick_until_then():
    assert frame_rows(np.array([1.0])) == [0]
    assert frame_rows(np.array([0.0, 0.04, 0.08])) == [0, 1, 2]
    assert frame_rows(np.array([5.0, 5.1, 5.2])) == [0, 0, 0, 1, 1, 2]
    assert frame_rows(np.arange(9) * 0.01) == [0, 4, 8]


def test_a_film_that_is_broken_off_ends_although_its_pictures_do_not(tmp_path):
    def stop(_):
        raise KeyboardInterrupt

    pictures = itertools.repeat(np.zeros((48, 64, 3), np.uint8))
    with pytest.raises(KeyboardInterrupt):
        write_film(pictures, tmp_path / "film.mp4", progress=stop)

    def failing():
        yield np.zeros((48, 64, 3), np.uint8)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_film(failing(), tmp_path / "film.mp4")
