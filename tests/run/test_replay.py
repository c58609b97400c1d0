"""Replay gives modules the observations of a run again: a module that was in the loop gives its own result, exactly."""

import json
import re
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.beacon_vision.beacon_vision import BeaconVision
from mjsim.algorithms.constant import ConstantCommand
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.monte_carlo import MonteCarloLocalization
from mjsim.cli import main
from mjsim.errors import ModuleFault, RecordingError, UsageError
from mjsim.interface import Estimate, Observation
from mjsim.record import numeric_topics, same_run
from mjsim.report.labels import settings_of
from mjsim.run import replay

ROOT = Path(__file__).parents[2]
WALLS = "walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]\n"
RINGED = f"""mjsim: 1
{WALLS}
beacons: [{{name: a, at: [5.9, 1]}}, {{name: b, at: [0.1, 3]}}, {{name: c, at: [3, 3.9]}}]
robots:
  - {{name: scout, at: [1, 1], odometry: {{noise: {{distance: 0.02, turn: 0.02}}}},
     sensors: [{{beacons: ring, rate_hz: 5, latency: 2, noise: {{range: 0.05, bearing_deg: 1}}, false_rate: 0.5}}]}}
  - {{name: idle, at: [4, 3]}}
run: {{seconds: 2, drivers: {{scout: {{
    estimator: {{use: "mjsim.algorithms.ekf_slam:EkfSlam"}},
    navigator: {{use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.4, turn: 0.3}}}}}}}}
"""


def recorded(text: str, path: Path, **modules: object) -> mjsim.Recording:
    """Return a run of a world, with the modules that its text names unless others are given."""
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        drivers = {name: mjsim.Driver() for name in sim.robots} | {"scout": mjsim.Driver(**modules)}
        return mjsim.run(sim, drivers=drivers if modules else None, record=path)


@pytest.fixture(scope="module")
def ringed(tmp_path_factory):
    return recorded(RINGED, tmp_path_factory.mktemp("ringed") / "run.mcap")


@pytest.mark.slow
def test_an_estimator_that_was_in_the_loop_gives_its_own_recording_again(ringed, tmp_path):
    again = replay(ringed.path, robot="scout", estimator=EkfSlam(), record=tmp_path / "again.mcap")
    assert same_run(ringed.path, again.path)
    assert again.world == ringed.world
    assert again.seed == ringed.seed
    assert again.whole


class Still:
    """Believes that nothing moves, and keeps what it was given."""

    def start(self, robot, catalogue, rng):
        self.pose, self.seen = robot.prior, []

    def update(self, seen: Observation) -> Estimate:
        self.seen.append(seen)
        return Estimate(self.pose, np.eye(3))


def test_another_estimator_changes_the_estimates_and_nothing_else(ringed):
    still = Still()
    again = replay(ringed, robot="scout", estimator=still)
    track = again.robots["scout"]
    np.testing.assert_array_equal(track.estimate, np.tile([1.0, 1.0, 0.0], (50, 1)))
    assert track.landmarks.names == ()
    assert len(still.seen) == 50
    before, after = numeric_topics(ringed.path), numeric_topics(again.path)
    changed = {topic for topic in before if before[topic] != after.get(topic)}
    assert changed == {"/scout/estimate", "/scout/landmarks", "/scout/innovations", "/scout/covariance", "/tf"} & set(
        before
    )
    np.testing.assert_array_equal(track.truth, ringed.robots["scout"].truth)
    assert set(again.module_seconds) == {"scout/estimator"}
    assert again.metadata["replayed estimator"] == "Still"


@pytest.mark.slow
def test_a_replay_is_what_a_run_with_the_other_estimator_would_have_been(ringed):
    still, live = Still(), Still()
    # This navigator goes its way whatever is believed.
    arc = ConstantCommand(forward=0.4, turn=0.3)
    run = recorded(RINGED, ringed.path.with_name("live.mcap"), estimator=live, navigator=arc)
    again = replay(ringed, robot="scout", estimator=still)
    assert same_run(run.path, again.path)
    for then, now in zip(live.seen, still.seen, strict=True):
        assert (then.time, then.dt, then.bump) == (now.time, now.dt, now.bump)
        np.testing.assert_array_equal(then.proximity, now.proximity)
        np.testing.assert_array_equal(then.odometry.covariance, now.odometry.covariance)
        assert [(s.stamp, s.name, s.range, s.bearing) for s in then.sightings] == [
            (s.stamp, s.name, s.range, s.bearing) for s in now.sightings
        ]


@pytest.mark.slow
def test_a_recording_cut_short_is_replayed_up_to_its_last_whole_tick(ringed, tmp_path):
    data, cut = ringed.path.read_bytes(), tmp_path / "cut.mcap"
    for share in np.arange(0.95, 0.0, -0.05):
        cut.write_bytes(data[: int(share * len(data))])
        count = len(mjsim.read_recording(cut).time)
        if count < len(ringed.time):
            break
    assert 0 < count < len(ringed.time)
    after = replay(cut, robot="scout", estimator=EkfSlam())
    np.testing.assert_array_equal(after.time, ringed.time[:count])
    np.testing.assert_array_equal(after.robots["scout"].estimate, ringed.robots["scout"].estimate[:count])


@contextmanager
def _files_of_at_most(size: int) -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_what_is_not_there_is_said_in_one_line(ringed, tmp_path):
    with pytest.raises(UsageError, match=r"no robot 'scuot' in .*; did you mean 'scout'\?"):
        replay(ringed, robot="scuot", estimator=Still())
    with mjsim.Simulation(ringed.world) as sim:
        alone = mjsim.run(sim, drivers={"scout": mjsim.Driver()}, seconds=0.2)
    with pytest.raises(RecordingError, match="holds no observation of robot 'idle'; it had no driver in that run"):
        replay(alone, robot="idle", estimator=Still())
    with pytest.raises(UsageError, match="is the recording itself; name another file"):
        replay(ringed, robot="scout", estimator=Still(), record=ringed.path)
    with pytest.raises(UsageError, match="is a folder; name a file"):
        replay(ringed, robot="scout", estimator=Still(), record=tmp_path)
    with pytest.raises(UsageError, match="'/dev/full' is a device or a pipe; name a file"):
        replay(ringed, robot="scout", estimator=Still(), record="/dev/full", overwrite=True)
    with _files_of_at_most(4096), pytest.raises(RecordingError, match=r"cannot write '.*again.mcap': File too large"):
        replay(ringed, robot="scout", estimator=Still(), record=tmp_path / "again.mcap")
    assert not list(tmp_path.iterdir())


class Failing(Still):
    """Raises at half a second."""

    def update(self, seen: Observation) -> Estimate:
        if seen.time > 0.5:
            raise KeyError("lost")
        return super().update(seen)


def test_a_module_that_fails_ends_the_replay_as_it_ends_a_run(ringed, tmp_path):
    path = tmp_path / "failed.mcap"
    with pytest.raises(ModuleFault, match=r"estimator Failing of robot 'scout' at 0.52 s raised KeyError: 'lost'"):
        replay(ringed, robot="scout", estimator=Failing(), record=path)
    kept = mjsim.read_recording(path)
    assert kept.time[-1] == 0.48
    assert kept.whole
    # The fault itself stands in the file, for whom a later replay will no longer be told of it.
    faults = [json.loads(data)["kind"] for data in kept.messages("/scout/events")]
    assert faults[-1:] == ["fault"]
    again = replay(path, robot="scout", estimator=Still())
    assert [json.loads(data)["kind"] for data in again.messages("/scout/events")] == faults[:-1]


def test_the_fault_of_another_robot_stays_in_the_recording(tmp_path):
    path = tmp_path / "run.mcap"
    with mjsim.Simulation(mjsim.parse_world(RINGED)) as sim, pytest.raises(ModuleFault):
        mjsim.run(sim, drivers={"scout": mjsim.Driver(), "idle": mjsim.Driver(estimator=Failing())}, record=path)
    again = replay(path, robot="scout", estimator=Still())
    assert [event.kind for event in again.robots["idle"].events] == ["fault"]
    assert len(again.time) == 13


TURNING = ConstantCommand(forward=0.1, turn=-0.1)
PICTURES = f"""mjsim: 1
{WALLS}
obstacles: [{{name: crate, box: [0.4, 0.4, 0.4], at: [3, 3], movable: true, mass: 3}}]
beacons:
  - {{name: lion, image: posters/lion.jpg, at: [5.94, 1], heading_deg: 180, width: 0.8, center: 1.0}}
  - {{name: owl, image: posters/owl.jpg, at: [5.94, 2.5], heading_deg: 180, width: 0.8, center: 1.0}}
robots:
  - {{name: scout, at: [2.5, 1.5], odometry: {{noise: {{distance: 0.01, turn: 0.02}}}}, sensors: [
      {{camera: front, at: [0.1, 0, 1], width: 160, height: 120, rate_hz: 12.5, noise: 4, exposure: auto, latency: 1,
       shutter: 0.01, depth: {{noise: 0.01}}}},
      {{camera: back, yaw_deg: 180, width: 64, height: 48, rate_hz: 5, noise: 2, segmentation: true}}]}}
  - {{name: other, at: [4, 2], sensors: [{{camera: eye, width: 32, height: 24, rate_hz: 5, noise: 3}}]}}
run:
  seconds: 2
  events: [{{time: 0.6, light: 0.5}}, {{time: 1.0, move: scout, to: [3, 1.6], heading_deg: -10}},
           {{time: 1.4, move: crate, to: [4.5, 1]}}, {{time: 1.6, remove: owl}}]
"""


WAVING = f"""mjsim: 1
{WALLS}
people: [{{name: anna, sex: female, at: [4, 1.5], heading_deg: 180}}]
robots:
  - {{name: scout, at: [2.5, 1.5], sensors: [{{camera: front, at: [0.1, 0, 1.2], width: 160, height: 120, rate_hz: 12.5,
       exposure: {{time_constant: 0.5}}, dirt: 0.05, depth: {{stereo: {{texture: 0}}}}, segmentation: true}}]}}
  - {{name: other, at: [4, 3]}}
run:
  seconds: 1.8
  events: [{{time: 0.35, reach: anna, hand: right, to: [3.6, 1.7, 1.3]}},
           {{time: 0.9, reach: anna, hand: left, to: [3.5, 1.2, 1.1]}}, {{time: 1.3, release: anna, hand: right}}]
"""


@pytest.mark.slow
@pytest.mark.parametrize("world", [PICTURES, WAVING], ids=["light and things", "hands on their way and slow exposure"])
def test_pictures_are_drawn_again_to_the_last_bit_in_any_order(tmp_path, world):
    live, compared = Still(), []

    class Comparing(Still):
        """Looks at pictures of now and of some ticks ago, but at none of the first."""

        def update(self, seen: Observation) -> Estimate:
            belief = super().update(seen)
            for past in self.seen[10:][-6::5]:
                then = live.seen[self.seen.index(past)]
                assert list(then.cameras) == list(past.cameras)
                compared.extend((then.cameras[name], past.cameras[name]) for name in past.cameras)
            return belief

    with mjsim.Simulation(mjsim.parse_world(world)) as sim:
        other = mjsim.Driver(estimator=Still(), navigator=ConstantCommand(turn=1.0))
        drivers = {"scout": mjsim.Driver(estimator=live, navigator=TURNING), "other": other}
        for _ in range(7):
            sim.step()  # The recording begins while cameras have drawn from their noise already.
        mjsim.run(sim, drivers=drivers, record=tmp_path / "run.mcap")
    replay(tmp_path / "run.mcap", robot="scout", estimator=Comparing())
    assert len(compared) > 20
    assert len({now.image.tobytes() for _, now in compared}) > 10
    for then, now in compared:
        assert (then.stamp, then.instances) == (now.stamp, now.instances)
        np.testing.assert_array_equal(then.image, now.image)
        np.testing.assert_array_equal(np.asarray(then.depth, float), np.asarray(now.depth, float))
        np.testing.assert_array_equal(np.asarray(then.segmentation, float), np.asarray(now.segmentation, float))


@pytest.mark.slow
def test_slam_on_pictures_gives_its_own_recording_again(tmp_path):
    text = PICTURES.replace("width: 160, height: 120", "width: 320, height: 240").replace("seconds: 2", "seconds: 1.2")
    observer = {"observer": BeaconVision(camera="front"), "estimator": EkfSlam()}
    run = recorded(text, tmp_path / "run.mcap", **observer, navigator=TURNING)
    assert sum(map(len, run.robots["scout"].sightings)) > 5
    again = replay(run, robot="scout", estimator=EkfSlam(), observer=BeaconVision(camera="front"))
    assert same_run(run.path, again.path)
    assert list(again.pictures("scout", "front")) == list(run.pictures("scout", "front"))
    # Without the observer the estimator is given the run's own sightings, and no picture is drawn.
    assert same_run(run.path, replay(run, robot="scout", estimator=EkfSlam()).path)


SCANNED = """mjsim: 1
walls:
  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}
  - {points: [[3, 0], [3, 4]], openings: [{name: gate, segment: 0, at: 1.5, width: 0.9, door: {}}]}
obstacles: [{name: cart, box: [0.4, 0.4, 0.6], at: [1, 3], path: {points: [[1, 3], [2, 3]], speed: 0.3}}]
robots:
  - {name: scout, at: [1, 1], odometry: {noise: {distance: 0.02, turn: 0.02}},
     sensors: [{lidar: scan, beams: 60, fov_deg: 270, noise: {range: 0.02}, latency: 1}, {imu: imu}]}
  - {name: other, at: [5, 2], sensors: [{lidar: scan, beams: 20}]}
run: {seconds: 1.2, map: known, events: [{time: 0.2, open: gate}, {time: 0.8, move: scout, to: [1.2, 1.5]}]}
"""


@pytest.mark.slow
@pytest.mark.parametrize("estimator", [LidarSlam, partial(MonteCarloLocalization, particles=300)])
def test_estimators_on_lidar_and_those_that_draw_lots_give_their_own_recording_again(tmp_path, estimator):
    with mjsim.Simulation(mjsim.parse_world(SCANNED), seed=7) as sim:
        drivers = {
            name: mjsim.Driver(estimator=made(), navigator=ConstantCommand(forward=0.2, turn=0.2))
            for name, made in (("scout", estimator), ("other", Still))
        }
        run = mjsim.run(sim, drivers=drivers, record=tmp_path / "run.mcap")
    again = replay(run, robot="scout", estimator=estimator())
    assert same_run(run.path, again.path)


@pytest.mark.slow
def test_the_command_takes_modules_with_their_arguments_in_braces(ringed, tmp_path, capsys):
    (tmp_path / "mine.py").write_text(
        "import numpy as np\nfrom mjsim import Estimate, Pose\n\n\nclass Mine:\n"
        "    def __init__(self, x):\n        self.x = x\n"
        "    def start(self, robot, catalogue, rng): ...\n"
        "    def update(self, seen):\n        return Estimate(Pose(self.x, 0, 0), np.eye(3))\n"
    )
    output = tmp_path / "out" / "again.mcap"

    def code(estimator: str, robot: str = "scout") -> int:
        with pytest.raises(SystemExit) as end:
            main(["replay", str(ringed.path), "--robot", robot, "--estimator", estimator, "-o", str(output)])
        return end.value.code

    assert code(f"{tmp_path}/mine.py:Mine{{x: 2.5}}") == 0
    assert capsys.readouterr().out.strip() == str(output)
    again = mjsim.read_recording(output)
    assert (again.robots["scout"].estimate[:, 0] == 2.5).all()
    told = settings_of(again.world, again.metadata)
    assert {key: value for key, value in told.items() if ".estimator." in key} == {
        "run.drivers.scout.estimator.use": f"{tmp_path}/mine.py:Mine",
        "run.drivers.scout.estimator.x": "2.5",
    }
    output = tmp_path / "other.mcap"
    # Of a wrong robot and a wrong module, the robot comes first.
    assert code("nowhere:Nothing", robot="scuot") == 2
    assert capsys.readouterr().err == f"no robot 'scuot' in '{ringed.path}'; did you mean 'scout'?\n"
    for estimator, said in (
        ("mjsim.algorithms.ekf_slam:EkfSlm", "no class 'EkfSlm' in mjsim.algorithms.ekf_slam; did you mean 'EkfSlam'?"),
        ("mjsim.algorithms.ekf_slam:EkfSlam{a: 1", "the part in braces is not YAML; write it as {key: value"),
        (f"{tmp_path}/mine.py:Mine", "mine.py:Mine cannot be created: missing a required argument: 'x'"),
        (
            "EkfSlam",
            "use: 'EkfSlam' names no module; write 'file.py:Class', 'package.module:Class', 'file.m' or",
        ),
    ):
        assert code(estimator) == 2
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1
    assert code(f"{tmp_path}/mine.py:Mine{{x: 1}}", robot="nobody") == 2
    assert "no robot 'nobody'" in capsys.readouterr().err


@pytest.mark.slow
def test_the_program_on_the_page_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    exec(re.findall("```python\n(.*?)```", (ROOT / "docs" / "replay.md").read_text(), re.DOTALL)[0], {})
    lines = capsys.readouterr().out.split()
    assert lines[::2] == ["first-estimates", "standard"]
    assert all(0.0 < float(error) < 0.1 for error in lines[1::2])
