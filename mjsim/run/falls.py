"""Detection of falls."""

import math
from collections.abc import Mapping
from dataclasses import replace

from mjsim.geometry import Pose3
from mjsim.record import Order, RobotEvent

FALLEN = math.cos(math.radians(45.0))
"""Cosine of the lean from which a robot has fallen; no ramp is so steep."""
UPRIGHT = math.cos(math.radians(20.0))
"""Cosine of the lean up to which it stands again."""


class Falls:
    """Detects falls of robots from their true poses; a fall ends when the robot stands upright again."""

    def __init__(self) -> None:
        """Begin with all upright."""
        self._lying: set[str] = set()

    def noted(self, orders: Mapping[str, Order], poses: Mapping[str, Pose3], time: float) -> dict[str, Order]:
        """Return the orders of a tick with the falls that begin now among their events."""
        return {
            name: replace(order, events=(*order.events, RobotEvent(time, "fall", f"{name} fell over")))
            if name in poses and self._falls(name, poses[name])
            else order
            for name, order in orders.items()
        }

    def _falls(self, name: str, pose: Pose3) -> bool:
        """Return whether a robot falls now."""
        upright = 1.0 - 2.0 * (pose.qx * pose.qx + pose.qy * pose.qy)  # z of the body's z axis
        if name in self._lying:
            if upright > UPRIGHT:
                self._lying.remove(name)
            return False
        if upright > FALLEN:
            return False
        self._lying.add(name)
        return True
