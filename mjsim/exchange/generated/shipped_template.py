"""Templates for new worlds: shipped worlds under a new name."""

import re

from mjsim.errors import UsageError
from mjsim.world import own_copy, shipped_worlds

TEMPLATES = ("office", "corridor", "empty", "gallery")
"""Each is a shipped world that runs as it is; variables at the top of the office set its number of rooms."""


def template_text(template: str, *, name: str | None = None) -> str:
    """Return the text of a shipped world, including comments.

    Args:
        template: One of `TEMPLATES`.
        name: Name of the new world; by default that of the template.

    Raises:
        UsageError: The template does not exist.
    """
    if template not in TEMPLATES:
        raise UsageError(f"no template '{template:.40}'; templates are {', '.join(TEMPLATES)}")
    text = own_copy(shipped_worlds()[template])
    return text if name is None else re.sub(r"(?m)^name: .*$", f"name: {name}", text, count=1)
