"""How `mjsim run` drives a world: time, seed, and the modules of each robot."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from mjsim.world.base import PHYSICS_STEP, Model, Name


class Use(Model):
    """A class of the user's own; the keys beside `use` are its keyword arguments."""

    model_config = ConfigDict(extra="allow")

    use: Annotated[str, Field(pattern=r"^[^:]+:[A-Za-z_][A-Za-z0-9_]*$", max_length=256)]
    """'dotted.module:Class', or 'file.py:Class' beside the world file."""

    def arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of the class."""
        return dict(self.model_extra or {})


class Modules(Model):
    """The modules of one robot; without an estimator dead reckoning, without a navigator it stands still."""

    observer: Use | None = None
    estimator: Use | None = None
    navigator: Use | None = None
    avoidance: bool | Use = False
    """Whether obstacles are avoided, or the user's own class that does."""


class View(Model):
    """What the video and the live view show."""

    follow: Literal["truth", "estimate", "nothing"] = "truth"
    """Whom the close-up follows."""
    sightings: bool = True
    ellipses: bool = True
    trails: bool = True


class Run(Model):
    """One run of this world."""

    seconds: Annotated[float, Field(gt=0, le=1e6)] = 60.0
    rate_hz: Annotated[float, Field(gt=0, le=250)] = 25.0
    """Ticks of the loop a second; a tick is a whole number of 4 ms physics steps."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    map: Literal["unknown", "known"] = "unknown"
    """Known: modules get the map and where the beacons hang."""
    view: View = View()
    drivers: Annotated[Mapping[Name, Modules], Field(strict=False)] = {}
    """The modules of each robot, by its name."""

    @model_validator(mode="after")
    def _whole_steps(self) -> Self:
        steps = 1.0 / (self.rate_hz * PHYSICS_STEP)
        if abs(steps - round(steps)) > 1e-9:
            nearest = 1.0 / (max(round(steps), 1) * PHYSICS_STEP)
            raise ValueError(
                f"rate_hz is {self.rate_hz:g}; a tick must be a whole number of {PHYSICS_STEP * 1e3:g} ms steps,"
                f" the nearest rate is {nearest:g}"
            )
        return self

    @property
    def steps_per_tick(self) -> int:
        """Physics steps in one tick."""
        return round(1.0 / (self.rate_hz * PHYSICS_STEP))
