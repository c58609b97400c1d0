"""A model as one rigid body: what it weighs and what it fills while all its joints are at rest."""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from mjsim.geometry import Array
from mjsim.models.reader import seen_and_touched
from mjsim.models.rigid import AtRest, at_rest, weighed


@dataclass(frozen=True, slots=True, eq=False)
class WholeModel:
    """A model that does not move in itself, in units and in the frame of its file."""

    rest: AtRest
    """Its joints as they stay."""
    mass: float
    """[kg]; 0 where the file gives none."""
    center: Array
    """Of mass, shape (3,)."""
    inertia: Array
    """About that centre, axes of the file, shape (3, 3)."""
    corners: Array
    """Of the convex hull of all that can be touched, shape (n, 3)."""


def whole_of(model: mujoco.MjModel, *, urdf: bool) -> WholeModel:
    """Return a model as one rigid body, each joint at its reference or at the limit next to that."""
    rest = at_rest(model)
    mass, center, inertia = weighed(model, rest.data, range(model.nbody))
    _, touched = seen_and_touched(model, urdf=urdf)
    points = np.concatenate([rest.points(number) for number in np.flatnonzero(touched).tolist()])
    # Sheets have no hull in space unless their points are joggled.
    corners = points[ConvexHull(points, qhull_options="QJ").vertices] if len(points) > 4 else points
    return WholeModel(rest=rest, mass=mass, center=center, inertia=inertia, corners=corners)
