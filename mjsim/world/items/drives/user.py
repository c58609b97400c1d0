"""A user-defined drive."""

from typing import Annotated

from pydantic import ConfigDict, Field

from mjsim.world.items.drives.base import AnyDrive
from mjsim.world.items.running import Use


class UserDrive(AnyDrive, Use):
    """A user-defined drive: a class that converts between twist and wheel speeds (`mjsim.DriveModel`).

    Its body is a `model`. Keys other than these are keyword arguments of the class.
    """

    model_config = ConfigDict(extra="allow")

    max_left: Annotated[float, Field(ge=0, le=20)] = 0.0
    """Maximum speed sideways [m/s]."""

    @property
    def type(self) -> str:
        """Its type, as modules know it: the name of the class."""
        return self.use.rpartition(":")[2]

    @property
    def sideways(self) -> float:
        """Maximum speed sideways [m/s]."""
        return self.max_left
