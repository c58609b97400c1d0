"""Checks of arm files: unsupported joints, and impossible masses and inertias."""

import math
import re
from xml.etree import ElementTree

from mjsim.models.inertia_repair import mend_inertias
from mjsim.models.model_sources import Element
from mjsim.models.xml_text import RefusedXmlError, checked_xml
from mjsim.sentences import Sentence

MIN_MASS = 1e-12
"""Mass given to a massless link: below rounding errors [kg]."""
UNFIT = ("breaks the triangle", "principal moment", "is no number")
"""Messages of MuJoCo about impossible inertias."""
NUMBERS = {"mass", "value", "diaginertia", "fullinertia", "pos", "quat", "ixx", "iyy", "izz", "ixy", "ixz", "iyz"}
"""Attributes of masses and inertias."""

EXPRESSED = ("xyz", "rpy", "value", "lower", "upper", "effort", "velocity", "radius", "length", "size", "scale", "ixx")
"""Attributes with numbers; files that xacro has not expanded have expressions there."""


class ArmFileError(ValueError):
    """The reason why a file is not a valid arm."""

    def __init__(self, message: str, element: str = "") -> None:
        self.element = element
        """Name of the joint or body concerned; '' for none."""
        super().__init__(message)


def check_joints(root: Element, path: str) -> None:
    """Raise ValueError for joint types that an arm cannot have."""
    for item in root.iter():
        kind = item.get("type", "")
        name = item.get("name", "")
        if item.tag == "freejoint" or (item.tag == "joint" and kind in ("free", "floating", "planar")):
            kind_text = "a free joint" if kind != "planar" else "a planar joint"
            label = f" '{name}'" if name else ""
            message = f"'{path}' has {kind_text}{label}; an arm stands on its base, remove the joint"
            raise ArmFileError(message, name or (item.tag if item.tag == "freejoint" else kind))
        if item.tag == "joint" and kind in ("ball", "spherical"):
            label = f" '{name}'" if name else ""
            raise ArmFileError(
                Sentence("'{path}' has a ball joint{label}; an arm has hinges and slides", path, label), name or kind
            )


def check_numbers(root: Element, path: str) -> None:
    """Raise ValueError for masses that are negative or not numbers, for expressions, and for duplicate joint names."""
    for item in root.iter():
        for key in EXPRESSED:
            if "${" in item.get(key, ""):
                problem = f"'{path}' has {item.get(key, '')[:40]!r} in '{key}', an expression of xacro"
                raise ArmFileError(
                    Sentence("{problem}; write the number, or expand the file with xacro", problem), item.tag
                )
    for owner in (*root.iter("link"), *root.iter("body")):
        for inertial in owner.findall("inertial"):
            name = owner.get("name", "")
            parts = [inertial, *inertial.iter("mass"), *inertial.iter("inertia")]
            for key, text in (item for part in parts for item in part.attrib.items()):
                values = [_number(word) for word in text.split()]
                low = min(values, default=0.0) if key in ("mass", "value") else 0.0
                if key in NUMBERS and not (all(map(math.isfinite, values)) and low >= 0.0):
                    called = "mass" if key == "value" else key
                    problem = f"'{path}' has an impossible body: {called} of '{name}' is {text}"
                    raise ArmFileError(Sentence("{problem}; give finite numbers, the mass not below 0", problem), name)
    names = [joint.get("name", "") for joint in root.findall("joint")]
    for name in names:
        if names.count(name) > 1:
            raise ArmFileError(
                Sentence(
                    "'{path}' has {count} joints '{name}'; give each a name of its own", path, names.count(name), name
                ),
                name,
            )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def checked_inertias(root: Element, path: str) -> list[str]:
    """Return notes on assumed masses and inertias; raise ArmFileError for an inertia that MJCF cannot have."""
    notes = mend_inertias(root, path, feather=MIN_MASS)
    for note in notes:
        if root.tag == "mujoco" and any(words in note for words in UNFIT):
            name = note.partition("'")[2].partition("'")[0]
            problem = note.partition("; made")[0].removeprefix(f"{path}: ")
            raise ArmFileError(Sentence("'{path}' has an impossible body: {problem}; correct it", path, problem), name)
    # The mass of the base follows from its shapes, and may be 0.
    return [note.removeprefix(f"{path}: ") for note in notes if "body 'base'" not in note]


def text_place(data: bytes, element: str) -> tuple[int, int]:
    """Return line and column, from 1, of a named element in a model, or of the end of valid XML."""
    try:
        text = checked_xml(data)
        ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        return error.position[0], error.position[1] + 1
    except RefusedXmlError:
        return 1, 1
    word = re.escape(element)
    patterns = (rf"<[^<>]*\bname\s*=\s*([\"']){word}\1", rf"<{word}\b", rf"<[^<>]*\btype\s*=\s*([\"']){word}\1")
    found = next(filter(None, (re.search(pattern, text) for pattern in patterns)), None) if element else None
    if found is None:
        return 1, 1
    return text.count("\n", 0, found.start()) + 1, found.start() - text.rfind("\n", 0, found.start())
