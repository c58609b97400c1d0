"""Learning environments: a `Task` as a Gymnasium environment, a vector of them, or a `dm_env` environment.

`GymEnvironment` and `vector_environment` need gymnasium, `DmEnvironment` needs dm-control; each is imported on first
use.
"""

from typing import Any

from mjsim.errors import UsageError, how_to_install
from mjsim.faces import face

_load, __dir__, __all__ = face(__name__, __file__)
_NO_DM_CONTROL = "dm-control, which supports only Python 3.11 and 3.12, is not installed; use GymEnvironment"


def __getattr__(name: str) -> Any:
    try:
        return _load(name)
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package == "gymnasium":
            raise UsageError(f"gymnasium is not installed; type: {how_to_install('gymnasium')}") from None
        if package == "dm_control":
            raise UsageError(_NO_DM_CONTROL) from None
        raise
