"""Calibration: noise and bias of a robot's odometry and sightings, from a log with ground truth."""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import RecordingError, UsageError
from mjsim.geometry import Array, places_at, wrap_angles
from mjsim.logs.importing import import_log
from mjsim.output import require_free
from mjsim.record import Recording, Track, read_recording

WINDOW_SECONDS = 2.0
"""Duration over which motion by odometry is compared with the true motion [s]."""
WINDOW_PARTS = 4
"""Parts of a window, over which distances and turns are summed."""
MIN_MOTION = 0.05
"""Minimum distance or turn in a window for it to count [m, rad]."""
OUTLIER_SIGMAS = 6.0
"""Sightings are outliers beyond this many standard deviations, estimated from the median absolute deviation."""
MIN_SAMPLES = 20
"""Minimum number of windows, or of sightings, for a result."""
MAX_DELAY, DELAY_STEP = 0.6, 0.02
"""Range (either sign) and step of the search for a delay [s]."""
MAX_ERROR_RATIO = 0.9
"""If the delay reduces the error of turns only to more than this ratio, it is not observable in the log."""
SIGMA_PER_MAD = 1.4826
"""Standard deviation of a normal distribution divided by its median absolute deviation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionCalibration:
    """Calibration of odometry, with noise in the units of a world's `odometry.noise`."""

    windows: int
    """Number of windows compared."""
    scale: float
    """Distance by odometry divided by the true distance."""
    distance: float
    """Noise of the distance, after correction of the scale [m/sqrt(m)]."""
    turn_bias: float
    """Bias of the turn rate of odometry, left positive [rad/s]."""
    turn: float
    """Noise of the turn, after subtraction of the bias [rad/sqrt(rad)]."""
    delay: float
    """Delay of the robot's turns relative to odometry [s]; 0 if it is not observable because the turn rate is
    constant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SightingCalibration:
    """Calibration of range and bearing to known landmarks; outliers are counted and left out."""

    count: int
    outliers: int
    range_bias: float
    """Mean error (measured minus true) [m]."""
    range: float
    """Standard deviation about it [m]."""
    bearing_bias: float
    """Mean error (measured minus true), left positive [rad]."""
    bearing: float
    """Standard deviation about it [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """Calibration of one robot; None where the log has too little data."""

    motion: MotionCalibration | None
    sightings: SightingCalibration | None


def calibrate(log: str | Path | Recording) -> dict[str, Calibration]:
    """Return noise and bias of the odometry and sightings of each robot of a log.

    Args:
        log: A recording, its file, or a log that `import_log` reads.

    Raises:
        UsageError: The log cannot be read, or has no ground truth for any robot.
    """
    recording = log if isinstance(log, Recording) else _recording(Path(log))
    places = {str(beacon.name): np.array(beacon.at) for beacon in recording.world.beacons}
    found = {
        name: Calibration(motion=_motion(track), sightings=_sightings(track, places))
        for name, track in recording.robots.items()
    }
    if all(each.motion is None and each.sightings is None for each in found.values()):
        raise UsageError("the log has too little ground truth for a calibration")
    return found


def noise_text(calibrations: Mapping[str, Calibration]) -> str:
    """Return noise and biases as YAML, combined over all robots: RMS of the noise, mean of the biases."""
    motions = [each.motion for each in calibrations.values() if each.motion is not None]
    sightings = [each.sightings for each in calibrations.values() if each.sightings is not None]
    noise, bias = {}, {}
    if motions:
        noise["distance"], noise["turn"] = _root([m.distance for m in motions]), _root([m.turn for m in motions])
        bias["scale"] = float(np.mean([m.scale for m in motions]))
        if delay := float(np.mean([m.delay for m in motions])):
            bias["delay"] = delay
        bias["turn_deg"] = math.degrees(float(np.mean([m.turn_bias for m in motions])))
    if sightings:
        noise["range"], noise["bearing_deg"] = (
            _root([s.range for s in sightings]),
            math.degrees(_root([s.bearing for s in sightings])),
        )
        bias["range"] = float(np.mean([s.range_bias for s in sightings]))
        bias["bearing_deg"] = math.degrees(float(np.mean([s.bearing_bias for s in sightings])))
    lines = [f"# Measured by mjsim calibrate; means over {', '.join(calibrations)}.", "noise:"]
    lines += [f"  {key}: {value:.5g}" for key, value in noise.items()]
    lines += ["bias:  # scale of odometry's distance; its delay [s] and turn [deg/s]; of range [m] and bearing"]
    lines += [f"  {key}: {value:.5g}" for key, value in bias.items()]
    return "\n".join(lines) + "\n"


def write_noise(path: Path, calibrations: Mapping[str, Calibration], *, overwrite: bool) -> None:
    """Write the noise and the biases as YAML.

    Raises:
        UsageError: The file exists and may not be replaced.
    """
    require_free(path, overwrite=overwrite)
    path.write_text(noise_text(calibrations), encoding="utf-8")


def _recording(path: Path) -> Recording:
    if path.is_file() and path.suffix == ".mcap":
        try:
            return read_recording(path)
        except RecordingError:
            return import_log(path)  # a ROS 2 bag
    return import_log(path)


def _motion(track: Track) -> MotionCalibration | None:
    """Compare odometry with the truth, window by window."""
    rows = max(1, round(WINDOW_SECONDS / float(np.median(np.diff(track.time))))) if len(track.time) > 1 else 1
    ends = np.arange(0, len(track.time) - rows, rows)
    # In parts of a window: the noise of a single tick may exceed the motion, and would make it seem longer.
    parts = np.linspace(0, rows, min(rows, WINDOW_PARTS) + 1).round().astype(int)
    steps = np.diff(track.odometry[ends[:, None] + parts], axis=1)
    distance, turned = (
        np.hypot(steps[..., 0], steps[..., 1]).sum(axis=1),
        np.abs(wrap_angles(steps[..., 2])).sum(axis=1),
    )
    measured, true = (_chords(poses, ends, rows) for poses in (track.odometry, track.truth))
    counts = (
        np.isfinite(true).all(axis=1)
        & np.isfinite(measured).all(axis=1)
        & ((distance > MIN_MOTION) | (turned > MIN_MOTION))
    )
    if counts.sum() < MIN_SAMPLES:
        return None
    measured, true, distance, turned = measured[counts], true[counts], distance[counts], turned[counts]
    # The distances are chords of arcs: for the small turns in a window they are proportional to the lengths of the
    # arcs.
    driven = true[:, 0] > MIN_MOTION
    scale = float(measured[driven, 0].sum() / true[driven, 0].sum()) if driven.any() else 1.0
    turn_errors = wrap_angles(measured[:, 1] - true[:, 1])
    bias, seconds = float(turn_errors.mean()), rows * float(np.median(np.diff(track.time)))
    return MotionCalibration(
        windows=int(counts.sum()),
        scale=scale,
        distance=_per_root(measured[driven, 0] / scale - true[driven, 0], distance[driven]),
        turn_bias=bias / seconds,
        turn=_per_root(turn_errors - bias, turned),
        delay=_delay(track),
    )


def _delay(track: Track) -> float:
    """Return the time shift of odometry for which its turns agree best with the true turns [s]."""
    known = np.asarray(np.isfinite(np.column_stack([track.truth, track.odometry])).all(axis=1))
    times, rates = track.time, np.diff(track.time)
    true = wrap_angles(np.diff(track.truth[:, 2])) / rates
    heading = np.concatenate([[0.0], np.nancumsum(wrap_angles(np.diff(track.odometry[:, 2])))])
    within = (times[:-1] - MAX_DELAY >= times[0]) & (times[1:] + MAX_DELAY <= times[-1])
    both = np.flatnonzero(np.logical_and(known[:-1], known[1:]) & within)
    if len(both) < MIN_SAMPLES:
        return 0.0
    delays, left = np.arange(-MAX_DELAY, MAX_DELAY + DELAY_STEP / 2, DELAY_STEP), []
    for delay in delays.tolist():
        measured = np.diff(np.interp(times - delay, times, heading)) / rates
        measured, turned = measured[both], true[both]
        share = float(measured @ turned) / max(float(measured @ measured), 1e-12)
        left.append(float(np.sum((turned - share * measured) ** 2)))
    best = int(np.argmin(left))
    without = left[len(delays) // 2]
    return float(delays[best]) if left[best] < MAX_ERROR_RATIO * without else 0.0


def _chords(poses: Array, ends: NDArray[np.intp], rows: int) -> Array:
    """Return distance and turn of a robot in each window, shape (n, 2) [m, rad]."""
    steps = poses[ends + rows] - poses[ends]
    return np.stack([np.hypot(steps[:, 0], steps[:, 1]), wrap_angles(steps[:, 2])], axis=-1)


def _per_root(errors: Array, amounts: Array) -> float:
    """Return a such that the variance of the errors is a^2 times the amounts that they grew over."""
    total = float(amounts.sum())
    return float(np.sqrt(np.sum(errors**2) / total)) if total > 0.0 else 0.0


def _sightings(track: Track, places: Mapping[str, Array]) -> SightingCalibration | None:
    """Compare the sightings of known landmarks with the truth at the time of each."""
    known = list(_identified(track, places))
    if len(known) < MIN_SAMPLES:
        return None
    stamps, ranges, bearings, x, y = np.array(known).T
    poses = places_at(stamps, np.column_stack([track.time, track.truth]), gap=math.inf)
    dx, dy = x - poses[:, 0], y - poses[:, 1]
    errors = np.stack([ranges - np.hypot(dx, dy), wrap_angles(bearings - np.arctan2(dy, dx) + poses[:, 2])], axis=-1)
    errors = errors[np.isfinite(errors).all(axis=1)]
    if len(errors) < MIN_SAMPLES:
        return None
    deviations = np.abs(errors - np.median(errors, axis=0))
    good = np.all(deviations <= OUTLIER_SIGMAS * SIGMA_PER_MAD * np.median(deviations, axis=0) + 1e-9, axis=1)
    mean, deviation = errors[good].mean(axis=0).tolist(), errors[good].std(axis=0).tolist()
    return SightingCalibration(
        count=len(errors),
        outliers=int((~good).sum()),
        range_bias=mean[0],
        range=deviation[0],
        bearing_bias=mean[1],
        bearing=deviation[1],
    )


def _identified(track: Track, places: Mapping[str, Array]) -> Iterator[tuple[float, float, float, float, float]]:
    """Yield stamp, range, bearing and true position for each sighting of a known landmark."""
    for seen, identities in itertools.zip_longest(track.sightings, track.identities, fillvalue=()):
        for sighting, identity in zip(seen, itertools.chain(identities, itertools.repeat(None)), strict=False):
            name = str(sighting.name or identity)
            if name in places:
                x, y = places[name].tolist()
                yield sighting.stamp, sighting.range, sighting.bearing, x, y


def _root(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
