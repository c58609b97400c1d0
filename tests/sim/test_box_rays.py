"""Rays against a box, held to MuJoCo's own."""

import mujoco
import numpy as np

from mjsim.sim.rays.batch_rays import box_hits


def test_rays_meet_a_box_where_mujoco_has_it_and_at_the_angle_of_its_face():
    rng, half = np.random.default_rng(7), np.array([0.5, 0.2, 0.8])
    directions = rng.normal(size=(150, 3))
    directions[:6] = np.vstack([np.eye(3), -np.eye(3)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    hits = 0
    for start in np.vstack([rng.uniform(-2.0, 2.0, (20, 3)), [1.0, 0.1, 0.3], [0.2, -1.0, 0.79], [0.0, 0.0, 3.0]]):
        if (np.abs(start) < half).all():
            continue
        distances, facing = box_hits(start, directions, half)
        for direction, distance, cosine in zip(directions, distances, facing, strict=True):
            kind, normal = mujoco.mjtGeom.mjGEOM_BOX, np.zeros(3)
            expected = mujoco.mju_rayGeom(np.zeros(3), np.eye(3).ravel(), half, start, direction, kind, normal)
            assert np.isfinite(distance) == (expected >= 0.0)
            if expected >= 0.0:
                hits += 1
                assert abs(distance - expected) < 1e-9
                assert abs(cosine - abs(normal @ direction)) < 1e-9
    assert hits > 100


def test_from_inside_a_box_is_met_at_once():
    distances, _ = box_hits(np.array([0.1, 0.1, 0.2]), np.eye(3), np.array([0.5, 0.2, 0.8]))
    assert distances.tolist() == [0.0, 0.0, 0.0]
