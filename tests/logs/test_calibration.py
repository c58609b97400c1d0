"""What `calibrate` says of logs whose noise and bias are known."""

import dataclasses

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.interface import Observation, Odometry, Sighting
from mjsim.logs import Wishes
from tests.real_logs import imported, run_command, write_mrclam

PLACES = {"door": (4.0, 0.0), "lamp": (-3.0, 2.0), "desk": (0.5, -4.0)}
DT = 0.1


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A drive of 100 s on a circle; odometry is 7 % long and turns by 0.2 degrees a second too much."""
    rng, observations, truth = np.random.default_rng(0), [], []
    pose, step = mjsim.Pose(1.0, 0.0, np.pi / 2), mjsim.Pose(0.03, 0.0, 0.03)
    for tick in range(1000):
        noise = rng.normal(0.0, [0.05 * np.sqrt(step.x), 0.1 * np.sqrt(step.heading)])
        moved = Odometry(
            1.07 * step.x + noise[0], 0.0, step.heading + DT * np.radians(0.2) + noise[1], 1e-4 * np.eye(3)
        )
        pose = pose @ step
        seen = []
        for name, place in PLACES.items():
            ahead, left = pose.inverse().transform(place)
            wrong = 3.0 if rng.random() < 0.02 else 0.0
            z = (
                np.hypot(ahead, left) + rng.normal(0.09, 0.03) + wrong,
                np.arctan2(left, ahead) + rng.normal(0.01, 0.02),
            )
            seen.append(Sighting(DT * tick, name, float(z[0]), float(z[1]), np.diag([0.01, 0.001])))
        observations.append(Observation(time=DT * tick, dt=DT, odometry=moved, sightings=tuple(seen)))
        truth.append(pose.as_array())
    path = tmp_path_factory.mktemp("calibrate") / "run.mcap"
    return mjsim.write_log(path, observations, truth=np.array(truth), landmarks=PLACES)


@pytest.mark.slow
def test_noise_and_bias_of_a_log_come_back(log):
    found = mjsim.calibrate(log)["robot"]
    motion, looks = found.motion, found.sightings
    assert motion.scale == pytest.approx(1.07, abs=0.02)
    assert np.degrees(motion.turn_bias) == pytest.approx(0.2, abs=0.35)  # 50 windows of 1.4 degrees
    assert motion.distance == pytest.approx(0.05, rel=0.35)
    assert motion.turn == pytest.approx(0.1, rel=0.35)
    assert (looks.range_bias, looks.range) == pytest.approx((0.09, 0.03), abs=0.003)
    assert (looks.bearing_bias, looks.bearing) == pytest.approx((0.01, 0.02), abs=0.0015)
    assert looks.outliers == pytest.approx(60, abs=25)


@pytest.mark.slow
def test_the_command_says_it_and_writes_it_once(log, tmp_path, capsys):
    assert run_command("calibrate", log.path, "-o", tmp_path / "noise.yaml") == 0
    assert "robot odometry: distance +" in capsys.readouterr().out
    assert "  range: 0.03" in (tmp_path / "noise.yaml").read_text()
    assert run_command("calibrate", log.path, "-o", tmp_path / "noise.yaml") == 2
    assert run_command("calibrate", log.path, "-o", tmp_path / "noise.yaml", "--overwrite") == 0


@pytest.mark.slow
@pytest.mark.parametrize("ticks", [-2, 3])
def test_a_delay_is_calibrated_and_corrected_by_an_import(tmp_path, ticks):
    """A robot turns left and right by turns, so many ticks later than its log tells."""
    times = DT * np.arange(600)
    turns = np.where((times // 2.0) % 2 == 0, 0.06, -0.04)
    truth = [mjsim.Pose(0.0, 0.0, 0.0)]
    for turn in np.roll(turns, ticks)[:-1]:
        truth.append(truth[-1] @ mjsim.Pose(0.03, 0.0, float(turn)))
    poses = [mjsim.Pose(0.0, 0.0, 0.0)]
    for turn in turns[:-1]:
        poses.append(poses[-1] @ mjsim.Pose(0.03, 0.0, float(turn)))
    for name, rows in (("odometry", poses), ("truth", truth)):
        lines = [f"{time:.3f},{at.x!r},{at.y!r},{at.heading!r}" for time, at in zip(times, rows, strict=True)]
        (tmp_path / f"{name}.csv").write_text("\n".join(["t,x,y,yaw", *lines]) + "\n")
    tables = [f"{name}: {{file: {name}.csv, time: t, x: x, y: y, heading: yaw}}\n" for name in ("odometry", "truth")]
    (tmp_path / "log.yaml").write_text("".join(["log: tables\n", *tables]))
    read = imported(tmp_path / "log.yaml", record=tmp_path / "log.mcap")
    found = mjsim.calibrate(read)["robot"].motion
    assert found.delay == pytest.approx(DT * ticks, abs=0.011)
    log = tmp_path / "log.yaml" if ticks > 0 else read.path  # one is read in a child, the other here
    assert run_command("calibrate", log, "-o", tmp_path / "noise.yaml") == 0
    wishes = Wishes().measured_by(tmp_path / "noise.yaml")
    assert wishes.bias.delay == pytest.approx(found.delay)
    again = mjsim.calibrate(imported(tmp_path / "log.yaml", wishes=wishes))["robot"].motion
    assert again.delay == 0.0
    assert again.turn < 0.3 * found.turn


def test_a_log_without_truth_is_refused(log):
    blind = {name: dataclasses.replace(t, truth=np.full_like(t.truth, np.nan)) for name, t in log.robots.items()}
    with pytest.raises(UsageError, match="too little ground truth"):
        mjsim.calibrate(dataclasses.replace(log, robots=blind))


NOISE = """\
noise: {distance: 0.02, turn: 0.03, veer: 0, range: 0.04, bearing_deg: 1.5}
bias: {scale: 1.25, turn_deg: 2, range: 0.1, bearing_deg: -1}
"""


def test_an_import_tells_the_measured_noise_and_takes_the_bias_away(tmp_path):
    write_mrclam(tmp_path / "log", seconds=3.0)
    (tmp_path / "noise.yaml").write_text(NOISE)
    plain = imported(tmp_path / "log")
    mended = imported(tmp_path / "log", wishes=Wishes().measured_by(tmp_path / "noise.yaml"))
    assert mended.metadata["bias taken away"] == "scale 1.25, turn_deg 2, range 0.1, bearing_deg -1"
    told = list(zip(plain.observations("robot1"), mended.observations("robot1"), strict=True))
    raw, step = told[7][0].odometry, told[7][1].odometry
    assert step.forward == pytest.approx(raw.forward / 1.25)
    assert step.turn == pytest.approx(raw.turn - DT * np.radians(2.0))
    assert step.covariance[2, 2] == pytest.approx(0.03**2 * 0.025, rel=1e-4)  # 0.25 rad/s for a tick
    before, after = next((a.sightings[0], b.sightings[0]) for a, b in told if a.sightings)
    assert after.range == pytest.approx(before.range - 0.1)
    assert after.bearing == pytest.approx(before.bearing + np.radians(1.0))
    np.testing.assert_allclose(after.covariance, np.diag([0.04**2, np.radians(1.5) ** 2]))


@pytest.mark.slow
def test_what_calibrate_writes_is_read_back_and_noise_asked_for_comes_first(log, tmp_path):
    assert run_command("calibrate", log.path, "-o", tmp_path / "noise.yaml") == 0
    wishes = Wishes(range_noise=0.2).measured_by(tmp_path / "noise.yaml")
    looks = mjsim.calibrate(log)["robot"].sightings
    assert wishes.range_noise == 0.2
    assert wishes.bearing_noise == pytest.approx(looks.bearing, rel=1e-4)
    assert wishes.bias.range == pytest.approx(looks.range_bias, rel=1e-4)


def test_a_faulty_noise_file_is_refused_with_its_line(tmp_path, capsys):
    write_mrclam(tmp_path / "log", seconds=3.0)
    (tmp_path / "noise.yaml").write_text("noise:\n  rnge: 0.1\n  turn: .nan\nbias: {scale: 0}\n")
    assert (
        run_command("import-log", tmp_path / "log", "-o", tmp_path / "a.mcap", "--noise", tmp_path / "noise.yaml") == 2
    )
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 3
    assert "noise.yaml:2:3: unknown key 'rnge'; did you mean 'range'?" in lines[0]
    assert not (tmp_path / "a.mcap").exists()
    assert (
        run_command("import-log", tmp_path / "log", "-o", tmp_path / "a.mcap", "--noise", tmp_path / "none.yaml") == 2
    )
    assert "none.yaml" in capsys.readouterr().err
