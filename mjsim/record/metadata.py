"""Checks the metadata of a recording."""

import math
from collections.abc import Mapping

from pydantic import JsonValue, TypeAdapter

MAX_SEED = 2**63 - 1
_MODULES: TypeAdapter[dict[str, dict[str, str]]] = TypeAdapter(dict[str, dict[str, str]])
_USES: TypeAdapter[dict[str, dict[str, JsonValue]]] = TypeAdapter(dict[str, dict[str, JsonValue]])


def checked_metadata(metadata: Mapping[str, str]) -> tuple[int, dict[str, str]]:
    """Return the seed, and all other metadata.

    Raises:
        ValueError: The seed is invalid, or an entry that other parts rely on is.
    """
    others = dict(metadata)
    seed = int(others.pop("seed"))
    if not 0 <= seed <= MAX_SEED:
        raise ValueError(f"its seed is {seed:.3g}; it must be between 0 and {MAX_SEED}")
    if not math.isfinite(float(others.get("seconds", "0"))):
        raise ValueError("its seconds are not finite")
    # Its exceptions are ValueErrors as well.
    _MODULES.validate_json(others.get("modules", "{}"))
    _USES.validate_json(others.get("replayed modules", "{}"))
    if any(key.startswith("replayed ") for key in others) and "replayed robot" not in others:
        raise ValueError("it does not say which robot was replayed")
    return seed, others
