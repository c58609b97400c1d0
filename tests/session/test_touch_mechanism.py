"""Joints of mechanisms led by hand: they go where they are led to, stay there, and repeat once that is written down."""

import math
from contextlib import closing

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.record import same_run
from mjsim.session import keep_events
from mjsim.world import check_world

PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""
LINKS = """
mjsim: 1
mechanisms:
  - name: bars
    at: [3, 2]
    elevation: 4
    mode: MODE
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: coupler, rod: [3.5, 0.05]}, {name: rocker, rod: [3.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0], start_deg: 28.6}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
    actuators: [{KIND: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 60}}}]
  - name: rockers                              # neither the crank nor the rocker turns all round
    at: [3, 6]
    elevation: 4
    bodies: [{name: crank, rod: [2.5, 0.05]}, {name: coupler, rod: [1.0, 0.05]}, {name: rocker, rod: [2.5, 0.05]}]
    joints:
      - {revolute: p2, of: [ground, crank], axis: [0, 1, 0], start_deg: -80}
      - {revolute: p3, of: [crank.end, coupler]}
      - {revolute: p4, of: [{ground: [2.5, 0, 0]}, rocker]}
      - {revolute: p5, of: [coupler.end, rocker.end]}
    actuators: [{angle: p2, signal: {constant: {value_deg: -80}}}]
  - name: truss                                # a triangle, which nothing moves
    at: [6, 6]
    elevation: 4
    bodies: [{name: left, rod: [2.5, 0.05]}, {name: right, rod: [2.5, 0.05]}]
    joints:
      - {revolute: t1, of: [ground, left], axis: [0, 1, 0], near_deg: -60}
      - {revolute: t2, of: [left.end, right.end], near_deg: 60}
      - {revolute: t3, of: [{ground: [2.5, 0, 0]}, right]}
  - name: lift
    at: [0, 0]
    bodies: [{name: table, box: [1, 1, 0.1], mass: 5}, {name: flap, rod: [0.5, 0.02]}]
    joints:
      - {prismatic: up, of: [ground, table], axis: [0, 0, 1], start: 0.5, range: [0, 1]}
      - {revolute: hinge, of: [table, flap], axis: [0, 1, 0]}
    actuators: [{position: up, signal: {sine: {offset: 0.5, amplitude: 0.1, frequency_hz: 0.5}}}]
run: {seconds: 3}
"""


def bars(mode="forward", kind="angle"):
    """Return the text of a world with the bars alone."""
    return only(text(mode, kind), until="run:")


def only(world, *, until):
    """Leave out what is between the bars and another part of a world's text."""
    first, _, rest = world.partition("  - name: rockers")
    return first + rest[rest.index(until) :]


def text(mode="forward", kind="angle"):
    if kind == "velocity":
        signal = "{KIND: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 60}}}"
        return LINKS.replace("MODE", mode).replace(signal, "{velocity: q2, signal: {constant: {value_deg: 60}}}")
    return LINKS.replace("MODE", mode).replace("KIND", kind)


@pytest.mark.slow
def test_a_joint_that_is_led_goes_there_no_faster_than_it_was_or_a_radian_a_second_and_stays():
    with mjsim.Simulation(mjsim.parse_world(bars())) as sim:
        for _ in range(12):
            sim.step()
        sim.lead("bars", "q2", 140)
        speeds, jumps, before = [], [], sim.motions()["bars"]
        for _ in range(95):
            sim.step()
            now = sim.motions()["bars"]
            speeds.append(abs(now.velocities[0]))
            jumps.append(abs(now.accelerations[0] - before.accelerations[0]))
            before = now
    assert math.degrees(now.positions[0]) == pytest.approx(140, abs=0.01)
    assert now.goal[0] == pytest.approx(math.radians(140))
    assert speeds[-1] < 1e-3
    assert max(speeds) < 1.5  # it came with 60 degrees a second
    assert max(jumps) < 0.5  # [rad/s^2] in a tick of 0.04 s: no blow to what hangs on it


def ticks(sim, count):
    """Take ticks, and return values, goals, speeds and accelerations of the first joint of the bars, shape (4, n)."""
    found = []
    for _ in range(count):
        sim.step()
        now = sim.motions()["bars"]
        found.append((now.positions[0], now.goal[0], now.velocities[0], now.accelerations[0]))
    return np.array(found).T


@pytest.mark.slow
def test_a_released_joint_returns_smoothly_to_its_signal_modulo_whole_turns():
    with mjsim.Simulation(mjsim.parse_world(bars())) as sim:
        ticks(sim, 12)
        sim.lead("bars", "q2", 140)
        held = ticks(sim, 200)
        sim.release("bars", joint="q2")
        values, goals, speeds, changes = ticks(sim, 110)
        signal = np.radians(28.6 + 60 * (sim.tick * 0.04))
    assert math.degrees(held[0, -1]) == pytest.approx(140, abs=0.01)
    # In 8.5 s the signal has gone more than a turn farther: it is caught the shorter way.
    turns = (signal - goals[-1]) / (2 * math.pi)
    assert turns == pytest.approx(1, abs=1e-6)
    assert values[-1] == pytest.approx(goals[-1], abs=1e-4)
    assert speeds[-1] == pytest.approx(math.radians(60), abs=1e-3)
    assert np.abs(speeds).max() < math.radians(60) + 1.05
    assert np.abs(np.diff(changes)).max() < 0.5  # [rad/s^2] in a tick of 0.04 s


@pytest.mark.slow
def test_a_released_joint_with_a_speed_signal_continues_from_its_value():
    with mjsim.Simulation(mjsim.parse_world(bars(kind="velocity"))) as sim:
        sim.lead("bars", "q2", 140)
        ticks(sim, 120)
        sim.release("bars", joint="q2")
        values, _, speeds, _ = ticks(sim, 80)
    assert math.degrees(values[0]) == pytest.approx(140, abs=0.1)
    assert speeds[-1] == pytest.approx(math.radians(60), abs=1e-3)
    assert np.diff(speeds[:20]).min() > -1e-6  # it never goes back


@pytest.mark.slow
def test_a_joint_within_limits_comes_back_to_the_very_value_and_one_that_was_not_led_stays_with_its_signal():
    world = mjsim.parse_world(only(text(), until="  - name: lift"))
    with mjsim.Simulation(world) as sim, mjsim.Simulation(world) as plain:
        sim.release("lift", joint="up")
        for _ in range(5):
            sim.step()
            plain.step()
        assert np.array_equal(sim.state()[0], plain.state()[0])
        sim.lead("lift", "up", 0.9)
        for _ in range(25):
            sim.step()
        sim.release("lift", joint="up")
        for _ in range(60):
            sim.step()
        time = sim.tick * 0.04
        assert sim.motions()["lift"].goal[0] == pytest.approx(0.5 + 0.1 * math.sin(math.pi * time), abs=1e-9)


@pytest.fixture
def touched():
    session = mjsim.Session(mjsim.parse_world(text()))
    session.start(paused=True)
    assert session.wait("paused", timeout=PATIENCE) == "paused"
    with closing(session):
        yield session


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"lead": "bar", "joint": "q2", "to_deg": 1}, "no mechanism 'bar' in this world; did you mean 'bars'?"),
        (
            {"lead": "truss", "joint": "t3", "to_deg": 1},
            "joint 't3' of mechanism 'truss' cannot be led, as it does not move; nor can any other",
        ),
        (
            {"lead": "lift", "joint": "up", "to_deg": 1.5},
            "joint 'up' of mechanism 'lift' cannot go to 1.5; its range",
        ),
        ({"release": "truss", "joint": "t1"}, "joint 't1' of mechanism 'truss' cannot be led, as it does not move"),
        ({"release": "lift"}, "'lift' is a mechanism; name the joint"),
        ({"release": "lift", "joint": "up", "hand": "left"}, "'joint' is for mechanisms, 'hand' for people"),
        ({"lead": "rockers", "joint": "p2", "to_deg": 180}, "mechanism 'rockers' locks: with 'p2' at"),
    ],
)
def test_a_joint_that_cannot_be_led_so_is_refused_in_a_line(touched, keys, said):
    with pytest.raises(UsageError) as caught:
        touched.touch(keys)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert touched.touched == ()


def test_check_says_where_an_event_leads_a_joint_that_does_not_move():
    events = "events: [{time: 1, lead: truss, joint: t2, to_deg: 1}]"
    world = mjsim.parse_world(text().replace("{seconds: 3}", f"{{seconds: 3, {events}}}"))
    (problem,) = check_world(world)
    assert "joint 't2' of mechanism 'truss' cannot be led, as it does not move" in str(problem)


@pytest.mark.slow
@pytest.mark.parametrize(("mode", "joint"), [("forward", "q4"), ("kinematics", "q5")])
def test_a_joint_that_a_motion_moves_through_its_loop_is_led_by_that_motion_and_released_with_it(mode, joint):
    """q4 is the rocker's, q5 the one at which the loop is cut; both by the law of cosines."""
    with mjsim.Simulation(mjsim.parse_world(bars(mode))) as sim:
        sim.lead("bars", joint, {"q4": 115, "q5": 85}[joint])
        for _ in range(75):
            sim.step()
        motion = sim.motions()["bars"]
        held = dict(zip(motion.names, motion.positions, strict=True))
        gap = math.hypot(4 - math.cos(held["q2"]), math.sin(held["q2"]))
        expected = {
            "q5": math.acos((3.5**2 + 3.0**2 - gap**2) / (2 * 3.5 * 3.0)),
            "q4": math.pi
            - math.acos((3.0**2 + gap**2 - 3.5**2) / (2 * 3.0 * gap))
            - math.atan2(math.sin(held["q2"]), 4 - math.cos(held["q2"])),
        }
        assert np.abs(motion.velocities).max() < 1e-6
        assert math.degrees(held[joint]) == pytest.approx({"q4": 115, "q5": 85}[joint], abs=1e-4)
        assert held[joint] == pytest.approx(expected[joint], abs=1e-6)
        sim.release("bars", joint=joint)
        # At a radian a second it needs up to 6 s for half a turn.
        for _ in range(160):
            sim.step()
        after, time = sim.motions()["bars"], sim.time
    signal = math.radians(28.6 + 60 * time)
    assert math.remainder(after.positions[0] - signal, 2 * math.pi) == pytest.approx(0.0, abs=1e-4)


@pytest.mark.slow
def test_what_was_led_by_hand_repeats_to_the_byte_once_it_is_kept(tmp_path):
    hand, kept = tmp_path / "hand.mcap", tmp_path / "kept.mcap"
    world = only(text(), until="  - name: lift").replace("seconds: 3", "seconds: 2")
    with mjsim.Session(mjsim.parse_world(world), record=hand) as session:
        session.pause()
        session.wait("paused", timeout=PATIENCE)
        session.touch({"lead": "bars", "joint": "q2", "to_deg": 90})
        session.touch({"lead": "lift", "joint": "up", "to_deg": 0.8})
        session.tick()
        session.wait("paused", timeout=PATIENCE)
        session.touch({"lead": "lift", "joint": "up", "to_deg": 0.2})
        session.touch({"release": "bars", "joint": "q2"})
        session.go()
        session.result()
        events = session.touched
    assert [event.joint for event in events] == ["q2", "up", "up", "q2"]
    with mjsim.Simulation(mjsim.parse_world(keep_events(world, events))) as sim:
        mjsim.run(sim, record=kept)
    assert same_run(hand, kept)
    led = mjsim.read_recording(hand).joints["lift"]
    np.testing.assert_allclose(led.positions[-1][0], 0.2, atol=1e-3)
