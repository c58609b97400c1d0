"""Touching a run: what is done by hand is an event of the next tick, and repeats once it is written down."""

from contextlib import closing

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.record import same_run
from mjsim.session import keep_events, touches
from mjsim.world import check_world

PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""
FLAT = """
mjsim: 1
walls:
  - {points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}
  - {points: [[4, 0], [4, 6]], openings: [{name: gate, segment: 0, at: 0.5, width: 1, door: {}}]}
obstacles:
  - {box: [0.4, 2, 0.8], at: [6, 3], name: rack}
  - {cylinder: [0.2, 0.5], at: [2, 5], movable: true, mass: 3, name: bin}
beacons: [{name: lion, at: [1.5, 1]}]
robots:
  - {name: r, preset: pioneer3dx, at: [1, 3], odometry: {noise: {turn: 0.02}}}
  - {name: q, preset: pioneer3dx, at: [1, 1]}
run: {seconds: 0.5, events: [{time: 0.06, light: 0.5}]}
"""


def ticked(session):
    session.tick()
    assert session.wait("paused", timeout=PATIENCE) == "paused"


@pytest.fixture
def touched():
    """A paused session at its start, to be touched."""
    session = mjsim.Session(mjsim.parse_world(FLAT))
    session.start(paused=True)
    assert session.wait("paused", timeout=PATIENCE) == "paused"
    with closing(session):
        yield session


def test_a_kidnapped_robot_stands_elsewhere_at_the_next_tick_and_its_odometry_does_not_notice(touched):
    event = touched.touch({"move": "r", "to": [2.123456789, 3], "heading_deg": 90})
    assert (event.time, event.to) == (touched.newest.time + 0.04, (2.1235, 3.0))
    ticked(touched)
    now = touched.newest
    assert now.events == (event,)
    assert (now.truth["r"].x, now.truth["r"].y) == pytest.approx((2.1235, 3.0), abs=1e-3)
    assert abs(now.seen["r"].odometry.forward) < 0.01


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"move": "r", "to": [4, 3]}, "'r' is placed at [4, 3] inside walls[1]; move it to a free place"),
        ({"move": "r", "to": [1, 1.2]}, "'r' is placed at [1, 1.2] inside 'q'; move it to a free place"),
        ({"move": "r", "to": [2, 5.1]}, "inside obstacle 'bin'"),
        ({"move": "bin", "to": [6, 3]}, "inside obstacle 'rack'"),
        ({"move": "r", "to": [99, 1]}, "outside the world"),
        ({"move": "r", "to": [float("nan"), 1]}, "to[0] is nan; it must be a finite number"),
        ({"move": "r"}, "key 'to' is missing"),
        ({"mov": "r"}, "an event needs an action; did you mean 'move'?"),
        ({}, "an event needs an action"),
        ({"move": "rr", "to": [2, 2]}, "no robot or movable obstacle 'rr' in this world; did you mean 'r'?"),
        (
            {"push": "r", "along": [1, 0, 0], "signal": {"table": {"file": "gone.csv"}}},
            "the signal of the push of 'r': ",
        ),
        ({"open": "gat"}, "no door 'gat' in this world; did you mean 'gate'?"),
        ({"open": "gate", "angle_deg": 160}, "door 'gate' swings to 110 at most"),
        ({"time": 3, "remove": "lion"}, "a touch has no time of its own; it happens at the next tick"),
    ],
)
def test_a_touch_that_cannot_be_is_answered_in_a_line_and_changes_nothing(touched, keys, said):
    with pytest.raises(UsageError) as caught:
        touched.touch(keys)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert touched.touched == ()


def test_two_touches_of_one_tick_do_not_put_two_things_on_one_spot(touched):
    touched.touch({"move": "q", "to": [3, 4]})
    with pytest.raises(UsageError, match=r"'r' is placed at \[3.1, 4\] inside 'q'; move it to a free place"):
        touched.touch({"move": "r", "to": [3.1, 4]})
    touched.touch({"move": "r", "to": [1, 1]})  # from where the other goes in the same tick
    ticked(touched)
    assert [event.move for event in touched.newest.events] == ["q", "r"]
    assert (touched.newest.truth["r"].x, touched.newest.truth["r"].y) == pytest.approx((1, 1), abs=1e-3)


def test_a_session_that_is_over_cannot_be_touched_and_a_restart_forgets_touches(touched):
    touched.touch({"remove": "lion"})
    touched.restart()
    assert touched.wait("paused", timeout=PATIENCE) == "paused"
    assert touched.touched == ()
    touched.stop()
    assert touched.wait("ended", timeout=PATIENCE) == "ended"
    with pytest.raises(UsageError, match="the run is over"):
        touched.touch({"remove": "lion"})


ARM = """
mjsim: 1
robots: [{name: r, base: fixed, at: [1, 2], arms: [{preset: puma560}]}]
run:
  seconds: 0.8
  drivers: {r: {navigator: {use: "mjsim.algorithms.joint_path:JointPath", to_deg: [20, 0, 0, 0, 0, 0], seconds: 1}}}
"""


@pytest.mark.slow
def test_an_arm_that_was_moved_by_hand_moves_so_again_to_the_bit(tmp_path):
    session = mjsim.Session(mjsim.parse_world(ARM), record=tmp_path / "hand.mcap")
    session.start(paused=True)
    for move in (
        lambda: session.move_joints("r", "arm", [0.1, 0.2, -0.3, 0.1, 0.2, 0.3]),
        lambda: session.touch({"reach": "r", "tool": [0.5, 0.1, 0.4]}),
        lambda: session.move_joints("r", "arm", None),
        lambda: session.touch({"reach": "r", "joints_deg": [0, 10, -20, 0, 0, 160 / 3]}),
    ):
        assert session.wait("paused", timeout=PATIENCE) == "paused"
        move()
        for _ in range(3):
            ticked(session)
    session.go()
    assert session.wait(timeout=PATIENCE) == "ended"
    session.close()
    assert [event.time for event in session.touched] == sorted(event.time for event in session.touched)
    with mjsim.Simulation(mjsim.parse_world(keep_events(ARM, session.touched))) as sim:
        mjsim.run(sim, record=tmp_path / "file.mcap")
    assert same_run(tmp_path / "hand.mcap", tmp_path / "file.mcap")


TURN = "robots.r.odometry.noise.turn"


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("robots.r.body.mass", 5.0, "robots.r.body.mass cannot change during a run, only noise can"),
        ("robots.r.odometry.noise.turm", 5.0, "no key 'turm'; did you mean 'turn'?"),
        (TURN, -1.0, "turn is -1.0 rad/sqrt(rad); it must be at least 0"),
        ("robots.r.odometry.noise", 1.0, "noise is 1.0; it must be keys with values"),
    ],
)
def test_noise_that_cannot_be_is_answered_in_a_line_by_hand_and_in_a_file(touched, key, value, said):
    with pytest.raises(UsageError) as caught:
        touched.set_noise(key, value)
    assert said in str(caught.value)
    assert touched.touched == ()
    assert touched.world.robots[0].odometry.noise.turn == 0.02
    text = FLAT.replace("{time: 0.06, light: 0.5}", f"{{time: 1, noise: {key}, value: {value}}}")
    (problem,) = check_world(mjsim.parse_world(text))
    assert said in problem.message


@pytest.mark.slow
def test_noise_that_was_changed_by_hand_is_changed_so_again_to_the_bit_and_a_restart_keeps_it(tmp_path):
    session = mjsim.Session(mjsim.parse_world(FLAT), record=tmp_path / "hand.mcap", overwrite=True)
    session.start(paused=True)
    assert session.wait("paused", timeout=PATIENCE) == "paused"
    ticked(session)
    session.set_noise(TURN, 0.7)
    session.set_noise("robots.1.odometry.scale", 1.25)
    session.set_noise(TURN, 0.5)  # before its tick: the last one counts
    assert session.world.robots[0].odometry.noise.turn == 0.5
    ticked(session)
    session.go()
    assert session.wait(timeout=PATIENCE) == "ended"
    assert [(event.time, event.noise, event.value) for event in session.touched] == [
        (0.08, "robots.1.odometry.scale", 1.25),
        (0.08, TURN, 0.5),
    ]
    text = keep_events(FLAT, session.touched)
    assert not check_world(mjsim.parse_world(text))
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        kept = mjsim.run(sim, record=tmp_path / "file.mcap")
        assert sim.tuned.robots[0].odometry.noise.turn == 0.5
    assert same_run(tmp_path / "hand.mcap", tmp_path / "file.mcap")
    with mjsim.Simulation(mjsim.parse_world(FLAT)) as sim:
        plain = mjsim.run(sim)
    turns, quiet = (np.diff(each.robots["r"].odometry[:, 2] - each.robots["r"].truth[:, 2]) for each in (kept, plain))
    # Odometry of the tick in which it changes is the first that errs 25 times as far, by the same chance.
    np.testing.assert_allclose(turns[:1], quiet[:1], atol=1e-12)
    np.testing.assert_allclose(turns[2:], 25.0 * quiet[2:], rtol=0.05, atol=1e-5)

    session.restart()
    assert session.wait(timeout=PATIENCE) == "ended"
    session.close()
    assert [(event.time, event.value) for event in session.touched] == [(0.0, 1.25), (0.0, 0.5)]
    again = keep_events(FLAT, session.touched)
    with mjsim.Simulation(mjsim.parse_world(again)) as sim:
        mjsim.run(sim, record=tmp_path / "again.mcap")
    assert same_run(tmp_path / "hand.mcap", tmp_path / "again.mcap")


def test_noise_reset_to_the_worlds_value_is_not_an_event_of_a_restart(touched):
    touched.set_noise(TURN, 0.5)
    ticked(touched)
    touched.set_noise(TURN, 0.02)
    touched.restart()
    assert touched.wait("paused", timeout=PATIENCE) == "paused"
    assert touched.touched == ()
    assert touched.world.robots[0].odometry.noise.turn == 0.02


def test_a_session_tells_of_noise_that_an_event_of_the_file_changes():
    said = []
    text = FLAT.replace("{time: 0.06, light: 0.5}", f"{{time: 0.1, noise: {TURN}, value: 0.3}}")
    session = mjsim.Session(mjsim.parse_world(text), on_change=lambda: said.append(session.world))
    with session:
        session.result()
    assert session.world.robots[0].odometry.noise.turn == 0.3
    assert session.touched == ()
    assert len({world.robots[0].odometry.noise.turn for world in said}) == 2


@pytest.mark.slow
def test_what_was_done_by_hand_repeats_with_the_same_truth_once_it_is_written_down(tmp_path):
    session = mjsim.Session(mjsim.parse_world(FLAT), seed=4, record=tmp_path / "hand.mcap")
    session.start(paused=True)
    for touch in (
        {"move": "r", "to": [2.00004999, 3]},
        {"shove": "bin", "impulse": [1.23456789, -2, 0]},
        {"open": "gate", "angle_deg": -60},
        {"remove": "lion"},
        {"push": "q", "signal": {"random": {"deviation": 30, "hold": 0.05}}, "seconds": 0.2},
        {"move": "bin", "to": [2.5, 4.2]},
        {"close": "gate"},
    ):
        assert session.wait("paused", timeout=PATIENCE) == "paused"
        session.touch(touch)
        ticked(session)
    session.go()
    assert session.wait(timeout=PATIENCE) == "ended"
    session.close()
    world = mjsim.parse_world(keep_events(FLAT, session.touched))
    assert check_world(world) == []
    with mjsim.Simulation(world, seed=4) as sim:
        mjsim.run(sim, record=tmp_path / "file.mcap")
    assert same_run(tmp_path / "hand.mcap", tmp_path / "file.mcap")


def test_the_time_of_a_touch_is_written_short_and_still_means_its_tick():
    for rate in (7, 24, 30, 60, 90, 250):
        for tick in range(1, 1000):
            written = touches._written_time(tick / rate)
            assert round(written, 4) == written
            assert (tick - 1) / rate < written <= tick / rate + 1e-9
