"""The commands `import-log`, which converts a real robot's log, and `calibrate`, which estimates noise and bias."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.errors import UsageError
from mjsim.progress import say, tracked

if TYPE_CHECKING:
    from mjsim.logs import Calibration


def import_log(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="LOG",
            help="MRCLAM, Victoria Park, TUM RGB-D, EuRoC, CARMEN or MRPT; a ROS bag; or YAML that describes tables.",
        ),
    ],
    output: Annotated[Path, typer.Option("-o", metavar="RUN.mcap", help="The recording to write.")],
    robot: Annotated[
        list[str] | None, typer.Option(metavar="R", help="Robots to import from MRCLAM or a bag; may be repeated.")
    ] = None,
    topic: Annotated[
        list[str] | None,
        typer.Option(metavar="KIND=TOPIC", help="Topic of a bag to read, such as odometry=/odom; may be repeated."),
    ] = None,
    rate: Annotated[float | None, typer.Option(help="Ticks per second of the recording.", min=0.1, max=250)] = None,
    begin: Annotated[float, typer.Option(help="Skip this much at the beginning [s].", min=0.0)] = 0.0,
    seconds: Annotated[float | None, typer.Option(help="Import only this much [s].", min=0.0)] = None,
    known_map: Annotated[
        bool, typer.Option("--known-map", help="Give modules the positions of the landmarks.")
    ] = False,
    deskew: Annotated[
        bool, typer.Option("--deskew", help="Move the beams of a bag's scans to where the lidar was at the last one.")
    ] = False,
    distance_noise: Annotated[
        float | None, typer.Option(help="Odometry noise of distance [m/sqrt(m)].", min=0.0)
    ] = None,
    turn_noise: Annotated[float | None, typer.Option(help="Odometry noise of turns [rad/sqrt(rad)].", min=0.0)] = None,
    veer_noise: Annotated[
        float | None, typer.Option(help="Odometry noise of heading over distance [rad/sqrt(m)].", min=0.0)
    ] = None,
    range_noise: Annotated[float | None, typer.Option(help="Range noise of sightings [m].", min=1e-6)] = None,
    bearing_noise_deg: Annotated[float | None, typer.Option(help="Bearing noise of sightings.", min=1e-6)] = None,
    noise: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Noise and bias, as written by `mjsim calibrate -o`.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Convert a real robot's log to a recording.

    The format is detected from its files.
    """
    from mjsim.logs import Wishes, listed
    from mjsim.logs import import_log as recorded
    from mjsim.record import require_recording_name

    require_recording_name(output)
    motion = {"distance": distance_noise, "turn": turn_noise, "veer": veer_noise}
    options = Wishes(
        rate_hz=rate,
        begin=begin,
        seconds=seconds,
        robots=robot or (),
        topics=_topics(topic or ()),
        known_map=known_map,
        deskew=deskew,
        motion={name: value for name, value in motion.items() if value is not None},
        range_noise=range_noise,
        bearing_noise=None if bearing_noise_deg is None else math.radians(bearing_noise_deg),
    )
    if noise is not None:
        options = options.measured_by(noise)
    with tracked(f"import {source.name}", total=100.0, unit="%") as advance:
        recording = recorded(source, wishes=options, record=output, progress=advance, overwrite=overwrite)
    for line in listed(recording):
        say(line)
    print(output)


def calibrate(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A log with ground truth, or a recording.")],
    output: Annotated[
        Path | None, typer.Option("-o", metavar="NOISE.yaml", help="Write noise and bias to this file.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Estimate noise and bias from a log with ground truth.

    Print those of odometry and sightings.
    """
    from mjsim.logs import calibrate as calibrated
    from mjsim.logs import write_noise
    from mjsim.output import require_free

    if output is not None:
        require_free(output, overwrite=overwrite)
    found = calibrated(log)
    for name, each in found.items():
        for line in _lines(name, each):
            print(line)
    if output is not None:
        write_noise(output, found, overwrite=overwrite)


def _lines(name: str, found: "Calibration") -> Iterator[str]:
    """Yield the lines printed about a robot."""
    if (m := found.motion) is not None:
        yield (
            f"{name} odometry: distance {100 * (m.scale - 1):+.1f} %, noise {m.distance:.3f} m/sqrt(m);"
            f" turn {math.degrees(m.turn_bias):+.3f} deg/s, noise {m.turn:.3f} rad/sqrt(rad);"
            f" delay {m.delay:+.2f} s; {m.windows} windows"
        )
    if (s := found.sightings) is not None:
        yield (
            f"{name} sightings: range {s.range_bias:+.3f} m, noise {s.range:.3f} m;"
            f" bearing {math.degrees(s.bearing_bias):+.2f} deg, noise {math.degrees(s.bearing):.2f} deg;"
            f" {s.count} sightings, {s.outliers} outliers"
        )


def _topics(words: Sequence[str]) -> dict[str, list[str]]:
    """Return the topics to read, by kind of data."""
    topics: dict[str, list[str]] = {}
    for word in words:
        kind, equals, topic = word.partition("=")
        if not equals or not topic:
            raise UsageError(f"--topic is '{word}'; it must be KIND=TOPIC, such as odometry=/odom")
        topics.setdefault(kind, []).append(topic)
    return topics
