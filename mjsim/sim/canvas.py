"""A model on the graphics processor: its meshes and textures, and the memory that pictures are drawn in."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

import mujoco

from mjsim.sim.gl_calls import GlCalls
from mjsim.sim.opengl import GLContext, make_context

Quality = Literal["normal", "high"]
SHADOW_PIXELS, SAMPLES = 4096, 4
"""Of high quality: side of the shadow map [px], and samples a pixel."""
BACKGROUND = (0.87, 0.91, 0.95)
"""What is seen where the world ends, in full light, red, green, blue."""


class Canvas:
    """What the renderers of one model share; each use may come from another thread, one at a time."""

    def __init__(self, model: mujoco.MjModel, *, quality: Quality = "normal") -> None:
        """Keep the model; all else is made at the first use."""
        self.model = model
        self.quality: Quality = quality
        self._context: GLContext | None = None
        self._width = self._height = 0

    @contextmanager
    def at_work(self, width: int, height: int) -> Iterator["Canvas"]:
        """Let this thread draw pictures of a size, until the end of the block.

        Raises:
            OpenGLError: This machine has no way to draw.
        """
        if self._context is None:
            self._context = make_context(width, height)
        context = self._context
        context.make_current()
        try:
            if not self._width:
                self._fill(context)
            if (width, height) != (self._width, self._height):
                # A buffer of just this size is cleared fastest.
                mujoco.mjr_resizeOffscreen(width, height, self.mjr)
                mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self.mjr)
                self._width, self._height = width, height
            yield self
        finally:
            context.release()

    def paint_background(self, level: float) -> None:
        """Paint what nothing was drawn on as the general light shows it; to be called after mjr_render."""
        red, green, blue = (min(level, 1.0) * value for value in BACKGROUND)
        self.gl.paint(self._background, (red, green, blue))

    def close(self) -> None:
        """Give back the context and all that it holds; a second call does nothing."""
        if self._context is None:
            return
        self._context.make_current()
        if self._width:
            self.mjr.free()
        self._context.free()
        self._context, self._width = None, 0

    def _fill(self, context: GLContext) -> None:
        """Copy the model to the graphics processor."""
        quality = self.model.vis.quality
        before = quality.shadowsize, quality.offsamples
        high = self.quality == "high"
        try:
            quality.shadowsize, quality.offsamples = (SHADOW_PIXELS, SAMPLES) if high else (0, 0)
            self.mjr = mujoco.MjrContext(self.model, mujoco.mjtFontScale.mjFONTSCALE_50)
        finally:
            quality.shadowsize, quality.offsamples = before
        # Depth near 0 is far: that way single precision is enough at any distance.
        self.mjr.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self.gl = GlCalls(context)
        self._background = self.gl.background()
