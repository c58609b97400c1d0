"""Reads the description of a robot as text without xacro."""

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from mjsim.errors import UsageError, printable
from mjsim.models.xacro.nodes import XacroNode, nodes_of, written
from mjsim.models.xacro.substitution import Given
from mjsim.models.xacro.xacro_expand import MAX_DEPTH, Expander, Files
from mjsim.models.xml_text import RefusedXmlError, checked_xml
from mjsim.sentences import Sentence

MAX_BYTES = 8_000_000
ROBOT_PARTS = {
    "link",
    "joint",
    "material",
    "gazebo",
    "transmission",
    "sensor",
    "ros2_control",
    "group",
    "mujoco",
    "plugin",
}
"""Elements of a robot in URDF, including extensions of other programs."""


@dataclass(frozen=True, slots=True)
class Resolved:
    """A description without xacro."""

    text: str
    asked: frozenset[str] = frozenset()
    """Names of arguments and variables that it declares or uses."""
    missing: tuple[tuple[str, str], ...] = ()
    """Place of each include that was not found, and what is missing."""


def resolved(text: str, path: Path, *, shown: Path, given: Given, files: Files) -> "Resolved":
    """Return a robot's description with all xacro elements expanded.

    The text of other files stays as it is.

    Args:
        text: Text of the file, as `parsed` returns it.
        path: Absolute path of the file.
        shown: Path for messages.
        given: Arguments and variables.
        files: Reads other files of the robot.

    Raises:
        UsageError: The file is invalid, or would do more than files of a robot may.
    """
    if "$" not in text and "xacro" not in text:
        return Resolved(text)
    expander = Expander(path, given, files)
    node = nodes_of(text, str(shown), expander.budget)
    if node.tag != "robot" or ("$" not in text and not _has_xacro(node)):
        return Resolved(text)
    made = written(expander.expanded(node))
    _refuse_bare_macros(node, expander.declared)
    if expander.missing and "<link" not in made:
        raise UsageError(printable(": ".join(expander.missing[0])))
    # Both $(find NAME) and package://NAME are a package, with or without file:// before it.
    return Resolved(made.replace("file://package://", "package://"), expander.asked, tuple(expander.missing))


def _has_xacro(node: XacroNode) -> bool:
    return node.word is not None or any(map(_has_xacro, node.elements))


def _refuse_bare_macros(root: XacroNode, declared: Collection[str]) -> None:
    """Reject macros called without `xacro:`, as in very old files: their parts of the robot would be missing.

    Raises:
        UsageError: The file contains one.
    """
    for item in root.elements:
        if item.tag in declared and item.tag not in ROBOT_PARTS:
            raise UsageError(
                Sentence(
                    "{file}:{line}:{column}: <{tag}> is a macro; to call it, write <xacro:{tag}>",
                    item.file,
                    item.line,
                    item.column,
                    item.tag,
                )
            )


def parsed(data: bytes, path: Path) -> tuple[str, ElementTree.Element]:
    """Return the text and the root element of an XML file of bounded size without entity definitions.

    Raises:
        UsageError: The file is not XML, is too large, or declares a document type.
    """
    if len(data) > MAX_BYTES:
        raise UsageError(
            Sentence(
                "{path} has {count:.0f} MB of XML; it must have at most {max_bytes} MB",
                path,
                len(data) / 1000000.0,
                MAX_BYTES // 10**6,
            )
        )
    try:
        text = checked_xml(data, deepest=MAX_DEPTH)
        return text, ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        line, column = error.position
        problem = str(error).partition(":")[0]
        raise UsageError(
            Sentence("{path}:{line}:{column}: this is not XML ({problem}); correct it", path, line, column + 1, problem)
        ) from None
    except RefusedXmlError as error:
        raise UsageError(Sentence("{path} {error}", path, error)) from None
