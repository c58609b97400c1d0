"""A user-defined drive behind the boundary."""

from collections.abc import Callable, Sequence
from functools import partial

from mjsim.modules.boundary import Boundary
from mjsim.modules.checks import checked_twist, checked_wheel_names, checked_wheel_speeds


class CheckedDrive:
    """Calls a user's `DriveModel`; its errors become a ModuleFault, and its results are checked."""

    def __init__(self, model: object, *, robot: str, clock: Callable[[], float]) -> None:
        """Check the methods of the model.

        Args:
            model: The instance of the user's class.
            robot: Name of its robot.
            clock: Gives the simulated time [s].

        Raises:
            ModuleFault: It lacks a method, or the names of its wheels.
        """
        self._model, self._clock, self._boundary = model, clock, Boundary(robot)
        self._boundary.require("drive", model)
        names = self._boundary.attribute("drive", model, clock(), "wheels")
        self.wheels: Sequence[str] = self._boundary.check("drive", model, clock(), "", checked_wheel_names, names)
        self._checked_speeds = partial(checked_wheel_speeds, wheels=self.wheels)

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> tuple[float, ...]:
        """Return the speeds of the wheels [rad/s] for a twist of the robot's origin [m/s, m/s, rad/s]."""
        now, method = self._clock(), "wheels_from_twist"
        speeds = self._boundary.call("drive", self._model, now, method, forward, left, turn)
        return self._boundary.check("drive", self._model, now, method, self._checked_speeds, speeds)

    def twist_from_wheels(self, speeds: Sequence[float]) -> tuple[float, float, float]:
        """Return the twist for speeds, or the small motion for rotations; see `DriveModel`."""
        now, method = self._clock(), "twist_from_wheels"
        twist = self._boundary.call("drive", self._model, now, method, speeds)
        return self._boundary.check("drive", self._model, now, method, checked_twist, twist)
