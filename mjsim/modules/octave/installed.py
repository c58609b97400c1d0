"""GNU Octave on this machine."""

import re
import shutil
import subprocess
from pathlib import Path

from mjsim.errors import UsageError
from mjsim.sentences import Sentence

INSTALL = "sudo apt-get install --no-install-recommends octave"
TOOLBOX = Path(__file__).parent / "toolbox"
"""Folder with functions for arms, with the names of the old robotics toolbox."""
VERSION_TIMEOUT = 20.0
"""Time limit for Octave to print its version [s]."""
_VERSION = re.compile(r"^GNU Octave, version (\S{1,40})", re.MULTILINE)


def find_octave() -> str:
    """Return the program.

    Raises:
        UsageError: It is not installed.
    """
    found = _program()
    if found is None:
        raise UsageError(Sentence("modules in .m files need GNU Octave; type: {install}", INSTALL))
    return found


def octave_found() -> str:
    """Return version and location of Octave, or how to install it if it is missing or does not start."""
    program = _program()
    if program is None:
        return f"not found; modules in .m files need it; type: {INSTALL}"
    try:
        done = subprocess.run(
            [program, "--version"], stdin=subprocess.DEVNULL, capture_output=True, timeout=VERSION_TIMEOUT, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        why = (
            f"printed nothing within {VERSION_TIMEOUT:g} s"
            if isinstance(error, subprocess.TimeoutExpired)
            else error.strerror
        )
        return f"{program} does not start: {why}; type: {INSTALL.replace('install', 'install --reinstall', 1)}"
    version = _VERSION.search(done.stdout.decode(errors="replace"))
    if version is None:
        return f"{program} is not GNU Octave, or is broken (exit code {done.returncode}); type: {INSTALL}"
    return f"{version[1]}, {program}"


def _program() -> str | None:
    return shutil.which("octave-cli") or shutil.which("octave")
