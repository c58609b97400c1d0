"""The command `bridge`: runs a world and connects its robots to ROS 2."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite, Settings, WorldFile
from mjsim.errors import UsageError
from mjsim.output import require_free
from mjsim.progress import say


def bridge(
    world: WorldFile,
    output: Annotated[Path | None, typer.Option("-o", metavar="RUN.mcap", help="Also record the run.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Duration, in simulated seconds.", min=0.0)] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of all random numbers of the run.", min=0)] = None,
    speed: Annotated[float, typer.Option(help="Simulated seconds per second of real time.", min=0.01)] = 1.0,
    interface: Annotated[
        str | None, typer.Option(metavar="NAME", help="Network interface or its address; default: loopback.")
    ] = None,
    private: Annotated[
        bool, typer.Option("--private", help="Use a network that no other user of this machine can reach (Linux).")
    ] = False,
    modules: Annotated[
        bool, typer.Option("--modules", help="Let the world's own modules drive while no commands arrive.")
    ] = False,
    watchdog: Annotated[
        float, typer.Option(metavar="S", help="Time after its last command at which a robot stops [s].")
    ] = 0.5,
    no_namespace: Annotated[
        bool, typer.Option("--no-namespace", help="Omit the name of the only robot: /scan, /odom, /cmd_vel.")
    ] = False,
    no_map: Annotated[
        bool, typer.Option("--no-map", help="Do not publish /map, if slam_toolbox or a map server does.")
    ] = False,
    paused: Annotated[bool, typer.Option("--paused", help="Pause after the first tick; services still work.")] = False,
    overwrite: Overwrite = False,
    settings: Settings = None,
) -> None:
    """Run a world and connect its robots to ROS 2.

    No ROS installation is needed.
    """
    # Do this before NumPy is imported: the kernel moves only processes with a single thread.
    network = _private(interface) if private else interface or "loopback, open to all users of this machine"

    from mjsim.bridge import Bridge
    from mjsim.modules import hosting, load_runnable
    from mjsim.record import require_recording_name, reserve
    from mjsim.world import with_settings

    if output is not None:
        require_recording_name(output)
        require_free(output, overwrite=overwrite)
    checked = with_settings(load_runnable(world), settings or ())
    place = nullcontext() if output is None else reserve(output, overwrite=overwrite)
    with (
        hosting(),
        place as record,
        Bridge(
            checked,
            seed=seed,
            seconds=seconds,
            speed=speed,
            modules=modules,
            watchdog=watchdog,
            record=record,
            overwrite=overwrite,
            interface=interface,
            namespaces=not no_namespace,
            publish_map=not no_map,
        ) as live,
    ):
        robots = ", ".join(live.robots) or "no robots"
        say(f"ROS 2, domain {live.domain}: {robots}; {network}; Ctrl-C stops")
        live.start(paused=paused)
        live.session.result()
    if output is not None:
        print(output)


def _private(interface: str | None) -> str:
    """Enter a private network; return a message about it."""
    from mjsim.bridge import enter_private_network

    if interface is not None:
        raise UsageError("a private network has no other interfaces; leave out --interface or --private")
    return f"private network; to join it: {enter_private_network()} COMMAND"
