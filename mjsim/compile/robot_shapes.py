"""Bodies of robots: collision shape, mass and visual shape."""

import math
from typing import Any

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DARK, MATERIAL, PALE, SEEN, make_decor
from mjsim.compile.textures import color_of
from mjsim.geometry import Array
from mjsim.world import BoxBody, CylinderBody, Part, PolygonBody, rims

PlainBody = CylinderBody | BoxBody | PolygonBody
"""Shapes that this module builds."""
TOUCHED = 3
"""Geom group of geoms that collide and are hit by rays, but are invisible."""
BUMPER_TRAVEL = 0.001
"""A bumper detects objects at this distance before it is pressed, so that contact does not flicker [m]."""
BUMPER_FRICTION = 0.3
"""Friction of a plastic bumper on a wall."""


def add_body(
    spec: mujoco.MjSpec, base: mujoco.MjsBody, body: PlainBody, *, name: str, low: float, mass: float, balanced: bool
) -> None:
    """Add the collision shape, its mass, and the visual shape.

    Args:
        spec: The scene, for the meshes of polygons.
        base: Body of the robot; its origin is on the floor.
        body: The shape.
        name: Name of the first geom; others have a number appended.
        low: Height of its lower face above the floor [m].
        mass: Mass of all but the wheels [kg].
        balanced: Whether the mass lies above the origin, as for robots on two wheels, or at the shape's center.
    """
    _set_mass(base, body, low=low, mass=mass, balanced=balanced)
    half = (body.height - low) / 2
    x, y = body.at if isinstance(body, BoxBody) else (0.0, 0.0)
    for number, shape in enumerate(_shapes(spec, body, name, half), start=1):
        base.add_geom(
            name=name if number == 1 else f"{name}-{number}",
            pos=[x, y, low + half],
            group=TOUCHED if body.look else SEEN,
            priority=1,
            friction=[BUMPER_FRICTION, 0.005, 0.0001],
            # Twice as stiff as MuJoCo's default: at 2 m/s it yields by a centimetre.
            solref=[0.01, 1.0],
            margin=BUMPER_TRAVEL,
            gap=BUMPER_TRAVEL,
            material=MATERIAL,
            rgba=color_of(body.color),
            **shape,
        )
    for part in body.look:
        _add_part(base, part)
    if not body.look:
        _add_heading_mark(base, body)


def _shapes(spec: mujoco.MjSpec, body: PlainBody, name: str, half: float) -> list[dict[str, Any]]:
    """Return the geoms of a body: type and size of each."""
    if isinstance(body, CylinderBody):
        return [{"type": mujoco.mjtGeom.mjGEOM_CYLINDER, "size": [body.radius, half, 0.0]}]
    if isinstance(body, BoxBody):
        length, width, _ = body.box
        return [{"type": mujoco.mjtGeom.mjGEOM_BOX, "size": [length / 2, width / 2, half]}]
    return [_prism(spec, piece, half, f"{name}-{k}") for k, piece in enumerate(_convex_pieces(body), start=1)]


def _convex_pieces(body: PolygonBody) -> list[Array]:
    """Return the convex pieces of a polygon, counter-clockwise, shapes (n, 2) [m]."""
    import shapely

    outline = body.outline()
    edge = np.roll(outline, -1, axis=0) - outline
    after = np.roll(edge, -1, axis=0)
    if (edge[:, 0] * after[:, 1] - edge[:, 1] * after[:, 0] >= 0.0).all():
        return [outline]
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.Polygon(outline)))
    return [np.array(triangle.exterior.coords[:-1]) for triangle in triangles]


def _prism(spec: mujoco.MjSpec, outline: Array, half: float, name: str) -> dict[str, Any]:
    """Add the mesh of an upright prism; return the keys of its geom."""
    corners = [[x, y, z] for z in (-half, half) for x, y in outline.tolist()]
    mesh = spec.add_mesh(name=name, uservert=np.array(corners).ravel(), maxhullvert=-1)
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    return {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": name}


def _set_mass(base: mujoco.MjsBody, body: PlainBody, *, low: float, mass: float, balanced: bool) -> None:
    """Set the mass of the base, even over the outline, and low, like batteries, unless the body sets the height."""
    half = (body.height - low) / 2
    (x, y), (xx, yy, xy) = _outline_moments(body)
    # The centre of mass is as high as a quarter of the body's width, and never above its middle.
    middle = min(low + half, max(low, math.sqrt(xx + yy) / math.sqrt(2.0)))
    upright = min(half, middle) ** 2 / 3
    if isinstance(body, BoxBody) and body.middle is not None:
        # A balancing body states the position of its mass.
        middle, upright = body.middle, half**2 / 3
    base.explicitinertial = True
    base.mass, base.ipos = mass, [0.0 if balanced else x, 0.0 if balanced else y, middle]
    if xy == 0.0:
        base.inertia = [mass * (yy + upright), mass * (xx + upright), mass * (xx + yy)]
    else:
        base.fullinertia = [mass * (yy + upright), mass * (xx + upright), mass * (xx + yy), -mass * xy, 0.0, 0.0]


def _outline_moments(body: PlainBody) -> tuple[tuple[float, float], tuple[float, float, float]]:
    """Return the centroid of a body's outline [m], and the means of x^2, y^2 and x y about it [m^2]."""
    if isinstance(body, CylinderBody):
        return (0.0, 0.0), (body.radius**2 / 4, body.radius**2 / 4, 0.0)
    if isinstance(body, BoxBody):
        return (body.at[0], body.at[1]), (body.box[0] ** 2 / 12, body.box[1] ** 2 / 12, 0.0)
    # Triangles from the origin to each side: the mean of a product over one is a sum over its corners.
    start = body.outline()
    end = np.roll(start, -1, axis=0)
    doubled = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    middle = doubled @ (start + end) / (3.0 * doubled.sum())
    both = start + end
    moments = np.einsum("i,ij,ik->jk", doubled, start, start) + np.einsum("i,ij,ik->jk", doubled, end, end)
    moments = (moments + np.einsum("i,ij,ik->jk", doubled, both, both)) / (12.0 * doubled.sum())
    xx, yy, xy = (moments - np.outer(middle, middle))[[0, 1, 0], [0, 1, 1]].tolist()
    return (float(middle[0]), float(middle[1])), (xx, yy, xy if abs(xy) > 1e-9 else 0.0)


def _add_part(base: mujoco.MjsBody, part: Part) -> None:
    """Add a purely visual part, which cameras see."""
    if part.box is not None:
        kind, size = mujoco.mjtGeom.mjGEOM_BOX, [part.box[0] / 2, part.box[1] / 2, part.box[2] / 2]
    elif part.cylinder is not None:
        kind, size = mujoco.mjtGeom.mjGEOM_CYLINDER, [part.cylinder[0], part.cylinder[1] / 2, 0.0]
    else:
        assert part.sphere is not None
        kind, size = mujoco.mjtGeom.mjGEOM_SPHERE, [part.sphere, 0.0, 0.0]
    geom = base.add_geom(type=kind, size=size, pos=part.at, quat=_orientation(part))
    make_decor(geom, color_of(part.color))


def _orientation(part: Part) -> Array:
    """Return the quaternion of yaw, then pitch (up), then roll."""
    turned = np.array([1.0, 0.0, 0.0, 0.0])
    axes = ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
    for axis, angle in zip(axes, (part.yaw_deg, part.pitch_deg, part.roll_deg), strict=True):
        step, before = np.zeros(4), turned.copy()
        mujoco.mju_axisAngle2Quat(step, np.array(axis), math.radians(angle))
        mujoco.mju_mulQuat(turned, before, step)
    return turned


def _add_heading_mark(base: mujoco.MjsBody, body: PlainBody) -> None:
    """Add a bar on top from the center to the rim, which shows the heading of the robot."""
    red, green, blue, _ = color_of(body.color)
    bright = 0.3 * red + 0.59 * green + 0.11 * blue > 0.6
    ahead, left = rims(body, np.array([0.0, math.pi / 2])).tolist()
    mark = base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[ahead / 2, 0.0, body.height],
        size=[ahead * 0.46, min(ahead, left) * 0.11, 0.004],
    )
    make_decor(mark, DARK if bright else PALE)
