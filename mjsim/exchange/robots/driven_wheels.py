"""Finds which wheels of a robot are driven, steered or passive; asks the user where the file does not say."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.exchange.robots.ahead import ALONG, forward_of, shown
from mjsim.exchange.robots.axles import Sides, across_of, axles_of, by_side
from mjsim.exchange.robots.found_wheels import (
    MAX_AXLE_RISE,
    FoundWheel,
    bare,
    could_be_axle,
    found_wheels,
    measured,
    turns_freely,
)
from mjsim.exchange.robots.omni import (
    OWN,
    PARALLEL,
    in_the_ring,
    is_omnidirectional,
    omni_kind,
    ring_forward,
    without_rollers,
)
from mjsim.exchange.robots.robot_import import RobotOptions
from mjsim.exchange.robots.steering import listed, steered_as_named, steering_note
from mjsim.geometry import Array
from mjsim.models import Anatomy, SaidDrive, said_about

CASTER = re.compile(r"cast[eo]r|swivel|support|lenkrolle", re.IGNORECASE)
FLOOR_MARGIN = 0.3
"""A wheel stands on the floor if its lowest point is this close to the lowest of all, in wheel radii."""
MAX_PASSIVE_RATIO = 0.6
"""A passive wheel is smaller than this fraction of the largest wheel."""
HINGELESS = "it has no level hinge at all; wheels, and the ends of tracks, turn on joints without limits"
DRIVES = ("differential", "skid_steer", "ackermann", "tricycle", "mecanum", "omni3")
"""Drives that a robot from a file can have."""


@dataclass(frozen=True, slots=True, eq=False)
class Gear:
    """The running gear of a robot, in the file frame."""

    drive: str
    """One of `DRIVES`."""
    rows: tuple[tuple[tuple[FoundWheel, ...], tuple[FoundWheel, ...]], ...]
    """Axles from front to rear, each with its left and its right wheels."""
    bearing: tuple[FoundWheel, ...]
    """Passive wheels."""
    floor: float
    """Height of the floor, file frame [m]."""
    forward: Array
    """Forward direction, horizontal unit vector, file frame, shape (2,)."""
    notes: tuple[str, ...] = ()
    single: tuple[FoundWheel, ...] = ()
    """Wheels without an axle: the steered and driven wheel of a tricycle, or the three of omni3 in the drive's order.
    """
    said: SaidDrive = field(default_factory=SaidDrive)
    """What plug-ins and controllers state about it."""

    @property
    def left(self) -> Array:
        """Horizontal unit vector to the left, file frame, shape (2,)."""
        return np.array([-self.forward[1], self.forward[0]])

    def wheels(self) -> list[FoundWheel]:
        """Return all wheels that are driven or steered."""
        return [*(wheel for row in self.rows for side in row for wheel in side), *self.single]


def find_gear(
    anatomy: Anatomy, options: RobotOptions, *, file: str, urdf: bool, said: Sequence[SaidDrive] = ()
) -> Gear:
    """Return the running gear of a robot.

    Args:
        anatomy: Contents of its file.
        options: What the user specified.
        file: Name of the file in messages.
        urdf: Whether +x is forward by convention (REP 103).
        said: What plug-ins and controllers state, in order of precedence.

    Raises:
        UsageError: There are no wheels, they are ambiguous, or of a kind that cannot be imported.
    """
    anatomy, hubs = without_rollers(anatomy)
    if options.left or options.right:
        chosen = [*_named(anatomy, options.left, file), *_named(anatomy, options.right, file)]
        others = [wheel for wheel in found_wheels(anatomy) if wheel.name not in {*options.left, *options.right}]
    else:
        chosen, others = _guessed(anatomy, file, said)
    if options.drive is not None and options.drive not in DRIVES:
        raise UsageError(f"--drive is '{options.drive}'; it must be one of {', '.join(DRIVES)}")
    if options.steering:
        chosen, others = steered_as_named(chosen, others, options.steering, anatomy, file)
    about = said_about({wheel.name for wheel in chosen}, said)
    if options.drive in ("mecanum", "omni3") or (options.drive is None and is_omnidirectional(anatomy, chosen, hubs)):
        if options.steering:
            raise UsageError(f"{file}: wheels with rollers do not steer; leave out --steering, or name another --drive")
        gear = _omnidirectional(anatomy, chosen, others, options, about, file=file, urdf=urdf)
        return replace(gear, said=about)
    axis = _common_axis(chosen, file)
    forward, notes = forward_of(anatomy, chosen, axis, options, file=file, urdf=urdf)
    chosen, floor, sizes = _on_floor(anatomy, chosen, file, about)
    bearing = [wheel for wheel in others if wheel.radius > 0.0 and wheel.bottom < floor + FLOOR_MARGIN * wheel.radius]
    gear = _sorted_out(anatomy, chosen, bearing, floor, forward, options, file=file, notes=(*notes, *sizes))
    steers = [wheel.steer for wheel in gear.wheels() if wheel.steer is not None]
    note = steering_note(steers) if gear.drive == "ackermann" else ""
    return replace(gear, said=about, notes=(*gear.notes, note) if note else gear.notes)


def _named(anatomy: Anatomy, names: Sequence[str], file: str) -> list[FoundWheel]:
    """Return the wheels of the joints that the user named."""
    known = {joint.name: joint for joint in anatomy.joints if not joint.slides}
    found = []
    for name in names:
        if name not in known:
            raise UsageError(f"no hinge '{name}' in {file}{did_you_mean(name, known)}")
        joint = known[name]
        if abs(joint.axis[2]) > MAX_AXLE_RISE:
            raise UsageError(
                f"joint '{name}' of {file} turns about {shown(joint.axis)}; the axle of a wheel must be horizontal"
            )
        wheels = measured(anatomy, joint) or [bare(joint)]
        found += [replace(wheel, swivels=False) for wheel in wheels[:1]]
    return found


def _guessed(anatomy: Anatomy, file: str, said: Sequence[SaidDrive]) -> tuple[list[FoundWheel], list[FoundWheel]]:
    """Return the driven or steered wheels, and the passive ones."""
    all_round = found_wheels(anatomy)
    whole = [wheel for wheel in all_round if wheel.radius > 0.0]
    if not whole:
        whole = [w for w in all_round if w.joint.driven or re.search("wheel", w.name, re.IGNORECASE)]
    if not whole and any(each.wheel_radius for each in said):
        # No rotating part is round, but a plug-in or controller states the radius.
        whole = [bare(joint) for joint in anatomy.joints if joint.driven and could_be_axle(joint)]
    if not whole:
        level = [joint for joint in anatomy.joints if not joint.slides and abs(joint.axis[2]) < MAX_AXLE_RISE]
        hinges = listed([joint.name for joint in level])
        reason = _instead(anatomy) or (f"its level hinges are {hinges}" if level else HINGELESS)
        name_them = "; name them with --left-wheel JOINT and --right-wheel JOINT" if level else ""
        if level and reason.startswith("its") and not any(map(turns_freely, anatomy.joints)):
            reason = (
                f"its level hinges {hinges} have limits; if it is an arm, a world has it as arms: [{{model: FILE}}]"
            )
        raise UsageError(f"{file}: no wheels can be found: {reason}{name_them}")
    lowest = min(wheel.bottom for wheel in whole)
    standing = [wheel for wheel in whole if wheel.bottom <= lowest + FLOOR_MARGIN * max(wheel.radius, 0.02)]
    largest = max(wheel.radius for wheel in standing)

    def bears(wheel: FoundWheel) -> bool:
        joints = [joint for joint in (wheel.joint, wheel.steer) if joint is not None]
        names = [name for joint in joints for name in (joint.name, *anatomy.parts[joint.part].names)]
        named = any(map(CASTER.search, names))
        return wheel.swivels or named or (wheel.radius < MAX_PASSIVE_RATIO * largest and not wheel.joint.driven)

    bearing = [wheel for wheel in standing if bears(wheel)]
    chosen = [wheel for wheel in standing if not bears(wheel)] or standing
    # A file that names a motor for only one wheel has left out the other motor.
    if sum(wheel.joint.driven for wheel in chosen) > 1 and not any(wheel.steer for wheel in chosen):
        # Motors tell which wheels are driven; the others are passive.
        bearing += [wheel for wheel in chosen if not wheel.joint.driven]
        chosen = [wheel for wheel in chosen if wheel.joint.driven]
    return chosen, [wheel for wheel in bearing if wheel not in chosen]


def _instead(anatomy: Anatomy) -> str | None:
    """Return what a robot has instead of rotating wheels; None if nothing was found."""
    wheels = [place.name for place in anatomy.places if place.kind == "body" and "wheel" in place.name.lower()]
    turning = [joint.name for joint in anatomy.joints if turns_freely(joint) and "wheel" in joint.name.lower()]
    if turning:
        return f"nothing that turns on {listed(turning[:4])} is round about its axle, or the axle is not level"
    if wheels:
        return f"no joint turns {listed(wheels[:4])}, give each a hinge"
    slides = [
        j.name
        for j in anatomy.joints
        if j.slides and abs(j.axis[2]) < MAX_AXLE_RISE and anatomy.parts[j.part].parent < 1
    ]
    return f"it moves by slides ({listed(slides[:4])})" if slides else None


def _omnidirectional(
    anatomy: Anatomy,
    chosen: list[FoundWheel],
    others: list[FoundWheel],
    options: RobotOptions,
    said: SaidDrive,
    *,
    file: str,
    urdf: bool,
) -> Gear:
    """Return the running gear of an omnidirectional base.

    Raises:
        UsageError: The wheels are not arranged as those of a drive that mjsim has.
    """
    kind = omni_kind(chosen, file)
    if options.drive not in (None, kind):
        raise UsageError(f"{file}: its wheels are arranged as those of {kind}; leave out --drive {options.drive}")
    chosen, floor, sizes = _on_floor(anatomy, chosen, file, said)
    bearing = tuple(w for w in others if w.radius > 0.0 and w.bottom < floor + FLOOR_MARGIN * w.radius)
    if kind == "omni3":
        requested = None if options.forward is None else np.array(ALONG.get(options.forward, (1.0, 0.0)))
        forward = ring_forward(chosen, requested)
        note = f"its front is {shown(forward)} in its file, with one wheel at the rear"
        return Gear(kind, (), bearing, floor, forward, (note, *sizes), in_the_ring(chosen, forward))
    forward, notes = forward_of(anatomy, chosen, _common_axis(chosen, file), options, file=file, urdf=urdf)
    left = np.array([-forward[1], forward[0]])
    rows = tuple(tuple(tuple(side) for side in by_side(row, left, options)) for row in axles_of(chosen, forward))
    if len(rows) != 2 or any(len(side) != 1 for row in rows for side in row):
        raise UsageError(
            f"{file}: {listed([w.name for w in chosen])} are not at the corners of a rectangle; name the four"
            " wheels with --left-wheel JOINT and --right-wheel JOINT, twice each"
        )
    return Gear(kind, tuple((row[0], row[1]) for row in rows), bearing, floor, forward, (*notes, *sizes))


def _common_axis(wheels: Sequence[FoundWheel], file: str) -> Array:
    """Return the direction of the axles of unsteered wheels, horizontal unit vector, shape (2,)."""
    fixed = [wheel for wheel in wheels if wheel.steer is None] or list(wheels)
    axis = fixed[0].axis[:2]
    for wheel in fixed:
        if abs(float(wheel.axis[:2] @ axis)) < PARALLEL:
            names = listed([w.name for w in fixed])
            raise UsageError(
                f"{file}: the axles of {names} point in different directions; mjsim has omni3 for three wheels in a"
                f" ring, name the driven ones with --left-wheel JOINT and --right-wheel JOINT, or {OWN}"
            )
    return np.asarray(axis / np.linalg.norm(axis))


def _on_floor(
    anatomy: Anatomy, wheels: list[FoundWheel], file: str, said: SaidDrive
) -> tuple[list[FoundWheel], float, tuple[str, ...]]:
    """Return the wheels with known radius, the height of the floor [m], and what is guessed."""
    notes: tuple[str, ...] = ()
    known = [wheel.bottom for wheel in wheels if wheel.radius > 0.0]
    if known:
        floor = float(np.mean(known)) if np.ptp(known) < 0.02 else min(known)
    elif said.wheel_radius is not None:
        floor = min(float(wheel.middle[2]) for wheel in wheels) - said.wheel_radius
    else:
        foot = [place for place in anatomy.places if place.kind == "body" and "footprint" in place.name]
        if not foot:
            raise UsageError(f"{file}: the wheels have no shape that gives their radius; give them a collision shape")
        floor = float(foot[0].at[2])
        notes = (f"radius of the wheels: their height above '{foot[0].name}', as no shape gives it",)
    whole = []
    for wheel in wheels:
        radius = float(wheel.middle[2]) - floor
        if radius <= 1e-3:
            raise UsageError(f"{file}: the axle of '{wheel.name}' lies {radius:.3g} m above the floor; is it a wheel?")
        width = wheel.width if wheel.width > 0.0 else 0.4 * radius
        # All wheels of a robot stand on one floor.
        whole.append(replace(wheel, radius=radius, width=width))
    return whole, floor, notes


def _sorted_out(
    anatomy: Anatomy,
    wheels: list[FoundWheel],
    bearing: list[FoundWheel],
    floor: float,
    forward: Array,
    options: RobotOptions,
    *,
    file: str,
    notes: tuple[str, ...],
) -> Gear:
    """Return the running gear made of wheels, by axles and sides."""
    left = np.array([-forward[1], forward[0]])
    steering = [wheel for wheel in wheels if wheel.steer is not None]
    if len(wheels) == 3 and len(steering) == 1 and options.drive in (None, "tricycle"):
        return _tricycle(wheels, steering[0], bearing, floor, forward, file=file, notes=notes)
    rows = axles_of(wheels, forward)
    sides = [by_side(row, left, options) for row in rows]
    for pair in [*sides]:
        centre = all(abs(across_of(w, left, sides)) < 0.5 * w.radius for side in pair for w in side)
        if centre and len(sides) > 1:
            sides.remove(pair)
            bearing = [*bearing, *pair[0], *pair[1]]
    uneven = not sides or any(not a or not b or abs(len(a) - len(b)) > 0 for a, b in sides)
    if uneven:
        _check_abreast(anatomy, wheels, left, file)
        raise UsageError(
            f"{file}: the driven wheels are ambiguous; candidates are {listed([w.name for w in wheels])};"
            " give --left-wheel JOINT and --right-wheel JOINT"
        )
    steered = [pair for pair in sides if any(w.steer is not None for side in pair for w in side)]
    drive = options.drive or ("ackermann" if steered else "differential" if len(sides) == 1 else "skid_steer")
    _check_drive(drive, sides, steered, file)
    whole = tuple((tuple(a), tuple(b)) for a, b in sides)
    return Gear(drive, whole, tuple(bearing), floor, forward, notes)


def _check_abreast(anatomy: Anatomy, wheels: Sequence[FoundWheel], left: Array, file: str) -> None:
    """Raise UsageError if all wheels are in line, as on a bicycle."""
    across = [float(wheel.middle[:2] @ left) for wheel in wheels]
    if len(wheels) > 1 and max(across) - min(across) < 0.5 * min(wheel.radius for wheel in wheels):
        held = [j.name for j in anatomy.joints if "wheel" in j.name.lower() and not turns_freely(j)]
        others = f", while {listed(held[:4])} have limits: make them continuous" if held else ""
        raise UsageError(
            f"{file}: its wheels {listed([wheel.name for wheel in wheels])} are one behind the other, as on a"
            f" bicycle{others}; it must be one of {', '.join(DRIVES)}"
        )


def _tricycle(
    wheels: list[FoundWheel],
    steered: FoundWheel,
    bearing: list[FoundWheel],
    floor: float,
    forward: Array,
    *,
    file: str,
    notes: tuple[str, ...],
) -> Gear:
    """Return the running gear of a base with a fixed axle and one steered wheel.

    Raises:
        UsageError: The wheels are arranged differently.
    """
    left = np.array([-forward[1], forward[0]])
    fixed = [wheel for wheel in wheels if wheel is not steered]
    right, left_one = sorted(fixed, key=lambda wheel: float(wheel.middle[:2] @ left))
    middle = (right.middle + left_one.middle)[:2] / 2
    offsets = (right.middle - left_one.middle)[:2] @ forward, (steered.middle[:2] - middle) @ left
    if any(abs(float(value)) > 0.5 * steered.radius for value in offsets):
        raise UsageError(
            f"{file}: '{steered.name}' steers, but '{left_one.name}' and '{right.name}' are not on one axle"
            " on both sides of it, as on a tricycle; name the driven wheels with --left-wheel and --right-wheel"
        )
    if not steered.joint.driven:
        notes = (*notes, f"'{steered.name}' steers and drives")
    return Gear("tricycle", (((left_one,), (right,)),), tuple(bearing), floor, forward, notes, (steered,))


def _check_drive(
    drive: str,
    sides: list[Sides],
    steered: list[Sides],
    file: str,
) -> None:
    if drive == "tricycle":
        raise UsageError(f"{file} has no single steered wheel in front of or behind an axle; name it with --steering")
    if len(steered) == len(sides) == 2:
        turned = dict.fromkeys(w.steer.name for side in sides[0] for w in side if w.steer is not None)
        front = " ".join(f"--steering {name}" for name in turned)
        raise UsageError(
            f"{file} steers all four wheels, a drive that mjsim does not have; {front} makes it a car"
            f" whose rear wheels are held straight, or {OWN}"
        )
    if drive == "ackermann":
        if len(sides) != 2 or len(steered) != 1 or steered[0] is not sides[0]:
            raise UsageError(
                f"{file} has axles: {len(sides)}, steered: {len(steered)}; a car has two, and"
                " steers the front one (--forward turns it round)"
            )
    elif steered:
        raise UsageError(f"{file} has wheels that steer; that is a car, leave out --drive {drive}")
    if drive == "differential" and len(sides) != 1:
        raise UsageError(f"{file} has {len(sides)} driven axles; a differential drive has one, name its two wheels")
    if drive == "skid_steer" and len(sides) < 2:
        raise UsageError(f"{file} has one driven axle; skid steering needs two or more")
