"""MUJOCO_GL: which OpenGL backend the user asks for, kept from ending `import mujoco` with a traceback.

The mujoco package reads MUJOCO_GL while it is imported and fails there when the value is unknown or the library
is missing, also when `mjsim.sim.opengl` would find that library in a package. So mjsim moves a request that
mujoco cannot meet to MJSIM_GL, where only `mjsim.sim.opengl` reads it and child processes inherit it.
"""

import os

_LIBRARIES = {"egl": (("EGL",), ("OpenGL", "GLESv2", "GLESv1_CM")), "osmesa": (("OSMesa",),)}
"""What PyOpenGL, through which mujoco draws by itself, loads for a request: one library of each group."""
_HARMLESS = {"", "glfw", "glx", "on", "true", "1", "enable", "enabled", "off", "false", "0", "disable", "disabled"}


def requested_backend() -> str:
    """Return what MJSIM_GL, or else MUJOCO_GL, asks for, in lower case; '' when nothing is asked for."""
    return (os.environ.get("MJSIM_GL") or os.environ.get("MUJOCO_GL", "")).strip().lower()


def hide_request_from_mujoco() -> None:
    """Move MUJOCO_GL to MJSIM_GL when `import mujoco` would fail because of it; to be called before that import."""
    value = os.environ.get("MUJOCO_GL", "").strip().lower()
    if value not in _HARMLESS and not _is_met(value):
        os.environ["MJSIM_GL"] = os.environ.pop("MUJOCO_GL")


def _is_met(value: str) -> bool:
    from ctypes.util import find_library  # Slow to load, and asked for by few.

    groups = _LIBRARIES.get(value)
    return groups is not None and all(any(map(find_library, group)) for group in groups)
