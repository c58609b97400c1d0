"""The parts of a mechanism, and what to use instead of those that are not simulated."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from mjsim.world.ground import Model, fault
from mjsim.world.items.mechanisms.actuators import Actuator
from mjsim.world.items.mechanisms.constraints import Constraint, ParallelConstraint
from mjsim.world.items.mechanisms.joint_kinds import Jointed
from mjsim.world.items.mechanisms.joints import MechanismJoint
from mjsim.world.items.mechanisms.many_joints import CustomJoint
from mjsim.world.items.mechanisms.measurements import MechanismSensor
from mjsim.world.items.mechanisms.mechanism_links import MechanismBody


class MechanismParts(Model):
    """Bodies, joints, actuators and sensors, before assembly."""

    mode: Literal["forward", "inverse", "kinematics", "trim"] = "forward"
    """forward: forces move it. inverse, kinematics: motions prescribe every degree of freedom exactly, and the required
    forces are computed. trim: it starts in an equilibrium."""
    bodies: Annotated[tuple[MechanismBody, ...], Field(strict=False, min_length=1, max_length=200)]
    """Its bodies."""
    joints: Annotated[tuple[Jointed, ...], Field(strict=False, min_length=1, max_length=300)]
    """Its joints; a joint between bodies that are already connected closes a loop."""
    constraints: Annotated[tuple[Constraint, ...], Field(strict=False, max_length=200)] = ()
    """Constraints in addition to joints: gears, screws, distances, parallel axes."""
    actuators: Annotated[tuple[Actuator, ...], Field(strict=False, max_length=200)] = ()
    """Its actuators."""
    sensors: Annotated[tuple[MechanismSensor, ...], Field(strict=False, max_length=200)] = ()
    """Its sensors, recorded in addition to the joints."""

    @model_validator(mode="before")
    @classmethod
    def _can_be_simulated(cls, keys: Any) -> Any:
        refuse(keys)
        return keys

    def written(self, number: int) -> tuple[str | int, ...]:
        """Return the path of the bodies of one of all joints: that of a joint, or of a constraint."""
        if number < len(self.joints):
            return ("joints", number, "of")
        parallel = [place for place, item in enumerate(self.constraints) if isinstance(item, ParallelConstraint)]
        return ("constraints", parallel[number - len(self.joints)], "parallel")

    @cached_property
    def all_joints(self) -> tuple[MechanismJoint, ...]:
        """Its joints, and those equivalent to constraints: a parallel axis is three slides and a rotation."""
        found: list[MechanismJoint] = list(self.joints)
        for number, item in enumerate(self.constraints):
            if isinstance(item, ParallelConstraint):
                slides = [{"slide": axis} for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
                keys = {"custom": item.called(number), "of": item.parallel}
                found.append(CustomJoint.model_validate({**keys, "motions": [*slides, {"turn": item.axis}]}))
        return tuple(found)


INSTEAD = {
    ("bodies", "variable_mass"): "a mass that changes is not simulated; give the change of weight as"
    " {force: BODY.center, axis: [0, 0, -1], signal: ...}",
    ("bodies", "variable_inertia"): "an inertia that changes is not simulated; move a mass on a prismatic joint with"
    " position: JOINT",
}
"""Messages by list and key."""


def refuse(keys: Any) -> None:
    """Raise a fault for keys of a mechanism that cannot be simulated.

    Args:
        keys: Keys of the mechanism, as written.
    """
    for (part, key), line in INSTEAD.items():
        items = keys.get(part) if isinstance(keys, Mapping) else None
        for number, item in enumerate(items if isinstance(items, (list, tuple)) else ()):
            if isinstance(item, Mapping) and key in item:
                raise fault(line, part, number, key)
