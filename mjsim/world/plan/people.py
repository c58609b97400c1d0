"""People seen from above."""

from collections.abc import Iterator

from mjsim.geometry import Array
from mjsim.world.items import Person


def from_above(person: Person) -> Iterator[tuple[Array, str]]:
    """Yield outlines of a person's segments, the lowest first, each with its colour.

    Outlines are convex, in the world frame, counter-clockwise, shape (n, 2) [m].
    """
    for segment, (outline, _, _) in person.prisms.items():
        yield outline, person.color_of(segment)
