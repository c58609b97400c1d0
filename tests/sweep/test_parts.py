"""What a sweep keeps and draws, and what its processes reset, without starting one."""

import importlib.util
import json
import os
import random
import sys
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool

import cv2
import numpy as np
import pytest
from scipy import stats

from mjsim.errors import MjsimError, PhysicsFault, UsageError
from mjsim.modules import INSTALLED
from mjsim.plan import GROUPS
from mjsim.sweep import SweepPlan, pool, worker
from mjsim.sweep.bench import KeptSimulation, own_modules, seed_the_rest
from mjsim.sweep.plan import Job
from mjsim.sweep.plots import error_plot, nees_plot, plots, settings_plot
from mjsim.sweep.pool import run_on_processes, usable_cores
from mjsim.sweep.results import write_results
from mjsim.sweep.store import Store
from mjsim.sweep.sweep import run_plan, sweep
from mjsim.sweep.worker import empty_outcome
from mjsim.world import parse_world

TURN = "robots.scout.odometry.noise.turn"
PLAN = SweepPlan(seeds=(4, 7), settings={TURN: (0.01, 0.04), "run.seconds": (5,)})
ROOM = """mjsim: 1
name: room
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
robots: [{name: scout, at: [1, 1], odometry: {noise: {turn: 0.02}}}]
run:
  seconds: 0.08
  drivers: {scout: {estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}, navigator: {use: NAVIGATOR}}}
"""
STAND = "mjsim.algorithms.constant:ConstantCommand"


def job(case=0, seed=4):
    return Job(case=case, seed=seed, settings=(), seconds=None)


def rows(values):
    return [
        {"case": case, "seed": seed, "robot": "scout", TURN: turn, "run.seconds": 5, "position_error_m.rmse": error,
         "odometry_error_m.rmse": 2 * error, "error": None}
        for case, (turn, errors) in enumerate(zip((0.01, 0.04), values, strict=True))
        for seed, error in zip((4, 7), errors, strict=False)
    ]  # fmt: skip


def series(scale, count=5):
    return {
        "time": [0.1 * k for k in range(count)], "position_error_m": [scale * k for k in range(count)],
        "odometry_error_m": [3 * scale * k for k in range(count)], "nees": [None, *[scale] * (count - 1)],
    }  # fmt: skip


def lines(axes):
    return {line.get_label(): np.column_stack(line.get_data()) for line in axes.lines}


def test_runs_of_each_value_are_dots_beside_their_mean_and_interval():
    above, below = settings_plot(PLAN, rows([(0.2, 0.4), (0.6,)])).axes
    for axes, factor in ((above, 1.0), (below, 2.0)):
        dots = [np.column_stack(line.get_data()) for line in axes.lines if line.get_alpha() == 0.35]
        np.testing.assert_allclose(dots[0], [[-0.05, 0.2 * factor], [0.05, 0.4 * factor]])
        np.testing.assert_allclose(dots[1], [[1.0, 0.6 * factor]])
        (bars,) = axes.containers
        np.testing.assert_allclose(
            np.column_stack(bars.lines[0].get_data()), [[0.0, 0.3 * factor], [1.0, 0.6 * factor]]
        )
        half = stats.t.ppf(0.975, 1) * stats.sem([0.2 * factor, 0.4 * factor])
        spans = [path[:, 1].tolist() for path in bars.lines[2][0].get_segments()]
        # An error is not negative; errorbar takes distances from the mean.
        assert spans[0] == pytest.approx([0.0, 0.3 * factor + half])
        assert spans[1] == pytest.approx([0.6 * factor, 0.6 * factor])
        assert bars.lines[0].get_linestyle() == "-"
        assert axes.get_ylim()[0] == 0.0
        assert axes.get_ylabel() == "position error, rmse [m]"
    assert above.get_title() == "the estimate of each run, means and 95 % intervals (2 runs a case)"
    assert (below.get_title(), below.get_xlabel()) == ("Odometry alone", TURN)
    assert [tick.get_text() for tick in below.get_xticklabels()] == ["0.01", "0.04"]
    assert below.get_xlim() == pytest.approx((-0.6, 1.6))
    assert [each.get_text() for each in below.get_legend().get_texts()] == ["run.seconds 5"]


def test_values_that_are_no_numbers_are_not_joined_and_modules_go_by_their_class():
    key, more = "run.drivers.scout.estimator", {"use": "mjsim.algorithms.ekf_slam:EkfSlam", "gate": 3}
    plan = SweepPlan(seeds=(1,), settings={key: ("a.py:Own", more), "run.speed": (1, 2)})
    given = [
        {"robot": "scout", key: use, "run.speed": speed, "position_error_m.rmse": 0.1 * speed,
         "odometry_error_m.rmse": 1.0}
        for use in plan.settings[key]
        for speed in (1, 2)
    ]  # fmt: skip
    above, below = settings_plot(plan, given).axes
    assert [tick.get_text() for tick in below.get_xticklabels()] == ["Own", "EkfSlam, gate=3"]
    assert [each.get_text() for each in below.get_legend().get_texts()] == ["run.speed 1", "run.speed 2"]
    assert [bars.lines[0].get_linestyle() for bars in above.containers] == ["None", "None"]
    # Two lanes stand beside each place.
    assert [bars.lines[0].get_xdata()[0] for bars in above.containers] == pytest.approx([-0.175, 0.175])
    assert [bars.lines[0].get_color() for bars in above.containers] == list(GROUPS[:2])
    assert "(1 run a case)" in above.get_title()
    alone = SweepPlan(seeds=(1, 2), settings={})
    above, below = settings_plot(alone, [{"position_error_m.rmse": 0.1, "odometry_error_m.rmse": 0.2}]).axes
    assert [tick.get_text() for tick in below.get_xticklabels()] == ["all runs"]
    assert below.get_legend() is None
    assert "(2 runs)" in above.get_title()


def test_errors_over_time_are_medians_with_the_range_of_most_runs():
    runs = [series(float(k), 5 + k) for k in range(1, 4)]
    (axes,) = error_plot(PLAN, [runs, []]).axes
    drawn = lines(axes)
    label = "noise.turn 0.01, run.seconds 5"
    # Two runs are left after 0.5 s, one after 0.6 s.
    np.testing.assert_allclose(drawn[label], [*([0.1 * k, 2.0 * k] for k in range(6)), [0.6, 15.0], [0.7, 21.0]])
    np.testing.assert_allclose(drawn["odometry"][:, 1], 3.0 * drawn[label][:, 1])
    shade = axes.collections[0].get_paths()[0].vertices
    assert shade[shade[:, 0] == 0.5][:, 1].max() == pytest.approx(5 * 2.8)
    assert shade[shade[:, 0] == 0.5][:, 1].min() == pytest.approx(5 * 1.2)
    assert axes.get_title() == "position error, median of the runs, 80 % of them in the shade (2 runs a case)"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [s]", "position error [m]")
    assert axes.get_xlim() == pytest.approx((0.0, 0.7))
    assert axes.get_ylim()[0] == 0.0
    (axes,) = error_plot(PLAN, [runs, runs]).axes
    assert "odometry" not in lines(axes)
    many = SweepPlan(seeds=(1,), settings={"run.speed": (1, 2, 3, 4)})
    (axes,) = error_plot(many, [runs] * 4).axes
    assert not axes.collections
    assert "shade" not in axes.get_title()
    (axes,) = error_plot(SweepPlan(seeds=(1,), settings={}), [runs]).axes
    assert "estimate" in lines(axes)
    assert axes.get_title().endswith("(1 run)")


def test_nees_over_time_is_the_mean_of_the_runs_that_have_one():
    (axes,) = nees_plot(PLAN, [[series(2.0), series(6.0), series(4.0)], [series(3.0)]]).axes
    drawn = lines(axes)
    first = drawn["noise.turn 0.01, run.seconds 5"]
    np.testing.assert_allclose(first, [[0.1 * k, 4.0] for k in range(1, 5)])
    assert drawn["noise.turn 0.04, run.seconds 5"][:, 1].tolist() == [3.0] * 4
    low, high = stats.chi2.ppf((0.025, 0.975), 9) / 3
    (band,) = axes.patches
    assert (band.get_y(), band.get_y() + band.get_height()) == pytest.approx((low, high))
    assert f"95 % band, {low:.2f} to {high:.2f}" in [each.get_text() for each in axes.get_legend().get_texts()]
    assert any(list(line.get_ydata()) == [3, 3] for line in axes.lines)
    assert (axes.get_ylabel(), axes.get_yscale()) == ("NEES of x, y, heading", "symlog")
    assert axes.get_yticks().tolist() == [0, 1, 3, 10]
    assert axes.get_title() == "consistency, the NEES averaged over the runs (2 runs a case)"
    assert axes.get_xlim() == pytest.approx((0.1, 0.4))
    (axes,) = nees_plot(SweepPlan(seeds=(1,), settings={}), [[series(2.0)]]).axes
    assert "mean of all runs" in lines(axes)


def test_a_robot_without_a_run_has_no_plots():
    assert plots(PLAN, [{"robot": "scout", "position_error_m.rmse": None}], [], ["scout", "other"], ("png",)) == {}


def outcome(case, seed, error):
    told = empty_outcome(job(case, seed), error=error)
    figures = {"position_error_m": {"rmse": 0.1 * seed}, "odometry_error_m": {"rmse": 0.5}}
    return told if error else told | {"robots": {"scout": figures}, "run": {"sim_seconds": 5.0}}


def test_results_are_tables_a_summary_and_the_failed_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)  # pyarrow takes seconds to import
    (tmp_path / "table.parquet").write_text("of an earlier sweep")
    outcomes = [
        outcome(case, seed, "it fell" if (case, seed) == (1, 4) else None) for case in (0, 1) for seed in (4, 7)
    ]
    found = write_results(Store(tmp_path, keep=False), PLAN, outcomes, ["other"], ("png",))
    assert found.failed == {"001-seed0004": "it fell"}
    assert json.loads((tmp_path / "summary.json").read_text()) == json.loads(json.dumps(found.summary))
    assert (tmp_path / "table.csv").exists()
    assert not (tmp_path / "table.parquet").exists()
    assert len((tmp_path / "clock.csv").read_text().splitlines()) == 5
    assert (found.folder, (tmp_path / "plots").exists()) == (tmp_path, False)


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
    with pytest.raises(UsageError, match="contains files that are not of a sweep"):
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
    monkeypatch.setattr(worker, "settle", lambda: None)  # it limits the threads of the whole process
    monkeypatch.setattr(worker, "bench", lambda: kept)
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

    monkeypatch.setattr(worker, "run", falls)
    lost = worker.run_job(room, job(seed=2), record=tmp_path / "r.mcap", pictures=False)
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
        1: {"seed": 1}, 2: {"seed": 2}, 3: worker.died(jobs[2], 3), 4: {"seed": 4},
    }  # fmt: skip
    assert [workers.asked.count(seed) for seed in range(1, 5)] == [1, 2, 3, 1]
    assert workers.alive == 0


def test_outcomes_that_are_there_are_not_run_again_and_deaths_are_not_kept(tmp_path, monkeypatch):
    world, begun, told = parse_world(ROOM.replace("NAVIGATOR", STAND)), [], []

    def coming(world_file, jobs, store, *, workers):
        begun.extend(one.seed for one in jobs)
        assert (world_file.name, workers) == ("world.yaml", 3)
        for one in jobs:
            yield one, worker.died(one, 3) if one.seed == 2 else worker.empty_outcome(one, error="it fell")

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
