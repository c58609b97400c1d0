"""Differential drive: two driven wheels on one axle."""

from typing import Literal

from mjsim.world.ground import Length
from mjsim.world.items.drives.base import SIDES, AnyDrive, Motor, Wheel, half_width


class DifferentialDrive(AnyDrive):
    """Two driven wheels on one axle, and frictionless casters."""

    type: Literal["differential"] = "differential"
    """Kind of drive."""
    wheel_radius: Length = 0.0975
    """[m]"""
    track: Length = 0.33
    """Distance between the wheels [m]."""

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """One on each side of the origin."""
        return tuple(
            Wheel(
                name=side,
                at=(0.0, y * self.track / 2),
                radius=self.wheel_radius,
                half_width=half_width(None, radius=self.wheel_radius, track=self.track),
                motor=Motor(inertia=0.02, share=0.5, follows_load=True),
                spokes=False,
            )
            for side, y in SIDES
        )

    @property
    def on_casters(self) -> bool:
        """Always true."""
        return True

    @property
    def turning_track(self) -> float:
        """The track [m]."""
        return self.track
