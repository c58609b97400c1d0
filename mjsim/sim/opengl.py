"""OpenGL without a screen, by whichever backend works on this machine.

Tried in this order: EGL (a GPU, or Mesa's software renderer), the OSMesa of the system, the OSMesa that the
package lavavu-osmesa carries. MUJOCO_GL, when set to 'egl' or 'osmesa', narrows the choice. MuJoCo looks its
OpenGL functions up once a process, so the choice is made once a process, before MuJoCo looks.
"""

import functools
import os
import platform
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from ctypes import CDLL
from pathlib import Path
from typing import Protocol

import mujoco

from mjsim.errors import OpenGLError, how_to_install
from mjsim.gl_request import requested_backend
from mjsim.sim import native
from mjsim.sim.egl import Egl, EglContext
from mjsim.sim.osmesa import PACKAGE, VERSION, OsmesaContext, package_is_there, packaged_osmesa, system_osmesa

APT_LINE = "sudo apt install libegl1 libgl1-mesa-dri"
CHECKOUT = Path(__file__).resolve().parents[2]
"""Holds scripts/setup unless mjsim was installed from a wheel."""
TINY = "<mujoco><visual><global offwidth='1' offheight='1'/><quality shadowsize='1' offsamples='0'/></visual></mujoco>"


class GLContext(Protocol):
    """An OpenGL context of the backend that was chosen; at work in one thread at a time."""

    def make_current(self) -> None:
        """Let the OpenGL calls of this thread go to this context."""

    def renderer(self) -> str:
        """Return who draws, as OpenGL tells it; the context must be current."""

    def release(self) -> None:
        """Let no OpenGL call of this thread go anywhere, so that another thread may make it current."""

    def address(self, name: bytes) -> int | None:
        """Return where an OpenGL function is, or None when there is none of that name."""

    def free(self) -> None:
        """Give it back, from the thread where it is current; a second call does nothing."""


ContextMaker = Callable[[int, int], GLContext]
"""Makes a context with a framebuffer of its own of this width and height [px]."""


def choose_backend() -> str:
    """Return 'egl', 'osmesa' or 'osmesa from a package': the first that works here.

    Raises:
        OpenGLError: None works, or not the one that MUJOCO_GL asks for; the message says what to type.
    """
    return _choice()[0]


def make_context(width: int, height: int) -> GLContext:
    """Return a new context, not yet current.

    Args:
        width: Of the framebuffer that comes with it [px]; MuJoCo's offscreen buffer does not depend on it.
        height: The same [px].

    Raises:
        OpenGLError: As `choose_backend` says.
    """
    return _choice()[1](width, height)


def try_backend(name: str) -> str:
    """Return who draws with one of `BACKENDS`; for a process of its own, as MuJoCo then keeps to that backend.

    Raises:
        OpenGLError: It does not work; the message says why.
    """
    maker = _OPEN[name]()
    _let_mujoco_look(name, maker)
    return _try(maker)


@functools.cache  # A fact of the process: MuJoCo binds to one OpenGL library and never looks again.
def _choice() -> tuple[str, ContextMaker]:
    reasons = []
    for name in _candidates(requested_backend()):
        try:
            maker = _OPEN[name]()
            _let_mujoco_look(name, maker)
        except OpenGLError as error:
            reasons.append(f"{name}: {error}")
        else:
            return name, maker
    raise OpenGLError(f"no way to draw pictures ({'; '.join(reasons)}); type: {_remedy()}")


def _candidates(asked: str) -> tuple[str, ...]:
    """Return the backends to try for a request."""
    if asked == "osmesa":
        return ("osmesa", "osmesa from a package")
    if asked in _OPEN:
        return (asked,)
    if asked:
        raise OpenGLError(f"MUJOCO_GL is '{asked}'; mjsim draws with 'egl' or 'osmesa'; type: unset MUJOCO_GL")
    return tuple(_OPEN)


def _remedy() -> str:
    """Return the one command that mends a machine on which nothing draws."""
    if requested_backend():
        return "unset MUJOCO_GL"
    if (sys.platform, platform.machine()) != ("linux", "x86_64") or package_is_there():
        return APT_LINE
    setup = CHECKOUT / "scripts" / "setup"
    if setup.is_file():
        return str(setup)
    # Its wheels end with Python 3.13.
    return how_to_install("--no-deps", f"{PACKAGE}=={VERSION}") if sys.version_info < (3, 14) else APT_LINE


def _open_egl() -> ContextMaker:
    egl = Egl()
    for display in egl.displays():
        maker = functools.partial(_egl_context, egl, display)
        with suppress(OpenGLError):  # A GPU that this user may not open stands before the one that draws in software.
            _try(maker)
            native.publish(egl.library)
            return maker
    raise OpenGLError("no device starts")


def _egl_context(egl: Egl, display: int, width: int, height: int) -> GLContext:
    del width, height  # It has no framebuffer of its own.
    return EglContext(egl, display)


def _open_osmesa(find: Callable[[], CDLL]) -> ContextMaker:
    library = find()
    maker = functools.partial(_osmesa_context, library)
    _try(maker)
    native.publish(library)
    return maker


def _osmesa_context(library: CDLL, width: int, height: int) -> GLContext:
    return OsmesaContext(library, width=width, height=height)


def _try(maker: ContextMaker) -> str:
    """Return who draws; raise OpenGLError unless a context can be made and answers."""
    context = maker(1, 1)
    try:
        context.make_current()
        return context.renderer()
    finally:
        context.free()


def _let_mujoco_look(name: str, maker: ContextMaker) -> None:
    """Let MuJoCo find its OpenGL functions now, in the library that was chosen.

    MuJoCo's C code asks MUJOCO_GL in which of several loaded libraries to look; dm_control may have loaded others.
    """
    context = maker(1, 1)
    before = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = name.split()[0]
    try:
        context.make_current()
        mujoco.MjrContext(mujoco.MjModel.from_xml_string(TINY), mujoco.mjtFontScale.mjFONTSCALE_50).free()
    except mujoco.FatalError as error:
        raise OpenGLError(f"MuJoCo cannot draw with it: {error}") from None
    finally:
        context.free()
        if before is None:
            del os.environ["MUJOCO_GL"]
        else:
            os.environ["MUJOCO_GL"] = before


_OPEN: Mapping[str, Callable[[], ContextMaker]] = {
    "egl": _open_egl,
    "osmesa": functools.partial(_open_osmesa, system_osmesa),
    "osmesa from a package": functools.partial(_open_osmesa, packaged_osmesa),
}

BACKENDS = tuple(_OPEN)
"""In the order in which they are tried."""
