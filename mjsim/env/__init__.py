"""Worlds to learn in: a `Task` as a Gymnasium environment, as many of them at once, or as a `dm_env` environment.

`GymEnvironment` and `vector_environment` need gymnasium, `DmEnvironment` needs dm-control; each is brought in when it
is first asked for.
"""

from typing import TYPE_CHECKING, Any

from mjsim.env.step import Step
from mjsim.env.task import Task
from mjsim.errors import UsageError

if TYPE_CHECKING:
    from mjsim.env.control import DmEnvironment
    from mjsim.env.gym import GymEnvironment
    from mjsim.env.vector import vector_environment

__all__ = ["DmEnvironment", "GymEnvironment", "Step", "Task", "vector_environment"]

_LATER = {
    "DmEnvironment": "mjsim.env.control",
    "GymEnvironment": "mjsim.env.gym",
    "vector_environment": "mjsim.env.vector",
}
_MISSING = {
    "dm_control": "dm-control is not installed, which has releases for Python 3.11 and 3.12 only; use GymEnvironment",
    "gymnasium": "gymnasium is not installed; type: pip install 'mjsim[gymnasium]'",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'mjsim.env' has no attribute '{name}'")
    import importlib

    try:
        return getattr(importlib.import_module(_LATER[name]), name)
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in _MISSING:
            raise
        raise UsageError(_MISSING[package]) from None
