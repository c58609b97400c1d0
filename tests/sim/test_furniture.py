"""Furniture merged by room and look: fewer geoms in a picture, and everything else as with each part by itself."""

from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world, export_scene, merged_into
from mjsim.sim import Canvas, Merged, Renderer, Simulation, glb_bytes
from mjsim.sim.rendering.instances import instances_of
from mjsim.world import Source, parse_world

ASSETS = Path(__file__).parents[2] / "assets"
WIDTH, HEIGHT = 96, 72
ROOMS = """
mjsim: 1
walls:
  - {points: [[0, 0], [8, 0], [8, 5], [0, 5]], closed: true}
  - {points: [[4, 0], [4, 5]], openings: [{at: 2, width: 1}]}
obstacles:
  - {name: desk, model: furniture/table.xml, at: [2.6, 2.9]}
  - {name: swivel, model: furniture/office_chair.xml, at: [2.6, 2.2], heading_deg: 60}
  - {name: books, model: furniture/shelf.urdf, at: [3.5, 1.0], heading_deg: 90}
  - {name: crate, box: [0.4, 0.3, 0.5], at: [2.2, 1.9], heading_deg: 20, color: "#cc4422"}
  - {name: tree, model: furniture/plant.xml, at: [7, 4]}
  - {name: loose, model: furniture/chair.xml, at: [6, 1], movable: true}
robots:
  - name: scout
    at: [0.8, 2.5]
    sensors: [{camera: front, at: [0.1, 0, 0.8], noise: 0}, {lidar: scan, at: [0.1, 0, 0.3], beams: 90, fov_deg: 270}]
"""


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return compile_world(parse_world(ROOMS)).compile()


def test_a_part_whose_place_cannot_be_computed_is_left_to_mujoco(tmp_path):
    parts = "".join(f'<geom size="0.1" pos="0 0 {k}" quat="1 {turn} 0 0"/>' for k, turn in enumerate([0, 1, "1e308"]))
    (tmp_path / "odd.xml").write_text(f"<mujoco><worldbody>{parts}</worldbody></mujoco>")
    text = "mjsim: 1\nobstacles: [{name: odd, model: odd.xml, at: [1, 1], movable: true}]\n"
    model = compile_world(parse_world(text, source=Source(folder=tmp_path))).compile()
    assert np.isfinite(model.mesh_vert).all()


@pytest.fixture(scope="module")
def canvas(model: mujoco.MjModel) -> Iterator[Canvas]:
    canvas = Canvas(model)
    yield canvas
    canvas.close()


@pytest.fixture
def apart(model: mujoco.MjModel) -> Iterator[mujoco.MjModel]:
    """The same scene with every part drawn by itself."""
    groups = model.geom_group.copy()
    merged = Merged(model)
    merged.take_out(merged.parts)
    yield model
    model.geom_group[:] = groups


def seen_from(model: mujoco.MjModel, canvas: Canvas) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Return picture, segmentation and depth from the robot, and the number of geoms in the picture."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer = Renderer(model, width=WIDTH, height=HEIGHT, canvas=canvas)
    picture = renderer.render(data, "scout/front").astype(int)
    drawn = renderer.drawn
    return picture, renderer.segment(data, "scout/front"), renderer.depth(data, "scout/front"), drawn


@pytest.fixture(scope="module")
def whole(model: mujoco.MjModel, canvas: Canvas) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    return seen_from(model, canvas)


@pytest.mark.slow
def test_a_merged_room_looks_as_its_parts_do(apart: mujoco.MjModel, canvas: Canvas, whole):
    picture, _, depth, drawn = seen_from(apart, canvas)
    assert whole[3] <= drawn / 2
    # Pixels at edges of round parts, which have other facets, may differ.
    assert (np.abs(picture - whole[0]).max(axis=2) > 2).mean() < 0.01
    finite = np.isfinite(depth) & np.isfinite(whole[2])
    error = np.abs(depth[finite] - whole[2][finite])
    assert (error < 1e-5).mean() > 0.98


def test_segmentation_is_that_of_the_parts(apart: mujoco.MjModel, canvas: Canvas, whole):
    segmentation = seen_from(apart, canvas)[1]
    np.testing.assert_array_equal(whole[1], segmentation)
    instances, names = instances_of(apart)
    assert {"obstacle/desk", "obstacle/swivel", "obstacle/books", "obstacle/crate"} <= {
        names[instance] for instance in np.unique(instances[segmentation[segmentation >= 0]])
    }
    assert not any("seen" in name for name in names)


@pytest.mark.slow
def test_lidars_meet_the_parts_whether_they_are_merged_or_not():
    with Simulation(parse_world(ROOMS)) as sim, Simulation(parse_world(ROOMS)) as other:
        merged = Merged(other.model)
        assert len(merged.parts)
        merged.take_out(merged.parts)
        one, two = (each.sense("scout").scans["scan"].ranges for each in (sim, other))
    np.testing.assert_array_equal(one, two)


@pytest.mark.slow
def test_a_removed_object_leaves_the_picture_and_the_rest_of_its_mesh_stays(model: mujoco.MjModel):
    def picture(world: str, *removed: str) -> np.ndarray:
        with Simulation(parse_world(world)) as sim:
            for name in removed:
                sim.remove(name)
            return np.asarray(sim.sense("scout").cameras["front"].image).astype(int)

    without = "\n".join(line for line in ROOMS.splitlines() if "name: desk" not in line)
    world = ROOMS.replace("camera: front", "camera: front, width: 96, height: 72")
    gone = picture(world, "desk")
    never = picture(without.replace("camera: front", "camera: front, width: 96, height: 72"))
    assert (np.abs(gone - never).max(axis=2) > 2).mean() < 0.01
    assert (np.abs(gone - picture(world)).max(axis=2) > 2).mean() > 0.03


def test_a_mesh_joins_parts_of_one_room_or_of_one_moving_body(model: mujoco.MjModel):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mesh_of = merged_into(model)
    for number in range(1, int(mesh_of.max()) + 1):
        (mesh,) = np.flatnonzero(mesh_of == -number)
        parts = np.flatnonzero(mesh_of == number)
        assert len({data.geom_xpos[part, 0] > 4.0 for part in parts}) == 1
        assert len({tuple(model.geom_rgba[part]) for part in parts}) == 1
        assert model.geom_group[mesh] == 1
        assert {int(model.body_weldid[model.geom_bodyid[part]]) for part in parts} == {int(model.geom_bodyid[mesh])}


def test_a_movable_object_weighs_what_its_file_says(model: mujoco.MjModel):
    alone = mujoco.MjModel.from_xml_path(str(ASSETS / "furniture/chair.xml"))
    assert model.body("obstacle/loose").subtreemass == pytest.approx(alone.body("chair").mass[0])


def test_a_view_in_three_dimensions_names_each_object(model: mujoco.MjModel):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    said = glb_bytes(model, data)
    for name in (b"obstacle/desk", b"obstacle/swivel", b"obstacle/books", b"obstacle/crate"):
        assert name in said
    assert b"obstacle/seen" not in said


@pytest.mark.slow
def test_an_exported_scene_draws_each_part_once(tmp_path):
    path = export_scene(parse_world(ROOMS), tmp_path / "scene")
    exported, mine = mujoco.MjModel.from_xml_path(str(path)), compile_world(parse_world(ROOMS)).compile()
    np.testing.assert_array_equal(merged_into(exported), merged_into(mine))
    np.testing.assert_array_equal(exported.geom_group, mine.geom_group)


@pytest.mark.slow
def test_the_same_world_compiles_to_the_same_file_twice():
    one, two = (compile_world(parse_world(ROOMS)) for _ in range(2))
    for spec in (one, two):
        spec.compile()
    assert one.to_xml() == two.to_xml()


def test_what_is_merged_lies_within_its_parts_and_reaches_all_of_them(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    meshes = merged_into(model)
    assert (meshes < 0).sum() > 3
    for number in np.flatnonzero(meshes < 0):
        mesh = model.geom_dataid[number]
        own = slice(model.mesh_vertadr[mesh], model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh])
        points = model.mesh_vert[own] @ data.geom_xmat[number].reshape(3, 3).T + data.geom_xpos[number]
        parts = np.flatnonzero(meshes == -meshes[number])
        turned = data.geom_xmat[parts].reshape(-1, 3, 3)
        middles = data.geom_xpos[parts] + np.einsum("nij,nj->ni", turned, model.geom_aabb[parts, :3])
        halves = np.einsum("nij,nj->ni", np.abs(turned), model.geom_aabb[parts, 3:]) + 1e-4
        inside = (np.abs(points[:, None] - middles) <= halves).all(axis=2)
        assert inside.any(axis=1).all()
        assert inside.any(axis=0).all()
