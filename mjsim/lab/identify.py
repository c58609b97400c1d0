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
from mjsim.record import Recording, Track
from mjsim.world import Plant

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
    """Held until the next, shape (k,)."""
    outputs: Array
    """Shape (outputs, k)."""
    source: str


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
    models = [_output_error(samples.inputs, row, len(plant.A)) for row in y]
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


def _output_error(u: Array, y: Array, order: int) -> tuple[Array, Array]:
    """Return numerator and denominator in powers of 1/z; an input acts on the next sample at the earliest."""
    rows = np.arange(order, len(u))
    past = [*(-y[rows - k] for k in range(1, order + 1)), *(u[rows - k] for k in range(1, order + 1))]
    guess = np.linalg.lstsq(np.array(past).T, y[rows], rcond=None)[0]

    def law(values: Array) -> tuple[Array, Array]:
        return np.concatenate([[0.0], values[order:]]), np.concatenate([[1.0], values[:order]])

    def missed(values: Array) -> Array:
        with np.errstate(over="ignore", invalid="ignore"):
            return np.nan_to_num(np.clip(_follow(law(values), u) - y, -HUGE, HUGE), nan=HUGE)

    best = least_squares(missed, guess, x_scale=np.maximum(np.abs(guess), 1e-6))
    return law(best.x)


def _driven(system: Any, samples: Samples) -> Array:
    """Return what a system does from rest under inputs that are held between samples, shape (outputs, k)."""
    control = theory()
    dt = float(samples.time[1] - samples.time[0])
    sampled = system if system.isdtime(strict=True) else control.sample_system(system, dt, "zoh")
    _, response = control.forced_response(sampled, np.arange(len(samples.time)) * dt, samples.inputs, squeeze=False)
    return np.asarray(response)


def recorded(recording: Recording, plant: Plant) -> Samples:
    """Return what a recording says of a plant's input and outputs.

    Raises:
        UsageError: It does not have them.
    """
    assert plant.of is not None
    assert plant.outputs is not None
    robot = plant.of.partition("/")[0]
    if robot not in recording.robots and plant.of not in recording.joints:
        raise UsageError(f"the recording has no '{plant.of}'")
    values = _values(recording, plant.of)
    for name in (plant.input, *plant.outputs):
        if name not in values["in" if name == plant.input else "out"]:
            kind = "input" if name == plant.input else "output"
            raise UsageError(f"the recording does not have {kind} '{name}' of {plant.of}, so it tells nothing of it")
    inputs = values["in"][str(plant.input)]
    outputs = np.array([values["out"][name] for name in plant.outputs])
    known = np.isfinite(inputs) & np.isfinite(outputs).all(axis=0)
    time = recording.time[known]
    return Samples(time=time, inputs=inputs[known], outputs=outputs[:, known], source="the recording")


def _values(recording: Recording, of: str) -> dict[str, dict[str, Array]]:
    """Return inputs and outputs by their names, each of shape (ticks,)."""
    values: dict[str, dict[str, Array]] = {"in": {}, "out": {}}
    if of in recording.robots:
        _add_base(values, recording.time, recording.robots[of])
    for name, track in recording.joints.items():
        if name in (of, f"{of}/drive"):
            for column, joint in enumerate(track.names):
                values["in"][joint] = track.torques[:, column]
                values["out"][joint] = track.positions[:, column]
                values["out"][f"{joint}.rate"] = track.velocities[:, column]
        if name == f"{of}/drive":
            values["in"]["torque"] = track.torques.sum(axis=1)
    return values


def _add_base(values: dict[str, dict[str, Array]], time: Array, track: Track) -> None:
    """Add what is commanded and where a base is; `way` is along its heading at the start."""
    values["in"] |= {"forward": track.command[:, 0], "turn": track.command[:, 2]}
    x, y, heading = track.truth.T
    way = (x - x[0]) * np.cos(heading[0]) + (y - y[0]) * np.sin(heading[0])
    turned = np.unwrap(heading) - heading[0]
    values["out"] |= {"way": way, "heading": turned}
    for name, series in (("way", way), ("heading", turned)):
        # The mean over the last tick: what a command did, none of what the next one will do.
        rate = np.diff(series) / np.diff(time)
        values["out"][f"{name}.rate"] = np.concatenate([[0.0], rate])
