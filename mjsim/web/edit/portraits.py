"""Pictures of single models, robots and arms, for choosing one."""

import json
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Literal, get_args

from mjsim.sentences import Sentence
from mjsim.video import portrait
from mjsim.web.run import jpeg
from mjsim.web.server import RefusedError
from mjsim.web.worlds import Signs
from mjsim.world import World

Kind = Literal["model", "robot", "arm"]
SIZE = 240, 180
"""Width and height of a picture [px]; twice the displayed size on most screens."""
CACHE_SIZE = 200
"""Maximum number of cached pictures."""
_WORLDS = {
    "model": "obstacles: [{{model: {name}, at: [0, 0]}}]",
    "robot": "robots: [{{name: it, preset: {name}, at: [0, 0], heading_deg: 0}}]",
    "arm": "robots: [{{name: it, base: fixed, at: [0, 0], arms: [{{preset: {name}, at: [0, 0, 1.2]}}]}}]",
}
_TEXT = "mjsim: 1\nfloor: {{color: '#d8dce0'}}\n{things}\n"


def text_of(kind: str, name: str) -> str:
    """Return the text of a world with a single item.

    Raises:
        RefusedError: There are no items of this kind.
    """
    if kind not in get_args(Kind):
        raise RefusedError(
            400, Sentence("no pictures of kind '{kind:.20}'; there are {kinds}", kind, ", ".join(get_args(Kind)))
        )
    return _TEXT.format(things=_WORLDS[kind].format(name=json.dumps(name)))


class Portraits:
    """Renders one picture at a time, and caches the results."""

    def __init__(self) -> None:
        """Start with an empty cache."""
        self._lock = threading.Lock()
        self._cached: OrderedDict[tuple[object, ...], bytes] = OrderedDict()

    def picture(self, text: str, *, folder: str, signs: Signs, world: Callable[[], World]) -> bytes:
        """Return a JPEG of the contents of a world.

        Args:
            text: Text of the world.
            folder: Path relative to which it names files.
            signs: Signs of these files.
            world: Returns the world.

        Raises:
            MjsimError: The world cannot be read, compiled or rendered.
        """
        key = text, folder, tuple(sorted(signs.items()))
        with self._lock:
            if key not in self._cached:
                self._cached[key] = jpeg(portrait(world(), width=SIZE[0], height=SIZE[1]))
                if len(self._cached) > CACHE_SIZE:
                    self._cached.popitem(last=False)
            self._cached.move_to_end(key)
            return self._cached[key]
