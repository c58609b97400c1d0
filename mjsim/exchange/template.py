"""Worlds to begin with: shipped ones, under a name of one's own."""

import re
from importlib import resources

from mjsim.errors import UsageError

TEMPLATES = ("office", "corridor", "empty", "gallery")
"""Each is a shipped world that runs at once; variables at the top of the office say how many rooms it has."""


def template_text(template: str, *, name: str | None = None) -> str:
    """Return the text of a shipped world, its comments too.

    Args:
        template: One of `TEMPLATES`.
        name: Of the new world; that of the template unless given.

    Raises:
        UsageError: There is no such template.
    """
    if template not in TEMPLATES:
        raise UsageError(f"no template '{template:.40}'; templates are {', '.join(TEMPLATES)}")
    text = (resources.files("mjsim.worlds") / f"{template}.yaml").read_text(encoding="utf-8")
    # The schema that completes keys in editors lies beside the shipped worlds only.
    text = re.sub(r"\A# yaml-language-server:.*\n", "", text)
    return text if name is None else re.sub(r"(?m)^name: .*$", f"name: {name}", text, count=1)
