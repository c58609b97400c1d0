"""Robots of a bag that share a namespace, or that only /tf tells apart; ground truth in UTM coordinates."""

import numpy as np
import pytest

from mjsim.geometry import Pose3
from mjsim.logs import Wishes
from tests.bags import START, new_bag
from tests.real_logs import imported

SPEEDS = {"one": 0.5, "two": -0.25}


def write_fleet(path, *, space: str = "", odometry: bool = True) -> None:
    """Write three seconds of two robots with scans that tell them apart, each with its own frames."""
    with new_bag(path) as bag:
        for k in range(30):
            at, moved = START + 0.1 * k, np.eye(4)
            for number, (name, speed) in enumerate(SPEEDS.items()):
                moved[0, 3], mounted = 0.1 * k * speed, np.eye(4)
                mounted[0, 3] = 0.1 + 0.3 * number
                # Frames of the same names, in topics of their own; or with prefixes in the common one.
                prefix, tf = ("", f"{space}/{name}/tf") if odometry else (f"{name}/", "/tf")
                poses = [
                    (f"{prefix}odom", f"{prefix}base_link", moved),
                    (f"{prefix}base_link", f"{prefix}laser", mounted),
                ]
                bag.transforms(tf, at, poses)
                ranges = np.full(9, 1.0 + number)
                told = bag.scan(bag.header(at, f"{prefix}laser"), ranges, -0.4, 0.1, (0.1, 50.0))
                bag.put(f"{space}/{name}/scan", at, told)
                if odometry:
                    pose = Pose3.from_matrix(moved)
                    bag.put(f"{space}/{name}/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", pose))


@pytest.mark.slow
@pytest.mark.parametrize(("space", "odometry"), [("/fleet", True), ("", True), ("", False)])
def test_each_robot_has_its_own_motion_scans_and_mounts(space, odometry, tmp_path):
    write_fleet(tmp_path / "bag", space=space, odometry=odometry)
    run = imported(tmp_path / "bag")
    assert set(run.robots) == set(SPEEDS)
    for number, (name, speed) in enumerate(SPEEDS.items()):
        seen = list(run.observations(name))
        assert sum(each.odometry.forward for each in seen) == pytest.approx(2.9 * speed, abs=1e-6)
        assert {each.scans["scan"].ranges[0] for each in seen if each.scans} == {1.0 + number}
        (robot,) = (each for each in run.world.robots if each.name == name)
        assert robot.sensors[0].at[0] == pytest.approx(0.1 + 0.3 * number)
    (alone,) = imported(tmp_path / "bag", wishes=Wishes(robots=["two"])).robots
    assert alone == "two"


@pytest.mark.parametrize("far", [0.0, 9000.0, 500_000.0])
def test_truth_far_from_the_origin_is_moved_and_it_is_said(far, tmp_path):
    with new_bag(tmp_path / "bag") as bag:
        for k in range(30):
            at, pose = START + 0.1 * k, Pose3(far + 0.05 * k, 10.0 * far + 3.0, 520.0, 0, 0, 0, 1)
            bag.put("/odom", at, bag.odometry(bag.header(at, "utm"), "base_link", pose))
            bag.put("/truth", at, bag.odometry(bag.header(at, "utm"), "base_link", pose))
    run = imported(tmp_path / "bag")
    track = run.robots["robot"]
    x, y = (0.0, 0.0) if far == 0.0 else (far, 10.0 * far)
    rows = np.flatnonzero(np.isfinite(track.truth).all(axis=1))
    since = track.moments[rows] + float(run.metadata["log start"]) - START
    np.testing.assert_allclose(track.truth[rows, 0], far - x + 0.5 * since, atol=1e-6)
    np.testing.assert_allclose(track.truth_pose[rows, 1:3], [[10.0 * far + 3.0 - y, 520.0]] * len(rows), atol=1e-6)
    assert sum(seen.odometry.forward for seen in run.observations("robot")) == pytest.approx(1.45, abs=1e-6)
    expected = None if far == 0.0 else f"x {far:.0f}, y {10.0 * far:.0f} m of the log, whose coordinates are too large"
    assert (run.metadata.get("origin of the world") or "").startswith(expected or "")
    assert ("origin of the world" in run.metadata) == (far > 0.0)
