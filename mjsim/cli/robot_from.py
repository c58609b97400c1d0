"""`mjsim new --robot-from`: a robot preset from the manufacturer's file."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from mjsim.errors import UsageError
from mjsim.output import require_free, write_files
from mjsim.progress import say

RobotFrom = Annotated[
    Path | None, typer.Option(metavar="FILE", help="URDF, xacro, SDF or MJCF of a robot; -o names the preset.")
]
LeftWheel = Annotated[list[str] | None, typer.Option(metavar="JOINT", help="Joint of a left wheel; may be repeated.")]
RightWheel = Annotated[list[str] | None, typer.Option(metavar="JOINT", help="Joint of a right wheel; may be repeated.")]
Steering = Annotated[list[str] | None, typer.Option(metavar="JOINT", help="A steering joint; may be repeated.")]
DriveKind = Annotated[
    str | None,
    typer.Option(
        metavar="KIND", help="Kind of drive: differential, skid_steer, ackermann, tricycle, mecanum or omni3."
    ),
]
Forward = Annotated[
    str | None, typer.Option(metavar="AXIS", help="Forward direction of the robot in its file: +x, -x, +y or -y.")
]
Model = Annotated[str | None, typer.Option(metavar="NAME", help="The robot in an SDF file with several.")]
Package = Annotated[
    list[str] | None, typer.Option(metavar="NAME=DIR", help="Folder of a ROS package; may be repeated.")
]
XacroArgument = Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help="xacro argument; may be repeated.")]
XacroVariable = Annotated[
    list[str] | None,
    typer.Option("--env", metavar="NAME=VALUE", help="Environment variable that xacro may read; may be repeated."),
]


@dataclass(frozen=True, slots=True)
class RobotArguments:
    """Options of the command for a robot."""

    left: Sequence[str]
    right: Sequence[str]
    steering: Sequence[str]
    drive: str | None
    forward: str | None
    model: str | None
    packages: Sequence[str]
    arguments: Sequence[str]
    environment: Sequence[str]


def write_robot(path: Path, output: Path | None, options: RobotArguments, *, overwrite: bool) -> None:
    """Write the preset of a robot, with its model in a folder beside it, and print a report.

    Raises:
        UsageError: The file cannot be converted, or an output file exists.
    """
    from mjsim.exchange import RobotOptions, bring_robot

    if output is None or output.suffix not in (".yaml", ".yml"):
        raise UsageError("a robot needs a preset file; name it with -o ROBOT.yaml")
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", output.stem).strip("_-") or "robot"
    packages = {key: _folder(key, value) for key, value in pairs(options.packages, "--package NAME=DIR").items()}
    require_free(output, overwrite=overwrite)
    brought = bring_robot(
        path,
        name=name,
        options=RobotOptions(
            left=options.left,
            right=options.right,
            steering=options.steering,
            drive=options.drive,
            forward=options.forward,
            model=options.model or "",
        ),
        packages=packages,
        arguments=pairs(options.arguments, "--arg NAME=VALUE"),
        environment=pairs(options.environment, "--env NAME=VALUE"),
    )
    for line in brought.report:
        say(line)
    files = {output.name: brought.text.encode(), **brought.files}
    write_files(output.parent, files, overwrite=overwrite)
    print(output)


def pairs(words: Sequence[str], option: str) -> Mapping[str, str]:
    """Return the names and values of an option that may be repeated."""
    pairs = {}
    for word in words:
        name, sign, value = word.partition("=")
        if not sign or not name:
            raise UsageError(f"'{word}' is not {option.partition(' ')[2]}; write {option}")
        pairs[name] = value
    return pairs


def _folder(name: str, value: str) -> Path:
    if not Path(value).is_dir():
        raise UsageError(f"no folder '{value}' for package '{name}'; write --package {name}=DIR")
    return Path(value)
