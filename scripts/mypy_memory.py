"""A plugin of mypy that lets it look for cycles of what it no longer needs less often: less time for more memory."""

import gc

from mypy.plugin import Plugin

FEWER_PASSES = 5_000_000
"""New objects until a pass; a check of all makes 30 million, and takes 1.3 GB then, not 0.9."""


def plugin(version: str) -> type[Plugin]:
    """Return the plugin, which changes no type."""
    gc.set_threshold(FEWER_PASSES)  # mypy sets it to 200,000 before it loads plugins
    return Plugin
