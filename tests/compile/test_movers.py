"""Things on paths, as MuJoCo has them."""

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.world import parse_world


@pytest.mark.parametrize("heading", [0.0, 30.0, -110.0])
def test_slides_of_a_mover_lead_along_the_axes_of_the_world_whatever_its_heading(heading):
    path = "path: {points: [[3, 2]], speed: 1}"
    item = f"{{name: cart, box: [0.6, 0.2, 0.5], at: [1, 2], heading_deg: {heading}, {path}}}"
    model = compile_world(parse_world(f"mjsim: 1\nobstacles: [{item}]\n")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = data.body("obstacle/cart")
    start, turned = body.xpos.copy(), body.xmat.copy()
    slides = [number for number in range(model.njnt) if model.jnt_type[number] == mujoco.mjtJoint.mjJNT_SLIDE]
    assert len(slides) == 2
    for number, way in zip(slides, (0.7, -0.4), strict=True):
        data.qpos[model.jnt_qposadr[number]] += way
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(body.xpos - start, [0.7, -0.4, 0.0], atol=1e-9)
    np.testing.assert_allclose(body.xmat, turned, atol=1e-12)
