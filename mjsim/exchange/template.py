"""Worlds to begin with: shipped ones, under a name of one's own."""

import re

from mjsim.errors import UsageError
from mjsim.world import own_copy, shipped_worlds

TEMPLATES = ("office", "corridor", "empty", "gallery")
"""Each is a shipped world that runs at once; variables at the top of the office say how many rooms it has."""


def template_text(template: str, *, name: str | None = None) -> str:
    """Return the text of a shipped world, its comments too.

    Args:
        template: One of `TEMPLATES`.
        name: Of the new world; by default that of the template.

    Raises:
        UsageError: The template does not exist.
    """
    if template not in TEMPLATES:
        raise UsageError(f"no template '{template:.40}'; templates are {', '.join(TEMPLATES)}")
    text = own_copy(shipped_worlds()[template])
    return text if name is None else re.sub(r"(?m)^name: .*$", f"name: {name}", text, count=1)


def template_summary(template: str) -> str:
    """Return the first sentence of what a template's comment says of it."""
    lines = template_text(template).splitlines()
    comment = [line.lstrip("# ") for line in lines if line.startswith("#") and "yaml-language-server" not in line]
    return " ".join(comment).partition(". ")[0] + "."
