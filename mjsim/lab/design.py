"""Controllers of a plant: PID by tuning rules, pole placement, LQR, lead-lag; and the resulting closed loops."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant
from mjsim.lab.study import INTEGRATOR, margins_of, shown_seconds, shown_times, theory

FILTER = 10.0
"""Time constant of the derivative filter of a PID: its derivative time divided by this."""
OTHERWISE = "take another rule of --pid, or --place, --lqr or --lead"
Parameters = tuple[float, float, float]
"""Parameters of a PID: gain, integral time and derivative time [s]; an infinite integral time means no integral part.
"""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Design:
    """A controller, and the closed loop."""

    name: str
    gain: tuple[float, ...] = ()
    """Gain of state feedback u = r - K x."""
    num: tuple[float, ...] = ()
    """Numerator of a series controller, u = C (r - y), highest power of s first."""
    den: tuple[float, ...] = ()
    """Denominator of a series controller."""
    poles: Array
    """Poles of the closed loop, complex [rad/s]."""
    margins: dict[str, float | None]
    """Margins of the open loop, cut at the plant's input."""
    time: Array
    """Shape (k,) [s]."""
    step: Array
    """Response of the outputs to a step of the set-point, or of the value added to the input, shape (outputs, k)."""

    @property
    def is_stable(self) -> bool:
        """Whether the closed loop is stable."""
        return bool((self.poles.real < 0.0).all())


def pid_design(plant: LinearPlant, rule: str) -> Design:
    """Return a PID for the first output, tuned by a rule.

    Raises:
        UsageError: The rule does not exist, or is not applicable to the plant.
    """
    if rule not in RULES:
        raise UsageError(f"no tuning rule '{rule}'{did_you_mean(rule, RULES)}")
    control = theory()
    kp, ti, td = RULES[rule](_first(plant))
    s = control.tf("s")
    law = control.tf([kp], [1])
    if math.isfinite(ti):
        law = law + kp / (ti * s)
    if td:
        law = law + kp * td * s / (1 + td / FILTER * s)
    return _in_series(plant, law, f"PID by {rule}: gain {kp:.4g}, Ti {ti:.4g} s, Td {td:.4g} s")


def placed_design(plant: LinearPlant, poles: Sequence[complex]) -> Design:
    """Return state feedback that places the poles of the closed loop.

    Raises:
        UsageError: The number of poles differs from that of states, a conjugate is missing, or placement is impossible.
    """
    _check_states(plant)
    if len(poles) != len(plant.A):
        states = ", ".join(plant.states)
        raise UsageError(f"{len(poles)} poles are given; the plant has {len(plant.A)}, one for each of {states}")
    if not np.allclose(np.sort_complex(np.conj(poles)), np.sort_complex(np.array(poles))):
        raise UsageError("complex poles come in pairs, such as -2+1j and -2-1j")
    control = theory()
    try:
        # Ackermann's formula also works for equal poles.
        K = control.place_acker(plant.A, plant.B, poles)
    except ValueError as error:
        raise UsageError(f"these poles cannot be placed: {error}") from None
    return _fed_back(plant, np.atleast_2d(K), f"poles placed at {', '.join(_complex(pole) for pole in poles)}")


def lqr_design(plant: LinearPlant, weights: Sequence[float], effort: float) -> Design:
    """Return the state feedback that minimises the integral of x' Q x + R u^2.

    Args:
        plant: The linear plant.
        weights: Diagonal of Q, one weight per state.
        effort: R.

    Raises:
        UsageError: They do not match the plant, or no feedback stabilises it.
    """
    _check_states(plant)
    if len(weights) != len(plant.A) or min(weights) < 0.0 or effort <= 0.0:
        expected = f"{len(plant.A)} weights of 0 or more, of {', '.join(plant.states)}"
        raise UsageError(f"LQR needs {expected}, and an effort above 0, such as --lqr {','.join('1' * len(plant.A))}:1")
    try:
        K, _, _ = theory().lqr(plant.A, plant.B, np.diag(weights), np.array([[effort]]))
    except (ValueError, np.linalg.LinAlgError) as error:
        raise UsageError(f"LQR finds no feedback: {error}; give a weight to every unstable state") from None
    return _fed_back(plant, K, f"LQR, Q = diag({', '.join(f'{weight:g}' for weight in weights)}), R = {effort:g}")


def lead_design(plant: LinearPlant, *, margin_deg: float, crossover: float, lag: float = 1.0) -> Design:
    """Return a lead compensator for a phase margin at a crossover frequency, optionally with a lag.

    Args:
        plant: The linear plant; its first output is fed back.
        margin_deg: Phase margin [deg].
        crossover: Frequency at which the open loop has gain 1 [rad/s].
        lag: Factor by which the lag raises the gain at low frequencies; its zero is a decade below the crossover.

    Raises:
        UsageError: A single lead cannot provide the required phase.

    References:
        Franklin, Powell, Emami-Naeini, Feedback Control of Dynamic Systems (2015), section 6.7.
    """
    control, loop = theory(), _first(plant)
    if not (crossover > 0.0 and lag >= 1.0):
        raise UsageError("a lead needs a crossover above 0 rad/s and a lag of 1 or more")
    behind = control.tf([1.0, crossover / 10], [1.0, crossover / 10 / lag]) if lag > 1.0 else control.tf([1.0], [1.0])
    if float(np.abs(loop.poles() - 1j * crossover).min(initial=math.inf)) < 1e-9 * crossover:
        raise UsageError(f"the plant has a pole at {crossover:g} rad/s; take another crossover")
    value = complex(loop(1j * crossover) * behind(1j * crossover))
    turn = (math.radians(margin_deg) - math.pi - np.angle(value) + math.pi) % (2 * math.pi) - math.pi
    if abs(turn) > math.radians(75.0):
        raise UsageError(
            f"the phase there is {math.degrees(np.angle(value)):.1f} deg; one lead cannot give a margin of"
            f" {margin_deg:g} deg at {crossover:g} rad/s, as it turns the phase by 75 deg at most"
        )
    ratio = (1 + math.sin(turn)) / (1 - math.sin(turn))
    zero, pole = crossover / math.sqrt(ratio), crossover * math.sqrt(ratio)
    law = control.tf([1 / zero, 1.0], [1 / pole, 1.0]) * behind
    law = law / abs(complex(law(1j * crossover)) * complex(loop(1j * crossover)))
    return _in_series(plant, law, f"lead-lag, {margin_deg:g} deg at {crossover:g} rad/s, lag {lag:g}")


def _check_states(plant: LinearPlant) -> None:
    if not len(plant.A):
        raise UsageError("the plant has no states to feed back; use --pid simc")


def _first(plant: LinearPlant) -> Any:
    return theory().ss(plant.A, plant.B, plant.C[:1], plant.D[:1])


def _in_series(plant: LinearPlant, law: Any, name: str) -> Design:
    """Return the design of a series controller with feedback from the first output."""
    control = theory()
    num, den = (np.asarray(part[0][0], dtype=float) / law.den[0][0][0] for part in (law.num, law.den))
    open_loop = _first(plant) * control.ss(law)
    closed = control.feedback(control.ss(plant.A, plant.B, plant.C, plant.D) * control.ss(law), _take_first(plant))
    return _design(closed, open_loop, name, num=tuple(num.tolist()), den=tuple(den.tolist()))


def _take_first(plant: LinearPlant) -> Any:
    """Return the feedback of the first output."""
    return theory().ss([], [], [], np.eye(1, len(plant.outputs)))


def _fed_back(plant: LinearPlant, K: Array, name: str) -> Design:
    control = theory()
    closed = control.ss(plant.A - plant.B @ K, plant.B, plant.C - plant.D @ K, plant.D)
    open_loop = control.ss(plant.A, plant.B, K, np.zeros((1, 1)))
    return _design(closed, open_loop, name, gain=tuple(np.asarray(K)[0].tolist()))


def _design(closed: Any, open_loop: Any, name: str, **law: tuple[float, ...]) -> Design:
    control = theory()
    poles = np.sort_complex(closed.poles())
    time = shown_times(poles, shown_seconds(poles))
    _, step = control.step_response(closed, time, squeeze=False)
    return Design(name=name, poles=poles, margins=margins_of(open_loop), time=time, step=step[:, 0, :], **law)


def _ultimate(loop: Any) -> tuple[float, float]:
    """Return the ultimate gain and period [s]."""
    gain, _, at, _ = theory().margin(loop)
    if not (math.isfinite(gain) and math.isfinite(at) and at > 0.0 and (loop.poles().real < 1e-9).all()):
        raise UsageError(f"no gain makes this plant oscillate; {OTHERWISE}")
    return float(gain), 2.0 * math.pi / float(at)


def _reaction(loop: Any) -> tuple[float, float, float]:
    """Return gain, dead time [s] and time constant [s] of the plant's step response, from its steepest tangent."""
    if not (loop.poles().real < 0.0).all():
        raise UsageError(f"the plant is not stable; {OTHERWISE}")
    if not len(loop.poles()):
        raise UsageError("the plant is a pure gain without a lag; any integral gain stabilises it")
    control, gain = theory(), float(np.real(loop.dcgain()))
    if abs(gain) < 1e-9 * float(np.abs(loop.D).max() + np.abs(loop.C @ loop.B).max(initial=0.0)) or gain == 0.0:
        raise UsageError(f"the plant returns to 0 after a step, so no PID can hold it elsewhere; {OTHERWISE}")
    time = np.linspace(0.0, 1.5 * shown_seconds(loop.poles()), 20_000)
    _, response = control.step_response(loop, time)
    response = response * np.sign(gain)
    # Before its final rise the response may go the wrong way, or show artefacts of Pade's approximation of a delay.
    rising = np.arange(len(time)) > np.flatnonzero(response <= 0.0).max(initial=-1)
    rate = np.where(rising, np.gradient(response, time), 0.0) if rising.any() else np.gradient(response, time)
    steepest = int(np.argmax(rate))
    constant = abs(gain) / float(rate[steepest])
    return gain, max(float(time[steepest] - response[steepest] / rate[steepest]), 0.0), constant


def _ziegler_nichols(loop: Any) -> Parameters:
    """Ziegler, Nichols, Optimum Settings for Automatic Controllers, Transactions of the ASME 64 (1942)."""
    gain, period = _ultimate(loop)
    return 0.6 * gain, 0.5 * period, 0.125 * period


def _tyreus_luyben(loop: Any) -> Parameters:
    """Luyben, Luyben, Essentials of Process Control (1997), section 3.3."""
    gain, period = _ultimate(loop)
    return gain / 2.2, 2.2 * period, period / 6.3


def _cohen_coon(loop: Any) -> Parameters:
    """Cohen, Coon, Theoretical Consideration of Retarded Control, Transactions of the ASME 75 (1953)."""
    gain, dead, constant = _reaction(loop)
    if dead < 1e-6 * constant:
        raise UsageError("the plant has no dead time, which this rule needs; use the rule simc")
    r = dead / constant
    kp = (1.35 + 0.25 * r) / (gain * r)
    return kp, dead * (2.5 + 0.46 * r) / (1 + 0.61 * r), 0.37 * dead / (1 + 0.19 * r)


def _simc(loop: Any) -> Parameters:
    """Skogestad, Simple Analytic Rules for Model Reduction and PID Controller Tuning, J. Process Control 13 (2003)."""
    poles = loop.poles()
    if (np.abs(poles) < INTEGRATOR).sum() == 1 and (poles.real < INTEGRATOR).all():
        slope, dead = _ramp(loop)
        return 1.0 / (slope * 2.0 * dead), 8.0 * dead, 0.0
    gain, dead, constant = _reaction(loop)
    time_constant = max(dead, constant / 5.0)
    return constant / (gain * (time_constant + dead)), min(constant, 4.0 * (time_constant + dead)), 0.0


def _ramp(loop: Any) -> tuple[float, float]:
    """Return the final slope of an integrating plant's step response, and its dead time [s].

    They follow from the series expansion at 0: G(s) = slope / s - slope dead + ...
    """
    moving = np.abs(loop.poles())[np.abs(loop.poles()) > INTEGRATOR]
    s = 1e-4 * float(moving.min(initial=1.0))
    inner, outer = (float(np.real(at * loop(at))) for at in (s, 2 * s))
    slope = 2.0 * inner - outer
    dead = (inner - outer) / s / slope if slope else 0.0
    if not dead > 1e-6 * s:
        raise UsageError(f"the plant is an integrator without a lag, so any gain stabilises it; {OTHERWISE}")
    return slope, dead


RULES = {
    "ziegler-nichols": _ziegler_nichols,
    "tyreus-luyben": _tyreus_luyben,
    "cohen-coon": _cohen_coon,
    "simc": _simc,
}
"""Tuning rules of PIDs by name."""


def _complex(value: complex) -> str:
    return f"{value.real:g}" if abs(complex(value).imag) < 1e-12 else f"{complex(value):.4g}"
