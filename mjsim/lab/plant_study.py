"""Analysis of a linear plant with python-control: the only source of the numbers on the laboratory's page."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mjsim.errors import UsageError, how_to_install
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant
from mjsim.lab.locus import LocusMark, RootLocus, finite_zeros, root_locus
from mjsim.lab.margins import margins_of, searched
from mjsim.lab.plane import in_time, nyquist_frequency, on_axis, outward

CURVE_POINTS = 400
"""Points of each curve, unless it oscillates many times."""
MAX_POINTS = 4000
"""Maximum number of points of each curve."""
A_SWING = 20
"""Number of points per period of an oscillation."""
SHOWN_PERIODS = 5
"""Periods shown for a response that neither grows nor decays."""
SHOWN_TIME_CONSTANTS = 6.0
"""Duration of responses, in time constants of the slowest pole."""
SHOWN_GROWTH = 20.0
"""Growth of an unstable response in the time shown, as a multiple of the start."""
MAX_MARK_ERROR = 0.01
"""Maximum error of the loop transfer function, ideally -1, where branches of a delayed loop meet."""
MAX_INTEGRATOR_POLE = 1e-9
"""Poles closer to 0 count as integrators [rad/s]."""

ZERO_TOLERANCE = 1e-6
"""Poles and zeros below this are integrators and differentiators, up to rounding [rad/s]."""


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


def system_of(plant: LinearPlant) -> Any:
    """Return a plant as a system of python-control, with all outputs."""
    return theory().ss(*plant.parts)


def first_output(plant: LinearPlant) -> Any:
    """Return the system of python-control from the input to the first output."""
    return theory().ss(plant.A, plant.B, plant.C[:1], plant.D[:1], plant.dt)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """The analysis of a plant."""

    plant: LinearPlant
    system: Any
    """System of python-control, with all outputs."""
    loop: Any
    """The system from the input to the first output, used for frequency plots."""
    poles: Array
    """Complex, shape (n,): of s [rad/s], or of z in discrete time."""
    zeros: Array
    """Zeros of the first output, likewise."""
    margins: dict[str, float | None]
    """Gain margin, phase margin [deg] and their frequencies [rad/s] under unity feedback."""
    locus: RootLocus
    """The root locus of the first output; a delay is approximated."""
    time: Array
    """Shape (k,) [s]."""
    step: Array
    """Responses to a unit step, shape (outputs, k)."""
    impulse: Array
    """Responses to a unit impulse, without the direct term D, shape (outputs, k); in discrete time to 1 / dt in the
    first period."""
    omega: Array
    """Frequencies, shape (m,) [rad/s]."""
    magnitude: Array
    """Magnitude of the first output, shape (m,)."""
    phase: Array
    """Unwrapped phase of the first output, shape (m,) [rad]."""

    @property
    def is_stable(self) -> bool:
        """Whether all poles are in the left half plane, or in the unit circle."""
        return bool((outward(self.poles, self.plant.dt) < 0.0).all())

    @property
    def is_stable_closed(self) -> bool:
        """Whether the loop of gain 1 is stable; for an unstable one, the margins say how far it is from stability."""
        if self.plant.delay and self.is_stable:
            # Its poles first reach the axis at the smallest of these gains, which are exact.
            return all(crossing.gain > 1.0 for crossing in self.locus.crossings)
        return bool((outward(self.locus.unity, self.plant.dt) < 0.0).all())


def study(plant: LinearPlant, *, seconds: float | None = None) -> Study:
    """Analyse a plant.

    Args:
        plant: The linear plant.
        seconds: Duration of responses; by default chosen from the poles [s].
    """
    loop, exact, dt = first_output(plant), first_output(plant.exact), plant.dt
    poles = np.sort_complex(loop.poles())
    zeros: Any = np.sort_complex(finite_zeros(loop))
    time = shown_times(exact.poles(), seconds or shown_seconds(exact.poles(), plant.delay, dt), dt)
    omega = frequencies(poles, zeros, dt)
    value = np.asarray(exact(on_axis(omega, dt), squeeze=False))[0, 0]
    return Study(
        plant=plant,
        system=system_of(plant),
        loop=loop,
        poles=poles,
        zeros=zeros,
        margins=margins_of(exact, plant.delay),
        locus=_with_exact_marks(root_locus(loop), plant),
        time=time,
        step=_response(plant, time, np.zeros(len(plant.exact.A)), 1.0),
        impulse=_impulse(plant, time),
        omega=omega,
        magnitude=np.abs(value),
        phase=_phase(value, poles, zeros, dt) - omega * plant.delay,
    )


def _phase(value: Array, poles: Array, zeros: Array, dt: float) -> Array:
    """Return the unwrapped phase; it begins at -90 degrees for each integrator, as far as its sign allows [rad]."""
    phase = np.unwrap(np.angle(value))
    integrators = _at_zero(poles, dt) - _at_zero(zeros, dt)
    turns = (-integrators * np.pi / 2.0 - phase[0]) / (2.0 * np.pi)
    # A negative gain begins at 180 degrees, whatever the rounding.
    return np.asarray(phase + 2.0 * np.pi * np.ceil(turns - 0.5 + 1e-6))


def _at_zero(roots: Array, dt: float) -> int:
    return int((np.abs(in_time(roots, dt)) < ZERO_TOLERANCE).sum())


def _impulse(plant: LinearPlant, time: Array) -> Array:
    if not plant.dt:
        return _response(plant, time, plant.exact.B[:, 0], 0.0)
    after = _response(plant, time, plant.B[:, 0], 0.0)
    return np.hstack([plant.D, after[:, :-1]]) / plant.dt


def _response(plant: LinearPlant, time: Array, start: Array, level: float) -> Array:
    """Return the outputs for a constant input from time 0, from a state, shape (outputs, k); a delay is exact."""
    control, exact = theory(), plant.exact
    system = system_of(exact)
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


def shown_seconds(poles: Array, delay: float = 0.0, dt: float = 0.0) -> float:
    """Return the duration of a response worth showing, after a delay; poles are of z if there is a period dt [s]."""
    if dt:
        # A pole at 0 delays by a period.
        return max(_moving_seconds(in_time(poles, dt), dt), (2 * len(poles) + 8) * dt)
    return delay + _moving_seconds(poles, 10.0 * (delay or 1.0))


def _moving_seconds(poles: Array, otherwise: float) -> float:
    """Return the duration by the poles; `otherwise` if all of them are integrators [s]."""
    growing = float(poles.real.max(initial=0.0))
    if growing > MAX_INTEGRATOR_POLE:
        return math.log(SHOWN_GROWTH) / growing
    moving = poles[np.abs(poles) > MAX_INTEGRATOR_POLE]
    settling = np.abs(moving.real)[np.abs(moving.real) > 1e-6 * np.abs(moving)]
    if len(settling):
        return SHOWN_TIME_CONSTANTS / float(settling.min())
    return SHOWN_PERIODS * 2.0 * math.pi / float(np.abs(moving).min()) if len(moving) else otherwise


def shown_times(poles: Array, seconds: float, dt: float = 0.0) -> Array:
    """Return evenly spaced times, those of samples or close enough for the fastest oscillating pole, shape (k,) [s]."""
    if dt:
        return np.asarray(np.arange(min(max(round(seconds / dt), 1), MAX_POINTS) + 1) * dt, dtype=float)
    swings = seconds * float(np.abs(poles.imag).max(initial=0.0)) / (2.0 * math.pi)
    return np.linspace(0.0, seconds, min(max(CURVE_POINTS, math.ceil(A_SWING * swings)), MAX_POINTS))


def frequencies(poles: Array, zeros: Array, dt: float = 0.0) -> Array:
    """Return frequencies up to two decades beyond all poles and zeros, or up to Nyquist's, shape (POINTS,) [rad/s]."""
    sizes = np.abs(in_time(np.concatenate([poles, zeros]), dt))
    sizes = sizes[sizes > MAX_INTEGRATOR_POLE]
    low, high = (float(sizes.min()), float(sizes.max())) if len(sizes) else (1.0, 1.0)
    if dt:
        high = nyquist_frequency(dt)
        return np.geomspace(min(low, high) / 100.0, high, CURVE_POINTS)
    return np.geomspace(low / 100.0, high * 100.0, CURVE_POINTS)


def _with_exact_marks(locus: RootLocus, plant: LinearPlant) -> RootLocus:
    """Return a locus with the exact crossings of a delayed loop, without breakaways that only Pade's method has."""
    if not plant.delay or plant.dt:
        return locus
    exact = first_output(plant.exact)
    found = sorted((gain, side * at) for gain, at in searched(exact, plant.delay)[0] for side in (-1.0, 1.0))

    def error(mark: LocusMark) -> float:
        return float(abs(mark.gain * exact(mark.point) * np.exp(-mark.point * plant.delay) + 1.0))

    return replace(
        locus,
        crossings=tuple(LocusMark(gain=g, point=complex(0.0, at)) for g, at in found if abs(at) < locus.extent),
        breakaways=tuple(mark for mark in locus.breakaways if error(mark) < MAX_MARK_ERROR),
    )
