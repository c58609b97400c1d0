"""Where sensors of a recording are in the world, and the states of a EuRoC data set, computed another way."""

import math

import numpy as np
import pytest

from mjsim.datasets.euroc_out import export_euroc
from mjsim.datasets.recorded_robots import RecordedRobots, planar_pose, pose_in_space

ROBOT = "7.tip-top"


def test_sensors_move_with_their_robot(run):
    with RecordedRobots(run, redraw=False) as recorded:
        ticks = list(recorded.ticks(ROBOT))
        assert [tick.row for tick in ticks] == list(range(len(run.robots[ROBOT].time)))
        for tick in ticks[::7]:
            x, y, heading = run.robots[ROBOT].truth[tick.row]
            c, s = math.cos(heading), math.sin(heading)
            for name, (ahead, left, up) in {"wide": (0.0, 0.1, 0.6), "imu": (0.02, 0.0, 0.1)}.items():
                pose = recorded.world_from_sensor(ROBOT, name, tick)
                expected = [x + c * ahead - s * left, y + s * ahead + c * left, up]
                assert [pose.x, pose.y, pose.z] == pytest.approx(expected, abs=0.02)
            # A camera that looks to the left: its optical axis.
            way = recorded.world_from_sensor(ROBOT, "wide", tick).matrix()[:3, 2]
            assert way == pytest.approx([-s, c, 0.0], abs=0.02)
        assert recorded.on_arms(ROBOT) == set()
        assert (recorded.has_depth(ROBOT, "eye"), recorded.has_depth(ROBOT, "wide")) == (True, False)
        truths = recorded.truths(ROBOT, [0.1, 0.1, 0.123])
        assert list(truths) == sorted(truths)
        assert sum(abs(time - 0.123) < 1e-9 for time in truths) == 1
    assert pose_in_space(np.full(7, np.nan)) is None
    assert planar_pose(np.array([np.nan, 0.0, 0.0])) is None
    assert planar_pose(np.array([1.0, 2.0, 3.0])).heading == 3.0


def test_states_of_a_data_set_are_of_its_inertial_sensor(run, tmp_path):
    (place,) = export_euroc(run, tmp_path)
    rows = np.loadtxt(place / "mav0" / "state_groundtruth_estimate0" / "data.csv", delimiter=",")
    times, places, turns, speeds = rows[:, 0] * 1e-9, rows[:, 1:4], rows[:, 4:8], rows[:, 8:11]
    track = run.robots[ROBOT]
    for time, at, (w, _, _, z) in zip(times[::5], places[::5], turns[::5], strict=True):
        x, y, heading = track.truth[int(np.abs(track.time - time).argmin())]
        if np.abs(track.time - time).min() > 1e-6:
            continue
        assert at[:2] == pytest.approx([x + 0.02 * math.cos(heading), y + 0.02 * math.sin(heading)], abs=0.01)
        # It is turned by 90 degrees on the robot.
        assert math.remainder(2 * math.atan2(z, w) - heading - math.pi / 2, 2 * math.pi) == pytest.approx(0.0, abs=0.02)
    middle = (places[2:] - places[:-2]) / (times[2:] - times[:-2])[:, None]
    assert np.median(np.abs(speeds[1:-1] - middle)) < 0.02
    assert not rows[:, 11:].any()
    sheet = (place / "mav0" / "imu0" / "sensor.yaml").read_text()
    found = dict(line.split(": ", 1) for line in sheet.splitlines() if ": " in line)
    assert float(found["gyroscope_noise_density"]) == pytest.approx(0.002 / math.sqrt(125))
    assert float(found["accelerometer_noise_density"]) == pytest.approx(0.02 / math.sqrt(125))
    # The body is the inertial sensor.
    assert [float(each) for each in found["  data"].strip("[]").split(",")] == pytest.approx(
        np.eye(4).ravel(), abs=1e-9
    )
