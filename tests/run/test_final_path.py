"""The final trajectory of an estimator: recorded, exported, replayed, and counted beside the online one."""

import numpy as np
import pytest

import mjsim
from mjsim.record import export_tum

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
robots:
  - {name: scout, at: [1, 1]}
  - {name: other, at: [4, 3]}
"""


class Late:
    """Believes online to be elsewhere; in the end it knows."""

    def start(self, robot, catalogue, rng):
        self.pose, self.found = robot.prior, []

    def update(self, seen):
        moved = seen.odometry
        self.pose = self.pose @ mjsim.Pose(moved.forward, moved.left, moved.turn)
        self.found.append((seen.time, self.pose))
        return mjsim.Estimate(mjsim.Pose(self.pose.x + 1.0, self.pose.y, self.pose.heading), np.eye(3))

    def path(self):
        return self.found


class Constant:
    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return mjsim.Command(forward=0.5)


def recorded(place, estimator, seconds=0.8):
    drivers = {
        "scout": mjsim.Driver(estimator=estimator, navigator=Constant()),
        "other": mjsim.Driver(estimator=Late(), navigator=Constant()),
    }
    with mjsim.Simulation(mjsim.parse_world(ROOM), seed=1) as sim:
        return mjsim.run(sim, drivers=drivers, seconds=seconds, record=place)


def test_the_final_path_is_recorded_exactly_and_counted_beside_the_online_estimate(tmp_path):
    late = Late()
    run = recorded(tmp_path / "run.mcap", late)
    kept = run.robots["scout"].path
    np.testing.assert_array_equal(kept, [(time, pose.x, pose.y, pose.heading) for time, pose in late.found])
    figures = mjsim.statistics(run)["scout"]
    assert figures["position_error_m"]["mean"] == pytest.approx(1.0, abs=0.02)
    assert figures["path_error_m"]["mean"] < 0.02
    assert figures["path_ate_m"]["rmse"] < 0.02
    later = run.between(0.4).robots["scout"].path
    np.testing.assert_array_equal(later, kept[kept[:, 0] >= 0.4 - 1e-6])
    export_tum(run, tmp_path)
    rows = np.loadtxt(tmp_path / "scout_path.tum")
    np.testing.assert_allclose(rows[:, :3], kept[:, :3], rtol=0, atol=1e-12)
    np.testing.assert_allclose(2 * np.arctan2(rows[:, 6], rows[:, 7]), kept[:, 3], atol=1e-9)


def test_a_replay_makes_the_path_anew_and_keeps_that_of_other_robots(tmp_path):
    run = recorded(tmp_path / "run.mcap", Late())
    again = mjsim.replay(run, robot="scout", estimator=Late(), record=tmp_path / "again.mcap")
    np.testing.assert_array_equal(again.robots["scout"].path, run.robots["scout"].path)
    np.testing.assert_array_equal(again.robots["other"].path, run.robots["other"].path)

    class Plain(Late):
        path = None

    without = mjsim.replay(run, robot="scout", estimator=Plain(), record=tmp_path / "plain.mcap")
    assert without.robots["scout"].path.shape == (0, 4)
    assert len(without.robots["other"].path) == len(run.time)
    assert mjsim.statistics(without)["scout"]["path_ate_m"] is None


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ([(0.0, mjsim.Pose(0, 0, 0)), (0.0, mjsim.Pose(1, 0, 0))], "times do not ascend"),
        ([(0.0, mjsim.Pose(0, float("nan"), 0))], "not finite"),
        ([(0.0, 1.0, 2.0)], "it must be (time, pose)"),
        (7, "it must be a list of (time, Pose)"),
    ],
)
def test_an_invalid_final_path_is_a_one_line_error_and_the_run_stays_readable(tmp_path, path, said):
    class Wrong(Late):
        def path(self):
            return path

    with pytest.raises(mjsim.ModuleFault) as caught:
        recorded(tmp_path / "run.mcap", Wrong(), seconds=0.2)
    assert said in str(caught.value)
    assert "estimator Wrong of robot 'scout'" in str(caught.value)
    run = mjsim.read_recording(tmp_path / "run.mcap")
    assert run.robots["scout"].events[-1].kind == "fault"
    assert len(run.time) > 3


@pytest.mark.slow
def test_the_whole_graph_tells_where_the_robot_was():
    pytest.importorskip("gtsam")
    from mjsim.algorithms.graph_slam import GraphSlam

    beacons = "beacons: [{name: a, at: [3, 3.9]}, {name: b, at: [5.9, 2]}]\nrobots:\n"
    sensor = "- {name: scout, at: [1, 1], sensors: [{beacons: ring, rate_hz: 5, noise: {range: 0.02, bearing_deg: 1}}]}"
    world = mjsim.parse_world(ROOM.partition("robots:")[0] + beacons + f"  {sensor}\n")
    with mjsim.Simulation(world, seed=1) as sim:
        run = mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=GraphSlam(), navigator=Constant())}, seconds=2)
    track = run.robots["scout"]
    np.testing.assert_array_equal(track.path[:, 0], run.time)
    np.testing.assert_allclose(
        track.path[-1, 1:], track.estimate[-1], atol=1e-3
    )  # solved again with what the drive told
    assert np.hypot(*(track.path[:, 1:3] - track.truth[:, :2]).T).mean() < 0.1
