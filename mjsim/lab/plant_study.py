"""Analysis of a linear plant with python-control: the only source of the figures on the laboratory's page."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mjsim.errors import UsageError, how_to_install
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant, minimal_states
from mjsim.lab.locus import RootLocus, finite_zeros, root_locus
from mjsim.lab.margins import margins_of
from mjsim.world import Plant, TransferFunction

POINTS = 400
"""Points of each curve, unless it oscillates many times."""
MAX_POINTS = 4000
"""Maximum number of points of each curve."""
A_SWING = 20
"""Points per period."""
SWINGS = 5
"""Periods shown for a response that neither grows nor decays."""
PADE = 5
"""Order of the approximation of a delay."""
SHOWN = 6.0
"""Duration of responses, in time constants of the slowest pole."""
GROWN = 20.0
"""Growth of an unstable response in the time shown, as a multiple of the start."""
INTEGRATOR = 1e-9
"""Poles closer to 0 count as integrators [rad/s]."""


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
    """Return the linear plant of a transfer function or a state-space model in a world.

    Raises:
        UsageError: Its input affects none of its outputs.
    """
    if plant.tf is not None:
        return _transfer(plant.tf)
    assert plant.ss is not None
    A, B, C = (np.array(part, dtype=float) for part in (plant.ss.a, plant.ss.b, plant.ss.c))
    D = np.zeros((len(C), B.shape[1])) if plant.ss.d is None else np.array(plant.ss.d, dtype=float)
    name, outputs = plant.input or plant.ss.inputs[0], list(plant.outputs or plant.ss.outputs)
    rows, column = [plant.ss.outputs.index(each) for each in outputs], [plant.ss.inputs.index(name)]
    B, C, D = B[:, column], C[rows], D[np.ix_(rows, column)]
    if not minimal_states(A, B, C, coupled=0.0) and not D.any():
        raise UsageError(f"plant '{plant.name}': {name} affects none of {', '.join(outputs)}; name another input")
    return _formula(theory().ss(A, B, C, D), name, outputs)


def _formula(system: Any, name: str, outputs: Sequence[str]) -> LinearPlant:
    A, B, C, D = system.A, system.B, system.C, system.D
    states = tuple(f"x{k + 1}" for k in range(len(A)))
    units = ("",) * (1 + len(outputs))
    return LinearPlant(A=A, B=B, C=C, D=D, states=states, input=name, outputs=tuple(outputs), units=units)


def _transfer(given: TransferFunction) -> LinearPlant:
    """Return the plant of a transfer function, in state space with Pade's approximation of its delay."""
    control = theory()
    system = control.ss(control.tf(list(given.num), list(given.den)))
    undelayed = _formula(system, "u", ["y"])
    if not given.delay:
        return undelayed
    approximation = control.ss(control.tf(*control.pade(given.delay, PADE)))
    return replace(_formula(system * approximation, "u", ["y"]), delay=given.delay, undelayed=undelayed)


def pade_limit(delay: float) -> float:
    """Return the frequency up to which the phase of the approximation of a delay errs by less than 1 deg [rad/s]."""
    control = theory()
    turns = np.linspace(0.0, 4.0 * PADE, 4_000)
    _, phase, _ = control.frequency_response(control.tf(*control.pade(1.0, PADE)), turns)
    wrong = np.abs(np.unwrap(np.asarray(phase)) - phase[0] + turns) > math.radians(1.0)
    return float(turns[np.argmax(wrong)]) / delay


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """The analysis of a plant."""

    plant: LinearPlant
    system: Any
    """System of python-control, with all outputs."""
    loop: Any
    """The system from the input to the first output, used for frequency plots."""
    poles: Array
    """Complex, shape (n,) [rad/s]."""
    zeros: Array
    """Zeros of the first output, complex [rad/s]."""
    margins: dict[str, float | None]
    """Gain margin, phase margin [deg] and their frequencies [rad/s] under unity feedback."""
    locus: RootLocus
    """The root locus of the first output; a delay is approximated."""
    time: Array
    """Shape (k,) [s]."""
    step: Array
    """Responses to a unit step, shape (outputs, k)."""
    impulse: Array
    """Responses to a unit impulse, without the direct term D, shape (outputs, k)."""
    omega: Array
    """Frequencies, shape (m,) [rad/s]."""
    magnitude: Array
    """Magnitude of the first output, shape (m,)."""
    phase: Array
    """Unwrapped phase of the first output, shape (m,) [rad]."""

    @property
    def is_stable(self) -> bool:
        """Whether all poles are in the left half plane."""
        return bool((self.poles.real < 0.0).all())


def study(plant: LinearPlant, *, seconds: float | None = None) -> Study:
    """Analyse a plant.

    Args:
        plant: The linear plant.
        seconds: Duration of responses; by default chosen from the poles [s].
    """
    control = theory()
    system = control.ss(plant.A, plant.B, plant.C, plant.D)
    loop = control.ss(plant.A, plant.B, plant.C[:1], plant.D[:1])
    poles = np.sort_complex(system.poles())
    zeros: Any = np.sort_complex(finite_zeros(loop))
    exact = control.ss(plant.exact.A, plant.exact.B, plant.exact.C[:1], plant.exact.D[:1])
    time = shown_times(exact.poles(), seconds or shown_seconds(exact.poles(), plant.delay))
    omega = frequencies(poles, zeros)
    magnitude, phase, _ = control.frequency_response(exact, omega)
    return Study(
        plant=plant,
        system=system,
        loop=loop,
        poles=poles,
        zeros=zeros,
        margins=margins_of(exact, plant.delay),
        locus=root_locus(loop),
        time=time,
        step=_response(plant, time, np.zeros(len(plant.exact.A)), 1.0),
        impulse=_response(plant, time, plant.exact.B[:, 0], 0.0),
        omega=omega,
        magnitude=np.asarray(magnitude),
        phase=np.unwrap(np.asarray(phase)) - omega * plant.delay,
    )


def _response(plant: LinearPlant, time: Array, start: Array, level: float) -> Array:
    """Return the outputs for a constant input from time 0, from a state, shape (outputs, k); a delay is exact."""
    control, exact = theory(), plant.exact
    system = control.ss(exact.A, exact.B, exact.C, exact.D)
    moving = time >= plant.delay
    found = np.zeros((len(exact.C), len(time)))
    if moving.sum() < 2:
        return found
    later = time[moving] - plant.delay
    if later[0] > 0.0:
        ahead = control.forced_response(system, [0.0, later[0]], [level, level], start, squeeze=False)
        start = ahead.states[:, -1]
    inputs = np.full(len(later), level)
    found[:, moving] = control.forced_response(system, later - later[0], inputs, start, squeeze=False).outputs
    return found


def shown_seconds(poles: Array, delay: float = 0.0) -> float:
    """Return the duration of a response worth showing, after a delay [s]."""
    return delay + _moving_seconds(poles, 10.0 * (delay or 1.0))


def _moving_seconds(poles: Array, otherwise: float) -> float:
    """Return the duration by the poles; `otherwise` if all of them are integrators [s]."""
    growing = float(poles.real.max(initial=0.0))
    if growing > INTEGRATOR:
        return math.log(GROWN) / growing
    moving = poles[np.abs(poles) > INTEGRATOR]
    settling = np.abs(moving.real)[np.abs(moving.real) > 1e-6 * np.abs(moving)]
    if len(settling):
        return SHOWN / float(settling.min())
    return SWINGS * 2.0 * math.pi / float(np.abs(moving).min()) if len(moving) else otherwise


def shown_times(poles: Array, seconds: float) -> Array:
    """Return evenly spaced times, close enough for the fastest oscillating pole, shape (k,) [s]."""
    swings = seconds * float(np.abs(poles.imag).max(initial=0.0)) / (2.0 * math.pi)
    return np.linspace(0.0, seconds, min(max(POINTS, math.ceil(A_SWING * swings)), MAX_POINTS))


def frequencies(poles: Array, zeros: Array) -> Array:
    """Return frequencies up to two decades beyond all poles and zeros, shape (POINTS,) [rad/s]."""
    sizes = np.abs(np.concatenate([poles, zeros]))
    sizes = sizes[sizes > INTEGRATOR]
    low, high = (float(sizes.min()), float(sizes.max())) if len(sizes) else (1.0, 1.0)
    return np.geomspace(low / 100.0, high * 100.0, POINTS)
