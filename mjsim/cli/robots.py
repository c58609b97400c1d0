"""`mjsim new --robot-from`: the preset of a robot from its maker's file."""

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
    Path | None, typer.Option(metavar="FILE", help="A robot's URDF, xacro or MJCF, made a preset with -o.")
]
LeftWheel = Annotated[list[str] | None, typer.Option(metavar="JOINT", help="A wheel to its left; may be repeated.")]
RightWheel = Annotated[list[str] | None, typer.Option(metavar="JOINT", help="A wheel to its right; may be repeated.")]
Steering = Annotated[list[str] | None, typer.Option(metavar="JOINT", help="A joint that steers; may be repeated.")]
DriveKind = Annotated[
    str | None, typer.Option(metavar="KIND", help="How it drives: differential, skid_steer or ackermann.")
]
Forward = Annotated[str | None, typer.Option(metavar="AXIS", help="Where it looks in its file: +x, -x, +y or -y.")]
Package = Annotated[
    list[str] | None, typer.Option(metavar="NAME=DIR", help="Folder of a ROS package; may be repeated.")
]
XacroArgument = Annotated[
    list[str] | None, typer.Option(metavar="NAME=VALUE", help="Argument of xacro; may be repeated.")
]


@dataclass(frozen=True, slots=True)
class Wished:
    """What the options of the command say of a robot."""

    left: Sequence[str]
    right: Sequence[str]
    steering: Sequence[str]
    drive: str | None
    forward: str | None
    packages: Sequence[str]
    arguments: Sequence[str]


def write_robot(path: Path, output: Path | None, wished: Wished, *, overwrite: bool) -> None:
    """Write the preset of a robot, its model in a folder beside it, and say what was found.

    Raises:
        UsageError: It cannot be made, or a file exists.
    """
    from mjsim.exchange import RobotOptions, bring_robot

    if output is None or output.suffix not in (".yaml", ".yml"):
        raise UsageError("a robot has files of its own; name the preset with -o ROBOT.yaml")
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", output.stem).strip("_-") or "robot"
    packages = {key: _folder(key, value) for key, value in _pairs(wished.packages, "--package NAME=DIR").items()}
    require_free(output, overwrite=overwrite)
    brought = bring_robot(
        path,
        name=name,
        options=RobotOptions(
            left=wished.left,
            right=wished.right,
            steering=wished.steering,
            drive=wished.drive,
            forward=wished.forward,
        ),
        packages=packages,
        arguments=_pairs(wished.arguments, "--arg NAME=VALUE"),
    )
    for line in brought.report:
        say(line)
    files = {output.name: brought.text.encode(), **brought.files}
    write_files(output.parent, files, overwrite=overwrite)
    print(output)


def _pairs(words: Sequence[str], option: str) -> Mapping[str, str]:
    pairs = {}
    for word in words:
        name, sign, value = word.partition("=")
        if not sign or not name:
            raise UsageError(f"'{word}' is no {option.partition(' ')[2]}; write {option}")
        pairs[name] = value
    return pairs


def _folder(name: str, value: str) -> Path:
    if not Path(value).is_dir():
        raise UsageError(f"no folder '{value}' for package '{name}'; write --package {name}=DIR")
    return Path(value)
