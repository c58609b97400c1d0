"""Tricycle: one wheel that is both driven and steered, and a fixed axle."""

import math
from typing import Annotated, Literal

from pydantic import Field

from mjsim.world.ground import Length
from mjsim.world.items.drives.base import SIDES, AnyDrive, Slip, TurnRate, Wheel, geared_motor, half_width


class TricycleDrive(AnyDrive):
    """One wheel that is both driven and steered, and two on a fixed axle, as in a forklift.

    Its origin is midway between the wheels of the fixed axle.
    """

    type: Literal["tricycle"]
    """Kind of drive."""
    wheel_radius: Length = 0.1
    """Radius of the driven wheel [m]."""
    load_wheel_radius: Length | None = None
    """Radius of the two wheels on the fixed axle [m]; default: that of the driven wheel."""
    wheel_width: Length | None = None
    """[m]; default: half the radius."""
    track: Length = 0.4
    """Distance between the wheels of the fixed axle [m]."""
    wheelbase: Length = 0.6
    """Distance between the driven wheel and the fixed axle [m]."""
    driven: Literal["front", "rear"] = "rear"
    """Position of the driven wheel."""
    max_steer_deg: Annotated[float, Field(gt=0, le=90)] = 90.0
    """Maximum steering angle of the driven wheel; with 90 the robot can turn on the spot."""
    max_steer_rate_deg: TurnRate = 180.0
    """Maximum steering rate [deg/s]."""

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """Two on the fixed axle at the origin, and the driven and steered one."""
        load_radius = self.load_wheel_radius or self.wheel_radius
        fixed = [
            Wheel(
                name=side,
                at=(0.0, y * self.track / 2),
                radius=load_radius,
                half_width=half_width(self.wheel_width, radius=load_radius, track=self.track),
                load="shared",
            )
            for side, y in SIDES
        ]
        driven = Wheel(
            name="drive",
            at=(self.driven_x, 0.0),
            radius=self.wheel_radius,
            half_width=half_width(self.wheel_width, radius=self.wheel_radius, track=self.track),
            load="heavy",
            motor=geared_motor(share=1.0),
            steer="steer",
        )
        return *fixed, driven

    @property
    def driven_x(self) -> float:
        """Position of the driven wheel, ahead of the fixed axle positive [m]."""
        return self.wheelbase if self.driven == "front" else -self.wheelbase

    @property
    def turning_track(self) -> float:
        """The track of the fixed axle [m]."""
        return self.track

    @property
    def max_curvature(self) -> float:
        """Curvature at the largest steering angle [1/m]; infinite from 90 degrees."""
        return math.inf if self.max_steer_deg >= 90.0 else math.tan(math.radians(self.max_steer_deg)) / self.wheelbase

    @property
    def turn_acceleration(self) -> float:
        """Acceleration of the driven wheel, turned across, about the origin; at most that of the key [rad/s^2]."""
        return min(super().turn_acceleration, self.max_acceleration / self.wheelbase)

    @property
    def slip(self) -> Slip:
        """Slip of one wheel that drives and steers, while its angle changes."""
        return Slip(forward=0.002, turn=0.0045)
