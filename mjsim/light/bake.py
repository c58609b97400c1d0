"""Bakes the light of a compiled world: direct light of lamps, windows and sky, and all reflections on static surfaces.

Reflected light is computed in cells of some texels by gathering along stored rays, until it no longer changes.

References:
    Cohen, Wallace: Radiosity and Realistic Image Synthesis (1993), sections 4 and 5.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.light.baked import ALWAYS, DOOR, GENERAL, LAMP, BakedLight, LightGroup, LitSurface, linear
from mjsim.light.crew import MAX_LONE_POINTS, Crew, crew_of, processors
from mjsim.light.emitters import DAYLIGHT_RATIO, behind, inside_of, lamp_color, lamp_rectangle, window_rectangles
from mjsim.light.light_geometry import MIN_TEXEL, OPEN_ANGLE, Atlas, atlas_of, moved_doors
from mjsim.light.light_rays import Light, Points, Rectangle
from mjsim.light.probes import ProbeGrid, grid_of
from mjsim.light.spread import SMOOTHING_ROUNDS, filled, finer, on_image
from mjsim.light.texel_links import Links, links_of
from mjsim.light.texels import Cells, cells_of
from mjsim.light.work import Gathered, Surroundings, buried, gathered, lit
from mjsim.progress import say
from mjsim.world import LampEvent, World, item_names, leaves

MIN_CELL_SIDE, MAX_CELLS = 0.1, 110_000
"""Minimum side of a cell [m], and the approximate limit of cells above which they are larger."""
RAYS = 12
"""Rays per side of the hemisphere of a cell."""
PROBE_RAYS = 8
"""The same for each face of a probe."""
TEST_RAYS, MAX_BURIED_SHARE = 3, 0.85
"""Rays per side of the hemisphere that test whether a texel lies in a solid or a narrow gap, and the maximum share of
them that may hit one."""
CONVERGENCE, MAX_BOUNCES = 0.01, 40
"""Change of light, relative to full light, below which the remaining reflections are taken as a geometric series, and
the maximum number of reflections."""
MAX_SHARE = 0.95
"""Maximum share of light that a reflection keeps, for rooms that are almost white."""
MEAN_LIGHT, MIN_GAIN, MAX_GAIN = 0.75, 0.3, 4.0
"""Mean ambient light of floor and walls within rooms, and bounds of the factor that makes it so."""
FULL_LIGHT_SHARE, WHITE = 0.95, 1.0
"""Share of texels within rooms that exposure keeps at or below full light at the start, however bright the lamps."""
SHARES = ("sky", "behind")
"""Names of the shares of rays in `Gathered`."""
MAX_LAMPS = 4
"""Number of lamps with a map of their own: all that events change, even if more, then the first others."""
COARSE_TEXEL = 0.25
"""Side of a texel above which a message is printed [m]."""
DOOR_RADIUS = 6.0
"""Distance from a door within which it changes what rays hit [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Sources:
    """All light sources, and the group of each."""

    names: tuple[str, ...]
    """Names of the groups."""
    start: Array
    """Weight of each group at the start, shape (groups, 3)."""
    rectangles: tuple[Rectangle, ...]
    """Lamps and windows."""
    colors: Light
    """How much each rectangle adds to the light of each group of weight 1, shape (rectangles, 3 groups)."""


def bake(
    world: World,
    model: mujoco.MjModel,
    *,
    processes: int | None = None,
    texel: float = MIN_TEXEL,
    done: Callable[[float], None] = lambda share: None,
) -> BakedLight:
    """Return the light of a compiled world.

    Args:
        world: The world.
        model: The compiled world; not changed.
        processes: Number of processes that cast rays; the light does not depend on it.
        texel: Minimum side of a texel [m].
        done: Called with the share of the work that is done, in [0, 1].
    """
    groups = len(_groups(world)) + len(moved_doors(world))
    shape = atlas_of(world, model, groups=groups, texel=texel)
    if (side := float(shape.charts.size.max(initial=texel))) > COARSE_TEXEL:
        say(f"world '{world.name}' is large: its light has one value per {side:.2g} m, and finer shadows are lost")
    few = len(shape.texels.at) < MAX_LONE_POINTS
    with crew_of((1 if few else processors()) if processes is None else processes) as crew:
        return _Bake(world, shape, crew, done).light()


class _Bake:
    """One bake, with the data that its steps share."""

    def __init__(self, world: World, shape: Atlas, crew: Crew, done: Callable[[float], None]) -> None:
        self._world, self._shape, self._crew, self._report = world, shape, crew, done
        self._windows = window_rectangles(world, shape.room()[0])
        self._sources = sources_of(world, self._windows)
        # Surfaces seen through a window lie behind the plane in which it shines: they have daylight.
        self._views = np.any([behind(window, shape.points) for window in self._windows], axis=0)
        self._side = max(
            1, round(max(MIN_CELL_SIDE, _cell_side(shape)) / float(shape.charts.size.max(initial=MIN_TEXEL)))
        )
        self._done, self._total = 0.0, 1.0

    def light(self) -> BakedLight:
        """Return the light."""
        shape, sources = self._shape, self._sources
        around = self._around(np.zeros(0, np.int32))
        valid = (
            np.concatenate(self._crew.run(buried, around, shape.points, TEST_RAYS)) < MAX_BURIED_SHARE
        ) | self._views
        links = links_of(around.room, shape.texels, shape.charts.shape, valid)
        cells = cells_of(shape.texels, valid, shape.charts, self._side, links.pairs)
        grid = grid_of(self._world, shape)
        self._total = 1.05 * (len(valid) + len(cells.lead) + len(grid.points.points))
        image: NDArray[np.int32] = np.asarray(
            on_image(shape.charts.shape, shape.texels.at, cells.of.astype(np.int32), -1), np.int32
        )
        around = self._around(np.asarray(filled(image, image >= 0)).astype(np.int32).ravel())
        base = self._solved(around, cells, valid)
        maps, probes = [self._map(base, cells, links, valid)], [self._probed(around, grid, base)]
        names, start = list(sources.names), list(sources.start)
        for name in shape.ajar:
            opened = self._opened(base, name, cells, valid, image)
            difference = self._map(opened, cells, links, valid) - maps[0]
            maps.append(np.einsum("hwgc,gc->hwc", difference, sources.start)[:, :, None].astype(np.float32))
            change = self._probed(opened.around, grid, opened) - probes[0]
            probes.append(np.einsum("ngc,gc->nc", change, sources.start)[:, None].astype(np.float32))
            names.append(name)
            start.append(_opening(self._world, name))
        self._report(1.0)
        return self._result(names, np.array(start), maps, probes, grid, valid)

    def _around(self, cells: NDArray[np.int32], opened: str | None = None) -> Surroundings:
        room, names = self._shape.room(self._windows, opened=opened)
        return Surroundings(room, names, self._shape.charts, cells)

    def _advance(self, count: int) -> None:
        self._done += count
        self._report(min(self._done / self._total, 1.0))

    def _solved(self, around: Surroundings, cells: Cells, valid: NDArray[np.bool_]) -> "_Solved":
        """Return the light with all movable doors closed."""
        direct = np.zeros((len(valid), self._sources.colors.shape[1]), np.float32)
        direct[valid] = self._lit(around, self._shape.points.some(valid))
        direct += self._own()
        leads = self._shape.points.some(cells.lead)
        rays = _joined(self._crew.run(gathered, around, leads, RAYS, len(cells.lead), done=self._advance))
        return self._settled(around, cells, direct, rays)

    def _lit(self, around: Surroundings, at: Points) -> Light:
        rectangles, colors = self._sources.rectangles, self._sources.colors
        parts = self._crew.run(lit, around, at, rectangles, colors, done=self._advance)
        light: Light = np.concatenate([np.zeros((0, colors.shape[1]), np.float32), *parts])
        return light

    def _own(self) -> Light:
        """Return the light emitted by ceilings, glowing surfaces and views of windows, shape (texels, 3 groups)."""
        has = self._world.ceiling is not None
        own = self._shape.of_solids(
            [np.array([solid.glow + float(has and solid.is_ceiling)]) for solid in self._shape.solids]
        )
        own[self._views] = DAYLIGHT_RATIO
        return own * _as_general(self._sources)

    def _settled(self, around: Surroundings, cells: Cells, direct: Light, rays: Gathered) -> "_Solved":
        groups = len(self._sources.names)
        albedo = cells.mean(self._shape.of_solids([solid.albedo for solid in self._shape.solids]))
        sky = rays.sky[:, None] * _as_general(self._sources)
        outgoing, reflected = cells.mean(direct), np.zeros((len(albedo), 3 * groups), np.float32)
        first = outgoing + sky
        albedo = np.tile(albedo, groups)
        added = np.ones_like(reflected)
        for _ in range(MAX_BOUNCES):
            leaving = np.vstack([albedo * (first + reflected), np.zeros((1, 3 * groups), np.float32)])
            reflected, before, last = _gather(rays.hits, leaving), reflected, added
            added = reflected - before
            if np.abs(added).max(initial=0.0) < CONVERGENCE:
                reflected += added * _rest(added, last)
                break
        leaving = np.vstack([albedo * (first + reflected), np.zeros((1, 3 * groups), np.float32)])
        return _Solved(around, direct, reflected + sky, leaving, rays)

    def _opened(
        self, base: "_Solved", name: str, cells: Cells, valid: NDArray[np.bool_], image: NDArray[np.int32]
    ) -> "_Solved":
        """Return the light with one door open: light near it is computed again."""
        shape = self._shape
        around = self._around(base.around.cells, opened=name)
        leaf = np.isin(shape.owner, list(shape.ajar[name][1]))
        middle = shape.corners[leaf].reshape(-1, 3).mean(axis=0)
        near = np.linalg.norm(shape.texels.points - middle, axis=1) < DOOR_RADIUS
        direct = base.direct.copy()
        again = near & valid
        direct[again] = self._lit(around, shape.points.some(again)) + self._own()[again]
        chosen = np.flatnonzero(near[cells.lead])
        rays = _joined(self._crew.run(gathered, around, shape.points.some(cells.lead[chosen]), RAYS, len(cells.lead)))
        hits, sky = base.rays.hits.copy(), base.rays.sky.copy()
        hits[:, chosen], sky[chosen] = rays.hits, rays.sky
        return self._settled(around, cells, direct, Gathered(hits, sky, base.rays.behind))

    def _map(self, solved: "_Solved", cells: Cells, links: Links, valid: NDArray[np.bool_]) -> Light:
        """Return the light of each group on the atlas, shape (rows, columns, groups, 3)."""
        texels, charts = self._shape.texels, self._shape.charts
        fine = links.smoothed(finer(solved.indirect, cells, texels, links, self._side), SMOOTHING_ROUNDS * self._side)
        known = np.asarray(on_image(charts.shape, texels.at, valid, False)).astype(bool)
        image = on_image(charts.shape, texels.at, fine + solved.direct, 0.0)
        whole: Light = np.asarray(filled(image, known), np.float32)
        return whole.reshape(*charts.shape, -1, 3)

    def _probed(self, around: Surroundings, grid: ProbeGrid, solved: "_Solved") -> Light:
        """Return the mean light of each group on the sides of all probes, shape (probes, groups, 3)."""
        rays = _joined(
            self._crew.run(gathered, around, grid.points, PROBE_RAYS, len(solved.leaving) - 1, done=self._advance)
        )
        light = _gather(rays.hits, solved.leaving) + rays.sky[:, None] * _as_general(self._sources)
        light += self._lit(around, grid.points)
        mean = light.reshape(-1, 6, len(self._sources.names), 3).mean(axis=1)
        return grid.outside_solids(mean, rays.behind.reshape(-1, 6).mean(axis=1))

    def _result(
        self,
        names: Sequence[str],
        start: Array,
        maps: Sequence[Light],
        probes: Sequence[Light],
        grid: ProbeGrid,
        valid: NDArray[np.bool_],
    ) -> BakedLight:
        whole, points = np.concatenate(maps, axis=2), np.concatenate(probes, axis=1)
        texels, columns = self._shape.texels, self._shape.charts.shape[1]
        inside = valid & self._counted()
        rooms = whole[texels.at[inside] // columns, texels.at[inside] % columns]
        gain = np.ones(len(names), np.float32)
        general = names.index(GENERAL)
        mean = float(rooms[:, general].mean()) if inside.any() else MEAN_LIGHT
        gain[general] = np.clip(MEAN_LIGHT / max(mean, 1e-6), MIN_GAIN, MAX_GAIN)
        # A door changes ambient light and lamps together, but mostly ambient light.
        gain[len(self._sources.names) :] = gain[general]
        whole, points = whole * gain[:, None], points * gain[:, None]
        bright = np.einsum("ngc,gc->n", rooms * gain[:, None], start) / 3.0
        exposure = min(1.0, WHITE / max(float(np.quantile(bright, FULL_LIGHT_SHARE)) if len(bright) else WHITE, 1e-6))
        angles = {f"{DOOR}{name}": angle for name, angle in moved_doors(self._world).items()}
        groups = tuple(
            LightGroup(
                name, rounded(whole[:, :, index]), start[index], gain=float(gain[index]), angle=angles.get(name, 0.0)
            )
            for index, name in enumerate(names)
        )
        return BakedLight(surfaces_of(self._shape), groups, grid.probes(points), exposure)

    def _counted(self) -> NDArray[np.bool_]:
        """Return the texels of floors and walls within rooms."""
        texels = self._shape.texels
        up = texels.normals[:, 2]
        counted = (np.abs(up) < 0.1) | ((up > 0.9) & (texels.points[:, 2] < 0.1))
        counted[counted] = inside_of(self._world)((texels.points + 0.1 * texels.normals)[counted, :2])
        return counted


@dataclass(frozen=True, slots=True, eq=False)
class _Solved:
    """The light of all groups, one state of the doors."""

    around: Surroundings
    direct: Light
    """Direct light of lamps, windows and glowing surfaces on texels, shape (texels, 3 groups)."""
    indirect: Light
    """Light of the sky and reflected on cells, shape (cells, 3 groups)."""
    leaving: Light
    """Light that each cell reflects, and a row of zeros, shape (cells + 1, 3 groups)."""
    rays: Gathered


def _groups(world: World) -> dict[str, Array]:
    """Return the weight at the start of each group of light, without doors."""
    changed, names = {event.lamp for event in world.run.events if isinstance(event, LampEvent)}, item_names(world.lamps)
    own = sorted(names, key=lambda name: name not in changed)[: max(MAX_LAMPS, len(changed))]
    groups = {GENERAL: linear(np.full(3, world.light))}
    if len(own) < len(names):
        groups[ALWAYS] = np.ones(3)
    for name, lamp in zip(names, world.lamps, strict=True):
        if name in own:
            groups[f"{LAMP}{name}"] = lamp_weight(lamp.color, lamp.brightness)
    return groups


def lamp_weight(color: str, brightness: float) -> Array:
    """Return the weight of a lamp's group, shape (3,)."""
    return np.asarray(lamp_color(color) * linear(brightness), dtype=float)


def sources_of(world: World, windows: Sequence[Rectangle]) -> Sources:
    """Return all light sources of a world, given its windows."""
    groups = _groups(world)
    names = tuple(groups)
    rectangles, colors = list(windows), [_color(names, GENERAL, np.ones(3)) for _ in windows]
    for name, lamp in zip(item_names(world.lamps), world.lamps, strict=True):
        alone = f"{LAMP}{name}" in groups
        rectangles.append(lamp_rectangle(lamp))
        weight = np.ones(3) if alone else lamp_weight(lamp.color, lamp.brightness)
        colors.append(_color(names, f"{LAMP}{name}" if alone else ALWAYS, weight))
    table = np.array(colors, dtype=np.float32).reshape(len(rectangles), 3 * len(names))
    return Sources(names, np.array(list(groups.values())), tuple(rectangles), table)


def _color(names: Sequence[str], name: str, color: Array) -> Light:
    row = np.zeros((len(names), 3), np.float32)
    row[names.index(name)] = color
    return row.ravel()


def _as_general(sources: Sources) -> Light:
    """Return a row that adds white light to the ambient light, shape (3 groups,)."""
    return _color(sources.names, GENERAL, np.ones(3))


def _opening(world: World, name: str) -> Array:
    """Return how far the door of a group is open at the start, as a weight, shape (3,)."""
    angles = {f"{DOOR}{leaf.name}": abs(np.deg2rad(leaf.door.angle_deg)) for leaf in leaves(world)}
    return np.full(3, min(float(angles[name]) / OPEN_ANGLE, 1.0))


def _cell_side(shape: Atlas) -> float:
    return float(np.sqrt(shape.charts.count.prod(axis=1).sum() / MAX_CELLS)) * float(shape.charts.size.max())


def _gather(hits: NDArray[np.int32], leaving: Light) -> Light:
    """Return the mean over rays of the light that cells reflect, shape (n, k)."""
    total = np.zeros((hits.shape[1], leaving.shape[1]), np.float32)
    for row in hits:
        total += leaving[row]
    return total / np.float32(len(hits))


def _rest(added: Light, last: Light) -> Light:
    """Return all further reflections relative to the last, as a geometric series, shape (k,)."""
    share = np.clip(added.sum(axis=0) / np.maximum(last.sum(axis=0), 1e-6), 0.0, MAX_SHARE)
    return np.asarray(share / (1.0 - share), dtype=np.float32)


def _joined(parts: list[Gathered]) -> Gathered:
    """Return parts as one; the list is emptied meanwhile, so that little is in memory twice."""
    sky, behind = (
        np.concatenate([np.zeros(0, np.float32), *(getattr(part, name) for part in parts)]) for name in SHARES
    )
    hits = np.empty((len(parts[0].hits) if parts else 1, len(sky)), np.int32)
    first = 0
    for part in iter(lambda: parts.pop(0) if parts else None, None):
        hits[:, first : first + part.hits.shape[1]] = part.hits
        first += part.hits.shape[1]
    return Gathered(hits, sky, behind)


def rounded(light: Light) -> NDArray[np.float16]:
    """Return light with 7 of the 10 bits of its fractions, which is finer than a picture and compresses better."""
    bits = (np.clip(light, -6e4, 6e4).astype(np.float16).view(np.uint16) + np.uint16(4)) & np.uint16(0xFFF8)
    return bits.view(np.float16)


def surfaces_of(shape: Atlas) -> tuple[LitSurface, ...]:
    """Return the static surfaces with their coordinates on the light map."""
    found, first = [], 0
    size = np.array(shape.charts.shape[::-1])
    for solid in shape.solids:
        charts = shape.charts.of[first : first + len(solid.triangles)]
        first += len(solid.triangles)
        kept = charts >= 0
        if solid.moves or not kept.any():
            continue
        pairs = np.stack([charts[kept].repeat(3), solid.triangles[kept].ravel().astype(np.int64)], axis=1)
        unique, corner = np.unique(pairs, axis=0, return_inverse=True)
        points = solid.points[unique[:, 1]]
        found.append(
            LitSurface(
                solid.geom,
                points,
                solid.normals[unique[:, 1]],
                None if solid.texcoords is None else solid.texcoords[unique[:, 1]],
                (shape.charts.on_atlas(points, unique[:, 0]) / size).astype(np.float32),
                corner.reshape(-1, 3).astype(np.int32),
            )
        )
    return tuple(found)
