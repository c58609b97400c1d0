"""Recipes for the rooms of each style."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

StyleName = Literal["office", "home", "museum", "warehouse"]


@dataclass(frozen=True, slots=True)
class Surfaces:
    """Textures for surfaces without one in the world, with the size of a tile [m]."""

    wall: tuple[str, float]
    floor: tuple[str, float]
    ceiling: tuple[str, float]


SURFACES: Mapping[StyleName, Surfaces] = {
    "office": Surfaces(
        ("materials/plaster_white.jpg", 2.0), ("materials/carpet.jpg", 1.5), ("materials/ceiling_panels.jpg", 1.2)
    ),
    "home": Surfaces(
        ("materials/wallpaper.jpg", 0.9), ("materials/boards.jpg", 2.0), ("materials/plaster_white.jpg", 2.0)
    ),
    "museum": Surfaces(
        ("materials/plaster.jpg", 2.0), ("materials/terrazzo.jpg", 1.0), ("materials/plaster_white.jpg", 2.0)
    ),
    "warehouse": Surfaces(
        ("materials/concrete.jpg", 2.5), ("materials/concrete.jpg", 3.0), ("materials/metal.jpg", 2.0)
    ),
}


@dataclass(frozen=True, slots=True)
class WallItem:
    """A thing on a wall."""

    kind: str
    """Kind of part of the atlas."""
    width: float
    """[m]"""
    height: float
    """[m]"""
    low: float
    """Height of its lower edge [m]."""
    every: float
    """Average length of wall per thing [m]."""
    depth: float = 0.012
    """[m]"""
    side: str = "gray"
    """Part of the atlas on its sides."""
    most: int = 20
    """Largest number of them in a room."""
    least: float = 0.0
    """Minimum length of a wall that has one [m]."""


@dataclass(frozen=True, slots=True)
class RoomStyle:
    """The small things of a style."""

    skirting: str
    leaf: str
    frame: str
    """Part of the atlas on the frames of doors and windows."""
    view: str
    cover: str
    """What covers windows: blinds from above, or curtains at both sides."""
    shelf: tuple[str, ...]
    """Things on shelves."""
    hung: tuple[WallItem, ...]
    """Things on walls, the most important first."""
    duct: bool = False
    """Whether cable ducts run along walls."""
    lamp: tuple[float, float] = (0.6, 2.4)
    """Side of a lamp in the ceiling and distance between lamps [m]; 0.6 fits the panels of a ceiling."""
    hazard: bool = False
    """Whether a striped band protects the feet of walls, and cartons are on brown boxes."""


_SOCKETS = (
    WallItem("sockets", 0.16, 0.08, 0.26, 3.5, 0.01, "white"),
    WallItem("socket", 0.08, 0.08, 0.26, 4.0, 0.01, "white"),
)
_EXTINGUISHER = WallItem("extinguisher", 0.26, 0.56, 0.7, 8.0, 0.05, "red", 6, 5.5)

STYLES: Mapping[StyleName, RoomStyle] = {
    "office": RoomStyle(
        "skirting_white",
        "leaf_office",
        "gray",
        "view_town",
        "blinds",
        ("folders", "books"),
        (
            WallItem("noted", 1.2, 0.9, 1.05, 5.0, 0.02, "wood"),
            WallItem("written", 1.5, 0.95, 1.0, 7.0, 0.03, "steel"),
            _EXTINGUISHER,
            WallItem("fire", 0.3, 0.23, 1.5, 9.0, 0.004, "gray", 3, 5.5),
            WallItem("clock", 0.3, 0.3, 1.95, 8.0, 0.03, "dark", 1),
            WallItem("sheet", 0.21, 0.297, 1.3, 1.6, 0.002, "paper"),
            WallItem("vent", 0.4, 0.24, 2.1, 8.0, 0.02, "white", 2),
            WallItem("sheet", 0.21, 0.297, 0.95, 3.0, 0.002, "paper"),
            *_SOCKETS,
        ),
        duct=True,
    ),
    "home": RoomStyle(
        "skirting_wood",
        "leaf_home",
        "white",
        "view_park",
        "curtain",
        ("books",),
        (
            WallItem("painting", 0.8, 0.6, 1.2, 3.0, 0.03, "wood"),
            WallItem("clock", 0.3, 0.3, 1.8, 8.0, 0.03, "dark", 1),
            WallItem("painting", 0.4, 0.3, 1.35, 2.5, 0.02, "wood"),
            WallItem("vent", 0.25, 0.15, 2.1, 9.0, 0.01, "white", 1),
            *_SOCKETS,
        ),
        lamp=(0.3, 3.6),
    ),
    "museum": RoomStyle(
        "skirting_dark",
        "leaf_office",
        "dark",
        "view_park",
        "blinds",
        ("books",),
        (
            WallItem("panel", 0.7, 0.95, 1.0, 5.0, 0.02, "paper"),
            _EXTINGUISHER,
            WallItem("label", 0.2, 0.15, 1.15, 1.6, 0.006, "white"),
            WallItem("vent", 0.5, 0.3, 2.1, 10.0, 0.02, "white"),
            WallItem("sockets", 0.16, 0.08, 0.26, 4.0, 0.01, "white"),
            WallItem("label", 0.2, 0.15, 0.9, 3.0, 0.006, "white"),
        ),
    ),
    "warehouse": RoomStyle(
        "skirting_dark",
        "leaf_office",
        "yellow",
        "view_town",
        "blinds",
        ("folders",),
        (
            WallItem("safety", 1.0, 0.76, 1.6, 5.0, 0.01),
            _EXTINGUISHER,
            WallItem("danger", 0.6, 0.46, 1.5, 5.0, 0.01),
            WallItem("vent", 0.8, 0.5, 2.6, 6.0, 0.04),
            WallItem("fire", 0.5, 0.38, 1.3, 6.0, 0.01),
            WallItem("noted", 1.2, 0.9, 1.1, 16.0, 0.02, "wood"),
            WallItem("sockets", 0.2, 0.1, 1.1, 6.0, 0.05, "gray"),
        ),
        hazard=True,
    ),
}
