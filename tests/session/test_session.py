"""A session: a run in a thread of its own, which others start, pause, slow, steer and watch."""

import re
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.record import same_run
from mjsim.session.gate import MAX_DELAY, Pace
from mjsim.session.helm import Helm

ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
beacons: [{name: a, at: [1.5, 1]}, {name: b, at: [-1.5, 1]}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [0, 0]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors:
      - {beacons: ring, noise: {range: 0.05, bearing_deg: 1}}
      - {lidar: scan, beams: 20, noise: {range: 0.01}}
      - {imu: imu, noise: {turn: 0.01}}
run: {seconds: 2}
"""
WORLD = mjsim.parse_world(ROOM)
PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""


class Circle:
    """A navigator; with `until` it fails at that time."""

    def __init__(self, until=np.inf):
        self.until = until

    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        assert seen.time < self.until, "enough"
        return mjsim.Command(0.3, 0.0, 0.5)


def drivers(until=np.inf):
    return {"scout": mjsim.Driver(navigator=Circle(until), avoidance=True)}


@pytest.fixture
def session():
    with mjsim.Session(WORLD, drivers=drivers()) as session:
        yield session


def paused(**keys):
    """Return a session that has shown its start and waits."""
    session = mjsim.Session(WORLD, drivers=drivers(), **keys)
    session.start(paused=True)
    assert session.wait("paused", timeout=PATIENCE) == "paused"
    return session


@pytest.mark.slow
def test_a_session_paused_and_ticked_at_random_records_the_bytes_of_a_plain_run(tmp_path):
    with mjsim.Simulation(WORLD, seed=5) as sim:
        mjsim.run(sim, drivers=drivers(), seconds=2.0, record=tmp_path / "plain.mcap")
    rng = np.random.default_rng(0)
    session = paused(seed=5, seconds=2.0, record=tmp_path / "session.mcap")
    while session.state not in ("ended", "failed"):
        match rng.integers(4):
            case 0:
                session.go()
                session.pause()
            case 1:
                session.speed = float(rng.uniform(20.0, 200.0))
            case 2:
                session.watch().next(PATIENCE)
        session.tick()
        session.wait("paused", "ended", "failed", timeout=PATIENCE)
    session.result()
    session.close()
    assert same_run(tmp_path / "plain.mcap", tmp_path / "session.mcap")


def test_a_paused_session_stands_until_it_is_told_to_go_on_or_to_take_a_tick():
    session = paused()
    watcher = session.watch()
    assert watcher.next(PATIENCE).time == 0.0
    with pytest.raises(TimeoutError, match=r"there was no tick within 0\.05 s"):
        watcher.next(0.05)
    session.tick()
    # Else a button to pause would become one to go on as it is pressed.
    assert session.shown == "paused"
    assert watcher.next(PATIENCE).time == pytest.approx(0.04)
    assert session.shown == "paused"
    assert session.wait("paused", timeout=PATIENCE) == "paused"
    session.go()
    assert session.wait(timeout=PATIENCE) == "ended"
    assert session.newest.time == pytest.approx(1.96)
    assert watcher.next(PATIENCE).time == pytest.approx(1.96)
    assert watcher.next(PATIENCE) is None
    session.close()


def test_a_tick_that_is_asked_for_while_the_world_is_loading_comes_after_the_first():
    session = mjsim.Session(WORLD, drivers=drivers())
    session.start(paused=True)
    session.tick()
    watcher = session.watch()
    while watcher.next(PATIENCE).time < 0.04 - 1e-9:
        pass
    assert session.wait("paused", timeout=PATIENCE) == "paused"
    assert session.newest.time == pytest.approx(0.04)
    session.close()


@pytest.mark.slow
def test_a_restart_begins_at_the_start_with_the_same_noise_and_ends_where_it_ended_before(session):
    session.result()
    first = session.newest
    session.restart()
    session.result()
    assert session.newest is not first
    assert session.newest.truth == first.truth
    session.restart(seed=9)
    session.result()
    assert session.newest.truth != first.truth


def test_who_waits_for_a_run_to_go_on_after_a_restart_is_told_at_once():
    with mjsim.Session(WORLD, drivers=drivers(), seconds=1e6, speed=1.0) as session:
        for _ in range(2):
            began = time.perf_counter()
            assert session.wait("running", timeout=PATIENCE) == "running"
            # A tenth of the patience is long for a reset of this room, and short of what nobody tells.
            assert time.perf_counter() - began < PATIENCE / 10
            session.restart()


def test_a_run_that_was_stopped_is_over_and_its_recording_whole(tmp_path):
    session = paused(record=tmp_path / "run.mcap")
    session.tick()
    session.wait("paused", timeout=PATIENCE)
    session.stop()
    assert session.wait(timeout=PATIENCE) == "ended"
    recording = mjsim.read_recording(tmp_path / "run.mcap")
    assert len(recording.time) == 2
    assert recording.whole
    session.close()


def test_a_watcher_gets_the_newest_tick_and_does_not_delay_others(session):
    watcher = session.watch()
    first = watcher.next(PATIENCE)
    session.result()
    # It asked for one tick alone while fifty were made; now it gets the last, and is told that there are no more.
    assert first.time <= watcher.next().time == pytest.approx(1.96)
    assert list(watcher) == []


def test_a_module_that_fails_reaches_who_watches_and_who_waits_and_can_be_tried_again(tmp_path):
    with mjsim.Session(WORLD, drivers=drivers(until=0.5), record=tmp_path / "run.mcap") as session:
        assert session.wait(timeout=PATIENCE) == "failed"
        watcher = session.watch()
        assert watcher.next().time == pytest.approx(0.48)
        with pytest.raises(mjsim.ModuleFault, match=r"navigator Circle of robot 'scout' at 0\.52 s raised Assert"):
            watcher.next()
        with pytest.raises(mjsim.ModuleFault):
            session.result()
        recording = mjsim.read_recording(tmp_path / "run.mcap")
        assert recording.robots["scout"].events[-1].kind == "fault"
        session.restart()
        assert session.wait(timeout=PATIENCE) == "failed"


def test_a_run_without_a_tick_is_a_failure_in_one_line():
    with (
        mjsim.Session(WORLD, seconds=0.01) as session,
        pytest.raises(mjsim.UsageError, match=r"seconds is 0\.01; a run has at least one tick of 0\.04 s"),
    ):
        session.result()


@pytest.mark.parametrize(
    "busy_with", ["nothing", "running", "standing", "waiting for the clock", "having ended", "having failed"]
)
def test_closing_ends_the_run_and_its_thread_whatever_it_does(busy_with):
    until, seconds = (0.1 if busy_with == "having failed" else np.inf), (0.2 if busy_with == "having ended" else 1e4)
    session = mjsim.Session(WORLD, seconds=seconds, drivers=drivers(until))
    if busy_with != "nothing":
        session.start(paused=busy_with == "standing")
        session.watch().next(PATIENCE)
    if busy_with == "waiting for the clock":
        session.speed = 1e-3
    if busy_with.startswith("having"):
        session.wait(timeout=PATIENCE)
    session.close()
    session.close()
    assert not any(thread.name == "mjsim-session" for thread in threading.enumerate())


def test_with_a_speed_a_tick_comes_when_the_clock_says_so(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: clock[0])
    pace = Pace(2.0)
    assert pace.left(1.0) == 0.0
    assert pace.left(1.4) == pytest.approx(0.2)
    clock[0] += 0.3
    assert pace.left(1.4) == 0.0
    # It catches up with what it is late by, unless that is much.
    assert pace.left(1.7) == pytest.approx(0.05)
    clock[0] += 10.0 + MAX_DELAY
    assert pace.left(1.7) == 0.0
    assert pace.left(1.9) == pytest.approx(0.1)
    pace.forget()
    assert pace.left(50.0) == 0.0
    assert Pace(None).left(1e6) == 0.0


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan")])
def test_a_speed_that_cannot_be_is_refused(session, speed):
    with pytest.raises(mjsim.UsageError, match=r"speed is .*; it must be above 0, or None for as fast as possible"):
        session.speed = speed


def test_who_drives_by_hand_takes_the_place_of_the_navigator_for_a_while():
    session = paused()
    session.drive("scout", mjsim.Command(-0.2), hold=0.1)
    wanted = []
    for _ in range(6):
        session.tick()
        session.wait("paused", timeout=PATIENCE)
        wanted.append(session.newest.orders["scout"].wanted.forward)
    # From 0.04 s to 0.14 s; then the navigator again.
    assert wanted == [-0.2, -0.2, -0.2, 0.3, 0.3, 0.3]
    with pytest.raises(mjsim.UsageError, match="no robot 'scut' to drive in this world; did you mean 'scout'"):
        session.drive("scut", None)
    session.close()


def test_a_manual_command_ends_with_none_and_must_be_finite():
    helm = Helm(["scout"])
    helm.take("scout", mjsim.Command(1.0), hold=5.0)
    assert helm.command("scout", 3.0) == mjsim.Command(1.0)
    assert helm.command("scout", 8.0) == mjsim.Command(1.0)
    helm.take("scout", None, hold=0.0)
    assert helm.command("scout", 8.0) is None
    with pytest.raises(mjsim.UsageError, match="its numbers must be finite"):
        helm.take("scout", mjsim.Command(np.nan), hold=1.0)


def test_avoidance_stays_active_during_manual_driving():
    world = mjsim.parse_world(ROOM.replace("at: [0, 0]", "at: [1.6, 0]"))
    with mjsim.Session(world, drivers=drivers(), seconds=1.0) as session:
        session.drive("scout", mjsim.Command(0.5), hold=10.0)
        session.result()
        order = session.newest.orders["scout"]
    assert order.wanted == mjsim.Command(0.5)
    assert order.command.forward < 0.2


def test_requests_to_a_closed_session_are_refused(session):
    session.close()
    session.restart()
    assert session.state == "ended"
    with pytest.raises(mjsim.UsageError, match="the session is not running; start it first"):
        session.set_noise("robots.scout.odometry.scale", 1.1)


@pytest.mark.slow
def test_the_page_of_sessions_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = (Path(__file__).parents[2] / "docs" / "session.md").read_text(encoding="utf-8")
    names = {}
    for code in re.findall("```python\n(.*?)```", page, re.DOTALL):
        exec(code, names)
    first, count, *kept, address = capsys.readouterr().out.splitlines()
    events = mjsim.parse_world("\n".join(kept)).run.events
    assert [type(event).__name__ for event in events] == ["MoveEvent", "ShoveEvent", "RemoveEvent"]
    assert "Pose(x=" in first
    assert count == "500 ticks"
    assert address.startswith("watch it at http://127.0.0.1:")


def test_a_restart_keeps_what_was_recorded_and_writes_the_next_free_file(tmp_path: Path):
    path = tmp_path / "run.mcap"
    (tmp_path / "run-2.mcap").write_bytes(b"precious")
    with mjsim.Session(WORLD, drivers=drivers(), record=path, seconds=0.4) as session:
        session.result()
        assert session.record == path
        for seed, name in ((1, "run-3.mcap"), (9, "run-4.mcap")):
            session.restart(seed=seed)
            session.result()
            assert session.record == tmp_path / name
    assert [mjsim.read_recording(tmp_path / name).seed for name in ("run.mcap", "run-3.mcap", "run-4.mcap")] == [
        1,
        1,
        9,
    ]
    assert (tmp_path / "run-2.mcap").read_bytes() == b"precious"


def test_a_session_over_an_existing_file_is_refused_when_it_is_made_and_two_cannot_write_one(tmp_path: Path):
    path = tmp_path / "run.mcap"
    with mjsim.Session(WORLD, drivers=drivers(), record=path, seconds=0.4) as session:
        with pytest.raises(mjsim.UsageError, match=r"(exists|is being written); "):
            mjsim.Session(WORLD, drivers=drivers(), record=path)
        with pytest.raises(mjsim.UsageError, match="is being written"):
            mjsim.Session(WORLD, drivers=drivers(), record=path, overwrite=True)
        session.result()
    with pytest.raises(mjsim.UsageError, match="exists"):
        mjsim.Session(WORLD, drivers=drivers(), record=path)
    mjsim.Session(WORLD, drivers=drivers(), record=path, overwrite=True).close()
    assert mjsim.read_recording(path).time[0] == 0.0


def test_waiting_for_a_state_that_there_is_not_is_refused():
    with (
        mjsim.Session(WORLD, seconds=0.2) as session,
        pytest.raises(mjsim.UsageError, match="no state 'pausd'; did you mean 'paused'"),
    ):
        session.wait("pausd")  # type: ignore[arg-type]
