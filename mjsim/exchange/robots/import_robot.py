"""Converts a robot's file to a preset, with a report of all values found, guessed, measured and repaired."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from mjsim.errors import MjsimError, PhysicsFault, UsageError
from mjsim.exchange.robots.driven_wheels import Gear, find_gear
from mjsim.exchange.robots.listing import SIZES, amiss, kept, summary
from mjsim.exchange.robots.measure import Measured, measure
from mjsim.exchange.robots.mounts import find_mounts
from mjsim.exchange.robots.omni import without_rollers
from mjsim.exchange.robots.preset import (
    ACCELERATION,
    ROLLER_DRIVES,
    Plan,
    first_plan,
    preset_text,
)
from mjsim.exchange.robots.robot_frame import Stand, find_stand
from mjsim.exchange.robots.robot_import import BroughtRobot, RobotOptions
from mjsim.exchange.robots.robot_source import RobotSource
from mjsim.exchange.robots.slip import learned, rolled
from mjsim.inventory import inventory
from mjsim.models import Anatomy, Given, RobotFiles, anatomy_of, gather_robot, robot_text
from mjsim.world import Slip

SDF = (".sdf", ".world")
"""Endings of files of Gazebo."""
MARGIN = 1.2
"""Acceleration that the robot must withstand without tipping, as a multiple of the largest commanded one."""
MIN_DIAMETER, MAX_DIAMETER = 0.02, 20.0
"""Smallest and largest diameter of accepted robots [m]."""
MECANUM_WHEELS = 4
"""Number of mecanum wheels."""
MAX_ITERATIONS = 4
"""Maximum number of measuring runs, each with the result of the previous one."""
MAX_ODOMETRY_ERROR = 0.0003
"""Maximum relative error of odometry after calibration, in distance and in turn."""


def bring_robot(
    path: Path,
    *,
    name: str,
    options: RobotOptions,
    packages: Mapping[str, Path],
    arguments: Mapping[str, str],
    environment: Mapping[str, str] | None = None,
    search: Sequence[Path] = (),
) -> BroughtRobot:
    """Return the preset of a robot from a URDF, xacro, SDF or MJCF file.

    Args:
        path: The file.
        name: Name of the robot, and of the folder of its files.
        options: What the file leaves open.
        packages: Folders of ROS packages by name.
        arguments: Arguments of xacro.
        environment: Values of `$(env NAME)` in xacro; the variables of this process are not read.
        search: Folders in which the user keeps ROS packages.

    Raises:
        UsageError: The file cannot be read, its wheels are missing or ambiguous, or the robot does not drive.
        PhysicsFault: The simulation became unstable.
    """
    given = Given(arguments, environment or {})
    source = RobotSource(path, packages=packages, given=given, search=search, model=options.model)
    try:
        robot = gather_robot(source.name, source.read, up_axis=path.suffix.lower() not in SDF)
    except ValueError as error:
        raise UsageError(source.described(error)) from None
    anatomy = anatomy_of(robot)
    gear = _gear(source, robot, anatomy, options, path)
    # Rollers belong to their wheels: they are neither casters nor fixed joints.
    anatomy, _ = without_rollers(anatomy)
    stand = find_stand(anatomy, gear, acceleration=MARGIN * ACCELERATION)
    _check_size(path, stand)
    mounts, dropped = find_mounts(anatomy, stand, robot.sensors)
    model = f"{name}/robot.{'urdf' if robot.files.urdf else 'xml'}"
    files = {model: robot_text(robot.files).encode()}
    files |= {f"{name}/{flat}": data for flat, data in robot.files.assets.items()}
    plan = first_plan(name, model, gear, stand, mounts)
    items = [*kept(anatomy, plan), *amiss(source, robot, anatomy, plan), *dropped, *source.unused()]
    plan, measured = _calibrated(plan, files, path)
    report = [summary(path, robot, anatomy, stand, sdf=source.sdf), *_driven(measured, plan)]
    plan, found = _as_driven(plan, files, path, anatomy, robot)
    report += [*found, *inventory(items)]
    about = [line.replace(str(path), path.name) for line in report]  # comments name no folder of this machine
    origin = f"From {path.name}, by `mjsim new --robot-from`; worlds name this file as a preset."
    return BroughtRobot(preset_text(plan, [origin, *about]), files, report)


def _gear(source: RobotSource, robot: RobotFiles, anatomy: Anatomy, options: RobotOptions, path: Path) -> Gear:
    """Return how a robot drives.

    Raises:
        UsageError: Its wheels are missing or ambiguous, or it has no shapes.
    """
    try:
        said = [*source.drives(), *robot.drives]
        gear = find_gear(anatomy, options, file=str(path), urdf=robot.files.urdf, said=said)
        gear = moved_sideways(gear, anatomy, robot, options, file=str(path))
    except UsageError as error:
        raise UsageError(source.placed(str(error)) + _perhaps_missing(source, robot)) from None
    if not anatomy.shapes:
        gone = inventory(item for item in robot.items if "mesh" in item.kind)
        raise UsageError(f"{path}: no part of it has a shape; {'; '.join(gone) or 'give its links visual shapes'}")
    return gear


def moved_sideways(gear: Gear, anatomy: Anatomy, robot: RobotFiles, options: RobotOptions, *, file: str) -> Gear:
    """Return four wheels as mecanum wheels if only a plugin of the file or their controller declares them so.

    Args:
        gear: The gear found without the plugin.
        anatomy: Contents of the file.
        robot: The file.
        options: What the user specified; a drive is left as it is.
        file: Name of the file in messages.
    """
    moves = f"'{robot.sideways}' moves it" if robot.sideways else f"{gear.said.sideways} move it"
    if (
        options.drive is not None
        or not (robot.sideways or gear.said.sideways)
        or gear.drive != "skid_steer"
        or len(gear.wheels()) != MECANUM_WHEELS
    ):
        return gear
    found = find_gear(anatomy, replace(options, drive="mecanum"), file=file, urdf=robot.files.urdf, said=[gear.said])
    note = f"its wheels are mecanum, as {moves}; --drive skid_steer makes them plain"
    return replace(found, notes=(*found.notes, note))


def _perhaps_missing(source: RobotSource, robot: RobotFiles) -> str:
    """Return what to add to an error about the wheels of a robot whose meshes or included files are missing."""
    if source.missing:
        name = min(source.missing)
        return f"; package '{name}', which may show them, was not found: give --package {name}=DIR"
    if any(item.kind == "missing mesh" for item in robot.items):
        return "; meshes that may show them are missing"
    return f"; an include that may declare them is missing: {source.absent[0][1]}" if source.absent else ""


def _check_size(path: Path, stand: Stand) -> None:
    """Raise UsageError for a robot too large or too small to drive indoors: its file uses other units."""
    across = 2 * stand.radius
    if not MIN_DIAMETER <= across <= MAX_DIAMETER:
        allowed = f"{MIN_DIAMETER} to {MAX_DIAMETER:g} m"
        raise UsageError(
            f"{path}: the robot is {across:.3g} m across; it must be {allowed}, with lengths in metres in its file"
        )


def _calibrated(plan: Plan, files: Mapping[str, bytes], path: Path) -> tuple[Plan, Measured]:
    """Return a plan whose odometry matches the measured drives, and the last measurement."""
    for _ in range(MAX_ITERATIONS):
        measured = _measured(plan, files, path)
        if all(abs(ratio - 1.0) < MAX_ODOMETRY_ERROR for ratio in (measured.distance, measured.turn, measured.strafe)):
            break
        plan = plan.measured(distance=measured.distance, turn=measured.turn, strafe=measured.strafe)
    return plan, measured


def _as_driven(
    plan: Plan, files: Mapping[str, bytes], path: Path, anatomy: Anatomy, robot: RobotFiles
) -> tuple[Plan, list[str]]:
    """Return a plan that models the slip of its drive, and notes."""
    drive = plan.gear.drive
    if drive in ROLLER_DRIVES:
        return _rolling(plan, files, path)
    if drive == "skid_steer":
        return _slipping(plan, files, path, anatomy, robot)
    return _steering(plan, files, path) if drive == "ackermann" else (plan, [])


def _rolling(plan: Plan, files: Mapping[str, bytes], path: Path) -> tuple[Plan, list[str]]:
    """Return a plan that models the sideways and turning slip of a robot on rollers while it drives, and notes."""
    strafe, spin = rolled(preset_text(plan, ()), files, file=str(path))
    plan = plan.measured(distance=1.0, turn=spin, strafe=strafe)
    return plan, [
        f"measured: over drives in all directions it goes {plan.strafe:.4f} m sideways, and turns {plan.spin:.4f} rad,"
        " per unit of wheel odometry"
    ]


def _slipping(
    plan: Plan, files: Mapping[str, bytes], path: Path, anatomy: Anatomy, robot: RobotFiles
) -> tuple[Plan, list[str]]:
    """Return a plan that models how a skid-steered robot turns and slips on arcs of all kinds, and notes.

    Its tyres slip by more than all noise of a good robot, and by a different amount for each robot; its centre of
    rotation depends on its centre of mass.
    """
    found = learned(preset_text(plan, ()), files, file=str(path))
    stand = find_stand(anatomy, plan.gear, acceleration=MARGIN * ACCELERATION, ahead=found.center)
    mounts, _ = find_mounts(anatomy, stand, robot.sensors)
    plan = replace(plan.measured(distance=1.0, turn=found.turn), stand=stand, mounts=mounts, slip=found.slip)
    side = "ahead of" if found.center > 0 else "behind"
    return plan, [
        f"measured: it turns about a point {abs(found.center):.3f} m {side} the middle of its wheels, its origin",
        f"measured: over {found.drives} drives of 20 s on arcs of all kinds it turns as with a track of"
        f" {plan.track:.5f} m, and slips {_inline_slip(found.slip)}",
    ]


def _steering(plan: Plan, files: Mapping[str, bytes], path: Path) -> tuple[Plan, list[str]]:
    """Return a plan that models the slip of a car while it steers, if it exceeds the usual amount, and notes."""
    found = learned(preset_text(plan, ()), files, file=str(path))
    slip = Slip(**{name: max(usual, getattr(found.slip, name)) for name, usual in Slip()})
    if slip == Slip():
        return plan, []
    note = f"measured: over {found.drives} drives of 20 s on arcs of all kinds it slips {_inline_slip(found.slip)}"
    return replace(plan, slip=slip), [note]


def _inline_slip(slip: Slip) -> str:
    """Return the components of a slip in the form of `odometry: {tyres: ...}`."""
    return ", ".join(f"{name} {value:.3g}" for name, value in slip)


def _measured(plan: Plan, files: Mapping[str, bytes], path: Path) -> Measured:
    try:
        return measure(preset_text(plan, ()), files, file=str(path))
    except UsageError:
        raise
    except PhysicsFault as error:
        raise PhysicsFault(f"{path}: {error}") from None
    except MjsimError as error:
        raise UsageError(f"{path}: {' '.join(str(error).splitlines()[:1])}") from None


def _driven(measured: Measured, plan: Plan) -> list[str]:
    """Return notes on what was measured."""
    manner = "on the spot" if measured.on_spot else "on circles"
    a, b, c, d = measured.ahead, measured.back, measured.left, measured.right
    sideways = [f"{drive.driven:+.4f} m for {drive.odometry:+.4f} m" for drive in measured.sideways]
    return [
        f"measured: {a.driven:+.4f} m for {a.odometry:+.4f} m of odometry,"
        f" {b.driven:+.4f} m for {b.odometry:+.4f} m back",
        f"measured: {c.driven:+.4f} rad for {c.odometry:+.4f} rad {manner},"
        f" {d.driven:+.4f} rad for {d.odometry:+.4f} rad",
        *([f"measured: {sideways[0]} to the left, {sideways[1]} to the right"] if sideways else []),
        f"so its odometry computes with wheels of {plan.wheel_radius:.5f} m and"
        f" {SIZES.get(plan.gear.drive, 'a track')} of {plan.track:.5f} m",
    ]
