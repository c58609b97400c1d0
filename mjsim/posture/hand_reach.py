"""Moves a hand to a target: the other joints follow, and stay as close to their previous values as possible."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.people import SIDES, Figure
from mjsim.posture.goals import Seating
from mjsim.posture.posture_contacts import PointContact
from mjsim.posture.seated_figures import ROOT, Sitter
from mjsim.posture.solve import Preference, limits, solve_posture, stretch_posture

LED = "grip"
"""The landmark of a hand that is moved."""
PELVIS = "pelvis"
"""The segment that stays fixed."""
LIMB_WEIGHT, TRUNK_WEIGHT = 0.2, 1.0
"""Weights of deviations by the whole range: a hand is moved mainly by its arm, and by the trunk if necessary."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LedPosture:
    """A posture with hands moved to targets."""

    values: Array
    """Joint values of the figure, in order, shape (n,) [rad]."""
    short: Mapping[str, float]
    """For each hand that does not reach its target, by side, the remaining distance [m]."""


def lead_hands(figure: Figure, values: Array, root: Array, hands: Mapping[str, Array]) -> LedPosture:
    """Return the posture closest to another one in which hands are at their targets; the pelvis stays fixed.

    Args:
        figure: The figure.
        values: Previous joint values, in order, shape (n,) [rad].
        root: world_from_pelvis, shape (4, 4) [m].
        hands: Target position of a hand's grip, by side, world frame, shape (3,) each [m].
    """
    model = _model(figure, np.asarray(root, dtype=float).tobytes())
    names = [model.joint(number).name for number in range(model.njnt)]
    own = np.array([names.index(name) for name in figure.joints])
    before = np.zeros(model.nq)
    before[own] = values
    lower, upper = limits(model)
    span = upper - lower
    weights = np.divide(LIMB_WEIGHT, span, out=np.zeros_like(span), where=span > 0.0)
    weights[[names.index(name) for name in figure.joints if not name.startswith(SIDES)]] *= TRUNK_WEIGHT / LIMB_WEIGHT
    contacts = [PointContact(name=side, site=f"{side}_{LED}", target=target) for side, target in hands.items()]
    preference = Preference(values=before, weights=weights)
    if len(contacts) == 1 and _is_beyond(model, contacts[0]):
        found = stretch_posture(model, [], contacts[0], preference, start=before)
        return LedPosture(values=found.values[own], short=found.errors)
    found = solve_posture(model, contacts, preference)
    return LedPosture(values=found.values[own], short={side: found.errors[side] for side in found.missed})


def _is_beyond(model: mujoco.MjModel, contact: PointContact) -> bool:
    """Return whether a target is farther from the lowest joint of the trunk than the chain above it is long."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)  # that joint does not move, because the pelvis is fixed
    site = model.site(contact.site)
    body, reach = int(site.bodyid[0]), float(np.linalg.norm(site.pos))
    while model.body(model.body_parentid[body]).name != PELVIS:
        reach += float(np.linalg.norm(model.body_pos[body]))
        body = int(model.body_parentid[body])
    return float(np.linalg.norm(contact.target - data.xpos[body])) > reach


@lru_cache(maxsize=16)
def _model(figure: Figure, root: bytes) -> mujoco.MjModel:
    """Return the compiled model of a figure with a fixed pelvis; cached, because a person is usually moved repeatedly.

    Args:
        figure: The figure.
        root: world_from_pelvis, as bytes of a matrix of shape (4, 4) [m].
    """
    model = Sitter(figure, Seating(world_from_seat=np.frombuffer(root).reshape(4, 4))).model
    model.jnt_range[model.joint(ROOT[2]).id] = 0.0
    return model
