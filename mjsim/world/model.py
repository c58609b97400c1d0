"""The world: everything that a world file says, checked and frozen."""

from typing import Annotated, Literal

from pydantic import Field, PrivateAttr

from mjsim.world.base import Model, Name
from mjsim.world.robots import Robot
from mjsim.world.running import Run
from mjsim.world.source import BUILT, Source
from mjsim.world.source import read_asset as read_named_asset
from mjsim.world.structure import Beacon, Floor, Obstacle, Wall


class World(Model):
    """A room or a floor of a building, its robots, and how a run drives them."""

    mjsim: Literal[1] = 1
    """Version of this format."""
    name: Name = "world"
    walls: Annotated[tuple[Wall, ...], Field(strict=False)] = ()
    obstacles: Annotated[tuple[Obstacle, ...], Field(strict=False)] = ()
    beacons: Annotated[tuple[Beacon, ...], Field(strict=False)] = ()
    floor: Floor = Floor()
    robots: Annotated[tuple[Robot, ...], Field(strict=False)] = ()
    run: Run = Run()
    _source: Source = PrivateAttr(default=BUILT)

    @property
    def source(self) -> Source:
        """Where it was written."""
        return self._source

    def read_asset(self, name: str) -> bytes:
        """Return a file that this world names; raises ValueError when there is none."""
        return read_named_asset(name, self._source)
