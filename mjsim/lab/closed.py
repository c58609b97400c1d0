"""The plant in closed loop under a controller designed for the linear plant, simulated with the limits of its input."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from mjsim.geometry import Array
from mjsim.lab.design import Design
from mjsim.lab.identify import fit
from mjsim.lab.plant_scene import MAX_SIMULATED, Law, bound_of
from mjsim.lab.plant_study import theory
from mjsim.world import Plant


class SteppedPlant(Protocol):
    """A plant that is simulated step by step: a scene in MuJoCo, or a formula."""

    plant: Plant

    @property
    def dt(self) -> float:
        """Duration of a step [s]."""

    @property
    def held_input(self) -> float:
        """Input at the operating point."""

    @property
    def dry_friction(self) -> float:
        """The largest dry friction of its joints [N m, N]; 0 if there is none."""

    def controlled(self, law: Law, count: int, *, dry_friction: bool = False, bound: float = 0.0) -> Array:
        """Return the outputs under a controller before each step, shape (outputs, k); fewer if the plant diverges."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ClosedLoop:
    """The step response of the simulated plant under a design, which acts at each step."""

    what: str = "nonlinear, MuJoCo"
    """Name of the simulated system, for a legend."""
    time: Array
    """Shape (k,) [s]; shorter than the linear response if the plant diverges."""
    step: Array
    """Outputs minus those of the operating point, shape (outputs, k), for a step of the plant's amplitude."""
    fit: list[float] | None
    """Fit of the linear step response, for each output [%]; None if the plant diverges."""
    rough: tuple[Array, Array] | None
    """Times and outputs with dry friction, if there is any; shapes (k,) and (outputs, k)."""


def closed_loop(stepped: SteppedPlant, design: Design) -> ClosedLoop:
    """Simulate the plant under a design.

    The step is that of `Design.step`: of the set-point for a series controller, in the unit of the first output; of the
    value added to the input for state feedback.
    """
    time, step = _simulated(stepped, design)
    linear = np.array([np.interp(time, design.time, row * stepped.plant.amplitude) for row in design.step])
    return ClosedLoop(
        what=_what(stepped),
        time=time,
        step=step,
        fit=fit(step, linear).tolist() if len(time) == _count(stepped, design) else None,
        rough=_simulated(stepped, design, dry_friction=True) if stepped.dry_friction else None,
    )


def _what(stepped: SteppedPlant) -> str:
    plant = stepped.plant
    named = ("nonlinear, MuJoCo", plant.of), ("saturation", plant.saturation), ("dead zone", plant.dead_zone)
    return ", ".join(name for name, given in named if given) or "with its exact delay"


def limited(plant: Plant, value: float) -> float:
    """Return the input that acts for a commanded one: reduced by the dead zone, and saturated."""
    acting = math.copysign(max(abs(value) - plant.dead_zone, 0.0), value)
    return acting if plant.saturation is None else min(max(acting, -plant.saturation), plant.saturation)


def _simulated(stepped: SteppedPlant, design: Design, *, dry_friction: bool = False) -> tuple[Array, Array]:
    """Return times and outputs, shapes (k,) and (outputs, k)."""
    plant, held = stepped.plant, stepped.held_input
    law = _law(design, plant.amplitude, stepped.dt)
    bound = bound_of(design.step * plant.amplitude)
    outputs = stepped.controlled(
        lambda states, found: limited(plant, held + law(states, found)) - held,
        _count(stepped, design),
        dry_friction=dry_friction,
        bound=bound,
    )
    return np.asarray(np.arange(outputs.shape[1]) * stepped.dt, dtype=float), outputs


def _count(stepped: SteppedPlant, design: Design) -> int:
    """Return the number of steps worth simulating."""
    return min(math.ceil(float(design.time[-1]) / stepped.dt - 1e-9) + 1, MAX_SIMULATED)


def _law(design: Design, height: float, dt: float) -> Law:
    """Return the sampled form of a design, a transfer function by Tustin's rule, for a step of its set-point."""
    if design.gain:
        K = np.array(design.gain)
        return lambda states, outputs: height - float(K @ states)
    A, B, C, D = _sampled(design, dt)
    inside = np.zeros(len(A))

    def in_series(states: Array, outputs: Array) -> float:
        error = height - float(outputs[0])
        effort = float(C @ inside) + D * error
        inside[:] = A @ inside + B * error
        return effort

    return in_series


def _sampled(design: Design, dt: float) -> tuple[Array, Array, Array, float]:
    control = theory()
    law: Any = control.tf(list(design.num), list(design.den), design.dt)
    system = control.ss(law if design.dt else control.sample_system(law, dt, "tustin"))
    return system.A, system.B[:, 0], system.C[0], float(system.D[0, 0])
