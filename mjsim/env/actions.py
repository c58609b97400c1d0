"""Actions of one robot: arrays from -1 to 1 that are converted to commands."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import Command, RobotInfo, WheelCommand


class Actions:
    """Converts arrays of numbers to commands of a robot's drive."""

    def __init__(self, robot: RobotInfo, kind: Literal["twist", "wheels"]) -> None:
        """Compute the maximum of each number.

        Args:
            robot: Robot with the drive.
            kind: A twist in the robot's frame, or the speeds of its wheels.
        """
        self._robot, self._kind = robot.name, kind
        self._sideways = robot.max_left > 0.0
        twist = {"forward": robot.max_speed, "left": robot.max_left, "turn": robot.max_turn}
        if not self._sideways:
            del twist["left"]
        largest = twist if kind == "twist" else _fastest_wheels(robot)
        self.names: tuple[str, ...] = tuple(largest)
        """Name of each number of an action."""
        self.largest: Array = np.array(list(largest.values()), dtype=float)
        """Speeds that an action of 1 stands for, shape (n,) [m/s, rad/s]."""
        self.low: NDArray[np.float32] = np.full(len(largest), -1.0, dtype=np.float32)
        self.high: NDArray[np.float32] = np.full(len(largest), 1.0, dtype=np.float32)

    def command(self, action: object) -> Command | WheelCommand:
        """Return the command of an action; values beyond -1 to 1 are limited by the drive.

        Raises:
            UsageError: The action has another shape, or is not finite.
        """
        try:
            numbers = np.asarray(action, dtype=float)
        except (TypeError, ValueError):
            raise UsageError(
                f"the action for robot '{self._robot}' is {action!r}; it must be {self._meant()}"
            ) from None
        if numbers.shape != self.largest.shape:
            raise UsageError(
                f"the action for robot '{self._robot}' has shape {numbers.shape}; it must be {self._meant()}"
            )
        if not np.isfinite(numbers).all():
            raise UsageError(f"the action for robot '{self._robot}' is {numbers.tolist()}; its numbers must be finite")
        speeds = (numbers * self.largest).tolist()
        if self._kind == "wheels":
            return WheelCommand(tuple(speeds))
        return Command(*speeds) if self._sideways else Command(speeds[0], turn=speeds[1])

    def _meant(self) -> str:
        return f"{self.largest.shape}: {', '.join(self.names)}"


def _fastest_wheels(robot: RobotInfo) -> dict[str, float]:
    """Return the maximum speed of each wheel over all twists within the limits [rad/s]."""
    assert robot.twist_from_wheels is not None
    wheels_from_twist = np.asarray(np.linalg.pinv(robot.twist_from_wheels), dtype=float)
    fastest = np.abs(wheels_from_twist) @ [robot.max_speed, robot.max_left, robot.max_turn]
    return dict(zip(robot.wheels, fastest.tolist(), strict=True))
