"""A user's controller behind the boundary."""

import time
from collections.abc import Callable, Sequence
from functools import partial

from numpy.random import Generator

from mjsim.interface import Command, FastReading, RobotInfo
from mjsim.modules.boundary import Boundary
from mjsim.modules.checks import checked_torques
from mjsim.modules.given import seal, sealed_robot


class CheckedController:
    """Calls a `Controller`; its errors become a ModuleFault, and its results are checked."""

    def __init__(
        self, controller: object, *, robot: str, part: str, motors: Sequence[str], clock: Callable[[], float]
    ) -> None:
        """Check the methods of the controller.

        Args:
            controller: The instance of the user's class.
            robot: Name of its robot.
            part: The controlled part: 'drive', or the name of an arm.
            motors: Names of the motors, in the order of the torques.
            clock: Gives the simulated time [s].

        Raises:
            ModuleFault: It lacks a method.
        """
        self._controller, self._part, self._clock = controller, part, clock
        self._boundary = Boundary(robot)
        self._boundary.require("controller", controller)
        self._checked = partial(checked_torques, motors=motors)
        self._seconds = 0.0

    def start(self, robot: RobotInfo, rng: Generator) -> None:
        """Start it for a run."""
        now = self._clock()
        self._boundary.call("controller", self._controller, now, "start", sealed_robot(robot), self._part, rng)

    def torques(self, sensed: FastReading, wanted: Command) -> tuple[float, ...]:
        """Return the torques of the motors [N m]."""
        seal(sensed)
        now, began = self._clock(), time.perf_counter()
        torques = self._boundary.call("controller", self._controller, now, "torques", sensed, wanted)
        self._seconds += time.perf_counter() - began
        return self._boundary.check("controller", self._controller, now, "torques", self._checked, torques)

    def seconds(self) -> float:
        """Return the wall-clock time inside the controller since the last call of this [s]."""
        seconds, self._seconds = self._seconds, 0.0
        return seconds
