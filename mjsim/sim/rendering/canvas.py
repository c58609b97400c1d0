"""A model on the graphics processor: its meshes and textures, and the buffer for images."""

import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

import mujoco

from mjsim.closing import Closes
from mjsim.light import BakedLight
from mjsim.sim.gl import GlCalls, GLContext, make_context
from mjsim.sim.rendering.light_source import LightSource
from mjsim.sim.rendering.lit_check import why_not_lit
from mjsim.sim.rendering.lit_scene import LitScene

Quality = Literal["normal", "high"]
SHADOW_PIXELS, HIGH_QUALITY = 4096, 4
"""High quality: side of the shadow map [px], and samples per pixel."""
BACKGROUND_COLOR = (0.87, 0.91, 0.95)
"""Colour of the background in full light, red, green, blue."""
_left: list[tuple[GLContext, mujoco.MjrContext]] = []
"""What canvases have left that nobody closed. MuJoCo frees by numbers in the context that is current: if the garbage
collector did that, a canvas at work could lose its own resources, and its pictures would stand still."""


class Canvas:
    """Resources shared by the renderers of one model; any thread may use them, one at a time."""

    def __init__(self, model: mujoco.MjModel, *, quality: Quality = "normal", light: LightSource | None = None) -> None:
        """Keep the model; everything else is created at first use.

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
            self._context = make_context(width, height)
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
        """Fill the background in the general light; to be called after mjr_render."""
        red, green, blue = (min(level, 1.0) * value for value in BACKGROUND_COLOR)
        self.gl.paint(self._background, (red, green, blue))

    def close(self) -> None:
        """Release the context and its resources; a second call does nothing."""
        if self._context is None:
            return
        self._context.make_current()
        if self._unclosed is not None:
            self._unclosed.detach()
            self.mjr.free()
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


def _free_what_is_left() -> None:
    """Free what canvases have left that nobody closed; no context is current in this thread."""
    while _left:
        context, mjr = _left.pop()
        context.make_current()
        mjr.free()
        context.free()


class Canvases(Closes):
    """The canvas of each quality, made for its first renderer; OpenGL is not used before the first picture."""

    def __init__(self) -> None:
        """Begin without any."""
        self._made: dict[Quality, Canvas] = {}

    def of(self, model: mujoco.MjModel, quality: Quality, light: LightSource | None) -> Canvas:
        """Return the canvas of a quality; all are of the same model with the same light."""
        if quality not in self._made:
            self._made[quality] = Canvas(model, quality=quality, light=light)
        return self._made[quality]

    def close(self) -> None:
        """Release them; a second call does nothing."""
        for canvas in self._made.values():
            canvas.close()
