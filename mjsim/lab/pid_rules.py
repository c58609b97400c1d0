"""Tuning rules of PIDs: by the ultimate gain, and by a first-order model with a dead time."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.lab.linear import LinearPlant
from mjsim.lab.locus import finite_zeros
from mjsim.lab.margins import margins_of
from mjsim.lab.plane import outward
from mjsim.lab.plant_study import MAX_INTEGRATOR_POLE, first_output, shown_seconds, theory

OTHERWISE = "take another rule of --pid, or --place, --lqr or --lead"
ROOT_TOLERANCE = 1e-3
"""Roots that differ by less than this fraction of their size are equal except for rounding."""
TINY = 2.0**-20
"""Factor that makes a loop tiny, for the search of its ultimate gain."""
CLOSE, MAX_GUESSES = 1.6, 50
"""A smaller time constant is close to that of a zero within this factor; maximum number of guesses of the dead time."""
Parameters = tuple[float, float, float]
"""Parameters of a PID: gain, integral time and derivative time [s]; an infinite integral time means no integral part.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lag:
    """A first-order model with a dead time: gain exp(-dead s) / (constant s + 1)."""

    gain: float
    dead: float
    """[s]"""
    constant: float
    """[s]"""


def _ultimate(plant: LinearPlant) -> tuple[float, float]:
    """Return the ultimate gain and period [s]; in discrete time those of the sampled loop."""
    loop = first_output(plant.exact)
    # The margin is the crossing nearest to gain 1. The ultimate gain is the smallest: that nearest to 1 for a tiny
    # loop.
    margins = margins_of(TINY * loop, plant.delay)
    gain, at = margins["gain_margin"], margins["phase_crossover"]
    if gain is None or not at or not (outward(loop.poles(), plant.dt) < 1e-9).all():
        raise UsageError(f"no gain makes this plant oscillate; {OTHERWISE}")
    return TINY * gain, 2.0 * math.pi / at


def _reaction(plant: LinearPlant) -> Lag:
    """Return a first-order model: that of the plant if it is of first order, else from its step response."""
    loop = first_output(plant.exact)
    gain = _static_gain(loop)
    if len(loop.poles()) == 1 and not len(finite_zeros(loop)):
        return Lag(gain=gain, dead=plant.delay, constant=-1.0 / float(loop.poles()[0].real))
    tangent = _tangent(loop, gain)
    return Lag(gain=gain, dead=tangent.dead + plant.delay, constant=tangent.constant)


def _static_gain(loop: Any) -> float:
    """Return the gain at 0 rad/s of a stable loop."""
    if not (loop.poles().real < 0.0).all():
        raise UsageError(f"the plant is not stable; {OTHERWISE}")
    if not len(loop.poles()):
        raise UsageError("the plant is a pure gain without a lag; any integral gain stabilises it")
    gain = float(np.real(loop.dcgain()))
    if abs(gain) < 1e-9 * float(np.abs(loop.D).max() + np.abs(loop.C @ loop.B).max(initial=0.0)) or gain == 0.0:
        raise UsageError(f"the plant returns to 0 after a step, so no PID can hold it elsewhere; {OTHERWISE}")
    return gain


def _tangent(loop: Any, gain: float) -> Lag:
    """Return the first-order model by the steepest tangent of the step response."""
    time = np.linspace(0.0, 1.5 * shown_seconds(loop.poles()), 5_000)
    _, response = theory().step_response(loop, time)
    response = response * np.sign(gain)
    # Before its final rise, the response may go in the wrong direction.
    rising = np.arange(len(time)) > np.flatnonzero(response <= 0.0).max(initial=-1)
    rate = np.where(rising, np.gradient(response, time), 0.0) if rising.any() else np.gradient(response, time)
    steepest = int(np.argmax(rate))
    dead = max(float(time[steepest] - response[steepest] / rate[steepest]), 0.0)
    return Lag(gain=gain, dead=dead, constant=abs(gain) / float(rate[steepest]))


def _halved(plant: LinearPlant) -> Lag:
    """Return a first-order model by the half rule if poles and zeros are real, else by the step response.

    Half of the second largest time constant counts as dead time, half is added to the largest; the other lags, and
    zeros in the right half plane, count as dead time. Zeros in the left half plane change a lag each.

    References:
        Skogestad, Simple Analytic Rules for Model Reduction and PID Controller Tuning, J. Process Control 13 (2003),
        equations 10 and 11.
    """
    loop = first_output(plant.exact)
    gain, zeros = _static_gain(loop), finite_zeros(loop)
    poles = _cancelled(loop.poles(), zeros)
    zeros = _cancelled(zeros, loop.poles())
    if not (_are_real(poles) and _are_real(zeros) and len(poles) > len(zeros)):
        return _reaction(plant)
    lags, zeros = np.sort(-1.0 / _merged(poles).real)[::-1], zeros.real
    given = plant.delay + float((1.0 / zeros[zeros > 0.0]).sum())
    leads, dead = np.sort(-1.0 / zeros[zeros < 0.0])[::-1], given + float(lags[1:].sum())
    for _ in range(MAX_GUESSES):
        # The effect of a zero depends on the dead time, and this on the lags that remain after the zeros.
        factor, left = _without_leads(lags.tolist(), leads.tolist(), dead)
        half = left[1] / 2.0 if len(left) > 1 else 0.0
        guess, dead = dead, given + half + sum(left[2:])
        if abs(dead - guess) <= 1e-9 * dead:
            break
    return Lag(gain=gain * factor, dead=dead, constant=left[0] + half)


def _without_leads(lags: list[float], leads: list[float], dead: float) -> tuple[float, list[float]]:
    """Return the factor of the gain, and the lags left after zeros in the left half plane, the largest first [s].

    References:
        Skogestad (2003), section 3.3, rules T1, T1a, T1b, T2 and T3.
    """
    factor = 1.0
    for lead in leads:
        larger = min((lag for lag in lags if lag >= lead), default=math.inf)
        smaller = max((lag for lag in lags if lag < lead), default=0.0)
        is_close = smaller > 0.0 and lead / smaller < min(larger / lead, CLOSE)
        if larger == math.inf or is_close:
            lags.remove(smaller)
            factor *= max(lead / max(smaller, dead), 1.0)
        else:
            lags.remove(larger)
            near = lead if lead >= 5.0 * dead else min(larger, 5.0 * dead)
            factor *= near / larger
            lags += [near - lead] if near > lead else []
    return factor, sorted(lags, reverse=True)


def _merged(roots: Array) -> Array:
    """Return the roots, equal ones replaced by their mean: by rounding, four equal ones differ by 1e-4."""
    near = np.abs(roots[:, None] - roots) < ROOT_TOLERANCE * np.abs(roots)
    return np.array([roots[row].mean() for row in near])


def _are_real(roots: Array) -> bool:
    return bool((np.abs(roots.imag) < ROOT_TOLERANCE * np.abs(roots)).all())


def _cancelled(roots: Array, others: Array) -> Array:
    """Return the roots without those that occur among the others too."""
    keep = [all(abs(root - other) > 1e-9 * abs(root) for other in others) for root in roots]
    return np.asarray(roots[np.array(keep, dtype=bool)])


def _ziegler_nichols(plant: LinearPlant) -> Parameters:
    """Ziegler, Nichols, Optimum Settings for Automatic Controllers, Transactions of the ASME 64 (1942)."""
    gain, period = _ultimate(plant)
    return 0.6 * gain, 0.5 * period, 0.125 * period


def _tyreus_luyben(plant: LinearPlant) -> Parameters:
    """Luyben, Luyben, Essentials of Process Control (1997), section 3.3."""
    gain, period = _ultimate(plant)
    return gain / 2.2, 2.2 * period, period / 6.3


def _cohen_coon(plant: LinearPlant) -> Parameters:
    """Cohen, Coon, Theoretical Consideration of Retarded Control, Transactions of the ASME 75 (1953)."""
    _require_continuous(plant)
    lag = _reaction(plant)
    if lag.dead < 1e-6 * lag.constant:
        raise UsageError("the plant has no dead time, which this rule needs; use the rule simc")
    r = lag.dead / lag.constant
    ti, td = lag.dead * (32.0 + 6.0 * r) / (13.0 + 8.0 * r), lag.dead * 4.0 / (11.0 + 2.0 * r)
    return (4.0 / 3.0 + r / 4.0) / (lag.gain * r), ti, td


def _simc(plant: LinearPlant) -> Parameters:
    """Skogestad, Simple Analytic Rules for Model Reduction and PID Controller Tuning, J. Process Control 13 (2003).

    The closed loop's time constant is the dead time; without a dead time, a fifth of the plant's time constant.
    """
    _require_continuous(plant)
    loop = first_output(plant.exact)
    poles = loop.poles()
    if (np.abs(poles) < MAX_INTEGRATOR_POLE).sum() == 1 and (poles.real < MAX_INTEGRATOR_POLE).all():
        slope, dead = _ramp(loop, plant.delay)
        return 1.0 / (slope * 2.0 * dead), 8.0 * dead, 0.0
    lag = _halved(plant)
    aim = lag.dead if lag.dead > 1e-3 * lag.constant else lag.constant / 5.0
    return lag.constant / (lag.gain * (aim + lag.dead)), min(lag.constant, 4.0 * (aim + lag.dead)), 0.0


def _require_continuous(plant: LinearPlant) -> None:
    if plant.dt:
        raise UsageError("this rule is for plants in continuous time; take --pid ziegler-nichols, --place or --lqr")


def _ramp(loop: Any, delay: float) -> tuple[float, float]:
    """Return the final slope of an integrating plant's step response, and its dead time [s].

    They follow from the series expansion at 0: G(s) = slope / s - slope dead + ... So lags count in full, as in
    Skogestad's example E6, theta = 1.69: beside an integrator there is no time constant for the half rule to enlarge.
    """
    moving = np.abs(loop.poles())[np.abs(loop.poles()) > MAX_INTEGRATOR_POLE]
    s = 1e-6 * float(moving.min(initial=1.0 / delay if delay else 1.0))
    inner, outer = (float(np.real(at * loop(at))) for at in (s, 2 * s))
    slope = 2.0 * inner - outer
    dead = delay + ((inner - outer) / s / slope if slope else 0.0)
    if not dead * s > 1e-12:  # a millionth of the slowest lag; rounding errors are smaller
        raise UsageError(f"the plant is an integrator without a lag, so any gain stabilises it; {OTHERWISE}")
    return slope, dead


RULES = {
    "ziegler-nichols": _ziegler_nichols,
    "tyreus-luyben": _tyreus_luyben,
    "cohen-coon": _cohen_coon,
    "simc": _simc,
}
"""Tuning rules of PIDs by name."""
