"""What modules are told of a robot, for tests that need no simulation."""

import dataclasses
from typing import Any

from mjsim.bench.disturbed import ROBOT
from mjsim.geometry import Pose
from mjsim.interface import RobotInfo

PIONEER = dataclasses.replace(ROBOT, prior=Pose(1.0, 1.0, 0.0))


def pioneer(**parts: Any) -> RobotInfo:
    """Return the data sheet of a small robot, with parts of it changed."""
    return dataclasses.replace(PIONEER, **parts)
