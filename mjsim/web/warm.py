"""Prepares, in a thread while the browser starts, data that the first page would otherwise wait for."""

import threading
from functools import cache

from mjsim.web.edit import schema_text
from mjsim.web.server import pack, pack_files
from mjsim.web.worlds import EMPTY_WORLD, shipped, shipped_modules
from mjsim.world import parse_world


@cache
def warm_up() -> threading.Thread:
    """Start compressing the page's files, listing what is shipped, and building the validators of worlds.

    The first requests would do the same, and take longer.
    """
    thread = threading.Thread(target=_warm_up, name="mjsim-warm-up", daemon=True)
    thread.start()
    return thread


def _warm_up() -> None:
    pack_files()
    pack(schema_text())
    shipped()
    parse_world(EMPTY_WORLD)
    shipped_modules()
