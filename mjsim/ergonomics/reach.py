"""Reach of hands: to targets, and in all directions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjsim.geometry import Array
from mjsim.people import SIDES, Figure
from mjsim.posture import TOOLS, TOUCH, Goals, LineContact, PointContact, Seated, Seating, Sitter
from mjsim.world import GripTarget, PedalTarget, PlacedTarget

MAX_REACH = 3.0
"""Beyond everyone's reach [m]."""
AZIMUTHS, ELEVATIONS = np.radians(np.arange(-90, 91, 30)), np.radians(np.arange(-60, 61, 30))
"""Directions of an envelope, from forward to the left and from horizontal to up [rad]."""


@dataclass(frozen=True, slots=True)
class TargetReach:
    """Distance of a target from a limb, with the rest of the posture unchanged."""

    target: str
    limb: str
    """The closest hand or foot, 'left' or 'right'."""
    short: float
    """Remaining distance with the back against the backrest; 0 if the target is reached [m]."""
    leaning: float
    """The same if the back may leave the backrest [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Envelope:
    """The surface within reach of a hand, with the back against the backrest."""

    side: str
    shoulder: Array
    """Reference point, world frame, shape (3,) [m]."""
    points: Array
    """World frame, by azimuth and elevation, NaN where the hand cannot reach, shape (azimuths, elevations, 3) [m]."""

    @property
    def distances(self) -> Array:
        """From the shoulder, shape (azimuths, elevations) [m]."""
        return np.asarray(np.linalg.norm(self.points - self.shoulder, axis=-1))


def settled(seating: Seating, found: Seated) -> Seating:
    """Return the seat fixed at its current setting."""
    pose = seating.world_from_seat.copy()
    pose[:3, 3] += pose[:3, :3] @ (found.set_by[0], 0.0, found.set_by[1])
    return replace(seating, world_from_seat=pose, travel=(0.0, 0.0))


def target_reach(sitter: Sitter, goals: Goals, placed: PlacedTarget) -> TargetReach | None:
    """Return the distance between a target and the closer hand or foot; None for targets of the gaze.

    Args:
        sitter: The person, on a seat with a fixed setting.
        goals: Goals of the posture; only those of the reaching limb are replaced.
        placed: The target.
    """
    if not isinstance(placed.target, GripTarget | PedalTarget):
        return None
    tried = []
    for side in _nearer_first(sitter.seating, placed):
        aimed, name = _aimed(goals, placed, side)
        short = _short(sitter, aimed, name)
        tried.append((short, side, aimed, name))
        if short == 0.0:
            break
    short, side, aimed, name = min(tried, key=lambda each: each[0])
    leaning = 0.0 if short == 0.0 else _short(sitter, replace(aimed, leans=False), name)
    return TargetReach(placed.name, side, short, min(leaning, short))


def _nearer_first(seating: Seating, placed: PlacedTarget) -> Sequence[str]:
    """Return both sides of the body, first the one on which a target lies."""
    to_target = placed.world_from_target[:3, 3] - seating.world_from_seat[:3, 3]
    left = float(to_target @ seating.world_from_seat[:3, 1]) >= 0.0
    return SIDES if left else SIDES[::-1]


def _aimed(goals: Goals, placed: PlacedTarget, side: str) -> tuple[Goals, str]:
    """Return goals with one limb at a target, without goals for the eyes and the other hand; and the contact's name."""
    point = np.array(placed.world_from_target[:3, 3])
    if isinstance(placed.target, GripTarget):
        return replace(goals, hands={side: (placed.target.touch, point)}, gaze=None), f"{side} hand"
    return replace(goals, feet={**goals.feet, side: point}, hands={}, gaze=None), f"{side} foot"


def _short(sitter: Sitter, goals: Goals, name: str) -> float:
    error = sitter.sit(goals).errors[name]
    return 0.0 if error <= TOUCH else error


def reach_envelope(
    sitter: Sitter,
    goals: Goals,
    side: str,
    *,
    touch: str = "thumb",
    azimuths: Array = AZIMUTHS,
    elevations: Array = ELEVATIONS,
) -> Envelope:
    """Return how far a hand reaches in each direction from the relaxed position of its shoulder.

    Args:
        sitter: The person, on a seat with a fixed setting.
        goals: Goals of the posture; those of hands and eyes are replaced.
        side: 'left' or 'right'.
        touch: Contact point of the hand: 'fist', 'thumb' or 'finger'.
        azimuths: Angles from the seat's forward direction to the left, shape (n,) [rad].
        elevations: Angles above the horizontal, shape (m,) [rad].
    """
    still = replace(goals, hands={}, gaze=None)
    ease = sitter.sit(still)
    figure: Figure = sitter.figure
    shoulder = figure.poses(ease.values, ease.world_from_pelvis)[f"{side}_upper_arm"][:3, 3]
    axes, site = sitter.seating.world_from_seat[:3, :3], f"{side}_{TOOLS[touch]}"
    points = np.full((len(azimuths), len(elevations), 3), np.nan)
    for row, azimuth in enumerate(azimuths):
        start = ease.solution.values
        for column, elevation in enumerate(elevations):
            flat = math.cos(elevation)
            ahead = axes @ (flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation))
            line = LineContact(name="line", site=site, point=shoulder, direction=ahead)
            aim = PointContact(name="aim", site=site, target=shoulder + MAX_REACH * ahead)
            found = sitter.stretch(still, [line], aim, start=start)
            reached = MAX_REACH - found.errors["aim"]
            if not found.missed and reached > 0.0:
                points[row, column] = shoulder + reached * ahead
                start = found.solution.values
    return Envelope(side=side, shoulder=shoulder, points=points)
