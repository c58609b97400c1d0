"""Trimming: joint values, torques and forces for which a mechanism is in equilibrium."""

import dataclasses

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Apart, BodyPoint, jacobian, residual, solved
from mjsim.sentences import Sentence
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.actuators import ForceActuator, TorqueActuator
from mjsim.world.items.mechanisms.assembly import Assembly
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.ties import end_distance

GRAVITY = 9.81
"""MuJoCo's default [m/s^2]."""
AT_REST = 1e-9
"""Tolerated residual forces, as a fraction of the weight."""
ROUNDS, STEP = 100, 1e-6
MAX_STEP = 0.3
"""Largest change of a value in one iteration [rad, m]."""


def trimmed(mechanism: MechanismParts, found: Assembly, values: Array, held: set[int]) -> Assembly:
    """Return the assembly in equilibrium: joints with a given start stay, all other values are found.

    Args:
        mechanism: Mechanism as written.
        found: Closure with all rows that hold.
        values: Initial guess, shape (values,).
        held: Columns that stay.

    Raises:
        PydanticCustomError: There is no equilibrium near them.
    """
    for number, actuator in enumerate(mechanism.actuators):
        if number in {drive.number for drive in found.drives}:
            raise fault(
                "mode trim finds an equilibrium; use a torque, a force or a start instead of this motion",
                "actuators",
                number,
            )
        if getattr(actuator, "axis", None) is not None:
            raise fault("mode trim supports only torques and forces on joints; leave this one out", "actuators", number)
    balance = _Balance(mechanism, found)
    free = np.setdiff1d(np.arange(found.linkage.size), np.array(sorted(held), dtype=int))
    values, efforts, left = _newton(balance, values, free)
    if left > AT_REST * balance.weight:
        raise fault(
            Sentence(
                "no equilibrium was found near this start: forces of {left:.3g} N or N m are left over; give"
                " torque: JOINT with find: true, or leave out the start of a joint",
                left,
            ),
            "mode",
        )
    return dataclasses.replace(
        found,
        start=values,
        found=dict(zip(balance.sought, efforts.tolist(), strict=True)),
        speeds=np.zeros(found.linkage.size),
    )


class _Balance:
    """Forces on each value of a mechanism at rest."""

    def __init__(self, mechanism: MechanismParts, found: Assembly) -> None:
        self._found = found
        self._masses = []
        for body in mechanism.bodies:
            solid = body.solid()
            self._masses.append((solid.mass, BodyPoint(found.number(body.name), np.array(solid.center))))
        self.weight = GRAVITY * sum(mass for mass, _ in self._masses)
        size = found.linkage.size
        self._stiffness, self._rest, self._known = np.zeros(size), np.zeros(size), np.zeros(size)
        for joint in mechanism.all_joints:
            own = found.columns[joint.name]
            self._stiffness[own.start : own.stop] = joint.figures("stiffness")
            self._rest[own.start : own.stop] = [value or 0.0 for value in joint.spread("rest")]
        self.sought, columns = list[int](), list[int]()
        for number, actuator in enumerate(mechanism.actuators):
            if isinstance(actuator, TorqueActuator | ForceActuator):
                column = found.column(actuator.target)
                if actuator.signal is None:
                    self.sought.append(number)
                    columns.append(column)
                else:
                    rng = np.random.default_rng(0)
                    self._known[column] += float(actuator.signal.made(_no_file, rng).value(0.0))
        self.columns = np.array(columns, dtype=int)

    def forces(self, values: Array) -> Array:
        """Return gravity, springs and known efforts, shape (values,) [N m, N]."""
        linkage = self._found.linkage
        placement, total = linkage.place(values), self._known - self._stiffness * (values - self._rest)
        for mass, center in self._masses:
            rise = linkage.point_jacobian(placement, center.body, center.place(placement))[2]
            total = total - GRAVITY * mass * rise
        for spring in self._found.springs:
            rest = end_distance(self._found, spring.ends, self._found.start) if spring.rest is None else spring.rest
            stretched = Apart(spring.ends, rest)
            by = stretched.jacobian(linkage, placement, values)[0]
            total = total - spring.stiffness * stretched.residual(linkage, placement, values)[0] * by
        return np.asarray(total)

    def left(self, values: Array, efforts: Array, pulls: Array) -> Array:
        """Return the residual forces and the errors of the rows, shape (values + rows,)."""
        found = self._found
        total = self.forces(values) + jacobian(found.linkage, found.rows, values).T @ pulls
        np.add.at(total, self.columns, efforts)
        return np.concatenate([total, residual(found.linkage, found.rows, values)])

    @property
    def rows(self) -> int:
        """Number of rows that constrain the mechanism."""
        return len(residual(self._found.linkage, self._found.rows, self._found.start))


def _no_file(name: str) -> bytes:
    raise ValueError(Sentence("trimming cannot read files such as '{name}'", name))


def _newton(balance: _Balance, values: Array, free: Array) -> tuple[Array, Array, float]:
    """Return values, unknown efforts, and the residual; derivatives are central differences."""
    count, rows = len(balance.sought), balance.rows
    unknown = np.concatenate([values[free], np.zeros(count + rows)])

    def left(unknown: Array) -> Array:
        whole = values.copy()
        whole[free] = unknown[: len(free)]
        return balance.left(whole, unknown[len(free) : len(free) + count], unknown[len(free) + count :])

    for _ in range(ROUNDS):
        residual = left(unknown)
        slopes = []
        for place in range(len(unknown)):
            step = np.zeros(len(unknown))
            step[place] = STEP
            slopes.append((left(unknown + step) - left(unknown - step)) / (2.0 * STEP))
        change = solved(np.column_stack(slopes), -residual)
        largest = float(np.abs(change[: len(free)]).max(initial=0.0))
        unknown = unknown + change * min(1.0, MAX_STEP / max(largest, 1e-300))
        if largest < 1e-13 and np.abs(residual).max() < AT_REST * balance.weight:
            break
    whole = values.copy()
    whole[free] = unknown[: len(free)]
    return whole, unknown[len(free) : len(free) + count], float(np.abs(left(unknown)).max())
