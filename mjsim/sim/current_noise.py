"""Current noise of drives, odometry and sensors: that of the world, until a user or an event changes it."""

from collections.abc import Mapping

from mjsim.sim.robot import SimulatedRobot
from mjsim.world import World, with_noise


class Tuning:
    """The noise of a run."""

    def __init__(self, world: World, robots: Mapping[str, SimulatedRobot]) -> None:
        """Start with the noise of the world."""
        self.world = world
        """The world with its current noise."""
        self._robots = robots

    def set(self, key: str, value: float) -> None:
        """Change one noise parameter from now on.

        Args:
            key: Key as for `--set`: 'robots.scout.odometry.noise.turn'.
            value: New value.

        Raises:
            UsageError: There is no such parameter, or the value is invalid.
        """
        self.take(with_noise(self.world, key, value))

    def take(self, world: World) -> None:
        """Take the noise settings of another world, which must be equal otherwise."""
        before, self.world = self.world, world
        for old, new in zip(before.robots, world.robots, strict=True):
            if old != new:
                self._robots[new.name].retune(new)
