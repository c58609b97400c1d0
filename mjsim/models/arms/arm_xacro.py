"""Arms in files of xacro, expanded with the files that a world may read."""

import posixpath
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from mjsim.errors import UsageError
from mjsim.models.arms.arm_checks import ArmFileError
from mjsim.models.xacro import Given, Resolved, XacroError, parsed, resolved
from mjsim.sentences import Sentence


@dataclass(frozen=True, slots=True)
class _ReadFiles:
    """Files of an arm, by their paths in the folder of the world."""

    resolve: Callable[[str], str]
    """Returns the path for a name in the arm's file; raises ValueError if there is none."""
    contents: Callable[[str], bytes]
    """Returns the contents of a file by its path; raises ValueError if it is missing or too large."""

    def locate(self, name: str, beside: Path) -> list[Path]:
        """Return the path of a file that another one names."""
        try:
            return [Path(self.resolve(name if "://" in name else posixpath.join(beside.as_posix(), name)))]
        except ValueError:
            raise XacroError(
                Sentence("it names '{name:.200}', which was not found; put it beside the model", name)
            ) from None

    def read(self, path: Path) -> bytes:
        """Return the contents of a file."""
        try:
            return self.contents(path.as_posix())
        except ValueError as error:
            raise XacroError(Sentence("no file '{path}': {error}", path, error)) from None


def expanded(
    path: str,
    data: bytes,
    arguments: Mapping[str, str],
    *,
    resolve: Callable[[str], str],
    contents: Callable[[str], bytes],
) -> Resolved:
    """Return the description of an arm without xacro.

    Args:
        path: Its file.
        data: Contents of the file.
        arguments: Values of `xacro:arg`.
        resolve: Returns the path of a name in one of its files.
        contents: Returns a file by its path.

    Raises:
        ArmFileError: xacro cannot be expanded, or does not use an argument.
    """
    place = Path(path)
    try:
        written, _ = parsed(data, place)
        files = _ReadFiles(resolve, contents)
        found = resolved(written, place, shown=place, given=Given(arguments), files=files)
    except UsageError as error:
        raise ArmFileError(str(error)) from None
    unused = sorted(arguments.keys() - found.asked)
    if unused:
        known = ", ".join(sorted(found.asked)) or "none"
        raise ArmFileError(
            Sentence(
                "'{path}' has no xacro:arg '{unused:.60}'; those that it uses are {known:.300}", path, unused[0], known
            )
        )
    return found
