"""Bodies of mjsim's own robots: mass and moments by sums over small cells, parts that are only seen, lags of servos."""

import mujoco
import numpy as np
import pytest
import shapely

from mjsim.compile import compile_world
from mjsim.compile.geom_groups import DECOR
from mjsim.compile.mujoco_model import compiled
from mjsim.compile.robot_shapes import _outline_moments
from mjsim.world import parse_world

DRIVEN = """mjsim: 1
robots: [{{name: r, preset: {0}, at: [0, 0]}}]
"""
L_SHAPE = [[-0.3, -0.2], [0.3, -0.2], [0.3, 0.0], [0.0, 0.0], [0.0, 0.3], [-0.3, 0.3]]


def model_of(text: str) -> mujoco.MjModel:
    return compiled(compile_world(parse_world(text)))


@pytest.mark.parametrize("preset", ["pioneer3dx", "turtlebot3_burger", "husky", "f1tenth", "forklift", "robotino"])
def test_servos_of_each_drive_follow_with_their_lag_and_casters_touch_the_floor(preset):
    model = model_of(DRIVEN.format(preset))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for number in range(model.nu):
        if model.actuator_dyntype[number] == mujoco.mjtDyn.mjDYN_FILTEREXACT:
            assert model.actuator_dynprm[number, 0] == pytest.approx(0.05)
        assert model.actuator_gainprm[number, 0] > 0.0
    for number in range(model.ngeom):
        ball = model.geom_type[number] == mujoco.mjtGeom.mjGEOM_SPHERE and model.geom_contype[number]
        low = float(data.geom_xpos[number, 2] - model.geom_size[number, 0])
        if ball and low < 0.01:
            assert -1e-3 < low <= 1e-6


def test_moments_of_an_outline_are_sums_over_cells():
    class Body:
        def outline(self) -> np.ndarray:
            return np.array(L_SHAPE)

    (x, y), (xx, yy, xy) = _outline_moments(Body())
    step = 0.002
    places = np.meshgrid(np.arange(-0.3, 0.3, step), np.arange(-0.2, 0.3, step))
    grid = np.stack(places, axis=-1).reshape(-1, 2) + step / 2
    inside = grid[shapely.contains_xy(shapely.Polygon(L_SHAPE), *grid.T)]
    middle = inside.mean(axis=0)
    assert (x, y) == pytest.approx(tuple(middle), abs=1e-4)
    away = inside - middle
    assert (xx, yy, xy) == pytest.approx(
        (np.mean(away[:, 0] ** 2), np.mean(away[:, 1] ** 2), np.mean(away[:, 0] * away[:, 1])), abs=1e-4
    )


def test_parts_of_a_body_are_seen_and_touch_nothing():
    look = "{look: [{box: [0.1, 0.2, 0.3], at: [0, 0, 0.5], color: '#ff0000'}]}"
    model = model_of(DRIVEN.format("pioneer3dx").replace("at: [0, 0]", f"at: [0, 0], body: {look}"))
    (part,) = [k for k in range(model.ngeom) if np.allclose(model.geom_size[k], [0.05, 0.1, 0.15])]
    assert (model.geom_contype[part], model.geom_conaffinity[part], model.geom_group[part]) == (0, 0, DECOR)
    assert model.geom_rgba[part] == pytest.approx([1.0, 0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("shape", "middle", "half"),
    [
        ("box: [0.2, 0.3, 0.4]", (0.1, 0.2, 0.3), (0.15, 0.1, 0.2)),
        ("cylinder: [0.1, 0.4]", (0.1, 0.2, 0.3), (0.1, 0.1, 0.2)),
        ("sphere: 0.1", (0.1, 0.2, 0.3), (0.1, 0.1, 0.1)),
        ("rod: [0.8, 0.05]", (0.1, 0.6, 0.3), (0.05, 0.45, 0.05)),  # begins at its frame, and lies along x
    ],
)
def test_a_body_of_a_mechanism_fills_its_shape_turned_in_its_frame(shape, middle, half):
    model = model_of(
        f"""mjsim: 1
mechanisms:
  - name: m
    at: [0, 0]
    elevation: 2
    bodies: [{{name: b, {shape}, mass: 1, at: [0.1, 0.2, 0.3], rpy_deg: [0, 0, 90]}}]
    joints: [{{revolute: q, of: [ground, b], axis: [0, 1, 0]}}]
"""
    )
    (number,) = np.flatnonzero((model.geom_bodyid == model.body("m/b").id) & (model.geom_contype != 0))
    turned, (center, extent) = np.zeros(9), model.geom_aabb[number].reshape(2, 3)
    mujoco.mju_quat2Mat(turned, model.geom_quat[number])
    turned = turned.reshape(3, 3)
    assert turned @ center + model.geom_pos[number] == pytest.approx(middle)
    assert np.abs(turned) @ extent == pytest.approx(half)
