"""Conversion of names to those allowed in ROS 2: ASCII letters, digits and underscores, no digit first."""

import re
from collections.abc import Iterable

from mjsim.errors import UsageError


def plain_names(names: Iterable[str], *, of: str) -> dict[str, str]:
    """Return each name in a form allowed in ROS: other characters become `_`, a leading digit gets the prefix `x`.

    Args:
        names: From the world.
        of: What the names belong to, for the message.

    Raises:
        UsageError: Two of them become equal.
    """
    plain: dict[str, str] = {}
    for name in names:
        word = re.sub(r"[^A-Za-z0-9_]", "_", name)
        word = f"x{word}" if word[0].isdigit() else word
        for other, taken in plain.items():
            if taken == word and other != name:
                raise UsageError(f"{of} '{other}' and '{name}' are both '{word}' in ROS; rename one of them")
        plain[name] = word
    return plain
