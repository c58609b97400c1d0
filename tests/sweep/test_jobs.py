"""What a sweep keeps, what its processes reset, and its jobs, without starting a process."""

import json
import math
import os
import random
import sys
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool

import cv2
import numpy as np
import pytest

from mjsim.errors import MjsimError, PhysicsFault, UsageError
from mjsim.modules import INSTALLED
from mjsim.sweep import SweepPlan, pool, sweep_worker
from mjsim.sweep.bench import KeptSimulation, own_modules, seed_the_rest
from mjsim.sweep.pool import run_on_processes, usable_cores
from mjsim.sweep.store import Store
from mjsim.sweep.sweep import run_plan, sweep
from mjsim.sweep.sweep_plan import Job
from mjsim.world import parse_world
from tests.children import child
from tests.sweep.test_parts import PLAN, ROOM, STAND, TURN, job


def test_a_store_keeps_outcomes_and_recordings_where_they_are_wanted(tmp_path):
    kept, thrown = Store(tmp_path, keep=True), Store(tmp_path, keep=False)
    kept.put(job(), {"case": 0, "a": [1.5]})
    assert kept.outcome(job()) == {"case": 0, "a": [1.5]}
    assert kept.outcome(job(seed=5)) is None
    (tmp_path / "runs" / "000-seed0006.json").write_text("{half")
    assert kept.outcome(job(seed=6)) is None
    for store, seed, left in ((kept, 1, ["000-seed0001.mcap"]), (thrown, 2, [])):
        with store.recording(job(seed=seed)) as path:
            assert path.parent == tmp_path / "runs"
            assert str(os.getpid()) in path.name
            path.write_bytes(b"run")
        assert [each.name for each in (tmp_path / "runs").glob(f"*{seed}.mcap")] == left
    with pytest.raises(ZeroDivisionError), kept.recording(job(seed=3)) as path:  # noqa: PT012
        path.write_bytes(b"half")
        raise ZeroDivisionError
    assert not list((tmp_path / "runs").glob("*.part"))
    assert not list((tmp_path / "runs").glob("*3.mcap"))


class Files:
    """Stands for a bundle of files."""

    main = "room.yaml"

    def __init__(self, **digests):
        self._digests = digests

    def digests(self):
        return self._digests

    def unpack(self, folder):
        return folder / self.main


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"plan": SweepPlan(seeds=(4,), settings=PLAN.settings)}, r"seeds was \[4, 7\] and is \[4\]"),
        ({"plan": SweepPlan(seeds=(4, 7), settings=PLAN.settings, seconds=3.0)}, "seconds was not given and is 3"),
        ({"plan": SweepPlan(seeds=(4, 7), settings=PLAN.settings, keep=True)}, "keep was false and is true"),
        ({"files": Files(a="1", b="3")}, "b has changed"),
        ({"files": Files(a="1", b="2", c="3")}, "c has changed"),
        ({"plan": SweepPlan(seeds=tuple(range(99)), settings=PLAN.settings)}, r"is \[0, .{36} \.\.\. .{16}; name"),
    ],
)
def test_a_folder_holds_one_sweep(tmp_path, change, said):
    store, files = Store(tmp_path, keep=False), Files(a="1", b="2")
    store.open(PLAN, files)
    (tmp_path / "runs" / "x.part").write_text("left")
    assert store.open(PLAN, files) == tmp_path / "world" / "room.yaml"
    assert not list((tmp_path / "runs").iterdir())
    with pytest.raises(UsageError, match=said):
        store.open(change.get("plan", PLAN), change.get("files", files))


def test_a_folder_with_other_versions_or_other_files_is_refused(tmp_path):
    store = Store(tmp_path / "sweep", keep=False)
    store.open(PLAN, Files())
    told = json.loads((tmp_path / "sweep" / "sweep.json").read_text())
    told["versions"]["numpy"] = "0.1"
    (tmp_path / "sweep" / "sweep.json").write_text(json.dumps(told))
    with pytest.raises(UsageError, match=rf'numpy was "0\.1" and is "{np.__version__}"'):
        store.open(PLAN, Files())
    (tmp_path / "sweep" / "sweep.json").write_text("{")
    with pytest.raises(UsageError, match="is damaged"):
        store.open(PLAN, Files())
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    with pytest.raises(UsageError, match="contains files that do not belong to a sweep"):
        Store(tmp_path / "mine", keep=False).open(PLAN, Files())


def test_a_folder_is_held_by_one_sweep_at_a_time(tmp_path):
    store = Store(tmp_path / "new", keep=False)
    with store.held(), pytest.raises(UsageError, match="another sweep is running"), store.held():
        pass
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="file"), Store(tmp_path / "file" / "in", keep=False).held():
        pass


def test_every_run_begins_with_the_same_chance():
    def drawn(seed):
        seed_the_rest(seed)
        image = np.zeros((4, 4), np.uint8)
        cv2.randu(image, 0, 255)
        return random.random(), np.random.random(), image.tolist()  # noqa: NPY002

    assert drawn(5) == drawn(5)
    assert all(a != b for a, b in zip(drawn(5), drawn(6), strict=True))
    assert len(drawn(2**32 + 5)) == 3  # more than these generators take


def test_modules_of_a_user_are_unloaded_after_each_run(tmp_path):
    (tmp_path / "own_stroll.py").write_text("A = 1\n")
    (tmp_path / INSTALLED).mkdir()
    (tmp_path / INSTALLED / "own_library.py").write_text("B = 2\n")
    path, known = list(sys.path), set(sys.modules)
    with pytest.raises(ZeroDivisionError), own_modules(tmp_path):  # noqa: PT012
        import own_library  # type: ignore[import-not-found]

        assert own_library.B == 2
        assert "own_library" in sys.modules
        raise ZeroDivisionError
    assert sys.path == path
    assert "own_library" not in set(sys.modules) - known


@pytest.fixture
def room(tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM.replace("NAVIGATOR", STAND))
    return tmp_path / "room.yaml"


def test_a_simulation_serves_all_seeds_of_a_case_and_none_after_a_fault(room):
    kept = KeptSimulation()
    faster = Job(case=1, seed=4, settings=(f"{TURN}=0.04",), seconds=None)
    with kept.simulation(room, job()) as first:
        assert first.seed == 4
    with kept.simulation(room, job(seed=9)) as again:
        assert again is first
        assert again.seed == 9
    with kept.simulation(room, faster) as other:
        assert other is not first
        assert other.world.robots[0].odometry.noise.turn == 0.04
    with pytest.raises(ZeroDivisionError), kept.simulation(room, faster) as same:  # noqa: PT012
        assert same is other
        raise ZeroDivisionError
    with kept.simulation(room, faster) as new:
        assert new is not other
    kept.clear()
    kept.clear()


def test_cores_are_those_that_this_process_may_use(monkeypatch):
    assert usable_cores() == len(os.sched_getaffinity(0))
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 7)
    assert usable_cores() == 7


def test_without_jobs_no_process_is_started(tmp_path):
    before = dict(os.environ)
    assert list(run_on_processes(tmp_path / "none.yaml", [], Store(tmp_path, keep=False), workers=2)) == []
    assert dict(os.environ) == before


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"workers": 0}, "workers is 0; it must be at least 1"),
        ({"formats": ("gif",)}, "no format 'gif'"),
        ({"robot": "scuot"}, "no robot 'scuot' in this world; did you mean 'scout'"),
        ({"seconds": 0.001}, r"seconds is 0\.001; a run has at least one tick of 0\.04 s"),
        ({"seconds": math.nan}, r"seconds is nan; a run has at least one tick of 0\.04 s"),
        ({"seconds": math.inf}, r"seconds is inf; .* and at most 1e\+08 s"),
        ({"settings": {TURN: "0.1,0.2"}}, "the values of .* are the text '0.1,0.2'; give them as a list"),
    ],
)
def test_a_sweep_that_cannot_be_is_refused_before_a_process_is_started(tmp_path, change, said):
    world = parse_world(ROOM.replace("NAVIGATOR", STAND))
    with pytest.raises(UsageError, match=said):
        sweep(world, seeds=[1], folder=tmp_path / "out", **change)
    assert not (tmp_path / "out").exists()


def test_a_world_without_robots_is_no_sweep(tmp_path):
    with pytest.raises(UsageError, match="no robots in world"):
        run_plan(parse_world("mjsim: 1\nname: empty\n"), SweepPlan(seeds=(1,), settings={}), tmp_path / "out")


def test_a_job_gives_figures_series_and_times_and_a_fault_is_an_outcome(room, tmp_path, monkeypatch):
    kept = KeptSimulation()
    monkeypatch.setattr(sweep_worker, "settle", lambda: None)  # it limits the threads of the whole process
    monkeypatch.setattr(sweep_worker, "bench", lambda: kept)
    told = pool._work(room, job(case=3, seed=9), Store(tmp_path, keep=False))
    assert (told["case"], told["seed"], told["error"]) == (3, 9, None)
    assert told["robots"]["scout"]["odometry_error_m"]["rmse"] >= 0.0
    assert told["series"]["scout"]["estimated"] is True
    assert len(told["series"]["scout"]["time"]) == 2
    assert 0.0 < told["clock"]["wall_seconds"] < told["clock"]["total_seconds"]
    assert not {"wall_seconds", "real_time_factor", "milliseconds"} & set(told["run"])
    assert not list((tmp_path / "runs").glob("*")) if (tmp_path / "runs").exists() else True

    def falls(*_, **__):
        raise PhysicsFault("it fell at 0.04 s")

    monkeypatch.setattr(sweep_worker, "run", falls)
    lost = sweep_worker.run_job(room, job(seed=2), record=tmp_path / "r.mcap", pictures=False)
    assert (lost["error"], lost["robots"]) == ("it fell at 0.04 s", {})
    assert lost["clock"]["total_seconds"] > 0.0
    kept.clear()


def test_variables_of_the_environment_are_as_before(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("LP_NUM_THREADS", raising=False)
    with pool._environment({"OMP_NUM_THREADS": "1", "LP_NUM_THREADS": "1"}):
        assert (os.environ["OMP_NUM_THREADS"], os.environ["LP_NUM_THREADS"]) == ("1", "1")
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "LP_NUM_THREADS" not in os.environ


class Workers:
    """Stands for processes: the first attempts at a job die."""

    def __init__(self, deaths):
        self.deaths, self.alive, self.most, self.asked = deaths, 0, 0, []

    def __call__(self):
        return self

    def __enter__(self):
        self.alive += 1
        self.most = max(self.most, self.alive)
        return self

    def __exit__(self, *_):
        self.alive -= 1

    def close(self):
        pass

    def submit(self, world_file, one, store):
        self.asked.append(one.seed)
        future = Future()
        if self.asked.count(one.seed) <= self.deaths.get(one.seed, 0):
            future.set_exception(BrokenProcessPool())
        else:
            future.set_result({"seed": one.seed})
        return future


def test_a_job_whose_process_dies_is_tried_three_times(tmp_path, monkeypatch):
    workers = Workers({2: 1, 3: 9})
    monkeypatch.setattr(pool, "_Worker", workers)
    jobs = [job(seed=seed) for seed in range(1, 5)]
    found = dict(run_on_processes(tmp_path, jobs, Store(tmp_path, keep=False), workers=2))
    assert {one.seed: outcome for one, outcome in found.items()} == {
        1: {"seed": 1}, 2: {"seed": 2}, 3: sweep_worker.died(jobs[2], 3), 4: {"seed": 4},
    }  # fmt: skip
    assert [workers.asked.count(seed) for seed in range(1, 5)] == [1, 2, 3, 1]
    assert workers.alive == 0


@pytest.mark.slow
def test_outcomes_that_are_there_are_not_run_again_and_deaths_are_not_kept(tmp_path, monkeypatch):
    world, begun, told = parse_world(ROOM.replace("NAVIGATOR", STAND)), [], []

    def coming(world_file, jobs, store, *, workers):
        begun.extend(one.seed for one in jobs)
        assert (world_file.name, workers) == ("world.yaml", 3)
        for one in jobs:
            yield one, sweep_worker.died(one, 3) if one.seed == 2 else sweep_worker.empty_outcome(one, error="it fell")

    monkeypatch.setattr(sys.modules[run_plan.__module__], "run_on_processes", coming)
    plan = SweepPlan(seeds=(1, 2, 3), settings={})
    for _ in range(2):
        found = run_plan(world, plan, tmp_path / "out", workers=3, progress=told.append)
    assert begun == [1, 2, 3, 2]
    assert told == [0, 1, 2, 3, 2, 3]
    assert list(found.failed) == ["000-seed0001", "000-seed0002", "000-seed0003"]


def test_a_module_that_is_not_there_is_told_before_a_process_is_started(tmp_path):
    world = parse_world(ROOM.replace("NAVIGATOR", "mjsim.algorithms.crab:Crap"))
    with pytest.raises(MjsimError, match="Crap"):
        sweep(world, seeds=[1], folder=tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_ctrl_c_while_a_worker_starts_ends_the_parent_alone_and_after_the_start(tmp_path):
    path = tmp_path / "sweeping.py"
    path.write_text("""
import os, signal
from mjsim.sweep.pool import _Worker
if __name__ == "__main__":
    with _Worker() as worker:
        start = worker._executor._spawn_process
        worker._executor._spawn_process = lambda: (start(), os.killpg(0, signal.SIGINT))
        try:
            worker.submit(None, None, None)
        except KeyboardInterrupt:
            print("interrupted")
        print(type(worker.submit(None, None, None).exception(60)).__name__)
""")
    with child([sys.executable, path]) as process:
        assert process.rest() == "interrupted\nAttributeError\n"
        assert process.rest("stderr") == ""
