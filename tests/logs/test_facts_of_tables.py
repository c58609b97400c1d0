"""Tables of one's own, read column by column, and what a calibration says of tracks whose errors are known."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.interface import CameraFrame, Intrinsics, Observation, Odometry, Sighting
from mjsim.logs import Wishes, calibration, write_log
from mjsim.logs.calibration import Calibration, MotionCalibration, SightingCalibration, noise_text
from mjsim.logs.formats.columns import is_description, read_columns
from mjsim.logs.observed import _cameras
from mjsim.logs.resampling.resample import MotionNoise
from tests.logs.test_tables import LOG, MARKS, write_tables

SCAN = "{file: scan.csv, time: t, ranges: r_, from_deg: 0, step_deg: 1, range: [0.1, 8]}"


@pytest.fixture
def folder(tmp_path):
    write_tables(tmp_path)
    return tmp_path


def test_columns_are_read_in_our_units(folder):
    log = read_columns(folder / "log.yaml", Wishes())
    times = np.arange(0.0, 6.0, 0.1)
    robot = log.robot
    assert robot.track[:, 0] == pytest.approx(times)
    assert robot.track[:, 3] == pytest.approx(0.25 * times)
    assert np.hypot(*np.diff(robot.track[:, 1:3], axis=0).T) == pytest.approx(np.full(59, 0.03), abs=1e-4)
    assert robot.truth[0] == pytest.approx([0.0, 0.5, -0.2, 0.3])
    assert robot.twists.shape == (0, 3)
    assert log.sighting == (0.02, pytest.approx(math.radians(0.5)))
    first = robot.sightings[:3]
    assert [each.name for each in first] == list(MARKS)
    assert robot.identities[:3] == list(MARKS)
    for each, (x, y) in zip(first, MARKS.values(), strict=True):
        assert each.range == pytest.approx(math.dist((x, y), (0.5, -0.2)))
        assert each.bearing == pytest.approx(math.atan2(y + 0.2, x - 0.5) - 0.3)
        assert np.diag(each.covariance) == pytest.approx([0.02**2, math.radians(0.5) ** 2])
    assert log.landmarks == MARKS
    scan = robot.scans["scan"].take(0)
    # Measured from the left to the right; here from right to left.
    assert (scan.angle_min, scan.angle_increment) == pytest.approx((math.radians(90 - 4 * 45), math.radians(45)))
    assert scan.ranges.tolist() == [-math.inf, math.inf, 3.0, 2.0, 1.0]
    assert scan.stamp == pytest.approx(0.02)
    (felt, *_) = robot.imu
    assert (felt.acceleration.tolist(), felt.turn.tolist()) == ([0.0, 0.0, 9.81], [0.0, 0.0, 0.25])
    assert log.times() == pytest.approx((0.0, 5.9))
    wished = read_columns(folder / "log.yaml", Wishes(range_noise=0.5, bearing_noise=0.25))
    assert np.diag(wished.robot.sightings[0].covariance) == pytest.approx([0.25, 0.0625])


@pytest.mark.parametrize(
    ("text", "twists"),
    [
        ("twist: {file: v.csv, time: t, forward: v, turn: w}\n", [[0, 1, 3], [1, 2, 4]]),
        ("twist: {file: v.csv, time: t, forward: v, left: l, turn_deg: w}\n",
         [[0, 1, math.radians(3), 5], [1, 2, math.radians(4), 6]]),
        ("length_unit: cm\ntwist: {file: v.csv, time: t, forward: v, left: l, turn: w}\n",
         [[0, 0.01, 3, 0.05], [1, 0.02, 4, 0.06]]),
        ("time_unit: ms\ntwist: {file: v.csv, time: t, forward: v, turn: w}\n", [[0, 1, 3], [0.001, 2, 4]]),
    ],
)  # fmt: skip
def test_velocities_are_rows_in_order_of_time(tmp_path, text, twists):
    (tmp_path / "v.csv").write_text("t,v,w,l\n1,2,4,6\n0,1,3,5\n,9,9,9\n")
    (tmp_path / "log.yaml").write_text(f"log: tables\n{text}")
    log = read_columns(tmp_path / "log.yaml", Wishes())
    assert log.robot.twists == pytest.approx(np.array(twists))
    assert dict(log.notes).get("clock of v.csv") == "mended: set back 1 times; the rows are sorted by time"
    assert [value for key, value in log.notes.items() if key.startswith("rows of v.csv without t")] == ["1"]
    assert is_description(tmp_path / "log.yaml")
    assert not is_description(tmp_path / "v.csv")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("marks.csv", "../marks.csv", "is outside the folder of the description; put the table beside it"),
        ("scans: [", f"scans: [{SCAN}, ", "same name"),
    ],
)  # fmt: skip
def test_descriptions_that_lead_astray_are_refused(folder, old, new, said):
    (folder / "log.yaml").write_text(LOG.replace(old, new))
    with pytest.raises(UsageError, match=said):
        read_columns(folder / "log.yaml", Wishes())


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("marks.csv", "id,x,y\na,1,2\na,2,3\n", r"marks.csv:3: landmark 'a' has two positions"),
        ("marks.csv", "id,x,y\n,1,2\n", r"marks.csv:2: a landmark has no name"),
        ("marks.csv", "id,x,y\n-a b,1,2\n", None),
    ],
)
def test_landmarks_have_one_name_and_place(folder, file, text, said):
    (folder / file).write_text(text)
    if said is None:
        assert read_columns(folder / "log.yaml", Wishes()).landmarks == {"_-a_b": (1.0, 2.0)}
    else:
        with pytest.raises(UsageError, match=said):
            read_columns(folder / "log.yaml", Wishes())


def test_wishes_replace_the_noise_of_a_format():
    wishes = Wishes(motion={"turn": 0.5}, range_noise=0.1)
    assert wishes.motion_over(MotionNoise(distance=0.1, turn=0.2, veer=0.3)).turn == 0.5
    assert wishes.sighting_over(0.2, 0.3) == (0.1, 0.3)
    assert Wishes(bearing_noise=0.4).sighting_over(0.2, 0.3) == (0.2, 0.4)


def frame(*, depth: bool = False, size: tuple[int, int] = (4, 6), kind: type = np.uint8) -> CameraFrame:
    about = Intrinsics(width=6, height=4, fx=5.0, fy=5.0, cx=3.0, cy=2.0)
    return CameraFrame(0.0, np.zeros((*size, 3), kind), about, np.ones((4, 6)) if depth else None)


def seen(*frames: CameraFrame) -> list[Observation]:
    still = Odometry(0.0, 0.0, 0.0, np.eye(3))
    return [Observation(time=0.1 * k, dt=0.1, odometry=still, cameras={"eye": each}) for k, each in enumerate(frames)]


def test_a_camera_of_a_log_has_depth_if_one_picture_has():
    assert not _cameras(seen(frame(), frame()), placed=True)["eye"].has_depth
    assert _cameras(seen(frame(), frame(depth=True)), placed=True)["eye"].has_depth
    assert _cameras(seen(frame()), placed=False)["eye"].robot_from_camera is None
    for wrong, said in (
        (frame(size=(4, 5)), "gave 5 x 4 pixels; its intrinsics are for 6 x 4"),
        (frame(kind=np.float32), "uint8"),
    ):
        with pytest.raises(UsageError, match=f"observation 1: .*{said}"):
            _cameras(seen(frame(), wrong), placed=True)


def test_calibrations_of_several_robots_are_combined():
    motions = [
        MotionCalibration(windows=30, scale=scale, distance=distance, turn_bias=0.02, turn=0.1, delay=delay)
        for scale, distance, delay in ((1.1, 0.3, 0.1), (1.3, 0.4, 0.3))
    ]
    sighting = SightingCalibration(count=30, outliers=1, range_bias=0.05, range=0.2, bearing_bias=0.1, bearing=0.3)
    text = noise_text(
        {"a": Calibration(motion=motions[0], sightings=sighting), "b": Calibration(motion=motions[1], sightings=None)}
    )
    values = dict(line.strip().split(": ") for line in text.splitlines() if line.startswith("  "))
    assert text.startswith("# Measured by mjsim calibrate; means over a, b.\nnoise:\n")
    assert "distance: 0.35355" in text
    assert [float(values[key]) for key in ("scale", "delay", "turn_deg")] == pytest.approx(
        [1.2, 0.2, math.degrees(0.02)], rel=1e-4
    )
    assert f"  bearing_deg: {math.degrees(0.3):.5g}\n" in text
    assert f"  bearing_deg: {math.degrees(0.1):.5g}\n" in text
    assert "delay" not in noise_text({"a": Calibration(motion=None, sightings=sighting)}).partition("\nbias")[0]


def test_a_log_of_other_rates_or_sizes_is_refused(tmp_path):
    with pytest.raises(UsageError):
        write_log(tmp_path / "a.mcap", seen(frame()))


def tracked(*, scale: float = 1.0, bias: float = 0.0, late: float = 0.0, noise: float = 0.0) -> SimpleNamespace:
    """Return a track of 120 s whose odometry has known errors."""
    time = np.arange(0.0, 120.0, 0.1)
    rate, speed = 0.4 * np.sin(0.7 * time), 0.5
    true = np.zeros((len(time), 3))
    true[1:, 2] = np.cumsum(rate[:-1]) * 0.1
    headings = true[:-1, 2] + rate[:-1] * 0.05
    true[1:, :2] = np.cumsum(speed * 0.1 * np.stack([np.cos(headings), np.sin(headings)], axis=-1), axis=0)
    rng = np.random.default_rng(4)
    turns = 0.4 * np.sin(0.7 * (time[:-1] + late)) * 0.1 + bias * 0.1
    ways = scale * (speed * 0.1 + noise * math.sqrt(speed * 0.1) * rng.normal(size=len(turns)))
    odometry = np.zeros_like(true)
    odometry[1:, 2] = np.cumsum(turns)
    headings = odometry[:-1, 2] + turns / 2
    odometry[1:, :2] = np.cumsum(ways[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=-1), axis=0)
    return SimpleNamespace(time=time, truth=true, odometry=odometry, sightings=[], identities=[])


@pytest.mark.parametrize(
    ("errors", "found"),
    [
        ({}, {"scale": 1.0, "turn_bias": 0.0, "delay": 0.0, "distance": 0.0, "turn": 0.0}),
        ({"scale": 1.1}, {"scale": 1.1, "turn_bias": 0.0, "delay": 0.0}),
        ({"bias": 0.02}, {"scale": 1.0, "turn_bias": 0.02, "delay": 0.0, "turn": 0.0}),
        ({"late": 0.3}, {"delay": 0.3}),
        ({"late": -0.3}, {"delay": -0.3}),
        ({"noise": 0.05}, {"scale": 1.0, "distance": 0.05}),
    ],
)
def test_errors_of_odometry_that_are_known_are_found_again(errors, found):
    result = calibration._motion(tracked(**errors))
    assert result.windows == 59
    for name, value in found.items():
        assert getattr(result, name) == pytest.approx(value, abs=0.012), name


def test_what_is_too_short_or_stands_still_gives_no_calibration():
    track = tracked()
    track.truth[300:] = np.nan
    assert calibration._motion(track) is None
    still = tracked()
    still.odometry[:] = 0.0
    assert calibration._motion(still) is None


def test_errors_of_sightings_that_are_known_are_found_again():
    track, place = tracked(), np.array([3.0, 40.0])
    rng = np.random.default_rng(6)
    for k in range(0, 1200, 10):
        x, y, heading = track.truth[k]
        dx, dy = place - [x, y]
        errors = [0.05, 0.02] + [0.1, 0.03] * rng.normal(size=2) + ([5.0, 0.0] if k == 500 else 0.0)
        bearing = math.remainder(math.atan2(dy, dx) - heading + errors[1], 2 * math.pi)
        track.sightings.append([Sighting(track.time[k], None, math.hypot(dx, dy) + errors[0], bearing, np.eye(2))])
        track.identities.append(["mark"])
    found = calibration._sightings(track, {"mark": place})
    assert (found.count, found.outliers) == (120, 1)
    assert (found.range_bias, found.bearing_bias) == pytest.approx((0.05, 0.02), abs=0.03)
    assert (found.range, found.bearing) == pytest.approx((0.1, 0.03), rel=0.2)
    assert calibration._sightings(track, {"other": place}) is None
