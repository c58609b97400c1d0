"""Where the value at a path of keys and indices stands in a text."""

from collections.abc import Sequence

from mjsim.world.base import KEY
from mjsim.world.text import Node


def place_of(node: Node | None, path: Sequence[str | int]) -> tuple[int, int]:
    """Return line and column of the value at a path, or of the nearest value around it that is written.

    Steps in angle brackets, the tags of kinds, are not in the text; a last step `[key]` means the key itself.
    A world that was built in Python has no text: 1, 1.
    """
    if node is None:
        return 1, 1
    steps = [step for step in path if isinstance(step, int) or not step.startswith("<")]
    for index, step in enumerate(steps):
        if steps[index + 1 :] == [KEY] and step in node.keys:
            return node.keys[str(step)]
        if step not in node.items:
            break
        node = node.items[step]
    return node.line, node.column
