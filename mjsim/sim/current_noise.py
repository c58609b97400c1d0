"""Current noise of drives, odometry and sensors: that of the world, until a user or an event changes it."""

from collections.abc import Mapping

from mjsim.sim.robot import SimulatedRobot
from mjsim.world import World, with_noise


class Tuning:
    """The noise of a run."""

    def __init__(self, world: World, robots: Mapping[str, SimulatedRobot]) -> None:
        """Begin with robots that err as their world says."""
        self.world = world
        """With its noise as it is now."""
        self._robots = robots

    def set(self, key: str, value: float) -> None:
        """Change one figure from now on.

        Args:
            key: As `--set` has it: 'robots.scout.odometry.noise.turn'.
            value: The new one.

        Raises:
            UsageError: The figure does not exist, or the value does not fit it.
        """
        self.take(with_noise(self.world, key, value))

    def take(self, world: World) -> None:
        """Err as another world says from now on; in all else it is the same."""
        before, self.world = self.world, world
        for old, new in zip(before.robots, world.robots, strict=True):
            if old != new:
                self._robots[new.name].retune(new)
