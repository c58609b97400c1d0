"""Things on a side of a room: each where nothing else is."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from mjsim.style.atlas import PartAtlas
from mjsim.style.atlas_faces import Quad, Range
from mjsim.style.recipes import WallItem
from mjsim.style.sides import Rectangle, Side

MAX_TRIES = 6
"""Places that are tried for a thing."""
MIN_GAP = 0.12
"""Least distance between things, and from corners and frames [m]."""
FRAME_WIDTH = 0.07
"""Width of the frames of doors and windows [m]."""


class Hanging:
    """Fills a side with things, at random; the random numbers depend only on the position of the side."""

    def __init__(self, side: Side, atlas: PartAtlas, counts: Counter[str]) -> None:
        """Start with what the side has: openings, beacons and what stands before it.

        Args:
            side: The side.
            atlas: The parts.
            counts: How many things of each kind the room has; changed.
        """
        self._side, self._atlas, self._counts = side, atlas, counts
        self.rng = np.random.default_rng(side.seed)
        frame = FRAME_WIDTH + MIN_GAP
        self._taken: list[Rectangle] = [*side.beacons, *side.things]
        for hole in side.holes:
            low, high = hole.opening.sill, hole.opening.head
            self._taken.append((hole.left - frame, hole.right + frame, low - frame, high + frame))

    def fill(self, hung: Sequence[WallItem]) -> Iterator[Quad]:
        """Yield things of all kinds, as many as fit and belong on a side of this length."""
        for thing in hung:
            count = int(self.rng.poisson(self._side.length / thing.every))
            for _ in range(min(count, thing.most) if self._side.length >= thing.least else 0):
                yield from self._hang(thing)

    def put(self, left: float, thing: WallItem) -> Iterator[Quad]:
        """Yield a thing at a place, unless something is there."""
        place = (left, left + thing.width, thing.low, thing.low + thing.height)
        if self._counts[thing.kind] < thing.most and self._free(place):
            self._taken.append(place)
            self._counts[thing.kind] += 1
            part = self.one_of(thing.kind)
            yield from self._side.frame.block(place[:2], (0.0, thing.depth), place[2:], part, thing.side)

    def run(self, across: Range, up: Range, depth: float, part: str) -> Iterator[Quad]:
        """Yield a band along the wall, unless something is there."""
        if self._free((*across, *up)):
            self._taken.append((*across, *up))
            yield from self._side.frame.band(across, up, depth, part, length=1.0)

    def one_of(self, kind: str) -> str:
        """Return a random variant of a kind."""
        variants = [name for name in self._atlas.parts if name.partition("/")[0] == kind]
        return variants[self.rng.integers(len(variants))]

    def _hang(self, thing: WallItem) -> Iterator[Quad]:
        room = self._side.length - thing.width - 2 * MIN_GAP
        if room < 0.0 or thing.low + thing.height > self._side.height:
            return
        for left in self.rng.uniform(MIN_GAP, MIN_GAP + room, MAX_TRIES).tolist():
            faces = list(self.put(left, thing))
            if faces:
                yield from faces
                return

    def _free(self, place: Rectangle) -> bool:
        left, right, low, high = place
        inside = left >= 0.0 and right <= self._side.length and high <= self._side.height
        return inside and not any(
            overlap((left - MIN_GAP / 2, right + MIN_GAP / 2, low, high), other) for other in self._taken
        )


def overlap(one: Rectangle, other: Rectangle) -> bool:
    """Return whether two rectangles of a side overlap."""
    return one[0] < other[1] and other[0] < one[1] and one[2] < other[3] and other[2] < one[3]
