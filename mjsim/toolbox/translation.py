"""Translates a script and the files beside it for Octave: functions replace syntax that only MATLAB has."""

import re
from collections.abc import Collection, Mapping
from dataclasses import KW_ONLY, dataclass
from pathlib import Path

from mjsim.modules import TOOLBOX
from mjsim.toolbox.handle_fields import without_fields
from mjsim.toolbox.local_functions import WORD, apart, bare_line
from mjsim.toolbox.method_calls import is_old, with_calls
from mjsim.toolbox.pose_objects import with_poses

SCRIPT = "mjsim_script"
"""Name of a script that is translated."""
OWN = "mjsim_own_"
"""Prefix of the names of translated functions: Octave would take the files of the script's folder first."""
BEYOND = re.compile(rb"[\x80-\xff]+")
"""Bytes beyond ASCII."""
TAKES_NAMES = re.compile(
    r"\b(?:feval|str2func|fdyn|ode\d+\w*|lsode|fzero|fsolve|fmin\w+|quad\w*|integral\d?|\w+fun)\s*\("
)
"""Functions that call others by their names."""
MAX_FILES = 200
"""Maximum number of files that are read."""


@dataclass(frozen=True, slots=True)
class Translation:
    """What Octave runs instead of a script."""

    run: Path
    """The file: the script itself, if nothing had to be changed."""
    _: KW_ONLY
    is_function: bool
    """Whether it is called instead of executed."""
    is_old: bool
    """Whether it is written for the old toolbox."""
    parameters: tuple[str, ...]
    """Parameters of the script, if it is a function."""


def translate(script: Path, own: Path) -> Translation:
    """Write copies of a script and the files that it uses which Octave can run, where they differ.

    Args:
        script: The script.
        own: Folder for the files, which is made.
    """
    own.mkdir()
    texts = _texts(script)
    is_function = _is_function(script, texts[script])
    _keep_methods(script.parent, own)
    plain = {file: without_fields(with_calls(with_poses(text))) for file, text in texts.items()}
    changed = {file.stem for file in texts if plain[file].encode() != file.read_bytes()}
    names = {file.stem for file in texts if file != script}
    # Callers of a changed function call it by another name, so they are changed too.
    while more := {file.stem for file, text in plain.items() if renamed(text, changed & names) != text} - changed:
        changed |= more
    for file, text in plain.items():
        text = renamed(text, changed & names)
        if file == script and not is_function:
            commands, parts = apart(text)
            if parts or file.stem in changed:
                _write(own, {SCRIPT: commands, **parts})
        elif file.stem in changed:
            _write(own, {OWN + file.stem: text})
    run = own / f"{OWN}{script.name}" if is_function else own / f"{SCRIPT}.m"
    old = any(map(is_old, texts.values()))
    head = re.match(r"\s*function\b[^\n(]*\(([^)\n]*)\)", re.sub(r"(?m)^\s*[%#].*$", "", texts[script]))
    parameters = tuple(WORD.findall(head[1])) if head else ()
    return Translation(run if run.is_file() else script, is_function=is_function, is_old=old, parameters=parameters)


def _keep_methods(folder: Path, own: Path) -> None:
    """Let arms keep their methods where a script beside the user's, or that script, has the name of one."""
    for file in folder.glob("*.m"):
        if (TOOLBOX / file.name).is_file() and not re.search(r"^\s*function\b", decoded(file.read_bytes()), re.M):
            (own / "@robot").mkdir(exist_ok=True)
            (own / "@robot" / file.name).write_bytes((TOOLBOX / file.name).read_bytes())


def renamed(text: str, names: Collection[str]) -> str:
    """Return text in which functions, and their names where these are called, have a prefix of our own."""
    names = [name for name in names if not _is_variable(name, text)]
    if not names:
        return text
    known = "|".join(sorted(map(re.escape, names)))
    name = re.compile(rf"(?<![\w.])(?:{known})\b(?!\s*=(?!=))")
    lines = []
    for line in text.split("\n"):
        bare = bare_line(line)
        for found in reversed(list(name.finditer(bare))):
            line = line[: found.start()] + OWN + line[found.start() :]
        is_called = TAKES_NAMES.search(bare)
        lines.append(re.sub(rf"(['\"])((?:{known})\1)", rf"\1{OWN}\2", line) if is_called else line)
    return "\n".join(lines)


def decoded(data: bytes) -> str:
    """Return text in UTF-8; in GB 18030 if all letters beyond ASCII are pairs of bytes, else in cp1252."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        runs = [len(run) for run in BEYOND.findall(data)]
        pairs = max(runs) > 2 and not any(length % 2 for length in runs)
        return data.decode("gb18030" if pairs else "cp1252", errors="replace")


def _is_variable(name: str, text: str) -> bool:
    """Return whether a file assigns to a name, or has a parameter of that name."""
    part = r"(?:\.\w+|\([^()\n]*\)|\{[^{}\n]*\})*"
    assigned = rf"(?<![\w.]){name}\b{part}\s*=(?!=)|\[[^\]\n]*\b{name}\b[^\]\n]*\]\s*=(?!=)"
    return bool(re.search(rf"{assigned}|\bfunction\b[^\n]*\([^)\n]*\b{name}\b", text))


def in_files_of(script: Path, own: Path, error: str) -> str:
    """Return an error with the names of the user's own files and functions."""
    place = re.compile(rf"{re.escape(str(own))}/(?:{OWN})?(\w+\.m)")
    named = place.sub(lambda at: at[1] if (script.parent / at[1]).is_file() else script.name, error)
    return named.replace(OWN, "")


def _texts(script: Path) -> dict[Path, str]:
    """Return the text of the script, and of the files beside it whose names it or one of these contains."""
    beside = {file.stem: file for file in script.parent.glob("*.m")}
    texts: dict[Path, str] = {}
    waiting = [script]
    while waiting and len(texts) < MAX_FILES:
        file = waiting.pop()
        texts[file] = decoded(file.read_bytes())
        used = [name for name in {*WORD.findall(texts[file])} & {*beside} if not _is_variable(name, texts[file])]
        waiting += [beside[name] for name in used if beside[name] not in {*texts, *waiting}]
    return texts


def _write(own: Path, texts: Mapping[str, str]) -> None:
    for name, text in texts.items():
        (own / f"{name}.m").write_text(text, encoding="utf-8", newline="")


def _is_function(script: Path, text: str) -> bool:
    """Return whether the file is a function instead of a script."""
    text = re.sub(r"(?m)^\s*[%#].*$", "", text).lstrip()
    return bool(re.match(rf"function\b[^\n]*\b{re.escape(script.stem)}\b", text))
