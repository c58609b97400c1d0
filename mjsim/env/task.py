"""What is to be learned: who is driven, what it observes, what is rewarded, and when an episode ends."""

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
    """A world to learn in; every kind of environment is made of one.

    The robots that are driven follow actions in place of their navigators; their `avoidance` and `push` hold as the
    world file says, and the reaction to bumps is always on. All other robots are driven by their own modules.
    """

    world: World | str | Path
    """Or its file."""
    robots: str | Sequence[str] | None = None
    """Who is driven: a name; or a list of names, then actions and observations are dicts by robot; the first robot of
    the world unless given."""
    observations: Sequence[str] | None = None
    """What a driven robot observes: 'proximity', 'bump', 'odometry', 'sightings', 'estimate', and its lidars, cameras
    and inertial sensors by name; by default all that it has but 'estimate'. What is left out costs nothing."""
    actions: Literal["twist", "wheels"] = "twist"
    """What an action is: (forward, turn), or (forward, left, turn) for robots that go sideways, or the speed of each
    wheel; in shares of the largest, from -1 to 1."""
    reward: Callable[[Step], float] = no_reward
    """Called once after each step."""
    terminated: Callable[[Step], bool] = never
    """Called once after each step; true ends the episode because something was reached or lost."""
    seconds: float | None = None
    """After which an episode is cut off, simulated [s]; by default as the world file says."""
    random_starts: bool = False
    """Whether driven robots begin at random free places that they could reach from where the world has them."""

    def __post_init__(self) -> None:
        """Check what can be checked without the world."""
        if self.actions not in ("twist", "wheels"):
            raise UsageError(f"actions is {self.actions!r}; it must be 'twist' or 'wheels'")

    def loaded(self) -> World:
        """Return the world."""
        return self.world if isinstance(self.world, World) else load_world(self.world)


def driven(task: Task, world: World) -> tuple[str, ...]:
    """Return the names of the robots that actions drive.

    Raises:
        UsageError: One of them is not there, or there is none.
    """
    known = [robot.name for robot in world.robots]
    if not known:
        raise UsageError(f"no robot in world '{world.name}'; an environment needs one to drive")
    asked = known[:1] if task.robots is None else [task.robots] if isinstance(task.robots, str) else task.robots
    for name in asked:
        if name not in known:
            raise UsageError(f"no robot '{name}' in this world{did_you_mean(name, known)}")
    if not asked or len(set(asked)) < len(asked):
        raise UsageError(f"robots is {list(asked)}; name each robot that is driven once")
    return tuple(asked)
