"""Light maps made without rays, for tests: each static geom has one colour of light, given by a function."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from mjsim.compile import triangles_of
from mjsim.light import ALWAYS, BakedLight, LightGroup, LightProbes, LitSurface, linear

SIDE = 32
"""Texels along a side of the map."""


def static_geoms(model: mujoco.MjModel) -> list[int]:
    """Return the visible geoms that stand."""
    seen = np.isin(model.geom_group, (0, 1)) & (model.body_weldid[model.geom_bodyid] == 0)
    return np.flatnonzero(seen).tolist()


def evenly_lit(
    model: mujoco.MjModel,
    *groups: tuple[str, Callable[[int], Sequence[float]]],
    probes: LightProbes | None = None,
    exposure: float = 1.0,
) -> BakedLight:
    """Return light of groups, each a name and what it gives each geom, as values of pictures."""
    geoms = static_geoms(model)
    assert len(geoms) <= SIDE * SIDE
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    groups = groups or ((ALWAYS, lambda geom: (1.0, 1.0, 1.0)),)
    angle = np.pi / 2
    made = tuple(LightGroup(name, _texels(geoms, light), np.ones(3), angle=angle) for name, light in groups)
    light = np.ones((len(groups), 1, 1, 1, 3), dtype=np.float16)
    surfaces = tuple(_surface(model, data, geom, place) for place, geom in enumerate(geoms))
    return BakedLight(surfaces, made, probes or LightProbes(np.zeros(3), np.ones(3), light), exposure)


def _texels(geoms: list[int], light: Callable[[int], Sequence[float]]) -> np.ndarray:
    """Return a map with a texel for each geom."""
    texels = np.zeros((SIDE * SIDE, 3))
    for place, geom in enumerate(geoms):
        value = np.asarray(light(geom), dtype=float)
        texels[place] = np.sign(value) * linear(np.abs(value))
    return texels.reshape(SIDE, SIDE, 3).astype(np.float16)


def _surface(model: mujoco.MjModel, data: mujoco.MjData, geom: int, place: int) -> LitSurface:
    shape = triangles_of(model, geom)
    turned = data.geom_xmat[geom].reshape(3, 3)
    row, column = divmod(place, SIDE)
    at = np.array([column + 0.5, row + 0.5], dtype=np.float32) / SIDE
    points = shape.points @ turned.T + data.geom_xpos[geom]
    lightcoords = np.tile(at, (len(points), 1))
    return LitSurface(geom, points, shape.normals @ turned.T, shape.places, lightcoords, shape.corners.astype(np.int32))
