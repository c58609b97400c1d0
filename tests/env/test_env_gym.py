"""Tasks as Gymnasium has them: one environment, and several side by side."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from mjsim.env import GymEnvironment, Task, vector_environment
from mjsim.errors import MjsimError, UsageError
from mjsim.world import parse_world
from tests.learning import NUMBERS, ROOM, advance, alike, room, task, touched


@pytest.mark.parametrize("keys", [{}, {"actions": "wheels", "random_starts": True}, {"robots": ["other", "scout"]}])
def test_gymnasiums_checker_passes(keys):
    observations = ("odometry", "bump") if "robots" in keys else NUMBERS
    env = gymnasium.make("mjsim.env.gym:mjsim/World-v0", task=task(observations=observations, **keys))
    # Warnings are errors in these tests.
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


def made_by_name(seed: int):
    """Make an environment as libraries of learning do, which know its name and its arguments alone."""
    env = gymnasium.make("mjsim.env.gym:mjsim/World-v0", task=task())
    return gymnasium.wrappers.RecordEpisodeStatistics(env), env.reset(seed=seed)[0]


@pytest.mark.slow
def test_environments_made_by_name_are_those_of_the_task_and_independent():
    (one, first), (two, second) = made_by_name(1), made_by_name(2)
    alone = GymEnvironment(task())
    assert alike(first, alone.reset(seed=1)[0])
    assert not alike(first, second)
    command = np.array([0.5, 0.2])
    for _ in range(5):
        two.step(-command)
        assert alike(one.step(command)[0], alone.step(command)[0])
    over = False
    while not over:
        *_, ended, cut, info = one.step(command)
        over = ended or cut
    assert info["episode"]["l"] > 5
    for env in (one, two, alone):
        env.close()


@pytest.mark.slow
def test_gymnasium_makes_many_by_name():
    name = "mjsim.env.gym:mjsim/World-v0"
    many = vector_environment(task(), 2, processes=1)
    after_another = gymnasium.make_vec(name, num_envs=2, task=task())
    seen = [each.reset(seed=3)[0] for each in (many, after_another)]
    assert alike(*seen)
    actions = np.full((2, 2), 0.5, dtype=np.float32)
    for _ in range(3):
        seen = [each.step(actions)[0] for each in (many, after_another)]
        assert alike(*seen)
    many.close()
    after_another.close()


@pytest.mark.slow
def test_gymnasiums_checker_passes_with_pictures():
    world = parse_world(ROOM.replace("noise: 3}", "noise: 3, depth: true}"))
    env = gymnasium.make(
        "mjsim.env.gym:mjsim/World-v0", task=task(world=world, observations=None), render_mode="rgb_array"
    )
    check_env(env.unwrapped)
    observation, _ = env.reset(seed=1)
    assert observation["front"].shape == (24, 32, 3)
    assert observation["front"].dtype == np.uint8
    assert observation["front"].std() > 10
    assert 0.0 < observation["front_depth"].min() < observation["front_depth"].max() <= 10.0
    picture = env.render()
    assert picture.shape == (360, 640, 3)
    env.step(np.array([0.0, 1.0]))
    assert (env.render() != picture).any()
    env.close()
    env.close()


def test_an_episode_is_cut_off_when_its_time_is_over_and_ends_when_the_task_says_so():
    env = GymEnvironment(task(observations=["bump"], seconds=0.4))
    env.reset(seed=1)
    ends = [env.step(np.zeros(2))[2:4] for _ in range(10)]
    assert ends == [(False, False)] * 9 + [(False, True)]
    env.reset(seed=1)
    env.step(np.array([-1.0, 0.0]))
    ended = GymEnvironment(task(observations=["bump"]))
    ended.reset(seed=1)
    steps = [ended.step(np.array([-1.0, 0.0])) for _ in range(48)]
    assert [step[2] for step in steps].index(True) > 20
    assert steps[-1][3] is False
    assert sum(step[1] for step in steps) == pytest.approx(ended.latest.truth["scout"].x - 1.0)


def test_without_a_seed_each_episode_is_another_and_all_follow_from_the_first():
    one, other = (GymEnvironment(task(observations=["odometry"])) for _ in range(2))
    for env in (one, other):
        env.reset(seed=5)
    first, second = one.reset()[1]["seed"], one.reset()[1]["seed"]
    assert first != second
    assert [other.reset()[1]["seed"] for _ in range(2)] == [first, second]


def test_what_an_action_of_one_stands_for_is_told():
    env = GymEnvironment(task(observations=["odometry"], robots=["scout", "other"]))
    largest = env.largest
    assert largest["other"] == pytest.approx([0.22, 2.84], rel=1e-3)
    assert env.action_space["other"].shape == (2,)
    with pytest.raises(UsageError, match="render_mode is 'human'; it must be 'rgb_array' or None"):
        GymEnvironment(task(), render_mode="human")


@pytest.mark.slow
def test_environments_side_by_side_are_the_single_ones_of_their_seeds():
    short = Task(world=room(), observations=["scan"], reward=advance, terminated=touched, seconds=0.4)
    actions = np.random.default_rng(0).uniform(-1, 1, (15, 2, 2)).astype(np.float32)
    side_by_side = vector_environment(short, 2, processes=1)
    seen = [side_by_side.reset(seed=7)[0]["scan"]]
    rewards, cut = [], []
    for action in actions:
        observation, reward, _, truncated, _ = side_by_side.step(action)
        seen.append(observation["scan"])
        rewards.append(reward)
        cut.append(truncated)
    side_by_side.close()
    for number in range(2):
        env = GymEnvironment(short)
        expected = [env.reset(seed=7 + number)[0]["scan"]]
        for row, action in enumerate(actions):
            if row == 10:  # the step after the end begins anew
                expected.append(env.reset()[0]["scan"])
                continue
            observation, reward, _, truncated, _ = env.step(action[number])
            expected.append(observation["scan"])
            assert rewards[row][number] == reward
            assert cut[row][number] == truncated
        assert all(alike(row[number], each) for row, each in zip(seen, expected, strict=True))


@pytest.mark.slow
def test_what_goes_wrong_in_a_process_is_told_in_a_line_and_the_others_go_on():
    def rude(step):
        if step.time > 0.06:
            raise KeyError("door")
        return 0.0

    several = vector_environment(task(observations=["odometry"], reward=rude), 3, processes=2)
    several.reset(seed=[5, 6, 7])
    with pytest.raises(UsageError, match="2 seeds for 3 environments; give one, or one for each"):
        several.reset(seed=[5, 6])
    with pytest.raises(UsageError, match=r"the action for robot 'scout' is .*nan.*; its numbers must be finite"):
        several.step(np.full((3, 2), np.nan))
    several.step(np.zeros((3, 2)))
    with pytest.raises(MjsimError, match=r"reward rude at 0.08 s raised KeyError: 'door' \(test_env_gym.py:\d+\)"):
        several.step(np.zeros((3, 2)))
    assert several.reset(seed=[5, 6, 7])[1]["seed"].tolist() == [5, 6, 7]
    several.close()
    several.close()


@pytest.mark.parametrize(("keys", "message"), [((0, 1), "count is 0"), ((1, 0), "processes is 0")])
def test_a_vector_environment_needs_an_environment_and_a_process(keys, message):
    count, processes = keys
    with pytest.raises(UsageError, match=f"{message}; it must be 1 or more"):
        vector_environment(task(), count, processes=processes)
