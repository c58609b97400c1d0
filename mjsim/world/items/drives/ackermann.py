"""Ackermann steering, as in a car."""

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Length, fault
from mjsim.world.items.drives.base import SIDES, AnyDrive, TurnRate, Wheel, geared_motor, half_width


class AckermannDrive(AnyDrive):
    """A car: two driven rear wheels, and two front wheels that steer about a common centre.

    Its origin is midway between the rear wheels. It cannot turn on the spot.
    """

    type: Literal["ackermann"]
    """Kind of drive."""
    wheel_radius: Length = 0.05
    """[m]"""
    wheel_width: Length | None = None
    """[m]; default: half the radius."""
    track: Length = 0.25
    """Distance between the left and the right wheels [m]."""
    wheelbase: Length = 0.33
    """Distance between the axles [m]."""
    max_steer_deg: Annotated[float, Field(gt=0, le=60)] = 24.0
    """Maximum steering angle, for a virtual wheel midway between the steered ones."""
    max_steer_rate_deg: TurnRate = 180.0
    """Maximum steering rate [deg/s]."""

    @model_validator(mode="after")
    def _wheels_clear_the_centre(self) -> Self:
        radius = self.wheelbase / math.tan(math.radians(self.max_steer_deg))
        if radius <= 0.55 * self.track:
            raise fault(
                Sentence(
                    "max_steer_deg is {max_steer_deg:g} deg; the turning radius would be {radius:.3g} m, too small"
                    " for half the track of {track:g} m; reduce it",
                    *(self.max_steer_deg, radius, self.track / 2),
                ),
                "max_steer_deg",
            )
        return self

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """Two driven wheels at the origin, two steered wheels ahead."""
        radius, half = self.wheel_radius, half_width(self.wheel_width, radius=self.wheel_radius, track=self.track)
        rear = [
            Wheel(
                name=f"rear_{side}",
                at=(0.0, y * self.track / 2),
                radius=radius,
                half_width=half,
                load="shared",
                motor=geared_motor(share=0.5),
            )
            for side, y in SIDES
        ]
        front = [
            Wheel(
                name=f"front_{side}",
                at=(self.wheelbase, y * self.track / 2),
                radius=radius,
                half_width=half,
                load="shared",
                steer=f"steer_front_{side}",
            )
            for side, y in SIDES
        ]
        return *rear, *front

    @property
    def turning_track(self) -> float:
        """The track [m]."""
        return self.track

    @property
    def max_curvature(self) -> float:
        """Curvature at the largest steering angle [1/m]."""
        return math.tan(math.radians(self.max_steer_deg)) / self.wheelbase
