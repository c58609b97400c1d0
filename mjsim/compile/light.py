"""Light: ambient light, lamps, and surfaces subdivided finely enough for lamps.

MuJoCo lights corners and spreads that over the faces between them, and knows at most eight lights at a time. So
faces are divided in a world that has lamps, and in no other.
"""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile.pictures import color_of
from mjsim.geometry import Array
from mjsim.world import Lamp, World, item_names

EVEN, TOWARDS_VIEWER = (0.71, 0.71, 0.72), 0.08
"""Light from everywhere, red, green, blue; and what is added where one looks at a face squarely."""
DIRECTED = (("light/key", (0.80, 0.10, 0.50), 0.18), ("light/fill", (-0.45, 0.75, 0.50), 0.26))
"""Name, where it shines from, and strength: walls that face east, north, west and south get 0.86, 0.92, 0.83
and 0.71 of full light, the floor 0.93; what one looks at squarely gets 0.08 more."""
PICTURES = "beacon/"
"""How the names of materials begin that show pictures."""
LEVEL = "light"
"""Name of the number in the scene that holds the general light."""
GIVEN_BACK = 0.25
"""Fraction of the general light that a picture gives back; it shines by itself, so that its colours are its own at
any angle and only a little brighter where a lamp of high quality adds to it."""
MEAN_LIGHT = 0.92
"""Of what faces all sides, in full general light."""
NEAR_SHARE = 0.2
"""A lamp lights in proportion to 1 / (0.2 + 0.2 d^2) at d metres: once at 2 m, never more than five times."""
INDIRECT = 0.2
"""Fraction of a lamp's light that comes from all sides, as walls throw it back."""
MOST_LIGHTS = 8
"""As many lights as OpenGL draws with."""
FINE, MOST_TRIANGLES = 0.4, 60_000
"""Longest edge of a face that lamps light [m], and how many triangles there are about when that is not too fine."""
PICTURE_PARTS, QUADS = 6, 8
"""Into how many strips a picture, and the face of a box, are divided each way."""


def add_general_light(spec: mujoco.MjSpec, level: float, lower: Array, upper: Array) -> None:
    """Add even light and two lamps at infinity: walls of different directions differ, and white stays below full."""
    spec.add_numeric(name=LEVEL, data=[level], size=1)
    headlight = spec.visual.headlight
    headlight.ambient = [level * value for value in EVEN]
    headlight.diffuse = [level * TOWARDS_VIEWER] * 3
    headlight.specular = [0.0, 0.0, 0.0]
    # MuJoCo lets what no light shines on glow; one that is there and dark does not.
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
    """Return the general light of a compiled scene; 1 in one that is not ours."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, LEVEL)
    return float(model.numeric_data[model.numeric_adr[index]]) if index >= 0 else 1.0


def lamp_lights(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return the indices of the lamps among the lights of a compiled scene."""
    return np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_SPOT)


def lamps_drawn(model: mujoco.MjModel) -> int:
    """Return how many lamps can be drawn besides the general light."""
    directed = (model.light_type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL) & (model.light_active != 0)
    return MOST_LIGHTS - 1 - int(directed.sum())


def add_lamps(spec: mujoco.MjSpec, world: World) -> None:
    """Add the lamps: lights that shine to all sides, without shadows."""
    for lamp, name in zip(world.lamps, lamp_names(world), strict=True):
        direct, indirect = lamp_light(lamp, lamp.brightness)
        spec.worldbody.add_light(
            name=name,
            # MuJoCo's renderer of OpenGL has no light to all sides but a spot without a cone.
            type=mujoco.mjtLightType.mjLIGHT_SPOT,
            cutoff=180.0,
            exponent=0.0,
            pos=[*lamp.at, lamp.height],
            dir=[0.0, 0.0, -1.0],
            attenuation=[NEAR_SHARE, 0.0, (1.0 - NEAR_SHARE) / 4],
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
    return color * (1.0 - INDIRECT), color * INDIRECT


def given_back(world: World) -> float:
    """Return the fraction of light that pictures reflect: all of it where they are to show the light of lamps."""
    return 1.0 if world.lamps else GIVEN_BACK


def picture_glow(level: float, share: float) -> float:
    """Return the light of its own that a picture has, as a multiple of what it gives back.

    Full light shows its colours as they are; in less, its own light and what it gives back make up that much.

    Args:
        level: General light.
        share: Of light that it gives back.
    """
    return (level if level >= 1.0 else level * (1.0 - MEAN_LIGHT * share)) / share


def light_pictures(spec: mujoco.MjSpec, world: World) -> None:
    """Let the pictures on beacons glow as the general light has it."""
    share = given_back(world)
    for material in spec.materials:
        if material.name.startswith(PICTURES):
            material.emission = picture_glow(world.light, share)
            material.rgba = [share, share, share, 1.0]


def dim_light(model: mujoco.MjModel, level: float) -> None:
    """Change the general light of a compiled scene; pictures on beacons glow as it has it."""
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
    """Divide what is seen so finely that lamps light it as they should."""
    spec.visual.quality.numquads = QUADS
    meshes = [mesh for mesh in spec.meshes if len(mesh.uservert)]
    area = sum(_area(np.reshape(mesh.uservert, (-1, 3))[np.reshape(mesh.userface, (-1, 3))]) for mesh in meshes)
    # A triangle whose edges are just short enough has about a third of their square.
    longest = max(FINE, (3.0 * area / MOST_TRIANGLES) ** 0.5)
    for mesh in meshes:
        _divide_mesh(mesh, longest)
    for geom in spec.geoms:
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            fine = FINE if geom.name == "floor" else min(FINE, max(geom.size[:2]) * 2 / PICTURE_PARTS)
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
    """Return a mesh whose edges are at most so long: each longer edge is halved until none is left.

    An edge is halved for its length alone, so that neighbours which share it stay joined without a crack.

    Args:
        corners: Place of each corner [m] and whatever else goes linearly over a face, shape (n, 3 or more).
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
    """Return the parts of triangles whose edges have middles, -1 where an edge is whole, shape (m, 3) both."""
    # Turned so that a sole long edge comes first, and of two the whole one last.
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
