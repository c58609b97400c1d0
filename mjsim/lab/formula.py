"""Plants given by formulas: transfer functions, zeros, poles and a gain, and state-space models."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.signal import zpk2sos

from mjsim.errors import UsageError
from mjsim.lab.linear import LinearPlant, minimal_states
from mjsim.lab.plant_study import theory
from mjsim.world import Plant, StateSpace, TransferFunction, ZerosPolesGain, complex_root

PADE_ORDER = 5
"""Order of the approximation of a delay in continuous time."""


def formula_plant(plant: Plant) -> LinearPlant:
    """Return the linear plant of a model in a world.

    Raises:
        UsageError: Its input affects none of its outputs.
    """
    if plant.tf is not None:
        return _delayed(theory().ss(_transfer(plant.tf)), plant.tf.delay)
    if plant.zpk is not None:
        return _delayed(_cascade(plant.zpk), plant.zpk.delay)
    assert plant.ss is not None
    return _state_space(plant, plant.ss)


def _state_space(plant: Plant, model: StateSpace) -> LinearPlant:
    A, B, C = (np.array(part, dtype=float) for part in (model.a, model.b, model.c))
    D = np.zeros((len(C), B.shape[1])) if model.d is None else np.array(model.d, dtype=float)
    name, outputs = plant.input or model.inputs[0], list(plant.outputs or model.outputs)
    rows, column = [model.outputs.index(each) for each in outputs], [model.inputs.index(name)]
    B, C, D = B[:, column], C[rows], D[np.ix_(rows, column)]
    if not minimal_states(A, B, C, coupled=0.0) and not D.any():
        raise UsageError(f"plant '{plant.name}': {name} affects none of {', '.join(outputs)}; name another input")
    return _named(theory().ss(A, B, C, D, plant.dt), name, outputs)


def _named(system: Any, name: str = "u", outputs: Sequence[str] = ("y",)) -> LinearPlant:
    A, B, C, D = system.A, system.B, system.C, system.D
    states, units = tuple(f"x{k + 1}" for k in range(len(A))), ("",) * (1 + len(outputs))
    return LinearPlant(
        A=A, B=B, C=C, D=D, states=states, input=name, outputs=tuple(outputs), units=units, dt=float(system.dt or 0.0)
    )


def _transfer(given: TransferFunction) -> Any:
    return theory().tf(list(given.num), list(given.den), given.dt or 0.0)


def _cascade(given: ZerosPolesGain) -> Any:
    """Return the state space of second-order sections in series, whose poles equal those given except for rounding."""
    control = theory()
    zeros, poles = ([complex_root(root) for root in roots] for roots in (given.zeros, given.poles))
    # Scaled by their size, coefficients remain moderate.
    sections = zpk2sos(zeros, poles, given.gain, pairing="minimal", analog=True)
    system = control.ss([], [], [], [[1.0]], given.dt or 0.0)
    for section in sections:
        num, den = (np.trim_zeros(part, "f") for part in (section[:3], section[3:]))
        system = control.ss(control.tf(num, den, given.dt or 0.0)) * system
    return system


def _delayed(system: Any, delay: float) -> LinearPlant:
    """Return the plant with a delay: exact in discrete time, by Pade's approximation in continuous time."""
    control, undelayed = theory(), _named(system)
    if not delay:
        return undelayed
    if undelayed.dt:
        periods = round(delay / undelayed.dt)
        shift = control.ss(np.eye(periods, k=-1), np.eye(periods, 1), np.eye(1, periods, periods - 1), 0, undelayed.dt)
        return _named(shift * system)
    approximation = control.ss(control.tf(*control.pade(delay, PADE_ORDER)))
    return replace(_named(system * approximation), delay=delay, undelayed=undelayed)


def pade_limit(delay: float) -> float:
    """Return the frequency up to which the phase of the approximation of a delay errs by less than 1 deg [rad/s]."""
    control = theory()
    turns = np.linspace(0.0, 4.0 * PADE_ORDER, 4_000)
    _, phase, _ = control.frequency_response(control.tf(*control.pade(1.0, PADE_ORDER)), turns)
    wrong = np.abs(np.unwrap(np.asarray(phase)) - phase[0] + turns) > math.radians(1.0)
    return float(turns[np.argmax(wrong)]) / delay
