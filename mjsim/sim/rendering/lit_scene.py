"""Draws a scene in its baked light: surfaces by our own display lists, moving things in the light at their position.

MuJoCo draws a mesh by calling the display list `baseMesh + dataid`. Geoms with a light map are therefore handed to it
as meshes with the number of a list of ours; its own lists, and all it draws by them, stay as they are.

Moving things get the light of the probes at their position. The drawn light map is the weighted sum of the maps of
groups of lights, encoded in 8 bits.
"""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import (
    DIRECTED,
    EVEN,
    MEAN_LIGHT,
    PICTURES,
    has_texcoords,
    is_flat,
    picture_glow,
    rgba_of,
    texture_of,
)
from mjsim.geometry import Array
from mjsim.light import GAMMA, BakedLight, LitSurface
from mjsim.sim.gl import GlCalls
from mjsim.sim.rendering.contact_shadows import shadows_of
from mjsim.sim.rendering.gl_light import GlLight
from mjsim.sim.rendering.gl_shadows import GlShadows
from mjsim.sim.rendering.in_view import frustum_of
from mjsim.sim.rendering.light_weights import LightWeights
from mjsim.sim.rendering.merged import UNSEEN
from mjsim.sim.rendering.merged_geoms import moving_bodies
from mjsim.sim.rendering.scene_geoms import as_bytes, geoms_of, mesh_geom

CAST = (0, 1, UNSEEN)
"""Geom groups of things that cast shadows, or did before they were removed."""
MESH, GEOM = int(mujoco.mjtGeom.mjGEOM_MESH), int(mujoco.mjtObj.mjOBJ_GEOM)


class LitScene:
    """The baked light of one model in one context; use it while the context is current."""

    def __init__(self, gl: GlCalls, mjr: mujoco.MjrContext, model: mujoco.MjModel, baked: BakedLight) -> None:
        """Copy the light to the graphics processor.

        Args:
            gl: Functions of the context.
            mjr: MuJoCo's resources in the context.
            model: The compiled world.
            baked: Its light.
        """
        self._mix, self._weights = LightMix(baked), LightWeights(model, baked)
        self._gl = GlLight(gl, width=self._mix.width, height=self._mix.height)
        self._lists = np.full(model.ngeom, -1, dtype=np.int32)
        self._pictured = np.zeros(model.ngeom, dtype=np.int32)
        self._apart = np.zeros(model.ngeom, dtype=bool)
        self._make_lists(mjr, model, [each for each in baked.surfaces if _may_be_listed(model, each.geom)])
        self._marks = [as_bytes(mesh_geom(each - mjr.baseMesh)) for each in (self._gl.enter, self._gl.leave)]
        self._moving = MovingLight(model, baked)
        self._factors, self._glow = _own_colors(model, lit=self._lists >= 0)
        shadows = shadows_of(model, np.flatnonzero((self._lists < 0) & np.isin(model.geom_group, CAST)))
        self._shadows = GlShadows(gl, self._gl, model, shadows) if shadows else None
        self._now: Array | None = None

    def draw(self, rect: mujoco.MjrRect, scene: mujoco.MjvScene, mjr: mujoco.MjrContext, data: mujoco.MjData) -> None:
        """Draw a scene that holds geoms of a state, no lights, and has room for two geoms more.

        Args:
            rect: Where in the buffer.
            scene: Its camera is up to date.
            mjr: MuJoCo's resources in the context.
            data: The state.
        """
        self._update(data)
        count = scene.ngeom
        self._prepare(scene, data)
        if scene.nlight != len(DIRECTED):
            light_moving_things(scene)
        mujoco.mjr_render(rect, scene, mjr)
        scene.ngeom = count
        if self._shadows is not None:
            self._shadows.draw(data, frustum_of(scene, width=rect.width, height=rect.height))

    def _update(self, data: mujoco.MjData) -> None:
        """Update to the light of a state."""
        weights = self._weights.of(data)
        if weights is self._now:
            return
        self._now = weights
        self._moving.set_weights(weights)
        changed = self._mix.changed(weights)
        if changed is not None:
            self._gl.upload(changed[1], changed[0])

    def _prepare(self, scene: mujoco.MjvScene, data: mujoco.MjData) -> None:
        """Exchange the geoms that have a light map, and color the others."""
        memory, count = geoms_of(scene), scene.ngeom
        geoms = memory[:count]
        own = geoms["objtype"] == GEOM
        ids = np.where(own, geoms["objid"], 0)
        lists = self._lists[ids]
        is_lit = own & (lists >= 0)
        lit = np.flatnonzero(is_lit)
        geoms["type"][lit] = MESH
        geoms["dataid"][lit] = lists[lit]
        geoms["texcoord"][lit] = self._pictured[ids[lit]]
        geoms["rgba"][:, :3] *= self._factors[ids]
        unlit = np.flatnonzero(~is_lit)
        if len(unlit):
            geoms["rgba"][unlit, :3] *= self._moving.factors(data, ids[unlit])
            glow = self._glow[ids]
            np.copyto(geoms["emission"], glow, where=glow >= 0.0)
        # Those with a light map come first, between the lists that switch it on and off.
        together = is_lit & ~self._apart[ids]
        rows = as_bytes(geoms)
        ordered = [self._marks[0], rows[together], self._marks[1], rows[~together]]
        as_bytes(memory)[: count + 2] = np.concatenate(ordered)
        scene.ngeom = count + 2

    def _make_lists(self, mjr: mujoco.MjrContext, model: mujoco.MjModel, surfaces: list[LitSurface]) -> None:
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        for surface in surfaces:
            geom, corners = surface.geom, surface.triangles.ravel()
            points = (surface.points - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
            self._pictured[geom] = pictured = has_texcoords(model, geom) and surface.texcoords is not None
            listed = self._gl.surface(
                points.astype(np.float32)[corners],
                surface.lightcoords[corners],
                np.asarray(surface.texcoords, dtype=np.float32)[corners] if pictured else None,
                # For planes, they are relative to the corner that MuJoCo chooses.
                scaled=not pictured or model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_PLANE,
            )
            # MuJoCo draws transparent geoms last.
            self._apart[geom] = clear = bool(rgba_of(model, geom)[3] < 1.0)
            self._lists[geom] = (self._gl.apart(listed) if clear else listed) - mjr.baseMesh
        self._gl.require_no_error("surfaces of a light map")


def light_moving_things(scene: mujoco.MjvScene) -> None:
    """Set the lights of a scene to even light and two lamps at infinity, as in full ambient light.

    The colours of geoms that move are multiplied by the light where they are.
    """
    scene.nlight = len(DIRECTED)
    for light, (_, towards, strength) in zip(scene.lights, DIRECTED, strict=False):
        light.id, light.type, light.headlight, light.castshadow = -1, mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, 0, 0
        light.dir[:] = -np.array(towards) / np.linalg.norm(towards)
        light.diffuse[:], light.ambient[:], light.specular[:] = strength, 0.0, 0.0
    scene.lights[0].ambient[:] = EVEN


def _may_be_listed(model: mujoco.MjModel, geom: int) -> bool:
    """Return whether a surface looks the same when drawn as a mesh: MuJoCo maps cube textures by its own shapes."""
    texture = texture_of(model, geom)
    return texture < 0 or is_flat(model, texture)


def _own_colors(model: mujoco.MjModel, *, lit: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the factor on the colour of each geom, shape (ngeom, 3), and its emission, -1 to keep it.

    Pictures on beacons glow and reflect little in plain light. With a light map they reflect all; on things that move
    they glow as in full ambient light.
    """
    factors, glow = np.ones((model.ngeom, 3)), np.full(model.ngeom, -1.0)
    for geom, material in enumerate(model.geom_matid.tolist()):
        if material >= 0 and model.mat(material).name.startswith(PICTURES):
            share = float(model.mat_rgba[material, 0])
            factors[geom] = 1.0 / share if lit[geom] else 1.0
            glow[geom] = picture_glow(1.0, share)
    return factors, glow


CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
"""Corners of a cell of a grid."""


class MovingLight:
    """Ambient colours of geoms without a light map: one for each body, from all directions."""

    def __init__(self, model: mujoco.MjModel, baked: BakedLight) -> None:
        """Find the place of each body by its largest geom."""
        self._baked = baked
        self._last = np.array(baked.probes.light.shape[1:4]) - 1
        _, ny, nz = self._last + 1
        self._steps = np.array([ny * nz, nz, 1])
        bodies = moving_bodies(model)[model.geom_bodyid]
        bodies = np.where(bodies > 0, bodies, model.body_rootid[model.geom_bodyid])
        by_size = np.lexsort([-model.geom_rbound, bodies])
        found, first = np.unique(bodies[by_size], return_index=True)
        largest = by_size[first][np.searchsorted(found, bodies)]
        # Parts of the building have the light of their own position.
        self._points = np.where(bodies > 0, largest, np.arange(model.ngeom))
        self._light = np.zeros((0, 3))

    def set_weights(self, weights: Array) -> None:
        """Take new weights of the groups, shape (groups, 3)."""
        total = np.einsum("gxyzc,gc->xyzc", self._baked.probes.light.astype(float), weights)
        self._light = total.reshape(-1, 3) * self._baked.exposure

    def factors(self, data: mujoco.MjData, geoms: NDArray[np.intp]) -> Array:
        """Return the factor on the colour that geoms have in full even light, shape (n, 3)."""
        probes = self._baked.probes
        where = np.clip((data.geom_xpos[self._points[geoms]] - probes.origin) / probes.spacing, 0.0, self._last)
        low = np.minimum(where.astype(np.intp), np.maximum(self._last - 1, 0))
        share = (where - low)[:, None]
        weights = np.where(CORNERS, share, 1.0 - share).prod(axis=2)
        places = np.minimum(low[:, None] + CORNERS, self._last) @ self._steps
        light = np.einsum("nk,nkc->nc", weights, self._light[places])
        return np.asarray(np.maximum(light, 0.0) ** (1.0 / GAMMA) / MEAN_LIGHT)


DITHER_SEED = 39
"""Seed of the noise that is added before values are rounded, so that smooth light has no steps."""


class LightMix:
    """Adds up the maps again when weights change; the result depends on the weights alone, to the last bit."""

    def __init__(self, baked: BakedLight) -> None:
        """Store the maps of the groups."""
        self._maps = [group.texels for group in baked.groups]
        self.height, self.width = self._maps[0].shape[:2]
        self._spans = [_rows(each) for each in self._maps]
        self._weights = np.full((len(self._maps), 3), np.nan)
        self._codes = _codes(baked.exposure)
        noise = np.random.default_rng(DITHER_SEED).integers(0, 256, (self.height, self.width, 1), dtype=np.uint16)
        self._noise: NDArray[np.uint16] = noise

    def changed(self, weights: Array) -> tuple[int, NDArray[np.uint8]] | None:
        """Return the rows that new weights change, encoded, with the number of the first; None if none change.

        Args:
            weights: Factor of each group, red, green and blue, shape (groups, 3).
        """
        different = np.flatnonzero((weights != self._weights).any(axis=1))
        everything = np.isnan(self._weights).any()
        self._weights = np.array(weights)
        spans = [self._spans[group] for group in different.tolist() if self._spans[group][1]]
        if everything:
            spans = [(0, self.height)]
        if not spans:
            return None
        first, last = min(span[0] for span in spans), max(span[1] for span in spans)
        return first, self._encoded(first, last)

    def _encoded(self, first: int, last: int) -> NDArray[np.uint8]:
        """Return rows of the map, shape (last - first, width, 3)."""
        light = np.zeros((last - first, self.width, 3), dtype=np.float32)
        for texels, (start, end), weight in zip(self._maps, self._spans, self._weights, strict=True):
            low, high = max(start, first), min(end, last)
            if low < high and weight.any():
                light[low - first : high - first] += texels[low:high] * weight.astype(np.float32)
        codes = self._codes[light.astype(np.float16).view(np.uint16)]
        codes += self._noise[first:last]
        codes >>= 8
        return codes.astype(np.uint8)


def _codes(exposure: float) -> NDArray[np.uint16]:
    """Return the value, in 256ths of a step of 8 bits, of light given as the bits of a half-precision number."""
    light = np.arange(1 << 16, dtype=np.uint16).view(np.float16).astype(np.float64)
    light = np.nan_to_num(light, nan=0.0, posinf=65504.0, neginf=0.0)
    values = np.clip(light * exposure, 0.0, 1.0) ** (1.0 / GAMMA)
    return np.rint(values * (255 * 256)).astype(np.uint16)


def _rows(texels: NDArray[np.float16]) -> tuple[int, int]:
    """Return the first row that is not dark, and the one after the last; 0 and 0 if all are."""
    lit = np.flatnonzero((texels != 0).any(axis=(1, 2)))
    return (int(lit[0]), int(lit[-1]) + 1) if len(lit) else (0, 0)
