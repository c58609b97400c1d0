"""People as MuJoCo bodies: `PERSON/SEGMENT`, held in their posture, with a camera in each eye.

A person is static: robots that run into one stop.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DARK, MATERIAL, SEEN, make_decor
from mjsim.compile.room import TILES, Finishes
from mjsim.compile.textures import color_of
from mjsim.geometry import Array
from mjsim.mechanics import inverted
from mjsim.models import pose_keys
from mjsim.world import Person, World

if TYPE_CHECKING:  # not needed for worlds without people
    from mjsim.people import Mesh, Segment

EYE_FOV = 60.0
"""Vertical field of view of the image from an eye [deg]."""
EYE_SIZE = (640, 480)
"""Size of that image [px]."""
EYE_RADIUS = 0.012
"""Radius of the visual shape of an eye [m]."""
EYE_AXES = (0.0, -1.0, 0.0, 0.0, 0.0, 1.0)
"""Right and up axis of a camera that looks along x."""
CLOTH = "fabric"
"""Texture of clothes in worlds with a style."""
FRICTION = (0.5, 0.005, 0.0001)
"""Friction of clothes; assumed."""
TOOLS = ("thumb_tip", "fingertip", "grip")
"""Landmarks of a hand that are sites in the scene."""


def add_people(spec: mujoco.MjSpec, world: World) -> None:
    """Add all people in their initial posture."""
    if not world.people:
        return
    from mjsim.posture import poses_of

    finishes = None if world.style == "plain" else Finishes(spec, world)
    for person in world.people:
        _add_person(spec, person, poses_of(world, person), finishes)


def _add_person(spec: mujoco.MjSpec, person: Person, poses: Mapping[str, Array], finishes: Finishes | None) -> None:
    figure, skins = person.figure, person.skins
    bodies: dict[str, mujoco.MjsBody] = {}
    for name, segment in figure.segments.items():
        parent, within = spec.worldbody, poses[name]
        if segment.parent is not None:
            parent, within = bodies[segment.parent], inverted(poses[segment.parent]) @ within
        body = parent.add_body(name=f"{person.name}/{name}", **pose_keys(within))
        _set_mass(body, segment)
        for number, mesh in enumerate(skins[name], start=1):
            named = f"{person.name}/{name}" + (f"-{number}" if number > 1 else "")
            geom = _add_skin(spec, body, mesh, named, color_of(person.color_of(name)))
            if finishes is not None and person.is_dressed(name):
                finish = finishes.made_of(CLOTH, geom.rgba.tolist())
                geom.material, geom.rgba = finish.name, finish.tint
                # Mapped along and around the limb: no seam, and little distortion.
                x, y, z = mesh.vertices.T
                spec.mesh(named).usertexcoord = (np.stack([x + y, z], axis=1) / TILES[CLOTH]).ravel()
        bodies[name] = body
    _add_face(spec, bodies["head"], person)
    for side in ("left", "right"):
        for tool in TOOLS:
            mark = figure.landmarks[f"{side}_{tool}"]
            bodies[mark.segment].add_site(name=f"{person.name}/{side}_{tool}", pos=mark.at, size=[0.005] * 3, group=5)


def _set_mass(body: mujoco.MjsBody, segment: "Segment") -> None:
    solid = segment.solid
    body.explicitinertial, body.mass, body.ipos = True, solid.mass, solid.center
    # Along the axes of the segment: batched ray casting excludes only bodies whose principal axes are not rotated.
    body.inertia = solid.inertia[:3]


def _add_skin(spec: mujoco.MjSpec, body: mujoco.MjsBody, mesh: "Mesh", name: str, rgba: list[float]) -> mujoco.MjsGeom:
    _add_mesh(spec, mesh, name)
    return body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        group=SEEN,
        mass=0.0,
        material=MATERIAL,
        rgba=rgba,
        friction=list(FRICTION),
    )


def _add_mesh(spec: mujoco.MjSpec, mesh: "Mesh", name: str) -> None:
    added = spec.add_mesh(name=name)
    added.uservert = mesh.vertices.ravel()
    added.userface = mesh.faces.ravel()
    added.smoothnormal = True


def _add_face(spec: mujoco.MjSpec, head: mujoco.MjsBody, person: Person) -> None:
    """Add purely visual hair and eyes, and the cameras of the eyes."""
    from mjsim.people import hair

    _add_mesh(spec, hair(person.figure), f"{person.name}/hair")
    made = head.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"{person.name}/hair")
    make_decor(made, color_of(person.colors.hair))
    for side in ("left", "right"):
        pupil: Array = np.array(person.figure.landmarks[f"{side}_eye"].at)
        ball = head.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[EYE_RADIUS, 0.0, 0.0], pos=pupil - (EYE_RADIUS, 0.0, 0.0)
        )
        make_decor(ball, DARK)
        head.add_camera(
            name=f"{person.name}/{side}_eye", pos=pupil, xyaxes=EYE_AXES, fovy=EYE_FOV, resolution=list(EYE_SIZE)
        )
