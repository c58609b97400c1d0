"""Base classes of sensor models: kind, mounting, and presets of real devices."""

from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, Field, model_validator

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import PART_PATTERN, Distance, Legible, Model, Name, Point3, Slider, fault
from mjsim.world.items.sensing.sensor_presets import over_sensor


def _ascending(bounds: tuple[float, ...]) -> tuple[float, ...]:
    if bounds[0] >= bounds[1]:
        raise ValueError(Sentence("range is {range} m; the nearest must be less than the farthest", list(bounds)))
    return bounds


Latency = Annotated[int, Field(ge=0, le=1000)]
"""Whole ticks."""
Chance = Annotated[float, Field(ge=0, le=1), Slider(0.0, 1.0)]
"""A probability."""
Bounds = Annotated[tuple[Distance, ...], Field(strict=False, min_length=2, max_length=2), AfterValidator(_ascending)]
"""[nearest, farthest] [m]."""
Pitch = Annotated[float, Field(ge=-89, le=89)]


class SensorModel(Model):
    """Base class of sensor models."""

    kind: ClassVar[str]
    """The key of sensors of this kind, also given to modules."""
    reading: ClassVar[str]
    """The field of `Observation` with its readings."""
    noise_keys: ClassVar[tuple[str, ...]] = ("noise",)
    """Keys of its noise, which may change during a run."""
    is_housed: ClassVar[bool] = False
    """Whether it has a round housing at the key `at`."""
    between_ticks: ClassVar[bool] = False
    """Whether it measures between ticks, so that a tick gets several readings."""

    @property
    def housing(self) -> Point3 | None:
        """Position of its round housing, [x, y, z] in the robot frame [m]; None if it has none."""
        return getattr(self, "at", None) if self.is_housed else None

    def misfit(self, robot: Any) -> str | None:
        """Return a sentence that says why a robot cannot carry this sensor; None if it can."""
        return None

    @model_validator(mode="before")
    @classmethod
    def _not_on_an_arm(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and "on" in keys and "on" not in cls.model_fields:
            raise fault(
                Sentence("a sensor '{kind}' is on the body of a robot, not on its arms; leave out 'on'", cls.kind), "on"
            )
        return keys


class OnArm(SensorModel):
    """A sensor that an arm may carry."""

    on: Annotated[str, Field(pattern=PART_PATTERN, max_length=129), Legible] | None = None
    """Part of an arm that carries it, ARM/link1 and so on or ARM/tool, which defines its frame; default: the body."""

    def misfit(self, robot: Any) -> str | None:
        """Return a sentence that says why a robot cannot carry this sensor; None if it can."""
        parts = [part for arm in robot.arms for part in arm.parts()]
        if self.on is None or self.on in parts:
            return None
        return Sentence("no part '{on}' of an arm of this robot{meant}", self.on, did_you_mean(self.on, parts))


class Bought(OnArm):
    """A sensor with presets of real devices."""

    preset: Name | None = None
    """Preset from `assets/sensors`; keys given here override it."""

    @model_validator(mode="before")
    @classmethod
    def _over_preset(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and isinstance(keys.get("preset"), str):
            try:
                return over_sensor(cls.kind, keys["preset"], keys)
            except ValueError as error:
                raise fault(str(error), "preset") from None
        return keys
