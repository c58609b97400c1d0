"""Obstacles, static or movable.

The frame of an obstacle has its origin at the center of its underside, x along its length. A static one is part of
the world; a movable one is a body `obstacle/NAME` with a free joint of the same name, and one with a scripted path a
body of that name on slides. Geoms carry the name too, numbered where there are several:
`obstacle/NAME/1`. Models are always bodies, as their parts may have joints.

Movers: obstacles with a scripted motion.

A mover is a body on two slides, `obstacle/NAME/x` and `obstacle/NAME/y`, whose values are the displacement from its
start. The simulation sets them; contacts use its true velocity, and no object slows it down.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import mujoco
import numpy as np

from mjsim.compile.models import LoadedFile, add_model, original, try_alone
from mjsim.compile.room import COLLISION, VISUAL, Covers, surface_of
from mjsim.compile.textures import add_matte, color_of, tint_of
from mjsim.errors import WorldError
from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world import (
    BoxObstacle,
    CylinderObstacle,
    Fault,
    ModelObstacle,
    Obstacle,
    RampObstacle,
    SphereObstacle,
    StepsObstacle,
    World,
    item_names,
    problems_at,
)

TORSIONAL_FRICTION, ROLLING_FRICTION = 0.005, 0.002
"""Torsional and rolling friction of a movable object, as lengths [m]."""


@dataclass(frozen=True, slots=True)
class ObstacleBody:
    """Parent of the geoms of an obstacle: the world body at a pose, or a separate body."""

    body: mujoco.MjsBody
    frame: mujoco.MjsFrame | None
    """Frame of the obstacle in the world; None if the body exists already."""
    solid: dict[str, Any]
    """Common keys of all geoms that collide."""

    def add_geom(self, **keys: Any) -> mujoco.MjsGeom:
        """Add a geom whose pose is in the frame of the obstacle."""
        geom = self.body.add_geom(**{"material": "matte"} | keys)
        if self.frame is not None:
            geom.set_frame(self.frame)
        return geom


def add_obstacles(spec: mujoco.MjSpec, world: World) -> None:
    """Add the obstacles of a world at their initial poses.

    Raises:
        WorldError: MuJoCo cannot read the files of some models; each is listed where it is first named.
    """
    originals: dict[str, LoadedFile] = {}
    covers = Covers(spec, "obstacle")
    tried: set[object] = set()
    faults: dict[str, Fault] = {}
    for index, (obstacle, name) in enumerate(zip(world.obstacles, item_names(world.obstacles), strict=True)):
        stand = _stand(spec, obstacle, f"obstacle/{name}")
        if not isinstance(obstacle, ModelObstacle):
            geoms = _add_shape(spec, stand, obstacle, f"obstacle/{name}")
            if not isinstance(obstacle, SphereObstacle) and obstacle.texture is not None:
                material = covers.material(obstacle.texture, world.read_picture(obstacle.texture))
                mesh = covers.mesh(surface_of(spec, geoms), obstacle.tile)
                _cover(stand, geoms, f"obstacle/{name}/seen", material=material, mesh=mesh, tint=tint_of(obstacle))
            continue
        try:
            _check_alone(obstacle, tried)
            if obstacle.model not in originals:
                originals[obstacle.model] = original(spec, obstacle.shape, key=f"obstacle:model{len(originals) + 1}")
            file = originals[obstacle.model]
            add_model(spec, stand.body, obstacle, file, name=f"obstacle/{name}", solid=stand.solid)
        except ValueError as error:
            faults.setdefault(obstacle.model, (("obstacles", index, "model"), partial(str, error)))
    if faults:
        raise WorldError(problems_at(world.source.written, world.source.file, faults.values()))


def _check_alone(obstacle: ModelObstacle, tried: set[object]) -> None:
    """Raise ValueError when a model fails as the only object in a world; `tried` holds those that passed."""
    key = obstacle.model, obstacle.scale, obstacle.mass, obstacle.movable, obstacle.path is not None
    if key not in tried:
        spec = mujoco.MjSpec()
        add_matte(spec, "matte")
        stand = _stand(spec, obstacle, "obstacle/1")
        file = original(spec, obstacle.shape, key="obstacle:model1")
        add_model(spec, stand.body, obstacle, file, name="obstacle/1", solid=stand.solid)
        try_alone(spec, obstacle.model)
        tried.add(key)


def check_things(world: World) -> None:
    """Raise WorldError when MuJoCo cannot read the files of a world's objects."""
    if any(isinstance(obstacle, ModelObstacle) for obstacle in world.obstacles):
        add_obstacles(mujoco.MjSpec(), world)


def _stand(spec: mujoco.MjSpec, obstacle: Obstacle, name: str) -> ObstacleBody:
    turn = math.radians(obstacle.heading_deg) / 2
    place = {"pos": [*obstacle.at, obstacle.origin_height], "quat": [math.cos(turn), 0.0, 0.0, math.sin(turn)]}
    if obstacle.path is not None:
        body = spec.worldbody.add_body(name=name, **place)
        add_slides(body, name, heading=2 * turn)
        return ObstacleBody(body, None, {})
    if not obstacle.movable:
        if isinstance(obstacle, ModelObstacle):
            return ObstacleBody(spec.worldbody.add_body(name=name, **place), None, {})
        return ObstacleBody(spec.worldbody, spec.worldbody.add_frame(**place), {})
    body = spec.worldbody.add_body(name=name, **place)
    body.add_freejoint(name=name)
    # Friction is the larger of the two surfaces' unless one has priority: this one's must count.
    solid = {"priority": 1, "condim": 6, "friction": [obstacle.friction, TORSIONAL_FRICTION, ROLLING_FRICTION]}
    return ObstacleBody(body, None, solid)


def _cover(
    stand: ObstacleBody, geoms: Sequence[mujoco.MjsGeom], name: str, *, material: str, mesh: str, tint: str
) -> None:
    """Show a mesh with a texture in place of geoms, which remain for contacts and lidars."""
    for geom in geoms:
        geom.group = COLLISION
    looks: dict[str, Any] = {"material": material, "rgba": color_of(tint), "meshname": mesh, "mass": 0.0}
    unfelt = {"group": VISUAL, "contype": 0, "conaffinity": 0}
    stand.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, **looks, **unfelt)


def _add_shape(spec: mujoco.MjSpec, stand: ObstacleBody, obstacle: Obstacle, name: str) -> Sequence[mujoco.MjsGeom]:
    keys: dict[str, Any] = {"rgba": color_of(obstacle.color), **stand.solid}
    if obstacle.movable:
        keys["mass"] = obstacle.mass
    geoms = mujoco.mjtGeom
    match obstacle:
        case BoxObstacle(box=(length, width, height)):
            half = [length / 2, width / 2, height / 2]
            return [stand.add_geom(name=name, type=geoms.mjGEOM_BOX, size=half, pos=[0.0, 0.0, height / 2], **keys)]
        case CylinderObstacle(cylinder=(radius, height)):
            size, pos = [radius, height / 2, 0.0], [0.0, 0.0, height / 2]
            return [stand.add_geom(name=name, type=geoms.mjGEOM_CYLINDER, size=size, pos=pos, **keys)]
        case SphereObstacle(sphere=radius):
            size, pos = [radius, 0.0, 0.0], [0.0, 0.0, radius]
            return [stand.add_geom(name=name, type=geoms.mjGEOM_SPHERE, size=size, pos=pos, **keys)]
        case RampObstacle(ramp=(length, width, rise)):
            _add_wedge(spec, name, length=length, width=width, rise=rise)
            return [stand.add_geom(name=name, type=geoms.mjGEOM_MESH, meshname=name, **keys)]
        case StepsObstacle():
            return [stand.add_geom(type=geoms.mjGEOM_BOX, **step, **keys) for step in _steps(obstacle, name)]
    raise AssertionError(Sentence("no shape for {obstacle}", obstacle))


def _steps(obstacle: StepsObstacle, name: str) -> Iterator[dict[str, Any]]:
    """Yield the name, half sizes and position of the box of each step."""
    (length, width, rise), count = obstacle.steps, obstacle.count
    for step in range(1, count + 1):
        half = [length / count / 2, width / 2, rise * step / count / 2]
        pos = [length * ((step - 0.5) / count - 0.5), 0.0, half[2]]
        yield {"name": f"{name}/{step}", "size": half, "pos": pos}


def _add_wedge(spec: mujoco.MjSpec, name: str, *, length: float, width: float, rise: float) -> None:
    """Add the mesh of a ramp that rises along x from zero, in the frame of the obstacle."""
    x, y = length / 2, width / 2
    foot, top = [(-x, -y, 0.0), (-x, y, 0.0)], [(x, -y, rise), (x, y, rise)]
    under = [(x, -y, 0.0), (x, y, 0.0)]
    faces = [
        [foot[0], top[0], top[1], foot[1]],
        [foot[0], foot[1], under[1], under[0]],
        [under[0], under[1], top[1], top[0]],
        [foot[0], under[0], top[0]],
        [foot[1], top[1], under[1]],
    ]
    add_flat_mesh(spec, name, [np.array(face) for face in faces])


def add_flat_mesh(spec: mujoco.MjSpec, name: str, faces: Sequence[Array]) -> None:
    """Add a mesh of flat convex faces: corners counter-clockwise seen from outside, shape (n, 3) each [m]."""
    mesh = spec.add_mesh(name=name)
    normals, triangles, first = [], [], 0
    for corners in faces:
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normals.append(np.tile(normal / np.linalg.norm(normal), (len(corners), 1)))
        triangles += [(first, first + i, first + i + 1) for i in range(1, len(corners) - 1)]
        first += len(corners)
    mesh.uservert = np.concatenate(faces).ravel()
    mesh.usernormal = np.concatenate(normals).ravel()
    mesh.userface = np.array(triangles, dtype=np.int32).ravel()


MOVER_INERTIA = 1e4
"""Inertia of a mover along its slides [kg]: no contact within one physics step can slow it down."""


def add_slides(body: mujoco.MjsBody, name: str, *, heading: float) -> None:
    """Add slides in the plane, with a practically infinite inertia, to a body with a heading in the world [rad]."""
    c, s = math.cos(heading), math.sin(heading)
    # An axis is given in the frame of its body.
    for axis, direction in (("x", [c, -s, 0.0]), ("y", [s, c, 0.0])):
        body.add_joint(name=f"{name}/{axis}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=direction, armature=MOVER_INERTIA)
