"""Fields of graphics handles as calls of set and get: handles are numbers here."""

import re
from collections.abc import Mapping

from mjsim.toolbox.figure_names import FIGURE_FUNCTIONS
from mjsim.toolbox.local_functions import bare_line

MAKERS = "|".join((*FIGURE_FUNCTIONS, "gcf", "groot", "fplot", "ezplot", "fimplicit", "fsurf", "fmesh", "refline"))
MADE = re.compile(
    rf"(?:^|[;,])\s*(?:\[([\w\s,~]+)\]|(\w+)(?:\([^()=]*\)|\{{[^{{}}=]*\}})?)\s*=\s*(?:{MAKERS})\s*(?:\(|;|,|$)"
)
PARTS: Mapping[str, str] = {"XLabel": "xlabel", "YLabel": "ylabel", "ZLabel": "zlabel", "Title": "title"}
"""Texts of axes, which are handles of their own in MATLAB."""


def without_fields(text: str) -> str:
    """Return a script in which fields of handles are set and read by functions, each on its line."""
    bare = [bare_line(line) for line in text.split("\n")]
    names = {
        name for line in bare for found in MADE.finditer(line) for name in re.findall(r"\w+", found[1] or found[2])
    }
    if not names:
        return text
    handle = rf"(?<![\w.])((?:{'|'.join(sorted(names))})(?:\([^()=]*\)|\{{[^{{}}=]*\}})?)"
    written = re.compile(rf"((?:^|[;,]|\belse\b)\s*){handle}\.([A-Z]\w*)(\.String)?(\([^()]*\))?\s*=(?!=)\s*")
    read = re.compile(rf"{handle}\.([A-Z]\w*)(?![\w(.]|\s*=(?!=))")
    return "\n".join(_line(line, blank, written, read) for line, blank in zip(text.split("\n"), bare, strict=True))


def _line(line: str, bare: str, written: re.Pattern[str], read: re.Pattern[str]) -> str:
    """Return a line with calls in place of fields; bare has the same places without text and comments."""
    while found := written.search(bare):
        head, handle, name, inner, part = found.groups()
        end = _end(bare, found.end())
        value = line[found.end() : end].rstrip()
        call = f"set({handle}, '{name}', {value})"
        if inner and name in PARTS:
            call = f"{PARTS[name]}({handle}, {value})"
        elif part:
            call = f"set({handle}, '{name}', [])"
        line = line[: found.start()] + head + call + line[end:]
        bare = bare[: found.start()] + head + re.sub(r"\.[A-Z]", "__", call) + bare[end:]
    for found in reversed(list(read.finditer(bare))):
        line = f"{line[: found.start()]}get({found[1]}, '{found[2]}'){line[found.end() :]}"
    return line


def _end(bare: str, start: int) -> int:
    """Return where an expression ends: at a separator outside brackets."""
    depth = 0
    for place in range(start, len(bare)):
        depth += (bare[place] in "([{") - (bare[place] in ")]}")
        if depth == 0 and bare[place] in ";,":
            return place
    return len(bare)
