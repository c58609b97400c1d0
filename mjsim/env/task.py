"""The learning task: controlled robots, observations, reward, and the end of an episode."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from mjsim.env.step import Step
from mjsim.errors import UsageError, did_you_mean
from mjsim.world import World, load_world


def no_reward(step: Step) -> float:
    """Return 0."""
    return 0.0


def never(step: Step) -> bool:
    """Return False."""
    return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A learning task in a world; every kind of environment is created from one.

    Controlled robots follow actions in place of their navigators; `avoidance` and `push` of their drivers are as in the
    world file, and the bump reaction is always on. All other robots use their own modules.
    """

    world: World | str | Path
    """The world, or its file."""
    robots: str | Sequence[str] | None = None
    """Controlled robots: a name, or a list of names, for which actions and observations are dicts by robot; by default
    the first robot of the world."""
    observations: Sequence[str] | None = None
    """Observations: 'proximity', 'bump', 'odometry', 'sightings', 'estimate', and lidars, cameras and inertial sensors
    by name; by default all except 'estimate'. Observations that are not listed are not computed."""
    actions: Literal["twist", "wheels"] = "twist"
    """Meaning of an action: (forward, turn), or (forward, left, turn) for robots that can move sideways, or the speed
    of each wheel; relative to the maximum, from -1 to 1."""
    reward: Callable[[Step], float] = no_reward
    """Called once after each step."""
    terminated: Callable[[Step], bool] = never
    """Called once after each step; true ends the episode, because of success or failure."""
    seconds: float | None = None
    """Time limit of an episode, simulated [s]; by default that of the world file."""
    random_starts: bool = False
    """Whether controlled robots start at random free places that they could reach from their start in the world."""

    def __post_init__(self) -> None:
        """Check the fields as far as possible without the world."""
        if self.actions not in ("twist", "wheels"):
            raise UsageError(f"actions is {self.actions!r}; it must be 'twist' or 'wheels'")

    def loaded(self) -> World:
        """Return the world."""
        return self.world if isinstance(self.world, World) else load_world(self.world)


def driven(task: Task, world: World) -> tuple[str, ...]:
    """Return the names of the controlled robots.

    Raises:
        UsageError: One of them does not exist, or there is none.
    """
    known = [robot.name for robot in world.robots]
    if not known:
        raise UsageError(f"no robot in world '{world.name}'; an environment needs one to control")
    requested = known[:1] if task.robots is None else [task.robots] if isinstance(task.robots, str) else task.robots
    for name in requested:
        if name not in known:
            raise UsageError(f"no robot '{name}' in this world{did_you_mean(name, known)}")
    if not requested or len(set(requested)) < len(requested):
        raise UsageError(f"robots is {list(requested)}; name each controlled robot once")
    return tuple(requested)
