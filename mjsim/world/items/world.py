"""The world: the contents of a world file, validated and frozen."""

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, PrivateAttr, model_validator

from mjsim.errors import UsageError
from mjsim.sentences import number_of
from mjsim.views import Viewed
from mjsim.world.files import BUILT, Source, check_picture
from mjsim.world.files import read_asset as read_named_asset
from mjsim.world.ground import Model, Name, fault
from mjsim.world.items.mechanisms import Mechanism
from mjsim.world.items.people import Person
from mjsim.world.items.plants import Plant
from mjsim.world.items.radio import Radio
from mjsim.world.items.robots import Robot
from mjsim.world.items.room_lamps import Brightness, Lamp
from mjsim.world.items.running import Run
from mjsim.world.items.structure import Ceiling, Floor, Wall
from mjsim.world.items.things import Beacon, Obstacle
from mjsim.world.items.underfoot import floors
from mjsim.world.items.world_consistency import NAMED, misfits

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class World(Viewed, Model):
    """A room or a floor of a building, its robots, and the settings of a run."""

    mjsim: Literal[1] = 1
    """Version of this format."""
    name: Name = "world"
    """Name of the world, and of the folder of its runs."""
    walls: Annotated[tuple[Wall, ...], Field(strict=False)] = ()
    """Polylines of straight walls."""
    obstacles: Annotated[tuple[Obstacle, ...], Field(strict=False)] = ()
    """Objects on the floor, including ramps and steps: boxes, spheres, ramps, models."""
    beacons: Annotated[tuple[Beacon, ...], Field(strict=False)] = ()
    """Pictures and markers on the walls, and reflectors."""
    floor: Floor = Floor()
    """The level floor."""
    ceiling: Ceiling | None = None
    """A ceiling; default: none."""
    light: Brightness = 1.0
    """Ambient light; with 0 only the lamps give light."""
    lamps: Annotated[tuple[Lamp, ...], Field(strict=False, max_length=100)] = ()
    """Lamps, in addition to the ambient light."""
    shading: Literal["plain", "baked"] = "plain"
    """How cameras show light: plain is even light without shadows, baked has soft shadows and reflected light, computed
    once for everything that stands still and kept in a cache."""
    style: Literal["plain", "office", "home", "museum", "warehouse"] = "plain"
    """How rooms look: all but plain have small things on walls, ceilings, doors and furniture, and textures where the
    world names none; for cameras alone: nothing collides with it, and lidars do not see it."""
    robots: Annotated[tuple[Robot, ...], Field(strict=False, max_length=32)] = ()
    """Wheeled robots, up to 32."""
    mechanisms: Annotated[tuple[Mechanism, ...], Field(strict=False, max_length=100)] = ()
    """Bodies connected by joints, with or without closed loops, and their actuators."""
    people: Annotated[tuple[Person, ...], Field(strict=False, max_length=32)] = ()
    """People in the world, standing or seated."""
    radio: Radio = Radio()
    """Radio communication between robots."""
    plants: Annotated[tuple[Plant, ...], Field(strict=False, max_length=100)] = ()
    """Plants for `mjsim lab`."""
    run: Run = Run()
    """Settings for `mjsim run`."""
    _source: Source = PrivateAttr(default=BUILT)

    def __repr__(self) -> str:
        """Return its name, and how many things it has."""
        kinds = {"walls": "wall", "obstacles": "obstacle", "beacons": "beacon", "robots": "robot"}
        kinds |= {"mechanisms": "mechanism", "people": "person"}
        counts = [number_of(len(items), noun) for key, noun in kinds.items() if (items := getattr(self, key))]
        return f"<World '{self.name}': {', '.join(counts) or 'empty'}>"

    __str__ = __repr__

    @property
    def source(self) -> Source:
        """Position in the file."""
        return self._source

    def read_asset(self, name: str) -> bytes:
        """Return a file that this world names; raises ValueError if it does not exist."""
        return read_named_asset(name, self._source)

    def read_picture(self, name: str) -> "NDArray[np.uint8]":
        """Return the RGB pixels of a picture that this world names, shape (height, width, 3).

        Raises:
            UsageError: It does not exist, or cannot be read.
        """
        from mjsim.models import read_picture

        try:
            # A world built in Python was not checked with its file, and files change.
            check_picture(name, self._source)
            return read_picture(self.read_asset(name))
        except ValueError as error:
            raise UsageError(str(error)) from None

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        for message, path in misfits(self.model_dump(include={*NAMED, "run"})):
            raise fault(message, *path)
        things = {thing.name: thing for thing in self.obstacles}
        below = floors(self.obstacles) if self.people else ()
        for person in self.people:
            if person.seat is not None:
                person.sit_on(things[person.seat])
            else:
                person.stand_among(below)
        return self
