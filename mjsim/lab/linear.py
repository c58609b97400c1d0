"""A part of a scene made linear about rest: x' = A x + B u, y = C x + D u."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.lab.reduced import Reduced, Setting

Truths = NDArray[np.bool_]
STEP = 2e-4
"""Of the differences [rad, m, and so on]; the error is of its fourth power."""
COUPLED = 1e-8
"""What differences leave of a zero, of the largest in its matrix."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearPlant:
    """A linear plant with names."""

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
    """Of the input, then of the outputs."""


def slope(function: Callable[[float], Array], step: float = STEP) -> Array:
    """Return the derivative of a function at 0, from centred differences of fourth order.

    References:
        Fornberg, Generation of Finite Difference Formulas on Arbitrarily Spaced Grids (1988), table 1.
    """
    near = function(step) - function(-step)
    far = function(2 * step) - function(-2 * step)
    return np.asarray((8.0 * near - far) / (12.0 * step))


def linearised(
    reduced: Reduced,
    setting: Setting,
    *,
    measure: Sequence[Callable[[Array], float]],
) -> tuple[Array, Array, Array]:
    """Return A, B and the slopes of the measured values by the coordinates.

    Args:
        reduced: The part, in its coordinates.
        setting: The working point, an equilibrium.
        measure: Each returns a value of a position, shape (nq,).

    Returns:
        A: Of coordinates, their rates, and activations, shape (2 n + na, 2 n + na).
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


def kept_states(A: Array, B: Array, C: Array, *, coupled: float = COUPLED) -> list[int]:
    """Return which states the input moves and an output shows, in their order.

    What is smaller than `coupled`, of the largest in its matrix, couples nothing.
    """
    moves = np.abs(A) > coupled * max(float(np.abs(A).max(initial=0.0)), 1.0)
    driven = _closure(moves, np.abs(B).max(axis=1) > coupled * float(np.abs(B).max(initial=0.0)))
    seen = _closure(moves.T, np.abs(C).max(axis=0) > coupled * float(np.abs(C).max(initial=0.0)))
    return [int(state) for state in np.flatnonzero(driven & seen)]


def _closure(leads: Truths, start: Truths) -> Truths:
    """Return what can be reached; `leads[i, j]` says whether j leads to i."""
    found = start.copy()
    for _ in range(len(found)):
        found = found | (leads @ found)
    return found
