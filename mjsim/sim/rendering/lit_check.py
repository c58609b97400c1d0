"""Checks that MuJoCo draws the way on which baked light relies, which a new version may change."""

import functools

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.errors import OpenGLError
from mjsim.light import ALWAYS, BakedLight, LightGroup, LightProbes, LitSurface, linear
from mjsim.progress import say
from mjsim.sim.gl import GlCalls, make_context
from mjsim.sim.rendering.lit_scene import LitScene
from mjsim.sim.rendering.scene_geoms import same_layout

SQUARE_SIDE = 8
"""Of each of three squares in a picture, one beside the other [px]."""
SCENE = f"""
<mujoco>
  <visual>
    <global offwidth="{3 * SQUARE_SIDE}" offheight="{SQUARE_SIDE}"/><quality shadowsize="0" offsamples="0"/>
  </visual>
  <worldbody>
    <camera pos="0 0 4" fovy="28.0725"/>
    <geom type="box" size="1 1 1" pos="-2 0 -1" rgba="1 1 1 1"/>
    <geom type="plane" size="1 1 1" rgba="1 1 1 1"/>
    <geom type="box" size="1 1 1" pos="2 0 -1" rgba="1 1 1 1"/>
  </worldbody>
</mujoco>
"""
LIGHT = np.array([[1.0, 0.5, 0.25], [0.125, 0.75, 0.5]])
"""Values of the light on the first two, red, green, blue."""
SAME_COLOR, SAME_DEPTH = 2, 1e-5
"""Tolerances of a value of a pixel, because light is kept in half precision, and of MuJoCo's depth."""


@functools.cache  # Constant in a process: it draws by one OpenGL library.
def why_not_lit() -> str:
    """Return why baked light cannot be drawn, '' if it can; the reason is also printed, once."""
    reason = _difference()
    if reason:
        say(f"baked light is drawn as plain: {reason}; MuJoCo {mujoco.__version__} may draw in a new way")
    return reason


def _difference() -> str:
    """Return what differs from the expected in a small picture."""
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    scene = mujoco.MjvScene(model, maxgeom=5)
    if not _fill(model, data, scene):
        return "geoms of a scene are laid out differently"
    context = make_context(3 * SQUARE_SIDE, SQUARE_SIDE)
    context.make_current()
    try:
        mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
        try:
            return _compare(model, data, scene, mjr, GlCalls(context))
        finally:
            mjr.free()
    except OpenGLError as error:
        return str(error)
    finally:
        context.release()
        context.free()


def _compare(
    model: mujoco.MjModel, data: mujoco.MjData, scene: mujoco.MjvScene, mjr: mujoco.MjrContext, gl: GlCalls
) -> str:
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, mjr)
    rect = mujoco.MjrRect(0, 0, 3 * SQUARE_SIDE, SQUARE_SIDE)
    mujoco.mjr_render(rect, scene, mjr)
    scene.nlight = 0
    _, depth = _read(rect, mjr)
    LitScene(gl, mjr, model, _lit(model)).draw(rect, scene, mjr, data)
    colors, lit_depth = _read(rect, mjr)
    if np.abs(lit_depth - depth).max() > SAME_DEPTH:
        return "surfaces with a light map are not where they were"
    middle = colors[SQUARE_SIDE // 2, SQUARE_SIDE // 2 :: SQUARE_SIDE].astype(float)
    if np.abs(middle[:2] - LIGHT * 255.0).max() > SAME_COLOR:
        return "surfaces do not show their light map"
    return "" if middle[2].min() > 128.0 else "other surfaces are dark"


def _fill(model: mujoco.MjModel, data: mujoco.MjData, scene: mujoco.MjvScene) -> bool:
    """Fill a scene, and return whether its geoms are laid out as expected."""
    camera = mujoco.MjvCamera()
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    everything = mujoco.mjtCatBit.mjCAT_ALL
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, everything, scene)
    return same_layout(scene)


def _read(rect: mujoco.MjrRect, mjr: mujoco.MjrContext) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    colors, depth = (
        np.empty((SQUARE_SIDE, 3 * SQUARE_SIDE, 3), np.uint8),
        np.empty((SQUARE_SIDE, 3 * SQUARE_SIDE), np.float32),
    )
    mujoco.mjr_readPixels(colors, depth, rect, mjr)
    return colors, depth


def _lit(model: mujoco.MjModel) -> BakedLight:
    """Return light for the first two geoms, one texel each."""
    square = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    surfaces = tuple(
        LitSurface(
            geom,
            square + np.array([2.0 * geom - 2.0, 0.0, 0.0]),
            up,
            None,
            np.full((4, 2), [0.25 + 0.5 * geom, 0.5], np.float32),
            triangles,
        )
        for geom in range(2)
    )
    group = LightGroup(ALWAYS, linear(LIGHT).astype(np.float16)[None], np.ones(3))
    probes = LightProbes(np.zeros(3), np.ones(3), np.ones((1, 1, 1, 1, 3), dtype=np.float16))
    return BakedLight(surfaces, (group,), probes, 1.0)
