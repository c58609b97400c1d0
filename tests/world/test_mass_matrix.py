"""The mass matrix of mechanisms, which finds joints that move nothing and springs too stiff, against MuJoCo."""

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.world import parse_world
from mjsim.world.items import mass_matrix

WORLD = """
mjsim: 1
mechanisms:
  - name: m
    at: [1, 2]
    heading_deg: 30
    elevation: 3
    bodies:
      - {name: a, box: [0.3, 0.2, 0.1], mass: 2, center: [0.1, 0.2, -0.1], inertia: [0.3, 0.4, 0.5, 0.05, -0.04, 0.03]}
      - {name: b, rod: [0.7, 0.05], mass: 1, inertia: [0.2, 0.3, 0.4, 0.01, 0.02, 0.03]}
      - {name: c, sphere: 0.1, mass: 3, center: [0, 0.3, 0], inertia: [0.3, 0.4, 0.5, 0.05, -0.04, 0.03]}
    joints:
      - {revolute: p, of: [ground, a], axis: [0.6, 0, 0.8], start_deg: 40}
      - {prismatic: q, of: [{a: [0.2, 0.1, 0]}, b], axis: [0, 0.6, 0.8], start: 0.3}
      - {revolute: r, of: [b.end, c], axis: [0.8, 0.6, 0], start_deg: -70}
"""


def test_the_mass_matrix_of_a_tree_is_that_of_mujoco_in_every_position():
    world = parse_world(WORLD)
    (mechanism,) = world.mechanisms
    model = compile_world(world).compile()
    data, rng = mujoco.MjData(model), np.random.default_rng(2)
    addresses = [model.joint(f"m/{name}").qposadr[0] for name in "pqr"]
    for _ in range(5):
        values = rng.uniform(-1.0, 1.0, 3)
        data.qpos[addresses] = values
        mujoco.mj_forward(model, data)
        expected = np.zeros((3, 3))
        mujoco.mj_fullM(model, data, expected)
        found = mass_matrix(mechanism, mechanism.assembly, values)
        assert found == pytest.approx(expected - np.diag(model.dof_armature), abs=1e-9)
