"""The commands that write recordings: `run` and `replay`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mjsim.cli.arguments import Overwrite, RunFile, Settings, WorldFile, recorded
from mjsim.cli.page_access import addresses_on_signal, how_to_get_another
from mjsim.cli.recordings import film
from mjsim.errors import UsageError
from mjsim.output import NewFile, require_free
from mjsim.progress import say, show, tracked

if TYPE_CHECKING:
    from mjsim.record import Recording, Tick
    from mjsim.world import World


def run(
    world: WorldFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", metavar="RUN.mcap", help="Recording to write; default: out/NAME/run.mcap, or the next free name."
        ),
    ] = None,
    seconds: Annotated[float | None, typer.Option(help="Duration, in simulated seconds.", min=0.0)] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of all random numbers of the run.", min=0)] = None,
    video: Annotated[Path | None, typer.Option(metavar="MP4", help="Also make a video, after the run.")] = None,
    live: Annotated[bool, typer.Option("--live", help="Watch and steer the run in a browser.")] = False,
    realtime: Annotated[bool, typer.Option("--realtime", help="Run no faster than real time.")] = False,
    overwrite: Overwrite = False,
    settings: Settings = None,
) -> None:
    """Run a world and record it."""
    from mjsim.modules import hosting, load_runnable, notes_on
    from mjsim.run import drivers_of
    from mjsim.run import run as run_loop
    from mjsim.sim import Simulation
    from mjsim.toolbox import figures_told
    from mjsim.world import with_settings

    _check_outputs(output, video, overwrite=overwrite)
    checked = with_settings(load_runnable(world), settings or ())
    for note in notes_on(checked):
        show(str(note))
    duration = checked.run.seconds if seconds is None else seconds
    with (
        hosting(),
        _recording_of(checked, output, overwrite=overwrite) as place,
        figures_told(checked.run, place.path, overwrite=overwrite, tell=print),
    ):
        if live:
            recording = _run_live(checked, place, seed=seed, seconds=duration, speed=1.0 if realtime else None)
        else:
            drivers = drivers_of(checked)
            with Simulation(checked, seed=seed) as sim:
                _bake_first(checked, sim.model)
                with tracked(f"run {checked.name}", total=duration, unit="s") as advance:
                    recording = run_loop(
                        sim,
                        drivers=drivers,
                        seconds=duration,
                        record=place,
                        watch=lambda _: advance(sim.time + sim.dt),
                        realtime=realtime,
                        progress=False,
                    )
    print(place.path)
    if video is not None:
        film(recording, video, overwrite=overwrite)


def _bake_first(world: "World", model: Any) -> None:
    """Put the light that cameras show into the cache, so that its progress does not mix with that of the run."""
    from mjsim.light import light_of
    from mjsim.sim import choose_backend
    from mjsim.world import Camera

    if any(isinstance(sensor, Camera) for robot in world.robots for sensor in robot.sensors):
        choose_backend()  # Fails early if there is none, before the time that baking takes.
        light_of(world, model)


def replay(
    recording: RunFile,
    output: Annotated[Path, typer.Option("-o", metavar="RUN2.mcap", help="The recording to write.")],
    robot: Annotated[
        str | None, typer.Option(metavar="R", help="The robot whose observations are replayed, if there are several.")
    ] = None,
    estimator: Annotated[
        str | None,
        typer.Option(metavar="SPEC", help="module:Class or file.py:Class, with arguments in braces: {key: value}."),
    ] = None,
    trajectory: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Estimates of another program: TUM, KITTI, g2o, or a ROS bag with poses."),
    ] = None,
    topic: Annotated[str | None, typer.Option(help="Topic of a bag with the trajectory.")] = None,
    offset: Annotated[float | None, typer.Option(help="Added to the times of the trajectory [s].")] = None,
    period: Annotated[float | None, typer.Option(help="Time between two poses of KITTI or g2o [s].", min=1e-6)] = None,
    observer: Annotated[
        str | None, typer.Option(metavar="SPEC", help="Observer to run; default: use the recorded sightings.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Run another estimator on a recording's observations."""
    from mjsim.modules import hosting, module_of
    from mjsim.record import require_recording_name
    from mjsim.run import observed_robot
    from mjsim.run import replay as replay_run
    from mjsim.toolbox import figures_told

    require_recording_name(output)
    require_free(output, overwrite=overwrite, source=recording)
    run = recorded(recording)
    robot = observed_robot(run, robot)
    spec = _estimator(estimator, trajectory, run, {"topic": topic, "offset": offset, "period": period})
    believes, use = module_of(spec, role="estimator", robot=robot)
    if (check := getattr(believes, "require_pose_at", None)) is not None:  # of `mjsim.logs.Trajectory`
        check(float(run.time[0]))
    observing, uses = None, {"estimator": use}
    if observer is not None:
        observing, uses["observer"] = module_of(observer, role="observer", robot=robot)
    with (
        hosting(),
        figures_told((estimator, observer), output, overwrite=overwrite, tell=print),
        tracked(f"replay {recording.name}", total=float(run.time[-1]), unit="s") as advance,
    ):
        replay_run(
            run,
            robot=robot,
            estimator=believes,
            observer=observing,
            record=output,
            uses=uses,
            progress=advance,
            overwrite=overwrite,
        )
    print(output)


def _estimator(spec: str | None, trajectory: Path | None, run: "Recording", keys: dict[str, Any]) -> str:
    """Return the estimator to replay: the named one, or one that returns the poses in a file at the run's times."""
    if (spec is None) == (trajectory is None):
        raise UsageError("a replay has one estimator; give --estimator SPEC or --trajectory FILE")
    if trajectory is None:
        assert spec is not None, "one of them is given"
        if given := [f"--{key}" for key, value in keys.items() if value is not None]:
            raise UsageError(f"{' and '.join(given)}: for trajectories only; give --trajectory FILE")
        return spec
    import json

    from mjsim.logs import listed_notes, offset_to_run
    from mjsim.progress import say

    notes: dict[str, str] = {}
    offset = offset_to_run(trajectory, run, **keys, notes=notes)
    for line in listed_notes(notes):
        say(line)
    keys = {"file": str(trajectory.absolute()), **keys, "offset": offset}
    return f"mjsim.logs.trajectory:Trajectory{json.dumps(keys)}"


def _check_outputs(output: Path | None, video: Path | None, *, overwrite: bool) -> None:
    """Refuse an output that cannot be written before the run, not after it."""
    if output is not None:
        from mjsim.record import require_recording_name

        require_recording_name(output)
        require_free(output, overwrite=overwrite)
    if video is not None:
        from mjsim.video import require_film_name

        require_film_name(video)
        require_free(video, overwrite=overwrite)


def _recording_of(world: "World", output: Path | None, *, overwrite: bool) -> NewFile:
    """Reserve and return the file of the recording: as given, else the default of the world or the next free name."""
    from mjsim.record import reserve, reserve_next

    path = output or Path("out") / world.name / "run.mcap"
    return reserve_next(path) if output is None and not overwrite else reserve(path, overwrite=overwrite)


def _run_live(world: "World", place: NewFile, *, seed: int | None, seconds: float, speed: float | None) -> "Recording":
    """Run a world in a session that a page shows and steers; return the recording."""
    from mjsim.record import read_recording
    from mjsim.session import Session
    from mjsim.web import LiveView

    with LiveView(world) as page, addresses_on_signal(lambda: page.url):
        say(f"open {page.url} to watch; this address works once{how_to_get_another()}")
        with tracked(f"run {world.name}", total=seconds, unit="s") as advance:

            def watch(tick: "Tick") -> None:
                advance(tick.time + 1.0 / world.run.rate_hz)
                page.show(tick)

            with Session(
                world, seed=seed, seconds=seconds, record=place, speed=speed, on_tick=watch, on_change=page.changed
            ) as session:
                page.steer(session)
                session.result()
                path = session.record or place.path
    return read_recording(path)
