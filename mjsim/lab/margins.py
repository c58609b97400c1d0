"""Margins of a loop under unity feedback: gain and phase, with their frequencies."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from mjsim.geometry import Array
from mjsim.lab.plane import in_time, nyquist_frequency, on_axis, outward

REAL_TOLERANCE = 1e-9
"""A response is real if its imaginary part is below this fraction of its magnitude, and then crosses no axis; one whose
magnitude changes by less about a frequency does not cross 1 there."""
EDGE_TOLERANCE = 1e-4
"""Poles whose real part is below this fraction of a frequency neither grow nor decay: double ones err by 1e-8."""
MIN_CROSSOVER = 1e-6
"""Crossovers below this fraction of the lowest corner frequency are rounding errors: the gain at 0 is 1."""
GRID = 2000
"""Number of frequencies at which crossovers of a delayed or sampled loop are searched."""


def margins_of(loop: Any, delay: float = 0.0) -> dict[str, float | None]:
    """Return the margins of a loop; None for those that do not exist, or are infinite.

    Args:
        loop: A system of python-control with one input and one output.
        delay: Delay in series, taken into account exactly [s].
    """
    import control

    if delay or loop.dt:
        gains, phases = searched(loop, delay)
    else:
        # The response is undefined at 0 if a zero cancels a pole there.
        with np.errstate(invalid="ignore"):
            found = control.stability_margins(loop, returnall=True)
        gains = list(zip(found[0], found[3], strict=True))
        phases = list(zip(found[1], found[4], strict=True))
    low = MIN_CROSSOVER * _lowest(loop)
    gains = [(gain, at) for gain, at in gains if low < at < math.inf and gain > 0.0 and not _is_real(loop, at, delay)]
    # A static loop of gain -1 at 0 rad/s is at its margin there.
    gains += [] if delay else _static(loop)
    phases = [(phase, at) for phase, at in phases if low < at < math.inf and _crosses(loop, at, delay)]
    gain, at_gain = min(gains, key=lambda pair: abs(math.log(pair[0])), default=(None, None))
    phase, at_phase = min(phases, key=lambda pair: abs(pair[0]), default=(None, None))
    values = (gain, phase, at_gain, at_phase)
    names = ("gain_margin", "phase_margin_deg", "phase_crossover", "gain_crossover")
    return {name: None if value is None else float(value) for name, value in zip(names, values, strict=True)}


def _corners(loop: Any) -> Array:
    """Return the sizes of poles and zeros, except those at 0, in continuous time [rad/s]."""
    corners = np.abs(in_time(np.concatenate([loop.poles(), loop.zeros()]), loop.dt))
    return np.asarray(corners[(corners > REAL_TOLERANCE) & np.isfinite(corners)])


def _lowest(loop: Any) -> float:
    return float(_corners(loop).min(initial=math.inf)) if len(_corners(loop)) else 1.0


def _is_real(loop: Any, omega: float, delay: float) -> bool:
    """Whether the response is real around a frequency, so that its phase crosses nothing there."""
    if delay:
        return False
    if loop.dt and omega >= nyquist_frequency(loop.dt):
        return False
    values = loop(on_axis(omega * np.array([0.7, 1.0, 1.4]), loop.dt))
    return bool((np.abs(values.imag) < REAL_TOLERANCE * np.abs(values)).all())


def _crosses(loop: Any, omega: float, delay: float) -> bool:
    """Whether the curve meets the unit circle at a frequency, other than by rounding.

    A real response, such as that of 1 / s^2, meets it at -1: its margin is 0 if the closed loop oscillates there and
    does not grow elsewhere, else there is none.
    """
    below, above = np.abs(loop(on_axis(omega * np.array([0.99, 1.01]), loop.dt)))
    if abs(above - below) < REAL_TOLERANCE:
        return False
    if not _is_real(loop, omega, delay):
        return True
    import control

    growth = np.max(outward(control.feedback(loop).poles(), loop.dt), initial=0.0) / (loop.dt or 1.0)
    return bool(complex(loop(on_axis(omega, loop.dt))).real < 0.0 and growth < EDGE_TOLERANCE * omega)


def _static(loop: Any) -> list[tuple[float, float]]:
    """Return the gain margin at 0 rad/s of a loop that is negative there."""
    value = float(np.real(loop.dcgain()))
    return [(-1.0 / value, 0.0)] if math.isfinite(value) and value < 0.0 else []


def searched(loop: Any, delay: float) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Return gain margins and phase margins [deg] with their frequencies [rad/s], of a loop delayed or sampled."""
    omega = _sampled_grid(loop) if loop.dt else _delayed_grid(loop, delay)

    def value(at: Any) -> Any:
        return loop(on_axis(at, loop.dt)) * np.exp(-1j * np.asarray(at) * delay)

    crossed = _roots(lambda at: np.abs(value(at)) - 1.0, omega)
    turned = [*_roots(lambda at: np.imag(value(at)), omega), *([nyquist_frequency(loop.dt)] if loop.dt else [])]
    # Beside a pole on the axis the sign changes through infinity.
    turned = [at for at in turned if -1.0 / REAL_TOLERANCE < complex(value(at)).real < -REAL_TOLERANCE * REAL_TOLERANCE]
    gains = [(1.0 / abs(complex(value(at))), at) for at in turned]
    phases = [((math.degrees(np.angle(-complex(value(at)))) + 180.0) % 360.0 - 180.0, at) for at in crossed]
    return gains, phases


def _delayed_grid(loop: Any, delay: float) -> Array:
    corners = np.append(_corners(loop), 1.0 / delay)
    low, high = corners.min() / 1e3, corners.max() * 1e2
    rounds = np.arange(1, min(high * delay / math.pi, GRID)) * math.pi / delay
    return np.unique(np.concatenate([np.geomspace(low, high, GRID), rounds]))


def _sampled_grid(loop: Any) -> Array:
    """Return frequencies up to almost Nyquist's, where the response is real except for rounding [rad/s]."""
    high = nyquist_frequency(loop.dt) * (1.0 - 1e-7)
    low = min(_lowest(loop), high) / 1e3
    return np.unique(np.concatenate([np.geomspace(low, high, GRID), np.linspace(low, high, GRID)]))


def _roots(function: Callable[[Any], Any], omega: Array) -> list[float]:
    """Return the zeros of a function between frequencies at which its sign differs."""
    values = np.asarray(function(omega))
    places = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return [float(brentq(lambda at: float(function(at)), omega[k], omega[k + 1], rtol=1e-13)) for k in places]
