"""Poses of the later toolbox, SE3 objects, as the 4 x 4 matrices that poses are here."""

import re

from mjsim.toolbox.local_functions import bare_line

MAKERS = {"Rx": "trotx", "Ry": "troty", "Rz": "trotz", "rpy": "mjsim_se3rpy", "eul": "eul2tr", "angvec": "angvec2tr"}
"""Constructors of SE3, and the functions that make these poses."""
MADE = re.compile(r"(?:^|[;,])\s*([A-Za-z]\w*)\s*=(?!=)[^;]*?\b(?:SE3\b|fkine\s*\(|ctraj\s*\()")
"""A variable that is a pose, or a row of them."""


def with_poses(text: str) -> str:
    """Return a script with matrices in place of SE3 objects, each on its line."""
    bare = [bare_line(line) for line in text.split("\n")]
    if not any("SE3" in line for line in bare) and not re.search(r"\bfkine\b", text):
        return text
    text = "\n".join(_made(line) for line in text.split("\n"))
    names = "|".join(sorted({found[1] for line in bare for found in MADE.finditer(line)}))
    if not names:
        return text
    index = r"\(((?!\s*:\s*\))[^(),:]+)\)"
    element = re.compile(rf"(?<![\w.])({names}){index}(?!\s*=(?!=))")
    part = re.compile(rf"(?<![\w.])((?:{names})(?:\(:, :, [^()]*\))?)\.(t|T|R|inv)\b(?:\(\))?(?!\s*=(?!=))")
    rows = [_replaced(line, element, r"\1(:, :, \2)") for line in text.split("\n")]
    return "\n".join(_replaced(line, part, r"mjsim_part(\1, '\2')") for line in rows)


def _made(line: str) -> str:
    for name, function in MAKERS.items():
        line = _replaced(line, re.compile(rf"\bSE3\.{name}\s*\("), f"{function}(")
    return _replaced(line, re.compile(r"\bSE3\s*\("), "mjsim_se3(")


def _replaced(line: str, pattern: re.Pattern[str], template: str) -> str:
    """Return a line with a pattern replaced outside of text and comments."""
    for found in reversed(list(pattern.finditer(bare_line(line)))):
        own = pattern.match(line, found.start())
        line = line if own is None else line[: found.start()] + own.expand(template) + line[own.end() :]
    return line
