"""A drive of the user's own."""

from typing import Annotated

from pydantic import ConfigDict, Field

from mjsim.world.items.drives.base import AnyDrive
from mjsim.world.items.running import Use


class UserDrive(AnyDrive, Use):
    """A drive of the user's own: a class that knows how twist and wheels belong together (`mjsim.DriveModel`).

    Its body is a `model`. The keys beside those named here are keyword arguments of the class.
    """

    model_config = ConfigDict(extra="allow")

    max_left: Annotated[float, Field(ge=0, le=20)] = 0.0
    """Largest speed sideways [m/s]."""

    @property
    def type(self) -> str:
        """What modules are told: the name of the class."""
        return self.use.rpartition(":")[2]

    @property
    def sideways(self) -> float:
        """Largest speed sideways [m/s]."""
        return self.max_left
