"""The commands that convert recordings: `video` and `export`."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from mjsim.cli.arguments import Begin, End, Overwrite, RunFile, recorded
from mjsim.errors import UsageError
from mjsim.output import require_free
from mjsim.progress import tracked

if TYPE_CHECKING:
    from mjsim.record import Recording


def video(
    recording: RunFile,
    output: Annotated[
        Path, typer.Option("-o", metavar="FILE", help="The video, .mp4; with --at .svg, .pdf, .png or .jpg.")
    ],
    view: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="One view: plan, chase, overview, diagrams, ROBOT/CAMERA; --at: close-up."),
    ] = None,
    follow: Annotated[
        str | None, typer.Option(metavar="WHAT", help="What the close-up follows: truth, estimate or nothing.")
    ] = None,
    sightings: Annotated[bool | None, typer.Option(help="Draw lines to sighted beacons.")] = None,
    ellipses: Annotated[bool | None, typer.Option(help="Draw 95 % confidence ellipses.")] = None,
    trails: Annotated[bool | None, typer.Option(help="Draw true and estimated paths.")] = None,
    at: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Write this instant only, as a picture, SVG or PDF.")
    ] = None,
    theme: Annotated[Literal["light", "dark"], typer.Option(help="Colours of SVG and PDF.")] = "light",
    begin: Begin = None,
    end: End = None,
    overwrite: Overwrite = False,
) -> None:
    """Make a video of a recording, or a picture of one instant."""
    from mjsim.video import make_video, write_instant

    require_free(output, overwrite=overwrite)
    shown: dict[str, Any] = {"follow": follow, "sightings": sightings, "ellipses": ellipses, "trails": trails}
    if at is not None:
        if begin is not None or end is not None:
            raise UsageError("--at names one instant; leave out --from and --to")
        write_instant(recorded(recording), output, at, view=view, theme=theme, overwrite=overwrite, **shown)
        print(output)
        return
    draw = partial(make_video, view=view, **shown)
    film(recorded(recording), output, draw=draw, begin=begin, end=end, overwrite=overwrite)


def export(
    recording: RunFile,
    tum: Annotated[Path | None, typer.Option(metavar="DIR", help="Trajectories for evo.")] = None,
    csv: Annotated[Path | None, typer.Option(metavar="DIR", help="Tables as CSV.")] = None,
    npz: Annotated[Path | None, typer.Option(metavar="FILE", help="Arrays for NumPy.")] = None,
    mat: Annotated[Path | None, typer.Option(metavar="FILE", help="Arrays for MATLAB and Octave.")] = None,
    images: Annotated[Path | None, typer.Option(metavar="DIR", help="The pictures of the onboard cameras.")] = None,
    rosbag2: Annotated[Path | None, typer.Option(metavar="DIR", help="A ROS 2 bag.")] = None,
    storage: Annotated[Literal["mcap", "sqlite3"], typer.Option(help="Storage format of the bag.")] = "mcap",
    tum_rgbd: Annotated[Path | None, typer.Option(metavar="DIR", help="TUM RGB-D, one data set per camera.")] = None,
    euroc: Annotated[Path | None, typer.Option(metavar="DIR", help="EuRoC, one data set per robot.")] = None,
    carmen: Annotated[Path | None, typer.Option(metavar="FILE", help="CARMEN log, one file per robot.")] = None,
    redraw: Annotated[
        bool,
        typer.Option("--redraw", help="Render pictures again without compression loss, for bags, TUM RGB-D and EuRoC."),
    ] = False,
    overwrite: Overwrite = False,
) -> None:
    """Write a recording in other formats."""
    from mjsim.record import export_csv, export_images, export_mat, export_npz, export_tum

    requested: tuple[tuple[Callable[..., object], Path | None], ...] = (
        *((export_tum, tum), (export_csv, csv), (export_npz, npz), (export_mat, mat), (export_images, images)),
        *_data_sets(rosbag2, storage, tum_rgbd, euroc, carmen, redraw=redraw),
    )
    if all(place is None for _, place in requested):
        raise UsageError(
            "nothing to export; name at least one of --tum, --csv, --npz, --mat, --images, --rosbag2, --tum-rgbd,"
            " --euroc, --carmen"
        )
    for file in (npz, mat, carmen):
        if file is not None:
            require_free(file, overwrite=overwrite, source=recording)
    read = recorded(recording)
    for write, place in requested:
        if place is not None:
            made = write(read, place, overwrite=overwrite)
            # Files written per robot are printed one by one; for a folder, only the folder is.
            for path in made if isinstance(made, list) and not place.is_dir() else [place]:
                print(path)


def _data_sets(
    rosbag2: Path | None,
    storage: Literal["mcap", "sqlite3"],
    tum_rgbd: Path | None,
    euroc: Path | None,
    carmen: Path | None,
    *,
    redraw: bool,
) -> tuple[tuple[Callable[..., object], Path | None], ...]:
    """Return the exporter and destination of each data set; exporters are imported only if one is requested."""
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
    """Make a video of a recording and print its path.

    Args:
        recording: What is shown.
        path: The video.
        draw: `make_video` with its options; by default the view of the world file.
        begin: Start of the video in the recording [s].
        end: End of the video in the recording [s].
        overwrite: Whether the video may replace a file.
    """
    from mjsim.video import frames_between, make_video

    count = len(frames_between(recording, begin, end))
    with tracked(f"video {path.name}", total=count, unit="frames") as advance:
        (draw or make_video)(recording, path, begin=begin, end=end, progress=advance, overwrite=overwrite)
    print(path)
