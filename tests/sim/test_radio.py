"""What robots tell each other over the radio: when it comes, from how far, how often it is lost."""

import math

import numpy as np
import pytest

from mjsim.errors import ModuleFault, UsageError
from mjsim.interface import Command, Message
from mjsim.run import Driver, run
from mjsim.sim import Simulation
from mjsim.world import parse_world


def team(radio: str = "{}", places: tuple[tuple[float, float], ...] = ((0, 0), (3, 0), (0, 4)), **keys: int):
    robots = "".join(f"  - {{name: r{k}, at: [{x}, {y}]}}\n" for k, (x, y) in enumerate(places))
    return Simulation(parse_world(f"mjsim: 1\nradio: {radio}\nrobots:\n{robots}"), **keys)


def heard(sim: Simulation, robot: str) -> list[tuple[str, object]]:
    return [(message.sender, message.content) for message in sim.sense(robot).messages]


def test_what_is_sent_in_a_tick_reaches_all_others_in_the_next_one_once():
    sim = team()
    sim.apply("r1", Command(messages=("second",)))
    sim.apply("r0", Command(messages=({"pose": [1.5, -2.0], "names": ["a", None, True]}, 7)))
    assert heard(sim, "r2") == []
    sim.step()
    mine = ({"pose": [1.5, -2.0], "names": ["a", None, True]}, 7)
    assert heard(sim, "r2") == [("r0", mine[0]), ("r0", mine[1]), ("r1", "second")]
    assert heard(sim, "r2") == [("r0", mine[0]), ("r0", mine[1]), ("r1", "second")]
    assert heard(sim, "r0") == [("r1", "second")]
    assert all(message.stamp == 0.0 for message in sim.sense("r2").messages)
    sim.step()
    assert heard(sim, "r2") == []


def test_a_delay_is_exact_to_the_tick_and_nothing_is_missed_by_who_listens_late():
    sim = team("{delay: 3}")
    for tick in range(12):
        sim.apply("r0", Command(messages=(tick,)))
        if tick != 7:
            expected = [("r0", tick - 4)] if tick >= 4 else []
            expected = [("r0", 3), ("r0", 4)] if tick == 8 else expected
            assert heard(sim, "r1") == expected, tick
        sim.step()


def test_who_is_too_far_when_it_is_sent_hears_nothing():
    sim = team("{range: 3.5}", ((5, 5), (8, 5), (5, 9)))
    sim.apply("r0", Command(messages=("hello",)))
    sim.apply("r2", Command(messages=("who is there",)))
    sim.step()
    assert heard(sim, "r1") == [("r0", "hello")]
    assert heard(sim, "r2") == heard(sim, "r0") == []


def losses(sim: Simulation, count: int, receiver: str = "r1") -> list[bool]:
    lost = []
    for number in range(count):
        sim.apply("r0", Command(messages=(number,)))
        sim.step()
        lost.append(not sim.sense(receiver).messages)
    return lost


def test_messages_are_lost_as_often_as_asked_for_each_receiver_by_itself():
    many = tuple(range(60))
    sim = team("{loss: 0.25}")
    got = {"r1": 0, "r2": 0}
    both = 0
    for _ in range(20):
        sim.apply("r0", Command(messages=many))
        sim.step()
        came = {name: {message.content for message in sim.sense(name).messages} for name in got}
        got = {name: got[name] + len(came[name]) for name in got}
        both += len(came["r1"] & came["r2"])
    total = 20 * len(many)
    for name in got:
        assert got[name] / total == pytest.approx(0.75, abs=4 * math.sqrt(0.1875 / total)), name
    # Independent: 0.75 squared.
    assert both / total == pytest.approx(0.5625, abs=4 * math.sqrt(0.25 / total))


def test_another_robot_leaves_the_luck_of_the_others_as_it_was():
    before = losses(team("{loss: 0.5}"), 30)
    after = losses(team("{loss: 0.5}", ((0, 0), (3, 0), (0, 4), (9, 9))), 30)
    assert before == after
    assert 0 < sum(before) < 30
    assert losses(team("{loss: 0.5}", seed=2), 30) != before


@pytest.mark.parametrize("count", [1, 2, 32])
def test_any_number_of_robots_hear_each_other(count):
    sim = team(places=tuple((2.0 * (k % 8), 2.0 * (k // 8)) for k in range(count)))
    for name in sim.robots:
        sim.apply(name, Command(messages=(name,)))
    sim.step()
    for name in sim.robots:
        assert heard(sim, name) == [(other, other) for other in sim.robots if other != name]


def test_what_json_has_no_word_for_cannot_be_sent_and_arrays_come_as_lists():
    sim = team()
    for bad in (float("nan"), object(), {1, 2}, "x" * (1 << 20)):
        with pytest.raises(UsageError, match="robot 'r0' sends a message"):
            sim.apply("r0", Command(messages=(bad,)))
    array = np.array([[1.0, 2.0], [3.0, 0.1 + 0.2]])
    sim.apply("r0", Command(messages=((array, np.float64(0.1)),)))
    array[:] = 0.0
    sim.step()
    assert heard(sim, "r1") == [("r0", [[[1.0, 2.0], [3.0, 0.1 + 0.2]], 0.1])]


class Talker:
    """A navigator that says where it believes to be, and keeps what it hears."""

    def __init__(self, words: object = None) -> None:
        self.words, self.heard = words, []

    def start(self, robot, map, rng):
        self.name = robot.name

    def command(self, seen, belief):
        self.heard.append(seen.messages)
        words = [belief.pose.x, belief.pose.y] if self.words is None else self.words
        return Command(0.2, messages=(words,))


def test_a_run_records_what_was_sent_and_heard_exactly_and_avoidance_holds_nothing_back():
    sim = team("{delay: 1}")
    talkers = {name: Talker() for name in ("r0", "r1")}
    drivers = {name: Driver(navigator=talker, avoidance=True) for name, talker in talkers.items()}
    recording = run(sim, drivers=drivers, seconds=0.4)
    for name, other in (("r0", "r1"), ("r1", "r0")):
        read = [seen.messages for seen in recording.observations(name)]
        assert read == talkers[name].heard
        assert [len(messages) for messages in read] == [0, 0] + [1] * 8
        assert all(isinstance(message, Message) and message.sender == other for each in read for message in each)
        # What was believed two ticks before.
        for tick in range(2, 10):
            assert read[tick][0].content == recording.robots[other].estimate[tick - 2, :2].tolist()


def test_a_module_that_sends_what_cannot_be_sent_ends_the_run_with_its_name():
    with pytest.raises(ModuleFault, match=r"navigator Talker of robot 'r0' at 0.00 s returned a message that cannot"):
        run(team(), drivers={"r0": Driver(navigator=Talker(words={1, 2}))}, seconds=0.2)
