"""MUJOCO_GL: which OpenGL backend the user asks for, kept from ending `import mujoco` with a traceback.

The mujoco package reads MUJOCO_GL while it is imported and fails there when the value is unknown or the library
is missing, also when `mjsim.sim.opengl` would find that library in a package. So mjsim moves a request that
mujoco cannot meet to MJSIM_GL, where only `mjsim.sim.opengl` reads it and child processes inherit it.
"""

import ctypes.util
import os

_LIBRARY = {"egl": "EGL", "osmesa": "OSMesa"}
_HARMLESS = {"", "glfw", "glx", "on", "true", "1", "enable", "enabled", "off", "false", "0", "disable", "disabled"}


def requested_backend() -> str:
    """Return what MJSIM_GL, or else MUJOCO_GL, asks for, in lower case; '' when nothing is asked for."""
    return (os.environ.get("MJSIM_GL") or os.environ.get("MUJOCO_GL", "")).strip().lower()


def hide_request_from_mujoco() -> None:
    """Move MUJOCO_GL to MJSIM_GL when `import mujoco` would fail because of it; to be called before that import."""
    value = os.environ.get("MUJOCO_GL", "").strip().lower()
    library = _LIBRARY.get(value)
    if value not in _HARMLESS and (library is None or ctypes.util.find_library(library) is None):
        os.environ["MJSIM_GL"] = os.environ.pop("MUJOCO_GL")
