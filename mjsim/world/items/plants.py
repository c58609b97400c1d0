"""Plants of the control laboratory: a part of the scene, or a model given by formulas."""

from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from mjsim.world.ground import PLANT_PATTERN, Legible, Model, Name, fault
from mjsim.world.items.timeline import Signal

MAX_STATES = 50
"""Largest number of states of a mathematical model."""
Figure = Annotated[float, Field(ge=-1e12, le=1e12)]
Coefficients = Annotated[tuple[Figure, ...], Field(strict=False, min_length=1, max_length=MAX_STATES + 1)]
Row = Annotated[tuple[Figure, ...], Field(strict=False, min_length=1, max_length=MAX_STATES)]
Matrix = Annotated[tuple[Row, ...], Field(strict=False, min_length=1, max_length=MAX_STATES)]
Names = Annotated[
    tuple[Name, ...],
    BeforeValidator(lambda value: (value,) if isinstance(value, str) else value),
    Field(strict=False, min_length=1, max_length=10),
]


class TransferFunction(Model):
    """A ratio of polynomials in s, highest power first: [12] over [1, 1.09] is 12 / (s + 1.09); optional delay."""

    num: Coefficients
    """Coefficients of the numerator."""
    den: Coefficients
    """Coefficients of the denominator."""
    delay: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Delay of the output, with a fifth-order Pade approximation [s]."""

    @model_validator(mode="after")
    def _is_proper(self) -> Self:
        if self.den[0] == 0.0:
            raise fault("the first coefficient of den is 0; leave leading zeros out", "den", 0)
        if len(self.num) > len(self.den):
            raise fault(f"num has degree {len(self.num) - 1}, den {len(self.den) - 1}; num's must not be higher", "num")
        if not any(self.num):
            raise fault("num is 0 altogether; give a coefficient", "num")
        return self


class StateSpace(Model):
    """x' = A x + B u, y = C x + D u."""

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
                raise fault(f"{key} must have {shape[0]} rows of {shape[1]} each, as a has {states} rows", key)
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
    """A plant that `mjsim lab` linearises and analyses: a part of the scene, `tf` or `ss`."""

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
    ss: StateSpace | None = None
    """A state-space model, instead of a part of the scene."""
    amplitude: Annotated[float, Field(gt=0, le=1e9)] = 1.0
    """Size of the step for which linear and nonlinear plant are compared: of the input, or of the set-point of a closed
    loop."""
    seconds: Annotated[float, Field(gt=0, le=1e4)] | None = None
    """Duration of the responses; default: chosen from the poles [s]."""
    signal: Signal | None = None
    """Input for simulation and identification; default: a chirp over its frequencies."""

    @model_validator(mode="after")
    def _is_one_thing(self) -> Self:
        given = [key for key in ("of", "tf", "ss") if getattr(self, key) is not None]
        if len(given) != 1:
            raise fault(f"a plant has one of 'of', 'tf' and 'ss'; this one has {' and '.join(given) or 'none'}")
        if self.of is None:
            for key in ("input", "outputs", "around") if self.ss is None else ("around",):
                if getattr(self, key):
                    raise fault(f"{key} is for a part of the scene; leave it out beside {given[0]}", key)
            if self.ss is not None:
                self._check_names(self.ss)
        elif self.input is None or self.outputs is None:
            missing = "input" if self.input is None else "outputs"
            raise fault(f"key '{missing}' is missing; a part of the scene has an input and outputs")
        if self.signal is not None and (wrong := self.signal.misfit(angle=False)) is not None:
            raise fault(wrong[0], "signal", *wrong[1])
        return self

    def _check_names(self, model: StateSpace) -> None:
        """Raise a fault for an input or output that a state space model does not have."""
        if self.input is None and len(model.inputs) > 1:
            raise fault(f"input is missing; the state space has {', '.join(model.inputs)}, so say which", "ss")
        for key, given, known in (
            ("input", (self.input,) if self.input else (), model.inputs),
            ("outputs", self.outputs or (), model.outputs),
        ):
            for name in given:
                if name not in known:
                    raise fault(f"{key} has '{name}'; the state space has {', '.join(known)}", key)
