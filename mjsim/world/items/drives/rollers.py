"""What drives have in common that go in any direction, on wheels with rollers."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Length
from mjsim.world.items.drives.base import AnyDrive, Speed

RollerRatio = Annotated[float, Field(gt=0.5, lt=1.5)]


class RollerDrive(AnyDrive):
    """What drives have in common that go in any direction, on wheels with rollers."""

    wheel_radius: Length = 0.05
    """Over the rollers [m]."""
    wheel_width: Length | None = None
    """[m]; follows from the rollers unless given."""
    rollers: Annotated[int, Field(ge=6, le=24)] = 12
    """How many a wheel has."""
    max_left: Speed = 0.7
    """Largest speed sideways [m/s]."""

    strafe: RollerRatio = 1.0
    """Metres driven sideways for each that wheels tell by their sizes; rollers slip until they spin."""
    spin: RollerRatio = 1.0
    """Radians turned for each that wheels tell by their sizes."""

    @property
    def sideways(self) -> float:
        """Largest speed sideways [m/s]."""
        return self.max_left
