"""Joints of several freedoms: chains of slides and turns that have names of their own."""

from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, model_validator

from mjsim.world.ground import Model, fault
from mjsim.world.items.mechanisms.joints import MechanismJoint, OneAxis, X, Y, Z, chain, unit
from mjsim.world.items.mechanisms.points import Axis, PartName

if TYPE_CHECKING:  # worlds without mechanisms start without it
    from mjsim.mechanics import Primitive

LEAST_SINE = 1e-3
"""Of the angle between two axes that are not one."""


class _TurnAxes(MechanismJoint):
    axes: Annotated[tuple[Axis, ...], Field(strict=False, min_length=2, max_length=3)] | None = None
    """Those that it turns about, one after the other, in the frame of the first body where all values are 0."""

    @model_validator(mode="after")
    def _axes_fit(self) -> Self:
        if self.axes is None:
            return self
        count = len(self._usual())
        if len(self.axes) != count:
            raise fault(f"axes holds {len(self.axes)}; this joint turns about {count}", "axes")
        for place, (one, other) in enumerate(zip(self.axes, self.axes[1:], strict=False), start=1):
            cosine = sum(a * b for a, b in zip(unit(one), unit(other), strict=True))
            if 1.0 - cosine**2 < LEAST_SINE**2:
                raise fault("this axis is parallel to the one before; turn it", "axes", place)
        return self

    def _usual(self) -> tuple[tuple[float, float, float], ...]:
        return (X, Y, Z)

    def turns(self) -> list[tuple[Any, tuple[float, float, float], str]]:
        """Return its turns in order."""
        axes = self._usual() if self.axes is None else tuple(unit(axis) for axis in self.axes)
        return [("turn", axis, str(number)) for number, axis in enumerate(axes, start=1)]


class UniversalJoint(_TurnAxes):
    """A cardan joint: two turns one after the other, about y and z unless `axes` says otherwise."""

    universal: PartName
    """Its name; its values are `NAME.1` and `NAME.2`."""

    def _usual(self) -> tuple[tuple[float, float, float], ...]:
        return (Y, Z)

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return both turns."""
        return chain(*self.turns())


class GimbalJoint(_TurnAxes):
    """Three turns one after the other, about x, y and z unless `axes` says otherwise; locks at 90 degrees."""

    gimbal: PartName
    """Its name; its values are `NAME.1`, `NAME.2` and `NAME.3`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return the turns."""
        return chain(*self.turns())


class BearingJoint(_TurnAxes):
    """A slide along x, then three turns about x, y and z, unless `axes` says otherwise for both."""

    bearing: PartName
    """Its name; its values are `NAME.slide`, `NAME.1`, `NAME.2` and `NAME.3`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slide and turns."""
        turns = self.turns()
        return chain(("slide", turns[0][1], "slide"), *turns)


class BushingJoint(_TurnAxes):
    """Three slides along x, y and z, then three turns about them; give it stiffness and damping."""

    bushing: PartName
    """Its name; its values are `NAME.x`, `NAME.y`, `NAME.z`, `NAME.1`, `NAME.2` and `NAME.3`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slides and turns."""
        return chain(("slide", X, "x"), ("slide", Y, "y"), ("slide", Z, "z"), *self.turns())


class TelescopingJoint(OneAxis):
    """A slide along an axis with a ball at its end."""

    telescoping: PartName
    """Its name; its values are `NAME.slide`, and the rotation vector `NAME.rx`, `NAME.ry`, `NAME.rz`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slide and ball."""
        return chain(("slide", self.direction(axis), "slide"), ("ball", Z, ""))


class SixDofJoint(MechanismJoint):
    """All freedoms: three slides and a ball."""

    six_dof: PartName
    """Its name; its values are `NAME.x`, `.y`, `.z`, and the rotation vector `.rx`, `.ry`, `.rz`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slides and ball."""
        return chain(("slide", X, "x"), ("slide", Y, "y"), ("slide", Z, "z"), ("ball", Z, ""))


class ScrewJoint(OneAxis):
    """A thread: a turn about an axis that goes with a slide along it."""

    screw: PartName
    """Its name; its values are `NAME.turn` and `NAME.slide`."""
    pitch: Annotated[float, Field(ge=-100, le=100)]
    """How far it slides in one turn; negative for a left-hand thread [m]."""

    @model_validator(mode="after")
    def _is_a_thread(self) -> Self:
        if self.pitch == 0.0:
            raise fault("pitch is 0 m; use a revolute joint, which does not slide", "pitch")
        return self

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return turn and slide."""
        along = self.direction(axis)
        return chain(("turn", along, "turn"), ("slide", along, "slide"))


class CustomMotion(Model):
    """One motion of a custom joint: exactly one of these keys."""

    slide: Axis | None = None
    """Along this axis, in the frame of the first body where all values are 0."""
    turn: Axis | None = None
    """About this axis."""
    ball: bool = False
    """About all axes; the last motion, of a joint that has no turn."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        given = [key for key in ("slide", "turn") if getattr(self, key) is not None] + ["ball"] * self.ball
        if len(given) != 1:
            raise fault("a motion is one of slide: [x, y, z], turn: [x, y, z] and ball: true")
        return self


class CustomJoint(MechanismJoint):
    """Up to three slides and three turns in any order, or slides and a ball."""

    custom: PartName
    """Its name; its values are `NAME.1`, `NAME.2` and so on, of a ball `NAME.rx`, `NAME.ry`, `NAME.rz`."""
    motions: Annotated[tuple[CustomMotion, ...], Field(strict=False, min_length=1, max_length=6)]
    """One after the other, from the first body to the second."""

    @model_validator(mode="before")
    @classmethod
    def _counted(cls, keys: Any) -> Any:
        """Count before the lists of values are compared with what moves."""
        motions = keys.get("motions") if isinstance(keys, dict) else None
        if isinstance(motions, (list, tuple)) and all(isinstance(each, dict) for each in motions):
            slides, turns = (sum(key in each for each in motions) for key in ("slide", "turn"))
            balls = [place for place, each in enumerate(motions) if each.get("ball") is True]
            if slides > 3 or turns > 3:
                raise fault(f"it has {slides} slides and {turns} turns; a joint has at most 3 of each", "motions")
            if balls and (turns or len(balls) > 1 or balls[0] != len(motions) - 1):
                raise fault(
                    "a ball turns about all axes; make it the last motion, and leave out turns", "motions", balls[0]
                )
        return keys

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return its motions."""
        parts: list[tuple[Any, tuple[float, float, float], str]] = []
        for number, each in enumerate(self.motions, start=1):
            along = each.slide or each.turn
            kind = "slide" if each.slide else "turn" if each.turn else "ball"
            parts.append((kind, Z if along is None else unit(along), "" if along is None else str(number)))
        return chain(*parts)
