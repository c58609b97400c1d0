"""A model as one rigid body: its mass and its shape with all joints at rest."""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from mjsim.geometry import Array
from mjsim.models.model_reader import seen_and_touched
from mjsim.models.rigid import AtRest, at_rest, weighed


@dataclass(frozen=True, slots=True, eq=False)
class WholeModel:
    """A model without internal motion, in the units and the frame of its file."""

    rest: AtRest
    """Its joints at rest."""
    mass: float
    """[kg]; 0 if the file gives none."""
    center: Array
    """Centre of mass, shape (3,)."""
    inertia: Array
    """Inertia about the centre of mass, axes of the file, shape (3, 3)."""
    corners: Array
    """Corners of the convex hull of all collision shapes, shape (n, 3)."""


def whole_of(model: mujoco.MjModel, *, urdf: bool) -> WholeModel:
    """Return a model as one rigid body, each joint at its reference or at the nearest limit."""
    rest = at_rest(model)
    mass, center, inertia = weighed(model, rest.data, range(model.nbody))
    _, touched = seen_and_touched(model, urdf=urdf)
    points = np.concatenate([rest.points(number) for number in np.flatnonzero(touched).tolist()])
    # Flat point sets have no 3-D hull unless their points are jittered.
    corners = points[ConvexHull(points, qhull_options="QJ").vertices] if len(points) > 4 else points
    return WholeModel(rest=rest, mass=mass, center=center, inertia=inertia, corners=corners)
