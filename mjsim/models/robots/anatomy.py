"""Contents of a robot's file as plain numbers: rigid parts, joints, shapes, and positions of sensors."""

from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models.model_reader import seen_and_touched
from mjsim.models.rigid import SINGLE, AtRest, at_rest
from mjsim.models.robots.robot_files import RobotFiles

MAX_CORNERS = 4000
"""Maximum number of corners of a shape that are examined."""


@dataclass(frozen=True, slots=True, eq=False)
class FileJoint:
    """A joint with one degree of freedom, at rest, in the file frame."""

    name: str
    part: int
    """Index of the part that it moves in `Anatomy.parts`."""
    slides: bool
    at: Array
    """A point on its axis, shape (3,) [m]."""
    axis: Array
    """Unit vector, shape (3,)."""
    range: tuple[float, float] | None
    """Limits [rad] or [m]; None without limits."""
    driven: bool
    """Whether the file gives it a motor."""
    speed: float | None = None
    """Maximum speed in the file [rad/s] or [m/s]; None if not stated."""
    placeholder: bool = False
    """Whether the file states limits of 0 to 0."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A geom at rest, in the file frame."""

    part: int
    names: tuple[str, ...]
    """Names of the geom, its mesh and its body."""
    points: Array
    """Points whose convex hull is the geom, or a subset of them, shape (n, 3) [m]."""
    seen: bool
    touched: bool


@dataclass(frozen=True, slots=True, eq=False)
class FilePart:
    """A rigid part."""

    name: str
    parent: int
    """Index of the part that carries it; -1 for the base, which comes first."""
    names: tuple[str, ...]
    """Names of its bodies."""
    mass: float
    """[kg]"""
    center: Array
    """Centre of mass, file frame, shape (3,) [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class FileFrame:
    """A body, a site or a camera at rest, in the file frame."""

    name: str
    kind: str
    """body, site or camera."""
    part: int
    at: Array
    """Position, shape (3,) [m]."""
    axes: Array
    """Axes as columns, shape (3, 3); a camera looks along -z."""
    fov: float = 0.0
    """Vertical field of view of a camera [deg]."""
    size: tuple[int, int] = (0, 0)
    """Size of a camera's pictures, width and height [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class Anatomy:
    """Contents of a robot's file as plain numbers."""

    parts: tuple[FilePart, ...]
    joints: tuple[FileJoint, ...]
    shapes: tuple[Shape, ...]
    places: tuple[FileFrame, ...]
    loose: tuple[str, ...]
    """Names of ball joints, which are treated as rigid."""

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return sum(part.mass for part in self.parts)

    @property
    def center(self) -> Array:
        """Total centre of mass, file frame, shape (3,) [m]."""
        total = max(self.mass, 1e-12)
        return np.asarray(sum(part.mass * part.center for part in self.parts) / total, dtype=float)


def anatomy_of(robot: RobotFiles) -> Anatomy:
    """Return the contents of a robot's file."""
    rest = at_rest(robot.model)
    numbers = {body: index for index, part in enumerate(rest.parts) for body in part.bodies}
    roots = {part.root: index for index, part in enumerate(rest.parts)}
    parts = tuple(
        FilePart(
            name=rest.model.body(part.root).name if part.root else "base",
            parent=roots.get(part.parent, -1),
            names=tuple(rest.model.body(body).name for body in part.bodies),
            mass=part.mass,
            center=part.center,
        )
        for part in rest.parts
    )
    joints = tuple(
        _joint(rest, number, index, robot) for index, part in enumerate(rest.parts) for number in part.joints
    )
    ball = int(mujoco.mjtJoint.mjJNT_BALL)
    loose = tuple(rest.model.joint(n).name for n in range(rest.model.njnt) if int(rest.model.jnt_type[n]) == ball)
    return Anatomy(parts, joints, _shapes(rest, numbers, urdf=robot.files.urdf), _places(rest, numbers), loose)


def _joint(rest: AtRest, number: int, part: int, robot: RobotFiles) -> FileJoint:
    model = rest.model
    at, axis = rest.axis(number)
    name = model.joint(number).name
    low, high = model.jnt_range[number].tolist()
    limits = (low, high) if model.jnt_limited[number] else None
    return FileJoint(
        name,
        part,
        int(model.jnt_type[number]) != SINGLE[0],
        at,
        axis,
        limits,
        name in robot.driven,
        robot.speeds.get(name),
        name in robot.unlimited,
    )


def _shapes(rest: AtRest, numbers: dict[int, int], *, urdf: bool) -> tuple[Shape, ...]:
    model = rest.model
    seen, touched = seen_and_touched(model, urdf=urdf)
    found = []
    for number in np.flatnonzero(seen | touched).tolist():
        body = int(model.geom_bodyid[number])
        points = rest.points(number)
        names = [model.geom(number).name, model.body(body).name]
        if model.geom_type[number] == mujoco.mjtGeom.mjGEOM_MESH:
            names.append(model.mesh(int(model.geom_dataid[number])).name)
        fewer = points[:: max(1, len(points) // MAX_CORNERS)]
        # The outermost corners determine the size.
        ends = points[np.concatenate([points.argmin(axis=0), points.argmax(axis=0)])]
        whole = np.concatenate([fewer, ends])
        found.append(Shape(numbers[body], tuple(names), whole, bool(seen[number]), bool(touched[number])))
    return tuple(found)


def _places(rest: AtRest, numbers: dict[int, int]) -> tuple[FileFrame, ...]:
    model, data = rest.model, rest.data
    mujoco.mj_camlight(model, data)
    found = [
        FileFrame(model.body(n).name, "body", numbers[n], data.xpos[n].copy(), data.xmat[n].reshape(3, 3).copy())
        for n in range(1, model.nbody)
    ]
    for n in range(model.nsite):
        part = numbers[int(model.site_bodyid[n])]
        found.append(
            FileFrame(
                model.site(n).name, "site", part, data.site_xpos[n].copy(), data.site_xmat[n].reshape(3, 3).copy()
            )
        )
    for n in range(model.ncam):
        part, axes = numbers[int(model.cam_bodyid[n])], data.cam_xmat[n].reshape(3, 3).copy()
        width, height = model.cam_resolution[n].tolist()
        at = data.cam_xpos[n].copy()
        found.append(
            FileFrame(model.camera(n).name, "camera", part, at, axes, float(model.cam_fovy[n]), (width, height))
        )
    return tuple(found)
