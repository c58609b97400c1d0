"""Fans of rays meet what single rays meet, however the masses of a body lie."""

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.sim.rays.ray_fan import SOLID, Fan
from mjsim.world import parse_world

ROBOTS = {
    "an odd outline": "at: [1, 0], heading_deg: 20,"
    " body: {polygon: [[-0.3, -0.2], [0.9, 0.1], [0.9, 0.3], [-0.3, 0.1]], height: 0.6}",
    "an arm": "base: fixed, at: [1, 0], heading_deg: 90,"
    " arms: [{preset: puma560, start_deg: [20, 30, -130, 40, 50, 60]}]",
    "a plain one": "at: [1, 0], preset: husky",
}


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_fan_meets_what_each_of_its_rays_meets(robot):
    world = parse_world(
        f"mjsim: 1\nrobots: [{{name: r, {ROBOTS[robot]}}}]\nobstacles: [{{box: [6, 0.1, 2], at: [0, 3]}}]"
    )
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    angles, rng, found = np.linspace(-np.pi, np.pi, 180, endpoint=False), np.random.default_rng(0), set()
    rays = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
    fan, one = Fan(model, data, capacity=180), np.zeros(1, np.int32)
    for _ in range(20):
        start = np.array([*rng.uniform(-1.5, 1.5, 2), rng.uniform(0.1, 1.2)])
        fan.cast(start, rays, exclude=-1, limit=30.0)
        for ray, geom, distance in zip(rays, fan.geoms, fan.distances, strict=True):
            alone = mujoco.mj_ray(model, data, start, ray, SOLID, True, -1, one)
            assert (geom, distance if geom >= 0 else -1.0) == (one[0], pytest.approx(alone))
        found |= set(fan.geoms.tolist())
    assert len(found) >= 3
