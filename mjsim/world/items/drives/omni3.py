"""Three omni wheels on a circle."""

import math
from typing import Literal

from mjsim.world.ground import Length
from mjsim.world.items.drives.base import Rollers, Slip, Wheel, geared_motor, half_width
from mjsim.world.items.drives.rollers import RollerDrive

OMNI3_BEARINGS = {"front_left": math.pi / 3, "rear": math.pi, "front_right": -math.pi / 3}
"""Bearings of the wheels on their circle, left positive [rad]."""


class Omni3Drive(RollerDrive):
    """Three omni wheels on a circle: front left, rear, and front right."""

    type: Literal["omni3"]
    """Kind of drive."""
    wheel_circle: Length = 0.15
    """Radius of the circle of the wheels [m]."""

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """On the circle, rolling along its tangent; their rollers are at 90 degrees."""
        return tuple(
            Wheel(
                name=name,
                at=(self.wheel_circle * math.cos(bearing), self.wheel_circle * math.sin(bearing)),
                radius=self.wheel_radius,
                half_width=half_width(self.wheel_width, radius=self.wheel_radius),
                heading=bearing + math.pi / 2,
                motor=geared_motor(share=0.5),
                rollers=Rollers(angle=math.pi / 2, count=self.rollers),
            )
            for name, bearing in OMNI3_BEARINGS.items()
        )

    @property
    def turning_track(self) -> float:
        """The diameter of the circle [m]."""
        return 2.0 * self.wheel_circle

    @property
    def slip(self) -> Slip:
        """Slip of wheels with rollers at 90 degrees, which creep equally in all directions."""
        return Slip(forward=0.0015, left=0.0015, outward=0.0)
