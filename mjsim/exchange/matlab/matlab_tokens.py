"""Splits a MATLAB script into statements and these into tokens; comments are dropped."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

TOKEN = re.compile(
    r"""(?P<space>(?:[ \t]|\.\.\.[^\n]*(?:\n|\Z))+)|(?P<comment>[%#][^\n]*)|(?P<end>[\n;,])
    |(?P<number>(?:\d++\.?\d*+|\.\d++)(?:[eEdD][+-]?\d++)?(?![\w]))|(?P<name>[A-Za-z]\w*)|(?P<word>\d\w*)
    |(?P<op>\.\*|\./|\.\^|\.'|==|[-+*/^()\[\]{}=:'".@<>~&|!])""",
    re.VERBOSE,
)
BLOCK_COMMENT = re.compile(r"^[ \t]*[%#]\{[ \t]*\n.*?^[ \t]*[%#]\}[ \t]*$", re.MULTILINE | re.DOTALL)
BLOCK_END = re.compile(r"^[ \t]*[%#]\}[ \t]*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Token:
    """A token and its position."""

    kind: str
    text: str
    spaced: bool
    """Whether white space precedes it."""
    line: int


def statements(text: str) -> Iterator[list[Token]]:
    """Split a script at line ends, semicolons and commas outside brackets."""
    statement: list[Token] = []
    depth = 0
    for token in _tokens(text):
        depth += (token.text in "([{" and token.kind == "op") - (token.text in ")]}" and token.kind == "op")
        if token.kind == "end" and depth <= 0:
            if statement:
                yield statement
            statement, depth = [], 0
        else:
            statement.append(token)
    if statement:
        yield statement


def _without_blocks(text: str) -> str:
    """Return text without block comments, with their line ends."""
    # Only up to the last end: otherwise each start without an end would search the whole text.
    end = max((match.end() for match in BLOCK_END.finditer(text)), default=0)
    return BLOCK_COMMENT.sub(lambda block: "\n" * block[0].count("\n"), text[:end]) + text[end:]


def _tokens(text: str) -> Iterator[Token]:
    text = _without_blocks(text.replace("\r\n", "\n"))
    place, spaced, line, before = 0, False, 1, Token("end", "\n", False, 0)
    while place < len(text):
        if text[place] in "'\"" and not (text[place] == "'" and _transposes(before, spaced)):
            kind, found, after = "text", *_quoted(text, place)
        elif match := TOKEN.match(text, place):
            kind, found, after = str(match.lastgroup), match[0], match.end()
        else:
            kind, found, after = "op", text[place], place + 1
        if kind in ("space", "comment"):
            spaced = True
        else:
            before = Token(kind, found, spaced, line)
            yield before
            spaced = False
        line += text.count("\n", place, after)
        place = after


def _transposes(before: Token, spaced: bool) -> bool:
    """Return whether a quote after a token transposes it, instead of starting text."""
    return not spaced and (before.kind in ("name", "number", "text") or before.text in (")", "]", "}", "'", ".'"))


def _quoted(text: str, place: int) -> tuple[str, int]:
    """Return text in quotes, with doubled quotes made single, and where it ends."""
    quote = text[place]
    match = re.compile(rf"{quote}((?:[^{quote}\n]|{quote}{quote})*){quote}").match(text, place)
    if match is None:
        return text[place], place + 1
    return match[1].replace(quote * 2, quote), match.end()
