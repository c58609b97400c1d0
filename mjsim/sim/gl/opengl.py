"""OpenGL without a screen, by the first backend that works on this machine.

Tried in this order: EGL (a GPU, or Mesa's software renderer), the OSMesa of the system, the OSMesa of the package
lavavu-osmesa. MUJOCO_GL, when set to 'egl' or 'osmesa', restricts the choice. MuJoCo looks up its OpenGL functions
once per process, so the backend is chosen once per process, before that.
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
from mjsim.sentences import Sentence
from mjsim.sim.gl import native
from mjsim.sim.gl.egl import Egl, EglContext
from mjsim.sim.gl.osmesa import OSMESA_PACKAGE, VERSION, OsmesaContext, has_package, packaged_osmesa, system_osmesa

APT_LINE = "sudo apt install libegl1 libgl1-mesa-dri"
CHECKOUT = Path(__file__).resolve().parents[3]
"""Root of the checkout, with scripts/setup unless mjsim was installed from a wheel."""
TINY = "<mujoco><visual><global offwidth='1' offheight='1'/><quality shadowsize='1' offsamples='0'/></visual></mujoco>"


class GLContext(Protocol):
    """An OpenGL context of the chosen backend, used by one thread at a time."""

    def make_current(self) -> None:
        """Make this the context of the OpenGL calls of this thread."""

    def renderer(self) -> str:
        """Return the name of the OpenGL renderer; the context must be current."""

    def release(self) -> None:
        """Detach the context from this thread, so that another thread can make it current."""

    def address(self, name: bytes) -> int | None:
        """Return the address of an OpenGL function, or None if there is none of that name."""

    def free(self) -> None:
        """Destroy the context, in the thread where it is current; a second call does nothing."""


ContextMaker = Callable[[int, int], GLContext]
"""Creates a context with its own framebuffer of a width and height [px]."""


def choose_backend() -> str:
    """Return 'egl', 'osmesa' or 'osmesa from a package': the first that works here.

    Raises:
        OpenGLError: None works, or not the one set by MUJOCO_GL; the message contains the remedy.
    """
    return _choice()[0]


def make_context(width: int, height: int) -> GLContext:
    """Return a new context, not yet current.

    Args:
        width: Width of its framebuffer [px]; MuJoCo's offscreen buffer does not depend on it.
        height: Height of its framebuffer [px].

    Raises:
        OpenGLError: As for `choose_backend`.
    """
    return _choice()[1](width, height)


def try_backend(name: str) -> str:
    """Return the renderer of one of `BACKENDS`; call it in a separate process, as MuJoCo then keeps that backend.

    Raises:
        OpenGLError: It does not work; the message contains the reason.
    """
    maker = _OPEN[name]()
    _preset_mujoco(name, maker)
    return _try(maker)


@functools.cache  # Constant in a process: MuJoCo binds to one OpenGL library and never searches again.
def _choice() -> tuple[str, ContextMaker]:
    reasons = []
    for name in _candidates(requested_backend()):
        try:
            maker = _OPEN[name]()
            _preset_mujoco(name, maker)
        except OpenGLError as error:
            reasons.append(f"{name}: {error}")
        else:
            return name, maker
    raise OpenGLError(Sentence("cannot draw pictures ({reasons}); type: {remedy}", "; ".join(reasons), _remedy()))


def _candidates(requested: str) -> tuple[str, ...]:
    """Return the backends to try for a request."""
    if requested == "osmesa":
        return ("osmesa", "osmesa from a package")
    if requested in _OPEN:
        return (requested,)
    if requested:
        raise OpenGLError(
            Sentence("MUJOCO_GL is '{requested}'; mjsim draws with 'egl' or 'osmesa'; type: unset MUJOCO_GL", requested)
        )
    return tuple(_OPEN)


def _remedy() -> str:
    """Return the command that makes rendering work on this machine."""
    if requested_backend():
        return "unset MUJOCO_GL"
    if (sys.platform, platform.machine()) != ("linux", "x86_64") or has_package():
        return APT_LINE
    setup = CHECKOUT / "scripts" / "setup"
    if setup.is_file():
        return str(setup)
    # Its last wheels are for Python 3.13.
    return how_to_install("--no-deps", f"{OSMESA_PACKAGE}=={VERSION}") if sys.version_info < (3, 14) else APT_LINE


def _open_egl() -> ContextMaker:
    egl = Egl()
    for display in egl.displays():
        maker = functools.partial(_egl_context, egl, display)
        with suppress(OpenGLError):  # A GPU that this user may not open is listed before the software renderer.
            _try(maker)
            native.publish(egl.library)
            return maker
    raise OpenGLError("no device starts")


def _egl_context(egl: Egl, display: int, width: int, height: int) -> GLContext:
    del width, height  # A surfaceless context has no framebuffer.
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
    """Return the name of the renderer; raise OpenGLError unless a context can be created and used."""
    context = maker(1, 1)
    try:
        context.make_current()
        return context.renderer()
    finally:
        context.free()


def _preset_mujoco(name: str, maker: ContextMaker) -> None:
    """Make MuJoCo look up its OpenGL functions now, in the chosen library.

    MuJoCo's C code selects one of several loaded libraries by MUJOCO_GL; dm_control may have loaded others.
    """
    context = maker(1, 1)
    before = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = name.split()[0]
    try:
        context.make_current()
        mujoco.MjrContext(mujoco.MjModel.from_xml_string(TINY), mujoco.mjtFontScale.mjFONTSCALE_50).free()
    except mujoco.FatalError as error:
        raise OpenGLError(Sentence("MuJoCo cannot draw with it: {error}", error)) from None
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
"""Backends in the order in which they are tried."""
