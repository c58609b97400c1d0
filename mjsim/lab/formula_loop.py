"""A plant given by a formula, simulated step by step: its delay is exact."""

import math

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.lab.design import Design
from mjsim.lab.linear import LinearPlant
from mjsim.lab.plant_scene import MAX_SIMULATED, Law
from mjsim.lab.plant_study import system_of, theory
from mjsim.world import Plant

STEPS = 4_000
"""Minimum number of steps of a response in continuous time."""


class FormulaLoop:
    """A formula simulated in steps: of its own period, or short ones with the input held."""

    dry_friction = 0.0
    """A formula has no joints."""
    held_input = 0.0
    """Input at rest."""

    def __init__(self, plant: Plant, linear: LinearPlant, design: Design) -> None:
        """Choose the step for a design's response: a delay is a multiple of it."""
        control, self.plant = theory(), plant
        self.dt = linear.dt or _step(linear, float(design.time[-1]))
        self._late = round(linear.delay / self.dt)
        system = system_of(linear.exact)
        stepped = system if linear.dt else control.sample_system(system, self.dt, "zoh")
        self._parts = stepped.A, stepped.B[:, 0], stepped.C, stepped.D[:, 0]

    def controlled(self, law: Law, count: int, *, dry_friction: bool = False, bound: float = math.inf) -> Array:
        """Return the outputs under a controller before each step, shape (outputs, k); fewer if the plant diverges."""
        A, B, C, D = self._parts
        state, found = np.zeros(len(A)), np.zeros((len(C), count))
        inputs = np.zeros(count + self._late)
        for k in range(count):
            found[:, k] = C @ state + D * inputs[k]
            if not np.abs(found[:, k]).max() < bound:
                return found[:, :k]
            inputs[k + self._late] = law(state, found[:, k])
            state = A @ state + B * inputs[k]
        return found


def is_simulated(plant: Plant, linear: LinearPlant, design: Design) -> bool:
    """Whether the loop of a formula differs from the linear one; its delay has no states that feedback could use.

    Raises:
        UsageError: Its input has limits, and its output reacts without delay.
    """
    limits = plant.saturation is not None or plant.dead_zone > 0.0
    if limits and not linear.delay and linear.D.any():
        raise UsageError(
            f"plant '{plant.name}': a loop with saturation or a dead zone needs an output without direct"
            " feedthrough; give fewer zeros than poles, or a delay"
        )
    return not design.gain if linear.delay else limits


def _step(linear: LinearPlant, seconds: float) -> float:
    """Return a step that is short for a response and for the plant's poles, and divides its delay [s]."""
    fastest = float(np.abs(np.linalg.eigvals(linear.exact.A)).max(initial=0.0))
    step = max(min(seconds / STEPS, 0.02 / fastest if fastest else math.inf), seconds / MAX_SIMULATED)
    return linear.delay / math.ceil(linear.delay / step) if linear.delay else step
