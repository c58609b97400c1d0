"""Conversion of names to those allowed in ROS 2: ASCII letters, digits and underscores, no digit first."""

from collections.abc import Iterable

from mjsim.errors import UsageError
from mjsim.progress import say
from mjsim.spelling import ascii_name, spellings


def plain_names(names: Iterable[str], *, of: str) -> dict[str, str]:
    """Return each name in a form allowed in ROS, as `ascii_name` spells it; report replaced letters.

    Args:
        names: Names in the world.
        of: What the names belong to, for the message.

    Raises:
        UsageError: Two of them become equal.
    """
    plain: dict[str, str] = {}
    for name in names:
        word = ascii_name(name)
        for other, taken in plain.items():
            if taken == word and other != name:
                raise UsageError(f"{of} '{other}' and '{name}' are both '{word}' in ROS; rename one of them")
        plain[name] = word
    if told := spellings(plain):
        say(f"names in ROS are ASCII; of {of}, {told}")
    return plain
