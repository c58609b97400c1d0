"""What every environment does, whatever its interface: actions in, arrays out, the same simulation in between."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest

import mjsim.env
from mjsim.env.episodes import Episodes
from mjsim.errors import ModuleFault, UsageError
from mjsim.interface import Command, WheelCommand
from mjsim.run import Driver, drivers_of, ticks
from mjsim.sim import Simulation
from mjsim.world import parse_world
from tests.learning import ROOM, alike, room, task


class Constant:
    """A navigator that always wants the same."""

    def __init__(self, command):
        self._command = command

    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return self._command


@pytest.mark.slow
def test_an_episode_is_what_the_simulation_does_with_the_same_commands():
    alone = room(robots=room().robots[:1], run=room().run.model_copy(update={"drivers": {}}))
    episodes, sim = Episodes(task(world=alone)), Simulation(alone, seed=7)
    (most_forward, most_turn) = episodes.actions["scout"].largest
    episodes.begin(7)
    for action in np.random.default_rng(0).uniform(-1, 1, (50, 2)).astype(np.float32):
        seen = sim.sense("scout")
        assert np.array_equal(seen.odometry.covariance, episodes.step.seen["scout"].odometry.covariance)
        assert episodes.step.truth == sim.truths()
        got = episodes.observation()
        assert np.array_equal(got["proximity"], np.minimum(seen.proximity, 2.0).astype(np.float32))
        if "scan" in seen.scans:
            assert np.array_equal(got["scan"], np.clip(seen.scans["scan"].ranges, 0, 4).astype(np.float32))
        felt = [[*reading.acceleration, *reading.turn] for reading in seen.imu]
        assert np.array_equal(got["inertia"], np.array(felt or np.zeros((5, 6)), dtype=np.float32))
        sim.apply("scout", Command(float(action[0]) * most_forward, turn=float(action[1]) * most_turn))
        sim.step()
        episodes.go_on(action)
    assert episodes.step.time == sim.time == pytest.approx(2.0)


@pytest.mark.slow
def test_all_robots_move_as_in_a_run_whose_navigator_wants_what_the_action_says():
    episodes = Episodes(task())
    world, fastest = episodes.world, float(episodes.actions["scout"].largest[0])
    with Simulation(world, seed=3) as sim:
        loop = ticks(sim, drivers_of(world) | {"scout": Driver(navigator=Constant(Command(fastest)))})
        run = [next(loop) for _ in range(190)]
    episodes.begin(3)
    events = []
    for tick in run:
        assert episodes.step.truth == tick.truth
        events += episodes.step.events["scout"]
        episodes.go_on([1.0, 0.0])
        assert episodes.step.command["scout"] == tick.orders["scout"].command
    told = [event for tick in run for event in tick.orders["scout"].events]
    assert [event.kind for event in told] == ["bump", "blocked"]
    # That a command was not let through is known at the end of its step, a bump as soon as it is felt.
    assert [event.time for event in events] == [event.time for event in told]
    assert abs(run[-1].truth["other"].x - 1.0) > 0.1


@pytest.mark.slow
def test_the_same_seed_gives_the_same_episode_whatever_came_before():
    one, other = Episodes(task(random_starts=True)), Episodes(task(random_starts=True))
    for seed in (1, 5, 1):
        one.begin(seed)
        rows = []
        for _ in range(20):
            one.go_on([1.0, 0.3])
            rows.append((one.observation(), one.reward()))
    other.begin(1)
    for observation, reward in rows:
        other.go_on([1.0, 0.3])
        assert alike(other.observation(), observation)
        assert other.reward() == reward
    other.begin(2)
    other.go_on([1.0, 0.3])
    assert not alike(other.observation()["scan"], rows[0][0]["scan"])


def test_what_is_left_out_leaves_the_rest_byte_for_byte_and_is_not_drawn():
    few, many = Episodes(task(observations=["scan"])), Episodes(task())
    assert [len(each.sim.robots["scout"].sensors) for each in (few, many)] == [1, 3]
    for episodes in (few, many):
        episodes.begin(4)
        for _ in range(10):
            episodes.go_on([0.5, 0.5])
    assert alike(few.observation()["scan"], many.observation()["scan"])
    assert few.step.truth == many.step.truth


def test_readings_are_held_until_newer_ones_come_and_never_share_memory():
    episodes = Episodes(task())
    episodes.begin(1)
    scans = []
    for _ in range(4):
        scans.append(episodes.observation()["scan"])
        episodes.go_on([0.5, 0.0])
    assert alike(scans[0], scans[1])
    assert not alike(scans[1], scans[2])
    assert not np.shares_memory(scans[0], scans[1])


def test_sightings_come_in_the_order_of_the_world_with_zeros_for_what_is_not_seen():
    west = parse_world(
        ROOM.replace("at: [1, 1]", "at: [1, 1]\n    heading_deg: 90").replace(
            "beacons: ring", "beacons: ring, fov_deg: 60"
        )
    )
    episodes = Episodes(task(world=west, observations=["sightings"]))
    episodes.begin(1)
    (seen_a, *_), (seen_b, distance, bearing) = episodes.observation()["sightings"].tolist()
    assert (seen_a, seen_b) == (0.0, 1.0)
    assert distance == pytest.approx(math.hypot(0.9, 2.0), abs=0.3)
    assert bearing == pytest.approx(math.atan2(0.9, 2.0), abs=0.1)


def test_a_touched_sector_of_the_ring_reads_one():
    episodes = Episodes(task(observations=["bump", "proximity"], robots="scout"))
    episodes.begin(1)
    while not episodes.terminated():
        assert not episodes.observation()["bump"].any()
        episodes.go_on([-1.0, 0.0])
    # Driven backwards into the wall behind it.
    assert np.flatnonzero(episodes.observation()["bump"]).tolist() == [8]
    assert episodes.observation()["proximity"][8] < 0.01
    assert episodes.step.events["scout"][0].kind == "bump"
    episodes.go_on([-1.0, 0.0])
    assert episodes.step.wanted["scout"].forward < 0.0
    assert episodes.step.command["scout"].forward == 0.0


@pytest.mark.slow
def test_random_starts_are_free_within_reach_and_known_to_the_robot_itself():
    episodes = Episodes(task(random_starts=True, observations=["estimate", "bump"]))
    starts = []
    for seed in range(40):
        episodes.begin(seed)
        assert not episodes.observation()["bump"].any()
        start, other = episodes.step.truth["scout"], episodes.step.truth["other"]
        assert episodes.observation()["estimate"] == pytest.approx(start.as_array(), abs=1e-5)
        assert math.hypot(start.x - other.x, start.y - other.y) > 0.22 + 0.1
        starts.append(start.as_array())
    spread = np.array(starts)
    # All of the room in which it stands, nothing of the one behind the wall.
    assert 0.05 + 0.22 < spread[:, 0].min() < 1.0
    assert 5.0 < spread[:, 0].max() < 5.95 - 0.22
    assert spread[:, 1].min() < 1.0
    assert spread[:, 1].max() > 3.0
    assert np.ptp(spread[:, 2]) > 5.0


def test_a_world_without_a_free_place_is_an_error():
    tight = parse_world(ROOM.replace("scout\n", "scout\n    body: {radius: 2.1}\n"))
    with pytest.raises(UsageError, match="no free place for robot 'scout'; it is too wide for this world"):
        Episodes(task(world=tight, random_starts=True))


def test_wheels_are_driven_by_shares_of_their_largest_speed():
    episodes = Episodes(task(actions="wheels"))
    actions, info = episodes.actions["scout"], episodes.sim.robots["scout"]
    assert actions.names == info.wheels
    most = (info.max_speed + info.max_turn * info.track / 2) / info.wheel_radius
    assert actions.largest == pytest.approx([most, most])
    command = actions.command([0.5, -0.5])
    assert isinstance(command, WheelCommand)
    assert command.speeds == pytest.approx((most / 2, -most / 2))
    episodes.begin(1)
    episodes.go_on([0.5, -0.5])
    assert episodes.step.wanted["scout"] == command


@pytest.mark.parametrize(
    ("package", "module", "name", "message"),
    [
        ("gymnasium", "gym", "GymEnvironment", "gymnasium is not installed; type: .* install .*gymnasium$"),
        ("dm_control.rl", "control_env", "DmEnvironment", "dm-control, which supports only Python 3.11 and 3.12, is"),
    ],
)
def test_what_is_not_installed_is_told_with_what_to_do(monkeypatch, package, module, name, message):
    monkeypatch.delitem(sys.modules, f"mjsim.env.{module}", raising=False)
    monkeypatch.delitem(vars(mjsim.env), name, raising=False)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(UsageError, match=message):
        getattr(mjsim.env, name)


def test_several_robots_are_driven_by_dicts():
    episodes = Episodes(task(robots=["scout", "other"], observations=["odometry"], reward=lambda step: 1.0))
    episodes.begin(1)
    for _ in range(25):
        episodes.go_on({"scout": [0.0, 1.0], "other": [0.5, 0.0]})
    assert set(episodes.observation()) == {"scout", "other"}
    assert episodes.step.truth["scout"].heading > 0.5
    assert episodes.step.truth["other"].x > 1.05
    with pytest.raises(UsageError, match="no action for robot 'other'; each step needs one of scout, other"):
        episodes.go_on({"scout": [0, 0]})
    with pytest.raises(UsageError, match="no robot 'othr' is controlled by actions; did you mean 'other'"):
        episodes.go_on({"scout": [0, 0], "othr": [0, 0]})


@pytest.mark.slow
def test_the_avoidance_of_the_world_file_keeps_its_hand_in():
    careful = room(
        run=room().run.model_copy(
            update={
                "drivers": parse_world(
                    ROOM.replace("other: {nav", "scout: {avoidance: true}\n    other: {nav")
                ).run.drivers
            }
        )
    )
    episodes = Episodes(task(world=careful))
    episodes.begin(1)
    for _ in range(200):
        episodes.go_on([1.0, 0.0])
        assert not episodes.terminated()
    assert episodes.step.truth["scout"].x > 2.0


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ([0.0, 0.0, 0.0], r"the action for robot 'scout' has shape \(3,\); it must be \(2,\): forward, turn"),
        ([0.0, math.nan], r"the action for robot 'scout' is \[0.0, nan\]; its numbers must be finite"),
        ("north", r"the action for robot 'scout' is 'north'; it must be \(2,\): forward, turn"),
    ],
)
def test_an_invalid_action_is_an_error(action, message):
    episodes = Episodes(task(observations=["odometry"]))
    with pytest.raises(UsageError, match="reset the environment before its first step"):
        episodes.go_on([0, 0])
    episodes.begin(1)
    with pytest.raises(UsageError, match=message):
        episodes.go_on(action)


def test_what_the_functions_of_a_task_must_not_return_is_told():
    episodes = Episodes(task(observations=["odometry"]))
    episodes.begin(1)
    for part, value in (("reward", math.nan), ("reward", None), ("terminated", 1.0)):
        episodes.task = replace(episodes.task, **{part: lambda step, value=value: value})
        right = "a finite number" if part == "reward" else "True or False"
        with pytest.raises(ModuleFault, match=f"{part} <lambda> at 0.00 s returned {value}; it must be {right}"):
            getattr(episodes, part)()


def give_up(step):
    raise SystemExit("no more")


class Odd:
    def __float__(self):
        return 1 / 0

    def __repr__(self):
        return "odd\n" * 1000


def test_what_the_functions_of_a_task_raise_is_one_line_and_so_is_an_odd_value():
    episodes = Episodes(task(observations=["odometry"]))
    episodes.begin(1)
    for part, function, said in (
        ("reward", give_up, r"give_up at 0\.00 s raised SystemExit: no more \(test_env\.py:\d+\)$"),
        ("reward", lambda step: step.nothing, r"<lambda> at 0\.00 s raised AttributeError: .* \(test_env\.py:\d+\)$"),
        ("reward", lambda step: Odd(), r"<lambda> at 0\.00 s returned odd odd .*; it must be a finite number$"),
        ("terminated", give_up, r"give_up at 0\.00 s raised SystemExit: no more \(test_env\.py:\d+\)$"),
    ):
        episodes.task = replace(episodes.task, **{part: function})
        with pytest.raises(ModuleFault, match=f"^{part} {said}") as caught:
            getattr(episodes, part)()
        assert str(caught.value).isprintable()
        assert len(str(caught.value)) < 1000
        assert caught.value.exit_code == 1


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"robots": "scot"}, "no robot 'scot' in this world; did you mean 'scout'"),
        ({"robots": []}, r"robots is \[\]; name each controlled robot once"),
        ({"observations": ["scn"]}, "robot 'scout' observes no 'scn'; did you mean 'scan'"),
        ({"actions": "legs"}, "actions is 'legs'; it must be 'twist' or 'wheels'"),
        ({"seconds": math.inf}, "seconds is inf; an episode has at least one tick of 0.04 s, and at most"),
        ({"seconds": 0.001}, "seconds is 0.001; an episode has at least one tick of 0.04 s"),
        ({"world": room(robots=())}, "no robot in world 'learning'; an environment needs one to control"),
    ],
)
def test_an_invalid_task_is_an_error_at_once(keys, message):
    with pytest.raises(UsageError, match=message):
        Episodes(task(**keys))
