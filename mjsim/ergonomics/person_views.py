"""Pictures from a person's eyes, and of the person from outside, as PNG."""

import cv2
import mujoco
import numpy as np

from mjsim.ergonomics.sight import Eye
from mjsim.errors import OpenGLError
from mjsim.progress import say
from mjsim.sim import SEEN_FROM_OUTSIDE, Renderer

LOOKING = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""eye_from_camera: right, up and back of the camera in the axes of an eye, as columns."""
WIDTH, HEIGHT = 640, 480
"""Size of a picture [px]."""
VIEW = 2.6, 62.0, -16.0
"""External view of a person: distance [m], azimuth and elevation relative to the seat [deg]."""


def pictures_of(model: mujoco.MjModel, person: str, eyes: tuple[Eye, Eye]) -> dict[str, bytes]:
    """Return the pictures of a person by name; none if rendering is impossible, which is reported.

    Args:
        model: The compiled world.
        person: Name of the person.
        eyes: Both eyes with their lines of sight.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pelvis = model.body(f"{person}/pelvis").id
    try:
        with Renderer(model, width=WIDTH, height=HEIGHT, groups=SEEN_FROM_OUTSIDE) as renderer:
            found = {"outside": renderer.render(data, _outside(data, pelvis)).copy()}
            for eye in eyes:
                name = f"{person}/{eye.side}_eye"
                # A camera of MuJoCo looks along -z, with x to the right; an eye looks along its line of sight.
                data.cam_xmat[model.camera(name).id] = (eye.axes @ LOOKING).ravel()
                found[f"{eye.side}_eye"] = renderer.render(data, name).copy()
    except OpenGLError as error:
        say(f"no pictures: {error}")
        return {}
    return {name: _png(image) for name, image in found.items()}


def _outside(data: mujoco.MjData, pelvis: int) -> mujoco.MjvCamera:
    """Return a camera beside and behind the shoulder of a seated person."""
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = data.xpos[pelvis] + (0.0, 0.0, 0.25)
    axes = data.xmat[pelvis].reshape(3, 3)
    heading = float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))
    camera.distance, camera.azimuth, camera.elevation = VIEW[0], heading + VIEW[1], VIEW[2]
    return camera


def _png(image: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]) -> bytes:
    return bytes(cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes())
