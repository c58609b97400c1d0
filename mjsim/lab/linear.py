"""Linearisation of a part of a scene about an equilibrium: x' = A x + B u, y = C x + D u."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.lab.reduced import Reduced, Setting

Truths = NDArray[np.bool_]
DIFFERENCE_STEP = 2e-4
"""Step of the differences [rad, m, and so on]; their error is of fourth order in it."""
NOISE_RATIO = 1e-8
"""Numerical noise of the differences, as a fraction of the largest element of the matrix."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearPlant:
    """A linear plant with names of inputs, outputs and states."""

    A: Array
    """Shape (n, n)."""
    B: Array
    """Shape (n, 1)."""
    C: Array
    """Shape (outputs, n)."""
    D: Array
    """Shape (outputs, 1)."""
    states: tuple[str, ...]
    input: str
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    """Units of the input, then of the outputs."""
    dt: float = 0.0
    """Sampling period of a plant in discrete time; 0 in continuous time [s]."""
    delay: float = 0.0
    """Delay that A, B, C, D approximate [s]; in discrete time they contain it exactly, and this is 0."""
    undelayed: "LinearPlant | None" = None
    """The plant without its delay; None if it has none."""

    @property
    def parts(self) -> tuple[Array, Array, Array, Array, float]:
        """A, B, C, D and the sampling period, as python-control takes them."""
        return self.A, self.B, self.C, self.D, self.dt

    @property
    def exact(self) -> "LinearPlant":
        """The plant without any approximation of a delay."""
        return self.undelayed or self


def slope(function: Callable[[float], Array], step: float = DIFFERENCE_STEP) -> Array:
    """Return the derivative of a function at 0, by fourth-order central differences.

    References:
        Fornberg, Generation of Finite Difference Formulas on Arbitrarily Spaced Grids (1988), table 1.
    """
    inner = function(step) - function(-step)
    outer = function(2 * step) - function(-2 * step)
    return np.asarray((8.0 * inner - outer) / (12.0 * step))


def linearised(
    reduced: Reduced,
    setting: Setting,
    *,
    measure: Sequence[Callable[[Array], float]],
) -> tuple[Array, Array, Array]:
    """Return A, B and the derivatives of the measured values by the coordinates.

    Args:
        reduced: The part, in independent coordinates.
        setting: The operating point, an equilibrium.
        measure: Functions that return a value for positions, shape (nq,).

    Returns:
        A: For coordinates, their rates, and activations, shape (2 n + na, 2 n + na).
        B: Shape (2 n + na, 1).
        Y: Derivatives of the values by the coordinates, shape (values, n).
    """
    n, na = len(reduced.coordinates), len(setting.act)
    axes, none = np.eye(n), np.zeros(n)
    A, B = np.zeros((2 * n + na, 2 * n + na)), np.zeros((2 * n + na, 1))
    A[:n, n : 2 * n] = np.eye(n)

    def pushed(place: Setting, rates: Array) -> Array:
        return np.concatenate([reduced.acceleration(place, rates), reduced.activation_rate(place)])

    for k in range(n):
        A[n:, k] = slope(lambda h, e=axes[k]: pushed(reduced.moved(setting, h * e), none))  # type: ignore[misc]
        A[n:, n + k] = slope(lambda h, e=axes[k]: pushed(setting, h * e))  # type: ignore[misc]
    for k, e in enumerate(np.eye(na)):
        A[n:, 2 * n + k] = slope(lambda h, e=e: pushed(replace(setting, act=setting.act + h * e), none))  # type: ignore[misc]
    B[n:, 0] = slope(lambda h: pushed(replace(setting, value=setting.value + h), none))
    Y = [slope(lambda h, e=e: np.array([m(reduced.moved(setting, h * e).qpos) for m in measure])) for e in axes]  # type: ignore[misc]
    return A, B, np.array(Y).T.reshape(len(measure), n)


def minimal_states(A: Array, B: Array, C: Array, *, coupled: float = NOISE_RATIO) -> list[int]:
    """Return the indices of the states that are reachable from the input and observable in an output, in order.

    Elements below `coupled` times the largest of their matrix count as zero.
    """
    moves = np.abs(A) > coupled * max(float(np.abs(A).max(initial=0.0)), 1.0)
    driven = _closure(moves, np.abs(B).max(axis=1) > coupled * float(np.abs(B).max(initial=0.0)))
    seen = _closure(moves.T, np.abs(C).max(axis=0) > coupled * float(np.abs(C).max(initial=0.0)))
    return [int(state) for state in np.flatnonzero(driven & seen)]


def _closure(leads: Truths, start: Truths) -> Truths:
    """Return the set reachable from `start`; `leads[i, j]` says whether j leads to i."""
    found = start.copy()
    for _ in range(len(found)):
        found = found | (leads @ found)
    return found
