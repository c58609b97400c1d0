"""Lists what was kept, guessed, repaired, added and left out of a robot's file."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

from mjsim.exchange.robots.driven_wheels import Gear
from mjsim.exchange.robots.mounts import SensorMount
from mjsim.exchange.robots.preset import Plan, max_speed, preset_turn, speed_source, stated_speed, track_of
from mjsim.exchange.robots.robot_frame import Stand
from mjsim.exchange.robots.robot_source import RobotSource
from mjsim.inventory import Fate, FileItem
from mjsim.models import Anatomy, Motors, RobotFiles, gyrations
from mjsim.sentences import number_of

KINDS = {
    "differential": "a differential drive",
    "skid_steer": "skid steering",
    "ackermann": "a car",
    "tricycle": "a tricycle",
    "mecanum": "mecanum wheels",
    "omni3": "three omni wheels",
}
SIZES = {"mecanum": "track and wheelbase together", "omni3": "a ring of wheels with a diameter"}
"""Names of the dimension that determines how far a robot turns."""
ANY_TORQUE = "wheels follow their speeds with any torque"
"""Why limits of torque are left out."""
BEYOND = 1.2
"""A radius of gyration that exceeds the reach of the shapes by this factor is impossible."""
SIZE_TOLERANCE = 0.02
"""Sizes of the file and of its plug-ins that differ by less than this fraction are equal."""


def summary(path: Path, robot: RobotFiles, anatomy: Anatomy, stand: Stand, *, sdf: bool = False) -> str:
    """Return the line about a file as a whole."""
    return (
        f"{path}: {'SDF' if sdf else 'URDF' if robot.files.urdf else 'MJCF'} of {anatomy.mass:.3g} kg,"
        f" {2 * stand.radius:.2f} m across, {stand.height:.2f} m high, {_counted(robot.files.assets)}"
    )


def kept(anatomy: Anatomy, plan: Plan) -> Iterator[FileItem]:
    """Yield the contents of a preset that come from its file, and those that are guessed."""
    gear, stand = plan.gear, plan.stand
    rows = [f"'{pair[0][0].name}' and '{pair[1][0].name}'" for pair in gear.rows]
    rows += [f"'{wheel.name}'" for wheel in gear.single]
    sizes = f"of radius {plan.wheel_radius:.4f} m, {SIZES.get(gear.drive, 'a track')} of {_own_track(plan):.4f} m"
    yield FileItem(Fate.KEPT, f"{KINDS[gear.drive]}: wheels {', '.join(rows)}, {sizes}")
    own = stand.casters[: len(stand.casters) - len(stand.notes)]  # those that are added come last
    if own:
        yield FileItem(Fate.KEPT, f"casters at {', '.join(f'[{x:.3f}, {y:.3f}]' for x, y, _ in own)}")
    for mount in plan.mounts:
        yield FileItem(Fate.KEPT, mount.kind, mount.name, _placed(mount))
    yield from _speeds(plan)
    for note in gear.notes:
        yield FileItem(Fate.GUESSED, note)
    yield FileItem(Fate.GUESSED, "noise of a good robot; change it in the preset")
    yield from _differing(plan)
    for joint in _held(anatomy, gear):
        yield FileItem(Fate.KEPT, "locked joint", joint, "only wheels move")


def _speeds(plan: Plan) -> Iterator[FileItem]:
    """Yield where the maximum speeds come from."""
    stated = stated_speed(plan.gear) is not None
    advice = "" if stated else "; change it in the preset"
    fate = Fate.KEPT if stated else Fate.GUESSED
    yield FileItem(
        fate, f"max_speed {max_speed(plan):g} m/s", why=speed_source(plan).removeprefix("a guess: ") + advice
    )
    said = plan.gear.said
    if said.max_turn is not None:
        yield FileItem(Fate.KEPT, f"max_turn {preset_turn(plan):g} deg/s", why=f"by {said.source}")
    if said.unused:
        yield FileItem(Fate.LEFT_OUT, ", ".join(said.unused), why=ANY_TORQUE)


def _differing(plan: Plan) -> Iterator[FileItem]:
    """Yield sizes for which a plug-in or a controller contradicts the shapes and joints of the file."""
    said = plan.gear.said
    for name, stated, shown in (
        ("wheel radius", said.wheel_radius, plan.wheel_radius),
        ("track", said.separation if plan.gear.drive in ("differential", "skid_steer") else None, _own_track(plan)),
    ):
        if stated is not None and abs(stated - shown) > SIZE_TOLERANCE * shown:
            yield FileItem(
                Fate.KEPT, f"{name} of {shown:.4f} m, from the shapes", why=f"{said.source} has {stated:.4f} m"
            )


def _own_track(plan: Plan) -> float:
    """Return the track of the file, which that of the equivalent differential drive exceeds in skid steering [m]."""
    return track_of(plan.gear) if plan.gear.drive == "skid_steer" else plan.track


def _counted(assets: Mapping[str, bytes]) -> str:
    """Return the numbers of meshes and images as text."""
    meshes = sum(name.lower().endswith((".stl", ".obj", ".msh")) for name in assets)
    pictures = len(assets) - meshes
    return number_of(meshes, "mesh") + (f", {number_of(pictures, 'picture')}" if pictures else "")


def _placed(mount: SensorMount) -> str:
    x, y, z = mount.at
    return f"at [{x:.3f}, {y:.3f}, {z:.3f}], {mount.origin}"


def _held(anatomy: Anatomy, gear: Gear) -> list[str]:
    wheels = [*gear.wheels(), *gear.bearing]
    used = {wheel.name for wheel in wheels} | {wheel.steer.name for wheel in wheels if wheel.steer is not None}
    return [joint.name or "?" for joint in anatomy.joints if joint.name not in used]


def amiss(source: RobotSource, robot: RobotFiles, anatomy: Anatomy, plan: Plan) -> Iterator[FileItem]:
    """Yield what was left out, repaired or added."""
    yield from efforts(robot, plan.gear)
    for note in robot.notes:
        left_out = note.removeprefix("left out: ")
        fate = Fate.MENDED if left_out == note else Fate.LEFT_OUT
        yield FileItem(fate, source.shown(left_out))
    yield from source.changed
    yield from source.installed
    yield from sluggish(robot)
    yield from robot.items
    for place, why in source.absent:
        yield FileItem(Fate.LEFT_OUT, "unused include", place.rpartition("/")[2], why)
    for name in source.moved:
        yield FileItem(Fate.MENDED, "file", name, "its absolute path is of another machine; taken from the package")
    for name in sorted(source.missing):
        why = f"not found; give --package {name}=DIR, or set ROS_PACKAGE_PATH"
        yield FileItem(Fate.LEFT_OUT, "package", name, why)
    for name in anatomy.loose:
        yield FileItem(Fate.LEFT_OUT, "ball joint", name, "treated as rigid")
    for note in plan.stand.notes:
        yield FileItem(Fate.ADDED, note)


def efforts(robot: RobotFiles, gear: Gear) -> Iterator[FileItem]:
    """Yield the torques that the joints of driven wheels state."""
    found = {Motors({}, {}).torque(robot.model, robot.model.joint(wheel.name).id) for wheel in gear.wheels()}
    if torques := sorted(torque for torque in found if math.isfinite(torque)):
        values = ", ".join(f"{torque:g}" for torque in torques)
        yield FileItem(Fate.LEFT_OUT, f"effort of wheels, {values} N m", why=ANY_TORQUE)


def sluggish(robot: RobotFiles) -> Iterator[FileItem]:
    """Yield the bodies whose inertia no distribution of their mass over their shapes can have."""
    for name, gyration, reach in gyrations(robot.model):
        if gyration > BEYOND * reach:
            why = f"as if all its mass were {gyration:.2f} m away, but it reaches {reach:.2f} m; it may turn too slowly"
            yield FileItem(Fate.KEPT, "implausible inertia", name, why)
