"""The command line: arguments in, one call, text out. Results go to stdout, everything for people to stderr."""

import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mjsim import exchange_cli, experiments_cli, logs_cli, replay_cli, report_cli, studio_cli, sweep_cli
from mjsim.errors import MjsimError, UsageError, WorldError
from mjsim.progress import say, tracked

if TYPE_CHECKING:
    from mjsim.record import Recording, Tick
    from mjsim.world import World

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""

app = typer.Typer(
    name="mjsim",
    help="A simulator for navigation and SLAM of indoor wheeled robots, with real camera pictures.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

app.command("new")(exchange_cli.new)
app.command("export-world")(exchange_cli.export_world)
app.command("sweep")(sweep_cli.sweep)
app.command("replay")(replay_cli.replay)
app.command("import-log")(logs_cli.import_log)
app.command("experiments")(experiments_cli.experiments)
app.command("report")(report_cli.report)
app.command("compare")(report_cli.compare)
app.command("studio")(studio_cli.studio)

WorldFile = Annotated[Path, typer.Argument(metavar="WORLD", help="A world file.")]
RunFile = Annotated[Path, typer.Argument(metavar="RUN.mcap", help="A recording.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a value: robots.scout.odometry.scale=1.1")
]


@app.command()
def doctor(
    output: Annotated[Path, typer.Option("-o", help="Where the test picture goes.")] = Path("out/doctor.png"),
) -> None:
    """Tell which OpenGL backend works, take a test picture, measure pictures a second."""
    from mjsim.doctor import diagnose, report_lines

    diagnosis = diagnose(output)
    print(*report_lines(diagnosis), sep="\n")
    if diagnosis.backend is None:
        raise typer.Exit(1)


@app.command()
def check(worlds: Annotated[list[Path], typer.Argument(metavar="WORLD...", help="World files.")]) -> None:
    """Say everything that is wrong with world files; nothing when all is well."""
    from mjsim.world import load_checked
    from mjsim.world.things import ModelObstacle

    failed = False
    for path in worlds:
        try:
            world = load_checked(path)
            if any(isinstance(obstacle, ModelObstacle) for obstacle in world.obstacles):
                from mjsim.compile import check_models

                check_models(world)
        except (WorldError, UsageError) as error:
            print(error, file=sys.stderr)
            failed = True
    if failed:
        raise typer.Exit(2)


@app.command()
def fmt(
    worlds: Annotated[list[Path], typer.Argument(metavar="WORLD...", help="World files.")],
    check: Annotated[
        bool, typer.Option("--check", help="Change nothing; exit with 1 when a file would change.")
    ] = False,
) -> None:
    """Lay world files out anew, every value and comment kept; names those that change."""
    from mjsim.world.formatter import format_file

    code = 0
    for path in worlds:
        try:
            if format_file(path, write=not check):
                print(path)
                code = max(code, 1 if check else 0)
        except (WorldError, UsageError) as error:
            print(error, file=sys.stderr)
            code = 2
    if code:
        raise typer.Exit(code)


@app.command()
def compile(
    world: WorldFile, output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder of scene.xml and assets.")]
) -> None:
    """Write the scene as MJCF with its assets; plain MuJoCo loads it."""
    from mjsim.compile import export_scene
    from mjsim.world import load_checked

    print(export_scene(load_checked(world), output))


@app.command()
def show(
    world: WorldFile,
    output: Annotated[Path, typer.Option("-o", metavar="PNG", help="The picture to write.")],
    camera: Annotated[
        str | None,
        typer.Option("--camera", "--view", help="Instead of the plan: ROBOT/CAMERA, ROBOT/chase or overview."),
    ] = None,
) -> None:
    """Draw the plan of a world to be printed, or what a camera sees at the start."""
    from mjsim.video import draw_world, take_picture
    from mjsim.world import load_checked

    checked = load_checked(world)
    if camera is None:
        draw_world(checked, output)
    else:
        take_picture(checked, camera, output)
    print(output)


@app.command()
def run(
    world: WorldFile,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="RUN.mcap", help="out/NAME/run.mcap unless given.")
    ] = None,
    seconds: Annotated[float | None, typer.Option(help="How long, simulated.", min=0.0)] = None,
    seed: Annotated[int | None, typer.Option(help="Of all chance in the run.", min=0)] = None,
    video: Annotated[Path | None, typer.Option(metavar="MP4", help="Also draw the video, after the run.")] = None,
    live: Annotated[bool, typer.Option("--live", help="Watch it in a browser while it runs.")] = False,
    realtime: Annotated[bool, typer.Option("--realtime", help="Go no faster than the clock.")] = False,
    settings: Settings = None,
) -> None:
    """Run a world and record it."""
    from mjsim.run import drivers_of
    from mjsim.run import run as run_loop
    from mjsim.sim import Simulation
    from mjsim.world import load_checked
    from mjsim.world.settings import with_settings

    checked = with_settings(load_checked(world), settings or ())
    if video is not None:
        from mjsim.video import require_film_name

        # Now, not after the run.
        require_film_name(video)
    path = output or Path("out") / checked.name / "run.mcap"
    duration = checked.run.seconds if seconds is None else seconds
    if live:
        recording = _run_live(checked, path, seed=seed, seconds=duration, speed=1.0 if realtime else None)
    else:
        drivers = drivers_of(checked)
        with (
            Simulation(checked, seed=seed) as sim,
            tracked(f"run {checked.name}", total=duration, unit="s") as advance,
        ):
            recording = run_loop(
                sim,
                drivers=drivers,
                seconds=duration,
                record=path,
                watch=lambda _: advance(sim.time + sim.dt),
                realtime=realtime,
            )
    print(path)
    if video is not None:
        _film(recording, video)


@app.command()
def video(
    recording: RunFile,
    output: Annotated[Path, typer.Option("-o", metavar="MP4", help="The film to write.")],
    view: Annotated[str | None, typer.Option(help="One view alone: plan, chase, overview or ROBOT/CAMERA.")] = None,
    follow: Annotated[str | None, typer.Option(help="Whom the close-up follows: truth, estimate, nothing.")] = None,
    sightings: Annotated[bool | None, typer.Option(help="Lines to what is seen.")] = None,
    ellipses: Annotated[bool | None, typer.Option(help="95 % ellipses.")] = None,
    trails: Annotated[bool | None, typer.Option(help="Trails of the robot.")] = None,
    begin: report_cli.Begin = None,
    end: report_cli.End = None,
) -> None:
    """Draw the film of a recording."""
    from mjsim.record import read_recording

    _film(
        read_recording(recording),
        output,
        view=view,
        follow=follow,
        sightings=sightings,
        ellipses=ellipses,
        trails=trails,
        begin=begin,
        end=end,
    )


@app.command()
def export(
    recording: RunFile,
    tum: Annotated[Path | None, typer.Option(metavar="DIR", help="Trajectories for evo.")] = None,
    csv: Annotated[Path | None, typer.Option(metavar="DIR", help="Tables.")] = None,
    npz: Annotated[Path | None, typer.Option(metavar="FILE", help="Arrays for NumPy.")] = None,
    mat: Annotated[Path | None, typer.Option(metavar="FILE", help="Arrays for Matlab and Octave.")] = None,
    images: Annotated[Path | None, typer.Option(metavar="DIR", help="The onboard pictures.")] = None,
) -> None:
    """Write a recording in other formats."""
    from mjsim.record import read_recording
    from mjsim.record.export import export_csv, export_images, export_mat, export_npz, export_tum

    wanted = ((export_tum, tum), (export_csv, csv), (export_npz, npz), (export_mat, mat), (export_images, images))
    if all(place is None for _, place in wanted):
        raise UsageError("nothing to export; name at least one of --tum, --csv, --npz, --mat, --images")
    read = read_recording(recording)
    for write, place in wanted:
        if place is not None:
            write(read, place)
            print(place)


@app.command()
def schema() -> None:
    """Print the JSON Schema of the world file, for completion in editors."""
    from mjsim.world import editor_schema

    print(json.dumps(editor_schema(), indent=1))


@app.command()
def bench(
    only: Annotated[list[str] | None, typer.Argument(metavar="[FIGURE]...", help="Figures to measure; all.")] = None,
    runs: Annotated[int, typer.Option(help="How often each is measured.", min=1)] = 5,
    peers: Annotated[bool, typer.Option("--peers", help="Measure ir-sim and PyBullet too.")] = False,
    cpu: Annotated[bool, typer.Option("--cpu", help="Processor time, for busy machines.")] = False,
) -> None:
    """Measure speeds on this machine: name, median, min, max, unit, runs; then what is asked of their ratios."""
    from mjsim.bench import measure

    for line in measure(only or (), runs=runs, peers=peers, clock=time.process_time if cpu else time.perf_counter):
        print(line, flush=True)


def _film(
    recording: "Recording",
    path: Path,
    *,
    view: str | None = None,
    follow: str | None = None,
    sightings: bool | None = None,
    ellipses: bool | None = None,
    trails: bool | None = None,
    begin: float | None = None,
    end: float | None = None,
) -> None:
    from mjsim.video import frames_between, make_video

    count = len(frames_between(recording, begin, end))
    with tracked(f"video {path.name}", total=count, unit="frames") as advance:
        make_video(
            recording,
            path,
            view=view,
            follow=follow,
            sightings=sightings,
            ellipses=ellipses,
            trails=trails,
            begin=begin,
            end=end,
            progress=advance,
        )
    print(path)


def _run_live(world: "World", path: Path, *, seed: int | None, seconds: float, speed: float | None) -> "Recording":
    """Run a world in a session that a page shows and steers; return what was recorded."""
    from mjsim.record import read_recording
    from mjsim.session import Session
    from mjsim.web import LiveView

    with LiveView(world) as page:
        say(f"watch it at {page.url}")
        with tracked(f"run {world.name}", total=seconds, unit="s") as advance:

            def watch(tick: "Tick") -> None:
                advance(tick.time + 1.0 / world.run.rate_hz)
                page.show(tick)

            with Session(
                world, seed=seed, seconds=seconds, record=path, speed=speed, on_tick=watch, on_change=page.changed
            ) as session:
                page.steer(session)
                session.result()
    return read_recording(path)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0, 2 for the user's mistake, 1 for a failed run, 130 when interrupted."""
    sys.exit(_exit_code(lambda: app(args=arguments, prog_name="mjsim", standalone_mode=False)))


def _exit_code(call: Callable[[], int | None]) -> int:
    try:
        code = call() or 0
    except typer.TyperException as error:
        # What was typed is wrong; without any command the message is the help.
        text = error.format_message()
        print(text if text.startswith("Usage") else f"mjsim: {text}", file=sys.stderr)
        return 2
    except MjsimError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    if code == INTERRUPTED:
        say("interrupted; what was recorded until then is closed and readable")
    return code


if __name__ == "__main__":
    main()
