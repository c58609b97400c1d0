"""The nonlinear plant in closed loop: simulation with MuJoCo under a controller designed for the linear plant."""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.lab.design import Design
from mjsim.lab.identify import fit
from mjsim.lab.plant_scene import MAX_SIMULATED, Law, ScenePlant, bound_of
from mjsim.lab.plant_study import theory


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ClosedLoop:
    """The step response of the nonlinear plant under a design, which acts at each physics step."""

    time: Array
    """Shape (k,) [s]; shorter than the linear response if the plant diverges."""
    step: Array
    """Outputs minus those of the operating point, shape (outputs, k), for a step of the plant's amplitude."""
    fit: list[float] | None
    """Fit of the linear step response, for each output [%]; None if the plant diverges."""
    rough: tuple[Array, Array] | None
    """Times and outputs with dry friction, if there is any; shapes (k,) and (outputs, k)."""


def closed_loop(scene: ScenePlant, design: Design) -> ClosedLoop:
    """Simulate the nonlinear plant under a design.

    The step is that of `Design.step`: of the set-point for a series controller, in the unit of the first output; of the
    value added to the input for state feedback.
    """
    time, step = _simulated(scene, design)
    linear = np.array([np.interp(time, design.time, row * scene.plant.amplitude) for row in design.step])
    return ClosedLoop(
        time=time,
        step=step,
        fit=fit(step, linear).tolist() if len(time) == _count(scene, design) else None,
        rough=_simulated(scene, design, dry_friction=True) if scene.dry_friction else None,
    )


def _simulated(scene: ScenePlant, design: Design, *, dry_friction: bool = False) -> tuple[Array, Array]:
    """Return times and outputs, shapes (k,) and (outputs, k)."""
    dt = float(scene.model.opt.timestep)
    law = _law(design, scene.plant.amplitude, dt)
    bound = bound_of(design.step * scene.plant.amplitude)
    outputs = scene.controlled(law, _count(scene, design), dry_friction=dry_friction, bound=bound)
    return np.asarray(np.arange(outputs.shape[1]) * dt, dtype=float), outputs


def _count(scene: ScenePlant, design: Design) -> int:
    """Return the number of physics steps worth simulating."""
    return min(math.ceil(float(design.time[-1]) / float(scene.model.opt.timestep)) + 1, MAX_SIMULATED)


def _law(design: Design, height: float, dt: float) -> Law:
    """Return the sampled form of a design, a transfer function by Tustin's rule, for a step of its set-point."""
    if design.gain:
        K = np.array(design.gain)
        return lambda states, outputs: height - float(K @ states)
    control = theory()
    sampled = control.ss(control.sample_system(control.tf(list(design.num), list(design.den)), dt, "tustin"))
    A, B, C, D = sampled.A, sampled.B[:, 0], sampled.C[0], float(sampled.D[0, 0])
    inside = np.zeros(len(A))

    def in_series(states: Array, outputs: Array) -> float:
        error = height - float(outputs[0])
        effort = float(C @ inside) + D * error
        inside[:] = A @ inside + B * error
        return effort

    return in_series
