"""What modules are told of a robot, for tests that need no simulation."""

import dataclasses
from typing import Any

import numpy as np

from mjsim.geometry import Pose
from mjsim.interface import RobotInfo

PIONEER = RobotInfo(
    name="scout",
    drive="differential",
    max_speed=0.7,
    max_turn=1.7,
    max_acceleration=1.0,
    max_turn_acceleration=5.0,
    wheels=("wheel_left", "wheel_right"),
    wheel_radius=0.0975,
    track=0.33,
    radius=0.22,
    dt=0.04,
    prior=Pose(1.0, 1.0, 0.0),
    prior_covariance=np.zeros((3, 3)),
)


def pioneer(**parts: Any) -> RobotInfo:
    """Return the data sheet of a small robot, with parts of it changed."""
    return dataclasses.replace(PIONEER, **parts)
