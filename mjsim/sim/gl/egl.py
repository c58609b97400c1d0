"""OpenGL contexts of EGL without a screen: on a GPU, or in software by Mesa.

References:
    EGL 1.5, EGL_EXT_device_enumeration and EGL_EXT_platform_device; numbers from Khronos' egl.h and eglext.h.
"""

import ctypes
import os
from collections.abc import Iterator
from ctypes import c_char_p, c_int, c_uint, c_void_p
from typing import cast

from mjsim.errors import OpenGLError
from mjsim.sim.gl.native import function, open_library, renderer_name

PLATFORM_DEVICE, OPENGL_API, NONE = 0x313F, 0x30A2, 0x3038
SURFACE_TYPE, PBUFFER_BIT, RENDERABLE_TYPE, OPENGL_BIT = 0x3033, 0x0001, 0x3040, 0x0008
CONFIG = (SURFACE_TYPE, PBUFFER_BIT, RENDERABLE_TYPE, OPENGL_BIT, NONE)
MAX_DEVICES = 16


class Egl:
    """The functions of libEGL."""

    def __init__(self) -> None:
        self.library = library = open_library("libEGL.so.1")
        self.get_address = function(library, "eglGetProcAddress", c_void_p, c_char_p)
        self.initialize = function(library, "eglInitialize", c_uint, c_void_p, c_void_p, c_void_p)
        self.bind_api = function(library, "eglBindAPI", c_uint, c_uint)
        self.choose_config = function(library, "eglChooseConfig", c_uint, c_void_p, c_void_p, c_void_p, c_int, c_void_p)
        self.create_context = function(library, "eglCreateContext", c_void_p, c_void_p, c_void_p, c_void_p, c_void_p)
        self.make_current = function(library, "eglMakeCurrent", c_uint, c_void_p, c_void_p, c_void_p, c_void_p)
        self.current_context = function(library, "eglGetCurrentContext", c_void_p)
        self.destroy_context = function(library, "eglDestroyContext", c_uint, c_void_p, c_void_p)

    def displays(self) -> Iterator[int]:
        """Yield a display of each device that initializes, in EGL's order; MUJOCO_EGL_DEVICE_ID selects one of them."""
        query = self.get_address(b"eglQueryDevicesEXT")
        display_of = self.get_address(b"eglGetPlatformDisplayEXT")
        if not query or not display_of:
            raise OpenGLError("libEGL cannot draw without a screen")
        devices, count = (c_void_p * MAX_DEVICES)(), c_int()
        ctypes.CFUNCTYPE(c_uint, c_int, c_void_p, c_void_p)(query)(MAX_DEVICES, devices, ctypes.byref(count))
        requested = os.environ.get("MUJOCO_EGL_DEVICE_ID")
        for index in range(count.value):
            if requested is None or requested == str(index):
                get_display = ctypes.CFUNCTYPE(c_void_p, c_uint, c_void_p, c_void_p)(display_of)
                display = get_display(PLATFORM_DEVICE, devices[index], None)
                if display and self.initialize(display, None, None):
                    yield display


class EglContext:
    """A context without a surface of its own: MuJoCo draws into a framebuffer object."""

    def __init__(self, egl: Egl, display: int) -> None:
        self._egl, self._display = egl, display
        attributes, config, count = (c_int * len(CONFIG))(*CONFIG), c_void_p(), c_int()
        egl.bind_api(OPENGL_API)  # applies to this thread only
        egl.choose_config(display, attributes, ctypes.byref(config), 1, ctypes.byref(count))
        self._context = egl.create_context(display, config, None, None) if count.value else None
        if not self._context:
            raise OpenGLError("EGL cannot create an OpenGL context")

    def make_current(self) -> None:
        """Make this the context of the OpenGL calls of this thread."""
        if not self._context or not self._egl.make_current(self._display, None, None, self._context):
            raise OpenGLError("the EGL context was freed, or is in use in another thread")

    def renderer(self) -> str:
        """Return the name of the OpenGL renderer; the context must be current."""
        return renderer_name(self._egl.get_address)

    def release(self) -> None:
        """Detach the context from this thread, so that another thread can make it current."""
        self._egl.make_current(self._display, None, None, None)

    def address(self, name: bytes) -> int | None:
        """Return the address of an OpenGL function, or None if there is none of that name."""
        return cast("int | None", self._egl.get_address(name))

    def free(self) -> None:
        """Destroy the context; a second call does nothing."""
        if self._context:
            if self._egl.current_context() == self._context:
                self._egl.make_current(self._display, None, None, None)
            self._egl.destroy_context(self._display, self._context)
            self._context = None
