"""Geometry of a world for its light: triangles, charts, texels, and the rooms that rays are cast in."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.light.baked import DOOR
from mjsim.light.charts import Charts, charts_of
from mjsim.light.light_rays import WINDOW_CELL, Light, Numbers, Points, Rectangle, Room
from mjsim.light.still_surfaces import StillGeom, solid_of, static_geoms
from mjsim.light.texels import Texels, texels_of
from mjsim.world import CloseEvent, OpenEvent, RemoveEvent, World, leaves

MIN_TEXEL = 0.05
"""Minimum side of a texel [m]."""
MAX_TEXELS = 1_100_000
"""Approximate limit of texels in all maps of a world; above it texels are larger."""
MAX_DOORS = 4
"""Number of doors with a map of their own, the first that events name; others cast the shadow of their initial
angle."""
OPEN_ANGLE = math.pi / 2
"""Angle of an open door, at which its map counts fully [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Atlas:
    """All lit triangles, and their charts."""

    solids: tuple[StillGeom, ...]
    """Static surfaces, then leaves of doors: of each door that moves, closed and open."""
    owner: Numbers
    """Index in `solids` of each triangle, shape (n,)."""
    corners: Array
    """World frame, shape (n, 3, 3) [m]."""
    charts: Charts
    texels: Texels
    ajar: Mapping[str, tuple[frozenset[int], frozenset[int]]]
    """Solids of the closed and of the open leaf of each door with a map of its own, by the name of its group."""

    def of_solids(self, values: Sequence[Array]) -> Light:
        """Return a value of each solid for each texel, shape (texels, k)."""
        rows: Light = np.asarray(values, dtype=np.float32)[self.owner[self.texels.triangles]]
        return rows

    @property
    def points(self) -> Points:
        """All texels, as points that cast rays."""
        return Points(self.texels.at, self.texels.points, self.texels.normals)

    def room(self, windows: Sequence[Rectangle] = (), *, opened: str | None = None) -> tuple[Room, Numbers]:
        """Return the room with one door open or none, and the index in `corners` of each of its triangles."""
        hidden = {solid for name, states in self.ajar.items() for solid in states[name != opened]}
        shades = [solid.shades and index not in hidden for index, solid in enumerate(self.solids)]
        chosen = np.flatnonzero(np.array(shades)[self.owner])
        panes = [_pane(window) for window in windows]
        names = np.concatenate([chosen, np.full(2 * len(panes), WINDOW_CELL)])
        return Room(np.concatenate([self.corners[chosen], *panes]).astype(np.float32)), names


def atlas_of(world: World, model: mujoco.MjModel, *, groups: int = 1, texel: float = MIN_TEXEL) -> Atlas:
    """Return the geometry of a compiled world at its start.

    Args:
        world: The world.
        model: The compiled world.
        groups: Number of maps, whose total size is limited.
        texel: Minimum side of a texel [m].
    """
    solids, ajar = _solids(world, model)
    corners = np.concatenate([solid.points[solid.triangles] for solid in solids])
    normals = np.concatenate([solid.normals[solid.triangles] for solid in solids])
    owner = np.repeat(np.arange(len(solids)), [len(solid.triangles) for solid in solids])
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = float(np.linalg.norm(cross, axis=1).sum() / 2)
    charts = charts_of(corners, normals, texel=max(texel, math.sqrt(area * groups / MAX_TEXELS)))
    return Atlas(solids, owner, corners, charts, texels_of(corners, normals, charts), ajar)


def moved_doors(world: World) -> dict[str, float]:
    """Return the angle [rad] of each door that events move and that has a map of its own, by its name."""
    known = {leaf.name: math.radians(leaf.door.angle_deg) for leaf in leaves(world)}
    found: dict[str, float] = {}
    for event in world.run.events:
        if isinstance(event, OpenEvent) and event.open in known:
            found[event.open] = math.copysign(OPEN_ANGLE, event.angle_deg)
        elif isinstance(event, CloseEvent) and known.get(event.close):
            found.setdefault(event.close, math.copysign(OPEN_ANGLE, known[event.close]))
    return dict(list(found.items())[:MAX_DOORS])


def _solids(
    world: World, model: mujoco.MjModel
) -> tuple[tuple[StillGeom, ...], dict[str, tuple[frozenset[int], frozenset[int]]]]:
    moved, data = moved_doors(world), mujoco.MjData(model)
    for name in moved:
        data.qpos[model.joint(f"{DOOR}{name}").qposadr] = 0.0
    mujoco.mj_kinematics(model, data)
    removed = _removed(world, model)
    geoms = [int(geom) for geom in static_geoms(model) if geom not in removed]
    bodies = {leaf.name: model.body(f"{DOOR}{leaf.name}").id for leaf in leaves(world)}
    still = [geom for name, body in bodies.items() if name not in moved for geom in _geoms(model, body)]
    solids = [solid for geom in geoms + still if (solid := solid_of(model, data, geom)) is not None]
    # People cast shadows where they stand; their round bodies are too small for texels.
    people = tuple(f"{person.name}/" for person in world.people)
    solids = [replace(each, moves=each.moves or _body_of(model, each).startswith(people)) for each in solids]
    ajar = {}
    for name, angle in moved.items():
        states = []
        for value in (0.0, angle):
            data.qpos[model.joint(f"{DOOR}{name}").qposadr] = value
            mujoco.mj_kinematics(model, data)
            leaf = [solid for geom in _geoms(model, bodies[name]) if (solid := solid_of(model, data, geom)) is not None]
            states.append(frozenset(range(len(solids), len(solids) + len(leaf))))
            solids += leaf
        ajar[f"{DOOR}{name}"] = states[0], states[1]
    return tuple(solids), ajar


def _body_of(model: mujoco.MjModel, solid: StillGeom) -> str:
    return str(model.body(model.geom_bodyid[solid.geom]).name)


def _geoms(model: mujoco.MjModel, body: int) -> list[int]:
    geoms: list[int] = np.flatnonzero((model.geom_bodyid == body) & np.isin(model.geom_group, (0, 1))).tolist()
    return geoms


def _removed(world: World, model: mujoco.MjModel) -> set[int]:
    """Return the geoms that events remove: they are lit like moving objects."""
    names = {event.remove for event in world.run.events if isinstance(event, RemoveEvent)}
    names |= {beacon.name for beacon in world.beacons if beacon.on in names}
    exact = {f"{kind}/{name}" for kind in ("obstacle", "beacon") for name in names}
    parts = tuple(f"{name}{mark}" for name in exact for mark in "/:")
    chosen = [(geom, model.geom(geom).name, model.body(model.geom_bodyid[geom]).name) for geom in range(model.ngeom)]
    return {geom for geom, *own in chosen if any(name in exact or name.startswith(parts) for name in own if parts)}


def _pane(window: Rectangle) -> NDArray[np.float64]:
    a, b, middle = window.across, window.along, window.middle
    square = middle + np.array([-a - b, a - b, a + b, b - a])
    triangles: NDArray[np.float64] = square[np.array([[0, 1, 2], [0, 2, 3]])]
    return triangles
