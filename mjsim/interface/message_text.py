"""Messages between robots as text."""

import json

import numpy as np

MAX_CHARACTERS = 1 << 20
"""Maximum number of characters of a message in JSON."""


def message_text(content: object) -> str:
    """Return a message's content as JSON, exactly.

    Raises:
        ValueError: It contains a value that JSON cannot represent, or is too long.
    """
    try:
        text = json.dumps(content, allow_nan=False, separators=(",", ":"), default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(
            f"a message that cannot be sent ({error}); it may contain finite numbers, strings, None, lists and dicts"
        ) from None
    if len(text) > MAX_CHARACTERS:
        raise ValueError(f"a message of {len(text)} characters as JSON; {MAX_CHARACTERS} can be sent")
    return text


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"a value of type {type(value).__name__}")
