"""A module's mistake is the same line in replay, session and environment, and for drives and threads."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.cli import main
from mjsim.env.episodes import Episodes
from mjsim.run import replay
from mjsim.world import Modules, Use
from tests.children import completed
from tests.learning import room, task
from tests.modules.faulty import ROOM, TICKS, made, written
from tests.rover import ROVER, TANK, WORLD

MISTAKES = [
    ("sys.exit(3)", r"raised SystemExit: 3 \(bad\.py:\d+\)"),
    (
        "return mjsim.Estimate(ORIGIN, -EYE)",
        r"returned the covariance of the pose with the eigenvalue -1; .* \(bad\.py:\d+\)",
    ),
    (
        "return mjsim.Estimate((0, 0, 0), EYE)",
        r"returned a pose that is a value of type tuple; it must be a Pose \(bad\.py:",
    ),
]
ALONE = mjsim.parse_world(ROOM.replace(', drivers: {scout: {ROLE: {use: "bad.py:Bad"}}}', ""))
LINE = r"estimator Bad of robot 'scout' at 0\.20 s "


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    with mjsim.Simulation(ALONE) as sim:
        return mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=made(good()))}, record=path)


def good() -> str:
    return written("estimator", "return mjsim.Estimate(ORIGIN, EYE)")


def typed(capsys, *words: str) -> tuple[int, list[str]]:
    """Return the exit code, and what stands on stderr beside progress."""
    with pytest.raises(SystemExit) as left:
        main(list(words))
    lines = capsys.readouterr().err.splitlines()
    return left.value.code, [line for line in lines if not re.match("mjsim: (run|replay) ", line)]


@pytest.mark.parametrize(("body", "says"), MISTAKES)
def test_in_a_replay(recording, tmp_path, body, says):
    with pytest.raises(mjsim.ModuleFault, match=LINE + says):
        replay(recording, robot="scout", estimator=made(written("estimator", body)), record=tmp_path / "again.mcap")
    assert len(mjsim.read_recording(tmp_path / "again.mcap").time) == TICKS


def test_in_a_replay_on_the_command_line(recording, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bad.py").write_text(written("estimator", "sys.exit(3)"))
    words = ("replay", str(recording.path), "--robot", "scout", "--estimator", "bad.py:Bad", "-o", "again.mcap")
    code, (line,) = typed(capsys, *words)
    assert code == 1
    assert re.fullmatch(LINE + MISTAKES[0][1], line)
    Path("bad.py").write_text("class Bad: pass\n")
    code, (line,) = typed(capsys, *words, "--overwrite")
    assert code == 1
    assert line.startswith("estimator Bad of robot 'scout' at 0.00 s has no methods start() and update();")


@pytest.mark.parametrize(
    ("body", "says"), [*MISTAKES, ("raise KeyboardInterrupt", r"raised KeyboardInterrupt \(bad\.py:\d+\)")]
)
def test_in_a_session_whose_thread_ctrl_c_does_not_reach(tmp_path, body, says):
    driver = mjsim.Driver(estimator=made(written("estimator", body)))
    with (
        mjsim.Session(ALONE, drivers={"scout": driver}, record=tmp_path / "run.mcap") as session,
        pytest.raises(mjsim.ModuleFault, match=LINE + says),
    ):
        session.result()
    assert len(mjsim.read_recording(tmp_path / "run.mcap").time) == TICKS


@pytest.mark.slow
@pytest.mark.parametrize(("body", "says"), MISTAKES)
def test_in_an_environment(tmp_path, body, says):
    (tmp_path / "bad.py").write_text(written("estimator", body))
    world = room()
    use = Use(use="bad.py:Bad")
    run = world.run.model_copy(update={"drivers": {"scout": Modules(estimator=use)}})
    world = world.model_copy(update={"run": run})
    world._source = mjsim.world.Source(folder=tmp_path)
    episodes = Episodes(task(world=world, observations=("estimate",)))
    episodes.begin(1)
    for _ in range(TICKS - 1):
        episodes.go_on(np.zeros(2, dtype=np.float32))
    with pytest.raises(mjsim.ModuleFault, match=LINE + says):
        episodes.go_on(np.zeros(2, dtype=np.float32))
    episodes.close()


TWIST = "        left, right = speeds\n"
DRIVES = [
    (TANK.replace(TWIST, "        1 / 0\n"), r"raised ZeroDivisionError: division by zero \(tank\.py:\d+\)"),
    (
        TANK.replace(TWIST, "        return 1.0, 2.0\n"),
        r"returned 2 numbers of a twist; they are forward, left, turn \(tank",
    ),
    (
        TANK.replace(TWIST, "        return None\n"),
        r"returned numbers of a twist that are None; they are forward, left, turn",
    ),
    (
        TANK.replace(TWIST, "        return 0.0, float('nan'), 0.0\n"),
        r"returned a twist that is not finite: \[0\.0, nan, 0\.0\]",
    ),
    (
        TANK.replace("half = turn", "return [0.0]; half = turn"),
        r"returned 1 wheel speeds; the wheels are left, right \(tank",
    ),
    (TANK.replace("half = turn", "raise SystemExit(2); half = turn"), r"raised SystemExit: 2 \(tank\.py:\d+\)"),
    (
        TANK.replace('wheels = ("left", "right")', "wheels = 2"),
        r"has wheels that are a value of type int; they must be a",
    ),
    (TANK.replace('wheels = ("left", "right")\n', ""), r"has wheels that are None; they must be a tuple of the names"),
    (
        TANK.replace("def wheels_from", "async def wheels_from"),
        r"has `async def wheels_from_twist`; write `def wheels_from",
    ),
    (
        TANK.replace("self.radius, self.track = radius, track", "1 / 0"),
        r"raised ZeroDivisionError: .* \(tank\.py:\d+\)",
    ),
]


@pytest.mark.parametrize(("tank", "says"), DRIVES)
def test_for_a_drive_of_the_users_own(tmp_path, capsys, monkeypatch, tank, says):
    monkeypatch.chdir(tmp_path)
    Path("rover.xml").write_text(ROVER)
    Path("room.yaml").write_text(WORLD)
    Path("tank.py").write_text(tank)
    code, (line,) = typed(capsys, "run", "room.yaml", "--seconds", "0.4")
    assert code == 1
    assert re.match(r"drive Tank of robot 'rover' at 0\.\d\d s " + says, line), line


def shell(
    folder: Path, body: str, *, start: str = "self.robot = robot", ctrl_c: signal.Handlers = signal.SIG_DFL
) -> subprocess.CompletedProcess:
    """Run a navigator in a process of its own, for a minute unless it ends."""
    (folder / "bad.py").write_text(written("navigator", body, start=start))
    (folder / "room.yaml").write_text(ROOM.replace("ROLE", "navigator"))
    words = [sys.executable, "-m", "mjsim.cli", "run", "room.yaml", "-o", "run.mcap", "--seconds", "60"]
    return completed(words, check=False, cwd=folder, preexec_fn=lambda: signal.signal(signal.SIGINT, ctrl_c))


@pytest.mark.slow
def test_what_a_thread_of_a_module_raises_ends_the_run_even_where_ctrl_c_is_ignored(tmp_path):
    work = "import time\nif seen.time > 5.0: time.sleep(30.0)\n"
    start = "threading.Thread(target=lambda: 1 / 0, name='solver').start()"
    done = shell(tmp_path, work + "return mjsim.Command()", start=start, ctrl_c=signal.SIG_IGN)
    assert done.returncode == 1
    assert re.fullmatch(
        r"thread 'solver' of a module raised ZeroDivisionError: division by zero \(bad\.py:\d+\)",
        done.stderr.splitlines()[-1],
    )
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_thread_that_does_not_end_is_named(tmp_path):
    start = "threading.Thread(target=threading.main_thread().join, name='mapper').start()"
    done = shell(tmp_path, "sys.exit(1)", start=start)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "mjsim: waiting for thread 'mapper' of a module; end it, or make it a daemon"


def test_keyboard_interrupt_means_ctrl_c_whoever_raises_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bad.py").write_text(written("navigator", "raise KeyboardInterrupt"))
    Path("room.yaml").write_text(ROOM.replace("ROLE", "navigator"))
    code, (*_, line) = typed(capsys, "run", "room.yaml", "-o", "run.mcap")
    assert (code, line) == (130, "mjsim: interrupted; anything recorded so far is closed and readable")
    assert len(mjsim.read_recording("run.mcap").time) == TICKS


@pytest.mark.slow
def test_a_module_that_kills_the_process_leaves_what_was_written(tmp_path):
    done = shell(tmp_path, "import os, time\nif seen.time > 2: time.sleep(3.0); os.abort()\nreturn mjsim.Command()")
    assert done.returncode == -signal.SIGABRT
    recording = mjsim.read_recording(tmp_path / "run.mcap")
    assert not recording.whole
    assert recording.time[-1] > 1.0


@pytest.mark.slow
def test_ten_lines_of_gtsam_are_one(tmp_path):
    pytest.importorskip("gtsam", reason="an extra")
    body = """
    import gtsam
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    values.insert(0, gtsam.Pose2())
    values.insert(1, gtsam.Pose2(1, 0, 0))
    noise = gtsam.noiseModel.Isotropic.Sigma(3, 0.1)
    graph.add(gtsam.BetweenFactorPose2(0, 1, gtsam.Pose2(1, 0, 0), noise))
    gtsam.Marginals(graph, values)
    """
    with mjsim.Simulation(ALONE) as sim, pytest.raises(mjsim.ModuleFault) as caught:
        mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=made(written("estimator", body)))})
    line = str(caught.value)
    assert re.match(LINE + r"raised RuntimeError: Indeterminate linear system detected .*\.\.\. \(bad\.py:\d+\)$", line)
    assert line.isprintable()
    assert len(line) < 400
