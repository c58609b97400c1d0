"""Recordings compared: labels from what differs in them, pairs by seed, and the files that are written."""

import itertools
import json
import shutil

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.output import LIST
from mjsim.report import write_comparison
from mjsim.report.labels import file_labels, setting_labels, settings_of
from mjsim.world import with_settings
from tests.cli.shell import typed

RING = """
mjsim: 1
name: ring
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons:
  - {name: a, at: [5.9, 1]}
  - {name: b, at: [0.1, 3]}
  - {name: c, at: [3, 3.9]}
  - {name: d, at: [3, 0.1]}
robots:
  - {name: scout, at: [1, 1], odometry: {noise: {distance: 0.05, turn: 0.1}},
     sensors: [{beacons: ring, range: [0.3, 8], fov_deg: 240, rate_hz: 5, noise: {range: 0.02, bearing_deg: 0.5}}]}
run: {seconds: 8, rate_hz: 10, map: known, drivers: {scout: {
    estimator: {use: "mjsim.algorithms.localization:EkfLocalization"},
    navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.4, turn: 0.4}}}}
"""
WHEELS = RING.replace('    estimator: {use: "mjsim.algorithms.localization:EkfLocalization"},\n', "")


def record(text, path, *, seed=1, seconds=1.0, settings=(), **modules):
    """Return the file of a run."""
    world = with_settings(mjsim.parse_world(text), settings)
    with mjsim.Simulation(world, seed=seed) as sim:
        drivers = {"scout": mjsim.Driver(**modules)} if modules else None
        mjsim.run(sim, seconds=seconds, record=path, drivers=drivers)
    return path


def labels(comparison):
    return [group.label for group in comparison.groups]


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """One run with beacons and one by wheels alone, same seed."""
    folder = tmp_path_factory.mktemp("pair")
    return record(RING, folder / "one.mcap"), record(WHEELS, folder / "two.mcap")


def test_runs_are_called_by_the_estimators_in_which_they_differ(pair):
    found = mjsim.compare(pair)
    assert labels(found) == ["EkfLocalization", "odometry"]
    assert found.verdicts == ()
    assert any("one pair is too few" in remark for remark in found.remarks)
    own = [mjsim.statistics(mjsim.read_recording(path))["scout"] for path in pair]
    (difference,) = [d.difference for d in found.differences if d.figure.key == "ate_m.rmse"]
    assert difference.mean == own[1]["ate_m"]["rmse"] - own[0]["ate_m"]["rmse"]


def test_the_same_run_twice_differs_by_exactly_0(pair, tmp_path):
    again = shutil.copy(pair[0], tmp_path / "again.mcap")
    found = mjsim.compare([pair[0], again])
    assert labels(found) == ["one", "again"]
    assert {item.difference.mean for item in found.differences} == {0.0}
    assert found.verdicts == ()


def test_labels_that_are_given_are_kept_and_recordings_in_memory_do(pair):
    first, second = (mjsim.read_recording(path) for path in pair)
    assert labels(mjsim.compare({"mine": first, "theirs": [second]})) == ["mine", "theirs"]


def test_several_folders_are_groups_of_their_names(pair, tmp_path):
    for name, path in zip(("sharp", "blunt"), pair, strict=True):
        (tmp_path / name).mkdir()
        shutil.copy(path, tmp_path / name / "run.mcap")
    assert labels(mjsim.compare([tmp_path / "sharp", tmp_path / "blunt"])) == ["sharp", "blunt"]
    assert sorted(labels(mjsim.compare(tmp_path))) == ["EkfLocalization", "odometry"]


def test_modules_given_in_python_are_told_by_the_recording(tmp_path):
    from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
    from mjsim.algorithms.filterpy_slam import FilterpySlam

    files = [
        record(RING, tmp_path / f"{k}.mcap", seconds=0.4, estimator=estimator)
        for k, estimator in enumerate((EkfSlam(), FilterpySlam()))
    ]
    assert labels(mjsim.compare(files)) == ["EkfSlam", "FilterpySlam"]


@pytest.mark.slow
def test_a_run_that_a_fault_ended_is_counted_and_left_out(pair, tmp_path):
    class Failing:
        def start(self, robot, catalogue, rng):
            self.prior = robot.prior

        def update(self, seen):
            if seen.time > 0.5:
                raise RuntimeError("lost")
            return mjsim.Estimate(self.prior, np.eye(3))

    with pytest.raises(mjsim.ModuleFault):
        record(RING, tmp_path / "bad.mcap", estimator=Failing())
    found = mjsim.compare([pair[0], tmp_path / "bad.mcap"])
    assert found.groups[1].failed == (1,)
    assert found.differences == ()
    assert any("1 run ended before its time" in remark for remark in found.remarks)
    write_comparison(found, tmp_path / "out")


def settings(text, **metadata):
    return settings_of(mjsim.parse_world(text), metadata)


def test_labels_are_the_shortest_ends_of_keys_that_tell_settings_apart():
    noisy = RING.replace("turn: 0.1}", "turn: 0.2}")
    assert setting_labels([settings(RING), settings(noisy)], ["ring", "ring"]) == ["noise.turn=0.1", "noise.turn=0.2"]
    slow = noisy.replace("forward: 0.4", "forward: 0.2")
    assert setting_labels([settings(RING), settings(noisy), settings(slow)], ["ring"] * 3) == [
        "noise.turn=0.1, forward=0.4",
        "noise.turn=0.2, forward=0.4",
        "noise.turn=0.2, forward=0.2",
    ]
    assert setting_labels([settings(RING)] * 2, ["ring"] * 2) == ["ring", "ring"]


def test_arguments_are_told_only_where_the_class_does_not_tell_them():
    slam = RING.replace("localization:EkfLocalization", "ekf_slam:EkfSlam")
    given = [settings(text) for text in (RING, slam.replace('EkfSlam"', 'EkfSlam", jacobians: standard'))]
    assert setting_labels(given, ["ring"] * 2) == ["EkfLocalization", "EkfSlam"]
    given.append(settings(slam.replace('EkfSlam"', 'EkfSlam", jacobians: invariant')))
    assert setting_labels(given, ["ring"] * 3) == [
        "EkfLocalization",
        "EkfSlam, jacobians=standard",
        "EkfSlam, jacobians=invariant",
    ]


def test_what_differs_a_little_differs():
    near = RING.replace("turn: 0.1}", "turn: 0.10000001}")
    assert len(set(setting_labels([settings(RING), settings(near)], ["ring"] * 2))) == 2
    first, second = (RING.replace("mjsim.algorithms.localization:Ekf", f"{name}.py:Ekf") for name in ("a", "b"))
    assert setting_labels([settings(first), settings(second)], ["ring"] * 2) == [
        "a.py:EkfLocalization",
        "b.py:EkfLocalization",
    ]


def test_a_replay_is_called_by_the_estimator_that_was_at_work():
    replayed = {"replayed robot": "scout", "replayed estimator": "EkfSlam"}
    given = [settings(RING), settings(RING, **replayed)]
    assert setting_labels(given, ["ring"] * 2) == ["EkfLocalization", "EkfSlam"]


def test_replays_are_told_apart_by_the_arguments_of_their_estimators():
    def replayed(**arguments):
        use = {"use": "mjsim.algorithms.ekf_slam:EkfSlam", **arguments}
        modules = json.dumps({"estimator": use})
        told = {"replayed robot": "scout", "replayed estimator": "EkfSlam", "replayed modules": modules}
        slam = RING.replace('localization:EkfLocalization"', 'ekf_slam:EkfSlam", jacobians: standard')
        return settings(slam, **told)

    # What the world says of the class holds for the run, not for the replay.
    assert setting_labels([replayed(), replayed(jacobians="invariant")], ["ring"] * 2) == [
        "jacobians=default",
        "jacobians=invariant",
    ]


def test_worlds_that_differ_in_much_are_called_by_their_names():
    other = mjsim.parse_world("mjsim: 1\nname: field\nrobots: [{name: scout, preset: turtlebot3_burger, at: [0, 0]}]\n")
    given = [settings(RING), settings_of(other, {})]
    assert setting_labels(given, ["ring", "field"]) == ["ring", "field"]
    assert setting_labels(given, ["same", "same"]) is None


def test_files_that_differ_in_a_number_at_the_end_have_one_label(tmp_path):
    names = ("ekf-1", "ekf-2", "ukf_seed10", "ukf_seed11")
    assert file_labels([tmp_path / f"{name}.mcap" for name in names]) == ["ekf", "ekf", "ukf", "ukf"]
    assert file_labels([tmp_path / "a" / "run.mcap", tmp_path / "b" / "run.mcap"]) == ["a", "b"]


def test_what_cannot_be_compared_is_refused_in_a_line(tmp_path):
    with pytest.raises(UsageError, match="no recording in"):
        mjsim.compare(tmp_path)
    with pytest.raises(UsageError, match=r"no file .*; name a recording"):
        mjsim.compare([tmp_path / "none.mcap"])


def fake_sweep(folder, settings, *, seeds, world=RING, lost=()):
    """Write what a sweep leaves in its folder: errors grow with the seed, and with the first setting."""
    (folder / "runs").mkdir(parents=True)
    (folder / "world").mkdir()
    (folder / "world" / "hall.yaml").write_text(world)
    (folder / "sweep.json").write_text(json.dumps({"world": "hall.yaml", "set": settings}))
    cases = int(np.prod([len(values) for _, *values in settings]))
    for case, seed in itertools.product(range(cases), range(seeds)):
        error = 0.1 + 0.01 * seed + 0.5 * (case // 2)
        series = {"time": [0.0, 1.0], "position_error_m": [0.0, error], "nees": [None, 3.0]}
        outcome = {
            "case": case,
            "seed": seed,
            "error": "lost" if (case, seed) in lost else None,
            "robots": {"scout": {"position_error_m": {"mean": error}}},
            "series": {"scout": series},
        }
        (folder / "runs" / f"{case}-{seed}.json").write_text(json.dumps(outcome))
    return folder


TURN = "robots.scout.odometry.noise.turn"


def test_the_runs_of_a_sweep_are_compared_by_its_settings(tmp_path):
    settings = [[TURN, 0.1, 0.2], ["run.map", "known", "unknown"]]
    found = mjsim.compare(fake_sweep(tmp_path / "sweep", settings, seeds=10, lost=[(3, 7)]))
    assert labels(found) == [
        f"noise.turn={turn}, run.map={known}" for turn in ("0.1", "0.2") for known in ("known", "unknown")
    ]
    assert found.groups[3].failed == (7,)
    assert len(found.verdicts) == 4  # Less noise is better, whatever is known; the map changes nothing.


@pytest.mark.slow
def test_the_plots_of_a_sweep_are_drawn_but_for_the_paths_that_it_does_not_keep(tmp_path):
    found = mjsim.compare(fake_sweep(tmp_path / "sweep", [[TURN, 0.1, 0.2]], seeds=6))
    write_comparison(found, tmp_path / "out")
    assert (tmp_path / "out" / "errors.png").stat().st_size > 5000
    assert not (tmp_path / "out" / "paths.png").exists()


def test_a_sweep_beside_recordings_goes_by_its_folder_and_they_by_their_files(pair, tmp_path):
    one = fake_sweep(tmp_path / "one", [], seeds=2)
    two = fake_sweep(tmp_path / "two", [[TURN, 0.1, 0.2]], seeds=2)
    again = shutil.copy(pair[1], tmp_path / "wheels-1.mcap")
    assert labels(mjsim.compare([one, again])) == ["one", "wheels"]
    # The first is swept with what the world says, the second with that and another: all keys of the worlds tell.
    assert labels(mjsim.compare([one, two])) == ["one, noise.turn=0.1", "two, noise.turn=0.1", "two, noise.turn=0.2"]
    assert labels(mjsim.compare([two, again])) == [
        "two, noise.turn=0.1, EkfLocalization",
        "two, noise.turn=0.2, EkfLocalization",
        "wheels, noise.turn=0.1, odometry",
    ]


def test_folders_of_one_name_keep_apart(tmp_path):
    folders = [fake_sweep(tmp_path / name / "out", [], seeds=2) for name in "ab"]
    assert labels(mjsim.compare(folders)) == list(map(str, folders))


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("sweep.json", '{"world": "hall.yaml"}', "sweep.json: 'set': field required"),
        ("sweep.json", '{"world": "hall.yaml", "set": [["a"]]}', "sweep.json: 'set.0': list should have at least 2"),
        ("sweep.json", "[]", "sweep.json: input should be an object"),
        ("sweep.json", "{", "sweep.json: invalid JSON"),
        ("runs/0-0.json", "{}", "0-0.json: 'case': field required"),
        (
            "runs/0-0.json",
            '{"case": 7, "seed": 0, "error": null, "robots": {}, "series": {}}',
            "0-0.json: case is 7; cases are 0 to 1",
        ),
    ],
)
def test_a_broken_file_of_a_sweep_is_a_one_line_error(tmp_path, name, text, told):
    folder = fake_sweep(tmp_path / "sweep", [[TURN, 0.1, 0.2]], seeds=1)
    (folder / name).write_text(text)
    with pytest.raises(UsageError) as caught:
        mjsim.compare(folder)
    assert str(caught.value).startswith(f"the sweep in '{folder}' cannot be read: {told}")
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_better_estimator_is_said_to_be_better_over_six_runs_and_all_files_are_written(tmp_path, capsys):
    for seed in range(6):
        record(RING, tmp_path / f"beacons-{seed}.mcap", seed=seed, seconds=2.4)
        record(WHEELS, tmp_path / f"wheels-{seed}.mcap", seed=seed, seconds=2.4)
    code, told, _ = typed("compare", str(tmp_path), "-o", str(tmp_path / "out"), capsys=capsys)
    assert code == 0
    assert "EkfLocalization is better than odometry (6 pairs), by:\n  position error, mean" in told
    held = json.loads((tmp_path / "out" / "comparison.json").read_text())
    (difference,) = [item for item in held["differences"] if item["figure"] == "position_error_m.mean"]
    assert difference["first"] == "EkfLocalization"
    assert 0.0 < difference["low"] < difference["mean"] < difference["high"]
    names = {path.name for path in (tmp_path / "out").iterdir()}
    plots = {f"{name}.png" for name in ("errors", "differences", "boxes", "nees", "paths")}
    assert names == {"comparison.json", "comparison.html", "table.csv", "table.tex", LIST} | plots
