"""OpenGL contexts of OSMesa, which render in memory on the processor.

The library is part of the system or of the package lavavu-osmesa, which can be installed without root rights.

References:
    Mesa, include/GL/osmesa.h.
"""

import ctypes
from ctypes import c_char_p, c_int, c_ubyte, c_uint, c_void_p
from importlib import metadata
from pathlib import Path
from typing import cast

from mjsim.errors import OpenGLError
from mjsim.sentences import Sentence
from mjsim.sim.gl.native import function, open_library, renderer_name

RGBA, UNSIGNED_BYTE = 0x1908, 0x1401
DEPTH_BITS, STENCIL_BITS = 24, 8
OSMESA_PACKAGE, VERSION = "lavavu-osmesa", "1.9.10"
NEEDED_FIRST = ("tinfo", "ffi", "zstd", "pcre2", "selinux", "drm", "glapi", "LLVM")
"""Libraries of the package, each after its dependencies, as they have no search path."""


def system_osmesa() -> ctypes.CDLL:
    """Return the OSMesa of the system."""
    return open_library("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


def packaged_osmesa() -> ctypes.CDLL:
    """Return the OSMesa of the package lavavu-osmesa."""
    if not has_package():
        raise OpenGLError(Sentence("the package {osmesa_package} is not installed", OSMESA_PACKAGE))
    folder = Path(str(metadata.distribution(OSMESA_PACKAGE).locate_file("lavavu_osmesa.libs")))
    for name in NEEDED_FIRST:
        open_library(*map(str, folder.glob(f"lib{name}-*")))
    return open_library(*map(str, folder.glob("libOSMesa-*")))


def has_package() -> bool:
    """Return whether the package lavavu-osmesa is installed."""
    return any(metadata.distributions(name=OSMESA_PACKAGE))


class OsmesaContext:
    """A context that renders in memory."""

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
            raise OpenGLError("OSMesa cannot create an OpenGL context")

    def make_current(self) -> None:
        """Make this the context of the OpenGL calls of this thread."""
        made = self._context and self._make_current(
            self._context, self._buffer, UNSIGNED_BYTE, self._width, self._height
        )
        if not made:
            raise OpenGLError("the OSMesa context was freed, or is too large")

    def renderer(self) -> str:
        """Return the name of the OpenGL renderer; the context must be current."""
        return renderer_name(self._get_address)

    def release(self) -> None:
        """Detach the context from this thread, so that another thread can make it current."""
        self._make_current(None, None, UNSIGNED_BYTE, 0, 0)

    def address(self, name: bytes) -> int | None:
        """Return the address of an OpenGL function, or None if there is none of that name."""
        return cast("int | None", self._get_address(name))

    def free(self) -> None:
        """Destroy the context; a second call does nothing."""
        if self._context:
            if self._current_context() == self._context:
                self._make_current(None, None, UNSIGNED_BYTE, 0, 0)
            self._destroy_context(self._context)
            self._context = None
