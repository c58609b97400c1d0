"""A task as a Gymnasium environment."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from mjsim.env.channels import Channel
from mjsim.env.episodes import Episodes, Seen
from mjsim.env.step import Step
from mjsim.env.task import Task
from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.sim import SEEN_FROM_OUTSIDE, Renderer

WIDTH, HEIGHT = 640, 360
"""Size of the pictures of `render` [px]."""


class GymEnvironment(gymnasium.Env[Seen, Any]):
    """A learning environment with one or several controlled robots; a step is one tick of the loop.

    `reset(seed=7)` starts the episode that `Simulation(world, seed=7)` would run; without a seed, the next one is drawn
    from `np_random`, as in Gymnasium. `info` has the `time` of the episode, and at its start the `seed`.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25}  # noqa: RUF012  # read from the class

    def __init__(self, task: Task, *, render_mode: str | None = None) -> None:
        """Compile the world.

        Args:
            task: The learning task.
            render_mode: 'rgb_array' for pictures of the scene from behind the first controlled robot.

        Raises:
            MjsimError: The world cannot be read, or the task names something that does not exist.
        """
        if render_mode not in (None, "rgb_array"):
            raise UsageError(f"render_mode is {render_mode!r}; it must be 'rgb_array' or None")
        self._episodes = Episodes(task)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self._episodes.sim.dt)}
        observed: dict[str, spaces.Space[Any]] = {
            name: _space(channels) for name, channels in self._episodes.channels.items()
        }
        driven: dict[str, spaces.Space[Any]] = {
            name: spaces.Box(each.low, each.high, dtype=np.float32) for name, each in self._episodes.actions.items()
        }
        first, alone = self._episodes.robots[0], self._episodes.together
        self.observation_space = observed[first] if alone else spaces.Dict(observed)
        self.action_space = driven[first] if alone else spaces.Dict(driven)
        self._renderer: Renderer | None = None

    @property
    def latest(self) -> Step:
        """The last step, with the truth."""
        return self._episodes.step

    @property
    def largest(self) -> dict[str, Array]:
        """Speeds that an action of 1 stands for, by robot, shape (n,) [m/s, rad/s]."""
        return {name: each.largest.copy() for name, each in self._episodes.actions.items()}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Seen, dict[str, Any]]:
        """Start an episode; return its first observation, and its time and seed."""
        super().reset(seed=seed)
        chosen = int(self.np_random.integers(2**31)) if seed is None else seed
        self._episodes.begin(chosen)
        return self._episodes.observation(), {"time": 0.0, "seed": chosen}

    def step(self, action: Any) -> tuple[Seen, float, bool, bool, dict[str, Any]]:
        """Advance by one tick; return observation, reward, terminated, truncated, and the time."""
        episodes = self._episodes
        episodes.go_on(action)
        return (
            episodes.observation(),
            episodes.reward(),
            episodes.terminated(),
            episodes.over,
            {"time": episodes.step.time},
        )

    def render(self) -> Picture | None:
        """Return the scene from behind the first controlled robot, shape (360, 640, 3)."""
        if self.render_mode is None:
            return None
        sim, view = self._episodes.sim, f"{self._episodes.robots[0]}/chase"
        if self._renderer is None:
            self._renderer = Renderer(sim.model, width=WIDTH, height=HEIGHT, groups=SEEN_FROM_OUTSIDE)
        return self._renderer.render(sim.data, view)

    def close(self) -> None:
        """Release the renderer."""
        if self._renderer is not None:
            self._renderer.close()
        self._episodes.close()


def _space(channels: dict[str, Channel]) -> spaces.Dict:
    return spaces.Dict(
        {name: spaces.Box(each.low, each.high, dtype=each.low.dtype.type) for name, each in channels.items()}
    )


# `gymnasium.make("mjsim.env.gym:mjsim/World-v0", task=...)` imports this module for the entry point, and so does
# `make_vec_env` of stable-baselines3.
gymnasium.register(id="mjsim/World-v0", entry_point="mjsim.env.gym:GymEnvironment")
