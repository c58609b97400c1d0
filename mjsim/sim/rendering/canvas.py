"""A model on the graphics processor: its meshes and textures, and the buffer for images.

It is checked whether MuJoCo draws as baked light requires, since a new version may change that.
"""

import functools
import os
import sys
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.closing import Closes
from mjsim.errors import OpenGLError
from mjsim.light import ALWAYS, BakedLight, LightGroup, LightProbes, LitSurface, linear
from mjsim.progress import say
from mjsim.sim.gl import GlCalls, GLContext, make_context
from mjsim.sim.rendering.light_source import LightSource
from mjsim.sim.rendering.lit_scene import LitScene
from mjsim.sim.rendering.scene_geoms import same_layout

Quality = Literal["normal", "high"]
SHADOW_PIXELS, HIGH_QUALITY = 4096, 4
"""High quality: side of the shadow map [px], and samples per pixel."""
BACKGROUND_COLOR = (0.87, 0.91, 0.95)
"""Colour of the background in full light, red, green, blue."""
MAX_IDLE = 2
"""Maximum number of OpenGL contexts that are kept for the next canvases."""
_idle: list[GLContext] = []
"""Contexts of closed canvases, empty except for code that OpenGL compiled: in software that takes 0.2 s for a new
one."""
if sys.platform != "win32":
    os.register_at_fork(after_in_child=_idle.clear)  # A forked child has none of the threads that draw.
_left: list[tuple[GLContext, mujoco.MjrContext]] = []
"""Resources of canvases that were never closed. MuJoCo frees by numbers in the context that is current: if the garbage
collector did that, a canvas at work could lose its own resources, and its pictures would freeze."""


class Canvas:
    """Resources shared by the renderers of one model; any thread may use them, one at a time."""

    def __init__(self, model: mujoco.MjModel, *, quality: Quality = "normal", light: LightSource | None = None) -> None:
        """Store the model; everything else is created at first use.

        Args:
            model: The model.
            quality: High adds shadows, reflections and four samples per pixel; in baked light, the samples alone.
            light: Source of its baked light; None for plain light.
        """
        self.model = model
        self.quality: Quality = quality
        self._light = light
        self._baked: BakedLight | None = None
        self._context: GLContext | None = None
        self._unclosed: weakref.finalize[..., Canvas] | None = None
        self._width = self._height = 0

    @contextmanager
    def at_work(self, width: int, height: int) -> Iterator["Canvas"]:
        """Reserve the canvas for this thread and images of a given size, until the end of the block.

        Raises:
            OpenGLError: This machine cannot render.
        """
        _free_what_is_left()
        if self._context is None:
            # Before the context is current: the check has one of its own.
            self._baked = None if self._light is None or why_not_lit() else self._light()
            self._context = _empty_context(width, height)
        context = self._context
        context.make_current()
        try:
            if self._unclosed is None:
                self._fill(context)
            if (width, height) != (self._width, self._height):
                # A buffer of exactly this size is cleared fastest.
                mujoco.mjr_resizeOffscreen(width, height, self.mjr)
                mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self.mjr)
                self._width, self._height = width, height
            yield self
        finally:
            context.release()

    def paint_background(self, level: float) -> None:
        """Fill the background in the ambient light; to be called after mjr_render."""
        red, green, blue = (min(level, 1.0) * value for value in BACKGROUND_COLOR)
        self.gl.paint(self._background, (red, green, blue))

    def close(self) -> None:
        """Release the context and its resources; a second call does nothing."""
        if self._context is None:
            return
        self._context.make_current()
        # The resources of baked light are freed with its context.
        is_kept = self._unclosed is not None and self.lit is None and len(_idle) < MAX_IDLE
        if self._unclosed is not None:
            self._unclosed.detach()
            self.mjr.free()
        if is_kept:
            self.gl.forget(self._background)
            self._context.release()
            _idle.append(self._context)
        else:
            self._context.free()
        self._context, self._unclosed, self._width = None, None, 0

    def _fill(self, context: GLContext) -> None:
        """Copy the model to the graphics processor."""
        quality = self.model.vis.quality
        before = quality.shadowsize, quality.offsamples
        high = self.quality == "high"
        try:
            quality.shadowsize = SHADOW_PIXELS if high and self._baked is None else 0
            quality.offsamples = HIGH_QUALITY if high else 0
            self.mjr = mujoco.MjrContext(self.model, mujoco.mjtFontScale.mjFONTSCALE_50)
        finally:
            quality.shadowsize, quality.offsamples = before
        # Depth near 0 is far: that way single precision is enough at any distance.
        self.mjr.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        try:
            self.gl = GlCalls(context)
            self._background = self.gl.background()
            self.lit = None if self._baked is None else LitScene(self.gl, self.mjr, self.model, self._baked)
            """Draws the model in baked light; None for plain light."""
        except BaseException:
            self.mjr.free()
            raise
        self._unclosed = weakref.finalize(self, _left.append, (context, self.mjr))


def _empty_context(width: int, height: int) -> GLContext:
    """Return an empty context, not yet current: one that was kept, or a new one."""
    try:
        return _idle.pop()
    except IndexError:
        return make_context(width, height)


def _free_what_is_left() -> None:
    """Free resources of canvases that were never closed; no context is current in this thread."""
    while _left:
        context, mjr = _left.pop()
        context.make_current()
        mjr.free()
        context.free()


class Canvases(Closes):
    """The canvas of each quality, made for its first renderer; OpenGL is not used before the first picture."""

    def __init__(self) -> None:
        """Start without canvases."""
        self._made: dict[Quality, Canvas] = {}

    def of(self, model: mujoco.MjModel, quality: Quality, light: LightSource | None) -> Canvas:
        """Return the canvas of a quality; all are of the same model with the same light."""
        if quality not in self._made:
            self._made[quality] = Canvas(model, quality=quality, light=light)
        return self._made[quality]

    def close(self) -> None:
        """Release all canvases; a second call does nothing."""
        for canvas in self._made.values():
            canvas.close()


SQUARE_SIDE = 8
"""Side of each of three squares in a picture, one beside the other [px]."""
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
"""Tolerances of a pixel value, as light has half precision, and of MuJoCo's depth."""


@functools.cache  # Constant in a process, which uses one OpenGL library.
def why_not_lit() -> str:
    """Return why baked light cannot be drawn, '' if it can; the reason is also printed, once."""
    reason = _difference()
    if reason:
        say(f"baked light is drawn as plain: {reason}; MuJoCo {mujoco.__version__} may draw in a new way")
    return reason


def _difference() -> str:
    """Return how a small picture differs from the expected one."""
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
