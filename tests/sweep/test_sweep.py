"""Sweeps that are run: the same table, whatever happens to the processes on the way."""

import csv
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.cli import main
from mjsim.world import with_settings
from tests.children import completed
from tests.cli.shell import typed

pytestmark = pytest.mark.slow  # Every sweep starts processes.

ROOM = """
mjsim: 1
name: room
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: a, at: [5.9, 1]}, {name: b, at: [0.1, 3]}, {name: c, at: [3, 3.9]}]
robots:
  - name: scout
    at: [1, 1]
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors: [{beacons: ring, range: [0.3, 8], fov_deg: 240, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}]
run:
  seconds: 1
  drivers: {scout: {estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}, navigator: {use: "stroll.py:Stroll"}}}
"""
STROLL = '''
"""Drives in an arc. For the tests: some of all runs may kill their process, or the one that started that."""
import os, signal
import pace
from mjsim import Command

class Stroll:
    def start(self, robot, map, rng):
        log, _, kill = os.environ.get("STROLL", "").partition("|")
        if log:
            with open(log, "a") as file:
                file.write(f"{os.getpid()}\\n")
                count = file.tell()
            with open(log) as file:
                count = len(file.readlines())
            for whom, at in (each.split("@") for each in kill.split()):
                if count == int(at):
                    os.kill(os.getpid() if whom == "worker" else os.getppid(), signal.SIGKILL)

    def command(self, seen, belief):
        return Command(pace.SPEED, 0.0, 0.4)
'''
TRAP = """
from mjsim import Command
class Trap:
    def start(self, robot, map, rng): self.ahead = rng.random() < 0.5
    def command(self, seen, belief): return Command() if seen.time < 0.5 or not self.ahead else fall()
def fall(): raise SystemExit("over the edge")
"""
TURN = "robots.scout.odometry.noise.turn"
SETTINGS = {TURN: (0.01, 0.04)}
ARGUMENTS = ("--seeds", "0:3", "--set", f"{TURN}=0.01,0.04", "--workers", "1")


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A world file with a module of the user's."""
    folder = tmp_path_factory.mktemp("home")
    (folder / "room.yaml").write_text(ROOM)
    (folder / "stroll.py").write_text(STROLL)
    (folder / "pace.py").write_text("SPEED = 0.4\n")
    return folder / "room.yaml"


@pytest.fixture(scope="module")
def undisturbed(room):
    """A sweep to which nothing happened."""
    return mjsim.sweep(room, seeds=range(3), settings=SETTINGS, folder=room.parent / "undisturbed", workers=1)


def table(folder):
    return (folder / "table.parquet").read_bytes()


def command(room, folder, *more):
    return ["sweep", str(room), "-o", str(folder), *ARGUMENTS, *more]


def test_a_row_is_what_the_same_run_gives_by_itself(room, undisturbed):
    world = with_settings(mjsim.load_world(room), [f"{TURN}=0.04"])
    with mjsim.Simulation(world, seed=2) as sim:
        alone = mjsim.statistics(mjsim.run(sim))["scout"]
    (row,) = (row for row in undisturbed.rows if row[TURN] == 0.04 and row["seed"] == 2)
    assert row["position_error_m.rmse"] == alone["position_error_m"]["rmse"]
    assert row["nees.mean"] == alone["nees"]["mean"]
    assert len(undisturbed.rows) == 6
    assert undisturbed.failed == {}


def test_a_sweep_of_which_a_worker_is_killed_goes_on_and_after_its_own_end_too_where_it_was_and_leaves_no_process(
    room, undisturbed, tmp_path, monkeypatch, capsys
):
    out, log = tmp_path / "out", tmp_path / "log"
    line = [sys.executable, "-m", "mjsim.cli", *command(room, out)]
    killed = completed(line, check=False, env={**os.environ, "STROLL": f"{log}|worker@2 parent@4"})
    assert killed.returncode == -signal.SIGKILL
    assert len(list((out / "runs").glob("*.json"))) == 2
    assert not (out / "table.parquet").exists()
    wait_for(lambda: not any(map(is_alive, set(log.read_text().split()))))
    monkeypatch.setenv("STROLL", str(log))
    code, said, progress = typed(*command(room, out), capsys=capsys)
    assert code == 0
    assert len(log.read_text().split()) == 4 + 4  # the second run began twice, and the third too
    assert table(out) == table(undisturbed.folder)
    assert "scout, 3 of 3 runs" in said
    assert "6 of 6 runs" in progress
    assert sorted(path.suffix for path in (out / "runs").iterdir()) == [".json"] * 6


def test_a_dask_cluster_of_which_one_worker_is_killed_gives_the_same_table(room, undisturbed, tmp_path, capsys):
    cluster = pytest.importorskip("distributed").LocalCluster
    stroll = {"STROLL": f"{tmp_path / 'log'}|worker@3"}
    with cluster(n_workers=2, threads_per_worker=1, dashboard_address=None, local_directory=tmp_path, env=stroll) as it:
        words = command(room, tmp_path / "out", "--dask", it.scheduler_address, "--keep")
        assert typed(*words, capsys=capsys)[0] == 0
    # One run was killed; those that its worker had not yet handed on are lost with it.
    assert len((tmp_path / "log").read_text().split()) >= 7
    assert len(set((tmp_path / "log").read_text().split())) >= 2
    assert table(tmp_path / "out") == table(undisturbed.folder)
    recording = mjsim.read_recording(tmp_path / "out" / "runs" / "001-seed0002.mcap")
    assert recording.seed == 2


def test_a_failed_run_is_reported_and_the_others_continue(tmp_path, capsys):
    (tmp_path / "room.yaml").write_text(ROOM.replace("stroll.py:Stroll", "trap.py:Trap"))
    (tmp_path / "trap.py").write_text(TRAP)
    with pytest.raises(SystemExit) as ended:
        main(["sweep", str(tmp_path / "room.yaml"), "--seeds", "0:6", "-o", str(tmp_path / "out"), "--workers", "1"])
    assert ended.value.code == 1
    failing = [seed for seed in range(6) if np.random.default_rng([seed, *b"scout/navigator/module"]).random() < 0.5]
    with (tmp_path / "out" / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["seed"]) for row in rows if row["error"]] == failing
    assert all((row["bumps"] == "") == bool(row["error"]) for row in rows)
    told = capsys.readouterr()
    assert f"scout, {6 - len(failing)} of 6 runs" in told.out
    line = "navigator Trap of robot 'scout' at 0.52 s raised SystemExit: over the edge (trap.py:6)"
    assert f"mjsim: run 000-seed{failing[0]:04d} failed: {line}\n" in told.err
    # What failed would fail again: nothing is left to do.
    before = table(tmp_path / "out")
    assert set(mjsim.sweep(tmp_path / "room.yaml", seeds=range(6), folder=tmp_path / "out").failed) == {
        f"000-seed{seed:04d}" for seed in failing
    }
    assert table(tmp_path / "out") == before


def wait_for(condition):
    ends = time.monotonic() + 300.0
    while not condition():
        assert time.monotonic() < ends
        time.sleep(0.05)


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
