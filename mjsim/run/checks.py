"""What user modules return, checked before it is believed: ValueError says what is wrong with it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mjsim.interface import Command, Estimate, RobotInfo, Sighting, WheelCommand
from mjsim.readings import message_text


def checked_command(command: object, robot: RobotInfo) -> Command | WheelCommand:
    """Return a command that is finite and fits the robot."""
    if isinstance(command, WheelCommand):
        if len(command.speeds) != len(robot.wheels):
            raise ValueError(f"returned {len(command.speeds)} wheel speeds; the wheels are {', '.join(robot.wheels)}")
        _require_finite("a wheel command", command.speeds)
        return command
    if not isinstance(command, Command):
        raise ValueError(f"returned {_kind(command)}; it must be a Command or a WheelCommand")
    _require_finite("a command", (command.forward, command.left, command.turn))
    for message in command.messages:
        try:
            message_text(message)
        except ValueError as error:
            raise ValueError(f"returned {error}") from None
    return command


def checked_estimate(belief: object) -> Estimate:
    """Return an estimate that is finite and whose arrays have their shapes."""
    if not isinstance(belief, Estimate):
        raise ValueError(f"returned {_kind(belief)}; it must be an Estimate")
    _require_finite("a pose", (belief.pose.x, belief.pose.y, belief.pose.heading))
    _require("the covariance of the pose", belief.covariance, (3, 3))
    for name, (mean, covariance) in belief.landmarks.items():
        _require(f"the mean of landmark {name!r}", mean, (2,))
        _require(f"the covariance of landmark {name!r}", covariance, (2, 2))
    for name, nu, S in belief.innovations:
        _require(f"the innovation of {name!r}", nu, (2,))
        _require(f"the innovation covariance of {name!r}", S, (2, 2))
    if belief.joint_covariance is not None:
        size = 3 + 2 * len(belief.landmarks)
        _require("the joint covariance", belief.joint_covariance, (size, size))
    return belief


def checked_sightings(sightings: object) -> Sequence[Sighting]:
    """Return sightings that are finite."""
    if not isinstance(sightings, Sequence):
        raise ValueError(f"returned {_kind(sightings)}; it must be a list of Sighting")
    for seen in sightings:
        if not isinstance(seen, Sighting):
            raise ValueError(f"returned {_kind(seen)} in its list; each must be a Sighting")
        _require_finite("a sighting", (seen.stamp, seen.range, seen.bearing))
        _require("the covariance of a sighting", seen.covariance, (2, 2))
    return sightings


def _require(what: str, value: ArrayLike, shape: tuple[int, ...]) -> None:
    if np.shape(value) != shape:
        raise ValueError(f"returned {what} of shape {np.shape(value)}; it must be {shape}")
    _require_finite(what, value)


def _require_finite(what: str, values: ArrayLike) -> None:
    try:
        finite = np.isfinite(values).all()
    except TypeError:
        raise ValueError(f"returned {what} that holds something other than numbers: {values!r}") from None
    if not finite:
        raise ValueError(f"returned {what} that is not finite: {np.asarray(values).tolist()}")


def _kind(value: object) -> str:
    return "None" if value is None else f"a value of type {type(value).__name__}"
