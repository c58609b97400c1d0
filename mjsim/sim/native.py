"""C libraries through ctypes: opened by name, functions with their types."""

import ctypes
from collections.abc import Callable
from typing import Any

from mjsim.errors import OpenGLError

GL_RENDERER = 0x1F01


def open_library(*names: str) -> ctypes.CDLL:
    """Return the first of these libraries that is there, its symbols kept out of the way of others."""
    reasons = []
    for name in names:
        try:
            return ctypes.CDLL(name)
        except OSError as error:
            reasons.append(str(error))
    raise OpenGLError(reasons[0] if reasons else "not installed")


def publish(library: ctypes.CDLL) -> None:
    """Let the symbols of a library be found by name in the whole process, where MuJoCo looks for OpenGL."""
    ctypes.CDLL(library._name, mode=ctypes.RTLD_GLOBAL)


def function(library: ctypes.CDLL, name: str, result: Any, *arguments: Any) -> Any:
    """Return a function of a library, with the ctypes types of its result and its arguments."""
    try:
        found = getattr(library, name)
    except AttributeError:
        raise OpenGLError(f"{library._name} has no function {name}") from None
    found.restype, found.argtypes = result, arguments
    return found


def renderer_name(get_address: Callable[[bytes], int | None]) -> str:
    """Return who draws in the OpenGL context that is current.

    Args:
        get_address: Finds an OpenGL function by its name.

    Raises:
        OpenGLError: OpenGL does not answer.
    """
    address = get_address(b"glGetString")
    name = ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.c_uint)(address)(GL_RENDERER) if address else None
    if not name:
        raise OpenGLError("OpenGL does not answer")
    return str(name.decode())
