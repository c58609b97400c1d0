"""A model as an object in a world: its files, and the space that it occupies."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from mjsim.geometry import Array
from mjsim.models.model_sources import ModelFiles, Read, gather_model
from mjsim.sentences import Sentence

if TYPE_CHECKING:
    import mujoco

    from mjsim.models.rigid_whole import WholeModel


@dataclass(frozen=True, eq=False)
class ModelShape:
    """A model in the units and the frame of its file."""

    files: ModelFiles = field(repr=False)
    model: "mujoco.MjModel" = field(repr=False)
    """The compiled model."""
    columns: tuple[tuple[Array, float, float], ...] = field(repr=False)
    """For each solid part its hull from above, counter-clockwise, shape (n, 2), and its lower and upper z."""

    @property
    def low(self) -> float:
        """Height of its lowest point."""
        return min(low for _, low, _ in self.columns)

    @property
    def high(self) -> float:
        """Height of its highest point."""
        return max(high for _, _, high in self.columns)

    @cached_property
    def hinges(self) -> tuple[str, ...]:
        """Names of its hinge joints."""
        import mujoco

        hinge = int(mujoco.mjtJoint.mjJNT_HINGE)
        return tuple(self.model.joint(n).name for n in range(self.model.njnt) if self.model.jnt_type[n] == hinge)

    @cached_property
    def whole(self) -> "WholeModel":
        """The model as one rigid body."""
        from mjsim.models.rigid_whole import whole_of

        return whole_of(self.model, urdf=self.files.urdf)

    @cached_property
    def outline(self) -> Array:
        """Outline from above, counter-clockwise, shape (n, 2); for disconnected parts, the hull."""
        import shapely

        whole: Any = shapely.union_all([shapely.Polygon(hull) for hull, _, _ in self.columns])
        if whole.geom_type != "Polygon":
            whole = whole.convex_hull
        return np.asarray(shapely.get_coordinates(shapely.orient_polygons(whole).exterior)[:-1], dtype=float)


def read_model(path: str, read: Read) -> ModelShape:
    """Return the model of a file.

    Args:
        path: An MJCF or URDF file, as accepted by `read`.
        read: Returns a file by its path relative to the folder of the world.

    Raises:
        ValueError: It cannot be read, or exceeds the limits of an object; the message names the file.
    """
    # MuJoCo is loaded only for worlds with models, so that others are checked and reported on without it.
    from mjsim.models.model_reader import compiled, solid_parts

    files = gather_model(path, read)
    model = compiled(files)
    try:
        parts = solid_parts(model, urdf=files.urdf)
    except ValueError as error:
        raise ValueError(Sentence("'{path}' cannot be placed in a room: {error}", path, error)) from None
    if not parts:
        raise ValueError(Sentence("'{path}' has no shape; give it geoms", path))
    columns = [(_hull(part[:, :2]), float(np.min(part[:, 2])), float(np.max(part[:, 2]))) for part in parts]
    return ModelShape(files, model, tuple(columns))


def _hull(points: Array) -> Array:
    """Return the convex hull of points in the plane, counter-clockwise, shape (n, 2)."""
    import shapely

    hull: Any = shapely.MultiPoint(points).convex_hull
    if hull.geom_type != "Polygon":
        # A vertical sheet is a line from above.
        hull = hull.buffer(1e-3)
    return np.asarray(shapely.get_coordinates(shapely.orient_polygons(hull))[:-1], dtype=float)
