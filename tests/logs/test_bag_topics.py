"""Which robots the topics of a bag tell of."""

import pytest

from mjsim.errors import UsageError
from mjsim.logs.bags.bag_topics import robots_of

ODOMETRY, SCAN = "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan"


def test_a_robot_with_odometry_and_no_sensor_that_is_read_is_one_beside_others():
    types = {
        "/anna/odom": ODOMETRY,
        "/anna/scan": SCAN,
        "/bert/odom": ODOMETRY,
        "/bert/proximity": "sensor_msgs/msg/Range",
        "/carl/odom": ODOMETRY,
        "/carl/cmd_vel": "geometry_msgs/msg/Twist",
    }
    found = robots_of(types, topics_by_kind={}, names=())
    assert [(each.name, each.odometry, len(each.scan)) for each in found] == [
        ("anna", "/anna/odom", 1),
        ("bert", "/bert/odom", 0),
        ("carl", "/carl/odom", 0),
    ]


def test_odometry_of_two_kinds_is_that_of_one_robot():
    types = {"/wheel/odom": ODOMETRY, "/visual/odom": ODOMETRY, "/scan": SCAN}
    with pytest.raises(UsageError, match="several topics hold odometry: /wheel/odom, /visual/odom"):
        robots_of(types, topics_by_kind={}, names=())
    (robot,) = robots_of(types, topics_by_kind={"odometry": ["/visual/odom"]}, names=())
    assert (robot.name, robot.odometry) == ("robot", "/visual/odom")
