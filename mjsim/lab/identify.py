"""Identification of a plant from inputs and outputs, and the fit of models."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import lfilter

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant
from mjsim.lab.plant_study import system_of, theory

Complexes = NDArray[np.complex128]

MIN_SAMPLES = 50
"""Minimum number of samples."""
MIN_UNSTABLE_POLE = 1e-6
"""Real part above which a pole makes the plant unstable [rad/s]."""
MAX_RESIDUAL = 1e6
"""Residuals are clipped at this value."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """Input and output samples."""

    time: Array
    """Evenly spaced, shape (k,) [s]."""
    inputs: Array
    """Shape (k,)."""
    outputs: Array
    """Shape (outputs, k)."""
    source: str
    held: bool = True
    """Whether each input is held until the next; otherwise the input is interpolated linearly."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identified:
    """A model identified from samples, and the fit of both models."""

    samples: Samples
    poles: Complexes
    """Poles of the identified model in continuous time, log(z) / dt, complex [rad/s]."""
    linear: Array
    """Response of the linear plant, shape (outputs, k)."""
    model: Array
    """Response of the identified model, shape (outputs, k)."""
    linear_fit: Array
    """Fit of the linear plant for each output [%]."""
    model_fit: Array
    """Fit of the identified model for each output [%]."""


def fit(measured: Array, model: Array) -> Array:
    """Return the fit of a model, 100 % for an exact one and 0 % for the mean, shape (outputs,) [%].

    References:
        Ljung, System Identification (1999), section 16.4: 100 (1 - |y - model| / |y - mean|).
    """
    deviation = np.linalg.norm(measured - measured.mean(axis=-1, keepdims=True), axis=-1)
    missed = np.linalg.norm(measured - model, axis=-1)
    return np.asarray(100.0 * (1.0 - missed / np.maximum(deviation, 1e-300)))


def identified(plant: LinearPlant, samples: Samples) -> Identified:
    """Identify a discrete transfer function for each output, and compare it and the plant with samples from rest.

    Each has as many poles as the plant. Least squares on the difference equation (ARX) gives the initial guess; then
    the squared simulation errors are minimised (output error).

    Raises:
        UsageError: There are too few samples, the input is constant, or the plant is unstable.

    References:
        Ljung, System Identification (1999), sections 4.2 and 10.2.
    """
    count = len(samples.time)
    if count < MIN_SAMPLES or not np.ptp(samples.inputs) > 0.0:
        raise UsageError(f"{samples.source} has {count} samples of an input that changes too little for identification")
    dt = float(samples.time[1] - samples.time[0])
    if (np.linalg.eigvals(plant.A).real > MIN_UNSTABLE_POLE).any():
        raise UsageError("the plant is unstable, so it cannot be identified from a recording without its controller")
    y = samples.outputs - samples.outputs[:, :1]
    direct = (plant.D != 0.0).any(axis=1) | (not samples.held)
    models = [_output_error(samples.inputs, row, len(plant.A), int(now)) for row, now in zip(y, direct, strict=True)]
    linear = _driven(system_of(plant), samples)
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
    """Return the output of a discrete transfer function (numerator, denominator in powers of 1/z)."""
    return np.asarray(lfilter(*law, inputs))


def _output_error(u: Array, y: Array, order: int, direct: int) -> tuple[Array, Array]:
    """Return numerator and denominator in powers of 1/z; inputs act one sample later, or at once if `direct` is 1."""
    rows = np.arange(order, len(u))
    past = [*(-y[rows - k] for k in range(1, order + 1)), *(u[rows - k] for k in range(1 - direct, order + 1))]
    guess = np.linalg.lstsq(np.array(past).T, y[rows], rcond=None)[0]

    def law(values: Array) -> tuple[Array, Array]:
        ahead = np.zeros(1 - direct)
        return np.concatenate([ahead, values[order:]]), np.concatenate([[1.0], values[:order]])

    def missed(values: Array) -> Array:
        with np.errstate(over="ignore", invalid="ignore"):
            return np.nan_to_num(np.clip(_follow(law(values), u) - y, -MAX_RESIDUAL, MAX_RESIDUAL), nan=MAX_RESIDUAL)

    best = least_squares(missed, guess, x_scale=np.maximum(np.abs(guess), 1e-6))
    return law(best.x)


def _driven(system: Any, samples: Samples) -> Array:
    """Return the response of a system at rest to the inputs, shape (outputs, k)."""
    control = theory()
    dt = float(samples.time[1] - samples.time[0])
    # python-control interpolates the input of a continuous system linearly between samples.
    sampled = control.sample_system(system, dt, "zoh") if samples.held else system
    _, response = control.forced_response(sampled, np.arange(len(samples.time)) * dt, samples.inputs, squeeze=False)
    return np.asarray(response)
