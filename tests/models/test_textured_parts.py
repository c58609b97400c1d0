"""Textures in files of models: of any kind of picture, and in metres on boxes and cylinders."""

import cv2
import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.world import load_world

CRATE = """<mujoco><asset><texture name="t" type="2d" file="{name}"/>
<material name="m" texture="t" {keys}/></asset><worldbody><body>
<geom type="{kind}" size="0.3 0.2 0.1" material="m" mass="2"/>
<geom type="box" size="0.1 0.1 0.1" pos="0.7 0 0" rgba="1 0 0 1" mass="1"/></body></worldbody></mujoco>"""


def compiled(folder, *, name: str = "grey.png", keys: str = "", kind: str = "box"):
    picture = np.full((8, 8, 3), (60, 120, 180), dtype=np.uint8)
    cv2.imwrite(str(folder / name), picture[..., ::-1])
    (folder / "crate.xml").write_text(CRATE.format(name=name, keys=keys, kind=kind))
    (folder / "world.yaml").write_text(
        "mjsim: 1\nobstacles: [{name: crate, model: crate.xml, at: [2, 0], scale: 0.5}]\n"
        "robots: [{name: scout, at: [0, 0]}]\n"
    )
    return compile_world(load_world(folder / "world.yaml"))


@pytest.mark.parametrize("name", ["grey.png", "grey.jpg"])
def test_a_texture_of_a_model_is_a_png_or_a_jpeg(tmp_path, name):
    model = compiled(tmp_path, name=name).compile()
    np.testing.assert_allclose(model.tex_data.reshape(-1, 3).mean(axis=0), (60, 120, 180), atol=2)


@pytest.mark.parametrize("kind", ["box", "cylinder"])
def test_a_texture_repeated_in_units_of_the_file_is_in_metres_on_every_side(tmp_path, kind):
    spec = compiled(tmp_path, keys='texuniform="true" texrepeat="4 4"', kind=kind)
    (mesh,) = (mesh for mesh in spec.meshes if ":cover" in mesh.name)
    points, places = np.reshape(mesh.uservert, (-1, 3)), np.reshape(mesh.usertexcoord, (-1, 2))
    triangles = np.reshape(mesh.userface, (-1, 3))
    # Four tiles a unit of the file, which is half a metre here.
    for start, end in ((0, 1), (1, 2), (2, 0)):
        along = np.linalg.norm(points[triangles[:, start]] - points[triangles[:, end]], axis=1)
        seen = np.linalg.norm(places[triangles[:, start]] - places[triangles[:, end]], axis=1)
        np.testing.assert_allclose(seen / 8.0, along, atol=1e-6)


def test_lidars_meet_the_shape_of_a_textured_part_in_the_mean_colour_of_its_texture(tmp_path):
    model = compiled(tmp_path, keys='texuniform="true" texrepeat="4 4"').compile()
    boxes = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_BOX)
    solid = [box for box in boxes if model.geom_contype[box] and model.geom_group[box] == 3]
    assert len(solid) == 1
    np.testing.assert_allclose(model.geom_rgba[solid[0], :3], np.array([60, 120, 180]) / 255, atol=0.01)
    assert model.geom_size[solid[0]] == pytest.approx([0.15, 0.1, 0.05])


def test_a_texture_that_a_file_stretches_over_a_part_stays_so(tmp_path):
    spec = compiled(tmp_path)
    assert not any(":cover" in mesh.name for mesh in spec.meshes)
