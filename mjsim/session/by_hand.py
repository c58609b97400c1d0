"""Changes that a person makes to a running world by hand, each as a touch."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

from mjsim.session.touches import joints_keys
from mjsim.world import ReachEvent, World, WorldEvent


class ByHand(ABC):
    """Methods that touch a world; `Session` is one."""

    world: World
    """The simulated world, including changed noise."""

    @abstractmethod
    def touch(self, keys: Mapping[str, Any], *, follows: bool = False) -> WorldEvent:
        """Apply an event of the world file; see `Session.touch`."""

    def move_joints(self, robot: str, arm: str, positions: Sequence[float] | None) -> None:
        """Move the joints of an arm manually, at up to 1 rad/s or 1 m/s; None returns it to the navigator.

        This is a touch, as is `move_tool`; see `touch`.

        Raises:
            UsageError: The arm does not exist, or its joints cannot take these values.
        """
        self.touch(joints_keys(self.world, robot, arm, positions))

    def move_tool(self, robot: str, arm: str, *, at: Sequence[float], rpy: Sequence[float]) -> None:
        """Move the tool of an arm manually to a pose in the robot frame.

        Args:
            robot: Robot with the arm.
            arm: Its name.
            at: x, y, z in the robot frame [m].
            rpy: Roll, pitch, yaw about fixed axes, right-handed [rad]; only used for arms with six joints or more.

        Raises:
            UsageError: The arm does not exist, or its tool cannot reach the pose.
        """
        self.touch({"reach": robot, "arm": arm, "tool": [*at], "rpy_deg": [math.degrees(angle) for angle in rpy]})

    def reach(self, person: str, hand: str, at: Sequence[float] | None) -> float:
        """Move a hand of a person, at up to 1 m/s; None releases it.

        Args:
            person: Person with the hand.
            hand: 'left' or 'right'.
            at: Target of its grip: x, y, z in the world frame [m].

        Returns:
            Remaining distance to the target [m]; 0 if it is within reach.

        Raises:
            UsageError: The person does not exist, or the hand or the target is invalid.
        """
        if at is None:
            self.touch({"release": person, "hand": hand})
            return 0.0
        event = self.touch({"reach": person, "hand": hand, "to": [*at]})
        return event.short if isinstance(event, ReachEvent) else 0.0

    def set_goal(self, robot: str, place: Sequence[float], heading: float | None = None) -> None:
        """Give a robot's navigator a new goal from the next tick on, instead of all others.

        This is a touch; see `touch`.

        Args:
            robot: Its name.
            place: x and y, in the frame of the estimate [m].
            heading: Heading at the goal [rad]; None for any.

        Raises:
            UsageError: The robot does not exist, its navigator takes no goals, or a number is out of bounds.
        """
        degrees = None if heading is None else math.degrees(heading)
        self.touch({"goal": robot, "to": [*place], "heading_deg": degrees})

    def set_noise(self, key: str, value: float) -> None:
        """Change the noise of a sensor, a drive or odometry from the next tick on.

        This is a touch; see `touch`. A restart keeps it.

        Args:
            key: As for `mjsim run --set`: 'robots.scout.odometry.noise.turn'.
            value: The new value.

        Raises:
            UsageError: The key does not exist, is not a noise key, or the value is invalid.
        """
        self.touch({"noise": key, "value": value})
