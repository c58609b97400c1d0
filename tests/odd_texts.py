"""Texts of YAML as people might write them: lists and keys in brackets and in lines, comments in all places."""

import re
from random import Random
from typing import Any

from mjsim.world.edit.snippet import scalar

KEYS = ("name", "at", "points", "noise", "color", "walls", "heading_deg", "one", "two")
TEXTS = (
    "plain",
    "two words",
    "it's",
    'say "hi" # no',
    "#e8e4da",
    "true",
    "12",
    "a: b",
    "\u00fcn\u00ef",
    "",
    "- x",
    "x,y",
)
COMMENT = re.compile(r"# (?:beside|above) \d+[^\r\n]*")


def random_value(random: Random, depth: int = 0) -> Any:
    """Return lists, keys and single values within each other."""
    kind = random.random()
    if depth < 3 and kind < 0.25:
        return [random_value(random, depth + 1) for _ in range(random.randint(0, 4))]
    if depth < 3 and kind < 0.5:
        return {key: random_value(random, depth + 1) for key in random.sample(KEYS, random.randint(0, 4))}
    numbers = random.randint(-5, 99), round(random.uniform(-9.0, 9.0), random.randint(1, 3))
    return random.choice([*numbers, True, False, random.choice(TEXTS)])


class OddText:
    """Writes a value in a way that somebody might."""

    def __init__(self, random: Random, value: dict[str, Any]) -> None:
        self._random, self._comments = random, 0
        self.text = self._lines(value, 0)
        if self._chance(0.2):
            self.text = self.text.rstrip("\n")
        if self._chance(0.15):
            self.text = self.text.replace("\n", "\r\n")

    def _chance(self, share: float) -> bool:
        return self._random.random() < share

    def _beside(self, share: float) -> str:
        self._comments += 1
        return f"  # beside {self._comments}: [x], {{y}} - 'q'" if self._chance(share) else ""

    def _above(self, indent: int, share: float) -> str:
        self._comments += 1
        return f"{' ' * indent}# above {self._comments}\n" if self._chance(share) else ""

    def _scalar(self, value: Any) -> str:
        plain = isinstance(value, str) and re.fullmatch(r"[A-Za-z]\w*( \w+)*", value) and value != "true"
        style = self._random.choice(["", "'", '"'])
        return value if plain and not style else scalar(value, style=style or '"' if isinstance(value, str) else "")

    def _brackets(self, value: Any, indent: int, *, lines: bool) -> str:
        if not isinstance(value, (dict, list)):
            return self._scalar(value)
        keys = list(value) if isinstance(value, dict) else [None] * len(value)
        inner = value.values() if isinstance(value, dict) else value
        items = [
            ("" if key is None else f"{key}: ") + self._brackets(item, indent + 2, lines=lines)
            for key, item in zip(keys, inner, strict=True)
        ]
        ends = "{}" if isinstance(value, dict) else "[]"
        if lines and items and self._chance(0.5):
            return self._filled(items, indent, ends)
        return ends[0] + ", ".join(items) + ("," if items and self._chance(0.1) else "") + ends[1]

    def _filled(self, items: list[str], indent: int, ends: str) -> str:
        """Return items in brackets, each on lines of its own."""
        text = f"{ends[0]}{self._beside(0.2)}\n" if self._chance(0.6) else ends[0]
        for number, item in enumerate(items, start=1):
            last = number == len(items)
            text += (" " * indent if text.endswith("\n") else "") + item + ("" if last and self._chance(0.6) else ",")
            if not last or self._chance(0.5):
                text += f"{self._beside(0.3)}\n{self._above(indent, 0.2)}"
        return text + (" " * (indent - 1) if text.endswith("\n") else "") + ends[1]

    def _lines(self, value: Any, indent: int) -> str:
        text, space = "", " " * indent
        pairs = value.items() if isinstance(value, dict) else ((None, item) for item in value)
        for key, item in pairs:
            text += ("\n" if text and self._chance(0.15) else "") + self._above(indent, 0.15)
            head = "-" if key is None else f"{key}:"
            if not (isinstance(item, (dict, list)) and item and self._chance(0.6)):
                inline = self._brackets(item, indent + 4, lines=self._chance(0.4))
                text += f"{space}{head} {inline}{self._beside(0.3)}\n"
                continue
            deeper = 0 if key and isinstance(item, list) and self._chance(0.3) else self._random.choice([2, 4])
            inner = self._lines(item, indent + (deeper if key else 2))
            compact = key is None and not inner.lstrip().startswith("#") and self._chance(0.8)
            text += f"{space}- {inner[indent + 2 :]}" if compact else f"{space}{head}{self._beside(0.3)}\n{inner}"
        return text
