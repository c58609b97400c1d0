"""Base class of omnidirectional drives, on wheels with rollers."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Length
from mjsim.world.items.drives.base import AnyDrive, Speed

RollerRatio = Annotated[float, Field(gt=0.5, lt=1.5)]


class RollerDrive(AnyDrive):
    """Base class of omnidirectional drives, on wheels with rollers."""

    wheel_radius: Length = 0.05
    """Radius over the rollers [m]."""
    wheel_width: Length | None = None
    """[m]; default: derived from the rollers."""
    rollers: Annotated[int, Field(ge=6, le=24)] = 12
    """Number of rollers per wheel."""
    max_left: Speed = 0.7
    """Maximum speed sideways [m/s]."""

    strafe: RollerRatio = 1.0
    """Ratio of actual sideways motion to that computed from the wheels; rollers slip until they spin."""
    spin: RollerRatio = 1.0
    """Ratio of the actual turn to that computed from the wheels."""

    @property
    def sideways(self) -> float:
        """Maximum speed sideways [m/s]."""
        return self.max_left
