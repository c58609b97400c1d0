"""Controllers of a plant: PID by tuning rules, pole placement, LQR, lead-lag; and the resulting closed loops."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant
from mjsim.lab.margins import margins_of
from mjsim.lab.pid_rules import RULES
from mjsim.lab.plane import on_axis, outward
from mjsim.lab.plant_study import first_output, shown_seconds, shown_times, system_of, theory

DERIVATIVE_FILTER = 10.0
"""Time constant of the derivative filter of a PID: its derivative time divided by this."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Design:
    """A controller, and the closed loop."""

    name: str
    gain: tuple[float, ...] = ()
    """Gain of state feedback u = r - K x."""
    num: tuple[float, ...] = ()
    """Numerator of a series controller, u = C (r - y), highest power of s, or of z in discrete time, first."""
    den: tuple[float, ...] = ()
    """Denominator of a series controller."""
    poles: Array
    """Poles of the closed loop, complex: of s [rad/s], or of z in discrete time."""
    dt: float = 0.0
    """Sampling period of plant and controller; 0 in continuous time [s]."""
    margins: dict[str, float | None]
    """Margins of the open loop, cut at the plant's input."""
    time: Array
    """Shape (k,) [s]."""
    step: Array
    """Response of the outputs to a step of the set-point, or of the value added to the input, shape (outputs, k)."""

    @property
    def is_stable(self) -> bool:
        """Whether the closed loop is stable."""
        return bool((outward(self.poles, self.dt) < 0.0).all())


def pid_design(plant: LinearPlant, rule: str) -> Design:
    """Return a PID for the first output, tuned by a rule; of a plant in discrete time by backward differences.

    Raises:
        UsageError: The rule does not exist, or is not applicable to the plant.
    """
    if rule not in RULES:
        raise UsageError(f"no tuning rule '{rule}'{did_you_mean(rule, RULES)}")
    control = theory()
    kp, ti, td = RULES[rule](plant)
    s = control.tf("s")
    law = control.tf([kp], [1])
    if math.isfinite(ti):
        law = law + kp / (ti * s)
    if td:
        law = law + kp * td * s / (1 + td / DERIVATIVE_FILTER * s)
    law = control.sample_system(law, plant.dt, "backward_diff") if plant.dt else law
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
    """Return the state feedback that minimises the integral, or the sum over samples, of x' Q x + R u^2.

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
        regulator = theory().dlqr if plant.dt else theory().lqr
        K, _, _ = regulator(plant.A, plant.B, np.diag(weights), np.array([[effort]]))
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
    control, loop = theory(), first_output(plant.exact)
    if not (crossover > 0.0 and lag >= 1.0):
        raise UsageError("a lead needs a crossover above 0 rad/s and a lag of 1 or more")
    if plant.dt and crossover * plant.dt >= math.pi:
        raise UsageError(f"a crossover of {crossover:g} rad/s needs more than two samples of {plant.dt:g} s per period")
    at = complex(on_axis(crossover, plant.dt))
    if float(np.abs(loop.poles() - at).min(initial=math.inf)) < 1e-9 * abs(at):
        raise UsageError(f"the plant has a pole at {crossover:g} rad/s; choose another crossover")
    # Tustin's rule takes the frequency w of the law to the crossover.
    w = 2.0 / plant.dt * math.tan(crossover * plant.dt / 2.0) if plant.dt else crossover
    behind = control.tf([1.0, w / 10], [1.0, w / 10 / lag]) if lag > 1.0 else control.tf([1.0], [1.0])
    value = complex(loop(at) * np.exp(-1j * crossover * plant.delay) * behind(1j * w))
    turn = (math.radians(margin_deg) - math.pi - np.angle(value) + math.pi) % (2 * math.pi) - math.pi
    if abs(turn) > math.radians(75.0):
        raise UsageError(
            f"the phase there is {math.degrees(np.angle(value)):.1f} deg; one lead cannot give a margin of"
            f" {margin_deg:g} deg at {crossover:g} rad/s, since it adds at most 75 deg of phase"
        )
    ratio = (1 + math.sin(turn)) / (1 - math.sin(turn))
    zero, pole = w / math.sqrt(ratio), w * math.sqrt(ratio)
    law = control.tf([1 / zero, 1.0], [1 / pole, 1.0]) * behind
    law = law / abs(complex(law(1j * w)) * complex(loop(at)))
    law = control.sample_system(law, plant.dt, "tustin") if plant.dt else law
    return _in_series(plant, law, f"lead-lag, {margin_deg:g} deg at {crossover:g} rad/s, lag {lag:g}")


def _check_states(plant: LinearPlant) -> None:
    if not len(plant.A):
        raise UsageError("the plant has no states to feed back; use --pid simc")


def _in_series(plant: LinearPlant, law: Any, name: str) -> Design:
    """Return the design of a series controller with feedback from the first output."""
    control = theory()
    num, den = (np.asarray(part[0][0], dtype=float) / law.den[0][0][0] for part in (law.num, law.den))
    open_loop = first_output(plant.exact) * control.ss(law)
    closed = control.feedback(system_of(plant) * control.ss(law), _take_first(plant))
    margins = margins_of(open_loop, plant.delay)
    return _design(closed, margins, name, plant.dt, num=tuple(num.tolist()), den=tuple(den.tolist()))


def _take_first(plant: LinearPlant) -> Any:
    """Return the feedback of the first output."""
    return theory().ss([], [], [], np.eye(1, len(plant.outputs)))


def _fed_back(plant: LinearPlant, K: Array, name: str) -> Design:
    control = theory()
    closed = control.ss(plant.A - plant.B @ K, plant.B, plant.C - plant.D @ K, plant.D, plant.dt)
    open_loop = control.ss(plant.A, plant.B, K, np.zeros((1, 1)), plant.dt)
    return _design(closed, margins_of(open_loop), name, plant.dt, gain=tuple(np.asarray(K)[0].tolist()))


def _design(closed: Any, margins: dict[str, float | None], name: str, dt: float, **law: tuple[float, ...]) -> Design:
    control = theory()
    poles = np.sort_complex(closed.poles())
    time = shown_times(poles, shown_seconds(poles, dt=dt), dt)
    _, step = control.step_response(closed, time, squeeze=False)
    return Design(name=name, poles=poles, dt=dt, margins=margins, time=time, step=step[:, 0, :], **law)


def _complex(value: complex) -> str:
    return f"{value.real:g}" if abs(complex(value).imag) < 1e-12 else f"{complex(value):.4g}"
