"""Draws shadows on the floor of a finished picture, before its background.

References:
    OpenGL 2.1, chapter 4.1.8 (blending); numbers from Khronos' gl.h.
"""

from ctypes import c_int, c_ubyte, c_uint, c_void_p

import mujoco
import numpy as np

from mjsim.sim.gl import ALL_ATTRIB_BITS, COMPILE, CULL_FACE, FOG, LIGHTING, QUADS, TEXTURE_2D, GlCalls
from mjsim.sim.rendering.contact_shadows import SHADOW_SIDE, PlacedShadows, Shadow
from mjsim.sim.rendering.gl_light import FLOAT, TEXTURE_COORD_ARRAY, VERTEX_ARRAY, GlLight
from mjsim.sim.rendering.in_view import Frustum
from mjsim.sim.rendering.merged import UNSEEN

COLOR_ARRAY = 0x8076
BLEND, ZERO, ONE_MINUS_SRC_ALPHA = 0x0BE2, 0, 0x0303
SHADOW_HEIGHT = 0.002
"""Height of shadows above the floor [m]."""


class GlShadows:
    """The shadows of the moving things of one model in one context; use it while the context is current."""

    def __init__(self, gl: GlCalls, light: GlLight, model: mujoco.MjModel, shadows: list[Shadow]) -> None:
        """Copy the shadows to one texture; at least one."""
        self._model, self._placed = model, PlacedShadows(shadows)
        self._geoms = [shadow.geom for shadow in shadows]
        across = int(np.ceil(np.sqrt(len(shadows))))
        atlas = np.zeros((across * SHADOW_SIDE, across * SHADOW_SIDE), dtype=np.uint8)
        count = len(shadows)
        self._corners = np.full((count, 4, 3), SHADOW_HEIGHT, dtype=np.float32)
        self._colors = np.zeros((count, 4, 4), dtype=np.float32)
        self._places, self._chosen_places = (np.empty((count, 4, 2), dtype=np.float32) for _ in range(2))
        # Not up to the border of a part, where its neighbour would bleed in.
        unit = np.array(
            [[0.5, 0.5], [SHADOW_SIDE - 0.5, 0.5], [SHADOW_SIDE - 0.5, SHADOW_SIDE - 0.5], [0.5, SHADOW_SIDE - 0.5]]
        )
        for number, shadow in enumerate(shadows):
            row, column = divmod(number, across)
            atlas[row * SHADOW_SIDE : (row + 1) * SHADOW_SIDE, column * SHADOW_SIDE : (column + 1) * SHADOW_SIDE] = (
                shadow.opacity
            )
            self._places[number] = (unit + np.array([column, row]) * SHADOW_SIDE) / len(atlas)
        self._look_up(gl)
        self._texture = light.texture(atlas)
        self._list_states(gl)
        light.require_no_error("shadows")

    def draw(self, data: mujoco.MjData, view: Frustum) -> None:
        """Darken the floor below and around the things in view, after mjr_render with the camera of the view."""
        strengths = self._placed.strengths(data, view)
        strengths[self._model.geom_group[self._geoms] == UNSEEN] = 0.0
        chosen = np.flatnonzero(strengths)
        count = len(chosen)
        if not count:
            return
        corners = self._placed.corners(data, chosen)
        self._corners[:count, :, 0], self._corners[:count, :, 1] = corners.real, corners.imag
        self._colors[:count, :, 3] = strengths[chosen, None]
        self._chosen_places[:count] = self._places[chosen]
        self._call_list(self._before)
        self._vertices(3, FLOAT, 0, self._corners.ctypes.data)
        self._tints(4, FLOAT, 0, self._colors.ctypes.data)
        self._texcoords(2, FLOAT, 0, self._chosen_places.ctypes.data)
        for array in (VERTEX_ARRAY, COLOR_ARRAY, TEXTURE_COORD_ARRAY):
            self._enable_array(array)
        self._draw_arrays(QUADS, 0, 4 * count)
        for array in (VERTEX_ARRAY, COLOR_ARRAY, TEXTURE_COORD_ARRAY):
            self._disable_array(array)
        self._call_list(self._after)

    def _list_states(self, gl: GlCalls) -> None:
        """Record the OpenGL states before and after drawing."""
        enable, disable = gl.function(b"glEnable", None, c_uint), gl.function(b"glDisable", None, c_uint)
        new_list, end_list = gl.function(b"glNewList", None, c_uint, c_uint), gl.function(b"glEndList")
        self._before = int(gl.function(b"glGenLists", c_uint, c_int)(2))
        self._after = self._before + 1
        new_list(self._before, COMPILE)
        gl.function(b"glPushAttrib", None, c_uint)(ALL_ATTRIB_BITS)
        for feature in (LIGHTING, CULL_FACE, FOG):
            disable(feature)
        for feature in (BLEND, TEXTURE_2D):
            enable(feature)
        gl.function(b"glBindTexture", None, c_uint, c_uint)(TEXTURE_2D, self._texture)
        gl.function(b"glBlendFunc", None, c_uint, c_uint)(ZERO, ONE_MINUS_SRC_ALPHA)
        gl.function(b"glDepthMask", None, c_ubyte)(0)
        end_list()
        new_list(self._after, COMPILE)
        gl.function(b"glPopAttrib")()
        end_list()

    def _look_up(self, gl: GlCalls) -> None:
        call = gl.function
        self._call_list = call(b"glCallList", None, c_uint)
        self._vertices = call(b"glVertexPointer", None, c_int, c_uint, c_int, c_void_p)
        self._tints = call(b"glColorPointer", None, c_int, c_uint, c_int, c_void_p)
        self._texcoords = call(b"glTexCoordPointer", None, c_int, c_uint, c_int, c_void_p)
        self._enable_array = call(b"glEnableClientState", None, c_uint)
        self._disable_array = call(b"glDisableClientState", None, c_uint)
        self._draw_arrays = call(b"glDrawArrays", None, c_uint, c_int, c_int)
