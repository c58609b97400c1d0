"""Plants of the control laboratory: a part of the scene, or a model given by formulas."""

from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import COMPLEX_PATTERN, PLANT_PATTERN, Legible, Model, Name, fault
from mjsim.world.items.timeline import Signal

MAX_STATES = 50
"""Largest number of states of a mathematical model."""
Figure = Annotated[float, Field(ge=-1e12, le=1e12)]
Coefficients = Annotated[tuple[Figure, ...], Field(strict=False, min_length=1, max_length=MAX_STATES + 1)]
Root = Figure | Annotated[str, Field(pattern=COMPLEX_PATTERN, max_length=60)]
Roots = Annotated[tuple[Root, ...], Field(strict=False, max_length=MAX_STATES)]
Row = Annotated[tuple[Figure, ...], Field(strict=False, min_length=1, max_length=MAX_STATES)]
Matrix = Annotated[tuple[Row, ...], Field(strict=False, min_length=1, max_length=MAX_STATES)]
Names = Annotated[
    tuple[Name, ...],
    BeforeValidator(lambda value: (value,) if isinstance(value, str) else value),
    Field(strict=False, min_length=1, max_length=10),
]


class _Formula(Model):
    """A model given by formulas, in continuous or discrete time."""

    dt: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Sampling period of a model in discrete time, in powers of z instead of s [s]."""


class _DelayedFormula(_Formula):
    delay: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Delay of the output; with `dt` a whole number of periods [s]."""

    @model_validator(mode="after")
    def _delay_fits(self) -> Self:
        if self.dt is not None:
            periods = self.delay / self.dt
            if abs(periods - round(periods)) > 1e-9 * max(periods, 1.0):
                raise fault(
                    Sentence("delay is {delay:g} s; it must be a multiple of dt, {dt:g} s", self.delay, self.dt),
                    "delay",
                )
            if periods > MAX_STATES:
                raise fault(
                    Sentence("delay is {periods:.0f} periods; it must be at most {max_states}", periods, MAX_STATES),
                    "delay",
                )
        return self


class TransferFunction(_DelayedFormula):
    """A ratio of polynomials in s, highest power first: [12] over [1, 1.09] is 12 / (s + 1.09); with `dt` in z."""

    num: Coefficients
    """Coefficients of the numerator."""
    den: Coefficients
    """Coefficients of the denominator."""

    @model_validator(mode="after")
    def _is_proper(self) -> Self:
        if self.den[0] == 0.0:
            raise fault("the first coefficient of den is 0; leave leading zeros out", "den", 0)
        if len(self.num) > len(self.den):
            raise fault(
                Sentence(
                    "num has degree {num}, den {den}; that of num must not be higher",
                    len(self.num) - 1,
                    len(self.den) - 1,
                ),
                "num",
            )
        if not any(self.num):
            raise fault("all numbers of num are 0; give another", "num")
        return self


class ZerosPolesGain(_DelayedFormula):
    """gain (s - zero) ... / ((s - pole) ...); with `dt` in z."""

    zeros: Roots = ()
    """Zeros [rad/s]; complex ones in pairs, such as -1+2j and -1-2j."""
    poles: Roots
    """Poles, likewise; at least as many as zeros [rad/s]."""
    gain: Figure
    """Factor before the product."""

    @model_validator(mode="after")
    def _is_real_and_proper(self) -> Self:
        if len(self.zeros) > len(self.poles):
            raise fault(
                Sentence(
                    "there are {zeros} zeros; at most {poles} are possible, one for each pole",
                    len(self.zeros),
                    len(self.poles),
                ),
                "zeros",
            )
        if self.gain == 0.0:
            raise fault("gain is 0; give another", "gain")
        for key in ("zeros", "poles"):
            roots = [self._root(root, key) for root in getattr(self, key)]
            alone = next((root for root in roots if roots.count(root) != roots.count(root.conjugate())), None)
            if alone is not None:
                raise fault(
                    Sentence("{key} contain {alone:g} without {conjugate:g}; give both", key, alone, alone.conjugate()),
                    key,
                )
        return self

    @staticmethod
    def _root(root: float | str, key: str) -> complex:
        try:
            value = complex_root(root)
        except ValueError:
            raise fault(Sentence("{key} contain '{root}'; write a complex number as -1+2j", key, root), key) from None
        if not abs(value) <= 1e12:
            raise fault(Sentence("{key} contain '{root}'; it must be at most 1e12", key, root), key)
        return value


def complex_root(root: float | str) -> complex:
    """Return a zero or pole as a number; j or i is the imaginary unit."""
    return complex(root.replace("i", "j").replace(" ", "") if isinstance(root, str) else root)


class StateSpace(_Formula):
    """x' = A x + B u, y = C x + D u; with `dt` x[k + 1] = A x[k] + B u[k]."""

    a: Matrix
    """A, row by row."""
    b: Matrix
    """B, one row per state and one column per input."""
    c: Matrix
    """C, one row per output."""
    d: Matrix | None = None
    """D, one row per output; default: zeros."""

    @model_validator(mode="after")
    def _shapes_fit(self) -> Self:
        states, inputs, outputs = len(self.a), len(self.b[0]), len(self.c)
        expected = {"a": (states, states), "b": (states, inputs), "c": (outputs, states), "d": (outputs, inputs)}
        for key, shape in expected.items():
            rows = getattr(self, key)
            found = None if rows is None else {(len(rows), len(row)) for row in rows}
            if found is not None and found != {shape}:
                raise fault(
                    Sentence(
                        "{key} must have {rows} rows of {columns} each, as a has {states} rows",
                        *(key, shape[0], shape[1], states),
                    ),
                    key,
                )
        return self

    @property
    def inputs(self) -> list[str]:
        """Names of its inputs: u, or u1, u2, ..."""
        return _numbered("u", len(self.b[0]))

    @property
    def outputs(self) -> list[str]:
        """Names of its outputs: y, or y1, y2, ..."""
        return _numbered("y", len(self.c))


def _numbered(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"{name}{k + 1}" for k in range(count)]


class Plant(Model):
    """A plant that `mjsim lab` linearises and analyses: a part of the scene, `tf`, `zpk` or `ss`."""

    name: Name
    """Name in the command."""
    of: Annotated[str, Field(pattern=PLANT_PATTERN, max_length=130), Legible] | None = None
    """A robot, ROBOT/ARM, or a mechanism."""
    input: Name | None = None
    """Input: for a robot `forward`, `turn` or a wheel; for an arm or a mechanism a joint (its torque or force),
    `JOINT.angle`, `JOINT.position`, `JOINT.velocity`, an actuator by its name, or the body that an actuator acts on;
    for `ss` with several inputs `u1`, `u2`, ..."""
    outputs: Names | None = None
    """Outputs, one or a list: joint values; for robots `way`, `lean`, `heading`; with `.rate` their derivatives, such
    as `way.rate`; for `ss` `y1`, `y2`, ..., all by default. Controllers feed back the first."""
    around: Annotated[Mapping[str, Figure], Field(strict=False)] = {}
    """Operating point: joint values by name [m], or by name with `_deg`; others have their start values."""
    tf: TransferFunction | None = None
    """A transfer function, instead of a part of the scene."""
    zpk: ZerosPolesGain | None = None
    """Zeros, poles and a gain, instead of a part of the scene."""
    ss: StateSpace | None = None
    """A state-space model, instead of a part of the scene."""
    amplitude: Annotated[float, Field(gt=0, le=1e9)] = 1.0
    """Size of the step for which linear and nonlinear plant are compared: of the input, or of the set-point of a closed
    loop."""
    saturation: Annotated[float, Field(gt=0, le=1e12)] | None = None
    """Largest input, in either direction, in simulated closed loops; default: unlimited."""
    dead_zone: Annotated[float, Field(ge=0, le=1e12)] = 0.0
    """Inputs up to this have no effect in simulated closed loops; larger ones act less by it."""
    seconds: Annotated[float, Field(gt=0, le=1e4)] | None = None
    """Duration of the responses; default: chosen from the poles [s]."""
    signal: Signal | None = None
    """Input for simulation and identification; default: a chirp over its frequencies."""

    @model_validator(mode="after")
    def _is_one_thing(self) -> Self:
        given = [key for key in ("of", "tf", "zpk", "ss") if getattr(self, key) is not None]
        if len(given) != 1:
            raise fault(
                Sentence(
                    "a plant has one of 'of', 'tf', 'zpk' and 'ss'; this one has {given}", " and ".join(given) or "none"
                )
            )
        if self.of is None:
            for key in ("input", "outputs", "around") if self.ss is None else ("around",):
                if getattr(self, key):
                    raise fault(
                        Sentence("{key} is for a part of the scene; leave it out beside {given}", key, given[0]), key
                    )
            if self.ss is not None:
                self._check_names(self.ss)
        elif self.input is None or self.outputs is None:
            missing = "input" if self.input is None else "outputs"
            raise fault(Sentence("key '{missing}' is missing; a part of the scene has an input and outputs", missing))
        if self.signal is not None and (wrong := self.signal.misfit(angle=False)) is not None:
            raise fault(wrong[0], "signal", *wrong[1])
        return self

    @property
    def dt(self) -> float:
        """Sampling period of a model in discrete time; 0 in continuous time [s]."""
        formula = self.tf or self.zpk or self.ss
        return formula.dt or 0.0 if formula is not None else 0.0

    def _check_names(self, model: StateSpace) -> None:
        """Raise a fault for an input or output that a state space model does not have."""
        if self.input is None and len(model.inputs) > 1:
            raise fault(
                Sentence("input is missing; the state space has {inputs}; name one", ", ".join(model.inputs)), "ss"
            )
        for key, given, known in (
            ("input", (self.input,) if self.input else (), model.inputs),
            ("outputs", self.outputs or (), model.outputs),
        ):
            for name in given:
                if name not in known:
                    raise fault(
                        Sentence("{key} has '{name}'; the state space has {known}", key, name, ", ".join(known)), key
                    )
