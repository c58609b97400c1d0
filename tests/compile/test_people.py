"""People in scenes: where their bodies are, what they weigh, and what meets them."""

import math

import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.compile import compile_world

WORLD = """mjsim: 1
people:
  - {name: anna, sex: female, percentile: 5, at: [2, 1], heading_deg: 180, joints_deg: {left_shoulder_flexion: 60}}
robots: [{name: r1, at: [0, 1]}]
"""


@pytest.fixture(scope="module")
def scene():
    world = mjsim.parse_world(WORLD)
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return world.people[0], model, data


def test_bodies_are_where_the_figure_has_its_segments(scene):
    person, _, data = scene
    for name, pose in person.poses().items():
        body = data.body(f"anna/{name}")
        np.testing.assert_allclose(body.xpos, pose[:3, 3], atol=1e-9)
        np.testing.assert_allclose(body.xmat.reshape(3, 3), pose[:3, :3], atol=1e-9)


def test_bodies_have_masses_and_inertias_of_the_segments(scene):
    person, model, _ = scene
    for name, segment in person.figure.segments.items():
        body = model.body(f"anna/{name}")
        assert body.mass[0] == pytest.approx(segment.solid.mass)
        np.testing.assert_allclose(body.ipos, segment.solid.center, atol=1e-12)
        np.testing.assert_allclose(body.inertia, segment.solid.inertia[:3])
        assert body.iquat[0] == pytest.approx(1.0)
    assert model.body("anna/pelvis").subtreemass[0] == pytest.approx(person.figure.measures["weight"])


def test_hands_and_eyes_are_where_the_figure_has_them(scene):
    person, _, data = scene
    spots = person.figure.spots(person.poses())
    for name in ("left_thumb_tip", "right_grip", "left_fingertip"):
        np.testing.assert_allclose(data.site(f"anna/{name}").xpos, spots[name], atol=1e-9)
    for name in ("left_eye", "right_eye"):
        camera = data.camera(f"anna/{name}")
        np.testing.assert_allclose(camera.xpos, spots[name], atol=1e-9)
        np.testing.assert_allclose(-camera.xmat.reshape(3, 3)[:, 2], [-1.0, 0.0, 0.0], atol=1e-9)


def test_a_ray_meets_the_chest_where_the_figure_has_it(scene):
    person, model, data = scene
    chest = person.figure.spots(person.poses())["chest_front"]
    met, seen = np.zeros(1, dtype=np.int32), np.array([1, 0, 0, 1, 0, 0], dtype=np.uint8)
    start = np.array([0.5, chest[1], chest[2]])
    distance = mujoco.mj_ray(model, data, start, np.array([1.0, 0.0, 0.0]), seen, True, -1, met, None)
    assert model.geom(met[0]).name == "anna/thorax"
    # Rings of the mesh lie a little apart from the height of the landmark.
    assert distance == pytest.approx(chest[0] - 0.5, abs=0.002)


def test_the_neck_leads_from_the_collar_to_below_the_skull(scene):
    figure, skins = scene[0].figure, scene[0].skins
    top, (neck,) = np.array(figure.segments["head"].at), skins["neck"]
    near = np.abs(neck.vertices[:, 2] - 0.95 * top[2]) < 0.02
    middle = (neck.vertices[near, 0].max() + neck.vertices[near, 0].min()) / 2
    assert middle == pytest.approx(0.95 * top[0], abs=0.01)
    low = neck.vertices[neck.vertices[:, 2] < 0.0]
    assert 0.0 < (low[:, 0].max() + low[:, 0].min()) / 2 < top[0]


def test_surfaces_are_closed_and_as_large_as_the_measures(scene):
    person, _, _ = scene
    figure = person.figure
    poses, skins = figure.poses(), person.skins
    points = {
        name: np.concatenate([mesh.vertices for mesh in meshes]) + poses[name][:3, 3] for name, meshes in skins.items()
    }
    for meshes in skins.values():
        for mesh in meshes:
            edges = np.sort(np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]))
            _, counts = np.unique(edges, axis=0, return_counts=True)
            assert (counts == 2).all()
            assert mesh.volume() > 0
    every, m = np.concatenate(list(points.values())), figure.measures
    assert every[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert every[:, 2].max() == pytest.approx(m["stature"], abs=1e-6)
    assert np.ptp(points["head"][:, 0]) == pytest.approx(m["head_length"], abs=1e-3)
    assert np.ptp(points["head"][:, 1]) == pytest.approx(m["head_breadth"], abs=1e-3)
    assert np.ptp(points["thorax"][:, 0]) == pytest.approx(m["chest_depth"], abs=1e-3)
    assert np.ptp(points["left_foot"][:, 0]) == pytest.approx(m["foot_length"], abs=1e-3)
    arms = np.concatenate([points["left_upper_arm"], points["right_upper_arm"]])
    assert np.ptp(arms[:, 1]) == pytest.approx(m["bideltoid_breadth"], abs=1e-3)


def test_limbs_have_the_volume_that_their_mass_takes(scene):
    figure, skins = scene[0].figure, scene[0].skins
    for name in ("left_upper_arm", "left_forearm", "left_thigh", "left_shank"):
        volume = sum(mesh.volume() for mesh in skins[name])
        assert figure.segments[name].solid.mass / volume == pytest.approx(1050.0, rel=0.01)


@pytest.mark.slow
def test_a_robot_that_drives_into_a_person_bumps_and_the_person_stays():
    text = WORLD.replace("joints_deg: {left_shoulder_flexion: 60}", "percentile: 50").replace("percentile: 5, ", "")
    with mjsim.Simulation(mjsim.parse_world(text), seed=1) as sim:
        before = sim.data.body("anna/head").xpos.copy()
        bumped = False
        for _ in range(150):
            seen = sim.sense("r1")
            bumped = bumped or bool(seen.bump)
            sim.apply("r1", mjsim.Command(forward=0.5))
            sim.step()
        assert bumped
        assert math.isclose(sim.truth("r1").x, 1.7, abs_tol=0.2)
        np.testing.assert_array_equal(sim.data.body("anna/head").xpos, before)
