"""The posture closest to the preferred one that meets its contacts within joint limits, computed with mink.

Levenberg-Marquardt steps, each a quadratic program of mink. The weights of contacts are increased until they hold to a
few micrometres. If not all can hold, those of higher ranks are relaxed, and come as close as possible.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import mink
import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.posture.posture_contacts import Contact

TOUCH = 1e-4
"""Contacts with smaller errors hold [m, rad]."""
RELAXED_WEIGHT = 20.0
"""Weight of a relaxed contact, relative to 1 for a joint's deviation by its whole range."""
CONTACT_WEIGHTS = (20.0, 200.0, 2e3)
"""Successive weights of a contact that holds: a stiff one from the start would make the posture creep along a curved
valley."""
STRICT_CONTACT_WEIGHTS = (20.0, 200.0, 2e3, 2e4)
"""Successive weights of contacts that must hold against relaxed ones."""
FREE_JOINT_WEIGHT = 0.01
"""Weight of a free joint relative to others."""
MAX_ERROR = 0.05
"""Larger errors pull no harder than one of this size [m, rad]."""
STEPS = 80
"""Maximum number of steps for each weight."""
MIN_IMPROVEMENT = 1e-6
"""Relative improvement below which the iteration stops."""
MAX_STEP = 0.5
"""Maximum step of a joint [rad] or a slide [m]: beyond it the contacts are far from linear."""
DAMPING_LIMITS = 1e-6, 1e9
"""Minimum damping, and the damping at which the search stops."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Preference:
    """Preferred joint values, and their weights."""

    values: Array
    """Shape (nq,) [rad, m]."""
    weights: Array
    """Weight of a deviation of each, shape (nq,) [1/rad, 1/m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """A posture, and the errors of its contacts."""

    values: Array
    """All joint values, in the order of the model, shape (nq,) [rad, m]."""
    errors: Mapping[str, float]
    """Error of each contact [m, rad]."""
    missed: tuple[str, ...] = field(default=())
    """Contacts that cannot hold together with those before them."""
    steps: int = 0
    """Number of quadratic programs solved."""

    @property
    def holds(self) -> bool:
        """Whether every contact holds."""
        return not self.missed


class _ContactTask(mink.Task):
    """A contact as a task of mink."""

    def __init__(self, contact: Contact, weight: float) -> None:
        """Store a contact with its weight."""
        super().__init__(cost=np.full(contact.size, weight))
        self._contact = contact

    def compute_error(self, configuration: mink.Configuration) -> Array:
        error = self._contact.error((configuration.model, configuration.data))
        return error * math.sqrt(self._share(error))

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        state = configuration.model, configuration.data
        return self._contact.jacobian(state) * math.sqrt(self._share(self._contact.error(state)))

    def loss(self, configuration: mink.Configuration) -> float:
        """Return the weighted squared error, which grows linearly beyond an error of `MAX_ERROR` (Huber's loss)."""
        error = self._contact.error((configuration.model, configuration.data))
        saturated = float(np.linalg.norm(error)) * self._share(error)
        return float(self.cost[0] ** 2 * saturated * (2.0 * np.linalg.norm(error) - saturated))

    def _share(self, error: Array) -> float:
        """Return the factor on the squared error that keeps distant targets from distorting the posture."""
        return min(1.0, MAX_ERROR / max(float(np.linalg.norm(error)), MAX_ERROR))


def range_preference(model: mujoco.MjModel, preferred: Mapping[str, float], *, free: Sequence[str] = ()) -> Preference:
    """Return a preference in which each joint's deviation is weighted relative to its own range.

    Args:
        model: A model with only hinges and slides as joints.
        preferred: Values by joint; the others prefer the value in their range closest to 0.
        free: Joints that may have any value; they have weight `FREE_JOINT_WEIGHT`, so that there is a unique optimum.
    """
    lower, upper = limits(model)
    values = np.array([preferred.get(model.joint(number).name, 0.0) for number in range(model.njnt)])
    span = upper - lower
    weights = np.where(np.isfinite(span) & (span > 0.0), 1.0 / np.where(span > 0.0, span, 1.0), 0.0)
    names = [model.joint(number).name for number in range(model.njnt)]
    weights = np.where([name in free for name in names], FREE_JOINT_WEIGHT * weights, weights)
    return Preference(values=np.clip(values, lower, upper), weights=weights)


def limits(model: mujoco.MjModel) -> tuple[Array, Array]:
    """Return the minimum and maximum values of the joints, infinite without a limit, shape (nq,) each."""
    limited = model.jnt_limited.astype(bool)
    lower: Array = np.where(limited, model.jnt_range[:, 0], -np.inf)
    upper: Array = np.where(limited, model.jnt_range[:, 1], np.inf)
    return lower, upper


def solve_posture(
    model: mujoco.MjModel, contacts: Sequence[Contact], preference: Preference, *, starts: Iterable[Array] = ()
) -> Solution:
    """Return the posture closest to the preferred one that meets the contacts within the joint limits.

    Args:
        model: A figure or another tree of hinges and slides, with nothing else.
        contacts: Contacts to meet; if not all can hold, higher ranks are relaxed.
        preference: Determines the posture where the contacts leave a choice; also the first initial value.
        starts: Additional initial values for when the first does not meet all contacts, shape (nq,) each.
    """
    configuration = mink.Configuration(model)
    found = _best(configuration, contacts, preference, [preference.values, *starts])
    if found.holds:
        return found
    held: list[Contact] = []
    steps, values = found.steps, found.values
    for _, ranked in groupby(sorted(contacts, key=_rank) if len(contacts) > 1 else (), key=_rank):
        # Within a rank, each is tried separately: a hand that cannot reach leaves the other in place.
        alone = [(each, _best(configuration, [*held, each], preference, [preference.values])) for each in ranked]
        able = [contact for contact, tried in alone if tried.holds]
        together = _best(configuration, [*held, *able], preference, [values, preference.values])
        held += able if together.holds else []
        steps, values = steps + together.steps + sum(tried.steps for _, tried in alone), together.values
    if not held:
        values = preference.values
    loose = [contact for contact in contacts if contact not in held]
    final = _descend(configuration, held, preference, values, firm=STRICT_CONTACT_WEIGHTS, loose=loose)
    short = tuple(contact.name for contact in contacts if final.errors[contact.name] > TOUCH)
    return Solution(values=final.values, errors=final.errors, missed=short, steps=steps + final.steps)


def stretch_posture(
    model: mujoco.MjModel, contacts: Sequence[Contact], aim: Contact, preference: Preference, *, start: Array
) -> Solution:
    """Return the posture that comes as close to an aim as contacts and limits allow.

    Args:
        model: Model as in `solve_posture`.
        contacts: Contacts that must hold.
        aim: The aim.
        preference: Determines the posture where these leave a choice.
        start: Initial values, shape (nq,).
    """
    firm = STRICT_CONTACT_WEIGHTS if contacts else STRICT_CONTACT_WEIGHTS[:1]
    found = _descend(mink.Configuration(model), contacts, preference, start, firm=firm, loose=[aim])
    missed = tuple(name for name in found.missed if name != aim.name)
    return Solution(values=found.values, errors=found.errors, missed=missed, steps=found.steps)


def _best(
    configuration: mink.Configuration,
    contacts: Sequence[Contact],
    preference: Preference,
    starts: Sequence[Array],
) -> Solution:
    """Return the first solution that holds, or the last."""
    steps = 0
    for start in starts:
        found = _descend(configuration, contacts, preference, start)
        steps += found.steps
        if found.holds:
            break
    return Solution(values=found.values, errors=found.errors, missed=found.missed, steps=steps)


def _descend(
    configuration: mink.Configuration,
    contacts: Sequence[Contact],
    preference: Preference,
    start: Array,
    *,
    firm: Sequence[float] = CONTACT_WEIGHTS,
    loose: Sequence[Contact] = (),
) -> Solution:
    """Return the result of Levenberg-Marquardt steps from a start, with increasing weights of the contacts."""
    model = configuration.model
    posture = mink.PostureTask(model, cost=preference.weights)
    posture.set_target(preference.values)
    configuration.update(np.clip(start, *limits(model)))
    steps = 0
    for weight in firm:
        held = [_ContactTask(contact, weight) for contact in contacts]
        steps += _minimise(
            configuration, posture, [*held, *(_ContactTask(contact, RELAXED_WEIGHT) for contact in loose)]
        )
    state = model, configuration.data
    errors = {each.name: float(np.linalg.norm(each.error(state))) for each in (*contacts, *loose)}
    missed = tuple(name for name, error in errors.items() if error > TOUCH)
    return Solution(values=configuration.q.copy(), errors=errors, missed=missed, steps=steps)


def _minimise(configuration: mink.Configuration, posture: mink.PostureTask, contacts: Sequence[_ContactTask]) -> int:
    """Move a model to the nearest minimum of the cost of posture and contacts; return the number of steps."""
    lower, upper = limits(configuration.model)
    bounds = [mink.ConfigurationLimit(configuration.model, gain=1.0)]
    cost, damping = _cost(posture, contacts, configuration), DAMPING_LIMITS[0]
    for count in range(1, STEPS + 1):
        before = configuration.q.copy()
        step = mink.solve_ik(configuration, [posture, *contacts], 1.0, "daqp", damping=damping, limits=bounds)
        step *= min(1.0, MAX_STEP / max(float(np.abs(step).max()), 1e-12))
        configuration.update(np.clip(before + step, lower, upper))
        gained = cost - (after := _cost(posture, contacts, configuration))
        if gained < 0.0:
            configuration.update(before)
            damping *= 10.0
            if damping > DAMPING_LIMITS[1]:
                return count
            continue
        cost, damping = after, max(damping / 10.0, DAMPING_LIMITS[0])
        if gained <= MIN_IMPROVEMENT * cost:
            return count
    return STEPS


def _cost(posture: mink.PostureTask, contacts: Sequence[_ContactTask], configuration: mink.Configuration) -> float:
    """Return the cost that steps must reduce."""
    strained = np.sum((posture.cost * posture.compute_error(configuration)) ** 2)
    return float(strained + sum(contact.loss(configuration) for contact in contacts))


def _rank(contact: Contact) -> int:
    return contact.rank
