"""The command `import-log`: the log of a real robot -> a recording."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.errors import UsageError
from mjsim.progress import say, tracked


def import_log(
    source: Annotated[
        Path,
        typer.Argument(metavar="LOG", help="Of MRCLAM, Victoria Park, TUM RGB-D, CARMEN; a ROS bag; tables in YAML."),
    ],
    output: Annotated[Path, typer.Option("-o", metavar="RUN.mcap", help="The recording to write.")],
    robot: Annotated[list[str] | None, typer.Option(metavar="R", help="Of MRCLAM or a bag; may be repeated.")] = None,
    topic: Annotated[list[str] | None, typer.Option(metavar="KIND=TOPIC", help="Of a bag; may be repeated.")] = None,
    rate: Annotated[float | None, typer.Option(help="Ticks a second.", min=0.1, max=250)] = None,
    begin: Annotated[float, typer.Option(help="Leave so much of the beginning out [s].", min=0.0)] = 0.0,
    seconds: Annotated[float | None, typer.Option(help="Take so much of it [s].", min=0.0)] = None,
    known_map: Annotated[bool, typer.Option("--known-map", help="Modules know where landmarks are.")] = False,
    distance_noise: Annotated[float | None, typer.Option(help="Of odometry [m/sqrt(m)].", min=0.0)] = None,
    turn_noise: Annotated[float | None, typer.Option(help="Of odometry [rad/sqrt(rad)].", min=0.0)] = None,
    veer_noise: Annotated[float | None, typer.Option(help="Of odometry [rad/sqrt(m)].", min=0.0)] = None,
    range_noise: Annotated[float | None, typer.Option(help="Of a sighting [m].", min=1e-6)] = None,
    bearing_noise_deg: Annotated[float | None, typer.Option(help="Of a sighting.", min=1e-6)] = None,
    overwrite: Overwrite = False,
) -> None:
    """Make a recording of a real robot's log; which kind it is, its files tell."""
    from mjsim.logs import Wishes
    from mjsim.logs import import_log as recorded

    motion = {"distance": distance_noise, "turn": turn_noise, "veer": veer_noise}
    wishes = Wishes(
        rate_hz=rate,
        begin=begin,
        seconds=seconds,
        robots=robot or (),
        topics=_topics(topic or ()),
        known_map=known_map,
        motion={name: value for name, value in motion.items() if value is not None},
        range_noise=range_noise,
        bearing_noise=None if bearing_noise_deg is None else math.radians(bearing_noise_deg),
    )
    with tracked(f"import {source.name}", total=100.0, unit="%") as advance:
        recording = recorded(source, wishes=wishes, record=output, progress=advance, overwrite=overwrite)
    for fact, value in recording.metadata.items():
        if "left out" in fact and value != "0":
            say(f"{fact}: {value}")
    print(output)


def _topics(words: Sequence[str]) -> dict[str, list[str]]:
    """Return what is read -> the topics that it is read from."""
    topics: dict[str, list[str]] = {}
    for word in words:
        kind, equals, topic = word.partition("=")
        if not equals or not topic:
            raise UsageError(f"--topic is '{word}'; it must be KIND=TOPIC, such as odometry=/odom")
        topics.setdefault(kind, []).append(topic)
    return topics
