"""Obstacles with a texture: cameras see it in metres on every side, everything else is as without."""

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.sim import Simulation
from mjsim.sim.rendering.instances import instances_of
from mjsim.world import parse_world

SHAPES = {
    "box": "box: [0.83, 0.47, 0.61]",
    "cylinder": "cylinder: [0.35, 0.9]",
    "ramp": "ramp: [1.2, 0.8, 0.3]",
    "steps": "steps: [0.9, 0.7, 0.45]",
}
TEXTURE = "texture: materials/wood.jpg, tile: 0.7"


def world_with(shape: str, keys: str, more: str = ""):
    return parse_world(
        f"mjsim: 1\nobstacles:\n  - {{name: thing, {shape}, at: [2, 0], heading_deg: 30, {keys}}}\n"
        f"robots: [{{name: scout, at: [0, 0], sensors: [{{lidar: scan, at: [0, 0, 0.2], beams: 90}}]}}]\n{more}"
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_a_metre_of_a_thing_is_a_metre_of_texture_on_every_side(shape):
    (mesh,) = (mesh for mesh in compile_world(world_with(SHAPES[shape], TEXTURE)).meshes if ":cover" in mesh.name)
    points, places = np.reshape(mesh.uservert, (-1, 3)), 0.7 * np.reshape(mesh.usertexcoord, (-1, 2))
    triangles = np.reshape(mesh.userface, (-1, 3))
    for start, end in ((0, 1), (1, 2), (2, 0)):
        along = np.linalg.norm(points[triangles[:, start]] - points[triangles[:, end]], axis=1)
        seen = np.linalg.norm(places[triangles[:, start]] - places[triangles[:, end]], axis=1)
        np.testing.assert_allclose(seen, along, atol=1e-6)


@pytest.mark.parametrize("shape", ["box", "cylinder"])
def test_a_texture_runs_on_round_all_upright_edges_but_one(shape):
    (mesh,) = (mesh for mesh in compile_world(world_with(SHAPES[shape], TEXTURE)).meshes if ":cover" in mesh.name)
    points, places = np.reshape(mesh.uservert, (-1, 3)), np.reshape(mesh.usertexcoord, (-1, 2))
    triangles = np.reshape(mesh.userface, (-1, 3))
    flat = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    )
    upright = triangles[np.abs(flat[:, 2]) < 1e-9].ravel()
    _, edge = np.unique(np.round(points[upright, :2], 6), axis=0, return_inverse=True)
    broken = [np.ptp(places[upright[edge == each], 0]) > 1e-6 for each in range(edge.max() + 1)]
    assert sum(broken) == 1


@pytest.mark.parametrize("shape", SHAPES)
def test_lidars_and_physics_take_a_thing_with_a_texture_as_one_without(shape):
    keys = "" if shape in {"ramp", "steps"} else "movable: true, mass: 3"
    scans, states = [], []
    for texture in (f"{TEXTURE}, {keys}", keys):
        with Simulation(world_with(SHAPES[shape], texture)) as sim:
            for _ in range(2):
                sim.step()
            scans.append(sim.sense("scout").scans["scan"].ranges)
            states.append(sim.state()[0])
    np.testing.assert_array_equal(*scans)
    np.testing.assert_array_equal(*states)
    assert np.isfinite(scans[0]).any()


def test_a_removed_thing_takes_its_texture_along():
    with Simulation(world_with(SHAPES["box"], TEXTURE)) as sim:
        seen = sim.model.geom("obstacle/thing/seen").id
        assert sim.model.geom_group[seen] == 1
        sim.remove("thing")
        assert sim.model.geom_group[seen] > 3


def test_a_texture_is_of_the_instance_of_its_thing():
    model = compile_world(world_with(SHAPES["steps"], TEXTURE)).compile()
    instances, names = instances_of(model)
    assert {names[instances[geom]] for geom in range(model.ngeom) if "thing" in model.geom(geom).name} == {
        "obstacle/thing"
    }


def test_equal_things_share_mesh_and_texture_and_each_has_its_colour():
    text = "mjsim: 1\nobstacles:\n" + "".join(
        f"  - {{box: [0.5, 0.4, 0.3], at: [{2 * k}, 2], color: '{color}', {TEXTURE}}}\n"
        for k, color in enumerate(("#8a6f4d", "#40c080", "#4080c0"))
    )
    model = compile_world(parse_world(text + "robots: [{name: scout, at: [0, 0]}]\n")).compile()
    assert (model.nmesh, model.ntex) == (1, 1)
    seen = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    tints = (np.round(model.geom_rgba[seen, :3] * 255)).astype(int).tolist()
    assert tints == [[255, 255, 255], [64, 192, 128], [64, 128, 192]]
