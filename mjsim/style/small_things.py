"""Small things on furniture: books on shelves, screens and papers on tables, cartons for brown boxes."""

import itertools
import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from mjsim.geometry import Array
from mjsim.style.atlas_faces import Axes, Quad
from mjsim.style.recipes import RoomStyle
from mjsim.world import BoxObstacle, ModelObstacle, Obstacle, World, hung, stays, wall_polygons

MAX_BOARD_THICKNESS = 0.05
"""Greatest thickness of a shelf's board or a table's top [m]."""
MIN_AREA = 0.1
"""Minimum area of one [m^2]."""
TABLE_AREA, TABLE_HIGH, TABLE_LOW = 0.4, 0.85, 0.6
"""Minimum area [m^2] and heights [m] of the top of a table."""
MAX_CARTON_SIDE, MIN_CARTON_HEIGHT = 0.55, 0.25
"""Longest side of a carton, and minimum height of a box that is made of cartons [m]."""
MAX_CARTONS = 50
"""Largest number of cartons side by side and above each other; on larger boxes they are larger."""
BEACON_CLEARANCE, ROBOT_CLEARANCE = 0.1, 1.0
"""Distance before a beacon that walls may not cover, and between a table and a robot behind it [m]."""
SIGHT_DISTANCE, EYE_HEIGHT = 8.0, 1.0
"""Distance from which a screen must not hide a beacon [m], and eye height for testing whether walls hide it anyway
[m]."""


@dataclass(frozen=True, slots=True)
class _Board:
    """A thin level part of a piece of furniture, as a box in its frame [m]."""

    left: float
    right: float
    rear: float
    front: float
    low: float
    high: float


class Things:
    """Puts small things on the furniture of a world."""

    def __init__(self, world: World, style: RoomStyle, parts: list[str]) -> None:
        """Store the world and find its beacons.

        Args:
            world: The world.
            style: The style.
            parts: Names of the parts of the atlas.
        """
        self._style = style
        self._variants: defaultdict[str, list[str]] = defaultdict(list)
        for name in parts:
            self._variants[name.partition("/")[0]].append(name)
        self._walls = shapely.STRtree([shapely.Polygon(outline) for outline in wall_polygons(world, height=EYE_HEIGHT)])
        self._places = np.array([obstacle.at for obstacle in world.obstacles]).reshape(-1, 2)
        self._beacons = np.array([[item.place.x, item.place.y] for item in hung(world) if item.fixed]).reshape(-1, 2)

    def of(self, obstacle: Obstacle) -> list[Quad]:
        """Return the faces on an obstacle, in its own frame."""
        if not stays(obstacle):
            return []
        place = np.round(np.array([*obstacle.at, obstacle.elevation]) * 100).astype(int).tolist()
        rng = np.random.default_rng([abs(value) * 2 + (value < 0) for value in place])
        if isinstance(obstacle, BoxObstacle):
            boxes = self._style.hazard and _brown(obstacle.color) and obstacle.box[2] > MIN_CARTON_HEIGHT
            return list(self._cartons(obstacle, rng)) if boxes and obstacle.texture is None else []
        if isinstance(obstacle, ModelObstacle):
            boards = _boards(obstacle)
            return [*self._rows(boards, rng), *self._on_table(obstacle, boards, rng)]
        return []

    def _one_of(self, kind: str, rng: np.random.Generator) -> str:
        variants = self._variants[kind]
        return variants[rng.integers(len(variants))]

    def _rows(self, boards: list[_Board], rng: np.random.Generator) -> Iterator[Quad]:
        """Yield rows of books on boards that have another one above."""
        shelves = [board for board in boards if board.high < 2.2]
        for below, above in itertools.pairwise(shelves):
            gap = above.low - below.high
            if not 0.2 < gap < 0.7 or abs(below.left - above.left) > 0.05:
                continue
            frame = Axes.facing(0.0, 0.0, 0.0, math.pi / 2)
            # The frame of a thing that faces its y axis has its right towards -x.
            at, end = -below.right + 0.015, -below.left - 0.015
            while at < end - 0.12:
                width = min(rng.uniform(0.2, 0.6), end - at)
                height = min(rng.uniform(0.62, 0.92) * gap, 0.34)
                kind = self._style.shelf[rng.integers(len(self._style.shelf))]
                depth = (below.rear + 0.02, below.front - rng.uniform(0.03, 0.08))
                for face in frame.block((at, at + width), depth, (below.high, below.high + height), "x", "paper"):
                    yield _with_spines(face, self._one_of(kind, rng), width / 0.8)
                at += width + (rng.uniform(0.04, 0.22) if rng.random() < 0.35 else 0.004)

    def _on_table(self, obstacle: Obstacle, boards: list[_Board], rng: np.random.Generator) -> Iterator[Quad]:
        """Yield a screen with a keyboard, and papers, on the top of a table."""
        if not boards or not _is_table(top := boards[-1]):
            return
        frame = Axes.facing(0.0, 0.0, top.high, self._front(obstacle))
        across, deep = (top.right - top.left) / 2, (top.front - top.rear) / 2
        if not self._hides(obstacle):
            yield from self._screen(frame, deep, rng)
        for _ in range(int(rng.integers(2, 5))):
            x, y = rng.uniform(-across + 0.15, across - 0.35), rng.uniform(-deep + 0.2, deep - 0.05)
            yield frame.lying(
                (x, x + 0.21), (y - 0.15, y + 0.147), 0.002 + 0.001 * rng.random(), self._one_of("sheet", rng)
            )

    def _front(self, table: Obstacle) -> float:
        """Return the direction in a table's frame from which it is used: where the nearest other thing stands [rad]."""
        offsets = self._places - table.at
        away = np.linalg.norm(offsets, axis=1)
        heading = math.radians(table.heading_deg)
        others = np.flatnonzero(away > 0.0)
        if not len(others):
            return math.pi / 2
        x, y = offsets[others[away[others].argmin()]]
        return math.copysign(math.pi / 2, math.cos(heading) * y - math.sin(heading) * x)

    def _screen(self, frame: Axes, deep: float, rng: np.random.Generator) -> Iterator[Quad]:
        at, rear = rng.uniform(-0.35, 0.05), -deep + 0.12
        yield from frame.block((at, at + 0.54), (rear, rear + 0.03), (0.1, 0.44), self._one_of("screen", rng), "dark")
        yield from Axes(frame.origin, -frame.right, -frame.out).block(
            (-at - 0.54, -at), (-rear - 0.03, -rear), (0.1, 0.44), "dark", "dark"
        )
        yield from frame.block((at + 0.24, at + 0.3), (rear - 0.01, rear + 0.01), (0.0, 0.12), "dark", "dark")
        yield frame.lying((at + 0.16, at + 0.38), (rear - 0.08, rear + 0.1), 0.006, "dark")
        yield from frame.block((at + 0.06, at + 0.48), (rear + 0.24, rear + 0.38), (0.0, 0.02), "dark", "dark")
        yield frame.lying((at + 0.06, at + 0.48), (rear + 0.24, rear + 0.38), 0.022, "keyboard/1")

    def _hides(self, obstacle: Obstacle) -> bool:
        """Return whether something on an obstacle could hide a beacon."""
        place = np.array(obstacle.at)
        offsets = place - self._beacons
        distances = np.linalg.norm(offsets, axis=1)
        if not distances.all():
            return True
        chosen = distances < SIGHT_DISTANCE
        near, away = self._beacons[chosen], offsets[chosen] / distances[chosen, None]
        if not len(near):
            return False
        # Walls hide it from there, or leave no space for a robot to look past the screen.
        lines = shapely.linestrings(np.stack([near + away * BEACON_CLEARANCE, place + away * ROBOT_CLEARANCE], axis=1))
        blocked = self._walls.query(lines, predicate="intersects")[0]
        return len(np.unique(blocked)) < len(near)

    def _cartons(self, box: BoxObstacle, rng: np.random.Generator) -> Iterator[Quad]:
        """Yield the sides of cartons on the four sides of a box."""
        length, width, height = box.box
        for heading, deep, wide in (
            (0.0, length, width),
            (math.pi / 2, width, length),
            (math.pi, length, width),
            (-math.pi / 2, width, length),
        ):
            frame = Axes.facing(0.0, 0.0, 0.0, heading)
            columns, rows = (min(math.ceil(size / MAX_CARTON_SIDE), MAX_CARTONS) for size in (wide, height))
            for column in range(columns):
                for row in range(rows):
                    a, low = -wide / 2 + column * wide / columns, row * height / rows
                    across, up = (a, a + wide / columns), (low, low + height / rows)
                    yield frame.sheet(across, up, deep / 2 + 0.002, self._one_of("carton", rng))


def _with_spines(face: Quad, row: str, share: float) -> Quad:
    """Return the front of a row of books with spines; all other faces as they are."""
    return Quad(face.corners, row, share) if face.part == "x" else face


def _boards(obstacle: ModelObstacle) -> list[_Board]:
    """Return the level boards of a piece of furniture, from below, in its frame."""
    scale, found = obstacle.scale, []
    for hull, low, high in obstacle.shape.columns:
        corners: Array = hull * scale
        (left, rear), (right, front) = corners.min(axis=0), corners.max(axis=0)
        if (high - low) * scale <= MAX_BOARD_THICKNESS and (right - left) * (front - rear) >= MIN_AREA:
            found.append(_Board(float(left), float(right), float(rear), float(front), low * scale, high * scale))
    return sorted(found, key=lambda board: board.low)


def _is_table(top: _Board) -> bool:
    area = (top.right - top.left) * (top.front - top.rear)
    return area >= TABLE_AREA and TABLE_LOW < top.high < TABLE_HIGH


def _brown(color: str) -> bool:
    """Return whether a colour is that of cardboard."""
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return red > green > blue and red - blue > 40
