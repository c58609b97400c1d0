"""What a person's eyes see, and the person from outside, as PNG."""

import cv2
import mujoco
import numpy as np

from mjsim.ergonomics.sight import Eye
from mjsim.errors import OpenGLError
from mjsim.progress import say
from mjsim.sim import SEEN_FROM_OUTSIDE, Renderer

LOOKING = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Eye from camera: the camera's right, up and back in the axes of an eye, as columns."""
WIDTH, HEIGHT = 640, 480
"""[px]"""
VIEW = 2.6, 62.0, -16.0
"""From where a person is seen: distance [m], azimuth and elevation from the seat [deg]."""


def pictures_of(model: mujoco.MjModel, person: str, eyes: tuple[Eye, Eye]) -> dict[str, bytes]:
    """Return the pictures of a person by their names, none where nothing can be drawn, which is said.

    Args:
        model: The compiled world.
        person: The name.
        eyes: Which way the person looks.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pelvis = model.body(f"{person}/pelvis").id
    try:
        with Renderer(model, width=WIDTH, height=HEIGHT, groups=SEEN_FROM_OUTSIDE) as renderer:
            found = {"outside": renderer.render(data, _outside(data, pelvis)).copy()}
            for eye in eyes:
                name = f"{person}/{eye.side}_eye"
                # A camera of MuJoCo looks against its z, x to the right; the eye looks along its line of sight.
                data.cam_xmat[model.camera(name).id] = (eye.axes @ LOOKING).ravel()
                found[f"{eye.side}_eye"] = renderer.render(data, name).copy()
    except OpenGLError as error:
        say(f"no pictures: {error}")
        return {}
    return {name: _png(image) for name, image in found.items()}


def _outside(data: mujoco.MjData, pelvis: int) -> mujoco.MjvCamera:
    """Return a view of a seated person from the side and behind the shoulder."""
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = data.xpos[pelvis] + (0.0, 0.0, 0.25)
    axes = data.xmat[pelvis].reshape(3, 3)
    heading = float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))
    camera.distance, camera.azimuth, camera.elevation = VIEW[0], heading + VIEW[1], VIEW[2]
    return camera


def _png(image: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]) -> bytes:
    return bytes(cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes())
