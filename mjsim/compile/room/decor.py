"""Details of a world's style: what `mjsim.style` puts on walls, ceilings, doors and furniture, as visual meshes.

Each room has one mesh. Nothing in it collides, and lidars pass through it: only cameras see it.
"""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.compile.room.walls import VISUAL
from mjsim.compile.textures import add_material
from mjsim.style import PartAtlas, Quad, StyleName, ceiling_lamps, leaf_faces, read_atlas, thing_faces, wall_faces
from mjsim.world import THICKNESS, World, item_names, leaves

ATLAS, LAMPS = "style/atlas", "style/lamps"
"""Materials of small things, and of lamps."""
WALL_DETAILS = "wall/style:"
"""Prefix of the names of meshes of details on walls."""
LAMP_EMISSION = 1.0
"""Light that a lamp emits, added to what falls on it."""


class Decor:
    """Adds the small things of a style to a scene."""

    def __init__(self, spec: mujoco.MjSpec, world: World, style: StyleName) -> None:
        """Add the atlas to the scene."""
        self._spec, self._world, self._style = spec, world, style
        self._atlas: PartAtlas = read_atlas()
        add_material(spec, ATLAS, self._atlas.picture)

    def add_to_things(self) -> None:
        """Add details on furniture, before furniture is merged by room."""
        names = item_names(self._world.obstacles)
        found = thing_faces(self._world, self._style, self._atlas)
        for obstacle, name, faces in zip(self._world.obstacles, names, found, strict=True):
            if not faces:
                continue
            body = self._spec.body(f"obstacle/{name}")
            geom = self._add(self._spec.worldbody if body is None else body, f"obstacle/{name}/style", faces)
            if body is None:
                turn = math.radians(obstacle.heading_deg) / 2
                geom.pos = [*obstacle.at, obstacle.elevation]
                geom.quat = [math.cos(turn), 0.0, 0.0, math.sin(turn)]

    def add_to_rooms(self, ceiling: float | None) -> None:
        """Add details on walls and doors, and lamps under a ceiling of a given height [m]."""
        for room, faces in wall_faces(self._world, self._style, self._atlas).items():
            if faces:
                self._add(self._spec.worldbody, f"{WALL_DETAILS}{room + 1}", faces)
        for leaf in leaves(self._world):
            faces = leaf_faces(leaf, THICKNESS, self._style)
            self._add(self._spec.body(f"door/{leaf.name}"), f"door/{leaf.name}/style", faces)
        if ceiling is None:
            return
        lamps = [face for faces in ceiling_lamps(self._world, self._style, ceiling).values() for face in faces]
        if lamps:
            add_material(self._spec, LAMPS, self._atlas.picture, emission=LAMP_EMISSION)
            self._add(self._spec.worldbody, "ceiling/style", lamps).material = LAMPS

    def _add(self, body: mujoco.MjsBody, name: str, faces: Sequence[Quad]) -> mujoco.MjsGeom:
        """Add faces to a body as one visual mesh."""
        corners = np.array([face.corners for face in faces])
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        mesh = self._spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert = corners.ravel()
        mesh.usernormal = np.repeat(normals, 4, axis=0).ravel()
        mesh.usertexcoord = self._atlas.texcoords(faces).ravel()
        first = 4 * np.arange(len(faces), dtype=np.int32)[:, None, None]
        mesh.userface = (first + np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)).ravel()
        return body.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            material=ATLAS,
            rgba=[1.0, 1.0, 1.0, 1.0],
            mass=0.0,
            group=VISUAL,
            contype=0,
            conaffinity=0,
        )
