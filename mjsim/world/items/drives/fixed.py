"""A fixed base without wheels."""

from typing import Literal

from mjsim.world.items.drives.base import AnyDrive


class FixedDrive(AnyDrive):
    """Placeholder for the drive of a fixed base; written as `base: fixed`."""

    type: Literal["fixed"]
    """Kind of drive."""
