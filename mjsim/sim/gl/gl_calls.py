"""The few OpenGL functions that MuJoCo does not wrap, looked up in the current context.

References:
    OpenGL 4.6 compatibility profile; MESA_pack_invert for rows read from the top; numbers from Khronos' gl.h.
"""

import ctypes
from ctypes import c_char_p, c_double, c_float, c_int, c_ubyte, c_uint, c_void_p
from typing import Any

from mjsim.errors import OpenGLError
from mjsim.interface import Picture
from mjsim.sentences import Sentence
from mjsim.sim.gl.opengl import GLContext

EXTENSIONS = 0x1F03
RGBA, UNSIGNED_BYTE = 0x1908, 0x1401
PACK_INVERT = 0x8758
COMPILE, QUADS, ALL_ATTRIB_BITS = 0x1300, 0x0007, 0x000FFFFF
MODELVIEW, PROJECTION = 0x1700, 0x1701
LIGHTING, CULL_FACE, FOG, TEXTURE_2D = 0x0B50, 0x0B44, 0x0B60, 0x0DE1


class GlCalls:
    """Reads images, paints the background, and looks up other functions."""

    def __init__(self, context: GLContext) -> None:
        """Look up the functions; the context must be current."""
        self._context = context
        self._read_pixels = self.function(b"glReadPixels", None, c_int, c_int, c_int, c_int, c_uint, c_uint, c_void_p)
        self._pixel_store = self.function(b"glPixelStorei", None, c_uint, c_int)
        self._call_list = self.function(b"glCallList", None, c_uint)
        self._color = self.function(b"glColor3f", None, *[c_float] * 3)
        names = self.function(b"glGetString", c_char_p, c_uint)(EXTENSIONS) or b""
        self.reads_from_top = b"GL_MESA_pack_invert" in names.split()
        """Whether `read` gives the top row first."""

    def read(self, into: Picture) -> None:
        """Read the rendered image, RGBA, shape (height, width, 4); four bytes per pixel are fastest."""
        height, width = into.shape[:2]
        if self.reads_from_top:
            self._pixel_store(PACK_INVERT, 1)
        self._read_pixels(0, 0, width, height, RGBA, UNSIGNED_BYTE, into.ctypes.data)
        if self.reads_from_top:
            self._pixel_store(PACK_INVERT, 0)

    def background(self) -> int:
        """Return a display list that paints the background, for `paint`."""
        listed = int(self.function(b"glGenLists", c_uint, c_int)(1))
        matrix_mode, load_identity = self.function(b"glMatrixMode", None, c_uint), self.function(b"glLoadIdentity")
        disable, vertex = (
            self.function(b"glDisable", None, c_uint),
            self.function(b"glVertex2f", None, *[c_float] * 2),
        )
        self.function(b"glNewList", None, c_uint, c_uint)(listed, COMPILE)
        self.function(b"glPushAttrib", None, c_uint)(ALL_ATTRIB_BITS)
        for feature in (LIGHTING, CULL_FACE, FOG, TEXTURE_2D):
            disable(feature)
        self.function(b"glDepthMask", None, c_ubyte)(0)
        # MuJoCo's depth is 1 near and 0 far: a depth of 0 is visible only where nothing was drawn.
        self.function(b"glDepthRange", None, c_double, c_double)(0.0, 0.0)
        for mode in (PROJECTION, MODELVIEW):
            matrix_mode(mode)
            load_identity()
        self.function(b"glBegin", None, c_uint)(QUADS)
        for x, y in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)):
            vertex(x, y)
        self.function(b"glEnd")()
        self.function(b"glPopAttrib")()
        self.function(b"glEndList")()
        return listed

    def paint(self, listed: int, color: tuple[float, float, float]) -> None:
        """Execute a display list in a colour, red, green, blue."""
        self._color(*color)
        self._call_list(listed)

    def forget(self, listed: int) -> None:
        """Delete a display list."""
        self.function(b"glDeleteLists", None, c_uint, c_int)(listed, 1)

    def function(self, name: bytes, result: Any = None, *arguments: Any) -> Any:
        """Return a function of OpenGL, by its name and the ctypes of its result and its arguments."""
        address = self._context.address(name)
        if not address:
            raise OpenGLError(Sentence("OpenGL has no function {decode}", name.decode()))
        return ctypes.CFUNCTYPE(result, *arguments)(address)
