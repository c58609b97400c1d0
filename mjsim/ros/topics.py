"""Topics of ROS 2."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from mjsim.ros.qos import LATCHED, RELIABLE, Qos


@dataclass(frozen=True, slots=True)
class RosTopic:
    """A topic that is published."""

    name: str
    """'/scout/scan' and so on."""
    type: str
    """Type of its messages: 'sensor_msgs/msg/LaserScan' and so on."""
    qos: Qos = RELIABLE


class Outgoing(NamedTuple):
    """A message to be sent."""

    topic: RosTopic
    message: Any
    """Message of the class that `typestore().types` has for the topic's type."""


CLOCK = RosTopic("/clock", "rosgraph_msgs/msg/Clock")
TF = RosTopic("/tf", "tf2_msgs/msg/TFMessage")
TF_STATIC = RosTopic("/tf_static", "tf2_msgs/msg/TFMessage", LATCHED)
MAP = RosTopic("/map", "nav_msgs/msg/OccupancyGrid", LATCHED)
