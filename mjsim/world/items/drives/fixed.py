"""A base that stands: no wheels, and nothing that moves it."""

from typing import Literal

from mjsim.world.items.drives.base import AnyDrive


class FixedDrive(AnyDrive):
    """What stands in the place of a drive where the base is fixed; written as `base: fixed`."""

    type: Literal["fixed"]
    """Its kind."""
