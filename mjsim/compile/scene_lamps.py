"""Light: ambient light, lamps, and surfaces subdivided finely enough for lamps.

MuJoCo lights vertices, interpolates over the faces between them, and draws at most eight lights at a time. Faces are
therefore subdivided in a world with lamps, and in no other.
"""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile.textures import color_of
from mjsim.geometry import Array
from mjsim.world import Lamp, World, item_names

EVEN, TOWARDS_VIEWER = (0.71, 0.71, 0.72), 0.08
"""Ambient light, red, green, blue; and light added on faces perpendicular to the line of sight."""
DIRECTED = (("light/key", (0.80, 0.10, 0.50), 0.18), ("light/fill", (-0.45, 0.75, 0.50), 0.26))
"""Name, direction of origin, and strength: walls that face east, north, west and south get 0.86, 0.92, 0.83 and 0.71
of full light, the floor 0.93; faces perpendicular to the line of sight get 0.08 more."""
PICTURES = "beacon/"
"""Prefixes of the names of materials with pictures."""
LEVEL = "light"
"""Name of the custom number in the scene for the ambient light."""
GIVEN_BACK = 0.25
"""Reflectance of a picture; it is emissive, so that its colours are the same at any angle and only a little brighter
where a lamp of high quality adds to them."""
MEAN_LIGHT = 0.92
"""Light averaged over faces of all directions, in full ambient light."""
LAMP_OFFSET = 0.2
"""A lamp lights in proportion to 1 / (0.2 + 0.2 d^2) at d metres: the factor is 1 at 2 m, and 5 at most."""
AMBIENT_SHARE = 0.2
"""Proportion of a lamp's light that is ambient, as reflected by walls."""
MAX_LIGHTS = 8
"""Largest number of lights in OpenGL."""
MAX_FACE_EDGE, MAX_TRIANGLES = 0.4, 60_000
"""Longest edge of a face lit by lamps [m], and the approximate limit of triangles above which it is coarser."""
PICTURE_PARTS, SUBDIVISIONS = 6, 8
"""Subdivisions per side of a picture, and of the face of a box."""


def add_general_light(spec: mujoco.MjSpec, level: float, lower: Array, upper: Array) -> None:
    """Add even light and two lamps at infinity: brightness depends on a face's direction; white does not saturate."""
    spec.add_numeric(name=LEVEL, data=[level], size=1)
    headlight = spec.visual.headlight
    headlight.ambient = [level * value for value in EVEN]
    headlight.diffuse = [level * TOWARDS_VIEWER] * 3
    headlight.specular = [0.0, 0.0, 0.0]
    # MuJoCo makes unlit surfaces glow; a light that exists but is dark prevents this.
    headlight.active = 1
    middle, height = (lower + upper) / 2, float(np.linalg.norm(upper - lower)) / 2
    for name, towards, strength in DIRECTED:
        direction = np.array(towards) / np.linalg.norm(towards)
        spec.worldbody.add_light(
            name=name,
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            pos=middle + direction * (height + 0.04),
            dir=-direction,
            diffuse=[level * strength] * 3,
            specular=[0.0] * 3,
            ambient=[0.0] * 3,
            castshadow=name == "light/key",
            active=level > 0.0,
        )


def lamp_names(world: World) -> list[str]:
    """Return the name of each lamp in the scene, `lamp/NAME`."""
    return [f"lamp/{name}" for name in item_names(world.lamps)]


def general_light(model: mujoco.MjModel) -> float:
    """Return the ambient light of a compiled scene; 1 in a scene not from mjsim."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, LEVEL)
    return float(model.numeric_data[model.numeric_adr[index]]) if index >= 0 else 1.0


def lamp_lights(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return the indices of the lamps among the lights of a compiled scene."""
    return np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_SPOT)


def lamp_brightness(model: mujoco.MjModel, lamps: NDArray[np.intp]) -> Array:
    """Return the current brightness of lamps, red, green and blue, 0 where they are off, shape (n, 3).

    Args:
        model: The compiled scene.
        lamps: Indices of lights, as from `lamp_lights`.
    """
    return np.asarray(model.light_diffuse[lamps] * (model.light_active[lamps, None] != 0) / (1.0 - AMBIENT_SHARE))


def lamps_drawn(model: mujoco.MjModel) -> int:
    """Return how many lamps can be drawn besides the ambient light."""
    directed = (model.light_type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL) & (model.light_active != 0)
    return MAX_LIGHTS - 1 - int(directed.sum())


def add_lamps(spec: mujoco.MjSpec, world: World) -> None:
    """Add the lamps: point lights without shadows."""
    for lamp, name in zip(world.lamps, lamp_names(world), strict=True):
        direct, indirect = lamp_light(lamp, lamp.brightness)
        spec.worldbody.add_light(
            name=name,
            # MuJoCo's OpenGL renderer has no omnidirectional light other than a spot without a cone.
            type=mujoco.mjtLightType.mjLIGHT_SPOT,
            cutoff=180.0,
            exponent=0.0,
            pos=[*lamp.at, lamp.height],
            dir=[0.0, 0.0, -1.0],
            attenuation=[LAMP_OFFSET, 0.0, (1.0 - LAMP_OFFSET) / 4],
            range=lamp.range,
            diffuse=direct,
            ambient=indirect,
            specular=[0.0] * 3,
            castshadow=False,
            active=lamp.brightness > 0.0,
        )


def lamp_light(lamp: Lamp, brightness: float) -> tuple[Array, Array]:
    """Return the direct and the ambient light of a lamp at 2 m, red, green and blue, shape (3,) each."""
    color = brightness * np.array(color_of(lamp.color)[:3])
    return color * (1.0 - AMBIENT_SHARE), color * AMBIENT_SHARE


def given_back(world: World) -> float:
    """Return the reflectance of pictures: 1 where they are to show the light of lamps."""
    return 1.0 if world.lamps else GIVEN_BACK


def picture_glow(level: float, share: float) -> float:
    """Return the emission of a picture, as a multiple of its reflectance.

    In full light its colours are exact; in less, emission and reflected light together make up that level.

    Args:
        level: Ambient light.
        share: Reflectance of the picture.
    """
    return (level if level >= 1.0 else level * (1.0 - MEAN_LIGHT * share)) / share


def light_pictures(spec: mujoco.MjSpec, world: World) -> None:
    """Set the emission of the pictures on beacons for the ambient light."""
    share = given_back(world)
    for material in spec.materials:
        if material.name.startswith(PICTURES):
            material.emission = picture_glow(world.light, share)
            material.rgba = [share, share, share, 1.0]


def dim_light(model: mujoco.MjModel, level: float) -> None:
    """Change the ambient light of a compiled scene, and with it the emission of pictures on beacons."""
    index = model.numeric(LEVEL).id
    model.numeric_data[model.numeric_adr[index]] = level
    model.vis.headlight.ambient[:] = [level * value for value in EVEN]
    model.vis.headlight.diffuse[:] = level * TOWARDS_VIEWER
    for name, _, strength in DIRECTED:
        light = model.light(name).id
        model.light_diffuse[light] = level * strength
        model.light_active[light] = level > 0.0
    for material in range(model.nmat):
        if model.mat(material).name.startswith(PICTURES):
            model.mat_emission[material] = picture_glow(level, float(model.mat_rgba[material, 0]))


def dim_lamp(model: mujoco.MjModel, name: str, lamp: Lamp, brightness: float) -> None:
    """Change the brightness of a lamp of a compiled scene, `lamp/NAME`."""
    light = model.light(name).id
    model.light_diffuse[light], model.light_ambient[light] = lamp_light(lamp, brightness)
    model.light_active[light] = brightness > 0.0


def divide_faces(spec: mujoco.MjSpec) -> None:
    """Subdivide visual shapes finely enough for lamps."""
    spec.visual.quality.numquads = SUBDIVISIONS
    meshes = [mesh for mesh in spec.meshes if len(mesh.uservert)]
    area = sum(_area(np.reshape(mesh.uservert, (-1, 3))[np.reshape(mesh.userface, (-1, 3))]) for mesh in meshes)
    # The area of a triangle whose edges are just short enough is about a third of their square.
    longest = max(MAX_FACE_EDGE, (3.0 * area / MAX_TRIANGLES) ** 0.5)
    for mesh in meshes:
        _divide_mesh(mesh, longest)
    for geom in spec.geoms:
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            fine = MAX_FACE_EDGE if geom.name == "floor" else min(MAX_FACE_EDGE, max(geom.size[:2]) * 2 / PICTURE_PARTS)
            geom.size = [*geom.size[:2], fine]


def _divide_mesh(mesh: mujoco.MjsMesh, longest: float) -> None:
    points = np.reshape(mesh.uservert, (-1, 3))
    columns = [points]
    if len(mesh.usernormal):
        columns.append(np.reshape(mesh.usernormal, (-1, 3)))
    if len(mesh.usertexcoord):
        columns.append(np.reshape(mesh.usertexcoord, (-1, 2)))
    corners, triangles = divided(np.hstack(columns), np.reshape(mesh.userface, (-1, 3)), longest)
    mesh.uservert, mesh.userface = corners[:, :3].ravel(), triangles.ravel()
    if len(mesh.usernormal):
        mesh.usernormal = corners[:, 3:6].ravel()
    if len(mesh.usertexcoord):
        mesh.usertexcoord = corners[:, -2:].ravel()


def divided(corners: Array, triangles: NDArray[np.int32], longest: float) -> tuple[Array, NDArray[np.int32]]:
    """Return a mesh whose edges have at most a given length; longer edges are halved until none is left.

    Whether an edge is halved depends on its length alone, so that neighbours that share it stay joined without cracks.

    Args:
        corners: Position of each corner [m] and other values linear over a face, shape (n, 3 or more).
        triangles: Indices of corners, shape (m, 3).
        longest: [m]
    """
    while True:
        starts, ends = triangles, np.roll(triangles, -1, axis=1)
        long = np.linalg.norm(corners[starts, :3] - corners[ends, :3], axis=2) > longest
        if not long.any():
            return corners, triangles
        edges = np.sort(np.stack([starts[long], ends[long]], axis=1), axis=1)
        unique, places = np.unique(edges, axis=0, return_inverse=True)
        middles = np.full(triangles.shape, -1, dtype=np.int32)
        middles[long] = len(corners) + places.ravel()
        corners = np.vstack([corners, (corners[unique[:, 0]] + corners[unique[:, 1]]) / 2])
        triangles = _split(triangles, middles)


def _split(triangles: NDArray[np.int32], middles: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the parts of triangles given the midpoints of their edges, -1 for undivided edges, shape (m, 3) both."""
    # Rotated so that a single long edge comes first, and of two the undivided one last.
    has = middles >= 0
    count = has.sum(axis=1)
    turn = np.where(count == 1, has.argmax(axis=1), np.where(count == 2, (~has).argmax(axis=1) + 1, 0))
    order = (np.arange(3) + turn[:, None]) % 3
    (a, b, c), (d, e, f) = np.take_along_axis(triangles, order, 1).T, np.take_along_axis(middles, order, 1).T
    parts = []
    for number, corners in (
        (0, [(a, b, c)]),
        (1, [(a, d, c), (d, b, c)]),
        (2, [(d, b, e), (a, d, e), (a, e, c)]),
        (3, [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]),
    ):
        chosen = count == number
        parts += [np.stack([corner[chosen] for corner in three], axis=1) for three in corners]
    return np.concatenate(parts).astype(np.int32)


def _area(triangles: Array) -> float:
    """Return the area of triangles in space, shape (m, 3, 3) [m] -> [m^2]."""
    sides = triangles[:, 1:] - triangles[:, :1]
    return float(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum() / 2)
