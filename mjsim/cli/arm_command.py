"""The command `arm`: an arm's table, its limits, and a picture of it."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.cli.page_access import addresses_on_signal, has_screen, how_to_get_another
from mjsim.cli.robot_from import XacroArgument, pairs
from mjsim.errors import UsageError
from mjsim.output import require_free
from mjsim.progress import say

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mjsim.geometry import Array
    from mjsim.mechanics import Arm, Link

HEAD = ("joint", "theta", "d", "a", "alpha", "range", "speed", "torque", "mass", "gear")
HEAD_OF_MODEL = ("joint", "name", "on", "at", "axis", *HEAD[5:])
UNITS_OF_MODEL = ("", "", "", "m", "", "deg, m", "deg/s, m/s", "N m, N", "kg", "")
UNITS = ("", "deg", "m", "m", "deg", "deg, m", "deg/s, m/s", "N m, N", "kg", "")


def arm(
    name: Annotated[
        str,
        typer.Argument(metavar="PRESET|FILE", help="A preset such as puma560, YAML with `dh`, MJCF, URDF or xacro."),
    ],
    joints: Annotated[
        str | None,
        typer.Option(metavar="Q1,Q2,...", help="Joint values [deg, m]; default: the start position."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Plot the arm to a PNG, SVG or PDF file.")] = None,
    end: Annotated[
        str | None, typer.Option(metavar="NAME", help="Body or site of the MJCF or URDF model that carries the tool.")
    ] = None,
    arg: XacroArgument = None,
    drive: Annotated[
        bool, typer.Option("--drive", help="Move joints and tool with sliders in the browser, until Ctrl-C.")
    ] = False,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser; print the address.")] = False,
    overwrite: Overwrite = False,
) -> None:
    """Print the joints of an arm, and the pose of its tool.

    With options, plot the arm, or move it in the browser.
    """
    import numpy as np

    from mjsim.world import arm_item

    arguments = pairs(arg or (), "--arg NAME=VALUE")
    item = arm_item(name, end, arguments)
    found = item.arm
    q = np.array(item.start()) if joints is None else _values(joints, found)
    if plot is not None:
        require_free(plot, overwrite=overwrite)
    if item.model is None:
        print(f"{found.name}: {found.n} joints, {found.convention} convention")
        print(_table([HEAD, UNITS, *(_row(number, link) for number, link in enumerate(found.links, start=1))]))
    else:
        _print_model(name, found, (*item.file_arm.changed, *item.file_arm.notes))
    print(f"at {_shown(q, found)}: tool at {_tool(found.fkine(q))}")
    if plot is not None:
        from mjsim.output import write_file

        write_file(plot, _picture(found, q, plot), overwrite=overwrite)
        print(plot)
    if drive:
        drive_arm(name, end, arguments, no_browser=no_browser)


def drive_arm(name: str, end: str | None, arguments: "Mapping[str, str]", *, no_browser: bool) -> None:
    """Simulate an arm alone, in real time, on a page that moves it."""
    from contextlib import suppress

    from mjsim.session import Session
    from mjsim.web import LiveView
    from mjsim.world import arm_world

    world = arm_world(name, end, arguments)
    with LiveView(world) as page, addresses_on_signal(lambda: page.url):

        def print_address() -> None:
            say(f"open {page.url} to move the arm; this address works once{how_to_get_another()}; Ctrl-C stops")

        session = Session(world, speed=1.0, on_tick=page.show, on_change=page.changed)
        page.steer(session)
        if no_browser or not has_screen():
            print_address()
        else:
            say(f"opening {page.address} in your browser; Ctrl-C stops")
            page.open(failed=print_address)
        # This is the intended way to end it.
        with suppress(KeyboardInterrupt), session:
            session.result()


def _values(text: str, arm: "Arm") -> "Array":
    """Return the values of joints that somebody typed [rad, m]."""
    import numpy as np

    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != arm.n or not all(map(math.isfinite, values)):
        raise UsageError(f"--joints is '{text}'; give {arm.n} numbers separated by commas")
    return np.array([v if link.slide else math.radians(v) for v, link in zip(values, arm.links, strict=True)])


def _print_model(name: str, arm: "Arm", notes: "Sequence[str]") -> None:
    """Print the table of an arm from a file: axes at joint values 0, in the frame of the file, instead of DH rows."""
    import numpy as np

    flange = f"flange on link{arm.carrier + 1}"
    print(f"{name}: {arm.n} joints, {flange}")
    posture = arm.posture(np.zeros(arm.n))
    rows = []
    for number, link in enumerate(arm.links):
        parent = f"link{arm.parents[number] + 1}" if arm.parents[number] >= 0 else "base"
        at, axis = (
            ", ".join(f"{value + 0.0:.4g}" for value in np.round(values[number], 9))
            for values in (posture.points, posture.axes)
        )
        rows.append((*_kind(number + 1, link), link.label, parent, at, axis, *_limits(link)))
    print(_table([HEAD_OF_MODEL, UNITS_OF_MODEL, *rows]))
    for note in notes:
        print(f"note: {note}")


def _row(number: int, link: "Link") -> tuple[str, ...]:
    theta, d, a, alpha = link.dh or (math.nan,) * 4
    dh = (f"{value:.6g}" for value in (math.degrees(theta), d, a, math.degrees(alpha)))
    return (*_kind(number, link), *dh, *_limits(link))


def _kind(number: int, link: "Link") -> tuple[str]:
    return (f"{number} {'slides' if link.slide else 'turns'}",)


def _limits(link: "Link") -> tuple[str, ...]:
    scale = 1.0 if link.slide else 180.0 / math.pi
    limited = math.isfinite(link.lower) or math.isfinite(link.upper)
    return (
        f"{link.lower * scale:.6g} .. {link.upper * scale:.6g}" if limited else "-",
        *(f"{value:.4g}" if math.isfinite(value) else "-" for value in (link.max_velocity * scale, link.max_torque)),
        f"{link.mass:.4g}",
        f"{link.gear:.6g}",
    )


def _table(rows: list[tuple[str, ...]]) -> str:
    """Return lines with columns aligned to the right."""
    lines, widths = rows, [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.rjust, line, widths)).rstrip() for line in lines)


def _shown(q: "Array", arm: "Arm") -> str:
    pairs = zip(q.tolist(), arm.links, strict=True)
    return ", ".join(f"{value:g} m" if link.slide else f"{math.degrees(value):g} deg" for value, link in pairs)


def _tool(pose: "Array") -> str:
    """Return a pose as place [m], and roll, pitch and yaw about fixed axes [deg]."""
    from mjsim.mechanics import rpy_of

    x, y, z = (f"{value + 0.0:.4f}" for value in pose[:3, 3])
    turned = ", ".join(f"{math.degrees(angle) + 0.0:.2f}" for angle in rpy_of(pose))
    return f"{x}, {y}, {z} m; roll, pitch, yaw {turned} deg"


def _picture(arm: "Arm", q: "Array", path: Path) -> bytes:
    import io

    kind = path.suffix.lower().lstrip(".")
    if kind not in ("png", "svg", "pdf"):
        raise UsageError(f"'{path}' is not a picture; its name must end in .png, .svg or .pdf")
    data = io.BytesIO()
    arm.plot(q).savefig(data, format=kind, dpi=120)
    return data.getvalue()
