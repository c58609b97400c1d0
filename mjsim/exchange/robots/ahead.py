"""Finds the forward direction of a robot in its file: from the options, by convention, or by names of parts."""

import math
import re
from collections.abc import Sequence

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.robots.found_wheels import FoundWheel
from mjsim.exchange.robots.omni import PARALLEL
from mjsim.exchange.robots.robot_import import RobotOptions
from mjsim.geometry import Array
from mjsim.models import Anatomy

FRONT = re.compile(r"front|nose|forward|(?<![a-z])(?:f[lr]|[lr]f)(?![a-z])")
BACK = re.compile(r"rear|back|tail|behind|(?<![a-z])(?:[rb][lr]|[lr]b)(?![a-z])")
ALONG = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}
"""Directions in the file frame."""


def forward_of(
    anatomy: Anatomy, wheels: Sequence[FoundWheel], axis: Array, options: RobotOptions, *, file: str, urdf: bool
) -> tuple[Array, tuple[str, ...]]:
    """Return the forward direction of the robot, horizontal unit vector in the file frame, and notes about it."""
    ahead = np.array([axis[1], -axis[0]])
    if options.forward is not None:
        if options.forward not in ALONG:
            raise UsageError(f"--forward is '{options.forward}'; it must be +x, -x, +y or -y")
        requested = np.array(ALONG[options.forward])
        if abs(float(requested @ ahead)) < math.cos(math.radians(45.0)):
            raise UsageError(f"--forward {options.forward} is along the axles of {file}; wheels roll across them")
        return ahead * np.sign(requested @ ahead), ()
    if urdf and abs(ahead[0]) > PARALLEL:
        return ahead * np.sign(ahead[0]), ()
    hint = _hint(anatomy, ahead)
    if abs(hint) > 1e-3:
        ahead = ahead * np.sign(hint)
        return ahead, (f"its front is {shown(ahead)} in its file, by the names of its parts and its cameras",)
    if abs(ahead[0]) > PARALLEL:
        ahead = ahead * np.sign(ahead[0])
        return ahead, ("its front is +x in its file, as usual",)
    steered = _steered_end(wheels, ahead)
    if steered != 0.0:
        ahead = ahead * np.sign(steered)
        return ahead, (f"its front is {shown(ahead)} in its file, where its wheels steer",)
    signs = [key for key, direction in ALONG.items() if abs(float(np.array(direction) @ ahead)) > 0.7]
    raise UsageError(f"{file} does not define its front; give --forward {signs[0]} or --forward {signs[1]}")


def _steered_end(wheels: Sequence[FoundWheel], ahead: Array) -> float:
    """Return how far the steered wheels of a car are ahead of its others [m]; 0 if it is no car."""
    ends = {True: [w for w in wheels if w.steer is not None], False: [w for w in wheels if w.steer is None]}
    if min(map(len, ends.values())) < 2:
        return 0.0
    middles = {steers: np.mean([wheel.middle[:2] for wheel in those], axis=0) for steers, those in ends.items()}
    return float((middles[True] - middles[False]) @ ahead)


def _hint(anatomy: Anatomy, ahead: Array) -> float:
    """Return a positive number if names and cameras suggest that a direction is forward, a negative one if not."""
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
    alignments = [-place.axes[:2, 2] @ ahead for place in anatomy.places if place.kind == "camera"]
    by_cameras = float(np.mean(alignments)) if alignments else 0.0
    return by_names if abs(by_names) > 0.02 else (by_cameras if abs(by_cameras) > 0.3 else 0.0)


def shown(direction: Array) -> str:
    """Return a direction as text for messages."""
    return f"[{', '.join(f'{value + 0.0:.2g}' for value in np.round(direction, 2))}]"
