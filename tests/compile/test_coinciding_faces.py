"""No two faces that are seen from the same side coincide: which of them a picture shows would change with its place."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from shapely import STRtree, area, intersection, length, polygons

from mjsim.compile import compile_world, rgba_of, texture_of, triangles_of
from mjsim.sim.rendering.merged import visible_parts
from mjsim.sim.rendering.renderer import SEEN_FROM_OUTSIDE
from mjsim.world import load_world, parse_world

WORLDS = Path(__file__).parents[2] / "worlds"
NEAR = 2e-5
"""Distance of faces that a depth of single precision no longer separates in a large hall [m]."""
MIN_AREA, MIN_WIDTH = 1e-6, 1e-4
"""Smaller overlaps are not seen [m^2], [m]."""
TWO_BOXES = """
mjsim: 1
obstacles:
  - {{name: low, box: [1, 0.6, 0.4], at: [0, 0], color: "#884422"}}
  - {{name: high, box: [0.2, {width}, 0.8], at: [0.3, 0], color: "#224488"}}
"""


def faces(model):
    """Return the opaque triangles that cameras see, shape (n, 3, 3) [m], and the geom of each."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points, geoms = [np.zeros((0, 3, 3))], []
    for geom in visible_parts(model, SEEN_FROM_OUTSIDE).tolist():
        shape = triangles_of(model, geom) if rgba_of(model, geom)[3] == 1.0 else None
        if shape is not None:
            p_world = shape.points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
            points.append(p_world[shape.corners])
            geoms += [geom] * len(shape.corners)
    return np.concatenate(points), np.array(geoms, dtype=int)


def coinciding(model):
    """Return the names of geoms of different looks with faces in one plane that overlap."""
    points, geoms = faces(model)
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    points, geoms, normals = (each[doubled > MIN_AREA / 5] for each in (points, geoms, normals))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    # What stands on the floor shows it no face.
    below = (normals[:, 2] < -0.99) & (points[..., 2].max(axis=1) < NEAR)
    points, geoms, normals = (each[~below] for each in (points, geoms, normals))
    looks = looks_of(model, geoms)
    _, direction = np.unique(np.round(normals * 200).astype(int), axis=0, return_inverse=True)
    return {
        pair
        for together in of_several_looks(np.argsort(direction, kind="stable"), direction, looks, 0.5)
        for plane in in_one_plane(together, points, normals, looks)
        for pair in overlapping(model, points[plane], geoms[plane], looks[plane], normals[plane[0]])
    }


def looks_of(model, geoms):
    """Return a number for the look of each face: plain ones of one colour are alike, each textured geom is not."""
    numbers = {geom: (geom,) if texture_of(model, geom) >= 0 else rgba_of(model, geom) for geom in set(geoms.tolist())}
    known = {look: number for number, look in enumerate(dict.fromkeys(map(tuple, numbers.values())))}
    return np.array([known[tuple(numbers[geom])] for geom in geoms.tolist()], dtype=int)


def of_several_looks(faces, values, looks, apart):
    """Return sets of faces, sorted by their values, that lie no farther apart and do not all look alike."""
    if not len(faces):
        return []
    starts = np.append(0, np.flatnonzero(np.diff(values[faces]) > apart) + 1)
    several = np.minimum.reduceat(looks[faces], starts) < np.maximum.reduceat(looks[faces], starts)
    ends = np.append(starts[1:], len(faces))
    return [faces[a:b] for a, b in zip(starts[several].tolist(), ends[several].tolist(), strict=True)]


def in_one_plane(together, points, normals, looks):
    """Return sets of parallel faces whose planes are the same."""
    normal = normals[together[0]]
    together = together[normals[together] @ normal > 1.0 - 1e-6]
    far = points[together].mean(axis=1) @ normal
    order = np.argsort(far)
    return [
        together[order[k]] for k in of_several_looks(np.arange(len(order)), far[order], looks[together][order], NEAR)
    ]


def overlapping(model, points, geoms, looks, normal):
    """Return pairs of names of geoms whose faces in a plane overlap."""
    right = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    right /= np.linalg.norm(right)
    flat = polygons(points @ np.stack([right, np.cross(normal, right)], axis=1))
    pairs = STRtree(flat).query(flat, predicate="intersects").T
    pairs = pairs[(geoms[pairs[:, 0]] < geoms[pairs[:, 1]]) & (looks[pairs[:, 0]] != looks[pairs[:, 1]])]
    one, other = flat[pairs.T]
    both = intersection(one, other)
    seen = (area(both) > MIN_AREA) & (area(both) > MIN_WIDTH * length(both))
    for pair in np.unique(geoms[pairs[seen]], axis=0):
        yield tuple(label(model, int(geom)) for geom in pair)


def label(model, geom):
    return model.geom(geom).name or f"{model.body(model.geom_bodyid[geom]).name}/{geom}"


def test_flush_sides_of_two_boxes_are_found():
    flush, narrower = (compile_world(parse_world(TWO_BOXES.format(width=width))).compile() for width in (0.6, 0.58))
    assert coinciding(flush) == {("obstacle/low", "obstacle/high")}
    assert not coinciding(narrower)


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(WORLDS.rglob("*.yaml")), ids=lambda path: path.stem)
def test_no_faces_of_shipped_worlds_and_robots_coincide(path):
    assert not coinciding(compile_world(load_world(path)).compile())


def test_every_shipped_robot_arm_and_thing_is_in_one_of_these_worlds():
    written = "".join(path.read_text() for path in WORLDS.rglob("*.yaml"))
    assets = WORLDS.parent / "assets"
    presets = [path.stem for kind in ("robots", "arms") for path in (assets / kind).glob("*.yaml")]
    models = [
        f"{path.parent.name}/{path.name}" for kind in ("furniture", "workplaces") for path in models_in(assets / kind)
    ]
    assert len(presets) > 12
    assert len(models) > 8
    assert not [name for name in presets + models if name not in written]


def models_in(folder):
    return [path for path in folder.iterdir() if path.suffix in (".xml", ".urdf")]
