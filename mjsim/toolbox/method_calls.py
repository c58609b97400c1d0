"""Methods of arms and links as calls: links are structs here, and Octave asks a method of an object for one result."""

import re

from mjsim.toolbox.local_functions import bare_line

TWO_RESULTS = re.compile(
    r"(\[[^\[\]=]*[\s,][^\[\]=]*\]\s*=\s*)([A-Za-z]\w*(?:\.\w+(?:\(\))?)?)\.(ikine|ikcon|ikunc|fdyn|fkine|jtraj|rne)(\(\s*\)|\()?"
)
"""Calls of methods with several results."""
INDEX = r"(?:\([^()]*\)|\{[^{}]*\})"
OF_LINK = re.compile(
    rf"(?<![\w.])([A-Za-z]\w*(?:\.links?)?{INDEX}?)\."
    r"(?:A\(((?:(?!\bend\b)[^(),:]|\([^()]*\))+)\)|(RP|isrevolute|isprismatic)\b(?!\())(?!\s*=(?!=))"
)
"""Methods of links, with the joint's value, or without arguments."""
MADE_LINK = re.compile(r"(?<![\w.])([A-Za-z]\w*)(\{[^{}\n]*\})?\s*=\s*(\{?)\s*[lL]ink\s*\(")
"""A variable that is a link, or a cell of links."""
OF_LINKS = re.compile(r"(?<![\w.])([A-Za-z]\w*)\.links(\.[A-Za-z]\w*)(?!\w|\s*=(?!=))")
"""A field of all links of an arm."""
OF_SOME = re.compile(r"(?<=[\[{])\s*([A-Za-z]\w*)\.links(\([^()]*\)\.[A-Za-z]\w*)(?=\s*[\]}])")
"""A field of some links of an arm, between brackets."""
OLD = re.compile(r"(?m)^\s*(?:puma560|twolink)\b|\b(?:link|robot)\s*\(")
NEW = re.compile(r"\b(?:SerialLink|Link|Revolute|Prismatic|mdl_\w+|trot[xyz]|rpy2r|eul2r|t2r|r2t)\b")
POSES = re.compile(r"\btransl\s*\([^;\n]*\)\s*\*\s*rot[xyz]\b|\brot[xyz]\s*\([^;\n*]*\)\s*\*\s*transl\b")
"""A rotation multiplied with a pose, which only the old toolbox allows."""


def is_old(text: str) -> bool:
    """Return whether a script is written for the old toolbox, whose rotations rotx, roty and rotz are poses."""
    bare = "\n".join(map(bare_line, text.split("\n")))
    return bool(POSES.search(bare)) or (bool(OLD.search(bare)) and not NEW.search(bare))


def with_calls(text: str) -> str:
    """Return a script with calls in place of methods, each on its line."""
    text = TWO_RESULTS.sub(lambda at: f"{at[1]}{at[3]}({at[2]}{', ' if at[4] == '(' else ')'}", text)
    lines = [_line(line) for line in text.split("\n")]
    found = MADE_LINK.finditer("\n".join(map(bare_line, lines)))
    cells = {made[1]: bool(made[2] or made[3]) for made in found}
    if not cells:
        return "\n".join(lines)
    links = "|".join(name + (r"\{[^{}]*\}" if is_cell else "") for name, is_cell in cells.items())
    value = r"\(((?:(?!\bend\b)[^(),:]|\([^()]*\))+)\)(?!\s*=(?!=)|[.({])"
    return "\n".join(_with_values(line, re.compile(rf"(?<![\w.])({links}){value}")) for line in lines)


def _with_values(line: str, called: re.Pattern[str]) -> str:
    """Return a line with calls in place of links that are called with the value of their joint: L{2}(q), L1(0.3)."""
    for found in reversed(list(called.finditer(bare_line(line)))):
        link, value = (line[slice(*found.span(k))] for k in (1, 2))
        line = f"{line[: found.start()]}mjsim_member({link}, '()', {value}){line[found.end() :]}"
    return line


def _line(line: str) -> str:
    for found in reversed(list(OF_LINK.finditer(bare_line(line)))):
        link, value, name = (line[slice(*found.span(k))] for k in (1, 2, 3))
        call = f"mjsim_member({link}, '{name}')" if name else f"mjsim_member({link}, 'A', {value})"
        line = line[: found.start()] + call + line[found.end() :]
    for pattern in (OF_LINKS, OF_SOME):
        for found in reversed(list(pattern.finditer(bare_line(line)))):
            line = f"{line[: found.start()]}mjsim_links({found[1]}){found[2]}{line[found.end() :]}"
    return line
