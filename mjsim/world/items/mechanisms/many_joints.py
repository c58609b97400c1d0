"""Joints with several degrees of freedom: named chains of translations and rotations."""

from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Model, fault
from mjsim.world.items.mechanisms.joints import MechanismJoint, OneAxis, X, Y, Z, chain, unit
from mjsim.world.items.mechanisms.points import Axis, PartName

if TYPE_CHECKING:  # Imported where it is used: worlds without mechanisms load faster.
    from mjsim.mechanics import Primitive

MIN_SINE = 1e-3
"""Smallest sine of the angle between two distinct axes."""


class _TurnAxes(MechanismJoint):
    axes: Annotated[tuple[Axis, ...], Field(strict=False, min_length=2, max_length=3)] | None = None
    """Axes of rotation in sequence, in the frame of the first body at joint values 0."""

    @model_validator(mode="after")
    def _axes_fit(self) -> Self:
        if self.axes is None:
            return self
        count = len(self._usual())
        if len(self.axes) != count:
            raise fault(Sentence("axes holds {given}; this joint turns about {count}", len(self.axes), count), "axes")
        for place, (one, other) in enumerate(zip(self.axes, self.axes[1:], strict=False), start=1):
            cosine = sum(a * b for a, b in zip(unit(one), unit(other), strict=True))
            if 1.0 - cosine**2 < MIN_SINE**2:
                raise fault("this axis is parallel to the one before; turn it", "axes", place)
        return self

    def _usual(self) -> tuple[tuple[float, float, float], ...]:
        return (X, Y, Z)

    def turns(self) -> list[tuple[Any, tuple[float, float, float], str]]:
        """Return its rotations in order."""
        axes = self._usual() if self.axes is None else tuple(unit(axis) for axis in self.axes)
        return [("turn", axis, str(number)) for number, axis in enumerate(axes, start=1)]


class UniversalJoint(_TurnAxes):
    """A universal (Cardan) joint: two rotations in sequence, by default about y and z."""

    universal: PartName
    """Its name; its values are `NAME.1` and `NAME.2`."""

    def _usual(self) -> tuple[tuple[float, float, float], ...]:
        return (Y, Z)

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return both rotations."""
        return chain(*self.turns())


class GimbalJoint(_TurnAxes):
    """Three rotations in sequence, by default about x, y and z; singular at 90 degrees."""

    gimbal: PartName
    """Its name; its values are `NAME.1`, `NAME.2` and `NAME.3`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return the rotations."""
        return chain(*self.turns())


class BearingJoint(_TurnAxes):
    """A translation, then three rotations in sequence, by default along x and about x, y and z."""

    bearing: PartName
    """Its name; its values are `NAME.slide`, `NAME.1`, `NAME.2` and `NAME.3`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slide and rotations."""
        turns = self.turns()
        return chain(("slide", turns[0][1], "slide"), *turns)


class BushingJoint(_TurnAxes):
    """Three translations along x, y and z, then three rotations about them; set stiffness and damping."""

    bushing: PartName
    """Its name; its values are `NAME.x`, `NAME.y`, `NAME.z`, `NAME.1`, `NAME.2` and `NAME.3`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slides and rotations."""
        return chain(("slide", X, "x"), ("slide", Y, "y"), ("slide", Z, "z"), *self.turns())


class TelescopingJoint(OneAxis):
    """A translation along an axis with a ball joint at its end."""

    telescoping: PartName
    """Its name; its values are `NAME.slide`, and the rotation vector `NAME.rx`, `NAME.ry`, `NAME.rz`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slide and ball."""
        return chain(("slide", self.direction(axis), "slide"), ("ball", Z, ""))


class SixDofJoint(MechanismJoint):
    """All six degrees of freedom: three translations and a ball joint."""

    six_dof: PartName
    """Its name; its values are `NAME.x`, `.y`, `.z`, and the rotation vector `.rx`, `.ry`, `.rz`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slides and ball."""
        return chain(("slide", X, "x"), ("slide", Y, "y"), ("slide", Z, "z"), ("ball", Z, ""))


class ScrewJoint(OneAxis):
    """A screw: a rotation about an axis coupled with a translation along it."""

    screw: PartName
    """Its name; its values are `NAME.turn` and `NAME.slide`."""
    pitch: Annotated[float, Field(ge=-100, le=100)]
    """Translation per revolution; negative for a left-hand thread [m]."""

    @model_validator(mode="after")
    def _is_a_thread(self) -> Self:
        if self.pitch == 0.0:
            raise fault("pitch is 0 m; use a revolute joint, which does not slide", "pitch")
        return self

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return rotation and slide."""
        along = self.direction(axis)
        return chain(("turn", along, "turn"), ("slide", along, "slide"))


class CustomMotion(Model):
    """One elementary motion of a custom joint: exactly one of these keys."""

    slide: Axis | None = None
    """Translation along this axis, in the frame of the first body at joint values 0."""
    turn: Axis | None = None
    """Rotation about this axis."""
    ball: bool = False
    """Rotation about all axes; must be the last motion of a joint without other rotations."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        given = [key for key in ("slide", "turn") if getattr(self, key) is not None] + ["ball"] * self.ball
        if len(given) != 1:
            raise fault("a motion is one of slide: [x, y, z], turn: [x, y, z] and ball: true")
        return self


class CustomJoint(MechanismJoint):
    """Up to three translations and three rotations in any order, or translations and a ball joint."""

    custom: PartName
    """Its name; its values are `NAME.1`, `NAME.2` and so on; of a ball `NAME.rx`, `NAME.ry`, `NAME.rz`."""
    motions: Annotated[tuple[CustomMotion, ...], Field(strict=False, min_length=1, max_length=6)]
    """Motions in sequence, from the first body to the second."""

    @model_validator(mode="before")
    @classmethod
    def _counted(cls, keys: Any) -> Any:
        """Check the number of motions before the lists of values are compared with it."""
        motions = keys.get("motions") if isinstance(keys, dict) else None
        if isinstance(motions, (list, tuple)) and all(isinstance(each, dict) for each in motions):
            slides, turns = (sum(key in each for each in motions) for key in ("slide", "turn"))
            balls = [place for place, each in enumerate(motions) if each.get("ball") is True]
            if slides > 3 or turns > 3:
                raise fault(
                    Sentence("it has {slides} slides and {turns} turns; a joint has at most 3 of each", slides, turns),
                    "motions",
                )
            if balls and (turns or len(balls) > 1 or balls[0] != len(motions) - 1):
                raise fault(
                    "a ball turns about all axes; make it the last motion, and leave out turns", "motions", balls[0]
                )
        return keys

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return its elementary motions."""
        parts: list[tuple[Any, tuple[float, float, float], str]] = []
        for number, each in enumerate(self.motions, start=1):
            along = each.slide or each.turn
            kind = "slide" if each.slide else "turn" if each.turn else "ball"
            parts.append((kind, Z if along is None else unit(along), "" if along is None else str(number)))
        return chain(*parts)
