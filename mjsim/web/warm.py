"""Does once, in a thread while the browser starts, what the first page would wait for."""

import threading
from functools import cache

from mjsim.web.files import EMPTY_WORLD
from mjsim.web.modules import shipped_modules
from mjsim.web.panel_schema import schema_text
from mjsim.web.shipped import shipped
from mjsim.web.static_page import pack, pack_files
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
