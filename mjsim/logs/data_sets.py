"""Imports data sets whose format is known, with arguments of their own."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

from mjsim.logs.importing import guarded_recording
from mjsim.logs.resampling import UNBIASED, Bias, MotionNoise, Wishes
from mjsim.record import Recording


def import_mrclam(
    folder: str | Path,
    *,
    robots: Sequence[int] | None = None,
    rate_hz: float | None = None,
    begin: float = 0.0,
    seconds: float | None = None,
    known_map: bool = False,
    motion: MotionNoise | None = None,
    sighting: tuple[float, float] | None = None,
    bias: Bias = UNBIASED,
    record: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
    overwrite: bool = False,
) -> Recording:
    """Return a data set as a recording: robots 'robot1' and so on, landmarks 'landmark6' and so on.

    Time 0 is when all files of these robots have started. Sightings of other robots are left out.

    Args:
        folder: Folder of the text files.
        robots: Numbers of the robots; by default all in the folder.
        rate_hz: Ticks per second; by default 10.
        begin: Time to skip at the beginning [s].
        seconds: Duration to import [s]; by default all.
        known_map: Whether modules get the positions of the landmarks.
        motion: Noise of the logged motion; by default that of `mjsim.logs.FORMAT`.
        sighting: Standard deviations of range and bearing [m, rad]; by default those of `mjsim.logs.FORMAT`.
        bias: Systematic errors that are subtracted from odometry and sightings.
        record: The MCAP file to write; by default a temporary one, deleted with the recording.
        progress: Called with the progress [%].
        overwrite: Whether `record` may replace a file.

    Raises:
        UsageError: A file does not exist or is invalid (the message has file and line), or `record` exists.
        RecordingError: The file cannot be written.
    """
    wishes = replace(
        _noise(motion, sighting),
        rate_hz=rate_hz,
        begin=begin,
        seconds=seconds,
        robots=[str(number) for number in robots or ()],
        known_map=known_map,
        bias=bias,
    )
    convert = "mjsim.logs.formats:convert_mrclam"
    return guarded_recording(convert, folder, wishes, record=record, progress=progress, overwrite=overwrite)


def import_victoria_park(
    folder: str | Path,
    *,
    rate_hz: float | None = None,
    begin: float = 0.0,
    seconds: float | None = None,
    motion: MotionNoise | None = None,
    sighting: tuple[float, float] | None = None,
    bias: Bias = UNBIASED,
    record: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
    overwrite: bool = False,
) -> Recording:
    """Return the data set as a recording of the robot 'car', whose sightings have no names.

    The car starts at the first fix, or without gps.dat at the origin, facing along x. The truth is the pose of the
    middle of the rear axle, at times close to fixes of the antenna; fixes that disagree with the others are left out.

    Args:
        folder: Folder of the text files.
        rate_hz: Ticks per second; by default 25.
        begin: Time to skip at the beginning [s].
        seconds: Duration to import [s]; by default all.
        motion: Noise of the logged motion; by default that of `mjsim.logs.FORMAT`.
        sighting: Standard deviations of range and bearing [m, rad]; by default those of `mjsim.logs.FORMAT`.
        bias: Systematic errors that are subtracted from odometry and sightings.
        record: The MCAP file to write; by default a temporary one, deleted with the recording.
        progress: Called with the progress [%].
        overwrite: Whether `record` may replace a file.

    Raises:
        UsageError: A file does not exist or is invalid (the message has file and line), or `record` exists.
        RecordingError: The file cannot be written.
    """
    wishes = replace(
        _noise(motion, sighting),
        rate_hz=rate_hz,
        begin=begin,
        seconds=seconds,
        bias=bias,
    )
    convert = "mjsim.logs.formats:convert_victoria_park"
    return guarded_recording(convert, folder, wishes, record=record, progress=progress, overwrite=overwrite)


def _noise(motion: MotionNoise | None, sighting: tuple[float, float] | None) -> Wishes:
    """Return options with the given noise; None leaves that of the format."""
    distance, bearing = (None, None) if sighting is None else sighting
    return Wishes(motion={} if motion is None else asdict(motion), range_noise=distance, bearing_noise=bearing)
