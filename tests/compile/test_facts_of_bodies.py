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
