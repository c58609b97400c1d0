"""The planes of poles: s in continuous time, z in discrete time; a sampling period of 0 means continuous time."""

from typing import Any

import numpy as np

from mjsim.geometry import Array

AT_ORIGIN = 1e-6
"""Poles in discrete time closer to 0 than this act as delays of some periods."""


def on_axis(omega: Any, dt: float) -> Any:
    """Return s = j omega, or z = exp(j omega dt) [rad/s, s]."""
    return np.exp(1j * np.asarray(omega) * dt) if dt else 1j * np.asarray(omega)


def outward(roots: Any, dt: float) -> Array:
    """Return how far roots are outside the stable region: right of the imaginary axis, or outside the unit circle."""
    return np.asarray(np.abs(roots) - 1.0 if dt else np.real(roots), dtype=float)


def on_boundary(root: complex, dt: float) -> complex:
    """Return the point of the imaginary axis, or of the unit circle, nearest to a root."""
    return root / abs(root) if dt else complex(0.0, root.imag)


def in_time(roots: Array, dt: float) -> Array:
    """Return roots in continuous time, log(z) / dt, complex [rad/s]; those at z = 0 have none and are left out."""
    return np.asarray(np.log(roots[np.abs(roots) > AT_ORIGIN].astype(complex)) / dt) if dt else roots


def nyquist_frequency(dt: float) -> float:
    """Return the highest frequency that samples can represent [rad/s]."""
    return float(np.pi / dt)
