"""What python-control says of a linear plant: the figures of the laboratory's page come from here alone."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.errors import UsageError, how_to_install
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant, kept_states
from mjsim.world import Plant, TransferFunction

POINTS = 400
"""Of each curve, unless it swings often."""
MOST_POINTS = 4000
"""Of each curve."""
A_SWING = 20
"""Points of a period."""
SWINGS = 5
"""Periods shown of what neither grows nor settles."""
PADE = 5
"""Order of the approximation of a delay."""
SHOWN = 6.0
"""Time constants of the slowest pole for which responses are shown."""
GROWN = 20.0
"""How many times as large as at the start an unstable response gets in the time shown."""
INTEGRATOR = 1e-9
"""A pole nearer to 0 is one of an integrator [rad/s]."""


def theory() -> Any:
    """Return python-control.

    Raises:
        UsageError: It is not installed.
    """
    try:
        import control
    except ImportError:
        raise UsageError(f"the laboratory needs python-control; type: {how_to_install('control')}") from None
    return control


def formula_plant(plant: Plant) -> LinearPlant:
    """Return the linear plant of a transfer function or a state space of a world.

    Raises:
        UsageError: Its input moves none of its outputs.
    """
    if plant.tf is not None:
        A, B, C, D = _transfer(plant.tf)
        name, outputs = "u", ["y"]
    else:
        assert plant.ss is not None
        A, B, C = (np.array(part, dtype=float) for part in (plant.ss.a, plant.ss.b, plant.ss.c))
        D = np.zeros((len(C), B.shape[1])) if plant.ss.d is None else np.array(plant.ss.d, dtype=float)
        name, outputs = plant.input or plant.ss.inputs[0], list(plant.outputs or plant.ss.outputs)
        rows, column = [plant.ss.outputs.index(each) for each in outputs], [plant.ss.inputs.index(name)]
        B, C, D = B[:, column], C[rows], D[np.ix_(rows, column)]
    if not kept_states(A, B, C, coupled=0.0) and not D.any():
        raise UsageError(f"plant '{plant.name}': {name} moves none of {', '.join(outputs)}; name another input")
    states = tuple(f"x{k + 1}" for k in range(len(A)))
    units = ("",) * (1 + len(outputs))
    return LinearPlant(A=A, B=B, C=C, D=D, states=states, input=name, outputs=tuple(outputs), units=units)


def _transfer(given: TransferFunction) -> tuple[Array, ...]:
    """Return A, B, C, D of a transfer function, its delay by Pade's approximation."""
    control = theory()
    found = control.ss(control.tf(list(given.num), list(given.den)))
    if given.delay:
        found = found * control.ss(control.tf(*control.pade(given.delay, PADE)))
    return found.A, found.B, found.C, found.D


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """A plant looked at."""

    plant: LinearPlant
    system: Any
    """Of python-control, with all outputs."""
    loop: Any
    """The system from the input to the first output, which the plots of frequencies are of."""
    poles: Array
    """Complex, shape (n,) [rad/s]."""
    zeros: Array
    """Those of the first output, complex [rad/s]."""
    margins: dict[str, float | None]
    """Gain margin, phase margin [deg] and their frequencies [rad/s] of the plant under unity feedback."""
    time: Array
    """Shape (k,) [s]."""
    step: Array
    """Responses to a unit step, shape (outputs, k)."""
    impulse: Array
    """Responses to a unit impulse, without what D passes on at once, shape (outputs, k)."""
    omega: Array
    """Frequencies, shape (m,) [rad/s]."""
    magnitude: Array
    """Of the first output, shape (m,)."""
    phase: Array
    """Unwrapped, shape (m,) [rad]."""

    @property
    def is_stable(self) -> bool:
        """Whether all poles lie in the left half plane."""
        return bool((self.poles.real < 0.0).all())


def study(plant: LinearPlant, *, seconds: float | None = None) -> Study:
    """Look at a plant.

    Args:
        plant: Linear.
        seconds: How long responses last; by default as the poles need.
    """
    control = theory()
    system = control.ss(plant.A, plant.B, plant.C, plant.D)
    loop = control.ss(plant.A, plant.B, plant.C[:1], plant.D[:1])
    poles = np.sort_complex(system.poles())
    time = shown_times(poles, seconds or shown_seconds(poles))
    _, step = control.step_response(system, time, squeeze=False)
    # What D adds to it has no height; python-control warns that it leaves that out.
    moving = control.ss(plant.A, plant.B, plant.C, np.zeros_like(plant.D))
    _, impulse = control.impulse_response(moving, time, squeeze=False)
    omega = frequencies(poles, loop.zeros())
    magnitude, phase, _ = control.frequency_response(loop, omega)
    return Study(
        plant=plant,
        system=system,
        loop=loop,
        poles=poles,
        zeros=np.sort_complex(loop.zeros()),
        margins=margins_of(loop),
        time=time,
        step=step[:, 0, :],
        impulse=impulse[:, 0, :],
        omega=omega,
        magnitude=np.asarray(magnitude),
        phase=np.unwrap(np.asarray(phase)),
    )


def margins_of(loop: Any) -> dict[str, float | None]:
    """Return the margins of a loop; None where there is none."""
    gain, phase, at_gain, at_phase = theory().margin(loop)
    names = ("gain_margin", "phase_margin_deg", "phase_crossover", "gain_crossover")
    return {
        name: float(value) if math.isfinite(value) else None
        for name, value in zip(names, (gain, phase, at_gain, at_phase), strict=True)
    }


def shown_seconds(poles: Array) -> float:
    """Return how long a response is worth looking at [s]."""
    growing = float(poles.real.max(initial=0.0))
    if growing > INTEGRATOR:
        return math.log(GROWN) / growing
    moving = poles[np.abs(poles) > INTEGRATOR]
    settling = np.abs(moving.real)[np.abs(moving.real) > 1e-6 * np.abs(moving)]
    if len(settling):
        return SHOWN / float(settling.min())
    return SWINGS * 2.0 * math.pi / float(np.abs(moving).min()) if len(moving) else 10.0


def shown_times(poles: Array, seconds: float) -> Array:
    """Return evenly spaced times, enough of them for the fastest pole that swings, shape (k,) [s]."""
    swings = seconds * float(np.abs(poles.imag).max(initial=0.0)) / (2.0 * math.pi)
    return np.linspace(0.0, seconds, min(max(POINTS, math.ceil(A_SWING * swings)), MOST_POINTS))


def frequencies(poles: Array, zeros: Array) -> Array:
    """Return frequencies two decades beyond all poles and zeros, shape (POINTS,) [rad/s]."""
    sizes = np.abs(np.concatenate([poles, zeros]))
    sizes = sizes[sizes > INTEGRATOR]
    low, high = (float(sizes.min()), float(sizes.max())) if len(sizes) else (1.0, 1.0)
    return np.geomspace(low / 100.0, high * 100.0, POINTS)
