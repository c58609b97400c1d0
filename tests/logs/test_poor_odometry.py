"""Bags whose odometry is not as REP 105 has it: twists alone, motion to the side, other frames, other names in /tf."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.geometry import Pose, Pose3
from mjsim.logs.resampling.resample import MotionNoise, motions, track_of
from tests.bags import START, new_bag
from tests.real_logs import imported, run_command

EXACT = MotionNoise(distance=0.0, turn=0.0, veer=0.0, aside=0.0)
NO_ROTATION = Pose3(0, 0, 0, 0, 0, 0, 0)


def _end(run) -> Pose:
    """Return where odometry leads to from the origin."""
    place = Pose(0.0, 0.0, 0.0)
    for seen in run.observations("robot"):
        place = place @ Pose(seen.odometry.forward, seen.odometry.left, seen.odometry.turn)
    return place


def test_what_moves_aside_follows_the_arc_of_its_velocity():
    # The velocity turns with the robot: its integral in closed form.
    vx, vy, w, T = 0.3, -0.2, 0.7, 2.0
    (step,) = motions(np.array([[0.0, vx, w, vy]]), np.array([0.0, T]), EXACT)
    s, c = math.sin(w * T), math.cos(w * T)
    expected = [(vx * s - vy * (1 - c)) / w, (vx * (1 - c) + vy * s) / w, w * T]
    np.testing.assert_allclose([step.forward, step.left, step.turn], expected, atol=1e-12)
    track = track_of(np.array([[0.0, vx, w, vy], [0.5, vx, w, vy], [T, 9.0, 9.0, 9.0]]))
    np.testing.assert_allclose(track[-1], [T, *expected], atol=1e-12)


@pytest.mark.slow
def test_odometry_without_poses_is_integrated_from_its_twists(tmp_path, capsys):
    with new_bag(tmp_path / "run") as bag:
        for k in range(21):
            at = START + 0.1 * k
            told = bag.odometry(bag.header(at, "odom"), "base_link", NO_ROTATION, forward=0.3, turn=0.5)
            told.twist.twist.linear.y = 0.2
            bag.put("/odom", at, told)
    out = tmp_path / "run.mcap"
    assert run_command("import-log", str(tmp_path / "run"), "-o", str(out)) == 0
    assert "odometry: twists of topic /odom" in capsys.readouterr().err
    run = mjsim.read_recording(out)
    (step,) = motions(np.array([[0.0, 0.3, 0.5, 0.2]]), np.array([0.0, 2.0]), EXACT)
    end = _end(run)
    np.testing.assert_allclose([end.x, end.y, end.heading], [step.forward, step.left, step.turn], atol=1e-6)
    # The robot is told to move aside too.
    assert run.robots["robot"].command[5].tolist() == pytest.approx([0.3, 0.2, 0.5])


@pytest.mark.slow
def test_motion_that_only_tf_tells_and_frames_that_tf_does_not_know(tmp_path):
    mounted = Pose3(0.2, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0)
    for name, outer in (("tf", "/odom_combined"), ("wheels", None)):
        with new_bag(tmp_path / f"{name}.bag", "bag") as bag:
            for k in range(11):
                at, pose = START + 0.1 * k, Pose3.from_planar(Pose(0.05 * k, 0.0, 0.0))
                fixed = [bag.transform(bag.header(at, "base_link"), "laser", mounted.matrix())]
                if outer is None:
                    bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "wheel_center", pose))
                else:
                    fixed.append(bag.transform(bag.header(at, outer), "/base_link", pose.matrix()))
                bag.put("/tf", at, bag.make("tf2_msgs/TFMessage", transforms=fixed))
                bag.put("/scan", at, bag.scan(bag.header(at, "laser"), np.ones(5), 0.0, 0.1, (0.1, 9.0)))
        run = imported(tmp_path / f"{name}.bag")
        assert _end(run).x == pytest.approx(0.5, abs=1e-6)
        assert run.world.robots[0].sensors[0].at == pytest.approx((0.2, 0.0, 0.3))
    assert run.metadata["odometry's frame"] == "guessed: base_link, since wheel_center is not in /tf"
