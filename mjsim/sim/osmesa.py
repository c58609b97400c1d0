"""OpenGL contexts of OSMesa, which draw in memory on the processor.

The library comes with the system, or in the package lavavu-osmesa, which anyone may install.

References:
    Mesa, include/GL/osmesa.h.
"""

import ctypes
from ctypes import c_char_p, c_int, c_ubyte, c_uint, c_void_p
from importlib import metadata
from pathlib import Path
from typing import cast

from mjsim.errors import OpenGLError
from mjsim.sim.native import function, open_library, renderer_name

RGBA, UNSIGNED_BYTE = 0x1908, 0x1401
DEPTH_BITS, STENCIL_BITS = 24, 8
PACKAGE, VERSION = "lavavu-osmesa", "1.9.10"
NEEDED_FIRST = ("tinfo", "ffi", "zstd", "pcre2", "selinux", "drm", "glapi", "LLVM")
"""Libraries of the package, each after those that it needs: they carry no search path of their own."""


def system_osmesa() -> ctypes.CDLL:
    """Return the OSMesa that the system has."""
    return open_library("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


def packaged_osmesa() -> ctypes.CDLL:
    """Return the OSMesa that the package lavavu-osmesa carries."""
    if not package_is_there():
        raise OpenGLError(f"the package {PACKAGE} is not installed")
    folder = Path(str(metadata.distribution(PACKAGE).locate_file("lavavu_osmesa.libs")))
    for name in NEEDED_FIRST:
        open_library(*map(str, folder.glob(f"lib{name}-*")))
    return open_library(*map(str, folder.glob("libOSMesa-*")))


def package_is_there() -> bool:
    """Return whether the package lavavu-osmesa is installed."""
    return any(metadata.distributions(name=PACKAGE))


class OsmesaContext:
    """A context that draws in memory."""

    def __init__(self, library: ctypes.CDLL, *, width: int, height: int) -> None:
        self._get_address = function(library, "OSMesaGetProcAddress", c_void_p, c_char_p)
        self._make_current = function(library, "OSMesaMakeCurrent", c_uint, c_void_p, c_void_p, c_uint, c_int, c_int)
        self._current_context = function(library, "OSMesaGetCurrentContext", c_void_p)
        self._destroy_context = function(library, "OSMesaDestroyContext", None, c_void_p)
        create = function(library, "OSMesaCreateContextExt", c_void_p, c_uint, c_int, c_int, c_int, c_void_p)
        self._width, self._height = width, height
        self._buffer = (c_ubyte * (4 * width * height))()
        self._context = create(RGBA, DEPTH_BITS, STENCIL_BITS, 0, None)
        if not self._context:
            raise OpenGLError("OSMesa gives no OpenGL context")

    def make_current(self) -> None:
        """Let the OpenGL calls of this thread go to this context."""
        made = self._context and self._make_current(
            self._context, self._buffer, UNSIGNED_BYTE, self._width, self._height
        )
        if not made:
            raise OpenGLError("the OSMesa context was freed, or is too large")

    def renderer(self) -> str:
        """Return who draws; the context must be current."""
        return renderer_name(self._get_address)

    def release(self) -> None:
        """Let no OpenGL call of this thread go anywhere, so that another thread may make it current."""
        self._make_current(None, None, UNSIGNED_BYTE, 0, 0)

    def address(self, name: bytes) -> int | None:
        """Return where an OpenGL function is, or None when there is none of that name."""
        return cast("int | None", self._get_address(name))

    def free(self) -> None:
        """Release it; a second call does nothing."""
        if self._context:
            if self._current_context() == self._context:
                self._make_current(None, None, UNSIGNED_BYTE, 0, 0)
            self._destroy_context(self._context)
            self._context = None
