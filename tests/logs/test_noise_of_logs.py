"""What a log tells about the noise of a robot, from tracks whose errors are known exactly."""

import math

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.logs.calibration import (
    Calibration,
    MotionCalibration,
    SightingCalibration,
    _delay,
    _motion,
    _per_root,
    _root,
    noise_text,
    write_noise,
)

DT = 0.1


class Track:
    """What a calibration reads of a recorded robot."""

    def __init__(self, truth, odometry):
        self.time, self.truth, self.odometry = np.arange(len(truth)) * DT, truth, odometry


def driven(speed, rates):
    """Return poses at a speed and changing turn rates, by Euler's midpoint."""
    headings = np.concatenate([[0.0], np.cumsum(rates * DT)])
    middle = (headings[1:] + headings[:-1]) / 2
    x = np.concatenate([[0.0], np.cumsum(speed * DT * np.cos(middle))])
    y = np.concatenate([[0.0], np.cumsum(speed * DT * np.sin(middle))])
    return np.column_stack([x, y, headings])


RATES = 0.3 * np.sin(np.arange(1200) * DT * 0.9)


def test_scale_and_bias_of_odometry_are_those_that_were_put_in():
    found = _motion(Track(driven(0.5, RATES), driven(0.55, RATES + 0.02)))
    assert found.scale == pytest.approx(1.1, abs=1e-3)
    assert found.turn_bias == pytest.approx(0.02, rel=1e-6)
    assert found.turn == pytest.approx(0.0, abs=1e-9)
    assert found.distance < 2e-3, "chords of slightly different arcs"
    assert found.windows == 60


def test_noise_of_odometry_has_the_unit_of_its_root():
    rng = np.random.default_rng(1)
    a, b = 0.05, 0.1
    true = driven(0.5, np.full(6_000, 0.2))
    steps = np.full(6_000, 0.5 * DT) + a * math.sqrt(0.5 * DT) * rng.normal(size=6_000)
    found = _motion(Track(true, driven(steps / DT, np.full(6_000, 0.2))))
    assert found.distance == pytest.approx(a, rel=0.15)
    turns = 0.2 + b * math.sqrt(0.2 * DT) * rng.normal(size=6_000) / DT
    assert _motion(Track(true, driven(0.5, turns))).turn == pytest.approx(b, rel=0.25)


def test_too_short_a_log_and_one_at_rest_tell_nothing():
    assert _motion(Track(driven(0.5, RATES[:100]), driven(0.5, RATES[:100]))) is None
    assert _motion(Track(driven(0.0, RATES * 0), driven(0.0, RATES * 0))) is None


@pytest.mark.parametrize("late", [0, 2, -3])
def test_a_delay_of_turns_is_found_by_its_sign(late):
    rates = np.random.default_rng(3).normal(size=1300)
    smooth = np.convolve(rates, np.ones(5) / 5, mode="same")
    odometry, truth = driven(0.5, smooth[50:1250]), driven(0.5, smooth[50 - late : 1250 - late])
    assert _delay(Track(truth, odometry)) == pytest.approx(late * DT, abs=0.021)


def test_a_delay_is_not_told_where_the_turn_rate_is_constant_or_the_log_short():
    assert _delay(Track(driven(0.5, np.full(500, 0.2)), driven(0.5, np.full(500, 0.2)))) == 0.0
    assert _delay(Track(driven(0.5, RATES[:15]), driven(0.5, RATES[:15]))) == 0.0


def test_errors_grow_with_the_root_of_what_they_grew_over():
    assert _per_root(np.array([0.3, -0.4]), np.array([1.0, 4.0])) == pytest.approx(math.sqrt(0.25 / 5.0))
    assert _per_root(np.array([0.3]), np.array([0.0])) == 0.0
    assert _root([3.0, 4.0]) == pytest.approx(math.sqrt(12.5))


def test_the_noise_is_written_in_the_units_of_a_world(tmp_path):
    motion = MotionCalibration(windows=30, scale=1.2, distance=0.03, turn_bias=math.radians(2.0), turn=0.05, delay=0.1)
    sightings = SightingCalibration(
        count=50, outliers=1, range_bias=0.07, range=0.3, bearing_bias=math.radians(-1.0), bearing=math.radians(4.0)
    )
    told = noise_text(
        {"a": Calibration(motion=motion, sightings=sightings), "b": Calibration(motion=None, sightings=None)}
    )
    assert told.splitlines() == [
        "# Measured by mjsim calibrate; means over a, b.",
        "noise:",
        "  distance: 0.03",
        "  turn: 0.05",
        "  range: 0.3",
        "  bearing_deg: 4",
        "bias:  # scale of odometry's distance; its delay [s] and turn [deg/s]; of range [m] and bearing",
        "  scale: 1.2",
        "  delay: 0.1",
        "  turn_deg: 2",
        "  range: 0.07",
        "  bearing_deg: -1",
    ]
    file = tmp_path / "noise.yaml"
    write_noise(file, {"a": Calibration(motion=motion, sightings=None)}, overwrite=False)
    assert "range" not in file.read_text().replace("range [m]", "")
    with pytest.raises(UsageError, match="exists"):
        write_noise(file, {}, overwrite=False)
