"""A plant identified from what went in and came out, and how well a model fits that."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import lfilter

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant
from mjsim.lab.study import theory

Complexes = NDArray[np.complex128]

FEWEST = 50
"""Samples that are worth identifying from."""
UNSTABLE = 1e-6
"""Real part of a pole of a plant that runs away by itself [rad/s]."""
HUGE = 1e6
"""A model that misses by more is no better for it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """What went in and came out."""

    time: Array
    """Evenly spaced, shape (k,) [s]."""
    inputs: Array
    """Shape (k,)."""
    outputs: Array
    """Shape (outputs, k)."""
    source: str
    held: bool = True
    """Whether each input is held until the next; else the input changes evenly between them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identified:
    """A model from samples, and how both models fit them."""

    samples: Samples
    poles: Complexes
    """Of the identified model, as continuous ones, log(z) / dt, complex [rad/s]."""
    linear: Array
    """What the linear plant does, shape (outputs, k)."""
    model: Array
    """What the identified model does, shape (outputs, k)."""
    linear_fit: Array
    """For each output [%]."""
    model_fit: Array
    """For each output [%]."""


def fit(measured: Array, model: Array) -> Array:
    """Return how well a model fits, 100 % being exact and 0 % no better than the mean, shape (outputs,) [%].

    References:
        Ljung, System Identification (1999), section 16.4: 100 (1 - |y - model| / |y - mean|).
    """
    spread = np.linalg.norm(measured - measured.mean(axis=-1, keepdims=True), axis=-1)
    missed = np.linalg.norm(measured - model, axis=-1)
    return np.asarray(100.0 * (1.0 - missed / np.maximum(spread, 1e-300)))


def identified(plant: LinearPlant, samples: Samples) -> Identified:
    """Identify a discrete transfer function for each output, and compare it and the plant with samples from rest.

    Each has as many poles as the plant. Least squares of the difference equation (ARX) are the first guess; then the
    squares of what a simulation misses (output error) are minimised.

    Raises:
        UsageError: There are too few samples, the input does not change, or the plant runs away by itself.

    References:
        Ljung, System Identification (1999), sections 4.2 and 10.2.
    """
    count = len(samples.time)
    if count < FEWEST or not np.ptp(samples.inputs) > 0.0:
        raise UsageError(f"{samples.source} has {count} samples of an input that changes too little to identify from")
    dt = float(samples.time[1] - samples.time[0])
    if (np.linalg.eigvals(plant.A).real > UNSTABLE).any():
        raise UsageError("the plant is not stable, so that no model without its controller can follow a recording")
    y = samples.outputs - samples.outputs[:, :1]
    direct = (plant.D != 0.0).any(axis=1) | (not samples.held)
    models = [_output_error(samples.inputs, row, len(plant.A), int(now)) for row, now in zip(y, direct, strict=True)]
    control = theory()
    linear = _driven(control.ss(plant.A, plant.B, plant.C, plant.D), samples)
    model = np.array([_follow(law, samples.inputs) for law in models])
    z = np.roots(models[0][1]).astype(complex)
    poles = np.log(np.where(np.abs(z) < 1e-12, 1e-12, z)) / dt
    return Identified(
        samples=samples,
        poles=np.sort_complex(poles),
        linear=linear,
        model=model,
        linear_fit=fit(y, linear),
        model_fit=fit(y, model),
    )


def _follow(law: tuple[Array, Array], inputs: Array) -> Array:
    """Return what a discrete transfer function (numerator, denominator in powers of 1/z) makes of inputs."""
    return np.asarray(lfilter(*law, inputs))


def _output_error(u: Array, y: Array, order: int, direct: int) -> tuple[Array, Array]:
    """Return numerator and denominator in powers of 1/z; an input acts a sample later, or at once if direct is 1."""
    rows = np.arange(order, len(u))
    past = [*(-y[rows - k] for k in range(1, order + 1)), *(u[rows - k] for k in range(1 - direct, order + 1))]
    guess = np.linalg.lstsq(np.array(past).T, y[rows], rcond=None)[0]

    def law(values: Array) -> tuple[Array, Array]:
        ahead = np.zeros(1 - direct)
        return np.concatenate([ahead, values[order:]]), np.concatenate([[1.0], values[:order]])

    def missed(values: Array) -> Array:
        with np.errstate(over="ignore", invalid="ignore"):
            return np.nan_to_num(np.clip(_follow(law(values), u) - y, -HUGE, HUGE), nan=HUGE)

    best = least_squares(missed, guess, x_scale=np.maximum(np.abs(guess), 1e-6))
    return law(best.x)


def _driven(system: Any, samples: Samples) -> Array:
    """Return what a system does from rest under the inputs, shape (outputs, k)."""
    control = theory()
    dt = float(samples.time[1] - samples.time[0])
    # python-control lets the input of a continuous system change evenly between samples.
    sampled = control.sample_system(system, dt, "zoh") if samples.held else system
    _, response = control.forced_response(sampled, np.arange(len(samples.time)) * dt, samples.inputs, squeeze=False)
    return np.asarray(response)
