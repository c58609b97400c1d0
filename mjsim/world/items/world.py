"""The world: everything that a world file says, checked and frozen."""

from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, model_validator

from mjsim.world.files import BUILT, Source
from mjsim.world.files import read_asset as read_named_asset
from mjsim.world.ground import Model, Name, fault
from mjsim.world.items.fit import NAMED, misfits
from mjsim.world.items.light import Brightness, Lamp
from mjsim.world.items.mechanisms import Mechanism
from mjsim.world.items.people import Person
from mjsim.world.items.plants import Plant
from mjsim.world.items.radio import Radio
from mjsim.world.items.robots import Robot
from mjsim.world.items.running import Run
from mjsim.world.items.structure import Ceiling, Floor, Wall
from mjsim.world.items.things import Beacon, Obstacle
from mjsim.world.items.underfoot import floors


class World(Model):
    """A room or a floor of a building, its robots, and how a run drives them."""

    mjsim: Literal[1] = 1
    """Version of this format."""
    name: Name = "world"
    """Names the folder of its runs."""
    walls: Annotated[tuple[Wall, ...], Field(strict=False)] = ()
    """Runs of straight walls."""
    obstacles: Annotated[tuple[Obstacle, ...], Field(strict=False)] = ()
    """What stands on the floor, and what is driven on: boxes, balls, ramps, models."""
    beacons: Annotated[tuple[Beacon, ...], Field(strict=False)] = ()
    """Pictures and markers on the walls, and reflectors."""
    floor: Floor = Floor()
    """The level floor under everything."""
    ceiling: Ceiling | None = None
    """A ceiling, when the room has one."""
    light: Brightness = 1.0
    """General light from everywhere; 0 leaves the lamps alone."""
    lamps: Annotated[tuple[Lamp, ...], Field(strict=False, max_length=100)] = ()
    """Lamps, besides the general light."""
    robots: Annotated[tuple[Robot, ...], Field(strict=False, max_length=32)] = ()
    """Wheeled robots, up to 32."""
    mechanisms: Annotated[tuple[Mechanism, ...], Field(strict=False, max_length=100)] = ()
    """Bodies that joints hold, with loops or without, and what moves them."""
    people: Annotated[tuple[Person, ...], Field(strict=False, max_length=32)] = ()
    """People who stand in it."""
    radio: Radio = Radio()
    """How robots hear each other."""
    plants: Annotated[tuple[Plant, ...], Field(strict=False, max_length=100)] = ()
    """What `mjsim lab` looks at."""
    run: Run = Run()
    """How `mjsim run` drives this world."""
    _source: Source = PrivateAttr(default=BUILT)

    @property
    def source(self) -> Source:
        """Where it was written."""
        return self._source

    def read_asset(self, name: str) -> bytes:
        """Return a file that this world names; raises ValueError when there is none."""
        return read_named_asset(name, self._source)

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
