"""Four mecanum wheels."""

import math
from typing import Literal

from mjsim.world.ground import Length
from mjsim.world.items.drives.base import CORNERS, Rollers, Slip, Wheel, geared_motor, half_width
from mjsim.world.items.drives.rollers import RollerDrive, RollerRatio


class MecanumDrive(RollerDrive):
    """Four wheels with rollers at 45 degrees."""

    type: Literal["mecanum"]
    """Kind of drive."""
    track: Length = 0.3
    """Distance between the left and the right wheels [m]."""
    wheelbase: Length = 0.47
    """Distance between the front and the rear wheels [m]."""
    strafe: RollerRatio = 0.987
    """Ratio of actual sideways motion to that computed from the wheels; rollers slip until they spin."""
    spin: RollerRatio = 0.994
    """Ratio of the actual turn to that computed from the wheels."""

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """One at each corner; the axes of the rollers on the floor are across the lines to the robot's centre."""
        return tuple(
            Wheel(
                name=name,
                at=(x * self.wheelbase / 2, y * self.track / 2),
                radius=self.wheel_radius,
                half_width=half_width(self.wheel_width, radius=self.wheel_radius, track=self.track),
                motor=geared_motor(share=0.5),
                rollers=Rollers(angle=x * y * math.pi / 4, count=self.rollers),
            )
            for name, x, y in CORNERS
        )

    @property
    def turning_track(self) -> float:
        """The track [m]."""
        return self.track

    @property
    def slip(self) -> Slip:
        """Slip of wheels that roll from one roller onto the next, in addition to `strafe` and `spin`."""
        return Slip(forward=0.0033, left=0.0043, turn=0.0037, outward=0.0)
