"""Converts a scene to a world: walls, boxes, cylinders, spheres, and model files for everything else."""

import hashlib
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from pydantic import ValidationError

from mjsim.exchange.maps import DIGITS
from mjsim.exchange.scenes.model_text import model_files
from mjsim.exchange.scenes.scene_solids import (
    MAX_MASS,
    Scene,
    ScenePart,
    SceneSkin,
    SceneSolid,
    SceneTexture,
    SceneThing,
)
from mjsim.exchange.scenes.scene_walls import walls_of
from mjsim.exchange.scenes.shells import traced
from mjsim.geometry import Array
from mjsim.inventory import Fate
from mjsim.world import BoxObstacle, CylinderObstacle, Lamp, ModelObstacle, Source, SphereObstacle, Wall, World

MAX_FLOOR_HEIGHT, MAX_SLAB_HEIGHT, MIN_SLAB_AREA = 0.03, 0.12, 4.0
"""Parts that end below the first height are floor, as are those that end below the second [m] and have this area
[m^2]."""
MIN_OVERHEAD = 2.2
"""Height above which objects cannot touch a robot [m]."""
MAX_SLAB_TOP, MIN_AREA_SHARE = 0.3, 0.5
"""Maximum height of a slab on which things stand [m], and its minimum fraction of the area of the scene."""
MAX_LAMPS = 100
MAX_GAP = 0.02
"""Solids this close are one obstacle [m]."""
MIN_SIZE = 1e-3
"""Minimum size [m]."""

Obstacle = BoxObstacle | CylinderObstacle | SphereObstacle | ModelObstacle


@dataclass(slots=True)
class Built:
    """A world, and the model files that it names, by their paths beside it."""

    folder: str
    """Folder of its files beside the world."""
    walls: list[Wall] = field(default_factory=list)
    obstacles: list[Obstacle] = field(default_factory=list)
    files: dict[str, bytes] = field(default_factory=dict)
    counts: Counter[str] = field(default_factory=Counter)
    models: dict[str, str] = field(default_factory=dict)
    """Digest of a model -> its file."""


def build_world(scene: Scene, *, name: str, folder: str) -> tuple[World, dict[str, bytes]]:
    """Return the world of a scene, and the model files that it names.

    Args:
        scene: The scene; what becomes of its parts is noted in it.
        name: Name of the world.
        folder: Folder of the model files beside the world.
    """
    built = Built(folder)
    _lower_to_floor(scene)
    static = [(thing, solid) for thing in scene.things if thing.mass is None for solid in thing.solids]
    static = [(thing, solid) for thing, solid in static if not _is_floor(scene, thing, solid)]
    found, used = walls_of([solid for _, solid in static])
    taken = set(used)
    pictures = {solid.texture.name: solid.texture for _, solid in static if solid.texture is not None}
    built.walls += [
        wall.model_copy(update={"texture": _texture(built, pictures[wall.texture])}) if wall.texture else wall
        for wall in found
    ]
    if found:
        names = dict.fromkeys(static[index][0].name for index in used)
        for each in names:
            scene.tell(Fate.KEPT, "wall", each)
    left: dict[tuple[str, int], tuple[SceneThing, list[SceneSolid]]] = {}
    for index, (thing, solid) in enumerate(static):
        if index not in taken and not _is_overhead(scene, thing, solid):
            left.setdefault(_key(thing), (thing, []))[1].append(solid)
    for thing in scene.things:
        if thing.mass is None and thing.parts:
            left.setdefault(_key(thing), (thing, []))
    for thing, solids in left.values():
        _add_static(built, scene, thing, solids)
    for thing in scene.things:
        _tell_masses(scene, thing)
        if thing.mass is not None:
            _add_movable(built, scene, thing)
    named = [wall.model_copy(update={"name": f"wall-{k}"}) for k, wall in enumerate(built.walls, start=1)]
    world = World(name=name, walls=tuple(named), obstacles=tuple(built.obstacles), lamps=tuple(_lamps(scene)))
    return world, built.files


def _key(thing: SceneThing) -> tuple[str, int]:
    """Return the key by which objects are merged: their name; one with parts stays separate."""
    return thing.name, id(thing) if thing.parts else 0


def _lower_to_floor(scene: Scene) -> None:
    """Lower a scene whose things stand on a slab, such as the foundation of a house, so that its top is the floor."""
    ends = [
        (points.min(axis=0), points.max(axis=0), thing)
        for thing in scene.things
        for points in (solid.corners() for solid in thing.solids)
    ]
    static = np.array([(low, high) for low, high, thing in ends if thing.mass is None])
    if not len(static):
        return
    wide, deep = (static[:, 1].max(axis=0) - static[:, 0].min(axis=0))[:2]
    slabs = [
        (float(high[2]), thing.name)
        for low, high, thing in ends
        if thing.mass is None
        and high[2] <= MAX_SLAB_TOP
        and np.prod((high - low)[:2]) >= max(MIN_SLAB_AREA, MIN_AREA_SHARE * wide * deep)
    ]
    level, name = max(slabs, default=(0.0, ""))
    if level <= MAX_FLOOR_HEIGHT or not any(abs(low[2] - level) <= MAX_GAP / 2 for low, *_ in ends):
        return
    scene.tell(Fate.GUESSED, "floor", name, f"its top is the floor of the world, {level:.2f} m lower than in the file")
    down = np.eye(4)
    down[2, 3] = -level
    scene.things = [thing.moved(down) for thing in scene.things]
    scene.lights = [replace(light, place=light.place + down[:3, 3]) for light in scene.lights]


def _is_floor(scene: Scene, thing: SceneThing, solid: SceneSolid) -> bool:
    """Return whether a static solid is part of the floor."""
    points = solid.corners()
    top, (wide, deep) = points[:, 2].max(), np.ptp(points[:, :2], axis=0)
    found = top <= MAX_FLOOR_HEIGHT or (top <= MAX_SLAB_HEIGHT and wide * deep >= MIN_SLAB_AREA)
    if found:
        flat = top <= MAX_GAP / 2
        scene.tell(
            Fate.KEPT if flat else Fate.GUESSED,
            "floor",
            thing.name,
            "" if flat else f"its top, at {top:.2f} m, is that of the world's floor",
        )
    return bool(found)


def _is_overhead(scene: Scene, thing: SceneThing, solid: SceneSolid) -> bool:
    """Return whether a static solid outside of walls is above all that a robot can meet or see."""
    found = solid.corners()[:, 2].min() >= MIN_OVERHEAD
    if found:
        scene.tell(Fate.LEFT_OUT, "overhead part", thing.name, f"it begins above {MIN_OVERHEAD} m")
    return bool(found)


def _add_static(built: Built, scene: Scene, thing: SceneThing, solids: Sequence[SceneSolid]) -> None:
    """Add the rest of a static thing: moving parts with what they touch, simple shapes, all others as one model."""
    solids, skins = _add_parts(built, scene, thing, solids)
    found = traced(solids)
    built.walls += found.walls
    built.obstacles += [each.model_copy(update={"name": _named(built, thing.name)}) for each in found.things]
    if found.used:
        scene.tell(
            Fate.GUESSED, "hollow mesh", thing.name, "its walls are traced where it is cut 0.3 m above the floor"
        )
    if found.dropped:
        scene.tell(Fate.LEFT_OUT, "hollow mesh part", thing.name, "it begins above 0.3 m")
    gone = {id(solid) for solid in (*found.used, *found.dropped)}
    alone = [solid for solid in solids if id(solid) not in gone]
    if skins and (found.used or not alone):
        scene.tell(Fate.LEFT_OUT, "look of meshes", thing.name, "it became walls, which have one colour")
        skins = []
    others = alone if skins else _add_plain(built, scene, thing, alone)
    # Visible meshes belong to the thing as a whole.
    groups = [[*range(len(others))]] if skins else _touching([[solid] for solid in others])
    for group in groups:
        whole = replace(thing, solids=[others[k] for k in group], parts=(), skins=skins)
        _add_model(built, scene, whole, {})
    if solids:
        scene.tell(Fate.KEPT, "static model", thing.name)


def _add_plain(built: Built, scene: Scene, thing: SceneThing, solids: Sequence[SceneSolid]) -> list[SceneSolid]:
    """Add solids that are simple shapes one by one, and return the others."""
    others = []
    for solid in solids:
        plain = _plain(solid, built, thing.name)
        if plain is not None:
            built.obstacles.append(plain)
        else:
            others.append(solid)
    return others


def _add_parts(
    built: Built, scene: Scene, thing: SceneThing, solids: Sequence[SceneSolid]
) -> tuple[list[SceneSolid], list[SceneSkin]]:
    """Add models of the parts that joints move on a static thing, with solids near them; return the rest, and skins."""
    parts, skins = thing.parts, list(thing.skins)
    shapes = [part.all_solids() for part in parts]
    beside = [solid for solid in solids if any(len(_touching([[solid], shape])) == 1 for shape in shapes)]
    for group in _touching([*shapes, *([solid] for solid in beside)]):
        moved = [parts[k] for k in group if k < len(parts)]
        still = [beside[k - len(parts)] for k in group if k >= len(parts)]
        if not moved:
            continue
        named = moved[0].name if len(moved) == 1 else thing.name
        own = [skins.pop() for _ in range(len(skins) if still else 0)]
        _add_model(built, scene, replace(thing, name=named, solids=still, parts=moved, skins=own), {})
    used = set(map(id, beside))
    return [solid for solid in solids if id(solid) not in used], skins


def _touching(shapes: Sequence[Sequence[SceneSolid]]) -> list[list[int]]:
    """Return groups of shapes whose bounding boxes touch from above: things apart are obstacles of their own."""
    import shapely
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if not shapes:
        return []
    corners = [np.concatenate([solid.corners() for solid in shape]) for shape in shapes]
    ends = np.array([[points.min(axis=0), points.max(axis=0)] for points in corners])
    low, high = ends[:, 0, :2] - MAX_GAP, ends[:, 1, :2] + MAX_GAP
    boxes = shapely.box(*low.T, *high.T)
    pairs = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    graph = coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(len(shapes),) * 2)
    _, label = connected_components(graph, directed=False)
    return [np.flatnonzero(label == group).tolist() for group in np.unique(label).tolist()]


def _add_movable(built: Built, scene: Scene, thing: SceneThing) -> None:
    """Add a movable thing: as a simple shape if it is one, else as a model."""
    assert thing.mass is not None, "static things have none"
    if not thing.solids:
        scene.tell(Fate.GUESSED, "movable model", thing.name, "one rigid thing: what carries its joints has no shape")
        whole = [solid for part in thing.parts for solid in part.all_solids()]
        thing = replace(thing, solids=whole, parts=(), mass=_mass(thing))
    keys = {"movable": True, "mass": round(min(max(_mass(thing), 1e-3), MAX_MASS), 4)}
    simple = len(thing.solids) == 1 and not thing.parts and not thing.skins
    plain = _plain(thing.solids[0], built, thing.name, keys) if simple else None
    if plain is not None:
        built.obstacles.append(plain)
    elif not _add_model(built, scene, thing, keys):
        return
    scene.tell(Fate.KEPT, "movable model", thing.name)


def _tell_masses(scene: Scene, thing: SceneThing | ScenePart) -> None:
    """Report the masses of a thing and its parts that are limited."""
    for part in thing.parts:
        _tell_masses(scene, part)
    if (thing.mass or 0.0) > MAX_MASS:
        scene.tell(Fate.MENDED, "mass", thing.name, f"of {thing.mass:.3g} kg; made {MAX_MASS:g} kg")


def _mass(thing: SceneThing | ScenePart) -> float:
    """Return the mass of a thing with its parts [kg]."""
    return (thing.mass or 0.0) + sum(_mass(part) for part in thing.parts)


def _plain(solid: SceneSolid, built: Built, name: str, keys: dict[str, Any] | None = None) -> Obstacle | None:
    """Return an upright box or cylinder, or a sphere, as an obstacle; None for anything else."""
    if solid.kind == "mesh" or not (solid.is_upright or solid.kind == "sphere"):
        return None
    at = tuple((np.round(solid.pose[:2, 3], DIGITS) + 0.0).tolist())
    low = float(solid.pose[2, 3] - solid.half[2])
    given: dict[str, Any] = {"name": _named(built, name), "at": at, **(keys or {})}
    if low > 1e-3:
        given["elevation"] = round(low, DIGITS)
    cut = min(low, 0.0)  # Parts below the floor are cut off.
    if solid.color is not None:
        given["color"] = solid.color
    if solid.texture is not None and solid.kind != "sphere":
        tile = solid.texture.tile or solid.size[-1]
        given |= {"texture": _texture(built, solid.texture), "tile": round(max(tile, MIN_SIZE), DIGITS)}
    sizes = [round(max(size, MIN_SIZE), DIGITS) for size in solid.size]
    if solid.kind == "sphere":
        return SphereObstacle(sphere=sizes[0], **given)
    sizes[-1] = round(max(solid.size[-1] + cut, MIN_SIZE), DIGITS)
    if solid.kind == "cylinder":
        return CylinderObstacle(cylinder=(sizes[0], sizes[1]), **given)
    heading = (math.degrees(solid.heading) + 90.0) % 180.0 - 90.0
    return BoxObstacle(box=(sizes[0], sizes[1], sizes[2]), heading_deg=round(heading, 2) + 0.0, **given)


def _add_model(built: Built, scene: Scene, thing: SceneThing, keys: dict[str, Any]) -> bool:
    """Add a thing as one obstacle with a model file; equal things share a file. False if MuJoCo cannot read it."""
    yaw = math.atan2(thing.pose[1, 0], thing.pose[0, 0])
    base = np.eye(4)
    base[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    base[:2, 3] = thing.pose[:2, 3]
    local = thing.moved(np.asarray(np.linalg.inv(base), dtype=float))
    whole = [*local.solids, *(solid for part in local.parts for solid in part.all_solids())]
    low = float(min(solid.corners()[:, 2].min() for solid in whole))
    if any(solid.texture is not None for solid in whole):
        scene.tell(
            Fate.LEFT_OUT, "texture", thing.name, "it is not a single upright box or cylinder; its colour is kept"
        )
    text, meshes = model_files(local, moves="mass" in keys)
    digest = hashlib.sha256(b"".join([text.encode(), *meshes.values()])).hexdigest()
    if digest not in built.models:
        own = _file_name(thing.name, len(built.models))
        built.models[digest] = f"{built.folder}/{own}/model.xml"
        built.files[built.models[digest]] = text.encode()
        built.files |= {f"{built.folder}/{own}/{mesh}": data for mesh, data in meshes.items()}
    given: dict[str, Any] = {"name": _named(built, thing.name), "model": built.models[digest], **keys}
    given["at"] = tuple((np.round(base[:2, 3], DIGITS) + 0.0).tolist())
    given["heading_deg"] = round(math.degrees(yaw), 2) + 0.0
    given["elevation"] = round(max(low, 0.0), DIGITS)
    try:
        built.obstacles.append(ModelObstacle.model_validate(given, context={"source": Source(attached=built.files)}))
    except ValidationError as error:
        scene.tell(Fate.LEFT_OUT, "model", thing.name, error.errors()[0]["msg"][:200])
        return False
    for part in thing.parts:
        scene.tell(Fate.KEPT, "jointed thing", part.name)
    return True


def _texture(built: Built, texture: SceneTexture) -> str:
    """Return the path of a texture in the world."""
    if texture.data is None:
        return texture.name
    path = f"{built.folder}/{texture.name}"
    built.files[path] = texture.data
    return path


def _named(built: Built, name: str) -> str:
    """Return a new name for an obstacle."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:48] or "thing"
    built.counts[plain] += 1
    return plain if built.counts[plain] == 1 else f"{plain}-{built.counts[plain]}"


def _file_name(name: str, number: int) -> str:
    return f"{re.sub(r'[^A-Za-z0-9_-]+', '_', name).strip('_')[:40] or 'model'}_{number}"


def _lamps(scene: Scene) -> Iterator[Lamp]:
    for light in scene.lights[:MAX_LAMPS]:
        at: Array = np.round(light.place, DIGITS)
        height = max(float(at[2]), 0.05)
        x, y = (at[:2] + 0.0).tolist()
        yield Lamp(at=(x, y), height=height, color=light.color, range=min(max(light.reach, 0.1), 100.0))
    if len(scene.lights) > MAX_LAMPS:
        scene.tell(Fate.LEFT_OUT, f"lamps beyond the first {MAX_LAMPS}")
