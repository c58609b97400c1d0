"""A hand that is led somewhere: the other joints follow, and stay as near to where they were as they can."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.people import SIDES, Figure
from mjsim.posture.contacts import PointContact
from mjsim.posture.goals import Seating
from mjsim.posture.sitting import ROOT, Sitter
from mjsim.posture.solve import Preference, limits, solve_posture

LED = "grip"
"""The landmark of a hand by which it is led."""
LIMB, TRUNK = 0.2, 1.0
"""How much deviations by the whole range count: a hand is led by its arm, and the back helps where it must."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LedPosture:
    """A posture with hands led somewhere."""

    values: Array
    """Of the figure's joints, in their order, shape (n,) [rad]."""
    short: Mapping[str, float]
    """By side of a hand that does not reach its target: how far it is away [m]."""


def lead_hands(figure: Figure, values: Array, root: Array, hands: Mapping[str, Array]) -> LedPosture:
    """Return the posture nearest to another one in which hands are where they are led; the pelvis stays.

    Args:
        figure: Whose hands.
        values: Of its joints before, in their order, shape (n,) [rad].
        root: World from pelvis, shape (4, 4) [m].
        hands: Where the grip of a hand is to be, by its side, world frame, shape (3,) each [m].
    """
    model = _model(figure, np.asarray(root, dtype=float).tobytes())
    names = [model.joint(number).name for number in range(model.njnt)]
    own = np.array([names.index(name) for name in figure.joints])
    before = np.zeros(model.nq)
    before[own] = values
    lower, upper = limits(model)
    span = upper - lower
    weights = np.divide(LIMB, span, out=np.zeros_like(span), where=span > 0.0)
    weights[[names.index(name) for name in figure.joints if not name.startswith(SIDES)]] *= TRUNK / LIMB
    contacts = [PointContact(name=side, site=f"{side}_{LED}", target=target) for side, target in hands.items()]
    found = solve_posture(model, contacts, Preference(values=before, weights=weights))
    return LedPosture(values=found.values[own], short={side: found.errors[side] for side in found.missed})


@lru_cache(maxsize=16)
def _model(figure: Figure, root: bytes) -> mujoco.MjModel:
    """Return a figure whose pelvis stays where it is, compiled; kept, as the same person is led again and again.

    Args:
        figure: Whose joints.
        root: World from pelvis, the bytes of a matrix of shape (4, 4) [m].
    """
    model = Sitter(figure, Seating(world_from_seat=np.frombuffer(root).reshape(4, 4))).model
    model.jnt_range[model.joint(ROOT[2]).id] = 0.0
    return model
