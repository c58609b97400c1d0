"""Tasks as dm_env has them."""

import unittest

import numpy as np
import pytest

from mjsim.env.episodes import Episodes
from tests.learning import NUMBERS, alike, room, task

pytest.importorskip("dm_control", reason="dm-control has releases for Python 3.11 and 3.12 only")

import dm_env
from dm_env import test_utils

from mjsim.env import DmEnvironment


class TestContract(test_utils.EnvironmentTestMixin, unittest.TestCase):
    """What DeepMind's own tests ask of every environment."""

    def make_object_under_test(self):
        return DmEnvironment(task(seconds=0.4, observations=NUMBERS))

    def make_action_sequence(self):
        rng, spec = np.random.default_rng(0), self.environment.action_spec()
        for _ in range(25):
            yield rng.uniform(spec.minimum, spec.maximum).astype(spec.dtype)


def test_episodes_are_those_of_the_seed_and_end_with_the_discount_that_tells_why():
    environment, episodes = DmEnvironment(task(observations=["scan"], seconds=0.4), seed=6), Episodes(task())
    first = environment.reset()
    episodes.begin(6)
    assert alike(first.observation["scan"], episodes.observation()["scan"])
    steps = [environment.step(np.array([0.5, 0.5])) for _ in range(10)]
    assert [step.step_type for step in steps] == [dm_env.StepType.MID] * 9 + [dm_env.StepType.LAST]
    assert steps[-1].discount == 1.0
    for _ in range(10):
        episodes.go_on([0.5, 0.5])
    assert alike(steps[-1].observation["scan"], episodes.observation()["scan"])
    assert steps[-1].reward == episodes.reward()
    again = environment.step(np.array([0.5, 0.5]))
    assert again.first()
    assert not alike(again.observation["scan"], first.observation["scan"])


def test_an_end_that_the_task_tells_has_no_future():
    with DmEnvironment(task(observations=["bump"]), seed=1) as environment:
        step = environment.reset()
        while not step.last():
            step = environment.step(np.array([-1.0, 0.0]))
        assert step.discount == 0.0
        assert environment.latest.seen["scout"].bump
        assert environment.control_timestep() == pytest.approx(0.04)


def test_several_robots_have_specs_by_robot():
    environment = DmEnvironment(task(world=room(), robots=["scout", "other"], observations=["proximity"]))
    assert set(environment.action_spec()) == {"scout", "other"}
    assert environment.action_spec()["other"].name == "other: forward, turn"
    step = environment.step({"scout": np.zeros(2), "other": np.zeros(2)})
    assert step.first()
    environment.observation_spec()["scout"]["proximity"].validate(step.observation["scout"]["proximity"])
