"""MUJOCO_GL, the OpenGL backend that the user requests; hidden where it would make `import mujoco` fail.

The mujoco package reads MUJOCO_GL when it is imported, and fails if the value is unknown or the library is missing,
even if `mjsim.sim.gl.opengl` would find that library in a package. Therefore mjsim moves a request that mujoco cannot
satisfy to MJSIM_GL, which only `mjsim.sim.gl.opengl` reads and child processes inherit.
"""

import os

_LIBRARIES = {"egl": (("EGL",), ("OpenGL", "GLESv2", "GLESv1_CM")), "osmesa": (("OSMesa",),)}
"""Libraries that mujoco's default OpenGL loader, PyOpenGL, needs for a backend: one of each group."""
_HARMLESS = {"", "glfw", "glx", "on", "true", "1", "enable", "enabled", "off", "false", "0", "disable", "disabled"}


def requested_backend() -> str:
    """Return the backend requested by MJSIM_GL, or else by MUJOCO_GL, in lower case; '' if none is requested."""
    return (os.environ.get("MJSIM_GL") or os.environ.get("MUJOCO_GL", "")).strip().lower()


def hide_request_from_mujoco() -> None:
    """Move MUJOCO_GL to MJSIM_GL if `import mujoco` would fail because of it; call this before that import."""
    value = os.environ.get("MUJOCO_GL", "").strip().lower()
    if value not in _HARMLESS and not _is_usable(value):
        os.environ["MJSIM_GL"] = os.environ.pop("MUJOCO_GL")


def _is_usable(value: str) -> bool:
    from ctypes.util import find_library  # Slow to load, and rarely needed.

    groups = _LIBRARIES.get(value)
    return groups is not None and all(any(map(find_library, group)) for group in groups)
