"""Linearises, analyses, simulates, identifies and controls one plant."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.lab.closed import ClosedLoop, closed_loop
from mjsim.lab.design import Design
from mjsim.lab.effects import LedJoint
from mjsim.lab.formula import formula_plant
from mjsim.lab.formula_loop import FormulaLoop, is_simulated
from mjsim.lab.identify import Identified, Samples, fit, identified
from mjsim.lab.linear import LinearPlant
from mjsim.lab.plant_scene import MAX_SIMULATED, ScenePlant, bound_of
from mjsim.lab.plant_study import Study, frequencies, study
from mjsim.lab.recorded_plant import recorded
from mjsim.mechanics import Chirp, TimeSignal
from mjsim.record import Recording
from mjsim.views import Viewed
from mjsim.world import Plant, World

SWEEP_TIME_CONSTANTS = 40.0
"""Duration of a sweep, in time constants of the slowest pole."""
MAX_SAMPLES = 600
"""Maximum number of samples of an identification."""
Designer = Callable[[LinearPlant], Design]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Experiment(Viewed):
    """All results on the page of a plant."""

    plant: Plant
    study: Study
    about: str
    held: float = 0.0
    """Input that holds it at its operating point."""
    nonlinear: tuple[Array, Array] | None = None
    """Times and outputs of the nonlinear plant for a step of the input, shapes (k,) and (outputs, k)."""
    nonlinear_impulse: tuple[Array, Array] | None = None
    """The same for an impulse, applied within one physics step."""
    nonlinear_fit: list[float] | None = None
    """Fit of the linear step response, for each output [%]; None if the nonlinear plant diverges."""
    dry_friction: float = 0.0
    """The largest dry friction of the plant's joints, not included in the linear plant and these responses [N m, N]."""
    rough: tuple[Array, Array] | None = None
    """Times and outputs for the step with dry friction, if there is any."""
    step_poles: Array | None = None
    """Poles of MuJoCo's physics step nearest to the plant's, complex [rad/s]."""
    identified: Identified | None = None
    designs: tuple[Design, ...] = ()
    closed: tuple[ClosedLoop | None, ...] = ()
    """The simulated plant under each design; None for a joint that follows its input, and for a formula without delay
    whose input is unlimited."""

    @property
    def name(self) -> str:
        """Name of the plant."""
        return self.plant.name

    @property
    def amplitude(self) -> float:
        """Amplitude of the step of the input."""
        return self.plant.amplitude

    @property
    def labels(self) -> list[str]:
        """Names of the outputs with their units."""
        plant = self.study.plant
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(plant.outputs, plant.units[1:], strict=True)]


def plants_of(world: World, name: str | None) -> list[Plant]:
    """Return the named plant of a world, or all its plants.

    Raises:
        UsageError: There is no such plant.
    """
    names = [plant.name for plant in world.plants]
    if not names:
        raise UsageError(f"world '{world.name}' has no plants; add plants: [{{name: ..., of: ROBOT, input: ...}}]")
    if name is not None and name not in names:
        raise UsageError(f"no plant '{name}' in this world{did_you_mean(name, names)}")
    return [plant for plant in world.plants if name in (None, plant.name)]


def experiment(
    world: World, plant: Plant, *, designers: Sequence[Designer] = (), recording: Recording | None = None
) -> Experiment:
    """Analyse a plant of a world.

    Args:
        world: The world.
        plant: One of its plants.
        designers: Functions that return controllers for it.
        recording: Recording of a run for identification; otherwise the nonlinear plant is simulated, if it is stable.

    Raises:
        UsageError: It cannot be linearised, a controller is not applicable, or the recording does not contain it.
    """
    scene = None if plant.of is None else ScenePlant(world, plant)
    if scene is None:
        if recording is not None:
            raise UsageError(f"plant '{plant.name}' is a formula; recordings contain no data about it")
        linear = formula_plant(plant)
        found = Experiment(plant=plant, study=study(linear, seconds=plant.seconds), about=f"{plant.name}: a formula")
    else:
        found = _of_scene(world, scene, recording)
    try:
        designs = tuple(design(found.study.plant) for design in designers)
    except UsageError as error:
        raise UsageError(f"plant '{plant.name}': {error}") from None
    closed = tuple(_closed(scene, plant, found.study.plant, design) for design in designs)
    return replace(found, designs=designs, closed=closed)


def _closed(scene: ScenePlant | None, plant: Plant, linear: LinearPlant, design: Design) -> ClosedLoop | None:
    """Return the simulated loop under a design, if it can differ from the linear one."""
    if scene is None:
        return closed_loop(FormulaLoop(plant, linear, design), design) if is_simulated(plant, linear, design) else None
    return None if isinstance(scene.effect, LedJoint) else closed_loop(scene, design)


def _of_scene(world: World, scene: ScenePlant, recording: Recording | None) -> Experiment:
    plant = scene.plant
    linear_study = study(scene.linear, seconds=plant.seconds)
    samples = recorded(recording, scene) if recording is not None else _swept(world, scene, linear_study, plant)
    found = Experiment(
        plant=plant,
        study=linear_study,
        about=f"{plant.of}, from {plant.input} to {', '.join(plant.outputs or ())}; {scene.held} keeps it at its"
        " operating point",
        held=scene.setting.value,
        dry_friction=scene.dry_friction,
        step_poles=_nearest(scene.step_poles(), linear_study.poles),
        identified=None if samples is None else identified(scene.linear, samples),
    )
    # A mass cannot follow a joint that jumps.
    return found if scene.leads_value else _with_responses(found, scene)


def _with_responses(found: Experiment, scene: ScenePlant) -> Experiment:
    """Add the responses of the nonlinear plant, and the fit of the linear one."""
    study, amplitude = found.study, found.amplitude
    time, step = _simulated(scene, study, amplitude)
    linear = np.array([np.interp(time, study.time, row * amplitude) for row in study.step])
    rough = _simulated(scene, study, amplitude, dry_friction=True) if found.dry_friction else None
    return replace(
        found,
        nonlinear=(time, step),
        nonlinear_impulse=_simulated(scene, study, amplitude, impulse=True),
        nonlinear_fit=fit(step, linear).tolist() if len(time) == _count(scene, study) else None,
        rough=rough,
    )


def _simulated(
    scene: ScenePlant, study: Study, amplitude: float, *, impulse: bool = False, dry_friction: bool = False
) -> tuple[Array, Array]:
    dt, count = float(scene.model.opt.timestep), _count(scene, study)
    inputs = np.full(count, amplitude)
    if impulse:
        inputs[:] = 0.0
        inputs[0] = amplitude / dt
    bound = bound_of((study.impulse if impulse else study.step) * amplitude)
    outputs = scene.simulated(inputs, dry_friction=dry_friction, bound=bound)
    return np.asarray(np.arange(outputs.shape[1]) * dt, dtype=float), outputs


def _count(scene: ScenePlant, study: Study) -> int:
    """Return the number of physics steps worth simulating."""
    return min(math.ceil(float(study.time[-1]) / float(scene.model.opt.timestep)) + 1, MAX_SIMULATED)


def _nearest(many: Array, poles: Array) -> Array:
    """Return for each pole the nearest of `many`."""
    return np.array([many[int(np.argmin(np.abs(many - pole)))] for pole in poles])


def _swept(world: World, scene: ScenePlant, study: Study, plant: Plant) -> Samples | None:
    """Return samples of the nonlinear plant for its signal, or a chirp; None if it diverges."""
    if not (study.poles.real < -1e-9).all():
        return None
    slowest = float(np.abs(study.poles.real).min(initial=np.inf))
    seconds = min(
        plant.seconds or (SWEEP_TIME_CONSTANTS / slowest if len(study.poles) else SWEEP_TIME_CONSTANTS), 100.0
    )
    signal = _signal(world, study, plant, seconds)
    dt = float(scene.model.opt.timestep)
    stride = max(round(seconds / dt / MAX_SAMPLES), 1)
    count = min(round(seconds / dt) // stride, MAX_SIMULATED // stride) * stride
    times = np.asarray(np.arange(count) * dt, dtype=float)
    held = not scene.leads_value
    inputs = np.repeat(signal.value(times[::stride]), stride) if held else np.asarray(signal.value(times))
    outputs = scene.simulated(inputs)[:, ::stride]
    if outputs.shape[1] < count // stride:
        return None
    source = "a simulated sweep"
    return Samples(time=times[::stride], inputs=inputs[::stride], outputs=outputs, source=source, held=held)


def _signal(world: World, study: Study, plant: Plant, seconds: float) -> TimeSignal:
    if plant.signal is not None:
        return plant.signal.made(world.read_asset, np.random.default_rng([world.run.seed, *plant.name.encode()]))
    omega = frequencies(study.poles, study.zeros)
    low = max(float(omega[0]) * 10.0 / (2 * math.pi), 1.0 / seconds)
    high = max(float(omega[-1]) / 100.0 / (2 * math.pi) * 2.0, 2.0 * low)
    return Chirp(amplitude=plant.amplitude, first=low, last=high, seconds=seconds)
