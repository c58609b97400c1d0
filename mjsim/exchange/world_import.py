"""Inputs and results of the importers of worlds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mjsim.world import Use

PRESET = "pioneer3dx"
SCENE_SUFFIXES = (".world", ".sdf", ".model", ".xml", ".mjcf", ".wbt")
"""File suffixes of scenes of other simulators."""


@dataclass(frozen=True, slots=True)
class Brought:
    """An imported world."""

    text: str
    """Text of the world file."""
    report: Sequence[str] = ()
    """Lines for the user: what was done and what was left out."""
    files: Mapping[str, bytes] = field(default_factory=dict)
    """Files that the world names, by their paths beside it."""


@dataclass(frozen=True, slots=True)
class Reading:
    """Options for reading a drawing; None means that the drawing decides."""

    scale: float | None = None
    """Metres per unit of the drawing."""
    thickness: float | None = None
    """Thickness of walls [m]."""
    layers: Sequence[str] = ()
    """Layers that contain walls."""
    furniture: bool = True
    """Whether to turn furniture into obstacles."""
    rows: bool = False
    """Whether a table of MATLAB that fits both ways has an item in each row."""
    models: Sequence[Path] = ()
    """Folders with folders of models that a scene may name."""
    folder: str | None = None
    """Name of the folder for the models of a scene, beside the world."""


@dataclass(frozen=True, slots=True)
class Newcomer:
    """The robot to add to an imported world; the arguments of `with_robot`."""

    preset: str = PRESET
    lidar: str | None = None
    estimator: "Use | None" = None
    folder: Path | None = None
    """Folder of the new world; the preset may be a file in it."""
    is_usual: bool = False
    """Whether it is entirely the default: then a world without space for it gets no robot."""
