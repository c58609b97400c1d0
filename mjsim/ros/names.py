"""Names as ROS 2 allows them: letters of ASCII, digits and underscores, no digit first."""

import re
from collections.abc import Iterable

from mjsim.errors import UsageError


def plain_names(names: Iterable[str], *, of: str) -> dict[str, str]:
    """Return each name with what ROS does not allow replaced: other characters by `_`, `x` before a leading digit.

    Args:
        names: As the world has them.
        of: What has these names, for the message.

    Raises:
        UsageError: Two of them become the same.
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
