"""Inspects a MATLAB or Octave file without running it: its function, arguments, and where it terminates Octave."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mjsim.sentences import Sentence

MAX_BYTES = 5_000_000
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_HEAD = re.compile(
    r"^function\b\s*(?:(?:\[(?P<many>[^\]]*)\]|(?P<one>[A-Za-z]\w*))\s*=\s*)?(?P<name>[A-Za-z][\w.]*)\s*(?:\((?P<in>[^)]*)\))?"
)
_EXIT = re.compile(r"(?<![\w.])(?:exit|quit)\b(?!\s*=[^=])")
KEYWORDS = frozenset(
    {"break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if"}
    | {"otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while"}
)


@dataclass(frozen=True, slots=True)
class FunctionFile:
    """The first function of a file."""

    file: str
    """Name of the file."""
    name: str
    """Name by which the function is called: that of the file."""
    line: int
    """Line of the first function."""
    inputs: Sequence[str]
    outputs: Sequence[str]
    exit_line: int | None
    """Line at which the file terminates Octave; None if it does not."""
    about: str = ""
    """First line of the help text."""

    @property
    def place(self) -> str:
        """Return 'file:line'."""
        return f"{self.file}:{self.line}"


def read_function(path: Path) -> FunctionFile:
    """Return the function of a file.

    Raises:
        ValueError: It contains no function, or cannot be read; the message says why.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ValueError(Sentence("'{name}' is too large to be a module", path.name))
        text = path.read_bytes().decode(errors="replace")
    except OSError as error:
        raise ValueError(Sentence("'{name}' cannot be read: {strerror}", path.name, error.strerror)) from None
    lines = code_lines(text)
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        head = _HEAD.match(_continued(lines, number).strip())
        if head is None:
            raise ValueError(
                Sentence(
                    "{name}:{number}: does not begin with a function; a script cannot be a module", path.name, number
                )
            )
        return FunctionFile(
            file=path.name,
            name=path.stem,
            line=number,
            inputs=_split(head["in"]),
            outputs=_split(head["many"] if head["many"] is not None else head["one"]),
            exit_line=next((at for at, code in enumerate(lines, start=1) if _EXIT.search(code)), None),
            about=_help(text.splitlines(), number),
        )
    raise ValueError(Sentence("{name} holds no function", path.name))


def fields_read(path: Path, argument: str) -> set[str]:
    """Return the fields of a struct that the code of a file reads.

    Args:
        path: The file, which `read_function` could read.
        argument: Name of the struct.
    """
    code = "\n".join(code_lines(path.read_bytes().decode(errors="replace")))
    return set(re.findall(rf"(?<![\w.]){re.escape(argument)}\.([A-Za-z]\w*)", code))


def code_lines(text: str) -> list[str]:
    """Return the lines of a file without comments and string contents; a continued line keeps its `...`."""
    lines, depth = [], 0
    for line in text.splitlines():
        bare = line.strip()
        if bare in ("%{", "#{"):
            depth += 1
        if depth:
            lines.append("")
            depth -= bare in ("%}", "#}")
        else:
            lines.append(_without_comment(line))
    return lines


def _without_comment(line: str) -> str:
    """Return a line without its comment, and with empty strings; a `'` after a value transposes."""
    code, quote, before = [], "", ""
    for at, sign in enumerate(line):
        if quote:
            if sign == quote:
                quote = ""
                code.append(sign)
        elif sign in "%#":
            break
        elif line.startswith("...", at):
            code.append("...")
            break
        elif sign == '"' or (sign == "'" and not (before.isalnum() or before in ("_", ")", "]", "}", ".", "'"))):
            quote = sign
            code.append(sign)
        else:
            code.append(sign)
        before = sign
    return "".join(code)


def _continued(lines: Sequence[str], number: int) -> str:
    """Return a line joined with its continuation lines."""
    whole = ""
    for line in lines[number - 1 : number + 99]:
        head, dots, _ = line.partition("...")
        whole += f"{head} "
        if not dots and whole.count("(") <= whole.count(")") and whole.count("[") <= whole.count("]"):
            break
    return whole


def _split(words: str | None) -> list[str]:
    return [word for word in re.split(r"[\s,]+", words or "") if word]


def _help(lines: Sequence[str], number: int) -> str:
    """Return the first line of the comment after a function's signature."""
    for line in lines[number : number + 5]:
        bare = line.strip()
        if bare[:1] in ("%", "#"):
            return bare.lstrip("%# ").strip()
    return ""


def is_name(text: str) -> bool:
    """Return whether a text is a valid function name."""
    return bool(_NAME.fullmatch(text)) and text not in KEYWORDS and len(text) <= 63
