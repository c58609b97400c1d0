"""Contents of files of other simulators in any format: solids with their poses, lamps, robots."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem
from mjsim.models import MeshPart, SceneJoint

Kind = Literal["box", "cylinder", "sphere", "mesh"]
MAX_COORDINATE = 1e4
"""Maximum absolute value of a coordinate or a size [m]."""
MAX_TILT_SINE = 1e-3
"""Maximum sine of the tilt of an upright solid."""
MAX_MASS = 1e5
"""Maximum mass of a movable thing; heavier ones are taken as static [kg]."""
ON_ROBOTS = "only robots have sensors"
"""Why a sensor of a scene is left out."""
MAX_SOLIDS = 20_000
MAX_NAME = 100
"""Maximum length of a name in the report."""


@dataclass(frozen=True, slots=True)
class SceneTexture:
    """A picture on a solid."""

    name: str
    """Name of its file, or of one that comes with mjsim."""
    data: bytes | None = None
    """A PNG; None if it comes with mjsim."""
    tile: float = 0.0
    """Size of one repetition; 0 for the height of its solid [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class SceneSkin:
    """A mesh that cameras see in place of the solids of its thing, and that nothing touches."""

    look: MeshPart
    scale: Array
    """Along x, y and z, shape (3,)."""
    pose: Array
    """Pose in the frame of its thing or of the world, shape (4, 4) [m]."""

    def moved(self, outer_from_inner: Array) -> "SceneSkin":
        """Return the same in an outer frame."""
        return replace(self, pose=outer_from_inner @ self.pose)


@dataclass(frozen=True, slots=True, eq=False)
class SceneSolid:
    """A solid with its pose."""

    kind: Kind
    size: tuple[float, ...]
    """Full sizes x, y, z of a box; radius and height of a cylinder; radius of a sphere; () for a mesh [m]."""
    pose: Array
    """Pose in the frame of its thing or of the world, shape (4, 4) [m]."""
    color: str | None = None
    """'#rrggbb'."""
    vertices: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """Vertices of a mesh, in its own frame, shape (n, 3) [m]."""
    faces: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    """Vertices of its triangles, shape (m, 3)."""
    texture: SceneTexture | None = None

    def __post_init__(self) -> None:
        """Check the numbers before geometry is computed with them.

        Raises:
            ValueError: A number is not finite, or too large.
        """
        numbers = np.concatenate([self.size, self.pose.ravel(), self.vertices.ravel()])
        if not (np.abs(numbers) <= MAX_COORDINATE).all():
            raise ValueError(
                f"a {self.kind} has a number that is not finite, or above {MAX_COORDINATE:g} m; correct it"
            )
        if any(value <= 0.0 for value in self.size):
            raise ValueError(f"a {self.kind} has a size of {min(self.size):g} m; it must be above 0")

    @property
    def is_upright(self) -> bool:
        """Whether its z axis is vertical."""
        return bool(np.hypot(self.pose[0, 2], self.pose[1, 2]) <= MAX_TILT_SINE)

    @property
    def heading(self) -> float:
        """Direction of its x axis from above [rad]."""
        return math.atan2(self.pose[1, 0], self.pose[0, 0])

    @property
    def half(self) -> Array:
        """Half of its sizes along its own axes, shape (3,) [m]; of a mesh about its middle."""
        if self.kind == "mesh":
            return np.asarray(np.ptp(self.vertices, axis=0) / 2)
        if self.kind == "box":
            return np.array(self.size) / 2
        radius = self.size[0]
        return np.array([radius, radius, radius if self.kind == "sphere" else self.size[1] / 2])

    def corners(self) -> Array:
        """Return points whose convex hull contains it, shape (n, 3) [m]."""
        signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
        local = self.vertices if self.kind == "mesh" else signs * self.half
        return np.asarray(local @ self.pose[:3, :3].T + self.pose[:3, 3])

    def moved(self, outer_from_inner: Array) -> "SceneSolid":
        """Return the same in an outer frame."""
        return replace(self, pose=outer_from_inner @ self.pose)


@dataclass(frozen=True, slots=True, eq=False)
class ScenePart:
    """A part moved by joints: the leaf of a door, a drawer."""

    name: str
    joints: Sequence[SceneJoint]
    solids: Sequence[SceneSolid]
    """Poses in the world frame, with the joints at their reference."""
    mass: float
    """Without its own parts [kg]."""
    parts: Sequence["ScenePart"] = ()
    """Parts that further joints move on it."""
    skins: Sequence[SceneSkin] = ()

    def __post_init__(self) -> None:
        """Check the axes of its joints.

        Raises:
            ValueError: A number is not finite, or too large.
        """
        numbers = np.array([(joint.anchor, joint.axis) for joint in self.joints])
        if not (np.abs(numbers) <= MAX_COORDINATE).all():
            raise ValueError(
                f"a joint of '{self.name}' is not finite, or more than {MAX_COORDINATE:g} m away; correct it"
            )

    def all_solids(self) -> list[SceneSolid]:
        """Return its solids and those of its parts."""
        return [*self.solids, *(solid for part in self.parts for solid in part.all_solids())]

    def moved(self, outer_from_inner: Array) -> "ScenePart":
        """Return the same in an outer frame."""
        return replace(
            self,
            joints=[joint.moved(outer_from_inner) for joint in self.joints],
            solids=[solid.moved(outer_from_inner) for solid in self.solids],
            parts=[part.moved(outer_from_inner) for part in self.parts],
            skins=[skin.moved(outer_from_inner) for skin in self.skins],
        )


@dataclass(frozen=True, slots=True, eq=False)
class SceneThing:
    """A model of a scene: static or movable, rigid except for its parts."""

    name: str
    solids: Sequence[SceneSolid]
    """Poses in the world frame."""
    pose: Array
    """Pose of its own frame in the world, shape (4, 4) [m]."""
    mass: float | None = None
    """Mass of a movable thing, without its parts [kg]; None for a static one."""
    parts: Sequence[ScenePart] = ()
    """What joints move on it."""
    skins: Sequence[SceneSkin] = ()

    def moved(self, outer_from_inner: Array) -> "SceneThing":
        """Return the same in an outer frame."""
        return replace(
            self,
            solids=[solid.moved(outer_from_inner) for solid in self.solids],
            pose=outer_from_inner @ self.pose,
            parts=[part.moved(outer_from_inner) for part in self.parts],
            skins=[skin.moved(outer_from_inner) for skin in self.skins],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """A lamp."""

    name: str
    place: Array
    """Shape (3,) [m]."""
    color: str
    reach: float
    """[m]"""


@dataclass(slots=True)
class Scene:
    """The contents of a file."""

    things: list[SceneThing] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    starts: list[tuple[float, float, float]] = field(default_factory=list)
    """Poses of its robots: x, y [m], heading [rad]."""
    items: list[FileItem] = field(default_factory=list)
    """Notes on its parts."""
    _count: int = 0
    """Number of its solids."""

    def tell(self, fate: Fate, kind: str, name: str = "", why: str = "") -> None:
        """Note what became of a part of the file, on one line."""
        self.items.append(FileItem(fate, kind, " ".join(name.split())[:MAX_NAME], " ".join(why.split())))

    def add(self, thing: SceneThing) -> None:
        """Add a thing.

        Raises:
            ValueError: There are too many solids.
        """
        self.things.append(thing)
        self._count += len(thing.solids) + sum(len(part.all_solids()) for part in thing.parts)
        if self._count > MAX_SOLIDS:
            raise ValueError(f"the scene has more than {MAX_SOLIDS} solids; make it simpler")
