"""The radio between robots as a world file describes it."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Length, Model


class Radio(Model):
    """How messages go from robot to robot; walls do not hold them up."""

    range: Length | None = None
    """Farthest distance from sender to receiver, when it is sent [m]; anywhere without."""
    loss: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Probability that a message does not reach a receiver; each receiver has its own luck."""
    delay: Annotated[int, Field(ge=0, le=1000)] = 0
    """How many ticks a message takes beside the one that every message takes."""
