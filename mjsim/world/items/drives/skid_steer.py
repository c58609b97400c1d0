"""Skid steering: four driven wheels that do not steer."""

from typing import Literal

from mjsim.world.ground import Length
from mjsim.world.items.drives.base import CORNERS, AnyDrive, Motor, Slip, Wheel, half_width


class SkidSteerDrive(AnyDrive):
    """Four driven wheels without steering, equal speeds per side; it turns by sideways slip."""

    type: Literal["skid_steer"]
    """Kind of drive."""
    wheel_radius: Length = 0.1
    """[m]"""
    wheel_width: Length | None = None
    """[m]; default: half the radius."""
    track: Length = 0.4
    """Distance between the left and the right wheels [m]."""
    wheelbase: Length = 0.3
    """Distance between the front and the rear wheels [m]."""
    effective_track: Length | None = None
    """Track of the equivalent differential drive [m]; default: derived from wheelbase and track."""

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """One at each corner; no load slows them down, since the tyres slip first."""
        return tuple(
            Wheel(
                name=name,
                at=(x * self.wheelbase / 2, y * self.track / 2),
                radius=self.wheel_radius,
                half_width=half_width(self.wheel_width, radius=self.wheel_radius, track=self.track),
                motor=Motor(inertia=4.0, share=None),
            )
            for name, x, y in CORNERS
        )

    @property
    def turning_track(self) -> float:
        """Track of the differential drive that turns as this one does [m].

        Four equal wheels with equal loads at (+-a, +-b) from the centre. While the robot turns at w, a wheel with rim
        speed u slips by u - w b along and by w a across. Friction opposes the slip; the sum of all four has no moment
        when (u - w b) b = w a^2, so u = w (a^2 + b^2) / b: a track of 2 (a^2 + b^2) / b.
        """
        return self.effective_track or self.track * (1.0 + (self.wheelbase / self.track) ** 2)

    @property
    def slip(self) -> Slip:
        """Slip of four fixed wheels, which turn by slipping sideways."""
        return Slip(forward=0.019, left=0.015, turn=0.028, outward=0.0, surge=0.029, swing=0.02)
