"""C libraries through ctypes: opened by name, functions with their types."""

import ctypes
from collections.abc import Callable
from typing import Any

from mjsim.errors import OpenGLError
from mjsim.sentences import Sentence

GL_RENDERER = 0x1F01


def open_library(*names: str) -> ctypes.CDLL:
    """Return the first of these libraries that exists, loaded with local symbols."""
    reasons = []
    for name in names:
        try:
            return ctypes.CDLL(name)
        except OSError as error:
            reasons.append(str(error))
    raise OpenGLError(reasons[0] if reasons else "not installed")


def publish(library: ctypes.CDLL) -> None:
    """Make the symbols of a library global in the process, where MuJoCo looks for OpenGL."""
    ctypes.CDLL(library._name, mode=ctypes.RTLD_GLOBAL)


def function(library: ctypes.CDLL, name: str, result: Any, *arguments: Any) -> Any:
    """Return a function of a library, with the ctypes types of its result and its arguments."""
    try:
        found = getattr(library, name)
    except AttributeError:
        raise OpenGLError(Sentence("{name} has no function {other_name}", library._name, name)) from None
    found.restype, found.argtypes = result, arguments
    return found


def renderer_name(get_address: Callable[[bytes], int | None]) -> str:
    """Return the name of the renderer of the current OpenGL context.

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
