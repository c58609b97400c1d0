"""The bump reaction, which is always on."""

import math
from dataclasses import replace

import numpy as np

from mjsim.interface import Command, RobotInfo, WheelCommand
from mjsim.safety.body_outline import is_round, rim

MIN_BLOCKING_COSINE = 0.05
"""Cosine above which a contact blocks a motion; a robot may slide along an obstacle at 87 degrees."""


def react_to_bump(
    command: Command | WheelCommand, bump: tuple[float, ...], robot: RobotInfo | None = None
) -> Command | WheelCommand:
    """Return the command without the motion that would push against contacts.

    Turning is kept, because it does not push, except for robots that are not round: if a side or the rear would swing
    into a contact, turning is removed as well.

    Args:
        command: Command of the navigator, or of the avoidance.
        bump: Bearings of current contacts [rad].
        robot: Robot that gets the command; by default a round one with two driven wheels.
    """
    if not bump:
        return command
    if isinstance(command, WheelCommand):
        return _react_with_wheels(command, bump, robot)
    forward, left, turn = command.forward, command.left, command.turn
    if _moves_into_bump(forward, left, bump):
        forward, left = 0.0, 0.0
    if robot is not None and turn and _swings_into(turn, bump, robot):
        turn = 0.0
    if (forward, left, turn) == (command.forward, command.left, command.turn):
        return command
    return replace(command, forward=forward, left=left, turn=turn)


def _react_with_wheels(command: WheelCommand, bump: tuple[float, ...], robot: RobotInfo | None) -> WheelCommand:
    """Return the speeds without the part that would push against contacts."""
    if robot is None or robot.twist_from_wheels is None:
        # All wheels of a differential drive at their mean speed drive straight; the rest only turns.
        mean = sum(command.speeds) / len(command.speeds)
        if not _moves_into_bump(mean, 0.0, bump):
            return command
        return replace(command, speeds=tuple(speed - mean for speed in command.speeds))
    speeds, twists = np.asarray(command.speeds, dtype=float), robot.twist_from_wheels
    forward, left, turn = (twists @ speeds).tolist()
    safe = react_to_bump(Command(forward, left, turn), bump, robot)
    assert isinstance(safe, Command)
    if (safe.forward, safe.left, safe.turn) == (forward, left, turn):
        return command
    lost = np.array([forward - safe.forward, left - safe.left, turn - safe.turn])
    speeds_left = speeds - np.asarray(np.linalg.pinv(twists), dtype=float) @ lost
    return replace(command, speeds=tuple(speeds_left.tolist()))


def _moves_into_bump(forward: float, left: float, bump: tuple[float, ...]) -> bool:
    speed = math.hypot(forward, left)
    return any(forward * math.cos(b) + left * math.sin(b) > MIN_BLOCKING_COSINE * speed for b in bump)


def _swings_into(turn: float, bump: tuple[float, ...], robot: RobotInfo) -> bool:
    """Return whether turning moves a side of a robot that is not round towards a contact."""
    if robot.outline is None or is_round(robot.outline):
        return False
    start = robot.outline
    edge = np.roll(start, -1, axis=0) - start
    for bearing in bump:
        along = np.array([math.cos(bearing), math.sin(bearing)])
        # The side that the bearing leaves through: its corners lie to the right and to the left of the bearing.
        cross = start[:, 0] * along[1] - start[:, 1] * along[0]
        leaves = int(np.argmax((cross >= 0.0) & (np.roll(cross, -1) < 0.0)))
        point = along * rim(robot.outline, bearing)
        # Outward normal of a side of a counter-clockwise outline, and the point's motion.
        normal = np.array([edge[leaves, 1], -edge[leaves, 0]]) / np.hypot(*edge[leaves])
        motion = turn * np.array([-point[1], point[0]])
        if motion @ normal > MIN_BLOCKING_COSINE * np.hypot(*motion):
            return True
    return False
