"""The radio between robots, as described in a world file."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Length, Model


class Radio(Model):
    """Radio communication between robots; walls do not attenuate it."""

    range: Length | None = None
    """Maximum distance from sender to receiver at the time of sending [m]; default: unlimited."""
    loss: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Probability that a message is lost, drawn independently for each receiver."""
    delay: Annotated[int, Field(ge=0, le=1000)] = 0
    """Additional delay of a message, in ticks; every message takes one tick."""
