"""A task as a `dm_env` environment, on dm-control's `rl.control`."""

from collections import OrderedDict
from typing import Any

import numpy as np
from dm_control.rl import control
from dm_env import specs

from mjsim.env.actions import Actions
from mjsim.env.channels import Channel
from mjsim.env.episodes import Episodes, Seen
from mjsim.env.step import Step
from mjsim.env.task import Task


class DmEnvironment(control.Environment):
    """A learning environment with one or several controlled robots; a step is one tick of the loop.

    It is based on `rl.control`: its physics is our simulation, stepped by whole ticks, and its task is ours.
    An episode ends with discount 0 when the task terminates it, and with discount 1 at its time limit.
    """

    def __init__(self, task: Task, *, seed: int | None = None) -> None:
        """Compile the world.

        Args:
            task: The learning task.
            seed: Seed of the first episode; those of the others are drawn from it. By default that of the world.

        Raises:
            MjsimError: The world cannot be read, or the task names something that does not exist.
        """
        episodes = Episodes(task)
        physics = _Physics(episodes, episodes.world.run.seed if seed is None else seed)
        # Half a tick less, so that time limit / tick, rounded up, is the number of ticks.
        super().__init__(physics, _Task(episodes), time_limit=(episodes.length - 0.5) * episodes.sim.dt)
        self._episodes = episodes

    @property
    def latest(self) -> Step:
        """The last step, with the truth."""
        return self._episodes.step

    def close(self) -> None:
        """Release the renderer."""
        self._episodes.close()


class _Physics(control.Physics):
    """A simulation with the interface of dm-control's physics."""

    def __init__(self, episodes: Episodes, seed: int) -> None:
        self._episodes, self._next = episodes, seed
        self._seeds = np.random.default_rng([seed, *b"environment/episodes"])
        self.action: Any = None

    def reset(self) -> None:
        self._episodes.begin(self._next)
        self._next = int(self._seeds.integers(2**31))

    def after_reset(self) -> None:
        """Do nothing; a simulation is ready once it is reset."""

    def step(self, n_sub_steps: int = 1) -> None:
        for _ in range(n_sub_steps):
            self._episodes.go_on(self.action)

    def set_control(self, control: Any) -> None:
        self.action = control

    def time(self) -> float:
        return self._episodes.sim.time

    def timestep(self) -> float:
        return self._episodes.sim.dt


class _Task(control.Task):
    """A task with the interface of dm-control's tasks."""

    def __init__(self, episodes: Episodes) -> None:
        self._episodes = episodes

    def initialize_episode(self, physics: _Physics) -> None:
        """Do nothing; an episode starts when the physics is reset."""

    def before_step(self, action: Any, physics: _Physics) -> None:
        physics.set_control(action)

    def action_spec(self, physics: _Physics) -> Any:
        found = {name: _action_spec(name, each) for name, each in self._episodes.actions.items()}
        return found[self._episodes.robots[0]] if self._episodes.together else found

    def observation_spec(self, physics: _Physics) -> Any:
        found = {name: _observation_spec(each) for name, each in self._episodes.channels.items()}
        return found[self._episodes.robots[0]] if self._episodes.together else found

    def get_observation(self, physics: _Physics) -> Seen:
        return self._episodes.observation()

    def get_reward(self, physics: _Physics) -> float:
        return self._episodes.reward()

    def get_termination(self, physics: _Physics) -> float | None:
        return 0.0 if self._episodes.terminated() else None


def _action_spec(robot: str, actions: Actions) -> specs.BoundedArray:
    low, high = actions.low, actions.high
    return specs.BoundedArray(low.shape, low.dtype, low, high, name=f"{robot}: {', '.join(actions.names)}")


def _observation_spec(channels: dict[str, Channel]) -> "OrderedDict[str, specs.BoundedArray]":
    return OrderedDict(
        (name, specs.BoundedArray(each.low.shape, each.low.dtype, each.low, each.high, name=name))
        for name, each in channels.items()
    )
