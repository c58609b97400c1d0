"""The user's cache folder: results that took long to compute and can be recomputed."""

import os
from pathlib import Path


def user_cache(kind: str) -> Path:
    """Return the folder of one kind of cached files (XDG Base Directory Specification)."""
    base = os.environ.get("XDG_CACHE_HOME") or ""
    return (Path(base) if os.path.isabs(base) else Path(os.path.expanduser("~/.cache"))) / "mjsim" / kind
