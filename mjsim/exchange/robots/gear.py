"""Which wheels drive a robot, which steer it and which only bear it; asked for where the file does not tell."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.exchange.robots.rounds import LEVEL, Round, measured, rounds
from mjsim.geometry import Array
from mjsim.models import Anatomy, FileJoint

CASTER = re.compile(r"cast[eo]r|swivel|support|lenkrolle", re.IGNORECASE)
ROLLERS = re.compile(r"mecanum|omni_?wheel|omniwheel|rotacaster", re.IGNORECASE)
FRONT, BACK = re.compile(r"front|nose|forward"), re.compile(r"rear|back|tail|behind")
NEAR_FLOOR = 0.3
"""A wheel stands on the floor when its lowest point is this near to the lowest of all, in radii."""
SMALL = 0.6
"""A wheel that does not drive is smaller than this, of the largest."""
ROW = 0.5
"""Wheels this near to each other along the robot stand on one axle, in radii."""
PARALLEL = math.cos(math.radians(12.0))
ALONG = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}
"""Directions in the frame of a file."""
FEWEST_ROLLERS = 4
NOT_TAKEN = (
    "such wheels are not taken from files, describe the robot with drive: {type: mecanum} or omni3 and a plain body"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What a person says where the file leaves it open."""

    left: Sequence[str] = ()
    """Joints of the wheels to the left."""
    right: Sequence[str] = ()
    steering: Sequence[str] = ()
    """Joints that steer."""
    drive: str | None = None
    """Kind of drive."""
    forward: str | None = None
    """Where it looks in its file: +x, -x, +y or -y."""


@dataclass(frozen=True, slots=True, eq=False)
class Gear:
    """The running gear of a robot, file frame."""

    drive: str
    """differential, skid_steer or ackermann."""
    rows: tuple[tuple[tuple[Round, ...], tuple[Round, ...]], ...]
    """Axles from the front to the rear, each its wheels to the left and to the right."""
    bearing: tuple[Round, ...]
    """Wheels that only bear it."""
    floor: float
    """Height of the floor [m]."""
    forward: Array
    """Unit vector, level, shape (2,)."""
    notes: tuple[str, ...] = ()

    @property
    def left(self) -> Array:
        """Unit vector to the left, level, shape (2,)."""
        return np.array([-self.forward[1], self.forward[0]])

    def wheels(self) -> list[Round]:
        """Return all wheels that drive or steer."""
        return [wheel for row in self.rows for side in row for wheel in side]


def find_gear(anatomy: Anatomy, wishes: Wishes, *, file: str, urdf: bool) -> Gear:
    """Return the running gear of a robot.

    Args:
        anatomy: Of its file.
        wishes: What is said beside it.
        file: As errors name it.
        urdf: Whether x is ahead by convention (REP 103).

    Raises:
        UsageError: It has no wheels, its wheels are not clear, or they are of a kind that is not taken from files.
    """
    _refuse_rollers(anatomy, file)
    if wishes.left or wishes.right:
        chosen = [*_named(anatomy, wishes.left, file), *_named(anatomy, wishes.right, file)]
        others = [wheel for wheel in rounds(anatomy) if wheel.name not in {*wishes.left, *wishes.right}]
    else:
        chosen, others = _guessed(anatomy, file)
    axis = _common_axis(chosen, file)
    forward, notes = _forward(anatomy, axis, wishes, file=file, urdf=urdf)
    chosen, floor = _on_floor(anatomy, chosen, file)
    bearing = [wheel for wheel in others if wheel.radius > 0.0 and wheel.bottom < floor + NEAR_FLOOR * wheel.radius]
    if wishes.steering:
        chosen = _steered_as_said(anatomy, chosen, wishes.steering, file)
    return _sorted_out(chosen, bearing, floor, forward, wishes, file=file, notes=notes)


def _named(anatomy: Anatomy, names: Sequence[str], file: str) -> list[Round]:
    """Return the wheels of joints that a person names."""
    known = {joint.name: joint for joint in anatomy.joints if not joint.slides}
    found = []
    for name in names:
        if name not in known:
            raise UsageError(f"no hinge '{name}' in {file}{did_you_mean(name, known)}")
        joint = known[name]
        if abs(joint.axis[2]) > LEVEL:
            raise UsageError(f"joint '{name}' of {file} turns about {_shown(joint.axis)}; a wheel's axle is level")
        wheels = measured(anatomy, joint) or [Round(joint, joint.at, joint.axis, 0.0, 0.0)]
        found += [replace(wheel, swivels=False) for wheel in wheels[:1]]
    return found


def _guessed(anatomy: Anatomy, file: str) -> tuple[list[Round], list[Round]]:
    """Return the wheels that drive or steer, and those that only bear."""
    all_round = rounds(anatomy)
    whole = [wheel for wheel in all_round if wheel.radius > 0.0]
    if not whole:
        whole = [wheel for wheel in all_round if re.search("wheel", wheel.name, re.IGNORECASE)]
    if not whole:
        hinges = [joint.name for joint in anatomy.joints if not joint.slides and abs(joint.axis[2]) < LEVEL]
        there = f"its level hinges are {_listed(hinges)}" if hinges else "it has no level hinge at all"
        raise UsageError(
            f"{file} has no wheels that can be found: {there}; name them with --left-wheel JOINT and --right-wheel"
            " JOINT"
        )
    lowest = min(wheel.bottom for wheel in whole)
    standing = [wheel for wheel in whole if wheel.bottom <= lowest + NEAR_FLOOR * max(wheel.radius, 0.02)]
    largest = max(wheel.radius for wheel in standing)

    def bears(wheel: Round) -> bool:
        named = CASTER.search(wheel.name) or any(CASTER.search(n) for n in anatomy.parts[wheel.joint.part].names)
        return bool(wheel.swivels or named or (wheel.radius < SMALL * largest and not wheel.joint.driven))

    bearing = [wheel for wheel in standing if bears(wheel)]
    chosen = [wheel for wheel in standing if not bears(wheel)] or standing
    if any(wheel.joint.driven for wheel in chosen) and not any(wheel.steer for wheel in chosen):
        # Motors tell which of the wheels drive; the others roll along.
        bearing += [wheel for wheel in chosen if not wheel.joint.driven]
        chosen = [wheel for wheel in chosen if wheel.joint.driven]
    return chosen, [wheel for wheel in bearing if wheel not in chosen]


def _refuse_rollers(anatomy: Anatomy, file: str) -> None:
    """Refuse wheels with rollers, which slip and roll as no plain wheel does."""
    for number in range(1, len(anatomy.parts)):
        rolling = [joint for joint in anatomy.joints if anatomy.parts[joint.part].parent == number]
        if len(rolling) >= FEWEST_ROLLERS and any(joint.part == number for joint in anatomy.joints):
            hinge = next(joint.name for joint in anatomy.joints if joint.part == number)
            if all(not joint.slides and joint.range is None for joint in rolling):
                raise UsageError(f"{file}: the wheel on joint '{hinge}' has {len(rolling)} rollers; {NOT_TAKEN}")
    for part in anatomy.parts:
        for name in part.names:
            if ROLLERS.search(name):
                raise UsageError(f"{file}: '{name}' is a wheel with rollers by its name; {NOT_TAKEN}")


def _common_axis(wheels: Sequence[Round], file: str) -> Array:
    """Return the direction of the axles of wheels that do not steer, level, shape (2,)."""
    fixed = [wheel for wheel in wheels if wheel.steer is None] or list(wheels)
    axis = fixed[0].axis[:2]
    for wheel in fixed:
        if abs(float(wheel.axis[:2] @ axis)) < PARALLEL:
            names = _listed([w.name for w in fixed])
            raise UsageError(
                f"{file}: the axles of {names} point different ways, as those of an omnidirectional base; such wheels"
                " are not taken from files, or name two with --left-wheel JOINT and --right-wheel JOINT"
            )
    return np.asarray(axis / np.linalg.norm(axis))


def _forward(anatomy: Anatomy, axis: Array, wishes: Wishes, *, file: str, urdf: bool) -> tuple[Array, tuple[str, ...]]:
    """Return where the robot looks, level, and what is to be said about it."""
    ahead = np.array([axis[1], -axis[0]])
    if wishes.forward is not None:
        if wishes.forward not in ALONG:
            raise UsageError(f"--forward is '{wishes.forward}'; it is +x, -x, +y or -y")
        wanted = np.array(ALONG[wishes.forward])
        if abs(float(wanted @ ahead)) < math.cos(math.radians(45.0)):
            raise UsageError(f"--forward {wishes.forward} is along the axles of {file}, whose wheels roll across that")
        return ahead * np.sign(wanted @ ahead), ()
    if urdf and abs(ahead[0]) > PARALLEL:
        return ahead * np.sign(ahead[0]), ()
    hint = _hint(anatomy, ahead)
    if abs(hint) > 1e-3:
        ahead = ahead * np.sign(hint)
        return ahead, (f"it looks along {_shown(ahead)} of its file, by names of its parts and by its cameras",)
    if abs(ahead[0]) > PARALLEL:
        ahead = ahead * np.sign(ahead[0])
        return ahead, ("it looks along x of its file, as is usual",)
    signs = [key for key, direction in ALONG.items() if abs(float(np.array(direction) @ ahead)) > 0.7]
    raise UsageError(f"{file} does not tell where its front is; give --forward {signs[0]} or --forward {signs[1]}")


def _hint(anatomy: Anatomy, ahead: Array) -> float:
    """Return a positive number when names and cameras say that the robot looks along a direction, else negative."""
    places: dict[bool, list[float]] = {True: [], False: []}
    named: list[tuple[str, Array]] = [(place.name, place.at) for place in anatomy.places]
    named += [(shape.names[0], shape.points.mean(axis=0)) for shape in anatomy.shapes]
    for name, at in named:
        words = name.lower()
        if FRONT.search(words) and not BACK.search(words):
            places[True].append(float(at[:2] @ ahead))
        elif BACK.search(words) and not FRONT.search(words):
            places[False].append(float(at[:2] @ ahead))
    by_names = 0.0
    if all(places.values()):
        by_names = float(np.mean(places[True]) - np.mean(places[False]))
    looks = [-place.axes[:2, 2] @ ahead for place in anatomy.places if place.kind == "camera"]
    by_cameras = float(np.mean(looks)) if looks else 0.0
    return by_names if abs(by_names) > 0.02 else (by_cameras if abs(by_cameras) > 0.3 else 0.0)


def _on_floor(anatomy: Anatomy, wheels: list[Round], file: str) -> tuple[list[Round], float]:
    """Return wheels whose radius is known, and the height of the floor."""
    known = [wheel.bottom for wheel in wheels if wheel.radius > 0.0]
    if known:
        floor = float(np.mean(known)) if np.ptp(known) < 0.02 else min(known)
    else:
        foot = [place for place in anatomy.places if place.kind == "body" and "footprint" in place.name]
        if not foot:
            raise UsageError(f"{file}: the wheels have no shape that tells their radius; give them a collision shape")
        floor = float(foot[0].at[2])
    whole = []
    for wheel in wheels:
        radius = float(wheel.middle[2]) - floor
        if radius <= 1e-3:
            raise UsageError(f"{file}: the axle of '{wheel.name}' lies {radius:.3g} m above the floor; is it a wheel?")
        width = wheel.width if wheel.width > 0.0 else 0.4 * radius
        # Wheels of one robot stand on one floor.
        whole.append(replace(wheel, radius=radius, width=width))
    return whole, floor


def _steered_as_said(anatomy: Anatomy, wheels: list[Round], names: Sequence[str], file: str) -> list[Round]:
    known = {joint.name: joint for joint in anatomy.joints if not joint.slides}
    for name in names:
        if name not in known:
            raise UsageError(f"no hinge '{name}' in {file}{did_you_mean(name, known)}")
    return [replace(w, steer=w.steer if w.steer is not None and w.steer.name in names else None) for w in wheels]


def _sorted_out(
    wheels: list[Round],
    bearing: list[Round],
    floor: float,
    forward: Array,
    wishes: Wishes,
    *,
    file: str,
    notes: tuple[str, ...],
) -> Gear:
    """Return the gear that wheels make, by rows and sides."""
    left = np.array([-forward[1], forward[0]])
    rows = _rows(wheels, forward)
    sides = [_by_side(row, left, wishes) for row in rows]
    for pair in [*sides]:
        centre = all(abs(_across(w, left, sides)) < 0.5 * w.radius for side in pair for w in side)
        if centre and len(sides) > 1:
            sides.remove(pair)
            bearing = [*bearing, *pair[0], *pair[1]]
    uneven = not sides or any(not a or not b or abs(len(a) - len(b)) > 0 for a, b in sides)
    if uneven:
        raise UsageError(
            f"{file}: which wheels drive is not clear; candidates are {_listed([w.name for w in wheels])};"
            " give --left-wheel JOINT and --right-wheel JOINT"
        )
    steered = [pair for pair in sides if any(w.steer is not None for side in pair for w in side)]
    drive = wishes.drive or ("ackermann" if steered else "differential" if len(sides) == 1 else "skid_steer")
    _check_drive(drive, sides, steered, file)
    whole = tuple((tuple(a), tuple(b)) for a, b in sides)
    return Gear(drive, whole, tuple(bearing), floor, forward, notes)


def _check_drive(
    drive: str, sides: list[tuple[list[Round], list[Round]]], steered: list[tuple[list[Round], list[Round]]], file: str
) -> None:
    if drive not in ("differential", "skid_steer", "ackermann"):
        raise UsageError(f"--drive is '{drive}'; robots from files drive as differential, skid_steer or ackermann")
    if drive == "ackermann":
        if len(sides) != 2 or len(steered) != 1 or steered[0] is not sides[0]:
            raise UsageError(
                f"{file} has {len(sides)} axles, of which {len(steered)} steer; a car has two, and steers the front one"
                " (--forward turns it round)"
            )
    elif steered:
        raise UsageError(f"{file} has wheels that steer; that is a car, leave out --drive {drive}")
    if drive == "differential" and len(sides) != 1:
        raise UsageError(f"{file} has {len(sides)} axles that drive; a differential drive has one, name its two wheels")
    if drive == "skid_steer" and len(sides) < 2:
        raise UsageError(f"{file} has one axle that drives; skid steering needs two or more")


def _rows(wheels: list[Round], forward: Array) -> list[list[Round]]:
    """Return wheels by axles, those in front first."""
    rows: list[list[Round]] = []
    for wheel in sorted(wheels, key=lambda w: -float(w.middle[:2] @ forward)):
        near = rows and abs(float((rows[-1][0].middle - wheel.middle)[:2] @ forward)) < ROW * wheel.radius
        if near:
            rows[-1].append(wheel)
        else:
            rows.append([wheel])
    return rows


def _by_side(row: list[Round], left: Array, wishes: Wishes) -> tuple[list[Round], list[Round]]:
    """Return the wheels of an axle to the left and to the right, the outer ones first."""
    middle = float(np.mean([wheel.middle[:2] @ left for wheel in row]))
    if len(row) == 1:
        middle = 0.0

    def outward(wheel: Round) -> float:
        return -abs(float(wheel.middle[:2] @ left) - middle)

    said_left, said_right = set(wishes.left), set(wishes.right)

    def is_left(wheel: Round) -> bool:
        if (wheel.name in said_left) != (wheel.name in said_right):
            return wheel.name in said_left
        return float(wheel.middle[:2] @ left) > middle

    return (
        sorted((w for w in row if is_left(w)), key=outward),
        sorted((w for w in row if not is_left(w)), key=outward),
    )


def _across(wheel: Round, left: Array, sides: list[tuple[list[Round], list[Round]]]) -> float:
    """Return how far a wheel stands from the middle of the robot [m]."""
    all_of = [float(w.middle[:2] @ left) for pair in sides for side in pair for w in side]
    return float(wheel.middle[:2] @ left) - (min(all_of) + max(all_of)) / 2


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"'{name}'" for name in names[:12]) + (" and more" if len(names) > 12 else "")


def _shown(direction: Array) -> str:
    return f"[{', '.join(f'{value + 0.0:.2g}' for value in np.round(direction, 2))}]"


def steering_limit(joints: Sequence[FileJoint]) -> float:
    """Return how far wheels may be steered to both sides [rad]."""
    limits = [min(abs(joint.range[0]), abs(joint.range[1])) for joint in joints if joint.range is not None]
    return min([*limits, math.radians(35.0)])
