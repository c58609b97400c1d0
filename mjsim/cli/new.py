"""The command `new`: worlds from maps, drawings, mazes and templates, and robots from manufacturers' files."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mjsim.cli.robot_from import (
    DriveKind,
    Forward,
    LeftWheel,
    Model,
    Package,
    RightWheel,
    RobotArguments,
    RobotFrom,
    Steering,
    XacroArgument,
    XacroVariable,
    write_robot,
)
from mjsim.errors import UsageError
from mjsim.output import require_free, write_file, write_files
from mjsim.progress import say

if TYPE_CHECKING:
    from mjsim.exchange import Brought, Reading
    from mjsim.world import Use

MapFile = Annotated[
    Path | None,
    typer.Option(
        "--from",
        metavar="FILE",
        help="Map (.yaml, image), drawing (.svg, .dxf), MATLAB data (.mat, .m), scene (.world, .sdf, .wbt, MJCF .xml).",
    ),
]
MazeSize = Annotated[str | None, typer.Option(metavar="9x9", help="A maze with this many cells.")]
RoomSize = Annotated[str | None, typer.Option(metavar="12x10", help="A cluttered room of this size [m].")]
BarnNumber = Annotated[
    int | None, typer.Option(metavar="N", help="World N of the BARN benchmark, 1 to 299, except multiples of 6.")
]
TemplateName = Annotated[
    str | None, typer.Option(metavar="NAME", help="A shipped world: office, corridor, empty or gallery.")
]
NewFile = Annotated[
    Path | None, typer.Option("-o", metavar="WORLD.yaml", help="File to write; default: standard output.")
]
Replace = Annotated[bool, typer.Option("--overwrite", "--force", help="Replace an existing file.")]
RobotPreset = Annotated[
    str | None, typer.Option(metavar="PRESET", help="Robot to place in the world; default: pioneer3dx.")
]
LidarName = Annotated[
    str | None, typer.Option(metavar="NAME", help="Lidar of the robot: lds-01, lds-02, hokuyo-ust-10lx, sick-lms111.")
]
EstimatorSpec = Annotated[
    str | None,
    typer.Option(metavar="SPEC", help="Estimator of the robot: monte_carlo, lidar_slam, or module:Class{key: value}."),
]
Seed = Annotated[int, typer.Option(help="Seed of the maze or the clutter.", min=0)]
CellSide = Annotated[float, typer.Option(help="Cell size of the maze [m].")]
MarkerCount = Annotated[int, typer.Option(help="Number of markers along the robot's path through the maze.", min=0)]
UnitLength = Annotated[
    float | None,
    typer.Option(help="Metres per unit of a drawing or landmark map, or per pixel of an image.", min=1e-6),
]
WallThickness = Annotated[
    float | None, typer.Option(help="Thickness of walls in a drawing [m]; default: as drawn.", min=0.01)
]
WallLayers = Annotated[
    list[str] | None, typer.Option(metavar="NAME", help="Layer of the drawing with walls; may be repeated.")
]
FurnitureRule = Annotated[
    Literal["keep", "drop"], typer.Option(help="Whether furniture in a drawing becomes obstacles.")
]
TableRows = Annotated[
    bool,
    typer.Option(
        "--rows", help="Read a MATLAB table as one item per row where both are possible; default: per column."
    ),
]
WithoutRobot = Annotated[bool, typer.Option("--no-robot", help="Do not add a robot.")]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Options:
    """Options for the new world: its source and its robot."""

    source: Path | None
    maze: str | None
    clutter: str | None
    barn: int | None
    template: str | None
    output: Path | None
    robot: str | None
    lidar: str | None
    estimator: str | None
    no_robot: bool

    def __post_init__(self) -> None:
        equipped = self.lidar is not None or self.estimator is not None
        if sum(value is not None for value in (self.source, self.maze, self.clutter, self.barn, self.template)) != 1:
            raise UsageError(
                "a world has one source; give exactly one of --from FILE, --maze 9x9, --clutter 12x10,"
                " --barn N, --template NAME, --robot-from FILE"
            )
        if self.template is not None and (self.robot is not None or self.no_robot):
            raise UsageError("a template already has a robot; change it in the new file")
        if self.source is None and equipped:
            raise UsageError("--lidar and --estimator are for worlds from maps and drawings; use them with --from FILE")
        if self.no_robot and equipped:
            raise UsageError("--lidar and --estimator need a robot; leave out --no-robot")

    def preset(self) -> str | None:
        """Return the preset of the robot; None for no robot."""
        usual = "pioneer3dx" if self.barn is None else "jackal"
        return None if self.no_robot else _preset(self.robot or usual, self.folder)

    @property
    def is_usual(self) -> bool:
        """Whether the robot is entirely the default one."""
        return self.robot is self.lidar is self.estimator is None

    @property
    def folder(self) -> Path:
        """Folder of the new world."""
        return _folder(self.output)


def new(
    source: MapFile = None,
    maze: MazeSize = None,
    clutter: RoomSize = None,
    barn: BarnNumber = None,
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
    rows: TableRows = False,
    no_robot: WithoutRobot = False,
    robot_from: RobotFrom = None,
    left_wheel: LeftWheel = None,
    right_wheel: RightWheel = None,
    steering: Steering = None,
    drive: DriveKind = None,
    forward: Forward = None,
    model: Model = None,
    package: Package = None,
    arg: XacroArgument = None,
    env: XacroVariable = None,
) -> None:
    """Create a world or a robot.

    Create a world from a robot's map, a drawing, a maze, a cluttered room, a benchmark or a template, or a robot from
    the file of its manufacturer.
    """
    if robot_from is not None:
        if any(value is not None for value in (source, maze, clutter, barn, template, robot)):
            raise UsageError("--robot-from creates the preset of a robot; create the world with a separate command")
        arguments = RobotArguments(
            left_wheel or (),
            right_wheel or (),
            steering or (),
            drive,
            forward,
            model,
            package or (),
            arg or (),
            env or (),
        )
        write_robot(robot_from, output, arguments, overwrite=overwrite)
        return
    options = _Options(
        source=source,
        maze=maze,
        clutter=clutter,
        barn=barn,
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

        models = None if output is None else f"{output.stem}_models"
        reading = Reading(scale, thickness, layer or (), furniture == "keep", rows, folder=models)
        brought = _from_file(source, options, reading)
    else:
        brought = _made(options, seed=seed, cell=cell, beacons=beacons)
    _write(brought, output, overwrite=overwrite)


def _from_file(source: Path, options: _Options, reading: "Reading") -> "Brought":
    from mjsim.exchange import Newcomer, bring_file

    preset = options.preset()
    use = None if options.estimator is None else _estimator(options.estimator, options.output)
    robot = None if preset is None else Newcomer(preset, options.lidar, use, options.folder, is_usual=options.is_usual)
    return bring_file(source, robot=robot, reading=reading)


def _made(options: _Options, *, seed: int, cell: float, beacons: int) -> "Brought":
    """Return a world that needs no source file: a maze, a cluttered room, or a template."""
    from mjsim.exchange import bring_barn, bring_clutter, bring_maze, bring_template, name_of

    name = None if options.output is None else name_of(options.output)
    if options.maze is not None:
        preset, folder = options.preset(), options.folder
        return bring_maze(options.maze, preset=preset, seed=seed, cell=cell, beacons=beacons, name=name, folder=folder)
    if options.clutter is not None:
        return bring_clutter(options.clutter, preset=options.preset(), seed=seed, name=name, folder=options.folder)
    if options.barn is not None:
        return bring_barn(options.barn, preset=options.preset(), name=name, folder=options.folder)
    assert options.template is not None
    return bring_template(options.template, name=name)


def _write(brought: "Brought", output: Path | None, *, overwrite: bool) -> None:
    """Print the report, and write or print the world."""
    for line in brought.report:
        say(line)
    if output is None:
        if brought.files:
            raise UsageError("the world has models of its own, in a folder beside it; name its file with -o WORLD.yaml")
        print(brought.text, end="")
    elif brought.files:
        write_files(output.parent, {output.name: brought.text.encode(), **brought.files}, overwrite=overwrite)
        print(output)
    else:
        print(write_file(output, brought.text.encode(), overwrite=overwrite))


def _folder(output: Path | None) -> Path:
    """Return the folder of the new world."""
    return (output or Path("world.yaml")).resolve().parent


def _preset(name: str, folder: Path) -> str:
    """Return the name of a shipped robot preset, or the path of a preset file relative to the folder of the world.

    Raises:
        UsageError: The preset does not exist, or its file is outside the folder of the world.
    """
    from mjsim.errors import did_you_mean
    from mjsim.world import preset_names

    if name.endswith((".yaml", ".yml")):
        place = Path(name).resolve()
        if not place.is_file():
            raise UsageError(f"no file '{name}'; name a file written by mjsim new --robot-from, or a preset")
        if not place.is_relative_to(folder):
            raise UsageError(f"'{name}' must be in the folder of the new world, '{folder}'; move one of them")
        return place.relative_to(folder).as_posix()
    if name not in preset_names():
        raise UsageError(f"no preset '{name}'{did_you_mean(name, preset_names())}")
    return name


def _estimator(spec: str, output: Path | None) -> "Use":
    """Return the module that a text names, as the new world will name it; the class is loaded only to check it.

    Raises:
        UsageError: The module does not exist, or its file is outside the folder of the world.
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
