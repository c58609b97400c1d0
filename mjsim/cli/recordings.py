"""The commands that turn a recording into something else: `video` and `export`."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mjsim.cli.arguments import Begin, End, Overwrite, RunFile
from mjsim.errors import UsageError
from mjsim.output import require_free
from mjsim.progress import tracked

if TYPE_CHECKING:
    from mjsim.record import Recording


def video(
    recording: RunFile,
    output: Annotated[Path, typer.Option("-o", metavar="MP4", help="The film to write.")],
    view: Annotated[
        str | None, typer.Option(help="One view alone: plan, chase, overview, diagrams, ROBOT/CAMERA.")
    ] = None,
    follow: Annotated[str | None, typer.Option(help="What the close-up follows: truth, estimate, nothing.")] = None,
    sightings: Annotated[bool | None, typer.Option(help="Lines to what is seen.")] = None,
    ellipses: Annotated[bool | None, typer.Option(help="95 % ellipses.")] = None,
    trails: Annotated[bool | None, typer.Option(help="Trails of the robot.")] = None,
    begin: Begin = None,
    end: End = None,
    overwrite: Overwrite = False,
) -> None:
    """Draw the film of a recording."""
    from mjsim.record import read_recording
    from mjsim.video import make_video

    require_free(output, overwrite=overwrite)
    draw = partial(make_video, view=view, follow=follow, sightings=sightings, ellipses=ellipses, trails=trails)
    film(read_recording(recording), output, draw=draw, begin=begin, end=end, overwrite=overwrite)


def export(
    recording: RunFile,
    tum: Annotated[Path | None, typer.Option(metavar="DIR", help="Trajectories for evo.")] = None,
    csv: Annotated[Path | None, typer.Option(metavar="DIR", help="Tables.")] = None,
    npz: Annotated[Path | None, typer.Option(metavar="FILE", help="Arrays for NumPy.")] = None,
    mat: Annotated[Path | None, typer.Option(metavar="FILE", help="Arrays for Matlab and Octave.")] = None,
    images: Annotated[Path | None, typer.Option(metavar="DIR", help="The onboard pictures.")] = None,
    rosbag2: Annotated[Path | None, typer.Option(metavar="DIR", help="A bag of ROS 2.")] = None,
    storage: Annotated[Literal["mcap", "sqlite3"], typer.Option(help="Of the bag.")] = "mcap",
    tum_rgbd: Annotated[Path | None, typer.Option(metavar="DIR", help="TUM RGB-D, a data set a camera.")] = None,
    euroc: Annotated[Path | None, typer.Option(metavar="DIR", help="EuRoC, a data set a robot.")] = None,
    carmen: Annotated[Path | None, typer.Option(metavar="FILE", help="A log of CARMEN, one a robot.")] = None,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw pictures again without loss, for a bag, TUM RGB-D and EuRoC.")
    ] = False,
    overwrite: Overwrite = False,
) -> None:
    """Write a recording in other formats."""
    from mjsim.record import export_csv, export_images, export_mat, export_npz, export_tum, read_recording

    wanted: tuple[tuple[Callable[..., object], Path | None], ...] = (
        *((export_tum, tum), (export_csv, csv), (export_npz, npz), (export_mat, mat), (export_images, images)),
        *_data_sets(rosbag2, storage, tum_rgbd, euroc, carmen, redraw=redraw),
    )
    if all(place is None for _, place in wanted):
        raise UsageError(
            "nothing to export; name at least one of --tum, --csv, --npz, --mat, --images, --rosbag2, --tum-rgbd,"
            " --euroc, --carmen"
        )
    for file in (npz, mat, carmen):
        if file is not None:
            require_free(file, overwrite=overwrite, source=recording)
    read = read_recording(recording)
    for write, place in wanted:
        if place is not None:
            write(read, place, overwrite=overwrite)
            print(place)


def _data_sets(
    rosbag2: Path | None,
    storage: Literal["mcap", "sqlite3"],
    tum_rgbd: Path | None,
    euroc: Path | None,
    carmen: Path | None,
    *,
    redraw: bool,
) -> tuple[tuple[Callable[..., object], Path | None], ...]:
    """Return what writes each data set, and where to; nothing is loaded for those that are not wanted."""
    if (rosbag2, tum_rgbd, euroc, carmen) == (None,) * 4:
        return ()
    from mjsim.datasets import export_carmen, export_euroc, export_rosbag2, export_tum_rgbd

    return (
        (partial(export_rosbag2, storage=storage, redraw=redraw), rosbag2),
        (partial(export_tum_rgbd, redraw=redraw), tum_rgbd),
        (partial(export_euroc, redraw=redraw), euroc),
        (export_carmen, carmen),
    )


def film(
    recording: "Recording",
    path: Path,
    *,
    draw: Callable[..., None] | None = None,
    begin: float | None = None,
    end: float | None = None,
    overwrite: bool = False,
) -> None:
    """Draw the film of a recording and print its path.

    Args:
        recording: What is shown.
        path: The film.
        draw: `make_video` with its options; that of the world's own view unless given.
        begin: Only what was from this time on [s].
        end: Only what was until this time [s].
        overwrite: Whether the film may replace a file.
    """
    from mjsim.video import frames_between, make_video

    count = len(frames_between(recording, begin, end))
    with tracked(f"video {path.name}", total=count, unit="frames") as advance:
        (draw or make_video)(recording, path, begin=begin, end=end, progress=advance, overwrite=overwrite)
    print(path)
