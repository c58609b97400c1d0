"""How robots of a bag moved: by topics that were named, by commands without headers, with and without namespaces."""

import numpy as np
import pytest

from mjsim.geometry import Pose3
from mjsim.logs import Wishes
from tests.bags import START, new_bag
from tests.real_logs import imported


def write_driving(bag, *, simulated: bool = False) -> None:
    """Write two seconds of commands and scans of a robot at 0.5 m/s; headers may begin at 0."""
    for k in range(20):
        at = START + 0.2 * k if simulated else START + 0.1 * k  # a simulation at half of real time
        stamp = 1.0 + 0.1 * k if simulated else at
        bag.put("/scan", at, bag.scan(bag.header(stamp, "laser"), np.array([1.0, 2.0]), 0.0, 0.5, (0.1, 5.0)))
        forward = 0.5 if k < 10 else 0.0
        twist = bag.make("geometry_msgs/Twist", linear=bag.xyz(forward, 0, 0), angular=bag.xyz(0, 0, 0))
        bag.put("/cmd_vel", at, twist)


@pytest.mark.parametrize("kind", ["TwistStamped", "TwistWithCovarianceStamped", "PoseStamped", "TransformStamped"])
def test_odometry_may_be_velocities_or_poses_of_a_topic_that_is_named(kind, tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(20):
            header, pose = bag.header(START + 0.1 * k, "base_link"), Pose3(0.05 * k, 0, 0, 0, 0, 0, 1)
            twist = bag.make("geometry_msgs/Twist", linear=bag.xyz(0.5, 0, 0), angular=bag.xyz(0, 0, 0))
            if kind == "TwistStamped":
                told = bag.make("geometry_msgs/TwistStamped", header=header, twist=twist)
            elif kind == "TwistWithCovarianceStamped":
                uncertain = bag.make("geometry_msgs/TwistWithCovariance", twist=twist, covariance=np.zeros(36))
                told = bag.make("geometry_msgs/TwistWithCovarianceStamped", header=header, twist=uncertain)
            elif kind == "PoseStamped":
                told = bag.make(
                    "geometry_msgs/PoseStamped", header=bag.header(START + 0.1 * k, "odom"), pose=bag.pose(pose)
                )
            else:
                told = bag.transform(bag.header(START + 0.1 * k, "odom"), "base_link", pose.matrix())
            bag.put("/wheels", START + 0.1 * k, told)
            bag.put("/scan", START + 0.1 * k, bag.scan(header, np.array([1.0, 2.0]), 0.0, 0.5, (0.1, 5.0)))
    run = imported(tmp_path / "run", wishes=Wishes(topics={"odometry": ["/wheels"]}))
    way = sum(seen.odometry.forward for seen in run.observations("robot"))
    assert way == pytest.approx(0.5 * 1.9, abs=1e-6)
    # Nobody said what they are.
    run = imported(tmp_path / "run")
    assert run.metadata["odometry"] == "left out: none; the motion of each tick is unknown"


def test_commands_without_headers_go_by_the_simulated_time_of_all_others(tmp_path):
    ways = []
    for simulated in (False, True):
        with new_bag(tmp_path / f"run{simulated}") as bag:
            write_driving(bag, simulated=simulated)
        run = imported(tmp_path / f"run{simulated}")
        ways.append([seen.odometry.forward for seen in run.observations("robot")])
        assert run.metadata["/cmd_vel messages left out"] == "0"
    np.testing.assert_allclose(ways[1], ways[0], atol=1e-6)
    assert sum(ways[0]) == pytest.approx(0.5, abs=1e-6)


def test_a_robot_without_a_namespace_beside_one_with_is_another(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(20):
            for space, speed in (("", 0.5), ("/two", 1.0)):
                header = bag.header(START + 0.1 * k, "odom")
                bag.put(
                    f"{space}/odom",
                    START + 0.1 * k,
                    bag.odometry(header, "base", Pose3(0.1 * k * speed, 0, 0, 0, 0, 0, 1)),
                )
                bag.put(f"{space}/scan", START + 0.1 * k, bag.scan(header, np.array([1.0, 2.0]), 0.0, 0.5, (0.1, 5.0)))
    run = imported(tmp_path / "run")
    ways = {name: sum(seen.odometry.forward for seen in run.observations(name)) for name in run.robots}
    assert ways == pytest.approx({"robot": 0.95, "two": 1.9})
    assert list(imported(tmp_path / "run", wishes=Wishes(robots=["robot"])).robots) == ["robot"]
