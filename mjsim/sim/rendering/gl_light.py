"""OpenGL calls for light maps: a map in texture unit 2, and display lists with its texture coordinates.

MuJoCo uses only the texture units 0 (pictures of materials) and 1 (shadows), and leaves unit 2 unchanged. Colours are
(colour of the geom) x (picture of its material) x (light map).

References:
    OpenGL 2.1, chapters 2.8 (vertex arrays), 3.8.13 (texture environments), 5.4 (display lists); numbers from
    Khronos' gl.h and glext.h.
"""

from collections.abc import Callable
from ctypes import byref, c_int, c_uint, c_void_p

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import OpenGLError
from mjsim.sentences import Sentence
from mjsim.sim.gl import COMPILE, LIGHTING, MODELVIEW, TEXTURE_2D, UNSIGNED_BYTE, GlCalls

TEXTURE0, LIGHT_UNIT = 0x84C0, 0x84C2
RGB, RGB8, ALPHA, ALPHA8 = 0x1907, 0x8051, 0x1906, 0x803C
MIN_FILTER, MAG_FILTER, WRAP_S, WRAP_T, LINEAR, CLAMP_TO_EDGE = 0x2801, 0x2800, 0x2802, 0x2803, 0x2601, 0x812F
FLAT, SMOOTH = 0x1D00, 0x1D01
TEXTURE_ENV, ENV_MODE, MODULATE = 0x2300, 0x2200, 0x2100
VERTEX_ARRAY, TEXTURE_COORD_ARRAY = 0x8074, 0x8078
TEXTURE_MATRIX, FLOAT, TRIANGLES, UNPACK_ALIGNMENT = 0x1702, 0x1406, 0x0004, 0x0CF5

Floats = NDArray[np.float32]


class GlLight:
    """The light map of one context, and the display lists of lit surfaces; use it while the context is current."""

    def __init__(self, gl: GlCalls, *, width: int, height: int) -> None:
        """Make a dark map.

        Args:
            gl: Functions of the context.
            width: [px]
            height: [px]

        Raises:
            OpenGLError: OpenGL refuses a map of this size.
        """
        self._look_up(gl)
        self._map = self.texture(np.zeros((height, width, 3), dtype=np.uint8))
        self._active(LIGHT_UNIT)
        self._environment(TEXTURE_ENV, ENV_MODE, MODULATE)
        self._active(TEXTURE0)
        self.enter, self.leave = self._states()
        """Display lists that switch to surfaces with a light map, and back to MuJoCo's own display lists."""
        self.require_no_error("light map")

    def upload(self, picture: NDArray[np.uint8], first_row: int = 0) -> None:
        """Replace whole rows of the map, shape (rows, width, 3)."""
        rows, width = picture.shape[:2]
        self._pixel_store(UNPACK_ALIGNMENT, 1)
        self._bind(TEXTURE_2D, self._map)
        self._part(TEXTURE_2D, 0, 0, first_row, width, rows, RGB, UNSIGNED_BYTE, picture.ctypes.data)

    def surface(self, points: Floats, lightcoords: Floats, texcoords: Floats | None, *, scaled: bool) -> int:
        """Return a new display list of triangles, to be called between `enter` and `leave`.

        Args:
            points: Three corners of each, frame of the geom, shape (3 m, 3) [m].
            lightcoords: Their places in the light map, in [0, 1], shape (3 m, 2).
            texcoords: Their places in the picture of the material, shape (3 m, 2); None without a picture, or where
                MuJoCo derives them from the points.
            scaled: Whether MuJoCo may scale those coordinates by the material, as it does with those of meshes.
        """
        listed = int(self._new_lists(1))
        units = {LIGHT_UNIT: lightcoords} | ({} if texcoords is None else {TEXTURE0: texcoords})
        self._enable_array(VERTEX_ARRAY)
        self._vertices(3, FLOAT, 0, points.ctypes.data)
        for unit, places in units.items():
            self._client_unit(unit)
            self._enable_array(TEXTURE_COORD_ARRAY)
            self._places(2, FLOAT, 0, places.ctypes.data)
        self._new_list(listed, COMPILE)
        if scaled:
            self._draw_arrays(TRIANGLES, 0, len(points))
        else:
            self._matrix_mode(TEXTURE_MATRIX)
            self._push_matrix()
            self._load_identity()
            self._draw_arrays(TRIANGLES, 0, len(points))
            self._pop_matrix()
            self._matrix_mode(MODELVIEW)
        self._end_list()
        for unit in units:
            self._client_unit(unit)
            self._disable_array(TEXTURE_COORD_ARRAY)
        self._client_unit(TEXTURE0)
        self._disable_array(VERTEX_ARRAY)
        return listed

    def apart(self, listed: int) -> int:
        """Return a new display list that enters, calls a list and leaves."""
        made = int(self._new_lists(1))
        self._new_list(made, COMPILE)
        for each in (self.enter, listed, self.leave):
            self._call_list(each)
        self._end_list()
        return made

    def texture(self, picture: NDArray[np.uint8]) -> int:
        """Return a new texture of a picture with one channel (opacity) or three, interpolated between pixels."""
        made = c_uint()
        self._new_textures(1, byref(made))
        self._bind(TEXTURE_2D, made.value)
        for name in (MIN_FILTER, MAG_FILTER):
            self._parameter(TEXTURE_2D, name, LINEAR)
        for name in (WRAP_S, WRAP_T):
            self._parameter(TEXTURE_2D, name, CLAMP_TO_EDGE)
        inner, outer = (RGB8, RGB) if picture.ndim == 3 else (ALPHA8, ALPHA)
        height, width = picture.shape[:2]
        self._pixel_store(UNPACK_ALIGNMENT, 1)
        self._image(TEXTURE_2D, 0, inner, width, height, 0, outer, UNSIGNED_BYTE, picture.ctypes.data)
        return int(made.value)

    def require_no_error(self, what: str) -> None:
        """Raise OpenGLError if a call failed since the last time."""
        code = int(self._error())
        if code:
            raise OpenGLError(Sentence("OpenGL refuses the {what} (error {code:#x})", what, code))

    def _states(self) -> tuple[int, int]:
        """Return `enter` and `leave`."""
        enter = int(self._new_lists(2))
        # The colour of a surface is constant and need not be interpolated.
        self._record_state(enter, light=self._disable, map_=self._enable, shade=FLAT)
        self._record_state(enter + 1, light=self._enable, map_=self._disable, shade=SMOOTH)
        return enter, enter + 1

    def _record_state(
        self, listed: int, *, light: Callable[[int], None], map_: Callable[[int], None], shade: int
    ) -> None:
        self._new_list(listed, COMPILE)
        light(LIGHTING)
        self._shade(shade)
        self._active(LIGHT_UNIT)
        self._bind(TEXTURE_2D, self._map)
        map_(TEXTURE_2D)
        self._active(TEXTURE0)
        self._end_list()

    def _look_up(self, gl: GlCalls) -> None:
        call = gl.function
        self._active, self._client_unit = (
            call(b"glActiveTexture", None, c_uint),
            call(b"glClientActiveTexture", None, c_uint),
        )
        self._bind = call(b"glBindTexture", None, c_uint, c_uint)
        self._new_textures = call(b"glGenTextures", None, c_int, c_void_p)
        self._parameter = call(b"glTexParameteri", None, c_uint, c_uint, c_int)
        self._environment = call(b"glTexEnvi", None, c_uint, c_uint, c_int)
        self._image = call(b"glTexImage2D", None, c_uint, *[c_int] * 5, c_uint, c_uint, c_void_p)
        self._part = call(b"glTexSubImage2D", None, c_uint, *[c_int] * 5, c_uint, c_uint, c_void_p)
        self._pixel_store = call(b"glPixelStorei", None, c_uint, c_int)
        self._enable, self._disable = call(b"glEnable", None, c_uint), call(b"glDisable", None, c_uint)
        self._new_lists = call(b"glGenLists", c_uint, c_int)
        self._shade = call(b"glShadeModel", None, c_uint)
        self._call_list = call(b"glCallList", None, c_uint)
        self._new_list, self._end_list = call(b"glNewList", None, c_uint, c_uint), call(b"glEndList")
        self._enable_array = call(b"glEnableClientState", None, c_uint)
        self._disable_array = call(b"glDisableClientState", None, c_uint)
        self._vertices = call(b"glVertexPointer", None, c_int, c_uint, c_int, c_void_p)
        self._places = call(b"glTexCoordPointer", None, c_int, c_uint, c_int, c_void_p)
        self._matrix_mode, self._load_identity = call(b"glMatrixMode", None, c_uint), call(b"glLoadIdentity")
        self._push_matrix, self._pop_matrix = call(b"glPushMatrix"), call(b"glPopMatrix")
        self._draw_arrays = call(b"glDrawArrays", None, c_uint, c_int, c_int)
        self._error = call(b"glGetError", c_uint)
