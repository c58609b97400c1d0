"""What is dragged while a world runs follows; the drag is one event with its targets, and repeats to the byte."""

import numpy as np
import pytest

import mjsim
from mjsim.record import same_run
from mjsim.session import keep_events
from mjsim.world import check_world
from tests.session.test_touch import ARM, PATIENCE, ticked
from tests.session.test_touch_hand import ROOM
from tests.session.test_touch_mechanism import bars

LIFT = """
mjsim: 1
mechanisms:
  - name: lift
    bodies: [{name: table, box: [1, 1, 0.1], mass: 5}, {name: flap, rod: [0.5, 0.02]}]
    joints:
      - {prismatic: up, of: [ground, table], axis: [0, 0, 1], start: 0.5, range: [0, 1]}
      - {revolute: hinge, of: [table, flap], axis: [0, 1, 0]}
    actuators: [{position: up, signal: {constant: {value: 0.5}}}]
run: {seconds: 0.4}
"""


def dragged(text, record, *drags):
    """Run a world while things are dragged at the same time, and return what was touched.

    Each drag is a list of targets, one each tick.
    """
    with mjsim.Session(mjsim.parse_world(text), record=record) as session:
        session.pause()
        session.wait("paused", timeout=PATIENCE)
        begun = set()
        for targets in zip(*drags, strict=True):
            for keys in targets:
                session.touch(keys, follows=keys.get("joint") in begun)
                begun.add(keys.get("joint"))
            ticked(session)
        session.go()
        session.result()
        return session.touched


def repeats(text, touched, hand, place) -> bool:
    """Return whether a run of a world with these events equals the recorded one to the byte."""
    world = mjsim.parse_world(keep_events(text, touched))
    assert check_world(world) == []
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, record=place / "kept.mcap")
    return same_run(hand, place / "kept.mcap")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "targets"),
    [
        (ARM, [{"reach": "r", "tool": [0.5, 0.1 - 0.02 * k, 0.4]} for k in range(8)]),
        (
            ROOM.replace("seconds: 2", "seconds: 0.4"),
            [{"reach": "anna", "hand": "right", "to": [1.1, 0.1 + 0.02 * k, 1]} for k in range(8)],
        ),
    ],
)
def test_a_drag_is_one_event_with_its_targets_and_repeats_to_the_byte(tmp_path, text, targets):
    hand = tmp_path / "hand.mcap"
    touched = dragged(text, hand, targets)
    (event,) = touched
    assert event.time == 0.04
    np.testing.assert_allclose([row[0] for row in event.then], 0.04 * np.arange(1, 8))
    assert repeats(text, touched, hand, tmp_path)
    assert len(mjsim.read_recording(hand).events) == 8  # each target is told of exactly


@pytest.mark.slow
def test_a_joint_follows_what_is_dragged_within_a_third_of_a_second():
    targets = np.linspace(0, 40, 26)  # [deg], in a second
    with mjsim.Simulation(mjsim.parse_world(bars().replace("slope_deg: 60", "slope_deg: 0"))) as sim:
        values = []
        for target in targets[1::2]:
            sim.lead("bars", "q2", 28.6 + target)
            for _ in range(2):
                sim.step()
                values.append(np.degrees(sim.motions()["bars"].positions[0]) - 28.6)
    lag = targets[-1] - values[-2]
    assert 0 < lag < 40 * 0.33
    assert np.diff(values).min() > 0


@pytest.mark.slow
def test_drags_at_the_same_time_are_one_event_each_and_other_targets_of_a_tick_replace_each_other(tmp_path):
    hand = tmp_path / "hand.mcap"
    up = [{"lead": "lift", "joint": "up", "to_deg": 0.5 + 0.1 * k} for k in range(4)]
    hinge = [{"lead": "lift", "joint": "hinge", "to_deg": 10 * k} for k in range(4)]
    touched = dragged(LIFT, hand, up, hinge)
    assert [(event.joint, len(event.then)) for event in touched] == [("up", 3), ("hinge", 3)]
    assert repeats(LIFT, touched, hand, tmp_path)
    again = tmp_path / "again.mcap"
    twice = dragged(LIFT, again, hinge, up, hinge[::-1])
    assert [event.joint for event in twice] == ["hinge", "up"]
    assert [twice[0].to_deg, *(row[1] for row in twice[0].then)] == [30, 20, 10, 0]
    assert [event.joint for event in mjsim.read_recording(again).events] == ["hinge", "up"] * 4


def test_a_target_of_another_motion_begins_an_event_of_its_own():
    with mjsim.Session(mjsim.parse_world(ARM)) as session:
        session.pause()
        session.wait("paused", timeout=PATIENCE)
        session.touch({"reach": "r", "tool": [0.5, 0.1, 0.4]})
        ticked(session)
        session.touch({"reach": "r", "joints_deg": [0, 0, 0, 0, 0, 0]}, follows=True)
        ticked(session)
        session.touch({"reach": "r", "joints_deg": [1, 0, 0, 0, 0, 0]})
        assert [event.then for event in session.touched] == [None, None, None]
