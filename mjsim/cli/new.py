"""The command `new`: worlds from maps, drawings, mazes and templates, and robots from their makers' files."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mjsim.cli.robots import (
    DriveKind,
    Forward,
    LeftWheel,
    Package,
    RightWheel,
    RobotFrom,
    Steering,
    Wished,
    XacroArgument,
    write_robot,
)
from mjsim.errors import UsageError
from mjsim.output import require_free, write_file
from mjsim.progress import say

if TYPE_CHECKING:
    from mjsim.exchange import Brought, Reading
    from mjsim.world import Use

MapFile = Annotated[
    Path | None,
    typer.Option(
        "--from", metavar="FILE", help="A map's YAML file or picture, an SVG or DXF drawing, a landmark map (.mat)."
    ),
]
MazeSize = Annotated[str | None, typer.Option(metavar="9x9", help="A maze of so many cells.")]
RoomSize = Annotated[str | None, typer.Option(metavar="12x10", help="A room of so many metres, full of things.")]
TemplateName = Annotated[
    str | None, typer.Option(metavar="NAME", help="A shipped world: office, corridor, empty or gallery.")
]
NewFile = Annotated[Path | None, typer.Option("-o", metavar="WORLD.yaml", help="The file; printed unless given.")]
Replace = Annotated[bool, typer.Option("--overwrite", "--force", help="Replace a file that exists.")]
RobotPreset = Annotated[
    str | None, typer.Option(metavar="PRESET", help="Which robot is put into it; the pioneer3dx unless given.")
]
LidarName = Annotated[
    str | None, typer.Option(metavar="NAME", help="A lidar for it: lds-01, lds-02, hokuyo-ust-10lx, sick-lms111.")
]
EstimatorSpec = Annotated[
    str | None,
    typer.Option(
        metavar="SPEC", help="How it finds out where it is: monte_carlo, lidar_slam, or module:Class{key: value}."
    ),
]
Seed = Annotated[int, typer.Option(help="Of the maze or the things.", min=0)]
CellSide = Annotated[float, typer.Option(help="Side of a cell of the maze [m].")]
MarkerCount = Annotated[int, typer.Option(help="Markers along the robot's way through the maze.", min=0)]
UnitLength = Annotated[
    float | None,
    typer.Option(help="Metres to one unit of a drawing or a landmark map, to a pixel of a picture.", min=1e-6),
]
WallThickness = Annotated[
    float | None, typer.Option(help="Of walls in a drawing [m]; as the lines are drawn unless given.", min=0.01)
]
WallLayers = Annotated[
    list[str] | None, typer.Option(metavar="NAME", help="Layer of the drawing that holds walls; may be repeated.")
]
FurnitureRule = Annotated[
    Literal["keep", "drop"], typer.Option(help="Whether furniture of a drawing becomes obstacles.")
]
WithoutRobot = Annotated[bool, typer.Option("--no-robot", help="Leave the robot out.")]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wanted:
    """What the options say of the new world: what it is made from, and its robot."""

    source: Path | None
    maze: str | None
    clutter: str | None
    template: str | None
    output: Path | None
    robot: str | None
    lidar: str | None
    estimator: str | None
    no_robot: bool

    def __post_init__(self) -> None:
        equipped = self.lidar is not None or self.estimator is not None
        if sum(value is not None for value in (self.source, self.maze, self.clutter, self.template)) != 1:
            raise UsageError(
                "a world is made from one thing; give one of --from FILE, --maze 9x9, --clutter 12x10,"
                " --template NAME, --robot-from FILE"
            )
        if self.template is not None and (self.robot is not None or self.no_robot):
            raise UsageError("a template has a robot of its own; change it in the new file")
        if self.source is None and equipped:
            raise UsageError("--lidar and --estimator are for worlds from maps and drawings; they go with --from FILE")
        if self.no_robot and equipped:
            raise UsageError("--lidar and --estimator need a robot; leave out --no-robot")

    def preset(self) -> str | None:
        """Return the preset of its robot; None for no robot."""
        return None if self.no_robot else _preset(self.robot or "pioneer3dx", self.folder)

    @property
    def folder(self) -> Path:
        """In which the world will be."""
        return _folder(self.output)


def new(
    source: MapFile = None,
    maze: MazeSize = None,
    clutter: RoomSize = None,
    template: TemplateName = None,
    output: NewFile = None,
    overwrite: Replace = False,
    robot: RobotPreset = None,
    lidar: LidarName = None,
    estimator: EstimatorSpec = None,
    seed: Seed = 1,
    cell: CellSide = 1.5,
    beacons: MarkerCount = 0,
    scale: UnitLength = None,
    thickness: WallThickness = None,
    layer: WallLayers = None,
    furniture: FurnitureRule = "keep",
    no_robot: WithoutRobot = False,
    robot_from: RobotFrom = None,
    left_wheel: LeftWheel = None,
    right_wheel: RightWheel = None,
    steering: Steering = None,
    drive: DriveKind = None,
    forward: Forward = None,
    package: Package = None,
    arg: XacroArgument = None,
) -> None:
    """Write a new world: from the map of a robot or a drawing, a maze, a cluttered room, a template; or a robot."""
    if robot_from is not None:
        if any(value is not None for value in (source, maze, clutter, template, robot)):
            raise UsageError("--robot-from makes the preset of a robot; bring the world with a command of its own")
        wished = Wished(left_wheel or (), right_wheel or (), steering or (), drive, forward, package or (), arg or ())
        write_robot(robot_from, output, wished, overwrite=overwrite)
        return
    wanted = _Wanted(
        source=source,
        maze=maze,
        clutter=clutter,
        template=template,
        output=output,
        robot=robot,
        lidar=lidar,
        estimator=estimator,
        no_robot=no_robot,
    )
    if output is not None:
        require_free(output, overwrite=overwrite)
    if source is not None:
        from mjsim.exchange import Reading

        brought = _from_file(source, wanted, Reading(scale, thickness, layer or (), furniture == "keep"))
    else:
        brought = _made(wanted, seed=seed, cell=cell, beacons=beacons)
    _write(brought, output, overwrite=overwrite)


def _from_file(source: Path, wanted: _Wanted, reading: "Reading") -> "Brought":
    from mjsim.exchange import Newcomer, bring_file

    preset = wanted.preset()
    use = None if wanted.estimator is None else _estimator(wanted.estimator, wanted.output)
    robot = None if preset is None else Newcomer(preset, wanted.lidar, use, wanted.folder)
    return bring_file(source, robot=robot, reading=reading)


def _made(wanted: _Wanted, *, seed: int, cell: float, beacons: int) -> "Brought":
    """Return a world that is made from no file: a maze, a cluttered room, or a template."""
    from mjsim.exchange import bring_clutter, bring_maze, bring_template, name_of

    name = None if wanted.output is None else name_of(wanted.output)
    if wanted.maze is not None:
        preset, folder = wanted.preset(), wanted.folder
        return bring_maze(wanted.maze, preset=preset, seed=seed, cell=cell, beacons=beacons, name=name, folder=folder)
    if wanted.clutter is not None:
        return bring_clutter(wanted.clutter, preset=wanted.preset(), seed=seed, name=name, folder=wanted.folder)
    assert wanted.template is not None
    return bring_template(wanted.template, name=name)


def _write(brought: "Brought", output: Path | None, *, overwrite: bool) -> None:
    """Say what was found, and write the world, or print it."""
    for line in brought.report:
        say(line)
    if output is None:
        print(brought.text, end="")
    else:
        print(write_file(output, brought.text.encode(), overwrite=overwrite))


def _folder(output: Path | None) -> Path:
    """Return the folder in which the new world will be."""
    return (output or Path("world.yaml")).resolve().parent


def _preset(name: str, folder: Path) -> str:
    """Return the name of a robot that comes with mjsim, or the path of the file of one from the folder of the world.

    Raises:
        UsageError: There is none such, or a world in this folder cannot name it.
    """
    from mjsim.errors import did_you_mean
    from mjsim.world import preset_names

    if name.endswith((".yaml", ".yml")):
        place = Path(name).resolve()
        if not place.is_file():
            raise UsageError(f"no file '{name}'; name what mjsim new --robot-from wrote, or a preset")
        if not place.is_relative_to(folder):
            raise UsageError(f"'{name}' must be in the folder of the new world, '{folder}'; move one of them")
        return place.relative_to(folder).as_posix()
    if name not in preset_names():
        raise UsageError(f"no preset '{name}'{did_you_mean(name, preset_names())}")
    return name


def _estimator(spec: str, output: Path | None) -> "Use":
    """Return the module that a text names, written as the new world names it; it is looked at, not kept.

    Raises:
        UsageError: There is none such, or a world at this place cannot name its file.
    """
    from mjsim.exchange import ESTIMATORS
    from mjsim.modules import module_of

    name, brace, rest = spec.partition("{")
    if ":" not in name and name.strip() not in ESTIMATORS:
        known = ", ".join(ESTIMATORS)
        raise UsageError(f"no estimator '{name:.60}'; write {known}, module:Class or file.py:Class")
    _, use = module_of(ESTIMATORS.get(name.strip(), name) + brace + rest, role="estimator", robot="scout")
    place, _, called = use.use.rpartition(":")
    if not place.endswith(".py"):
        return use
    folder = _folder(output)
    if not Path(place).resolve().is_relative_to(folder):
        raise UsageError(f"'{place}' must be in the folder of the new world, '{folder}'; move one of them")
    return use.model_copy(update={"use": f"{Path(place).resolve().relative_to(folder)}:{called}"})
