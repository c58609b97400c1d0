"""MjSpec -> MjModel; an error of MuJoCo becomes one line."""

import re

import mujoco

from mjsim.errors import UsageError, one_line
from mjsim.sentences import Sentence

_NAMED = re.compile(r"\s+Element name '([^']*)'.*", re.DOTALL)


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Return the model of the scene of a world.

    Raises:
        UsageError: MuJoCo refuses it, for example if parts are too small to have an inertia or an area.
    """
    try:
        return spec.compile()
    except ValueError as error:
        text = str(error).removeprefix("Error: ")
        named = _NAMED.search(text)
        subject = f"'{named[1]}'" if named else "this world"
        reason = one_line(_NAMED.sub("", text))
        raise UsageError(
            Sentence("MuJoCo cannot compile {subject}: {reason}; make sizes and masses larger", subject, reason)
        ) from error
