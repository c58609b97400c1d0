"""Separates the functions that a script defines: Octave needs them before the first call, MATLAB at the end."""

import re

QUOTED = re.compile(r"(?<![\w)\]}.'])'(?:[^'\n]|'')*'|\"(?:[^\"\\\n]|\\.|\"\")*\"")
COMMENT = re.compile(r"[%#].*")
BRACKETS = re.compile(r"[(\[{][^()\[\]{}]*[)\]}]")
OPENS = frozenset(["function", "if", "for", "parfor", "while", "switch", "try", "unwind_protect", "do", "classdef"])
CLOSES = re.compile(r"end(?:function|if|for|parfor|while|switch|_try_catch|_unwind_protect)?|until")
HEAD = re.compile(r"\s*function\b\s*(?:[^=(\n]*=\s*)?([A-Za-z]\w*)")
WORD = re.compile(r"(?<![\w.])[A-Za-z]\w*")


def apart(text: str) -> tuple[str, dict[str, str]]:
    """Return a script's own commands, and its functions by name, each on the lines where the script has it."""
    own: list[str] = []
    functions: dict[str, list[str]] = {}
    depth, name, block = 0, "", 0
    for number, line in enumerate(text.split("\n")):
        block += _block_step(line)
        words = [] if block else _keywords(line)
        if depth == 0 and words[:1] == ["function"] and (head := HEAD.match(line)):
            name = head[1]
            functions[name] = [""] * number
        if name:
            functions[name].append(line)
        own.append("" if name else line)
        depth += sum(1 if word in OPENS else -1 for word in words)
        name = name if depth > 0 else ""
    # Without an end of each function it is unknown where the commands continue.
    return ("\n".join(own), {key: "\n".join(lines) for key, lines in functions.items()}) if not depth else (text, {})


def bare_line(line: str) -> str:
    """Return a line with its strings blanked in place, without its comment."""
    return COMMENT.sub("", QUOTED.sub(lambda found: "'" * len(found[0]), line))


def _block_step(line: str) -> int:
    """Return how many block comments a line opens, or closes."""
    return {"%{": 1, "#{": 1, "%}": -1, "#}": -1}.get(line.strip(), 0)


def _keywords(line: str) -> list[str]:
    """Return the words of a line that open or close a block."""
    bare, before = COMMENT.sub("", QUOTED.sub("''", line)), ""
    while bare != before:
        before, bare = bare, BRACKETS.sub("", bare)
    return [word for word in WORD.findall(bare) if word in OPENS or CLOSES.fullmatch(word)]
