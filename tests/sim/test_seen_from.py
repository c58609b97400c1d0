"""What a camera sees as it moves, and what walls hide from it, by geometry."""

import math
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.compile import compile_world
from mjsim.sim.imaging.shutter import Shutter
from mjsim.sim.rendering.in_view import Hiding, _clipped
from mjsim.sim.states.playback import CAMERA_DISTANCE, avoid_walls
from mjsim.world import parse_world

ROOM = """
mjsim: 1
walls: [{points: [[3, -1], [3, 2]], height: 2.5}, {points: [[6, -4], [7, 4]], height: 2.5}]
robots:
  - {name: r, at: [0, 0], heading_deg: 0, sensors: [{camera: eye, at: [0.2, 0.1, 0.5], width: 16, height: 16}]}
"""


@pytest.fixture(scope="module")
def model():
    return compile_world(parse_world(ROOM)).compile()


@pytest.fixture
def data(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def test_the_nearest_wall_of_each_column_is_that_which_a_ray_meets(model):
    hiding = Hiding(model)
    lines = np.stack([hiding._x, hiding._y, hiding._x_end, hiding._y_end], axis=-1)
    half, columns = math.tan(math.radians(35)), 16
    for eye, heading in (((0.0, 0.0), 0.0), ((1.0, -3.0), 0.6), ((4.5, 0.5), -0.4), ((4.5, 0.5), math.pi)):
        ahead = np.array([math.cos(heading), math.sin(heading)])
        view = np.stack([[ahead[1], -ahead[0]], ahead])
        found = hiding._nearness(view, np.array(eye), half, columns)
        for k, near in enumerate(found):
            across = ((k + 0.5) * 2 / columns - 1.0) * half
            ray = ahead + across * view[0]
            depths = []
            for x, y, x_end, y_end in lines:
                side = np.array([x_end - x, y_end - y])
                t, u = np.linalg.solve(np.stack([ray, -side], axis=-1), np.array([x, y]) - eye)
                if t > 0.01 and 0.0 <= u <= 1.0:
                    depths.append(1.0 / t)
            assert near == pytest.approx(max(depths, default=0.0), abs=1e-6)


def test_a_line_that_begins_behind_the_eye_begins_before_it():
    x, z = _clipped(np.array([0.0, 1.0]), np.array([-1.0, 2.0]), np.array([4.0, 5.0]), np.array([3.0, 4.0]))
    np.testing.assert_allclose(z, [0.01, 2.0])
    np.testing.assert_allclose(x, [1.01, 1.0])


def shutter(model, **keys):
    camera = SimpleNamespace(
        **({"camera": "eye", "height": 6, "width": 8, "rolling_shutter": 0.03, "exposed": 0.02} | keys)
    )
    return Shutter(model, "r", camera, focal=400.0)


def test_rows_are_exposed_one_after_the_other_for_their_time(model):
    made = shutter(model)
    instants = (np.arange(50) + 0.5) / 50 * 0.05 - 0.025
    weights = made._weights(instants)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    middles = (np.arange(6) + 0.5) / 6 * 0.03 - 0.015
    np.testing.assert_allclose(weights @ instants, middles, atol=2e-4)
    spread = np.sqrt(weights @ instants**2 - (weights @ instants) ** 2)
    # The deviation of what is even over a time is that time over the root of 12.
    np.testing.assert_allclose(spread, 0.02 / math.sqrt(12), rtol=0.02)


def test_a_still_camera_has_one_instant_and_a_fast_one_one_for_each_pixel(model, data):
    made = shutter(model)
    assert len(made._instants(data)) == 1
    data.qvel[:6] = [0, 0, 0, 0, 0, 0.5]
    mujoco.mj_forward(model, data)
    instants = made._instants(data)
    assert len(instants) == math.ceil(400.0 * 0.05 * 0.5)
    np.testing.assert_allclose(instants, -instants[::-1], atol=1e-15)


def test_the_camera_moves_with_the_robot_about_the_stamp_and_comes_back(model, data):
    made, index = shutter(model), model.camera("r/eye").id
    data.qvel[:6] = [0.4, -0.2, 0.0, 0.1, 0.2, 0.5]
    mujoco.mj_forward(model, data)
    place, axes = data.cam_xpos[index].copy(), data.cam_xmat[index].copy()
    base = data.xmat[model.body("r/base").id].reshape(3, 3)
    with made._moved_on(data, 0.03):
        # The velocity of a free joint is the world's, its turn rate the body's.
        turned = Rotation.from_rotvec(0.03 * (base @ [0.1, 0.2, 0.5])).as_matrix()
        np.testing.assert_allclose(data.cam_xmat[index].reshape(3, 3), turned @ axes.reshape(3, 3), atol=1e-12)
        origin = data.xpos[model.body("r/base").id]
        wanted = origin + 0.03 * np.array([0.4, -0.2, 0.0]) + turned @ (place - origin)
        np.testing.assert_allclose(data.cam_xpos[index], wanted, atol=1e-12)
    np.testing.assert_array_equal(data.cam_xpos[index], place)
    np.testing.assert_array_equal(data.cam_xmat[index], axes)


def test_a_row_is_taken_at_the_instant_nearest_to_its_own(model, data):
    made = shutter(model)
    data.qvel[3:6] = [0, 0, 3.0]
    mujoco.mj_forward(model, data)
    index, starts = model.camera("r/eye").id, []

    def draw():
        starts.append(math.atan2(*data.cam_xmat[index].reshape(3, 3)[1::-1, 0]))
        return np.full((6, 8), starts[-1])

    drawn = made.nearest(data, draw)
    angles = np.array(starts) - np.mean(starts)
    wanted = 3.0 * ((np.arange(6) + 0.5) / 6 * 0.03 - 0.015)
    step = angles[1] - angles[0]
    np.testing.assert_allclose(np.abs(drawn[:, 0] - np.mean(starts)), np.abs(wanted), atol=abs(step))
    assert (np.diff(drawn[:, 0]) * np.sign(drawn[-1, 0] - drawn[0, 0]) >= 0).all()


def test_a_camera_that_follows_stays_before_what_hides_its_robot(model, data):
    index = model.camera("r/chase").id
    before = data.cam_xpos[index].copy()
    avoid_walls(model, data, "r/chase")
    np.testing.assert_array_equal(data.cam_xpos[index], before)
    data.cam_xpos[index] = [5.0, 0.0, 0.5]
    avoid_walls(model, data, "r/chase")
    surface = data.cam_xpos[index]
    thickness = model.geom_size[next(k for k in range(model.ngeom) if model.geom(k).name.startswith("wall/"))].min()
    assert surface[0] < 3.0 - thickness
    body = data.xpos[model.body("r/base").id]
    assert np.linalg.norm(surface - [5.0, 0.0, 0.5]) > CAMERA_DISTANCE
    assert np.cross(surface - body, [5.0, 0.0, 0.5] - body)[2] == pytest.approx(0.0, abs=1e-9)
    avoid_walls(model, data, "r/none")
