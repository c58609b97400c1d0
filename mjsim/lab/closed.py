"""The nonlinear plant in the loop: steps of MuJoCo under a controller that was designed for the linear one."""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.lab.design import Design
from mjsim.lab.identify import fit
from mjsim.lab.scene import MOST_SIMULATED, Law, ScenePlant, bound_of
from mjsim.lab.study import theory


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ClosedLoop:
    """The step response of the nonlinear plant under a design, which acts at each step of MuJoCo."""

    time: Array
    """Shape (k,) [s]; it ends before the linear one where the plant runs away."""
    step: Array
    """Outputs less those of the working point, shape (outputs, k), for a step as high as the plant's amplitude."""
    fit: list[float] | None
    """How well the linear step response fits it, for each output [%]; None where the plant runs away."""
    rough: tuple[Array, Array] | None
    """Times and outputs with dry friction, if there is any."""


def closed_loop(scene: ScenePlant, design: Design) -> ClosedLoop:
    """Simulate the nonlinear plant under a design.

    The step is that of `Design.step`: of the set-point of a law in series, in the unit of the first output; of what is
    added to the input under state feedback.
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
    """Return for how many steps of MuJoCo it is worth looking at."""
    return min(math.ceil(float(design.time[-1]) / float(scene.model.opt.timestep)) + 1, MOST_SIMULATED)


def _law(design: Design, height: float, dt: float) -> Law:
    """Return a design at work in samples, a transfer function by Tustin's rule, for a step of its set-point."""
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
